#include "least_squares.h"

#include <gtest/gtest.h>

#include <random>

namespace tsc {
namespace {

TEST(LeastSquares, FindsTheWeights) {
  for (const int count : {16, 24}) {
    LeastSquares predictor;
    std::mt19937 random(3);
    std::int64_t error = 0;
    for (int i = 0; i < 3000; ++i) {
      LeastSquares::Features f{};
      for (int j = 0; j < count - 2; ++j) {
        f[static_cast<std::size_t>(j)] = static_cast<std::int32_t>(random() % 20001) - 10000;
      }
      const std::int64_t value = f[0] / 2 - f[3] / 4 + f[9] / 8;
      const std::int64_t predicted = predictor.predict(f, count);
      if (i >= 2000) error = std::max(error, std::abs(predicted - value));
      predictor.learn(value, count);
    }
    EXPECT_LT(error, 60) << count;
  }
}

TEST(LeastSquares, PredictsNothingFromNothing) {
  LeastSquares predictor;
  for (int i = 0; i < 300; ++i) {
    EXPECT_EQ(predictor.predict({}, 16), 0);
    predictor.learn(1000, 16);
  }
}

TEST(LeastSquares, StaysWithinItsRangeWhateverComes) {
  std::mt19937 random(4);
  LeastSquares predictor;
  for (int i = 0; i < 20000; ++i) {
    LeastSquares::Features f{};
    for (std::int32_t& x : f) {
      x = static_cast<std::int32_t>(random()) >> (2 + (random() % 4 == 0 ? random() % 30 : 0));
      if (random() % 8 == 0) x = random() % 2 == 0 ? -(1 << 29) : 1 << 29;
    }
    ASSERT_LE(std::abs(predictor.predict(f, 24)), std::int64_t{1} << 26);
    predictor.learn(static_cast<std::int32_t>(random()) >> (1 + random() % 30), 24);
  }
}

}  // namespace
}  // namespace tsc
