// Keeping the original order: the permutations as bytes, and assets that come back exactly as they were.
#include "original_order.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numeric>

#include "assets.h"
#include "compare_assets.h"
#include "data_access.h"
#include "fault.h"
#include "json_document.h"

namespace tsc::test {
namespace {

EncodeResult smallResult() {
  EncodeResult result;
  result.vertex_order = {{2, 0, 3, 1}};
  result.triangle_order = {{3 * 1 + 2, 3 * 0 + 1}};
  return result;
}

std::vector<OutputInfo> smallOutputs() {
  return {{OutputInfo::Kind::kPositions, ComponentType::kFloat32, 0, 4, 12, 48},
          {OutputInfo::Kind::kIndices, ComponentType::kUint8, 0, 6, 1, 6}};
}

std::vector<std::vector<std::byte>> smallArrays() {
  std::vector<std::byte> positions(48), indices;
  for (std::size_t i = 0; i < 48; ++i) positions[i] = static_cast<std::byte>(i / 12);
  for (const int i : {0, 1, 2, 3, 2, 1}) indices.push_back(static_cast<std::byte>(i));
  return {positions, indices};
}

TEST(OriginalOrder, BytesAreAsDocumented) {
  const std::vector<std::byte> bytes = writeOriginalOrder(smallResult());
  // v: 2 0 3 1, differences less one 2 -3 2 -3; t: 1 0 with k: 2 1, differences less one 1 -2.
  const std::vector<int> expected = {4, 5, 4, 5, 3 * 2 + 2, 3 * 3 + 1};
  ASSERT_EQ(bytes.size(), expected.size() + 8);
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(std::to_integer<int>(bytes[i]), expected[i]) << i;
}

TEST(OriginalOrder, ArraysAreRestored) {
  std::vector<std::vector<std::byte>> arrays = smallArrays();
  restoreOriginalOrder(writeOriginalOrder(smallResult()), smallOutputs(), arrays, "here");
  for (std::size_t i = 0; i < 4; ++i) {
    const std::vector<int> decoded_of = {1, 3, 0, 2};
    EXPECT_EQ(std::to_integer<int>(arrays[0][12 * i]), decoded_of[i]);
  }
  // Decoded triangle 0 (vertices 2 0 3) is original 1 from corner 2 on; decoded 1 (1 3 0) is original 0 from corner 1.
  const std::vector<int> expected = {0, 1, 3, 0, 3, 2};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(std::to_integer<int>(arrays[1][i]), expected[i]) << i;
}

TEST(OriginalOrder, EveryDamageIsNoticed) {
  const std::vector<std::byte> good = writeOriginalOrder(smallResult());
  const auto refused = [](const std::vector<std::byte>& bytes) {
    std::vector<std::vector<std::byte>> arrays = smallArrays();
    try {
      restoreOriginalOrder(bytes, smallOutputs(), arrays, "here");
    } catch (const Fault& fault) {
      return fault.failure().kind == FailureKind::kInvalidInput;
    }
    return false;
  };
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    std::vector<std::byte> bad = good;
    bad[bit / 8] ^= std::byte{1} << (bit % 8);
    EXPECT_TRUE(refused(bad)) << "bit " << bit;
  }
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_TRUE(refused({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)})) << length;
  }
  // Sound bytes of another stream: twice the same vertex, too few elements, too many.
  EncodeResult other = smallResult();
  other.vertex_order = {{2, 2, 3, 1}};
  EXPECT_TRUE(refused(writeOriginalOrder(other)));
  other.vertex_order = {{0, 1}};
  EXPECT_TRUE(refused(writeOriginalOrder(other)));
  other.vertex_order = {{0, 1, 2, 3}};
  other.triangle_order = {{0, 3, 6}};
  EXPECT_TRUE(refused(writeOriginalOrder(other)));
}

PackOptions keepOrder() {
  PackOptions options;
  options.keep_order = true;
  return options;
}

/// Packs with the order kept, writes, reads and unpacks. `packed` gets the asset in between.
Asset thereAndBack(const Asset& asset, Asset* packed = nullptr) {
  Asset copy = asset;
  const Expected<PackReport> report = packAsset(copy, keepOrder());
  EXPECT_TRUE(report) << report.failure().message;
  if (packed != nullptr) *packed = copy;
  const Expected<std::vector<std::byte>> glb = writeGlb(copy);
  EXPECT_TRUE(glb);
  Expected<Asset> unpacked = loadAsset(*glb, "packed");
  EXPECT_TRUE(unpacked) << unpacked.failure().message;
  const Outcome outcome = unpackAsset(*unpacked);
  EXPECT_FALSE(outcome) << outcome->message;
  return *std::move(unpacked);
}

