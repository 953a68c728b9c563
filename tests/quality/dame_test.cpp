#include <gtest/gtest.h>

#include <limits>

#include "meshes.h"

namespace tsc {
namespace {

using namespace test;
constexpr double kPi = std::numbers::pi;

TEST(Dame, OfAFoldedFlatEdge) {
  const auto error = dame(hinge(0).view(), hinge(0.3).positions);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->edges, 1u);
  EXPECT_NEAR(error->value, 100 * 0.3, 1e-9);  // flat edges weigh exp(ln 100)
}

TEST(Dame, OfAFlattenedFoldIsMaskedByTheFold) {
  const auto error = dame(hinge(kPi / 2).view(), hinge(0).positions);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->value, kPi / 2 * std::pow(100, 0.25), 1e-9);
}

TEST(Dame, AnglesAreOriented) {
  const auto error = dame(hinge(0.4).view(), hinge(-0.4).positions);
  ASSERT_TRUE(error);
  const double flatness = (kPi - 0.4) / kPi;
  EXPECT_NEAR(error->value, 0.8 * std::pow(100, flatness * flatness), 1e-9);
}

TEST(Dame, OfAMovedCubeIsNothing) {
  const MeshArrays cube = unitCube();
  const auto error = dame(cube.view(), translated(cube, 0.5, 0.25, 2).positions);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->edges, 18u);
  EXPECT_EQ(error->value, 0);
}

TEST(Dame, SeesEdgesThroughSeams) {
  const auto error = dame(soup(hinge(0)).view(), soup(hinge(0.3)).positions);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->edges, 1u);
  EXPECT_NEAR(error->value, 30, 1e-9);
}

TEST(Dame, LeavesOutEdgesOfCollapsedTriangles) {
  MeshArrays collapsed = hinge(0);
  std::copy_n(&collapsed.positions[0], 3, &collapsed.positions[9]);
  const auto error = dame(hinge(0).view(), collapsed.positions);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->edges, 0u);
  EXPECT_EQ(error->skipped_edges, 1u);
}

TEST(Dame, LeavesOutEdgesOfInconsistentOrientation) {
  MeshArrays mesh = hinge(0);
  std::swap(mesh.indices[4], mesh.indices[5]);
  const auto error = dame(mesh.view(), hinge(0.3).positions);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->edges + error->skipped_edges, 0u);
}

TEST(Dame, FollowsACorrespondence) {
  const Shuffled other = shuffled(hinge(0.3), 3);
  const auto error = dame(hinge(0).view(), other.mesh.positions, other.new_of_old);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->value, 30, 1e-9);
}

TEST(Dame, RefusesWhatCannotBeMeasured) {
  const MeshArrays cube = unitCube();
  MeshArrays nan = cube;
  nan.positions[4] = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> few = {0, 0, 0};
  EXPECT_EQ(dame(cube.view(), few).error().code, QualityErrorCode::kCountMismatch);
  EXPECT_EQ(dame(cube.view(), nan.positions).error().code, QualityErrorCode::kNonFinitePosition);
  EXPECT_EQ(dame(nan.view(), cube.positions).error().code, QualityErrorCode::kNonFinitePosition);
  EXPECT_EQ(dame({cube.positions, {}}, cube.positions).error().code, QualityErrorCode::kNoFaces);
}

}  // namespace
}  // namespace tsc
