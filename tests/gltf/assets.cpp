// See assets.h.
#include "assets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "compare_assets.h"
#include "data_access.h"

namespace tsc::test {

AssetBuilder::AssetBuilder() {
  asset_.name = "test";
  asset_.is_glb = true;
  asset_.document["asset"]["version"] = "2.0";
  asset_.document["buffers"].push_back({{"byteLength", 0}});
  asset_.buffers.emplace_back();
  asset_.buffers[0].source = Buffer::Source::kGlbChunk;
}

std::size_t AssetBuilder::addViewBytes(const void* data, std::size_t bytes, const Json& properties) {
  std::vector<std::byte>& buffer = asset_.buffers[0].bytes;
  buffer.resize((buffer.size() + 3) / 4 * 4);
  Json view = {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes}};
  for (const auto& [key, value] : properties.items()) view[key] = value;
  const auto* begin = static_cast<const std::byte*>(data);
  buffer.insert(buffer.end(), begin, begin + bytes);
  asset_.document["bufferViews"].push_back(std::move(view));
  return asset_.document["bufferViews"].size() - 1;
}

std::size_t AssetBuilder::addAccessorOf(std::size_t view, std::uint32_t component_type, const std::string& type,
                                        std::size_t count, const Json& more) {
  Json accessor = {{"bufferView", view}, {"componentType", component_type}, {"count", count}, {"type", type}};
  for (const auto& [key, value] : more.items()) accessor[key] = value;
  asset_.document["accessors"].push_back(std::move(accessor));
  return asset_.document["accessors"].size() - 1;
}

std::size_t AssetBuilder::addPositions(const std::vector<float>& xyz) {
  const std::size_t accessor = addAccessor(xyz, kGlFloat, "VEC3", xyz.size() / 3);
  Json low = Json::array({double{xyz[0]}, double{xyz[1]}, double{xyz[2]}}), high = low;
  for (std::size_t i = 0; i < xyz.size(); ++i) {
    low[i % 3] = std::min(low[i % 3].get<double>(), double{xyz[i]});
    high[i % 3] = std::max(high[i % 3].get<double>(), double{xyz[i]});
  }
  asset_.document["accessors"][accessor]["min"] = low;
  asset_.document["accessors"][accessor]["max"] = high;
  return accessor;
}

std::size_t AssetBuilder::addIndices16(const std::vector<std::uint32_t>& indices) {
  return addAccessor(std::vector<std::uint16_t>(indices.begin(), indices.end()), kGlUnsignedShort, "SCALAR",
                     indices.size());
}

std::size_t AssetBuilder::addMesh(const Json& primitives) {
  Json mesh = Json::object();
  mesh["primitives"] = primitives;
  asset_.document["meshes"].push_back(std::move(mesh));
  return asset_.document["meshes"].size() - 1;
}

Asset AssetBuilder::build() {
  asset_.document["buffers"][0]["byteLength"] = asset_.buffers[0].bytes.size();
  return asset_;
}

std::vector<float> gridPositions(std::size_t n, float offset) {
  std::vector<float> xyz;
  for (std::size_t y = 0; y <= n; ++y) {
    for (std::size_t x = 0; x <= n; ++x) {
      const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
      xyz.insert(xyz.end(), {fx + offset, fy, std::sin(fx * 0.7F) + std::cos(fy * 0.3F)});
    }
  }
  return xyz;
}

std::vector<std::uint32_t> gridIndices(std::size_t n) {
  std::vector<std::uint32_t> indices;
  for (std::size_t y = 0; y < n; ++y) {
    for (std::size_t x = 0; x < n; ++x) {
      const auto a = static_cast<std::uint32_t>(y * (n + 1) + x);
      const auto b = static_cast<std::uint32_t>(a + n + 1);
      indices.insert(indices.end(), {a, a + 1, b, b, a + 1, b + 1});
    }
  }
  return indices;
}

Asset gridAsset(std::size_t n) {
  AssetBuilder builder;
  const std::size_t count = (n + 1) * (n + 1);
  std::vector<float> normals, coordinates;
  for (std::size_t i = 0; i < count; ++i) {
    normals.insert(normals.end(), {0, 0, 1});
    coordinates.insert(coordinates.end(), {static_cast<float>(i) * 0.125F, 1.0F / static_cast<float>(i + 1)});
  }
  const std::size_t position = builder.addPositions(gridPositions(n));
  const std::size_t normal = builder.addAccessor(normals, kGlFloat, "VEC3", count);
  const std::size_t coordinate = builder.addAccessor(coordinates, kGlFloat, "VEC2", count);
  const std::size_t indices = builder.addIndices16(gridIndices(n));
  builder.addMesh({{{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", coordinate}}},
                    {"indices", indices}}});
  return builder.build();
}

PackReport expectRoundTrip(Asset asset, const PackOptions& options) {
  addVertexIds(asset);
  Asset packed = asset;
  Expected<PackReport> report = packAsset(packed, options);
  if (!report) {
    ADD_FAILURE() << report.failure().message;
    return {};
  }
  // Through a file, as a reader would have it.
  const Expected<std::vector<std::byte>> glb = writeGlb(packed);
  if (!glb) {
    ADD_FAILURE() << glb.failure().message;
    return {};
  }
  Expected<Asset> unpacked = loadAsset(*glb, "packed");
  if (!unpacked) {
    ADD_FAILURE() << unpacked.failure().message;
    return {};
  }
  const Outcome outcome = unpackAsset(*unpacked);
  EXPECT_FALSE(outcome) << outcome->message;
  if (outcome) return {};
  EXPECT_FALSE(isPacked(*unpacked));
  EXPECT_EQ(writeJson(unpacked->document).find(kExtensionName), std::string::npos);
  double bound = 0;
  for (const StreamReport& stream : report->streams) bound = std::max(bound, stream.guaranteed_error);
  expectSame(asset, *unpacked, bound);
  if (report->kept.empty()) expectWatertight(asset, *unpacked);
  return *std::move(report);
}

}  // namespace tsc::test
