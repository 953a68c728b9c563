// What is packed together, what stays, and why.
#include "mesh_groups.h"

#include <gtest/gtest.h>

#include "assets.h"

namespace tsc::test {
namespace {

using Indices = std::vector<std::uint32_t>;

TEST(MeshGroups, TrianglesOfStripsAndFans) {
  EXPECT_EQ(toTriangles(kTriangles, {0, 1, 2, 3}), (Indices{0, 1, 2}));
  EXPECT_EQ(toTriangles(kTriangleStrip, {0, 1, 2, 3, 4}), (Indices{0, 1, 2, 1, 3, 2, 2, 3, 4}));
  EXPECT_EQ(toTriangles(kTriangleFan, {0, 1, 2, 3}), (Indices{1, 2, 0, 2, 3, 0}));
  EXPECT_EQ(toTriangles(kTriangleStrip, {0, 1}), Indices{});
}

TEST(MeshGroups, PrimitivesOfAMeshAndMeshesOfATableGoTogether) {
  AssetBuilder builder;
  const std::size_t a = builder.addPositions(gridPositions(2));
  const std::size_t b = builder.addPositions(gridPositions(2, 5));
  const std::size_t c = builder.addPositions(gridPositions(2, 9));
  const std::size_t indices = builder.addIndices16(gridIndices(2));
  const auto primitive = [&](std::size_t position) {
    return Json{{"attributes", {{"POSITION", position}}}, {"indices", indices}};
  };
  builder.addMesh({primitive(a), primitive(b)});
  builder.addMesh(Json::array({primitive(b)}));
  builder.addMesh(Json::array({primitive(c)}));
  const Asset asset = builder.build();
  DataAccess data(asset);
  const MeshSurvey survey = surveyMeshes(asset, data);
  ASSERT_EQ(survey.groups.size(), 2U);
  EXPECT_EQ(survey.groups[0].meshes, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(survey.groups[0].tables.size(), 2U);
  EXPECT_EQ(survey.groups[0].primitives.size(), 2U);  // the one that two meshes show, once
  EXPECT_EQ(survey.groups[1].label, "meshes/2");
  EXPECT_TRUE(survey.kept.empty());
}

TEST(MeshGroups, AccessorsOverTheSameBytesAreOneTable) {
  AssetBuilder builder;
  const std::size_t a = builder.addPositions(gridPositions(4));
  Json copy = builder.document()["accessors"][a];
  copy["name"] = "the same";
  builder.document()["accessors"].push_back(copy);
  const std::size_t indices = builder.addIndices16(gridIndices(4));
  copy = builder.document()["accessors"][indices];
  builder.document()["accessors"].push_back(copy);
  builder.addMesh({{{"attributes", {{"POSITION", a}}}, {"indices", indices}},
                   {{"attributes", {{"POSITION", a + 1}}}, {"indices", indices + 1}}});
  Asset asset = builder.build();
  {
    DataAccess data(asset);
    const MeshSurvey survey = surveyMeshes(asset, data);
    ASSERT_EQ(survey.groups.size(), 1U);
    EXPECT_EQ(survey.groups[0].tables.size(), 1U);
    EXPECT_EQ(survey.groups[0].primitives.size(), 1U);
  }
  const PackReport report = expectRoundTrip(asset);
  ASSERT_EQ(report.streams.size(), 1U);
  EXPECT_EQ(report.streams[0].vertices, 25U);
  // Each accessor stays, with its name, and shares the view.
  ASSERT_TRUE(packAsset(asset));
  const Json& accessors = asset.document["accessors"];
  EXPECT_EQ(accessors.size(), 4U);
  EXPECT_EQ(accessors[a + 1]["name"], "the same");
  EXPECT_EQ(accessors[a]["bufferView"], accessors[a + 1]["bufferView"]);
  EXPECT_EQ(accessors[indices]["bufferView"], accessors[indices + 1]["bufferView"]);
}

TEST(MeshGroups, AttributesOverTheSameBytesMoveOnce) {
  AssetBuilder builder;
  const std::size_t position = builder.addPositions(gridPositions(4));
  const std::size_t a = builder.addAccessor(std::vector<float>(50, 0.5F), kGlFloat, "VEC2", 25);
  builder.document()["accessors"].push_back(builder.document()["accessors"][a]);
  const std::size_t indices = builder.addIndices16(gridIndices(4));
  builder.addMesh(
      {{{"attributes", {{"POSITION", position}, {"TEXCOORD_0", a}, {"TEXCOORD_1", a + 1}}}, {"indices", indices}}});
  Asset asset = builder.build();
  expectRoundTrip(asset);
  const Expected<PackReport> report = packAsset(asset);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->attribute_bytes, 200U);
}

TEST(MeshGroups, OneReasonKeepsTheWholeGroup) {
  for (const char* name : {"FOO_faces", "EXT_mesh_manifold"}) {
    Asset asset = gridAsset();
    Json& primitives = asset.document["meshes"][0]["primitives"];
    primitives.push_back(primitives[0]);
    primitives[1]["extensions"][name]["indices"] = 3;
    DataAccess data(asset);
    const MeshSurvey survey = surveyMeshes(asset, data);
    EXPECT_TRUE(survey.groups.empty());
    ASSERT_EQ(survey.kept.size(), 1U);
    EXPECT_NE(survey.kept[0].reason.find(name), std::string::npos);
    DataAccess again(asset);
    EXPECT_EQ(surveyMeshes(asset, again, true).groups.size(), 1U);  // with the order kept, nothing speaks against it
  }
}

}  // namespace
}  // namespace tsc::test
