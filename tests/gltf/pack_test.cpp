// Packing and unpacking of every kind of primitive and sharing.
#include <gtest/gtest.h>

#include <cstring>
#include <numeric>

#include "assets.h"
#include "compare_assets.h"
#include "data_access.h"

namespace tsc::test {
namespace {

TEST(Pack, IndexedGridComesBack) {
  const PackReport report = expectRoundTrip(gridAsset());
  ASSERT_EQ(report.streams.size(), 1U);
  EXPECT_EQ(report.streams[0].vertices, 81U);
  EXPECT_EQ(report.streams[0].triangles, 128U);
  EXPECT_LE(report.streams[0].max_error, report.streams[0].guaranteed_error);
}

TEST(Pack, FallbackLoadsWithoutTheExtension) {
  Asset asset = gridAsset();
  PackOptions options;
  options.fallback = true;
  expectRoundTrip(asset, options);
  ASSERT_TRUE(packAsset(asset, options));
  EXPECT_FALSE(asset.document.contains("extensionsRequired"));
  for (const Json& buffer : asset.document["buffers"]) EXPECT_FALSE(buffer.contains("extensions"));
}

TEST(Pack, StripsFansAndUnindexed) {
  AssetBuilder builder;
  std::vector<float> xyz = gridPositions(1);
  for (const float z : {5.0F, 6.0F}) xyz.insert(xyz.end(), {z, 0, z});
  const std::size_t position = builder.addPositions(xyz);
  const std::size_t strip = builder.addIndices16({0, 1, 2, 3, 3, 4, 5});  // with a degenerate triangle
  const std::size_t unindexed = builder.addPositions(xyz);
  builder.addMesh({{{"attributes", {{"POSITION", position}}}, {"indices", strip}, {"mode", 5}},
                   {{"attributes", {{"POSITION", position}}}, {"indices", strip}, {"mode", 6}},
                   {{"attributes", {{"POSITION", position}}}, {"indices", strip}, {"mode", 5}}});
  builder.addMesh({{{"attributes", {{"POSITION", unindexed}}}}});
  builder.addMesh({{{"attributes", {{"POSITION", unindexed}}}, {"mode", 6}}});
  const PackReport report = expectRoundTrip(builder.build());
  ASSERT_EQ(report.streams.size(), 2U);
  EXPECT_EQ(report.streams[0].triangles, 10U);  // the two equal strips once
}

TEST(Pack, LinesAndPointsFollowSharedVertices) {
  AssetBuilder builder;
  const std::size_t position = builder.addPositions(gridPositions(3));
  const std::size_t triangles = builder.addIndices16(gridIndices(3));
  const std::size_t lines = builder.addIndices16({0, 5, 5, 10, 10, 15});
  const Json attributes = {{"POSITION", position}};
  builder.addMesh({{{"attributes", attributes}, {"indices", triangles}},
                   {{"attributes", attributes}, {"indices", lines}, {"mode", 1}},
                   {{"attributes", attributes}, {"mode", 3}},
                   {{"attributes", attributes}, {"mode", 0}}});
  Asset asset = builder.build();
  addVertexIds(asset);
  Asset packed = asset;
  ASSERT_TRUE(packAsset(packed));
  ASSERT_FALSE(unpackAsset(packed));
  const auto before = contentOf(asset), after = contentOf(packed);
  EXPECT_EQ(before[1].elements, after[1].elements);
  EXPECT_EQ(before[2].elements, after[2].elements);
  EXPECT_EQ(before[3].elements, after[3].elements);
}

TEST(Pack, AccessorsSharedByMeshesStayShared) {
  AssetBuilder builder;
  const std::size_t position = builder.addPositions(gridPositions(4));
  const std::size_t indices = builder.addIndices16(gridIndices(4));
  const Json primitive = {{"attributes", {{"POSITION", position}}}, {"indices", indices}};
  builder.addMesh(Json::array({primitive}));
  builder.addMesh(Json::array({primitive}));
  Asset asset = builder.build();
  const PackReport report = expectRoundTrip(asset);
  ASSERT_EQ(report.streams.size(), 1U);
  EXPECT_EQ(report.streams[0].meshes, (std::vector<std::size_t>{0, 1}));
  ASSERT_TRUE(packAsset(asset));
  const Json& meshes = asset.document["meshes"];
  EXPECT_EQ(meshes[0]["primitives"][0], meshes[1]["primitives"][0]);
  EXPECT_EQ(asset.document["accessors"].size(), 2U);
}

TEST(Pack, AnAttributeOfTwoTablesIsUnshared) {
  AssetBuilder builder;
  const std::size_t a = builder.addPositions(gridPositions(4));
  const std::size_t b = builder.addPositions(gridPositions(4, 100));
  std::vector<float> uv(50);
  std::iota(uv.begin(), uv.end(), 0.0F);
  const std::size_t shared = builder.addAccessor(uv, kGlFloat, "VEC2", 25);
  const std::size_t indices = builder.addIndices16(gridIndices(4));
  builder.addMesh({{{"attributes", {{"POSITION", a}, {"TEXCOORD_0", shared}}}, {"indices", indices}}});
  builder.addMesh({{{"attributes", {{"POSITION", b}, {"TEXCOORD_0", shared}}}, {"indices", indices}}});
  EXPECT_EQ(expectRoundTrip(builder.build()).streams.size(), 2U);
}

TEST(Pack, PositionsUsedAsAnotherAttributeKeepTheirBits) {
  AssetBuilder builder;
  const std::size_t position = builder.addPositions(gridPositions(4));
  const std::size_t indices = builder.addIndices16(gridIndices(4));
  builder.addMesh({{{"attributes", {{"POSITION", position}, {"_REST", position}}},
                    {"indices", indices},
                    {"targets", {{{"POSITION", position}}}}}});
  expectRoundTrip(builder.build());
}

TEST(Pack, SparseMorphTargetsStaySparse) {
  AssetBuilder builder;
  const std::size_t position = builder.addPositions(gridPositions(4));
  const std::size_t indices = builder.addIndices16(gridIndices(4));
  const std::size_t index_view = builder.addView(std::vector<std::uint8_t>{1, 7, 24});
  const std::size_t value_view = builder.addView(std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8, 9});
  const Json sparse = {{"count", 3},
                       {"indices", {{"bufferView", index_view}, {"componentType", kGlUnsignedByte}}},
                       {"values", {{"bufferView", value_view}}}};
  builder.document()["accessors"].push_back(
      {{"componentType", kGlFloat}, {"count", 25}, {"type", "VEC3"}, {"sparse", sparse}});
  const std::size_t without_base = builder.document()["accessors"].size() - 1;
  const std::size_t base_view = builder.addView(gridPositions(4, 3));
  const std::size_t with_base = builder.addAccessorOf(base_view, kGlFloat, "VEC3", 25, {{"sparse", sparse}});
  builder.addMesh({{{"attributes", {{"POSITION", position}}},
                    {"indices", indices},
                    {"targets", {{{"POSITION", without_base}}, {{"POSITION", with_base}}}}}});
  Asset asset = builder.build();
  expectRoundTrip(asset);
  ASSERT_TRUE(packAsset(asset));
  EXPECT_TRUE(asset.document["accessors"][without_base].contains("sparse"));
  EXPECT_FALSE(asset.document["accessors"][without_base].contains("bufferView"));
}

TEST(Pack, SparsePositionsAndInterleaving) {
  AssetBuilder builder;
  std::vector<float> interleaved;
  const std::vector<float> xyz = gridPositions(4);
  for (std::size_t i = 0; i < 25; ++i) {
    interleaved.insert(interleaved.end(), {xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2], static_cast<float>(i), -1.0F});
  }
  const std::size_t view = builder.addView(interleaved, {{"byteStride", 20}});
  const std::size_t index_view = builder.addView(std::vector<std::uint16_t>{3, 11});
  const std::size_t value_view = builder.addView(std::vector<float>{1, 2, 3, 4, 5, 6});
  const Json sparse = {{"count", 2},
                       {"indices", {{"bufferView", index_view}, {"componentType", kGlUnsignedShort}}},
                       {"values", {{"bufferView", value_view}}}};
  const std::size_t position = builder.addAccessorOf(view, kGlFloat, "VEC3", 25, {{"sparse", sparse}});
  const std::size_t extra = builder.addAccessorOf(view, kGlFloat, "VEC2", 25, {{"byteOffset", 12}});
  const std::size_t indices = builder.addIndices16(gridIndices(4));
  builder.addMesh({{{"attributes", {{"POSITION", position}, {"_EXTRA", extra}}}, {"indices", indices}}});
  EXPECT_EQ(expectRoundTrip(builder.build()).streams.size(), 1U);
}

