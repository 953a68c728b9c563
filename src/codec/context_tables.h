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
#include <vector>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "entropy.h"

namespace tsc {

/// Lane s > 0: cumulative frequency below symbol s, times 2^-15. Lane 0: updates so far, capped; 0 in a fresh table.
using CumulativeLanes [[gnu::vector_size(32)]] = std::int16_t;

/// Lanes towards which a table moves when `symbol` is coded: every symbol has frequency 1 and `symbol` the rest.
struct alignas(32) LaneTargets {
  std::int16_t lanes[16][16];
};
inline constexpr LaneTargets kLaneTargets = [] {
  LaneTargets targets{};
  for (int symbol = 0; symbol < 16; ++symbol) {
    for (int s = 1; s < 16; ++s) {
      targets.lanes[symbol][s] =
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
      : table_bits_(std::clamp(static_cast<int>(std::bit_width(symbol_count)), kMinTableBits, kMaxTableBits)),
        tables_(kParentCount + (std::size_t{2} << table_bits_)) {
    for (int s = 0; s < 16; ++s) prior_[s] = prior[s];
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
  static constexpr int kMaxTableBits = 13;
  // A table counts its updates, up to kCountCap; a prior and a copy start at the counts below. The first updates go
  // 2^-3 of the way, later ones 2^-4 .. 2^-7.
  static constexpr int kPriorCount = 4;
  static constexpr int kCopyCount = 1;
  static constexpr int kCountCap = 250;
  static constexpr auto kRates = [] {
    std::array<std::uint8_t, kCountCap + 1> rates{};
    for (int count = 0; count <= kCountCap; ++count) {
      rates[static_cast<std::size_t>(count)] =
          static_cast<std::uint8_t>(3 + (count >= 6) + (count >= 20) + (count >= 80) + (count >= 250));
    }
    return rates;
  }();

  struct alignas(32) Table {
    CumulativeLanes lanes;
  };

  struct Chosen {
    Table* parent;
    Table* first;
    Table* second;
  };

  /// Frequencies stay positive: two neighbouring lanes differ by at least 1 in both tables, so their sums do by 2.
  struct Average {
    using Unsigned [[gnu::vector_size(32)]] = std::uint16_t;

    Average(const Table& a, const Table& b) {
      constexpr Unsigned kAllButCount = {0,      0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff,
                                         0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff};
      lanes = (((Unsigned)a.lanes + (Unsigned)b.lanes) >> 1) & kAllButCount;
      __builtin_memcpy(below, &lanes, sizeof(lanes));
      below[16] = kProbabilityOne;
    }

    std::uint32_t find(std::uint32_t slot) const {
#if defined(__SSE2__)
      // All values are below 2^15, so signed comparison is right.
      const __m128i wanted = _mm_set1_epi16(static_cast<short>(slot));
      const __m128i* halves = reinterpret_cast<const __m128i*>(&lanes);
      const __m128i above = _mm_packs_epi16(_mm_cmpgt_epi16(halves[0], wanted), _mm_cmpgt_epi16(halves[1], wanted));
      const auto mask = static_cast<std::uint32_t>(_mm_movemask_epi8(above)) | 0x10000;
      return static_cast<std::uint32_t>(std::countr_zero(mask)) - 1;
#else
      std::uint32_t symbol = 0;
      for (int s = 1; s < 16; ++s) symbol += lanes[s] <= slot;
      return symbol;
#endif
    }

    Unsigned lanes;
    alignas(32) std::uint16_t below[17];
  };

  Chosen choose(const Context& context) {
    Table* const parent = &tables_[context.parent];
    Table* const first = &tables_[kParentCount + hash(context.first)];
    Table* const second = &tables_[kParentCount + (std::size_t{1} << table_bits_) + hash(context.second)];
    if (parent->lanes[0] == 0) [[unlikely]] {
      parent->lanes = prior_;
      parent->lanes[0] = kPriorCount;
    }
    for (Table* table : {first, second}) {
      if (table->lanes[0] != 0) continue;
      table->lanes = parent->lanes;
      table->lanes[0] = kCopyCount;
    }
    return {parent, first, second};
  }

  std::uint32_t hash(std::uint32_t context) const { return (context * 0x9e3779b1u) >> (32 - table_bits_); }

  /// Moves each lane by 2^-rate of its way. Two neighbouring lanes at distance d >= 1 whose targets are at distance
  /// e >= 1 end at distance >= d + floor((e - d) / 2^rate) >= 1, so no frequency reaches 0.
  static void updateTable(Table& table, std::uint32_t symbol) {
    const int count = table.lanes[0];
    const std::int16_t rate = kRates[static_cast<std::size_t>(count)];
    CumulativeLanes lanes;
    __builtin_memcpy(&lanes, kLaneTargets.lanes[symbol], sizeof(lanes));
    lanes = table.lanes + ((lanes - table.lanes) >> rate);
    lanes[0] = static_cast<std::int16_t>(std::min(count + 1, kCountCap));
    table.lanes = lanes;
  }

  static void update(const Chosen& chosen, std::uint32_t symbol) {
    updateTable(*chosen.parent, symbol);
    updateTable(*chosen.first, symbol);
    updateTable(*chosen.second, symbol);
  }

  CumulativeLanes prior_ = {};
  int table_bits_;
  std::vector<Table> tables_;
};

}  // namespace tsc
