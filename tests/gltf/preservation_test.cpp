// What pack and unpack do not own comes out as it went in.
#include <gtest/gtest.h>

#include <algorithm>

#include "assets.h"
#include "data_access.h"

namespace tsc::test {
namespace {

/// A grid asset with all sorts of things that no tool may lose.
Asset richAsset() {
  Asset asset = gridAsset();
  Json& document = asset.document;
  document["asset"]["extras"] = Json::parse(R"({"big":18446744073709551615,"tiny":5e-324,"empty":{},"list":[]})");
  document["extensionsUsed"] = {"VENDOR_unknown"};
  document["extensions"] = Json::parse(R"({"VENDOR_unknown":{"value":1.5,"text":"bufferView"}})");
  document["nodes"] = Json::parse(R"([{"mesh":0,"translation":[6378137.123456789,0,0],"rotation":[0,0,0,1]},{}])");
  document["scenes"] = Json::parse(R"([{"nodes":[0]},{"nodes":[1]}])");
  document["scene"] = 0;
  document["images"] = Json::parse(R"([{"uri":"a%20b.png"},{"uri":"c d.png"},{"mimeType":"image/png"}])");
  document["meshes"][0]["extras"] = {{"x", 0.1}};
  document["meshes"][0]["primitives"][0]["mode"] = 4;
  document["accessors"][0]["byteOffset"] = 0;
  document["accessors"][1]["normalized"] = false;
  document["accessors"][1]["name"] = "normals";
  std::vector<std::byte>& bytes = asset.buffers[0].bytes;
  while (bytes.size() % 4 != 0) bytes.push_back(std::byte{0});
  document["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", 5}, {"extras", {{"k", 7}}}});
  for (int i = 0; i < 5; ++i) bytes.push_back(static_cast<std::byte>(200 + i));
  document["images"][2]["bufferView"] = document["bufferViews"].size() - 1;
  document["buffers"][0]["byteLength"] = bytes.size();
  document["buffers"][0]["name"] = "main";
  asset.extra_chunks.push_back({0x21212121, std::vector<std::byte>(8, std::byte{9})});
  return asset;
}

/// The document without what pack owns.
Json unowned(const Json& document) {
  Json rest = document;
  rest.erase("bufferViews");
  for (Json& buffer : rest["buffers"]) buffer.erase("byteLength");
  for (Json& accessor : rest["accessors"]) {
    for (const char* key : {"bufferView", "byteOffset", "min", "max"}) accessor.erase(key);
  }
  for (Json& image : rest["images"]) image.erase("bufferView");
  return rest;
}

TEST(Preservation, EverythingElseIsUntouched) {
  const Asset original = richAsset();
  Asset asset = original;
  const Expected<PackReport> report = packAsset(asset);
  ASSERT_TRUE(report) << report.failure().message;
  ASSERT_EQ(report->streams.size(), 1U);
  const Expected<std::vector<std::byte>> glb = writeGlb(asset);
  ASSERT_TRUE(glb);
  Expected<Asset> unpacked = loadAsset(*glb, "packed");
  ASSERT_TRUE(unpacked) << unpacked.failure().message;
  ASSERT_EQ(unpacked->extra_chunks.size(), 1U);
  EXPECT_EQ(unpacked->extra_chunks[0].bytes, original.extra_chunks[0].bytes);
  ASSERT_FALSE(unpackAsset(*unpacked));
  EXPECT_EQ(writeJson(unowned(unpacked->document)), writeJson(unowned(original.document)));
  EXPECT_EQ(unpacked->document["bufferViews"].size(), original.document["bufferViews"].size());
  DataAccess before(original), after(*unpacked);
  const std::size_t old_view = original.document["images"][2]["bufferView"];
  const std::size_t new_view = unpacked->document["images"][2]["bufferView"];
  EXPECT_EQ(unpacked->document["bufferViews"][new_view]["extras"],
            original.document["bufferViews"][old_view]["extras"]);
  const auto old_bytes = before.viewBytes(old_view), new_bytes = after.viewBytes(new_view);
  EXPECT_TRUE(std::equal(old_bytes.begin(), old_bytes.end(), new_bytes.begin(), new_bytes.end()));
}

TEST(Preservation, BytesThatNoViewCoversStay) {
  Asset asset = gridAsset();
  std::vector<std::byte>& bytes = asset.buffers[0].bytes;
  const std::vector<std::byte> secret(16, std::byte{0xAB});
  bytes.insert(bytes.end(), secret.begin(), secret.end());
  asset.document["buffers"][0]["byteLength"] = bytes.size();
  ASSERT_TRUE(packAsset(asset));
  ASSERT_FALSE(unpackAsset(asset));
  const std::vector<std::byte>& now = asset.buffers[0].bytes;
  EXPECT_NE(std::search(now.begin(), now.end(), secret.begin(), secret.end()), now.end());
}

TEST(Preservation, ViewsShrinkToWhatIsStillUsed) {
  // One view for two meshes' vertices; the second mesh cannot be packed.
  AssetBuilder builder;
  std::vector<float> both = gridPositions(8);
  const std::vector<float> second = gridPositions(8, 50);
  both.insert(both.end(), second.begin(), second.end());
  const std::size_t view = builder.addView(both);
  const std::size_t a = builder.addAccessorOf(view, kGlFloat, "VEC3", 81);
  const std::size_t b = builder.addAccessorOf(view, kGlFloat, "VEC3", 81, {{"byteOffset", 972}});
  const std::size_t indices = builder.addIndices16(gridIndices(8));
  for (const std::size_t position : {a, b}) {
    builder.addMesh({{{"attributes", {{"POSITION", position}}}, {"indices", indices}}});
  }
  builder.document()["meshes"][1]["extensions"]["FB_ngon_encoding"] = Json::object();
  const Asset original = builder.build();
  Asset asset = original;
  const Expected<PackReport> report = packAsset(asset);
  ASSERT_TRUE(report) << report.failure().message;
  ASSERT_EQ(report->streams.size(), 1U);
  const std::size_t still = asset.document["accessors"][b]["bufferView"];
  EXPECT_EQ(asset.document["bufferViews"][still]["byteLength"], 976);  // 972 is no multiple of eight
  EXPECT_EQ(asset.document["accessors"][b]["byteOffset"], 4);
  ASSERT_FALSE(unpackAsset(asset));
  DataAccess before(original), after(asset);
  EXPECT_EQ(before.elements(before.accessor(b)), after.elements(after.accessor(b)));
}

TEST(Preservation, DataOfAnimationsIsNotMovedUnderThem) {
  Asset asset = gridAsset();
  // An animation that reads the accessor that is also the texture coordinates.
  asset.document["animations"] = Json::parse(R"([{"channels":[],"samplers":[{"input":2,"output":1}]}])");
  const Asset original = asset;
  ASSERT_TRUE(packAsset(asset));
  ASSERT_FALSE(unpackAsset(asset));
  DataAccess before(original), after(asset);
  for (const std::size_t accessor : {1U, 2U}) {
    EXPECT_EQ(before.elements(before.accessor(accessor)), after.elements(after.accessor(accessor)));
  }
}

TEST(Preservation, UnpackedTwicePackedIsStable) {
  PackOptions options;
  options.precision = {Precision::Kind::kStep, 0.0009765625};
  options.mode = Mode::kLattice;
  Asset once = gridAsset(20);
  ASSERT_TRUE(packAsset(once, options));
  ASSERT_FALSE(unpackAsset(once));
  Asset twice = once;
  const Expected<PackReport> report = packAsset(twice, options);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->streams[0].max_error, 0);
}

}  // namespace
}  // namespace tsc::test
