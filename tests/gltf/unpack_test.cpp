// Unpacking what is damaged or hostile, expanding in memory, inspecting.
#include <gtest/gtest.h>

#include "assets.h"
#include "json_document.h"

namespace tsc::test {
namespace {

Asset packedGrid() {
  Asset asset = gridAsset();
  EXPECT_TRUE(packAsset(asset));
  return asset;
}

Json* packedView(Asset& asset) {
  for (Json& view : asset.document["bufferViews"]) {
    if (findExtension(view, kExtensionName) != nullptr) return &view;
  }
  return nullptr;
}

TEST(Unpack, ContradictionsAreNamed) {
  const std::string name(kExtensionName);
  const auto message = [&](auto&& spoil) {
    Asset asset = packedGrid();
    spoil(*packedView(asset));
    const Outcome outcome = unpackAsset(asset);
    return outcome ? outcome->message : std::string();
  };
  EXPECT_NE(message([&](Json& v) { v["extensions"][name]["bufferView"] = 99; }).find("found 99"), std::string::npos);
  EXPECT_NE(message([&](Json& v) { v["extensions"][name]["output"] = 5; }).find("found 5"), std::string::npos);
  EXPECT_NE(message([&](Json& v) { v["extensions"][name].erase("output"); }).find("missing"), std::string::npos);
  EXPECT_NE(message([&](Json& v) { v["byteLength"] = 12; }).find("found 12"), std::string::npos);
  EXPECT_NE(message([&](Json& v) { v["extensions"][name]["bufferView"] = 0; }).find("packed itself"),
            std::string::npos);
}

TEST(Unpack, EveryFlippedByteOfTheStreamIsNoticed) {
  const Asset packed = packedGrid();
  const Json& stream = packed.document["bufferViews"].back();
  const std::size_t begin = stream["byteOffset"], length = stream["byteLength"];
  for (std::size_t i = 0; i < length; ++i) {
    Asset damaged = packed;
    damaged.buffers[0].bytes[begin + i] ^= std::byte{0x10};
    const Outcome outcome = unpackAsset(damaged);
    ASSERT_TRUE(outcome) << "byte " << i;
    const bool other_version = outcome->message.find("header version") != std::string::npos;
    EXPECT_EQ(other_version, i == 0) << "byte " << i;
    EXPECT_EQ(outcome->kind, other_version ? FailureKind::kUnsupported : FailureKind::kInvalidInput) << "byte " << i;
  }
}

TEST(Unpack, NothingIsLeftBehindWhateverUnknownExtensionsCount) {
  for (const bool keep_order : {false, true}) {
    Asset asset = gridAsset();
    // Numbers that could mean any view or buffer, also those that pack adds.
    asset.document["extensions"]["FOO_numbers"]["all"] = Json::array({0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
    const std::size_t views = asset.document["bufferViews"].size();
    PackOptions options;
    options.keep_order = keep_order;
    ASSERT_TRUE(packAsset(asset, options));
    const std::size_t packed_views = asset.document["bufferViews"].size();
    ASSERT_FALSE(unpackAsset(asset));
    EXPECT_EQ(asset.document["buffers"].size(), 1U);
    EXPECT_EQ(asset.document["bufferViews"].size(), packed_views - (keep_order ? 2 : 1));
    EXPECT_GE(asset.document["bufferViews"].size(), views);
    for (const Buffer& buffer : asset.buffers) EXPECT_NE(buffer.source, Buffer::Source::kPlaceholder);
  }
}

TEST(Unpack, OutputLimitHolds) {
  Asset packed = packedGrid();
  packed.options.limits.max_output_bytes = 100;
  EXPECT_TRUE(unpackAsset(packed));
}

TEST(Unpack, ExpandGivesPlainGlb) {
  const Asset packed = packedGrid();
  const Expected<std::vector<std::byte>> glb = writeGlb(packed);
  ASSERT_TRUE(glb);
  const Expected<std::vector<std::byte>> plain = expand(*glb);
  ASSERT_TRUE(plain) << plain.failure().message;
  const Expected<Asset> asset = loadAsset(*plain, "plain");
  ASSERT_TRUE(asset);
  EXPECT_FALSE(isPacked(*asset));
  EXPECT_EQ(asset->buffers.size(), 1U);
}

TEST(Inspect, CountsPlainAndPacked) {
  const Expected<AssetSummary> plain = inspectAsset(gridAsset());
  ASSERT_TRUE(plain);
  EXPECT_FALSE(plain->packed);
  EXPECT_EQ(plain->vertices, 81U);
  EXPECT_EQ(plain->triangles, 128U);
  const Expected<AssetSummary> packed = inspectAsset(packedGrid());
  ASSERT_TRUE(packed) << packed.failure().message;
  ASSERT_EQ(packed->streams.size(), 1U);
  EXPECT_EQ(packed->streams[0].vertices, 81U);
  EXPECT_EQ(packed->streams[0].triangles, 128U);
  EXPECT_EQ(packed->streams[0].meshes, std::vector<std::size_t>{0});
}

}  // namespace
}  // namespace tsc::test
