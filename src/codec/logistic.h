// Logistic mixing of binary predictions, in integers (BITSTREAM.md, section 6.9; the idea is that of the PAQ
// compressors, Mahoney 2005).
//
// Probabilities are in units of 2^-16. The *stretched* value of a probability p is ln(p / (1 - p)) in units of 2^-8,
// within +-kStretchLimit; `squash` is its inverse. Mixers add stretched values with weights that learn.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "lanes.h"

namespace tsc {

inline constexpr int kStretchLimit = 2815;  // 11 nats

/// 2^16 / (1 + e^-x) for x = -11, -10.5, ... 11.
inline constexpr std::array<std::uint16_t, 45> kSquashKnots = {
    1,     2,     3,     5,     8,     13,    22,    36,    60,    98,    162,   267,   439,   720,   1179,
    1921,  3108,  4971,  7812,  11955, 17625, 24743, 32768, 40793, 47911, 53581, 57724, 60565, 62428, 63615,
    64357, 64816, 65097, 65269, 65374, 65438, 65476, 65500, 65514, 65523, 65528, 65531, 65533, 65534, 65535};

/// The probability of a stretched value within +-kStretchLimit: between knots by straight lines.
constexpr int squash(int stretched) {
  const int from_first = stretched + kStretchLimit + 1;
  const auto knot = static_cast<std::size_t>(from_first >> 7);
  const int part = from_first & 127;
  return (kSquashKnots[knot] * (128 - part) + kSquashKnots[knot + 1] * part + 64) >> 7;
}

/// For each probability without its lowest four bits: the least value that `squash` takes there or beyond. 0 for 1/2.
inline constexpr std::array<std::int16_t, 4096> kStretch = [] {
  std::array<std::int16_t, 4096> table{};
  int stretched = -kStretchLimit;
  for (int i = 0; i < 4096; ++i) {
    while (stretched < kStretchLimit && squash(stretched) < 16 * i) ++stretched;
    table[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(stretched);
  }
  return table;
}();

/// Adaptive probability of a bit, all zeros when nothing is known: the n-th update goes about 1 / n of the way.
struct Chance {
  std::uint16_t flipped = 0;  ///< the probability, its highest bit inverted
  std::uint16_t count = 0;    ///< updates so far, at most kCountLimit; kInert where nothing is ever learned

  static constexpr int kCountLimit = 255;
  static constexpr int kInert = 256;

  int stretched() const { return kStretch[static_cast<std::size_t>((flipped ^ 0x8000) >> 4)]; }

  void update(bool bit) {
    // Towards 65535 as the complement goes towards 0; the rate is below 2^16.
    const std::uint32_t mask = bit ? 0x7fffu : 0x8000u;
    const std::uint32_t from_target = flipped ^ mask;
    flipped = static_cast<std::uint16_t>((from_target - (from_target * kRates[count] >> 16)) ^ mask);
    count = static_cast<std::uint16_t>(count + (count < kCountLimit));
  }

 private:
  static constexpr std::array<std::uint16_t, kInert + 1> kRates = [] {
    std::array<std::uint16_t, kInert + 1> rates{};
    for (int n = 0; n <= kCountLimit; ++n) {
      rates[static_cast<std::size_t>(n)] = static_cast<std::uint16_t>(655360 / (10 * n + 16));
    }
    return rates;
  }();
};

inline constexpr int kMixerInputs = 16;
using MixerInputs = std::array<std::int16_t, kMixerInputs>;  ///< stretched

/// One set of weights, in units of 2^-20; they count as at most +-2. A set learns fast at first.
struct alignas(16) MixerWeights {
  std::array<std::int32_t, kMixerInputs> weight;
  std::int32_t rate = kFirstRate;

  static constexpr std::int32_t kFirstWeight = 251658;  // 0.24
  static constexpr std::int32_t kFirstRate = 1920;
  static constexpr std::int32_t kLastRate = 384;

  MixerWeights() { weight.fill(kFirstWeight); }

  /// The stretched probability of a 1.
  int mix(const MixerInputs& inputs) const {
    const Lanes low = packed(part(0) >> 6, part(4) >> 6);
    const Lanes high = packed(part(8) >> 6, part(12) >> 6);
    // 16 products below 2^12 * 2^15
    const std::int32_t sum = dotProduct(low, loadLanes(&inputs[0])) + dotProduct(high, loadLanes(&inputs[8]));
    return std::clamp(sum >> 14, -kStretchLimit, kStretchLimit);
  }

  /// `error`: what came, 65535 or 0, less the probability that this set gave.
  void learn(const MixerInputs& inputs, int error) {
    const Lanes step = splat(static_cast<std::int16_t>((error * rate) >> 12));  // below 2^16 * 1920 / 2^12
    for (int i = 0; i < kMixerInputs; i += 8) {
      const WideLanes product = multiplyWide(step, loadLanes(&inputs[static_cast<std::size_t>(i)]));
      move(i, product.low);
      move(i + 4, product.high);
    }
    rate -= (rate - kLastRate) >> 6;
  }

 private:
  Integers part(int i) const { return loadIntegers(&weight[static_cast<std::size_t>(i)]); }
  /// Modulo 2^32, which only a stream made for it could reach: what is too large counts as +-2 meanwhile.
  void move(int i, Integers product) {
    const Words moved = (Words)part(i) + (Words)((product + 128) >> 8);
    storeIntegers(&weight[static_cast<std::size_t>(i)], (Integers)moved);
  }
};

/// Weights for eight inputs, otherwise as `MixerWeights`.
struct alignas(16) EightWeights {
  std::array<std::int32_t, 8> weight;
  std::int32_t rate = MixerWeights::kFirstRate;

  EightWeights() { weight.fill(MixerWeights::kFirstWeight); }

  /// The stretched probability of a 1.
  int mix(Lanes inputs) const {
    const std::int32_t sum = dotProduct(packed(part(0) >> 6, part(4) >> 6), inputs);
    return std::clamp(sum >> 14, -kStretchLimit, kStretchLimit);
  }

  /// `error`: what came, 65535 or 0, less the probability that this set gave.
  void learn(Lanes inputs, int error) {
    const WideLanes product = multiplyWide(splat(static_cast<std::int16_t>((error * rate) >> 12)), inputs);
    move(0, product.low);
    move(4, product.high);
    rate -= (rate - MixerWeights::kLastRate) >> 6;
  }

 private:
  Integers part(std::size_t i) const { return loadIntegers(&weight[i]); }
  void move(std::size_t i, Integers product) {
    const Words moved = (Words)part(i) + (Words)((product + 128) >> 8);
    storeIntegers(&weight[i], (Integers)moved);
  }
};

/// Mixes what two sets of weights give for the same inputs.
struct FinalWeights {
  std::array<std::int32_t, 2> weight = {1 << 15, 1 << 15};  ///< units of 2^-16

  int mix(int first, int second) const {
    const std::int64_t sum = std::int64_t{weight[0]} * first + std::int64_t{weight[1]} * second;
    return static_cast<int>(std::clamp<std::int64_t>(sum >> 16, -kStretchLimit, kStretchLimit));
  }
  void learn(int first, int second, int error) {
    weight[0] = moved(weight[0], first * error);  // below 2^12 * 2^16
    weight[1] = moved(weight[1], second * error);
  }

 private:
  static std::int32_t moved(std::int32_t weight, int product) {
    return std::clamp(weight + ((product + (1 << 16)) >> 17), -(1 << 20), 1 << 20);
  }
};

}  // namespace tsc
