// A correction of the average prediction that learns on the way (BITSTREAM.md, section 6.5).
//
// For each component of the local frame, the correction is a weighted sum of features that both sides know: how far the
// neighbours were from their own predictions, how the candidates disagree, the shape of the base triangle, and
// valences. The weights move by a fixed step in the direction that would have made the last error smaller (sign-sign
// LMS).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "frame.h"
#include "lanes.h"

namespace tsc {

inline constexpr int kFeatureBits = 12;  // the largest component of all vectors is scaled to this many bits
inline constexpr int kWeightBits = 15;
inline constexpr int kWeightStepBits = 6;
inline constexpr int kFactorOne = 4;  // factors count quarters
inline constexpr int kFactorLimit = 12;

/// The vectors around a vertex that features are made of, on the fine lattice.
struct Surrounding {
  Integers left_surprise, right_surprise, base_surprise;
  Integers first, second;  ///< candidates, from the predicted point
  Integers height;         ///< from the base vertex to the middle of the gate
  Integers gate;           ///< from its right end to its left one
};

/// These vectors in the frame, scaled by 2^scale, and by 2^-3 beside.
struct LocalSurrounding {
  // Lanes: left, right, base surprise, first, height, gate, nothing, second.
  Lanes component[3];
  int scale = 0;

  /// The displacements of the candidates on the fine lattice again.
  std::array<Integers, 2> candidates() const {
    const auto [a, b, c] = component;
    const Lanes low = __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11);
    const Lanes high = __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
    const Lanes low_rest = __builtin_shufflevector(c, c, 0, 8, 1, 9, 2, 10, 3, 11);
    const Lanes high_rest = __builtin_shufflevector(c, c, 4, 12, 5, 13, 6, 14, 7, 15);
    // a b c c of the last lane of each half, in the high half of the register.
    const Lanes first = (Lanes)__builtin_shufflevector((Integers)low, (Integers)low_rest, 2, 6, 3, 7);
    const Lanes second = (Lanes)__builtin_shufflevector((Integers)high, (Integers)high_rest, 2, 6, 3, 7);
    return {scaled(widenedHigh(first), 3 - scale), scaled(widenedHigh(second), 3 - scale)};
  }
};

/// `local`: whether the frame is another than the coordinate axes.
TSC_ALWAYS_INLINE LocalSurrounding toLocal(const Frame& frame, bool local, const Surrounding& s) {
  // Two transpositions: lanes become the vectors.
  const Integers a = __builtin_shufflevector(s.left_surprise, s.right_surprise, 0, 4, 1, 5);
  const Integers b = __builtin_shufflevector(s.base_surprise, s.first, 0, 4, 1, 5);
  const Integers c = __builtin_shufflevector(s.height, s.gate, 0, 4, 1, 5);
  const Integers d = __builtin_shufflevector(Integers{}, s.second, 0, 4, 1, 5);
  const Integers e = __builtin_shufflevector(s.left_surprise, s.right_surprise, 2, 6, 2, 6);
  const Integers f = __builtin_shufflevector(s.base_surprise, s.first, 2, 6, 2, 6);
  const Integers g = __builtin_shufflevector(s.height, s.gate, 2, 6, 2, 6);
  const Integers h = __builtin_shufflevector(Integers{}, s.second, 2, 6, 2, 6);
  const Integers xl = __builtin_shufflevector(a, b, 0, 1, 4, 5), yl = __builtin_shufflevector(a, b, 2, 3, 6, 7);
  const Integers xh = __builtin_shufflevector(c, d, 0, 1, 4, 5), yh = __builtin_shufflevector(c, d, 2, 3, 6, 7);
  const Integers zl = __builtin_shufflevector(e, f, 0, 1, 4, 5), zh = __builtin_shufflevector(g, h, 0, 1, 4, 5);

  const auto fold = [](Integers v) { return v ^ (v >> 31); };
  LocalSurrounding result;
  result.scale = kFeatureBits - magnitudeBits(fold(xl) | fold(xh) | fold(yl) | fold(yh) | fold(zl) | fold(zh));
  const Lanes x = packed(scaled(xl, result.scale), scaled(xh, result.scale));
  const Lanes y = packed(scaled(yl, result.scale), scaled(yh, result.scale));
  const Lanes z = packed(scaled(zl, result.scale), scaled(zh, result.scale));
  if (!local) {
    result.component[0] = x >> 3;
    result.component[1] = y >> 3;
    result.component[2] = z >> 3;
    return result;
  }
  const auto project = [&](Integers axis) {
    // Below 2^12 * sqrt(3) * 2^-3.
    return multiplyHigh(x, splatLane<0>(axis)) + multiplyHigh(y, splatLane<1>(axis)) +
           multiplyHigh(z, splatLane<2>(axis));
  };
  result.component[0] = project(frame.normal);
  result.component[1] = project(frame.first);
  result.component[2] = project(frame.second);
  return result;
}

/// What the correction is made of: the vectors times factors, in quarters, within +-kFactorLimit.
struct Features {
  Lanes component[3];
  int scale = 0;

  /// `tip`, `gate` and `base` are factors that say how far valences are from regular.
  Features(const LocalSurrounding& local, int tip, int gate, int base) : scale(local.scale) {
    constexpr std::int16_t kOne = kFactorOne;
    const Lanes factor = packed(Integers{kOne, kOne, kOne, kOne}, Integers{kOne, tip, gate, base});
    const Lanes bounded = atMost(atLeast(factor, splat(-kFactorLimit)), splat(kFactorLimit));
    for (int a = 0; a < 3; ++a) {
      component[a] = __builtin_shufflevector(local.component[a], local.component[a], 0, 1, 2, 3, 4, 4, 5, 4) * bounded;
    }
  }
};

class AdaptiveOffset {
 public:
  /// Correction of each component, on the fine lattice.
  TSC_ALWAYS_INLINE Integers offset(const Features& features) const {
    // Sums of 8 products, within 2^31 even if all are at their limits.
    const Integers sums =
        laneSums(pairProducts(weights_[0], features.component[0]), pairProducts(weights_[1], features.component[1]),
                 pairProducts(weights_[2], features.component[2]));
    // The surrounding's 2^-3 against the factors' 2^2. Where it is not enough the features are as large as the lattice.
    const int shift = std::max(kWeightBits - 1 + features.scale, 0);
    return bounded((sums + ((1 << shift) >> 1)) >> shift, kOffsetLimit);
  }

  /// Learns from the signs of what the correction left over in each component.
  TSC_ALWAYS_INLINE void learn(const Features& features, Integers residual) {
    const Integers step = (Integers)(residual > 0) - (Integers)(residual < 0);  // -1 for a positive one
    learn(0, features, splatLane<0>(step));
    learn(1, features, splatLane<1>(step));
    learn(2, features, splatLane<2>(step));
  }

 private:
  TSC_ALWAYS_INLINE void learn(int a, const Features& features, Lanes against) {
    const Lanes f = features.component[a];
    const Lanes sign = greater(f, Lanes{}) - greater(Lanes{}, f);  // -1 for a positive one
    weights_[a] = saturatedSum(weights_[a], (sign * against) << kWeightStepBits);
  }

  static constexpr std::int32_t kOffsetLimit = 1 << 26;
  Lanes weights_[3] = {};
};

}  // namespace tsc
