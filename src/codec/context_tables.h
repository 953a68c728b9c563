// Sixteen-symbol models chosen by context, for the connectivity (BITSTREAM.md, section 5.3).
//
// The distribution of a symbol is the average of two adaptive cumulative tables, each chosen by a hash of its own
// context. A table met for the first time starts as a copy of its parent's, which a coarse context chooses. A table
// that was never used is all zeros, so tables need no initialisation beyond cleared memory; their number follows the
// size of the mesh. Two contexts with the same hash share a table.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "entropy.h"
#include "lanes.h"

namespace tsc {

/// Lane s > 0: cumulative frequency below symbol s, times 2^-15. Lane 0: the table's age, which grows with each update
/// from 1 or more towards 2^15 - 1; 0 in a fresh table.
struct alignas(32) CumulativeTable {
  std::int16_t lanes[16] = {};

  Lanes low() const { return loadLanes(std::assume_aligned<16>(lanes)); }
  Lanes high() const { return loadLanes(std::assume_aligned<16>(lanes + 8)); }
};

/// Where a table moves when `symbol` is coded: every symbol has frequency 1 and `symbol` the rest.
inline constexpr std::array<CumulativeTable, 16> kTableTargets = [] {
  std::array<CumulativeTable, 16> targets{};
  for (int symbol = 0; symbol < 16; ++symbol) {
    targets[symbol].lanes[0] = 32767;
    for (int s = 1; s < 16; ++s) {
      targets[symbol].lanes[s] =
          static_cast<std::int16_t>(s + (s > symbol ? static_cast<int>(kProbabilityOne) - 16 : 0));
    }
  }
  return targets;
}();

class AveragedModel {
 public:
  struct Context {
    std::uint32_t parent;  ///< below kParentCount
    std::uint32_t first;   ///< any 32 bits, to be hashed
    std::uint32_t second;
  };
  static constexpr std::uint32_t kParentCount = 256;

  /// `prior` is the distribution before anything is known: cumulative frequencies below each symbol, `prior[0]` = 0.
  /// Tables for about `symbol_count` symbols.
  AveragedModel(const std::array<std::int16_t, 16>& prior, std::uint32_t symbol_count)
      : hash_shift_(32 - std::clamp(static_cast<int>(std::bit_width(symbol_count)), kMinTableBits, kMaxTableBits)),
        tables_(kParentCount + (std::size_t{2} << (32 - hash_shift_))) {
    std::copy(prior.begin(), prior.end(), prior_.lanes);
    prior_.lanes[0] = kPriorAge;
  }

  void put(EntropyWriter& writer, const Context& context, std::uint32_t symbol) {
    const Chosen chosen = choose(context);
    const Average average(*chosen.first, *chosen.second);
    writer.put(average.below[symbol], average.below[symbol + 1] - average.below[symbol]);
    update(chosen, symbol);
  }

  std::uint32_t get(EntropyReader& reader, const Context& context) {
    const Chosen chosen = choose(context);
    const Average average(*chosen.first, *chosen.second);
    const std::uint32_t symbol = average.find(reader.peek());
    const std::uint32_t start = average.below[symbol];
    reader.advance(start, average.below[symbol + 1] - start);
    update(chosen, symbol);
    return symbol;
  }

 private:
  static constexpr int kMinTableBits = 6;
  static constexpr int kMaxTableBits = 12;
  /// Ages at which a prior and a copy start.
  static constexpr std::int16_t kPriorAge = 13000;
  static constexpr std::int16_t kCopyAge = 4096;
  /// Updates go 2^-rate of the way; the rate by the table's age / 2^8. After about 6, 20, 80 and 250 updates it grows.
  static constexpr std::array<std::uint8_t, 128> kRates = [] {
    std::array<std::uint8_t, 128> rates{};
    for (int age = 0; age < 128; ++age) {
      rates[static_cast<std::size_t>(age)] =
          static_cast<std::uint8_t>(3 + (age >= 70) + (age >= 104) + (age >= 124) + (age >= 127));
    }
    return rates;
  }();

  struct Chosen {
    CumulativeTable* parent;
    CumulativeTable* first;
    CumulativeTable* second;
  };

  /// Frequencies stay positive: two neighbouring lanes differ by at least 1 in both tables, so their sums do by 2.
  struct Average {
    Average(const CumulativeTable& a, const CumulativeTable& b) {
      constexpr Lanes kAllButAge = {0, -1, -1, -1, -1, -1, -1, -1};
      low = halfSum(a.low(), b.low()) & kAllButAge;
      high = halfSum(a.high(), b.high());
      std::memcpy(below, &low, sizeof low);
      std::memcpy(below + 8, &high, sizeof high);
      below[16] = kProbabilityOne;
    }

    std::uint32_t find(std::uint32_t slot) const {
      return static_cast<std::uint32_t>(countNotAbove(low, high, static_cast<std::int16_t>(slot))) - 1;
    }

    static Lanes halfSum(Lanes a, Lanes b) { return (Lanes)(((UnsignedLanes)a + (UnsignedLanes)b) >> 1); }

    Lanes low, high;
    alignas(32) std::uint16_t below[17];
  };

  Chosen choose(const Context& context) {
    CumulativeTable* const parent = &tables_[context.parent];
    CumulativeTable* const first = &tables_[kParentCount + 2 * hash(context.first)];
    CumulativeTable* const second = &tables_[kParentCount + 2 * hash(context.second) + 1];
    if (parent->lanes[0] == 0) [[unlikely]] *parent = prior_;
    for (CumulativeTable* table : {first, second}) {
      if (table->lanes[0] != 0) [[likely]] continue;
      *table = *parent;
      table->lanes[0] = kCopyAge;
    }
    return {parent, first, second};
  }

  std::size_t hash(std::uint32_t context) const { return (context * 0x9e3779b1u) >> hash_shift_; }

  /// Moves each lane by 2^-rate of its way. Two neighbouring lanes at distance d >= 1 whose targets are at distance
  /// e >= 1 end at distance >= d + floor((e - d) / 2^rate) >= 1, so no frequency reaches 0.
  static void updateTable(CumulativeTable& table, Lanes low_target, Lanes high_target) {
    const int rate = kRates[static_cast<std::size_t>(table.lanes[0] >> 8)];
    const Lanes low = table.low();
    const Lanes high = table.high();
    storeLanes(table.lanes, low + shiftRight(low_target - low, rate));
    storeLanes(table.lanes + 8, high + shiftRight(high_target - high, rate));
  }

  static void update(const Chosen& chosen, std::uint32_t symbol) {
    const Lanes low = kTableTargets[symbol].low();
    const Lanes high = kTableTargets[symbol].high();
    for (CumulativeTable* table : {chosen.parent, chosen.first, chosen.second}) updateTable(*table, low, high);
  }

  static Lanes shiftRight(Lanes lanes, int count) { return lanes >> static_cast<std::int16_t>(count); }

  CumulativeTable prior_;
  int hash_shift_;  ///< the highest bits of a hash number the tables
  std::vector<CumulativeTable> tables_;  ///< parents; then first and second ones by turns
};

}  // namespace tsc
