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

#include "cumulative_table.h"
#include "entropy.h"
#include "lanes.h"

namespace tsc {

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
    const AveragedTables average(*chosen.first, *chosen.second);
    writer.put(average.below(symbol), average.below(symbol + 1) - average.below(symbol));
    update(chosen, symbol);
  }

  std::uint32_t get(EntropyReader& reader, const Context& context) {
    const Chosen chosen = choose(context);
    const AveragedTables average(*chosen.first, *chosen.second);
    const std::uint32_t symbol = average.find(reader.peek());
    const std::uint32_t start = average.below(symbol);
    reader.advance(start, average.below(symbol + 1) - start);
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
  static constexpr TableRates kRates = [] {
    TableRates rates{};
    for (std::size_t age = 0; age < rates.size(); ++age) {
      rates[age] = 3 + (age >= 70) + (age >= 104) + (age >= 124) + (age >= 127);
    }
    return rates;
  }();

  struct Chosen {
    CumulativeTable* parent;
    CumulativeTable* first;
    CumulativeTable* second;
  };

  Chosen choose(const Context& context) {
    CumulativeTable* const parent = &tables_[context.parent];
    CumulativeTable* const first = &tables_[kParentCount + 2 * hash(context.first)];
    CumulativeTable* const second = &tables_[kParentCount + 2 * hash(context.second) + 1];
    if (parent->lanes[0] == 0) [[unlikely]]
      *parent = prior_;
    for (CumulativeTable* table : {first, second}) {
      if (table->lanes[0] != 0) [[likely]]
        continue;
      *table = *parent;
      table->lanes[0] = kCopyAge;
    }
    return {parent, first, second};
  }

  std::size_t hash(std::uint32_t context) const { return (context * 0x9e3779b1u) >> hash_shift_; }

  static void update(const Chosen& chosen, std::uint32_t symbol) {
    for (CumulativeTable* table : {chosen.parent, chosen.first, chosen.second}) {
      table->update(symbol, kRates);
    }
  }

  CumulativeTable prior_;
  int hash_shift_;                       ///< the highest bits of a hash number the tables
  std::vector<CumulativeTable> tables_;  ///< parents; then first and second ones by turns
};

}  // namespace tsc
