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

inline constexpr int kWeightBits = 15;
inline constexpr int kWeightStepBits = 6;
inline constexpr int kFactorOne = 4;  // factors count quarters
inline constexpr int kFactorLimit = 7;
inline constexpr int kSurpriseShift = 1;  // features are a half of surprises, and a sixteenth of shapes times factors
inline constexpr int kShapeShift = 4;

/// The vectors around a vertex that features are made of, two in each register, in 16 bits each.
struct Surrounding {
  Lanes gate_surprises;  ///< left's and right's
  Lanes base_and_first;  ///< base's surprise; the first candidate from the predicted point
  Lanes shape;  ///< height, from the base vertex to the middle of the gate; gate, from its right end to its left
};

/// What the correction is made of, by component.
struct Features {
  // Lanes: left, right, base surprise, first, height, height, gate, height.
  Lanes component[3];

  /// `irregular`, in lanes 1 to 3: how far the valences of the tip, between the gate's ends, and about the base are
  /// from regular.
  TSC_ALWAYS_INLINE Features(const Frame& frame, const Surrounding& s, Integers irregular) {
    constexpr std::int16_t kMost = kFactorLimit, kLeast = -kFactorLimit;
    constexpr Lanes kUpper = {1, 1, 1, 1, kFactorOne, kMost, kMost, kMost};
    constexpr Lanes kLower = {1, 1, 1, 1, kFactorOne, kLeast, kLeast, kLeast};
    const Lanes factors = atMost(atLeast(packed(irregular, irregular), kLower), kUpper);
    component[0] = along(frame.normal, s) * factors;
    component[1] = along(frame.first, s) * factors;
    component[2] = along(frame.second, s) * factors;
  }

 private:
  TSC_ALWAYS_INLINE static Lanes along(Lanes axis, const Surrounding& s) {
    const Integers a = pairProducts(s.gate_surprises, axis), b = pairProducts(s.base_and_first, axis);
    const Integers c = pairProducts(s.shape, axis);
    const Integers surprises = __builtin_shufflevector(a, b, 0, 2, 4, 6) + __builtin_shufflevector(a, b, 1, 3, 5, 7);
    const Integers shape = c + __builtin_shufflevector(c, c, 1, 0, 3, 2);
    const Lanes all = packed(surprises >> (kFrameBits + kSurpriseShift), shape >> (kFrameBits + kShapeShift));
    return __builtin_shufflevector(all, all, 0, 1, 2, 3, 4, 5, 6, 4);
  }
};

class AdaptiveOffset {
 public:
  /// Correction of each component, in the unit of the vectors.
  TSC_ALWAYS_INLINE Integers offset(const Features& features) const {
    // Sums of 8 products. Where surprises and weights are near their limits, they wrap.
    const Integers sums =
        laneSums(pairProducts(weights_[0], features.component[0]), pairProducts(weights_[1], features.component[1]),
                 pairProducts(weights_[2], features.component[2]));
    constexpr int kShift = kWeightBits - kSurpriseShift;
    return (Integers)((Words)sums + (1u << (kShift - 1))) >> kShift;
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

  Lanes weights_[3] = {};
};

}  // namespace tsc
