// Linear prediction whose weights are those of least squares over what has been coded, in integers (BITSTREAM.md,
// section 6.9.3).
//
// Second moments of features and value are running means. The weights follow by one round of coordinate descent (Gauss
// and Seidel) at a time, so that nothing is inverted and nothing can blow up: weights are bounded, and a feature that
// is always 0 keeps its weight.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "lanes.h"

namespace tsc {

inline constexpr int kLeastSquaresFeatures = 24;

class LeastSquares {
 public:
  /// Within +-2^29; those from `count` on are not looked at. `count` is a multiple of 8 and at most
  /// kLeastSquaresFeatures, and the same in every call.
  using Features = std::array<std::int32_t, kLeastSquaresFeatures>;

  /// In the units of the features, within +-2^26.
  std::int64_t predict(const Features& features, int count) {
    std::uint32_t magnitude = 0;
    for (int i = 0; i < count; ++i) magnitude |= static_cast<std::uint32_t>(features[i] ^ (features[i] >> 31));
    scale_ = kFeatureBits - std::bit_width(magnitude);
    nothing_ = magnitude == 0;
    std::int64_t sum = 0;  // 24 products below 2^15 * 2^16
    for (int i = 0; i < count; ++i) {
      const std::int32_t scaled = scale_ >= 0 ? features[i] * (1 << scale_) : features[i] >> -scale_;
      scaled_[i] = static_cast<std::int16_t>(std::max(scaled, -kScaledLimit));
      sum += scaled_[i] * static_cast<std::int64_t>(weight_[i]);
    }
    const int shift = kWeightBits + scale_;
    const std::int64_t value =
        shift > 0 ? (sum + (std::int64_t{1} << (shift - 1))) >> shift : sum * (std::int64_t{1} << -shift);
    return std::clamp<std::int64_t>(value, -kValueLimit, kValueLimit);
  }

  /// `value`: what `predict` should have given, within +-2^30. Nothing is learned from features that were all 0.
  void learn(std::int64_t value, int count) {
    if (nothing_) return;
    if (seen_ < (1 << kSlowest)) ++seen_;
    const bool few = seen_ < kFewSeen;
    phase_ = (phase_ + 1) & 3;
    if (few || phase_ == 1) {
      value = scale_ >= 0 ? value * (1 << scale_) : value >> -scale_;
      accumulate(static_cast<std::int16_t>(std::clamp<std::int64_t>(value, -kScaledLimit, kScaledLimit)), count,
                 std::min<int>(kSlowest, static_cast<int>(std::bit_width(static_cast<unsigned>(seen_)))));
    }
    if (few) {
      descend(0, count, count);
    } else if (phase_ == 3) {
      turn_ = turn_ + 8 < count ? turn_ + 8 : 0;
      descend(turn_, turn_ + 8, count);
    }
  }

 private:
  /// Until then, moments and all weights move at each vertex; then in turns, and eight weights at a time.
  static constexpr int kFewSeen = 128;
  static constexpr int kFeatureBits = 15;
  static constexpr int kScaledLimit = (1 << kFeatureBits) - 1;
  static constexpr int kWeightBits = 14;
  static constexpr double kWeightLimit = 1 << 16;
  static constexpr std::int64_t kValueLimit = std::int64_t{1} << 26;
  static constexpr int kSlowest = 9;

  /// Moves the moments 2^-shift of the way to this vertex's.
  void accumulate(std::int16_t value, int count, int shift) {
    const std::int32_t half = 1 << (shift - 1);
    const auto moved = [&](Integers mean, Integers product) { return mean + ((product - mean + half) >> shift); };
    for (int i = 0; i < count; ++i) {
      std::int32_t* const row = moment_[i].data();
      const Lanes x = splat(scaled_[i]);
      for (int j = 0; j < count; j += 8) {
        const WideLanes product = multiplyWide(x, loadLanes(&scaled_[j]));
        storeIntegers(row + j, moved(loadIntegers(row + j), product.low));
        storeIntegers(row + j + 4, moved(loadIntegers(row + j + 4), product.high));
      }
    }
    for (int j = 0; j < count; j += 8) {
      const WideLanes product = multiplyWide(splat(value), loadLanes(&scaled_[j]));
      storeIntegers(&with_value_[j], moved(loadIntegers(&with_value_[j]), product.low));
      storeIntegers(&with_value_[j + 4], moved(loadIntegers(&with_value_[j + 4]), product.high));
    }
  }

  /// Moves some weights to where the expected error is least, the others given. Every number is an integer below 2^53,
  /// so that doubles carry it exactly.
  void descend(int from, int to, int count) {
    const double ridge = 1 + ((1 << 18) / seen_);
    for (int i = from; i < to; ++i) {
      Doubles low = {}, high = {};
      const std::int32_t* const row = moment_[i].data();
      for (int j = 0; j < count; j += 4) {
        const Integers moments = loadIntegers(row + j);
        low += firstTwo(moments) * loadDoubles(&weight_[j]);
        high += lastTwo(moments) * loadDoubles(&weight_[j + 2]);
      }
      low += high;  // 24 products below 2^30 * 2^16
      const double gradient = static_cast<double>(with_value_[i]) * (1 << kWeightBits) - (low[0] + low[1]);
      const double moved = weight_[i] + std::floor(gradient / (row[i] + ridge));
      weight_[i] = std::clamp(moved, -kWeightLimit, kWeightLimit);
    }
  }

  alignas(16) std::array<std::int16_t, kLeastSquaresFeatures> scaled_ = {};
  alignas(16) std::array<std::array<std::int32_t, kLeastSquaresFeatures>, kLeastSquaresFeatures> moment_ = {};
  std::array<std::int32_t, kLeastSquaresFeatures> with_value_ = {};
  alignas(16) std::array<double, kLeastSquaresFeatures> weight_ = {};
  int scale_ = 0;
  int seen_ = 0;
  int turn_ = 0;
  int phase_ = 0;  ///< of four: moments move in one, weights in another
  bool nothing_ = true;
};

}  // namespace tsc
