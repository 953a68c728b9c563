#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "meshes.h"

namespace tsc {
namespace {

using namespace test;

Measured<Comparison> compare(const std::vector<NamedSurface>& a, const std::vector<NamedSurface>& b) {
  return compareScenes(a, b);
}

TEST(CompareScenes, OfATranslatedAndShuffledCube) {
  const MeshArrays cube = unitCube();
  const auto result = compare({cube.named("cube")}, {shuffled(translated(cube, 0.25, 0, 0)).mesh.named()});
  ASSERT_TRUE(result);
  const MeshComparison& mesh = result->meshes.at(0);
  EXPECT_EQ(mesh.name, "cube");
  EXPECT_DOUBLE_EQ(mesh.vertices->mse, 0.0625);
  EXPECT_DOUBLE_EQ(mesh.vertices->max, 0.25);
  EXPECT_DOUBLE_EQ(mesh.diagonal, std::sqrt(3.0));
  EXPECT_NEAR(mesh.metro.hausdorff(), 0.25, 1e-12);
  EXPECT_EQ(mesh.dame->value, 0);
  EXPECT_DOUBLE_EQ(result->total.vertices->mse, 0.0625);
}

TEST(CompareScenes, TotalsWeighMeshesByTheirSize) {
  const MeshArrays cube = unitCube(), torus = bumpyTorus(16, 12);
  const auto result = compare({cube.named(), torus.named()},
                              {translated(cube, 0.5, 0, 0).named(), translated(torus, 0, 0, 0.1).named()});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->total.vertices->count, 200u);
  EXPECT_NEAR(result->total.vertices->mse, (8 * 0.25 + 192 * 0.01) / 200, 1e-12);
  EXPECT_NEAR(result->total.vertices->max, 0.5, 1e-12);
  EXPECT_EQ(result->total.dame->edges, 18u + 3 * 192u);
}

TEST(CompareScenes, LeavesOutWhatConnectivityDoesNotAllow) {
  const MeshArrays cube = unitCube();
  MeshArrays open = cube;
  open.indices.resize(33);
  const auto result = compare({cube.named()}, {open.named()});
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->meshes[0].vertices);
  EXPECT_FALSE(result->meshes[0].dame);
  EXPECT_FALSE(result->total.vertices);
  EXPECT_GT(result->meshes[0].metro.hausdorff(), 0.28);  // the radius of the incircle of the missing half square
  const auto json = nlohmann::json::parse(comparisonJson(*result));
  EXPECT_TRUE(json["meshes"][0]["vertexErrors"].is_null());
  EXPECT_TRUE(json["total"]["dame"].is_null());
  EXPECT_EQ(json["meshes"][0]["connectivity"], "differs");
  EXPECT_NE(comparisonTable(*result).find("connectivity differs"), std::string::npos);
}

TEST(CompareScenes, JsonAndTableCarryTheFigures) {
  const MeshArrays cube = unitCube();
  const auto result = compare({cube.named("a \xff name")}, {translated(cube, 0.25, 0, 0).named()});
  ASSERT_TRUE(result);
  const auto json = nlohmann::json::parse(comparisonJson(*result));
  EXPECT_EQ(json["meshes"][0]["vertexErrors"]["mse"], 0.0625);
  EXPECT_DOUBLE_EQ(json["total"]["vertexErrors"]["maxRelative"], 0.25 / std::sqrt(3.0));
  EXPECT_EQ(json["total"]["dame"]["edges"], 18);
  EXPECT_NE(comparisonTable(*result).find("0.0625"), std::string::npos);
}

TEST(CompareScenes, RefusesWhatCannotBeMeasured) {
  const MeshArrays cube = unitCube();
  MeshArrays nan = cube, none = cube;
  nan.positions[0] = std::numeric_limits<double>::quiet_NaN();
  none.indices.clear();
  EXPECT_EQ(compare({cube.named()}, {}).error().code, QualityErrorCode::kCountMismatch);
  EXPECT_EQ(compare({}, {}).error().code, QualityErrorCode::kNoFaces);
  EXPECT_EQ(compare({cube.named()}, {nan.named()}).error().code, QualityErrorCode::kNonFinitePosition);
  const auto refused = compare({none.named("blob")}, {cube.named()});
  EXPECT_EQ(refused.error().code, QualityErrorCode::kNoFaces);
  EXPECT_EQ(refused.error().message, "mesh \"blob\": first file: the mesh has no faces");
}

TEST(VertexErrorField, IsInTheOrderOfB) {
  const MeshArrays cube = unitCube();
  MeshArrays moved = cube;
  moved.positions[3 * 6 + 2] += 0.25;
  const Shuffled other = shuffled(moved, 2);
  const NamedSurface a = cube.named(), b = other.mesh.named();
  const auto result = compareScenes(std::span(&a, 1), std::span(&b, 1));
  ASSERT_TRUE(result);
  const auto field = vertexErrorField(a, b, result->meshes[0]);
  ASSERT_TRUE(field);
  for (std::uint32_t v = 0; v < 8; ++v) EXPECT_EQ((*field)[other.new_of_old[v]], v == 6 ? 0.25 : 0.0);
}

}  // namespace
}  // namespace tsc
