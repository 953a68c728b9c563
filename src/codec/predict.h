// Predictors: pure functions from known positions to a point (BITSTREAM.md, section 6.3).
#pragma once

#include <algorithm>
#include <array>

#include "frame.h"
#include "stencil.h"

namespace tsc {

/// Paper, eq. 1.
inline Vec3 parallelogram(const Vec3& left, const Vec3& right, const Vec3& base) { return left + right - base; }

/// Mean of `count` candidates, rounded; exactly their value where all agree.
inline Vec3 average(const Vec3* candidates, int count) {
  static constexpr std::array<std::int64_t, kMaxStencils + 1> kReciprocal = {0, 262144, 131072, 87381,
                                                                             65536};  // 2^18 / n
  WideVec3 sum(0);
  for (int j = 1; j < count; ++j) sum += WideVec3(candidates[j] - candidates[0]);
  const WideVec3 mean = sum * kReciprocal[count] + (std::int64_t{1} << 17);
  return candidates[0] + Vec3(mean.x >> 18, mean.y >> 18, mean.z >> 18);
}

// --- Weighted parallelogram (paper, eq. 2-4) ---
//
// Angles are in units of pi / 2^15. They only steer the prediction, so coarse rational approximations do; that they are
// the same everywhere is what counts.

inline constexpr std::int64_t kHalfTurn = 1 << 15;
inline constexpr std::int64_t kCotangentOne = 1 << 12;
inline constexpr std::int64_t kCotangentLimit = 64 * kCotangentOne;

struct Angle {
  std::int64_t value = 0;      ///< units of pi / 2^15, in [0, 2^15]
  std::int64_t cotangent = 0;  ///< units of 2^-12, clamped to +-64
};

/// The inner angle at `tip` between the directions to `a` and `b`. 0 on a degenerate triangle.
Angle innerAngle(const Vec3& tip, const Vec3& a, const Vec3& b);

/// Cotangent, in units of 2^-12 and clamped, of an angle.
std::int64_t cotangentOf(std::int64_t angle);

/// The inner angles expected in the new triangle, by valence alone or from what the known triangles around the gate
/// leave over.
struct ExpectedAngles {
  std::int64_t left;
  std::int64_t right;
  std::int64_t tip;
};
ExpectedAngles expectedAngles(const Surface& surface, const std::vector<VertexState>& states,
                              const std::vector<std::uint8_t>& known, int tip_valence, const Stencil& stencil,
                              bool use_known_angles);

/// Eq. 2 with the weights of eq. 3 and 4. The parallelogram where the angles give no usable triangle.
Vec3 weightedParallelogram(const Vec3& left, const Vec3& right, const Vec3& base, ExpectedAngles expected);

}  // namespace tsc
