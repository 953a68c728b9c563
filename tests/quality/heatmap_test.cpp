#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "meshes.h"

namespace tsc {
namespace {

using namespace test;

struct Pair {
  std::vector<NamedSurface> a, b;
  Comparison comparison;
};

Pair bumpedPair() {
  const MeshArrays torus = bumpyTorus(24, 12);
  Pair pair{{torus.named("torus")}, {shuffled(jittered(torus, 0.01)).mesh.named("torus")}, {}};
  auto comparison = compareScenes(pair.a, pair.b);
  EXPECT_TRUE(comparison);
  pair.comparison = *std::move(comparison);
  return pair;
}

std::string contentOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(HeatmapGlb, HasColoursAndALegend) {
  Pair pair = bumpedPair();
  pair.b[0].placements = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1}};
  const auto path = std::filesystem::path(testing::TempDir()) / "tsc_quality_heatmap.glb";
  ASSERT_FALSE(writeHeatmapGlb(path, pair.a, pair.b, pair.comparison));
  const std::string glb = contentOf(path);
  ASSERT_EQ(glb.substr(0, 4), "glTF");
  std::uint32_t length = 0, json_length = 0;
  std::memcpy(&length, &glb[8], 4);
  std::memcpy(&json_length, &glb[12], 4);
  EXPECT_EQ(length, glb.size());
  const auto document = nlohmann::json::parse(glb.substr(20, json_length));
  EXPECT_EQ(document["scenes"][0]["name"].get<std::string>().substr(0, 12), "vertex error");
  const auto& primitive = document["meshes"][0]["primitives"][0];
  const auto& colours = document["accessors"][primitive["attributes"]["COLOR_0"].get<int>()];
  EXPECT_EQ(colours["count"], 288);
  EXPECT_EQ(colours["normalized"], true);
  EXPECT_EQ(document["nodes"][0]["matrix"][12], 5);
}

TEST(HeatmapPng, IsAPicture) {
  const Pair pair = bumpedPair();
  const auto path = std::filesystem::path(testing::TempDir()) / "tsc_quality_heatmap.png";
  ASSERT_FALSE(writeHeatmapPng(path, pair.a, pair.b, pair.comparison));
  const std::string png = contentOf(path);
  ASSERT_GT(png.size(), 10'000u);
  EXPECT_EQ(png.substr(1, 3), "PNG");
}

TEST(Heatmaps, SayWhenTheyCannotBeWritten) {
  const Pair pair = bumpedPair();
  EXPECT_EQ(writeHeatmapGlb("/nowhere/x.glb", pair.a, pair.b, pair.comparison)->code,
            QualityErrorCode::kUnreadableFile);
  EXPECT_EQ(writeHeatmapPng("/nowhere/x.png", pair.a, pair.b, pair.comparison)->code,
            QualityErrorCode::kUnreadableFile);
  EXPECT_EQ(writeHeatmapPng("/nowhere/x.png", pair.a, {}, pair.comparison)->code, QualityErrorCode::kCountMismatch);
}

}  // namespace
}  // namespace tsc
