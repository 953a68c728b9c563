// Input that meshopt compressed: made here by the library itself, decoded, and damaged.
#include "compressed_input.h"

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <cstring>

#include "assets.h"
#include "compare_assets.h"
#include "data_access.h"
#include "fault.h"

namespace tsc::test {
namespace {

using Bytes = std::vector<unsigned char>;

/// An asset whose first buffer holds `compressed`, to be a view of `length` bytes.
Asset compressedAsset(const Bytes& compressed, const char* mode, std::size_t count, std::size_t stride,
                      const char* filter = "NONE") {
  AssetBuilder builder;
  const std::size_t view = builder.addView(compressed);
  builder.document()["bufferViews"][view] = {{"buffer", 1},
                                             {"byteLength", count * stride},
                                             {"extensions",
                                              {{"EXT_meshopt_compression",
                                                {{"buffer", 0},
                                                 {"byteLength", compressed.size()},
                                                 {"mode", mode},
                                                 {"count", count},
                                                 {"byteStride", stride},
                                                 {"filter", filter}}}}}};
  Asset asset = builder.build();
  asset.document["buffers"].push_back(
      {{"byteLength", count * stride}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  asset.buffers.emplace_back();
  asset.buffers.back().source = Buffer::Source::kPlaceholder;
  return asset;
}

template <class T>
std::vector<T> decoded(const Asset& asset) {
  DataAccess data(asset);
  const auto bytes = data.viewBytes(0);
  std::vector<T> out(bytes.size() / sizeof(T));
  std::memcpy(out.data(), bytes.data(), bytes.size());
  return out;
}

Bytes encodedVertices(const std::vector<float>& xyz) {
  Bytes out(meshopt_encodeVertexBufferBound(xyz.size() / 3, 12));
  meshopt_encodeVertexVersion(0);
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), xyz.data(), xyz.size() / 3, 12));
  return out;
}

TEST(CompressedInput, EveryModeDecodes) {
  const std::vector<float> xyz = gridPositions(8);
  EXPECT_EQ(decoded<float>(compressedAsset(encodedVertices(xyz), "ATTRIBUTES", 81, 12)), xyz);

  std::vector<std::uint32_t> indices = gridIndices(8);
  Bytes out(meshopt_encodeIndexSequenceBound(indices.size(), 81));
  out.resize(meshopt_encodeIndexSequence(out.data(), out.size(), indices.data(), indices.size()));
  EXPECT_EQ(decoded<std::uint32_t>(compressedAsset(out, "INDICES", indices.size(), 4)), indices);

  out.resize(meshopt_encodeIndexBufferBound(indices.size(), 81));
  out.resize(meshopt_encodeIndexBuffer(out.data(), out.size(), indices.data(), indices.size()));
  std::vector<std::uint32_t> triangles = decoded<std::uint32_t>(compressedAsset(out, "TRIANGLES", indices.size(), 4));
  ASSERT_EQ(triangles.size(), indices.size());  // rotated, perhaps
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    const auto sum = [i](const auto& list) { return list[i] + list[i + 1] + list[i + 2]; };
    EXPECT_EQ(sum(triangles), sum(indices));
  }
}

TEST(CompressedInput, AMissingFallbackIsNotNeeded) {
  const std::vector<float> xyz = gridPositions(8);
  Asset asset = compressedAsset(encodedVertices(xyz), "ATTRIBUTES", 81, 12);
  asset.document["buffers"][1]["uri"] = "gone.bin";
  const Expected<std::vector<std::byte>> glb = writeGlb(asset);
  ASSERT_TRUE(glb);
  const Expected<Asset> loaded = loadAsset(*glb, "test");
  ASSERT_TRUE(loaded) << loaded.failure().message;
  EXPECT_EQ(decoded<float>(*loaded), xyz);
  EXPECT_EQ(loaded->document, asset.document);
  // Of a buffer that nothing decodes to, the file must be there.
  asset.document["buffers"][1].erase("extensions");
  const Expected<std::vector<std::byte>> plain = writeGlb(asset);
  ASSERT_TRUE(plain);
  const Expected<Asset> refused = loadAsset(*plain, "test");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.failure().kind, FailureKind::kIo);
}

