#include <gtest/gtest.h>

#include "meshes.h"

namespace tsc {
namespace {

using namespace test;

TEST(MatchVertices, FindsAShuffledMesh) {
  const MeshArrays torus = bumpyTorus(40, 20);
  const Shuffled other = shuffled(torus);
  const auto match = matchVertices(torus.view(), other.mesh.view());
  ASSERT_TRUE(match);
  EXPECT_EQ(match->level, Correspondence::Level::kVertices);
  EXPECT_EQ(match->b_of_a, other.new_of_old);
}

TEST(MatchVertices, FindsItThroughErrorsNearTheEdgeLength) {
  // Edges are about 0.1 long.
  const MeshArrays torus = bumpyTorus(60, 20);
  for (const double size : {0.001, 0.01, 0.03, 0.05}) {
    const Shuffled other = shuffled(jittered(torus, size));
    const auto match = matchVertices(torus.view(), other.mesh.view());
    ASSERT_TRUE(match) << size;
    EXPECT_EQ(match->b_of_a, other.new_of_old) << size;
  }
}

TEST(MatchVertices, FindsItWhereRoundingMergesPoints) {
  const MeshArrays torus = bumpyTorus(80, 40);
  const Shuffled other = shuffled(quantized(torus, 0.06));
  const auto match = matchVertices(torus.view(), other.mesh.view());
  ASSERT_TRUE(match);
  EXPECT_EQ(match->b_of_a, other.new_of_old);
}

TEST(MatchVertices, TakesTheOrderAsItStandsForAFarTranslation) {
  const MeshArrays cube = unitCube(), far = translated(cube, 50, 0, 0);
  const auto match = matchVertices(cube.view(), far.view());
  ASSERT_TRUE(match);
  for (std::uint32_t v = 0; v < 8; ++v) EXPECT_EQ(match->b_of_a[v], v);
}

TEST(MatchVertices, ChoosesTheSmallestErrorAmongSymmetries) {
  const MeshArrays cube = unitCube();
  const Shuffled other = shuffled(translated(cube, 0.3, 0.1, 0), 7);
  const auto match = matchVertices(cube.view(), other.mesh.view());
  ASSERT_TRUE(match);
  EXPECT_EQ(match->b_of_a, other.new_of_old);
}

TEST(MatchVertices, MatchesShuffledSoups) {
  const MeshArrays torus = soup(bumpyTorus(20, 10));
  const Shuffled other = shuffled(quantized(torus, 0.001));
  const auto match = matchVertices(torus.view(), other.mesh.view());
  ASSERT_TRUE(match);
  EXPECT_EQ(match->b_of_a, other.new_of_old);
}

TEST(MatchVertices, MatchesPointsWhereTablesAreSplitDifferently) {
  const MeshArrays torus = bumpyTorus(20, 10), split = soup(jittered(torus, 1e-3));
  const auto match = matchVertices(torus.view(), split.view());
  ASSERT_TRUE(match);
  EXPECT_EQ(match->level, Correspondence::Level::kPoints);
  EXPECT_EQ(match->representatives.size(), torus.vertexCount());
  const auto back = matchVertices(split.view(), torus.view());
  ASSERT_TRUE(back);
  EXPECT_EQ(back->representatives.size(), torus.vertexCount());
}

TEST(MatchVertices, CopesWithFansDuplicatesAndDegenerateTriangles) {
  // Three triangles on one edge, one of them twice, one triangle naming a vertex twice, one unused vertex.
  MeshArrays mesh = hinge(0);
  mesh.positions.insert(mesh.positions.end(), {0, 0.5, 1, 9, 9, 9});
  mesh.indices.insert(mesh.indices.end(), {0, 1, 4, 0, 1, 4, 2, 2, 3});
  const Shuffled other = shuffled(jittered(mesh, 0.01), 4);
  const auto match = matchVertices(mesh.view(), other.mesh.view());
  ASSERT_TRUE(match);
  for (std::uint32_t v = 0; v < 5; ++v) EXPECT_EQ(match->b_of_a[v], other.new_of_old[v]);
  EXPECT_EQ(match->b_of_a[5], kUnmatchedVertex);
}

TEST(MatchVertices, SaysWhenConnectivityDiffers) {
  const MeshArrays torus = bumpyTorus(20, 10);
  MeshArrays flipped = torus;  // one edge turned the other way: the same counts
  flipped.indices[2] = flipped.indices[5];
  flipped.indices[3] = flipped.indices[1];
  EXPECT_EQ(matchVertices(torus.view(), flipped.view()).error().code, QualityErrorCode::kConnectivityDiffers);
  MeshArrays fewer = torus;
  fewer.indices.resize(fewer.indices.size() - 3);
  EXPECT_EQ(matchVertices(torus.view(), fewer.view()).error().code, QualityErrorCode::kConnectivityDiffers);
  MeshArrays inside_out = torus;
  for (std::size_t i = 0; i < inside_out.indices.size(); i += 3)
    std::swap(inside_out.indices[i], inside_out.indices[i + 1]);
  EXPECT_EQ(matchVertices(torus.view(), inside_out.view()).error().code, QualityErrorCode::kConnectivityDiffers);
  EXPECT_EQ(matchVertices(soup(unitCube()).view(), soup(translated(hinge(0), 9, 9, 9)).view()).error().code,
            QualityErrorCode::kConnectivityDiffers);
}

TEST(MatchVertices, DoesNotPairSoupsThatAreElsewhere) {
  MeshArrays a = soup(unitCube()), b = a;
  std::mt19937 random(3);
  for (double& x : b.positions) x = 5 + static_cast<double>(random() % 1000) / 300;
  EXPECT_EQ(matchVertices(a.view(), b.view()).error().code, QualityErrorCode::kConnectivityDiffers);
}

}  // namespace
}  // namespace tsc