TEST(Pack, QuantizedPositionsAreLossless) {
  for (const bool is_short : {false, true}) {
    AssetBuilder builder;
    std::size_t position = 0;
    if (is_short) {
      std::vector<std::int16_t> xyz;
      for (const float v : gridPositions(4)) xyz.insert(xyz.end(), static_cast<std::int16_t>(v * 1000));
      std::vector<std::int16_t> padded;
      for (std::size_t i = 0; i < 25; ++i) padded.insert(padded.end(), {xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2], 0});
      position = builder.addAccessorOf(builder.addView(padded, {{"byteStride", 8}}), kGlShort, "VEC3", 25);
    } else {
      std::vector<std::uint8_t> padded;
      for (const float v : gridPositions(4)) {
        padded.push_back(static_cast<std::uint8_t>(v * 20 + 40));
        if (padded.size() % 4 == 3) padded.push_back(0);
      }
      position = builder.addAccessorOf(builder.addView(padded, {{"byteStride", 4}}), kGlUnsignedByte, "VEC3", 25,
                                       {{"normalized", true}});
    }
    const std::size_t indices = builder.addIndices16(gridIndices(4));
    builder.addMesh({{{"attributes", {{"POSITION", position}}}, {"indices", indices}}});
    Asset asset = builder.build();
    const PackReport report = expectRoundTrip(asset);
    ASSERT_EQ(report.streams.size(), 1U);
    EXPECT_EQ(report.streams[0].max_error, 0);
  }
}

