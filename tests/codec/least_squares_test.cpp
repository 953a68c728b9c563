#include "least_squares.h"

#include <gtest/gtest.h>

#include <random>

namespace tsc {
namespace {

ScaledFeatures noFeatures(int count) {
  ScaledFeatures f;
  f.count = count;
  for (auto& component : f.component) component.fill(0);
  f.scale = {};
  return f;
}

TEST(LeastSquares, FindsTheWeights) {
  for (const int count : {16, 24}) {
    LeastSquares predictor;
    std::mt19937 random(3);
    std::int32_t error = 0;
    for (int i = 0; i < 3000; ++i) {
      ScaledFeatures f = noFeatures(count);
      std::array<std::int32_t, 3> value;
      for (std::size_t a = 0; a < 3; ++a) {
        auto& x = f.component[a];
        f.scale[a] = static_cast<int>(a) - 1;
        for (int j = 0; j < count - 2; ++j) {
          x[static_cast<std::size_t>(j)] = static_cast<std::int16_t>(static_cast<int>(random() % 20001) - 10000);
        }
        value[a] = (x[0] / 2 - x[3] / 4 + x[9] / 8) * 2 >> a;
      }
      const Integers predicted = predictor.predict(f);
      for (int a = 0; a < 3 && i >= 2000; ++a) {
        error = std::max(error, std::abs(predicted[a] - value[static_cast<std::size_t>(a)]));
      }
      predictor.learn(f, value);
    }
    EXPECT_LT(error, 120) << count;
  }
}

TEST(LeastSquares, PredictsNothingFromNothing) {
  LeastSquares predictor;
  const ScaledFeatures f = noFeatures(16);
  for (int i = 0; i < 300; ++i) {
    EXPECT_TRUE(isZero(predictor.predict(f)));
    predictor.learn(f, {1000, 0, -1000});
  }
}

TEST(LeastSquares, StaysWithinItsRangeWhateverComes) {
  std::mt19937 random(4);
  LeastSquares predictor;
  for (int i = 0; i < 20000; ++i) {
    ScaledFeatures f = noFeatures(24);
    std::array<std::int32_t, 3> value;
    for (std::size_t a = 0; a < 3; ++a) {
      f.scale[a] = static_cast<int>(random() % 31) - 15;
      for (std::int16_t& x : f.component[a]) {
        const int limit = random() % 8 == 0 ? 1 : 32767;
        x = static_cast<std::int16_t>(random() % 8 == 0 ? (random() % 2 == 0 ? -32767 : 32767)
                                                        : static_cast<int>(random() % 65535) % (limit + 1));
      }
      value[a] = static_cast<std::int32_t>(random()) >> (2 + random() % 29);
    }
    const Integers predicted = predictor.predict(f);
    for (int a = 0; a < 3; ++a) ASSERT_LE(std::abs(std::int64_t{predicted[a]}), std::int64_t{1} << 26);
    predictor.learn(f, value);
  }
}

}  // namespace
}  // namespace tsc
