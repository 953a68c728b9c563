#include <gtest/gtest.h>

#include <limits>

#include "meshes.h"

namespace tsc {
namespace {

using namespace test;

TEST(VertexErrors, OfATranslatedCube) {
  const MeshArrays cube = unitCube(), moved = translated(cube, 1, 2, -2);
  const auto errors = vertexErrors(cube.positions, moved.positions);
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->count, 8u);
  EXPECT_DOUBLE_EQ(errors->mse, 9);
  EXPECT_DOUBLE_EQ(errors->rms, 3);
  EXPECT_DOUBLE_EQ(errors->max, 3);
}

TEST(VertexErrors, OfOneMovedVertex) {
  const MeshArrays cube = unitCube();
  MeshArrays moved = cube;
  moved.positions[3 * 5 + 1] += 0.5;
  const auto errors = vertexErrors(cube.positions, moved.positions);
  ASSERT_TRUE(errors);
  EXPECT_DOUBLE_EQ(errors->mse, 0.25 / 8);
  EXPECT_DOUBLE_EQ(errors->max, 0.5);
  EXPECT_EQ(errors->worst_vertex, 5u);
}

TEST(VertexErrors, BetweenFloatAndDoubleAndInAnotherOrder) {
  const std::vector<double> a = {0, 0, 0, 1, 0, 0};
  const std::vector<float> b = {1, 0, 0, 0, 0, 2};
  const std::vector<std::uint32_t> order = {1, 0};
  const auto errors = vertexErrors(a, b, order);
  ASSERT_TRUE(errors);
  EXPECT_DOUBLE_EQ(errors->mse, 2);
  EXPECT_EQ(errors->worst_vertex, 0u);
}

TEST(VertexErrors, RefuseWhatCannotBeMeasured) {
  const std::vector<double> one = {0, 0, 0}, two = {0, 0, 0, 1, 1, 1}, none;
  const std::vector<double> nan = {0, std::numeric_limits<double>::quiet_NaN(), 0};
  const std::vector<std::uint32_t> past = {7};
  EXPECT_EQ(vertexErrors(one, two).error().code, QualityErrorCode::kCountMismatch);
  EXPECT_EQ(vertexErrors(none, none).error().code, QualityErrorCode::kNoFaces);
  EXPECT_EQ(vertexErrors(one, nan).error().code, QualityErrorCode::kNonFinitePosition);
  EXPECT_EQ(vertexErrors(one, one, past).error().code, QualityErrorCode::kInvalidIndex);
}

TEST(BoundingBox, LeavesOutUnusedVertices) {
  MeshArrays cube = unitCube();
  cube.positions.insert(cube.positions.end(), {100, 100, 100});
  EXPECT_DOUBLE_EQ(boundingBoxDiagonal(cube.view()), std::sqrt(3.0));
}

}  // namespace
}  // namespace tsc
