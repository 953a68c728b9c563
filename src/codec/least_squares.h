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
#include <cstdint>

#include "lanes.h"

namespace tsc {

inline constexpr int kLeastSquaresFeatures = 24;

/// Features of the three components, each component's scaled by a power of two.
struct ScaledFeatures {
  int count = 0;  ///< a multiple of 8, the same at each vertex that one LeastSquares sees
  alignas(16) std::array<std::array<std::int16_t, kLeastSquaresFeatures>, 3> component;  ///< within +-(2^15 - 1)
  std::array<int, 3> scale;  ///< features are 2^scale times what they stand for
};

/// The predictors of three components. They learn at the same vertices.
class LeastSquares {
 public:
  /// In the units of the features before they were scaled, within +-2^26.
  Integers predict(const ScaledFeatures& features) const {
    Integers sums[3];
    for (std::size_t a = 0; a < 3; ++a) {
      sums[a] = Integers{};
      for (std::size_t i = 0; i < static_cast<std::size_t>(features.count); i += 8) {
        const Integers products = pairProducts(loadLanes(&features.component[a][i]), loadLanes(&short_weight_[a][i]));
        sums[a] += products >> kSumShift;  // 12 of them, below 2^26 each
      }
    }
    const Integers sum = laneSums(sums[0], sums[1], sums[2]);
    Integers result{};
    for (int a = 0; a < 3; ++a) {
      const int shift = kWeightBits - kSumShift + features.scale[static_cast<std::size_t>(a)];
      const std::int64_t value =
          shift > 0 ? (sum[a] + (std::int64_t{1} << (shift - 1))) >> shift : sum[a] * (std::int64_t{1} << -shift);
      result[a] = static_cast<std::int32_t>(std::clamp(value, -kValueLimit, kValueLimit));
    }
    return result;
  }

  /// `value`: what `predict` should have given.
  void learn(const ScaledFeatures& features, const std::array<std::int32_t, 3>& value) {
    if (seen_ < (1 << kSlowest)) ++seen_;
    const bool few = seen_ < kFewSeen;
    phase_ = (phase_ + 1) & 3;
    if (few || phase_ % 2 == 1) {
      const int shift = std::min<int>(kSlowest, static_cast<int>(std::bit_width(static_cast<unsigned>(seen_))));
      for (std::size_t a = 0; a < 3; ++a) {
        const int scale = features.scale[a];
        const std::int64_t scaled = scale >= 0 ? value[a] * (std::int64_t{1} << scale) : value[a] >> -scale;
        accumulate(a, features,
                   static_cast<std::int16_t>(std::clamp<std::int64_t>(scaled, -kScaledLimit, kScaledLimit)), shift);
      }
    }
    if (few) {
      for (std::size_t from = 0; from < static_cast<std::size_t>(features.count); from += kBlock) {
        descend(from, static_cast<std::size_t>(features.count));
      }
    } else if (phase_ == 3) {
      turn_ = turn_ + kBlock < static_cast<std::size_t>(features.count) ? turn_ + kBlock : 0;
      descend(turn_, static_cast<std::size_t>(features.count));
    }
  }

 private:
  /// Until then, moments and all weights move at each vertex; then moments at every other vertex, and a block of
  /// weights at every fourth.
  static constexpr int kFewSeen = 128;
  static constexpr std::size_t kBlock = 8;
  static constexpr int kScaledLimit = (1 << 15) - 1;
  static constexpr int kWeightBits = 13;
  static constexpr std::int64_t kWeightLimit = (1 << 15) - 1;
  static constexpr int kSumShift = 5;
  static constexpr std::int64_t kValueLimit = std::int64_t{1} << 26;
  static constexpr int kSlowest = 9;
  template <class T>
  using Row = std::array<T, kLeastSquaresFeatures>;

