#include "predict.h"

#include <gtest/gtest.h>

#include <random>

#include "surface_builders.h"

namespace tsc {
namespace {

TEST(Predict, Parallelogram) {
  EXPECT_EQ(parallelogram({1, 2, 3}, {10, 20, 30}, {4, 5, 6}), Vec3(7, 17, 27));
}

TEST(Predict, AverageIsExactWhereAllAgreeAndRoundedElsewhere) {
  for (int n = 1; n <= kMaxStencils; ++n) {
    const std::vector<Vec3> same(static_cast<std::size_t>(n), Vec3(123456, -7, 67108864));
    EXPECT_EQ(average(same.data(), n), same[0]);
  }
  const Vec3 pair[2] = {{0, 0, 0}, {10, -10, 7}};
  EXPECT_EQ(average(pair, 2), Vec3(5, -5, 4)) << "halves up";
  std::mt19937 random(1);
  for (int i = 0; i < 10000; ++i) {
    const int n = 1 + i % kMaxStencils;
    Vec3 candidates[kMaxStencils];
    for (Vec3& c : candidates) {
      const auto coordinate = [&] { return static_cast<int>(random() % 2000001) - 1000000; };
      const int x = coordinate(), y = coordinate();
      c = {x, y, coordinate()};
    }
    const Vec3 mean = average(candidates, n);
    for (int a = 0; a < 3; ++a) {
      double sum = 0;
      for (int j = 0; j < n; ++j) sum += candidates[j][a];
      // The reciprocals of 3, 5 and 6 are rounded to 18 bits.
      ASSERT_NEAR(mean[a], sum / n, 0.5 + 2e6 * n * 1e-6 * 2) << n;
    }
  }
}

TEST(Predict, InnerAngles) {
  // Units of pi / 2^15; atan is approximated within 0.004.
  const auto expectAngle = [](Vec3 a, Vec3 b, double radians) {
    const Angle angle = innerAngle({0, 0, 0}, a, b);
    EXPECT_NEAR(static_cast<double>(angle.value) * 3.14159265 / 32768, radians, 0.005);
    EXPECT_NEAR(static_cast<double>(angle.cotangent) / 4096, std::clamp(1 / std::tan(radians), -64.0, 64.0), 0.02);
  };
  expectAngle({1000, 0, 0}, {0, 1000, 0}, 3.14159265 / 2);
  expectAngle({1000, 0, 0}, {1000, 1000, 0}, 3.14159265 / 4);
  expectAngle({1000, 0, 0}, {-1000, 1000, 0}, 3.14159265 * 3 / 4);
  expectAngle({1000000, 0, 0}, {500000, 866025, 0}, 3.14159265 / 3);
  expectAngle({67108863, 0, 0}, {33554432, 0, -58117980}, 3.14159265 / 3);
  EXPECT_EQ(innerAngle({1, 1, 1}, {1, 1, 1}, {5, 5, 5}).value, 0);
  EXPECT_EQ(innerAngle({0, 0, 0}, {3, 3, 3}, {5, 5, 5}).cotangent, 0) << "no triangle";
}

TEST(Predict, Cotangents) {
  for (int degrees = 10; degrees <= 170; ++degrees) {
    const double radians = degrees * 3.14159265 / 180;
    EXPECT_NEAR(static_cast<double>(cotangentOf(degrees * 32768 / 180)) / 4096, 1 / std::tan(radians),
                0.02 * (1 + std::abs(1 / std::tan(radians))))
        << degrees;
  }
}

TEST(Predict, WeightedIsTheParallelogramOnRegularValences) {
  // An equilateral base, and thirds of a half turn expected everywhere: eq. 3 and 4 give w1 = w2 = 1.
  const Vec3 left(0, 0, 0), right(100000, 0, 0), base(50000, -86603, 0);
  const std::int64_t third = kHalfTurn / 3;
  const Vec3 weighted = weightedParallelogram(left, right, base, {third, third, kHalfTurn - 2 * third});
  const Vec3 expected = parallelogram(left, right, base);
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(weighted[a], expected[a], 400) << "within 0.4% of an edge";
}

TEST(Predict, WeightedFollowsTheExpectedAngles) {
  // Right angle expected at the left vertex: the tip stands above it.
  const Vec3 left(0, 0, 0), right(100000, 0, 0), base(50000, -86603, 0);
  const Vec3 tip = weightedParallelogram(left, right, base, {kHalfTurn / 2, kHalfTurn / 4, kHalfTurn / 4});
  EXPECT_NEAR(tip.x, 0, 2000);
  EXPECT_NEAR(tip.y, 100000, 2000);
  EXPECT_EQ(tip.z, 0);
}

TEST(Predict, WeightedFallsBackWhereAnglesGiveNoTriangle) {
  const Vec3 left(0, 0, 0), right(1000, 0, 0), base(500, -800, 0);
  EXPECT_EQ(weightedParallelogram(left, right, base, {kHalfTurn - 256, 256, 0}), parallelogram(left, right, base));
}

TEST(Predict, ExpectedAnglesByValence) {
  const Surface surface = test::torus(4, 4);
  std::vector<VertexState> states(surface.vertexCount());
  for (VertexState& state : states) state.valence = 6;
  std::vector<std::uint8_t> known(surface.vertexCount(), 0);
  const Stencil stencil{0, 1, 2};
  ExpectedAngles angles = expectedAngles(surface, states, known, 6, stencil, false);
  EXPECT_NEAR(static_cast<double>(angles.left), kHalfTurn / 3.0, 2);
  EXPECT_NEAR(static_cast<double>(angles.right), kHalfTurn / 3.0, 2);
  EXPECT_EQ(angles.left + angles.right + angles.tip, kHalfTurn);
  // Valences 4, 8, 8: pi/2, pi/4, pi/4 already sum to a half turn.
  states[0].valence = 4;
  states[1].valence = 8;
  angles = expectedAngles(surface, states, known, 8, stencil, false);
  EXPECT_EQ(angles.left, kHalfTurn / 2);
  EXPECT_EQ(angles.right, kHalfTurn / 4);
}

}  // namespace
}  // namespace tsc
