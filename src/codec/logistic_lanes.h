// Logistic mixing of many binary predictions in lanes (BITSTREAM.md, section 6.9.4; the idea is that of the PAQ
// compressors, Mahoney 2005): adaptive chances, and weights that learn to add them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "lanes.h"
#include "logistic.h"

namespace tsc {

/// Four adaptive probabilities of a bit, a lane each: the probability in units of 2^-16 in the lower half, in the upper
/// one how far the next update goes, which becomes less with each.
namespace chances {

inline constexpr std::int32_t kUnknown = 0x7fff8000;
inline constexpr std::int16_t kSlowest = 257;

/// log2 of p / (1 - p), in units of 2^-7, linear between powers of two: a float's bits are just that.
TSC_ALWAYS_INLINE Integers stretched(Integers chance) {
  const Integers one = ((chance & 0xffff) << 1) + 1;
  return ((Integers) __builtin_convertvector(one, Floats) -
          (Integers) __builtin_convertvector((1 << 17) - one, Floats)) >>
         16;
}

/// `bits`: what came, 65535 or 0 in all lanes.
TSC_ALWAYS_INLINE Integers updated(Integers chance, Integers bits) {
  // How far it is to the other value, so that one product moves the probability and the rate.
  const Lanes distance = (Lanes)(chance ^ bits);
  const Lanes lanes = (Lanes)chance;
  const Lanes rate = __builtin_shufflevector(lanes, lanes, 1, 1, 3, 3, 5, 5, 7, 7);
  const Lanes rest = (Lanes)((UnsignedLanes)distance - (UnsignedLanes)multiplyHighUnsigned(distance, rate));
  constexpr std::int16_t kNone = -32768;
  const Lanes bounded = atLeast(rest, Lanes{kNone, kSlowest, kNone, kSlowest, kNone, kSlowest, kNone, kSlowest});
  return (Integers)bounded ^ bits;
}

}  // namespace chances

/// `squash` of each value within +-kStretchLimit.
inline constexpr std::array<std::uint16_t, 2 * kStretchLimit + 1> kSquashed = [] {
  std::array<std::uint16_t, 2 * kStretchLimit + 1> table{};
  for (int i = -kStretchLimit; i <= kStretchLimit; ++i) {
    table[static_cast<std::size_t>(i + kStretchLimit)] = static_cast<std::uint16_t>(squash(i));
  }
  return table;
}();

/// Weights of eight stretched probabilities, or of twice eight, in units of 2^-14. A set learns fast at first.
struct alignas(16) LaneWeights {
  std::array<std::int16_t, 16> weight;
  std::int32_t rate = kFirstRate;

  static constexpr std::int16_t kFirstWeight = 2000;
  static constexpr std::int32_t kFirstRate = 3000;
  static constexpr std::int32_t kLastRate = 1500;

  LaneWeights() { weight.fill(kFirstWeight); }

  TSC_ALWAYS_INLINE Lanes part(std::size_t i) const { return loadLanes(&weight[8 * i]); }

  /// Inputs times this are what weights move by. `error`: what came, 65535 or 0, less the probability given.
  TSC_ALWAYS_INLINE Lanes step(int error) {
    const Lanes result = splat(static_cast<std::int16_t>((error * rate) >> 13));  // below 2^16 * 3000 / 2^13
    rate -= (rate - kLastRate) >> 6;
    return result;
  }
  TSC_ALWAYS_INLINE void learn(std::size_t i, Lanes inputs, Lanes step) {
    storeLanes(&weight[8 * i], saturatedSum(part(i), (multiplyHigh(inputs << 3, step) + 1) >> 1));
  }
};

}  // namespace tsc