  /// Moves the moments of a component 2^-shift of the way to this vertex's. They are symmetric: each row begins with
  /// the block on the diagonal.
  void accumulate(std::size_t a, const ScaledFeatures& features, std::int16_t value, int shift) {
    const auto count = static_cast<std::size_t>(features.count);
    const Row<std::int16_t>& x = features.component[a];
    const auto move = [&](std::int32_t* mean, Integers product) {
      const Integers old = loadIntegers(mean);
      storeIntegers(mean, old + ((product - old) >> shift));
    };
    for (std::size_t i = 0; i < count; ++i) {
      const Lanes factor = splat(x[i]);
      for (std::size_t j = i / kBlock * kBlock; j < count; j += 8) {
        const WideLanes product = multiplyWide(factor, loadLanes(&x[j]));
        move(&moment_[a][i][j], product.low);
        move(&moment_[a][i][j + 4], product.high);
      }
    }
    for (std::size_t j = 0; j < count; j += 8) {
      const WideLanes product = multiplyWide(splat(value), loadLanes(&x[j]));
      move(&with_value_[a][j], product.low);
      move(&with_value_[a][j + 4], product.high);
    }
  }

  /// Of a block's weights in one component: half the slope of the expected squared error. Every number here and in
  /// `descend` is an integer below 2^53, so that doubles carry it exactly, in whatever order it is summed.
  void slopes(std::size_t a, std::size_t from, std::size_t count, std::array<double, kBlock>& slope) const {
    Doubles sum[kBlock / 2];
    for (std::size_t k = 0; k < kBlock / 2; ++k) {
      const Integers with_value = loadIntegers(&with_value_[a][from + k / 2 * 4]);
      sum[k] = (k % 2 == 0 ? firstTwo(with_value) : lastTwo(with_value)) * (1 << kWeightBits);
    }
    for (std::size_t j = 0; j < from + kBlock; ++j) {  // 24 products below 2^30 * 2^15
      const Doubles weight = Doubles{} + weight_[a][j];
      const Integers low = loadIntegers(&moment_[a][j][from]), high = loadIntegers(&moment_[a][j][from + 4]);
      sum[0] -= firstTwo(low) * weight;
      sum[1] -= lastTwo(low) * weight;
      sum[2] -= firstTwo(high) * weight;
      sum[3] -= lastTwo(high) * weight;
    }
    for (std::size_t k = 0; k < kBlock; ++k) {
      Doubles beyond{};
      for (std::size_t j = from + kBlock; j < count; j += 4) {
        const Integers moments = loadIntegers(&moment_[a][from + k][j]);
        beyond += firstTwo(moments) * loadDoubles(&weight_[a][j]) + lastTwo(moments) * loadDoubles(&weight_[a][j + 2]);
      }
      slope[k] = sum[k / 2][static_cast<int>(k % 2)] - (beyond[0] + beyond[1]);
    }
  }

  /// Moves a block's weights, one after the other, to where the expected error is least, the others given.
  void descend(std::size_t from, std::size_t count) {
    const double ridge = 1 + ((1 << 18) / seen_);
    alignas(16) std::array<std::array<double, kBlock>, 3> slope;
    for (std::size_t a = 0; a < 3; ++a) slopes(a, from, count, slope[a]);
    for (std::size_t i = 0; i < kBlock; ++i) {
      // Three chains of long latency side by side.
      for (std::size_t a = 0; a < 3; ++a) {
        const std::int32_t* const row = &moment_[a][from + i][from];
        const auto old = static_cast<std::int64_t>(weight_[a][from + i]);
        const auto step = static_cast<std::int64_t>(slope[a][i] / (row[i] + ridge));
        const std::int64_t weight = std::clamp(old + step, -kWeightLimit, kWeightLimit);
        weight_[a][from + i] = static_cast<double>(weight);
        short_weight_[a][from + i] = static_cast<std::int16_t>(weight);
        const Doubles moved = Doubles{} + static_cast<double>(weight - old);
        for (std::size_t k = i / 4 * 4; k < kBlock; k += 4) {
          const Integers moments = loadIntegers(row + k);
          storeDoubles(&slope[a][k], loadDoubles(&slope[a][k]) - firstTwo(moments) * moved);
          storeDoubles(&slope[a][k + 2], loadDoubles(&slope[a][k + 2]) - lastTwo(moments) * moved);
        }
      }
    }
  }

  alignas(16) std::array<std::array<Row<std::int32_t>, kLeastSquaresFeatures>, 3> moment_ = {};
  alignas(16) std::array<Row<std::int32_t>, 3> with_value_ = {};
  alignas(16) std::array<Row<double>, 3> weight_ = {};
  alignas(16) std::array<Row<std::int16_t>, 3> short_weight_ = {};  ///< the same
  int seen_ = 0;
  int phase_ = 0;  ///< of four: moments move in the second and the last, weights in the last
  std::size_t turn_ = 0;
};

}  // namespace tsc
