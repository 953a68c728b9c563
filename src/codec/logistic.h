// Logistic mixing of binary predictions, in lanes (BITSTREAM.md, section 6.9.4; the idea is that of the PAQ
// compressors, Mahoney 2005): adaptive chances of a bit, and weights that learn to add what they say.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "lanes.h"

namespace tsc {

/// Four adaptive probabilities of a bit, a lane each: the probability in units of 2^-16 in the lower half, in the upper
/// one how far the next update goes, which becomes less with each.
namespace chances {

inline constexpr std::int32_t kUnknown = 0x7fff8000;
inline constexpr std::int16_t kSlowest = 257;

/// log2 of p / (1 - p), in units of 2^-7, linear between powers of two: a float's bits are just that. Below 2^12.
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

/// What mixing gives is ln(p / (1 - p)) in units of 2^-8, within +-kStretchLimit.
inline constexpr int kStretchLimit = 2815;  // 11 nats

/// 2^16 / (1 + e^-x) for x = -11, -10.5, ... 11.
inline constexpr std::array<std::uint16_t, 45> kSquashKnots = {
    1,     2,     3,     5,     8,     13,    22,    36,    60,    98,    162,   267,   439,   720,   1179,
    1921,  3108,  4971,  7812,  11955, 17625, 24743, 32768, 40793, 47911, 53581, 57724, 60565, 62428, 63615,
    64357, 64816, 65097, 65269, 65374, 65438, 65476, 65500, 65514, 65523, 65528, 65531, 65533, 65534, 65535};

/// The probability in units of 2^-16, 1..65535: between knots by straight lines.
constexpr int squash(int stretched) {
  const int from_first = stretched + kStretchLimit + 1;
  const auto knot = static_cast<std::size_t>(from_first >> 7);
  const int part = from_first & 127;
  return (kSquashKnots[knot] * (128 - part) + kSquashKnots[knot + 1] * part + 64) >> 7;
}

/// `squash` of each value within +-kStretchLimit.
inline constexpr std::array<std::uint16_t, 2 * kStretchLimit + 1> kSquashed = [] {
  std::array<std::uint16_t, 2 * kStretchLimit + 1> table{};
  for (int i = -kStretchLimit; i <= kStretchLimit; ++i) {
    table[static_cast<std::size_t>(i + kStretchLimit)] = static_cast<std::uint16_t>(squash(i));
  }
  return table;
}();

/// The probability of a 1 by the sum of weights times inputs.
TSC_ALWAYS_INLINE int mixedProbability(std::int32_t sum) {
  const int stretched = std::clamp(sum >> 14, -kStretchLimit, kStretchLimit);
  return kSquashed[static_cast<std::size_t>(stretched + kStretchLimit)];
}

/// Weights of `kInputs` stretched probabilities, a multiple of eight, in units of 2^-14. A set learns fast at first.
template <std::size_t kInputs, std::int16_t kFirstWeight, std::int32_t kFirstRate, std::int32_t kLastRate>
struct alignas(16) LaneWeights {
  static_assert(kInputs % 8 == 0 && kLastRate <= kFirstRate && kFirstRate < 1 << 15);

  std::array<std::int16_t, kInputs> weight;
  std::int32_t rate = kFirstRate;

  LaneWeights() { weight.fill(kFirstWeight); }

  /// Eight of the weights.
  TSC_ALWAYS_INLINE Lanes part(std::size_t i) const { return loadLanes(&weight[8 * i]); }

  /// Inputs times this are what weights move by. `error`: what came, 65535 or 0, less the probability given.
  TSC_ALWAYS_INLINE Lanes step(int error) {
    const Integers result = splatInteger((error * rate) >> 13);  // a product below 2^16 * 2^15
    rate -= (rate - kLastRate) >> 6;
    return packed(result, result);  // saturated, which takes a rate of 2^12 or more
  }
  TSC_ALWAYS_INLINE void learn(std::size_t i, Lanes inputs, Lanes step) {
    storeLanes(&weight[8 * i], saturatedSum(part(i), (multiplyHigh(inputs << 3, step) + 1) >> 1));
  }
};

}  // namespace tsc
