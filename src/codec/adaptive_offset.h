// A correction of the average prediction that learns on the way (BITSTREAM.md, section 6.5).
//
// For each component of the local frame, the correction is a weighted sum of features that both sides know: how far the
// neighbours were from their own predictions, how the candidates disagree, the shape of the base triangle, and valences.
// The weights move by a fixed step in the direction that would have made the last error smaller (sign-sign LMS).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "frame.h"
#include "lanes.h"

namespace tsc {

inline constexpr int kFeatures = 8;
inline constexpr int kFeatureBits = 13;   // the largest feature component is scaled to this many bits
inline constexpr int kWeightBits = 13;
inline constexpr int kWeightStep = 16;
inline constexpr int kWeightLimit = 32000;

/// Feature vectors on the fine lattice, one a lane.
struct Features {
  std::array<std::int32_t, kFeatures> x{};
  std::array<std::int32_t, kFeatures> y{};
  std::array<std::int32_t, kFeatures> z{};

  void set(int lane, const Vec3& v) {
    x[lane] = v.x;
    y[lane] = v.y;
    z[lane] = v.z;
  }
};

/// Features in the frame, scaled by 2^(scale - 2).
struct LocalFeatures {
  Lanes component[3];
  int scale = 0;
};

inline LocalFeatures toLocal(const Frame& frame, const Features& features) {
  std::uint32_t bits = 0;
  for (int i = 0; i < kFeatures; ++i) {
    bits |= static_cast<std::uint32_t>((features.x[i] ^ features.x[i] >> 31) | (features.y[i] ^ features.y[i] >> 31) |
                                       (features.z[i] ^ features.z[i] >> 31));
  }
  LocalFeatures local;
  local.scale = kFeatureBits - std::bit_width(bits);
  const Lanes x = narrowed(features.x.data(), local.scale);
  const Lanes y = narrowed(features.y.data(), local.scale);
  const Lanes z = narrowed(features.z.data(), local.scale);
  const auto project = [&](const Vec3& axis) {
    return multiplyHigh(x, splat(static_cast<std::int16_t>(axis.x))) +
           multiplyHigh(y, splat(static_cast<std::int16_t>(axis.y))) +
           multiplyHigh(z, splat(static_cast<std::int16_t>(axis.z)));
  };
  local.component[0] = project(frame.normal);
  local.component[1] = project(frame.first);
  local.component[2] = project(frame.second);
  return local;
}

class AdaptiveOffset {
 public:
  /// Correction of each component, on the fine lattice.
  WideVec3 offset(const LocalFeatures& features) const {
    WideVec3 result;
    const int shift = kWeightBits - 2 + features.scale;
    for (int a = 0; a < 3; ++a) {
      const std::int32_t sum = dotProduct(weights_[a], features.component[a]);  // 8 products below 2^15 * 2^12
      const std::int64_t value = shift > 0 ? (std::int64_t{sum} + (std::int64_t{1} << (shift - 1))) >> shift
                                           : std::int64_t{sum} * (std::int64_t{1} << -shift);
      result[a] = std::clamp<std::int64_t>(value, -kOffsetLimit, kOffsetLimit);
    }
    return result;
  }

  /// Learns from the sign of what the correction left over in component `a`.
  void learn(int a, const LocalFeatures& features, std::int32_t residual) {
    if (residual == 0) return;
    const Lanes step = splat(residual > 0 ? kWeightStep : -kWeightStep);
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
