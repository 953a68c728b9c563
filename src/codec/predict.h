// Predictors: pure functions from known positions to a point (BITSTREAM.md, section 6.3).
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "frame.h"
#include "stencil.h"

namespace tsc {

/// Paper, eq. 1.
inline Integers parallelogram(Integers left, Integers right, Integers base) { return left + right - base; }

/// Mean of `count` candidates, 1..kMaxStencils, rounded; of three, the first counts as much as the others together.
/// Beyond `count`, candidates are the first again.
TSC_ALWAYS_INLINE Integers average(const std::array<Integers, kMaxStencils>& candidates, int count) {
  constexpr std::array<Integers, kMaxStencils + 1> kRound = {Integers{}, Integers{}, Integers{1, 1, 1, 1},
                                                             Integers{2, 2, 2, 2}};
  const Integers spread = (candidates[1] - candidates[0]) + (candidates[2] - candidates[0]);
  return candidates[0] + ((spread + kRound[static_cast<std::size_t>(count)]) >> (count - 1));
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
struct AngleContext {
  const CodingOrder& order;
  std::span<const VertexState> states;
};
/// For the vertex coded at `time`, which stands first in the stencil's `face`, as in Stencils.
ExpectedAngles expectedAngles(const AngleContext& context, std::uint32_t time, std::uint32_t face, std::int32_t valence,
                              bool use_known_angles);

/// Eq. 2 with the weights of eq. 3 and 4. The parallelogram where the angles give no usable triangle. Of vertices that
/// a hostile stream has put far apart it can be beyond 32 bits.
WideVec3 weightedParallelogram(const Vec3& left, const Vec3& right, const Vec3& base, ExpectedAngles expected);

}  // namespace tsc