TEST(CompressedInput, TheBinChunkIsBufferZeroWhateverItIsMarked) {
  AssetBuilder builder;
  builder.addView(std::vector<float>{1, 2, 3});
  builder.document()["buffers"][0]["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
  const Asset asset = builder.build();
  const Expected<std::vector<std::byte>> glb = writeGlb(asset);
  ASSERT_TRUE(glb);
  const Expected<Asset> loaded = loadAsset(*glb, "test");
  ASSERT_TRUE(loaded) << loaded.failure().message;
  EXPECT_EQ(loaded->buffers[0].bytes, asset.buffers[0].bytes);
  EXPECT_EQ(*writeGlb(*loaded), *glb);
}

TEST(CompressedInput, FiltersAreApplied) {
  const std::vector<float> normals = {0, 0, 1, 0, 1, 0, 0, 0, 0, -1, 0, 0};
  std::vector<std::int8_t> filtered(12);
  meshopt_encodeFilterOct(filtered.data(), 3, 4, 8, normals.data());
  Bytes out(meshopt_encodeVertexBufferBound(3, 4));
  meshopt_encodeVertexVersion(0);
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), filtered.data(), 3, 4));
  const std::vector<std::int8_t> back = decoded<std::int8_t>(compressedAsset(out, "ATTRIBUTES", 3, 4, "OCTAHEDRAL"));
  ASSERT_EQ(back.size(), 12U);
  EXPECT_EQ(back[2], 127);
  EXPECT_EQ(back[4], 127);
  EXPECT_THROW(decoded<std::int8_t>(compressedAsset(out, "ATTRIBUTES", 3, 4, "COLOR")), Fault);
}

TEST(CompressedInput, DamageIsNamed) {
  const Bytes good = encodedVertices(gridPositions(8));
  const auto message = [](const Asset& asset) {
    try {
      decoded<float>(asset);
    } catch (const Fault& fault) {
      return fault.failure().message;
    }
    return std::string();
  };
  EXPECT_EQ(message(compressedAsset(good, "ATTRIBUTES", 81, 12)), "");
  Bytes bad = good;
  bad[0] = 0xA1;
  EXPECT_NE(message(compressedAsset(bad, "ATTRIBUTES", 81, 12)).find("version 1"), std::string::npos);
  bad.assign(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(good.size() / 2));
  EXPECT_NE(message(compressedAsset(bad, "ATTRIBUTES", 81, 12)).find("damaged"), std::string::npos);
  EXPECT_NE(message(compressedAsset(good, "ATTRIBUTES", 4000000000, 12)).find("too few"), std::string::npos);
  EXPECT_NE(message(compressedAsset(good, "ATTRIBUTES", 81, 10)), "");
  EXPECT_NE(message(compressedAsset(good, "MESHLETS", 81, 12)).find("MESHLETS"), std::string::npos);
}

TEST(CompressedInput, APackedAssetIsFreeOfMeshopt) {
  const std::vector<float> xyz = gridPositions(8);
  Asset asset = compressedAsset(encodedVertices(xyz), "ATTRIBUTES", 81, 12);
  asset.document["extensionsUsed"] = asset.document["extensionsRequired"] = {"EXT_meshopt_compression"};
  asset.document["accessors"].push_back(
      {{"bufferView", 0}, {"componentType", kGlFloat}, {"count", 81}, {"type", "VEC3"}});
  asset.document["meshes"] = Json::parse(R"([{"primitives":[{"attributes":{"POSITION":0,"_REST":0}, "mode":4}]}])");
  for (const bool keep_order : {false, true}) {
    PackOptions options;
    options.keep_order = keep_order;
    Asset packed = asset;
    const Expected<PackReport> report = packAsset(packed, options);
    ASSERT_TRUE(report) << report.failure().message;
    ASSERT_EQ(report->streams.size(), 1U);
    EXPECT_EQ(writeJson(packed.document).find("meshopt"), std::string::npos);
    ASSERT_FALSE(unpackAsset(packed));
    EXPECT_EQ(contentOf(packed)[0].triangles.size(), 27U);
  }
}

TEST(CompressedInput, DamagedDracoDataIsNamed) {
  const std::vector<std::byte> bytes(20, std::byte{7});
  AccessorInfo info;
  info.component_type = kGlFloat;
  info.component_bytes = 4;
  info.element_bytes = 12;
  try {
    (void)decodeDraco(bytes, {{"POSITION", 0}}, {{"POSITION", info}}, "/here");
    FAIL() << "decoded";
  } catch (const Fault& fault) {
    EXPECT_EQ(fault.failure().message.find("/here: the Draco data is damaged"), 0U) << fault.failure().message;
  }
}

}  // namespace
}  // namespace tsc::test
