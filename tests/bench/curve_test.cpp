// Figures drawn from rate-distortion curves, against cases with known answers.
#include "curve.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tsc::bench {
namespace {

std::vector<RatePoint> scaledCurve(double factor) {
  return {{factor * 8e5, 1e-2}, {factor * 1e6, 2e-3}, {factor * 1.3e6, 4e-4}, {factor * 1.9e6, 2e-5}};
}

TEST(Pchip, passesThroughItsPointsAndStaysMonotone) {
  const Pchip curve({0, 1, 2, 5}, {0, 0.1, 4, 4.1});
  EXPECT_DOUBLE_EQ(curve(0), 0);
  EXPECT_DOUBLE_EQ(curve(1), 0.1);
  EXPECT_DOUBLE_EQ(curve(5), 4.1);
  for (double x = 0.01; x <= 5; x += 0.01) EXPECT_GE(curve(x), curve(x - 0.01) - 1e-12);
}

TEST(Pchip, isExactOnALine) {
  EXPECT_NEAR(Pchip({1, 2, 4}, {3, 5, 9})(3.3), 7.6, 1e-12);
  EXPECT_NEAR(Pchip({1, 4}, {3, 9})(3.3), 7.6, 1e-12);
}

TEST(BdRate, ofTheSameCurveIsZero) { EXPECT_NEAR(*bdRate(scaledCurve(1), scaledCurve(1)), 0, 1e-12); }

TEST(BdRate, ofScaledBitsIsTheScale) {
  EXPECT_NEAR(*bdRate(scaledCurve(1), scaledCurve(0.8)), -0.2, 1e-9);
  EXPECT_NEAR(*bdRate(scaledCurve(0.8), scaledCurve(1)), 0.25, 1e-9);
}

TEST(BdRate, isEmptyWithoutCommonDistortions) {
  const std::vector<RatePoint> fine = {{2e6, 1e-8}, {3e6, 1e-9}};
  EXPECT_FALSE(bdRate(scaledCurve(1), fine));
  EXPECT_FALSE(bdRate(scaledCurve(1), std::vector<RatePoint>{{1e6, 1e-3}}));
}

TEST(BdRate, leavesPointsWithoutErrorOut) {
  auto curve = scaledCurve(0.5);
  curve.push_back({2e6, 0});
  EXPECT_NEAR(*bdRate(scaledCurve(1), curve), -0.5, 1e-9);
}

TEST(MseAtRate, interpolatesAndDoesNotExtrapolate) {
  EXPECT_NEAR(*mseAtRate(scaledCurve(1), 1e6), 2e-3, 1e-12);
  EXPECT_FALSE(mseAtRate(scaledCurve(1), 7e5));
  EXPECT_FALSE(mseAtRate(scaledCurve(1), 2e6));
}

TEST(Spread, knowsItsOrderStatistics) {
  const Spread spread = spreadOf({4, 1, 3, 2, 10});
  EXPECT_DOUBLE_EQ(spread.median, 3);
  EXPECT_DOUBLE_EQ(spread.mean, 4);
  EXPECT_DOUBLE_EQ(spread.worst, 10);
  EXPECT_DOUBLE_EQ(spread.best, 1);
  EXPECT_DOUBLE_EQ(spread.low_quartile, 2);
  EXPECT_DOUBLE_EQ(ratioSpreadOf({0.5, 2}).mean, 1);
  EXPECT_EQ(spreadOf({}).count, 0u);
}

}  // namespace
}  // namespace tsc::bench
