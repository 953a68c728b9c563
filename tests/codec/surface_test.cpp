#include "surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "meshes.h"
#include "surface_checks.h"

namespace tsc {
namespace {

CutMesh cut(const meshes::Triangles& mesh) { return cutToManifold(mesh.positions, mesh.indices); }

std::uint32_t dummyCount(const CutMesh& cut) { return cut.surface.dummy_count; }

std::uint32_t realVertexCount(const CutMesh& cut) { return cut.surface.vertexCount() - dummyCount(cut); }

/// Every input face is in the surface with its own corners, or a side face for a reason.
void expectFaithful(const meshes::Triangles& mesh, const CutMesh& cut) {
  expectClosedManifold(cut.surface);
  ASSERT_EQ(cut.input_face.size(), cut.surface.faceCount());
  ASSERT_EQ(cut.welded_vertex.size(), cut.surface.vertexCount());
  std::vector<std::array<std::uint32_t, 3>> kept;
  std::vector<std::uint8_t> is_met(mesh.faceCount(), 0);
  for (std::uint32_t face = 0; face < cut.surface.faceCount(); ++face) {
    const std::uint32_t input = cut.input_face[face];
    bool has_dummy = false;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = cut.surface.corner_vertex[3 * face + k];
      has_dummy |= cut.surface.isDummy(vertex);
      ASSERT_EQ(cut.surface.isDummy(vertex), cut.welded_vertex[vertex] == kNone);
      if (input != kNone) {
        ASSERT_EQ(cut.welded_vertex[vertex], mesh.indices[3 * input + k]);
      }
    }
    ASSERT_EQ(has_dummy, input == kNone);
    if (input == kNone) continue;
    ASSERT_EQ(is_met[input]++, 0);
    std::array<std::uint32_t, 3> triple = {mesh.indices[3 * input], mesh.indices[3 * input + 1],
                                           mesh.indices[3 * input + 2]};
    std::rotate(triple.begin(), std::min_element(triple.begin(), triple.end()), triple.end());
    kept.push_back(triple);
  }
  std::sort(kept.begin(), kept.end());
  ASSERT_EQ(std::adjacent_find(kept.begin(), kept.end()), kept.end()) << "a duplicate stayed in the surface";
  for (const std::uint32_t input : cut.side_faces) {
    ASSERT_EQ(is_met[input]++, 0);
    std::array<std::uint32_t, 3> triple = {mesh.indices[3 * input], mesh.indices[3 * input + 1],
                                           mesh.indices[3 * input + 2]};
    if (triple[0] == triple[1] || triple[1] == triple[2] || triple[2] == triple[0]) continue;
    std::rotate(triple.begin(), std::min_element(triple.begin(), triple.end()), triple.end());
    ASSERT_TRUE(std::binary_search(kept.begin(), kept.end(), triple)) << "face " << input << " is no duplicate";
  }
  ASSERT_EQ(std::count(is_met.begin(), is_met.end(), 1), mesh.faceCount());
}

TEST(Weld, JoinsEqualPositionsOverAllTables) {
  const std::vector<float> a = {1, 2, 3, 0, 0, 0, 1, 2, 3};
  const std::vector<float> b = {-0.0f, 0, -0.0f, 5, 5, 5, 1, 2, 3};
  const std::vector<std::uint32_t> a_indices = {0, 1, 2};
  const std::vector<std::uint32_t> b_indices = {2, 1, 0};
  Mesh mesh;
  mesh.tables = {{a}, {b}};
  mesh.primitives = {{1, b_indices}, {0, a_indices}};
  const WeldResult result = weld(mesh);
  EXPECT_EQ(result.mesh.positions, (std::vector<float>{1, 2, 3, 0, 0, 0, 5, 5, 5}));
  EXPECT_FALSE(std::signbit(result.mesh.positions[3]));
  ASSERT_EQ(result.table_vertex_to_welded.size(), 2u);
  EXPECT_EQ(result.table_vertex_to_welded[0], (std::vector<std::uint32_t>{0, 1, 0}));
  EXPECT_EQ(result.table_vertex_to_welded[1], (std::vector<std::uint32_t>{1, 2, 0}));
  EXPECT_EQ(result.mesh.corner_vertex, (std::vector<std::uint32_t>{0, 2, 1, 0, 1, 0}));
}

TEST(Weld, KeepsNearlyEqualPositionsApart) {
  const float tiny = std::numeric_limits<float>::denorm_min();
  const std::vector<float> positions = {0, 0, 0, tiny, 0, 0, -tiny, 0, 0};
  Mesh mesh;
  mesh.tables = {{positions}};
  EXPECT_EQ(weld(mesh).mesh.positions.size(), 9u);
}

TEST(Weld, Empty) {
  const WeldResult result = weld({});
  EXPECT_TRUE(result.mesh.positions.empty());
  EXPECT_TRUE(result.table_vertex_to_welded.empty());
}

TEST(Cut, KeepsEveryFaceOfEverySample) {
  for (const auto& [name, mesh] : meshes::samples()) {
    SCOPED_TRACE(name);
    expectFaithful(mesh, cut(mesh));
  }
}

TEST(Cut, KeepsEveryFaceOfRandomSoups) {
  for (std::uint32_t seed = 0; seed < 1500; ++seed) {
    SCOPED_TRACE(seed);
    const meshes::Triangles mesh = meshes::soup(3 + seed % 40, 1 + seed * 7 % 120, seed);
    expectFaithful(mesh, cut(mesh));
    if (HasFatalFailure()) return;
  }
}

TEST(Cut, ClosedManifoldStaysWhole) {
  for (const meshes::Triangles& mesh : {meshes::torus(5, 8), meshes::sphere(6, 9), meshes::tetrahedron()}) {
    const CutMesh result = cut(mesh);
    EXPECT_EQ(result.surface.vertexCount(), mesh.vertexCount());
    EXPECT_EQ(result.surface.faceCount(), mesh.faceCount());
    EXPECT_EQ(dummyCount(result), 0u);
  }
}

TEST(Cut, HoleGetsOneDummy) {
  const CutMesh result = cut(meshes::grid(4, 3));
  EXPECT_EQ(dummyCount(result), 1u);
  EXPECT_EQ(result.surface.faceCount(), 24u + 14u);
}

TEST(Cut, TwoSidedGeometryBecomesTwoSheets) {
  const meshes::Triangles sheet = meshes::grid(6, 5);
  const CutMesh result = cut(meshes::twoSided(sheet));
  EXPECT_EQ(dummyCount(result), 2u);
  EXPECT_EQ(realVertexCount(result), 2 * sheet.vertexCount());
  EXPECT_TRUE(result.side_faces.empty());
}

TEST(Cut, MoebiusStripIsCutOnce) {
  const CutMesh result = cut(meshes::moebiusStrip(20));
  EXPECT_EQ(realVertexCount(result), 42u);
  EXPECT_EQ(dummyCount(result), 1u);
}

TEST(Cut, BookPairsFlattestPages) {
  // A cross of four pages, opposite ones continuing each other.
  const meshes::Triangles cross = {{0, 0, 0, 0, 0, 1, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0},
                                   {0, 1, 2, 1, 0, 3, 0, 1, 4, 1, 0, 5}};
  const CutMesh result = cut(cross);
  EXPECT_EQ(dummyCount(result), 2u);
  ASSERT_EQ(result.surface.opposite[2], 5u);
  ASSERT_EQ(result.surface.opposite[8], 11u);
}

TEST(Cut, VertexSharedByTwoUmbrellasIsSplit) {
  const meshes::Triangles bowtie = {{0, 0, 0, 1, 0, 0, 1, 1, 0, -1, 0, 0, -1, -1, 0}, {0, 1, 2, 0, 3, 4}};
  const CutMesh result = cut(bowtie);
  EXPECT_EQ(realVertexCount(result), 6u);
  EXPECT_EQ(dummyCount(result), 2u);
}

TEST(Cut, DegenerateAndDuplicateFacesAreSetAside) {
  const meshes::Triangles mesh = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 1, 0, 1, 2, 1, 2, 0, 2, 2, 2, 2, 0, 1}};
  const CutMesh result = cut(mesh);
  EXPECT_EQ(result.side_faces, (std::vector<std::uint32_t>{0, 2, 3, 4}));
  EXPECT_EQ(result.input_face[0], 1u);
}

TEST(Cut, ThickBookTakesNoQuadraticTime) {
  // 20,000 faces on one edge: all pairs would be 10^8.
  const meshes::Triangles mesh = meshes::book(20000);
  const CutMesh result = cut(mesh);
  expectClosedManifold(result.surface);
  EXPECT_EQ(realVertexCount(result), mesh.vertexCount() - 2 + 2 * 10000);
}

}  // namespace
}  // namespace tsc