TEST(Pack, ByteIndicesGrowWhereTheirLargestValueWouldBeNeeded) {
  AssetBuilder builder;
  std::vector<float> xyz = gridPositions(15);  // 256 vertices
  const std::size_t position = builder.addPositions(xyz);
  std::vector<std::uint8_t> indices;
  for (const std::uint32_t i : gridIndices(14)) indices.push_back(static_cast<std::uint8_t>(i));
  const std::size_t accessor = builder.addAccessor(indices, kGlUnsignedByte, "SCALAR", indices.size());
  builder.addMesh({{{"attributes", {{"POSITION", position}}}, {"indices", accessor}}});
  Asset asset = builder.build();
  expectRoundTrip(asset);
  ASSERT_TRUE(packAsset(asset));
  EXPECT_EQ(asset.document["accessors"][accessor]["componentType"], kGlUnsignedShort);
}

TEST(Pack, UnknownExtensionsThatMayNameVerticesKeepTheMesh) {
  for (const Json& extension :
       {Json{{"FOO_faces", {{"triangles", {1, 2}}}}}, Json{{"FB_ngon_encoding", Json::object()}},
        Json{{"EXT_mesh_features", {{"featureIds", {{{"featureCount", 25}}}}}}}}) {
    Asset asset = gridAsset();
    asset.document["meshes"][0]["primitives"][0]["extensions"] = extension;
    const Json before = asset.document;
    const Expected<PackReport> report = packAsset(asset);
    ASSERT_TRUE(report) << report.failure().message;
    EXPECT_TRUE(report->streams.empty());
    ASSERT_EQ(report->kept.size(), 1U);
    EXPECT_NE(report->kept[0].reason.find(extension.begin().key()), std::string::npos);
    EXPECT_EQ(asset.document, before);
  }
}

TEST(Pack, BadMeshesAreNamed) {
  Asset asset = gridAsset();
  asset.document["accessors"][3]["count"] = 99999;
  const Expected<PackReport> report = packAsset(asset);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.failure().kind, FailureKind::kInvalidInput);
  EXPECT_NE(report.failure().message.find("/accessors/3"), std::string::npos) << report.failure().message;

  Asset out_of_range = gridAsset();
  out_of_range.document["accessors"][0]["count"] = 10;
  out_of_range.document["accessors"][1]["count"] = 10;
  out_of_range.document["accessors"][2]["count"] = 10;
  const Expected<PackReport> second = packAsset(out_of_range);
  ASSERT_FALSE(second);
  EXPECT_NE(second.failure().message.find("vertex index"), std::string::npos) << second.failure().message;
}

TEST(Pack, PackedInputNeedsRepack) {
  Asset asset = gridAsset();
  PackOptions options;
  options.precision = {Precision::Kind::kStep, 0.001};
  ASSERT_TRUE(packAsset(asset, options));
  Asset again = asset;
  const Expected<PackReport> refused = packAsset(again, options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.failure().kind, FailureKind::kUsage);
  options.repack = true;
  again = asset;
  const Expected<PackReport> repacked = packAsset(again, options);
  ASSERT_TRUE(repacked) << repacked.failure().message;
  EXPECT_LE(repacked->streams[0].max_error, repacked->streams[0].guaranteed_error);
}

}  // namespace
}  // namespace tsc::test
