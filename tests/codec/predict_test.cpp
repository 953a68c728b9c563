#include "predict.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "surface_builders.h"

namespace tsc {
namespace {

Integers lanes(int x, int y, int z) { return Integers{x, y, z, 0}; }

TEST(Predict, Parallelogram) {
  EXPECT_EQ(vectorOf(parallelogram(lanes(1, 2, 3), lanes(10, 20, 30), lanes(4, 5, 6))), Vec3(7, 17, 27));
}

/// As the position coder calls it: beyond their count, candidates repeat the first.
Vec3 averageOf(std::array<Integers, 3> candidates, int count) {
  for (std::size_t j = static_cast<std::size_t>(count); j < 3; ++j) candidates[j] = candidates[0];
  return vectorOf(average(candidates, count));
}

TEST(Predict, AverageIsExactWhereAllAgreeAndRoundedElsewhere) {
  const Integers same = lanes(123456, -7, 67108864);
  for (int n = 1; n <= kMaxStencils; ++n) EXPECT_EQ(averageOf({same, same, same}, n), vectorOf(same));
  EXPECT_EQ(averageOf({lanes(0, 0, 0), lanes(10, -10, 7), lanes(99, 99, 99)}, 2), Vec3(5, -5, 4)) << "halves up";
  EXPECT_EQ(averageOf({lanes(0, 0, 0), lanes(4, 1, -1), lanes(4, 1, -1)}, 3), Vec3(2, 1, 0)) << "of three, halves up";
  std::mt19937 random(1);
  for (int i = 0; i < 10000; ++i) {
    std::array<Integers, 3> candidates;
    for (Integers& c : candidates) {
      // Positions are within +-2^27.
      const auto coordinate = [&] { return static_cast<int>(random() % (6u << 27)) - (3 << 27); };
      const int x = coordinate(), y = coordinate();
      c = lanes(x, y, coordinate());
    }
    const Vec3 two = averageOf(candidates, 2), three = averageOf(candidates, 3);
    EXPECT_EQ(averageOf(candidates, 1), vectorOf(candidates[0]));
    for (int a = 0; a < 3; ++a) {
      const double first = candidates[0][a], second = candidates[1][a], third = candidates[2][a];
      ASSERT_EQ(two[a], std::floor((first + second) / 2 + 0.5));
      ASSERT_EQ(three[a], std::floor((2 * first + second + third) / 4 + 0.5)) << "the first counts twice";
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
  const WideVec3 weighted = weightedParallelogram(left, right, base, {third, third, kHalfTurn - 2 * third});
  const Vec3 expected = left + right - base;
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(weighted[a], expected[a], 400) << "within 0.4% of an edge";
}

TEST(Predict, WeightedFollowsTheExpectedAngles) {
  // Right angle expected at the left vertex: the tip stands above it.
  const Vec3 left(0, 0, 0), right(100000, 0, 0), base(50000, -86603, 0);
  const WideVec3 tip = weightedParallelogram(left, right, base, {kHalfTurn / 2, kHalfTurn / 4, kHalfTurn / 4});
  EXPECT_NEAR(tip.x, 0, 2000);
  EXPECT_NEAR(tip.y, 100000, 2000);
  EXPECT_EQ(tip.z, 0);
}

TEST(Predict, WeightedFallsBackWhereAnglesGiveNoTriangle) {
  const Vec3 left(0, 0, 0), right(1000, 0, 0), base(500, -800, 0);
  EXPECT_EQ(weightedParallelogram(left, right, base, {kHalfTurn - 256, 256, 0}), WideVec3(left + right - base));
}

TEST(Predict, WeightedOfFarVerticesExceeds32Bits) {
  // A gate across all of the lattice, high above the base, and nearly right angles at both ends.
  const int most = (1 << 27) - 1;
  const Vec3 left(-most, most, 0), right(most, most, 0), base(0, -most, 0);
  const std::int64_t angle = kHalfTurn / 2 - 500;
  const WideVec3 tip = weightedParallelogram(left, right, base, {angle, angle, kHalfTurn - 2 * angle});
  // Height of the new triangle: half the gate over the cotangent.
  const double height = most / (static_cast<double>(cotangentOf(angle)) / 4096);
  EXPECT_GT(height, std::ldexp(1.0, 31));
  EXPECT_NEAR(static_cast<double>(tip.y), most + height, 0.01 * height);
  EXPECT_NEAR(static_cast<double>(tip.x), 0, 0.01 * height);
}

/// A torus whose vertices are coded in the order of their numbers, or another.
class ExpectedAnglesTest : public testing::Test {
 protected:
  ExpectedAnglesTest() : surface_(test::torus(4, 4)), states_(surface_.vertexCount()) {
    map_ = {std::vector<std::uint32_t>(surface_.vertexCount()), surface_.vertexCount()};
    std::iota(map_.vertex_position.begin(), map_.vertex_position.end(), 0);
    for (std::uint32_t v = 0; v < surface_.vertexCount(); ++v) {
      states_[v].point = Integers{static_cast<int>(v % 4) * 1000, static_cast<int>(v / 4) * 1000, 0, 6};
    }
  }
  ExpectedAngles expected(std::uint32_t time, std::uint32_t face, std::int32_t valence, bool use_known) const {
    return expectedAngles({codingOrder(surface_, map_, Order::kTraversal), states_}, time, face, valence, use_known);
  }

  Surface surface_;
  PositionMap map_;
  std::vector<VertexState> states_;
};

TEST_F(ExpectedAnglesTest, ByValence) {
  // Face 0: the gate is 0-1, the vertex 5.
  ExpectedAngles angles = expected(5, 0, 6, false);
  EXPECT_NEAR(static_cast<double>(angles.left), kHalfTurn / 3.0, 2);
  EXPECT_NEAR(static_cast<double>(angles.right), kHalfTurn / 3.0, 2);
  EXPECT_EQ(angles.left + angles.right + angles.tip, kHalfTurn);
  // Valences 4, 8, 8: pi/2, pi/4, pi/4 already sum to a half turn.
  states_[0].point[3] = 4;
  states_[1].point[3] = 8;
  angles = expected(5, 0, 8, false);
  EXPECT_EQ(angles.left, kHalfTurn / 2);
  EXPECT_EQ(angles.right, kHalfTurn / 4);
}

TEST_F(ExpectedAnglesTest, ValencesBeyondAByteMakeNoDifference) {
  const ExpectedAngles most = expected(5, 0, 255, false), more = expected(5, 0, 1 << 28, false);
  EXPECT_EQ(most.left, more.left);
  EXPECT_EQ(most.tip, more.tip);
  const ExpectedAngles least = expected(5, 0, 3, false), less = expected(5, 0, 1, false);
  EXPECT_EQ(least.left, less.left);
}

TEST_F(ExpectedAnglesTest, KnownTrianglesLeaveTheRest) {
  // All but vertex 10 known, in a plane of squares: at each end of its gate 5-6 two of six angles are left. Those two
  // are 90 + 45 or 45 + 90 degrees.
  std::swap(map_.vertex_position[10], map_.vertex_position[15]);
  std::swap(states_[10].point, states_[15].point);
  std::uint32_t face = 0;
  for (std::uint32_t c = 0; c < surface_.corner_vertex.size(); ++c) {
    const bool gate = surface_.corner_vertex[nextCorner(c)] == 5 && surface_.corner_vertex[previousCorner(c)] == 6;
    if (surface_.corner_vertex[c] == 10 && gate) face = c - c % 3;
  }
  ASSERT_NE(face, 0u);
  const ExpectedAngles angles = expected(15, face, 6, true);
  // Left: 360 - 4 known; right likewise; the tip a sixth of a turn.
  const double left = static_cast<double>(angles.left), right = static_cast<double>(angles.right);
  EXPECT_EQ(angles.left + angles.right + angles.tip, kHalfTurn);
  EXPECT_GT(left + right, kHalfTurn / 2.0);
}

}  // namespace
}  // namespace tsc
