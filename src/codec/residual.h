// One residual component by adaptive tables (BITSTREAM.md, section 6.6).
//
// A residual is coarsened to bins of 2^shift steps. A table holds the distribution over a window of 16 bins around the
// prediction; the window's outer bins stand for all that lies beyond.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "cumulative_table.h"

namespace tsc {

inline constexpr int kWindowBins = 16;
inline constexpr int kWindowCentre = kWindowBins / 2;

/// Tables move 2^-rate of the way; the rate by the table's age / 2^8. After 4, 12 and 40 updates it grows.
inline constexpr TableRates kResidualRates = [] {
  TableRates rates{};
  for (std::size_t age = 0; age < rates.size(); ++age) rates[age] = 3 + (age >= 52) + (age >= 83) + (age >= 109);
  return rates;
}();

/// A window before anything is known: a two-sided geometric distribution around the centre, ratio `decay` / 64 a bin,
/// over a floor of 1/256.
constexpr CumulativeTable firstWindow(int decay) {
  std::array<int, kWindowBins> weight{};
  int sum = 0;
  for (std::size_t i = 0; i < kWindowBins; ++i) {
    int w = 1 << 14;
    for (int d = std::max(static_cast<int>(i) - kWindowCentre, kWindowCentre - static_cast<int>(i)); d > 0; --d) {
      w = w * decay / 64;
    }
    weight[i] = w + (1 << 6);
    sum += weight[i];
  }
  CumulativeTable table;
  std::int64_t part = 0;
  for (std::size_t i = 1; i < kWindowBins; ++i) {
    part += weight[i - 1];
    table.lanes[i] = static_cast<std::int16_t>(part * (kProbabilityOne - kWindowBins) / sum + static_cast<int>(i));
  }
  return table;
}

}  // namespace tsc