std::vector<std::byte> elementsOf(const Asset& asset, const Json& accessor) {
  DataAccess data(asset);
  return data.elements(data.accessor(accessor.get<std::size_t>()));
}

TEST(OriginalOrder, AnAssetComesBackInIt) {
  const Asset asset = gridAsset(20);
  const Asset back = thereAndBack(asset);
  const Json& before = asset.document["meshes"][0]["primitives"][0];
  const Json& after = back.document["meshes"][0]["primitives"][0];
  EXPECT_EQ(before, after);
  EXPECT_EQ(elementsOf(asset, before["indices"]), elementsOf(back, after["indices"]));
  for (const char* name : {"NORMAL", "TEXCOORD_0"}) {
    EXPECT_EQ(elementsOf(asset, before["attributes"][name]), elementsOf(back, after["attributes"][name])) << name;
  }
  const std::vector<std::byte> a = elementsOf(asset, before["attributes"]["POSITION"]);
  const std::vector<std::byte> b = elementsOf(back, after["attributes"]["POSITION"]);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); i += 4) {
    float x, y;
    std::memcpy(&x, a.data() + i, 4);
    std::memcpy(&y, b.data() + i, 4);
    EXPECT_NEAR(x, y, 0.002);
  }
}

TEST(OriginalOrder, EverythingRoundTripsWithIt) {
  expectRoundTrip(gridAsset(), keepOrder());
  PackOptions fallback = keepOrder();
  fallback.fallback = true;
  expectRoundTrip(gridAsset(), fallback);
}

TEST(OriginalOrder, LinesPointsAndStripsStayWhereTheyAre) {
  AssetBuilder builder;
  const std::size_t position = builder.addPositions(gridPositions(3));
  const std::size_t triangles = builder.addIndices16(gridIndices(3));
  const std::size_t both = builder.addIndices16({0, 1, 4, 5, 8, 9});
  const Json attributes = {{"POSITION", position}};
  builder.addMesh({{{"attributes", attributes}, {"indices", triangles}},
                   {{"attributes", attributes}, {"indices", both}, {"mode", 5}},
                   {{"attributes", attributes}, {"indices", both}, {"mode", 3}},
                   {{"attributes", attributes}, {"mode", 3}},
                   {{"attributes", attributes}, {"mode", 0}}});
  Asset asset = builder.build();
  addVertexIds(asset);
  const Asset back = thereAndBack(asset);
  const auto before = contentOf(asset), after = contentOf(back);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t p = 0; p < before.size(); ++p) {
    EXPECT_EQ(before[p].triangles, after[p].triangles) << p;
    EXPECT_EQ(before[p].elements, after[p].elements) << p;
    EXPECT_EQ(before[p].attributes, after[p].attributes) << p;
  }
  EXPECT_EQ(back.document["meshes"][0]["primitives"][2]["indices"], both);
}

TEST(OriginalOrder, NoExtensionNeedKeepAMeshUncompressed) {
  Asset asset = gridAsset();
  asset.document["meshes"][0]["primitives"][0]["extensions"] =
      Json::parse(R"({"FB_ngon_encoding":{},"FOO_faces":{"triangles":[100,200]}})");
  Asset packed;
  const Asset back = thereAndBack(asset, &packed);
  EXPECT_TRUE(isPacked(packed));
  EXPECT_EQ(back.document["meshes"][0]["primitives"][0], asset.document["meshes"][0]["primitives"][0]);
}

TEST(OriginalOrder, PositionsUsedAsAnotherAttributeKeepTheirBits) {
  AssetBuilder builder;
  const std::size_t position = builder.addPositions(gridPositions(4));
  const std::size_t indices = builder.addIndices16(gridIndices(4));
  builder.addMesh({{{"attributes", {{"POSITION", position}, {"_REST", position}}},
                    {"indices", indices},
                    {"targets", {{{"POSITION", position}}}}}});
  expectRoundTrip(builder.build(), keepOrder());
}

TEST(OriginalOrder, ViewsOfOneStreamMustAgree) {
  Asset asset = gridAsset();
  ASSERT_TRUE(packAsset(asset, keepOrder()));
  bool first = true;
  for (Json& view : asset.document["bufferViews"]) {
    if (findExtension(view, kExtensionName) == nullptr) continue;
    if (!first) view["extensions"][std::string(kExtensionName)].erase("order");
    first = false;
  }
  const Outcome outcome = unpackAsset(asset);
  ASSERT_TRUE(outcome);
  EXPECT_NE(outcome->message.find("another order"), std::string::npos) << outcome->message;
}

}  // namespace
}  // namespace tsc::test
