// How large the residual of each component is expected to be: bin width and choice of tables (BITSTREAM.md, section
// 6.6).
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "lanes.h"

namespace tsc {

inline constexpr int kScaleClasses = 32;
inline constexpr int kShiftClasses = 13;
inline constexpr int kRatioClasses = 15;
inline constexpr int kCountClasses = 3;     // 1, 2, 3 complete parallelograms
inline constexpr int kMaxMagnitude = 5461;  // stored magnitudes saturate here, so that six fit 16 bits
inline constexpr int kMaxSpread = 1 << 20;

/// What the contexts of a vertex are made of; lanes are components.
struct Neighbourhood {
  Integers magnitude;  ///< sum over six neighbours' residuals, in steps
  Integers spread;  ///< how far candidates lie from the predicted point, or the gate's extents, in 1/128 steps, at most
                    ///< kMaxSpread
  int count_class = 0;
};

/// Contexts of the three components.
struct ResidualContexts {
  Integers shifts;                              ///< a bin spans 2^shift steps
  std::array<std::int16_t, 8> scale_and_shift;  ///< half octaves of the expected magnitude; the same shifts
  std::array<std::int16_t, 8> spread_ratio;     ///< spread against the neighbours' residuals, and the count class

  int scale(int a) const { return scale_and_shift[static_cast<std::size_t>(a)]; }
  int shift(int a) const { return scale_and_shift[static_cast<std::size_t>(a) + 4]; }
  int ratio(int a) const { return spread_ratio[static_cast<std::size_t>(a)]; }
};

TSC_ALWAYS_INLINE ResidualContexts residualContexts(const Neighbourhood& around) {
  constexpr int kOctave = 1 << 23;
  const Integers own = around.magnitude;
  const Integers total = splatInteger(own[0] + own[1] + own[2]);
  const Integers spread = around.spread;
  // In 1/800 steps, below 2^24.
  const Integers expected = (own << 7) + (own << 6) + (total << 4) + spread + (spread << 1) + 256;
  const Integers size = logarithms(expected);
  const Integers mean = logarithms((own << 4) + total + 16);
  const Integers scale = (size - 8 * kOctave) >> 22;
  const Integers wide_shift = (size - 11 * kOctave - kOctave / 5) >> 23;
  const Integers ratio = (logarithms(spread + 1) - mean + 3 * kOctave) >> 23;
  // Below 2^24 there are no more than kShiftClasses.
  const Integers shift = wide_shift & (Integers)(wide_shift > 0);
  constexpr Lanes kLast = {kScaleClasses - 1, kScaleClasses - 1, kScaleClasses - 1, 0,
                           kShiftClasses - 1, kShiftClasses - 1, kShiftClasses - 1, 0};
  const Lanes ratios = atMost(atLeast(packed(ratio, ratio), Lanes{}), splat(4));
  ResidualContexts contexts;
  contexts.shifts = shift;
  storeLanes(contexts.scale_and_shift.data(), atMost(atLeast(packed(scale, shift), Lanes{}), kLast));
  storeLanes(contexts.spread_ratio.data(), ratios + static_cast<std::int16_t>(5 * around.count_class));
  return contexts;
}

}  // namespace tsc
