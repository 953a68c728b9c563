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

inline constexpr int kFeatures = 8;
inline constexpr int kFeatureBits = 12;  // the largest feature component is scaled to this many bits
inline constexpr int kWeightBits = 13;
inline constexpr int kWeightStep = 16;
inline constexpr int kWeightLimit = 8000;
inline constexpr std::int16_t kFactorOne = 4;  // factors count quarters
inline constexpr int kFactorLimit = 12;

/// Feature vectors on the fine lattice, one a lane.
struct Features {
  WideLanes x;
  WideLanes y;
  WideLanes z;
  Lanes factor;  ///< each lane's factor, in quarters, within +-kFactorLimit
};

/// Features in the frame, times their factors, scaled by 2^scale.
struct LocalFeatures {
  Lanes component[3];
  int scale = 0;
};

inline LocalFeatures toLocal(const Frame& frame, const Features& features) {
  LocalFeatures local;
  local.scale = kFeatureBits - std::bit_width(magnitudeBits(features.x, features.y, features.z));
  const Lanes x = narrowed(features.x, local.scale);
  const Lanes y = narrowed(features.y, local.scale);
  const Lanes z = narrowed(features.z, local.scale);
  const auto project = [&](const Vec3& axis) {
    // Below 2^12 * sqrt(3) * 2^-2 by a factor of at most 12: within 16 bits.
    return (multiplyHigh(x, splat(static_cast<std::int16_t>(axis.x))) +
            multiplyHigh(y, splat(static_cast<std::int16_t>(axis.y))) +
            multiplyHigh(z, splat(static_cast<std::int16_t>(axis.z)))) *
           features.factor;
  };
  local.component[0] = project(frame.normal);
  local.component[1] = project(frame.first);
  local.component[2] = project(frame.second);
  return local;
}

class AdaptiveOffset {
 public:
  /// Correction of each component, on the fine lattice.
  std::array<std::int64_t, 3> offset(const LocalFeatures& features) const {
    std::array<std::int64_t, 3> result;
    const int shift = kWeightBits + features.scale;  // the frame's 2^-2 and the factors' 2^2 cancel
    for (int a = 0; a < 3; ++a) {
      const std::int32_t sum = dotProduct(weights_[a], features.component[a]);  // 8 products below 2^13 * 2^15
      const std::int64_t value = shift > 0 ? (std::int64_t{sum} + (std::int64_t{1} << (shift - 1))) >> shift
                                           : std::int64_t{sum} * (std::int64_t{1} << -shift);
      result[a] = std::abs(value) <= kOffsetLimit ? value : value < 0 ? -kOffsetLimit : kOffsetLimit;
    }
    return result;
  }

  /// Learns from the sign of what the correction left over in component `a`.
  void learn(int a, const LocalFeatures& features, std::int32_t residual) {
    const Lanes step = splat(static_cast<std::int16_t>(kWeightStep * ((residual > 0) - (residual < 0))));
    const Lanes f = features.component[a];
    const Lanes w = weights_[a];
    const Lanes moved = w + (greater(f, Lanes{}) & step) - (greater(Lanes{}, f) & step);
    // A weight at its limit stays there, so that no lane wraps.
    const Lanes held = greater(moved, splat(kWeightLimit)) | greater(splat(-kWeightLimit), moved);
    weights_[a] = (held & w) | (~held & moved);
  }

 private:
  static constexpr std::int64_t kOffsetLimit = std::int64_t{1} << 26;
  Lanes weights_[3] = {};
};

}  // namespace tsc
