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
inline constexpr int kRatioClasses = 16;  // 5 for each count class; the last is not used
/// 2^23 log2 of the least that is of the second scale, less a half octave; bins are as wide as a step up to this scale.
inline constexpr int kFirstScale = 9 << 22;
inline constexpr int kFirstWideScale = 6;
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
  std::array<std::int16_t, 8> tables;  ///< kRatioClasses * scale + ratio
  std::array<std::int16_t, 8> shifts;  ///< a bin spans 2^shift steps

  int table(int a) const { return tables[static_cast<std::size_t>(a)]; }
  int scale(int a) const { return table(a) / kRatioClasses; }
  int shift(int a) const { return shifts[static_cast<std::size_t>(a)]; }
  Integers wideShifts() const { return widened(shifts.data()); }
};

TSC_ALWAYS_INLINE ResidualContexts residualContexts(const Neighbourhood& around) {
  constexpr int kOctave = 1 << 23;
  const Integers own = around.magnitude;
  const Integers total =
      own + __builtin_shufflevector(own, own, 1, 2, 0, 3) + __builtin_shufflevector(own, own, 2, 0, 1, 3);
  // In 1/114 steps, below 2^21.
  const Integers mean = (own << 4) + total + 16;
  const Integers size = logarithms(mean + (around.spread >> 2));
  const Integers scale = (size - kFirstScale) >> 22;
  const Integers ratio = (logarithms(around.spread + 1) - logarithms(mean) + 3 * kOctave) >> 23;
  constexpr Lanes kLast = {kScaleClasses - 1, kScaleClasses - 1, kScaleClasses - 1, 0, 4, 4, 4, 0};
  const Lanes classes = atMost(atLeast(packed(scale, ratio), Lanes{}), kLast);
  constexpr Lanes kSizes = {kRatioClasses, kRatioClasses, kRatioClasses, 0, 1, 1, 1, 0};
  const Integers parts = (Integers)(classes * kSizes);
  ResidualContexts contexts;
  storeLanes(contexts.tables.data(), (Lanes)parts + (Lanes)__builtin_shufflevector(parts, parts, 2, 3, 0, 1) +
                                         static_cast<std::int16_t>(5 * around.count_class));
  storeLanes(contexts.shifts.data(), atLeast(classes - kFirstWideScale, Lanes{}) >> 1);
  return contexts;
}

}  // namespace tsc
