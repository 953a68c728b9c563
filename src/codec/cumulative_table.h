// Adaptive distributions over 16 symbols in two registers, which the connectivity and the residuals learn
// (BITSTREAM.md, section 4.4).
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "entropy.h"
#include "lanes.h"

namespace tsc {

/// By a table's age / 2^8: updates go 2^-rate of the way.
using TableRates = std::array<std::int32_t, 128>;

/// Lane s > 0: cumulative frequency below symbol s, times 2^-15. Lane 0: the table's age, which grows with each update
/// towards 2^15 - 1. Every symbol has a frequency of at least 1.
struct alignas(32) CumulativeTable {
  std::int16_t lanes[16] = {};

  Lanes low() const { return loadLanes(std::assume_aligned<16>(lanes)); }
  Lanes high() const { return loadLanes(std::assume_aligned<16>(lanes + 8)); }

  /// Cumulative frequency below `symbol`, 0..16.
  TSC_ALWAYS_INLINE std::uint32_t below(std::uint32_t symbol) const {
    if (symbol == 0) return 0;
    return symbol == 16 ? kProbabilityOne : static_cast<std::uint16_t>(lanes[symbol]);
  }

  /// The same where it is known to be 1..15.
  TSC_ALWAYS_INLINE std::uint32_t belowInner(std::uint32_t symbol) const {
    return static_cast<std::uint16_t>(lanes[symbol]);
  }

  /// The symbol that owns `slot`.
  TSC_ALWAYS_INLINE std::uint32_t find(std::uint32_t slot) const {
    return firstAbove(low(), high(), static_cast<std::int16_t>(slot)) - 1;
  }

  TSC_ALWAYS_INLINE void update(std::uint32_t symbol, const TableRates& rates);
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

/// Moves each lane by 2^-rate of its way to the symbol's target. Two neighbouring lanes at distance d >= 1 whose
/// targets are at distance e >= 1 end at distance >= d + floor((e - d) / 2^rate) >= 1, so no frequency reaches 0.
inline void CumulativeTable::update(std::uint32_t symbol, const TableRates& rates) {
  const CumulativeTable& target = kTableTargets[symbol];
  const std::int32_t rate = rates[static_cast<std::uint16_t>(lanes[0]) >> 8];
  const Lanes a = low();
  const Lanes b = high();
  storeLanes(lanes, a + shiftedDown(target.low() - a, rate));
  storeLanes(lanes + 8, b + shiftedDown(target.high() - b, rate));
}

/// The average of two tables. Its frequencies stay positive: two neighbouring lanes differ by at least 1 in both
/// tables, so their sums do by 2.
class AveragedTables {
 public:
  TSC_ALWAYS_INLINE AveragedTables(const CumulativeTable& a, const CumulativeTable& b)
      : low_(halfSum(a.low(), b.low())), high_(halfSum(a.high(), b.high())) {
    storeLanes(lanes_, low_);
    storeLanes(lanes_ + 8, high_);
  }

  TSC_ALWAYS_INLINE std::uint32_t below(std::uint32_t symbol) const {
    if (symbol == 0) return 0;
    return symbol == 16 ? kProbabilityOne : static_cast<std::uint16_t>(lanes_[symbol]);
  }
  TSC_ALWAYS_INLINE std::uint32_t belowInner(std::uint32_t symbol) const {
    return static_cast<std::uint16_t>(lanes_[symbol]);
  }

  TSC_ALWAYS_INLINE std::uint32_t find(std::uint32_t slot) const {
    return firstAbove(low_, high_, static_cast<std::int16_t>(slot)) - 1;
  }

 private:
  static Lanes halfSum(Lanes a, Lanes b) { return (Lanes)(((UnsignedLanes)a + (UnsignedLanes)b) >> 1); }

  Lanes low_, high_;
  alignas(16) std::int16_t lanes_[16];
};

}  // namespace tsc
