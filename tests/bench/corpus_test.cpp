// Meshes made for measuring.
#include "corpus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace tsc::bench {
namespace {

TEST(MakePlane, liesInThePlane) {
  const BenchMesh plane = makePlane(10, 17.5);
  EXPECT_EQ(plane.vertexCount(), 100u);
  EXPECT_EQ(plane.faceCount(), 162u);
  const double tangent = std::tan(17.5 * 3.14159265358979323846 / 180);
  for (std::size_t i = 0; i < plane.positions.size(); i += 3) {
    EXPECT_NEAR(plane.positions[i + 2], tangent * plane.positions[i + 1], 1e-6);
  }
}

TEST(Subdivide, quartersTriangles) {
  const BenchMesh plane = makePlane(5, 0), fine = subdivide(plane);
  EXPECT_EQ(fine.faceCount(), 4 * plane.faceCount());
  EXPECT_EQ(fine.vertexCount(), 25u + (25u + 32u - 1u));  // Euler: edges = vertices + faces - 1 of a disk
}

TEST(CutPatch, hasAboutTheVerticesWantedAndNoLooseOnes) {
  const BenchMesh patch = cutPatch(makePlane(50, 0), 300);
  EXPECT_GE(patch.vertexCount(), 300u);
  EXPECT_LE(patch.vertexCount(), 302u);
  std::vector<bool> used(patch.vertexCount());
  for (const auto index : patch.indices) {
    ASSERT_LT(index, patch.vertexCount());
    used[index] = true;
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
  EXPECT_EQ(cutPatch(makePlane(5, 0), 300).vertexCount(), 25u);
}

TEST(ContentKey, dependsOnPositionsAndIndices) {
  BenchMesh mesh = makePlane(5, 0);
  const std::string key = mesh.contentKey();
  std::swap(mesh.indices[0], mesh.indices[1]);
  EXPECT_NE(mesh.contentKey(), key);
  EXPECT_EQ(makePlane(5, 0).contentKey(), key);
}

TEST(SpreadSelection, takesFromEveryFolder) {
  std::vector<CorpusFile> files;
  for (int i = 0; i < 10; ++i) files.push_back({"a/" + std::to_string(i), 1});
  for (int i = 0; i < 3; ++i) files.push_back({"b/" + std::to_string(i), 1});
  const auto selection = spreadSelection(files, 6);
  ASSERT_EQ(selection.size(), 6u);
  EXPECT_EQ(std::count_if(selection.begin(), selection.end(), [](auto& f) { return f.path.parent_path() == "b"; }), 3);
}

TEST(EveryNth, takesAtLeastOneOfEveryFolder) {
  std::vector<CorpusFile> files;
  for (int i = 0; i < 10; ++i) files.push_back({"a/" + std::to_string(i), 1});
  files.push_back({"b/0", 1});
  const auto selection = everyNth(files, 4);
  ASSERT_EQ(selection.size(), 3u);
  EXPECT_EQ(selection[0].path, "a/2");
  EXPECT_EQ(selection[1].path, "a/6");
  EXPECT_EQ(selection[2].path, "b/0");
  EXPECT_EQ(everyNth(files, 1).size(), 11u);
}

TEST(DropUnusedVertices, keepsTheOthersInOrder) {
  BenchMesh mesh{.name = "m", .class_name = "c", .positions = {}, .indices = {1, 4, 3}};
  for (int v = 0; v < 6; ++v) mesh.positions.insert(mesh.positions.end(), {float(v), 0, float(v * v)});
  dropUnusedVertices(mesh);
  EXPECT_EQ(mesh.positions, (std::vector<float>{1, 0, 1, 3, 0, 9, 4, 0, 16}));
  EXPECT_EQ(mesh.indices, (std::vector<std::uint32_t>{0, 2, 1}));
  EXPECT_EQ(mesh.dropped_vertices, 3u);
  dropUnusedVertices(mesh);
  EXPECT_EQ(mesh.dropped_vertices, 3u);
  EXPECT_EQ(mesh.vertexCount(), 3u);
}

TEST(Loading, saysWhatIsWrong) {
  EXPECT_THROW(listFiles({"/nonexistent"}), std::runtime_error);
  const auto path = std::filesystem::temp_directory_path() / "tsc_bench_corpus_test.glb";
  std::ofstream(path) << "no glTF";
  try {
    loadMeshes(path);
    FAIL() << "a broken file was read";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos);
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace tsc::bench
