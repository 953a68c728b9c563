// Extensions that name vertices and triangles by number: what they say is the same after pack and unpack.
#include "order_extensions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>

#include "assets.h"
#include "compare_assets.h"
#include "data_access.h"
#include "mesh_groups.h"

namespace tsc::test {
namespace {

using Ids = std::vector<std::uint32_t>;

/// The vertex numbers that `addVertexIds` gave, by the present vertex.
Ids idsOf(const Asset& asset, const Json& primitive) {
  DataAccess data(asset);
  const std::vector<std::byte> bytes = data.elements(data.accessor(primitive["attributes"]["_TEST_ID"]));
  Ids ids;
  for (std::size_t i = 0; i < bytes.size(); i += 4) {
    float id;
    std::memcpy(&id, bytes.data() + i, 4);
    ids.push_back(static_cast<std::uint32_t>(id));
  }
  return ids;
}

Ids valuesOf(const Asset& asset, const Json& accessor) {
  DataAccess data(asset);
  return data.indices(data.accessor(accessor.get<std::size_t>()));
}

const Json& primitiveOf(const Asset& asset, std::size_t index = 0) {
  return asset.document["meshes"][0]["primitives"][index];
}

/// Packs and unpacks; everything must be packed.
Asset packAndUnpack(const Asset& asset, const PackOptions& options = {}) {
  Asset copy = asset;
  const Expected<PackReport> report = packAsset(copy, options);
  EXPECT_TRUE(report) << report.failure().message;
  EXPECT_TRUE(isPacked(copy));
  EXPECT_TRUE(report->kept.empty()) << report->kept[0].reason;
  const Outcome outcome = unpackAsset(copy);
  EXPECT_FALSE(outcome) << outcome->message;
  return copy;
}

std::vector<PackOptions> bothOrders() {
  std::vector<PackOptions> options(2);
  options[1].keep_order = true;
  return options;
}

// ------------------------------------------------------------------------------------------------- Edge visibility

/// Visibility, mates and normals that depend on the edges' numbers in a way that no two neighbours share.
struct EdgeData {
  std::vector<std::uint8_t> visibility;
  Ids mates;
  std::vector<std::uint16_t> normals;
};

EdgeData edgeData(std::size_t triangles, std::size_t vertices) {
  EdgeData data;
  data.visibility.resize((triangles * 6 + 7) / 8);
  for (std::size_t edge = 0; edge < triangles * 3; ++edge) {
    const std::size_t value = edge * 7 / 3 % 4;
    data.visibility[edge / 4] |= static_cast<std::uint8_t>(value << (edge % 4 * 2));
    if (value != 1) continue;
    data.mates.push_back(static_cast<std::uint32_t>(edge * 5 % vertices));
    data.normals.insert(data.normals.end(), {static_cast<std::uint16_t>(edge), static_cast<std::uint16_t>(edge * 3)});
  }
  return data;
}

void addAccessor(Asset& asset, const void* data, std::size_t bytes, std::uint32_t type, std::size_t count) {
  std::vector<std::byte>& buffer = asset.buffers[0].bytes;
  buffer.resize((buffer.size() + 3) / 4 * 4);
  asset.document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes}});
  const auto* begin = static_cast<const std::byte*>(data);
  buffer.insert(buffer.end(), begin, begin + bytes);
  asset.document["buffers"][0]["byteLength"] = buffer.size();
  asset.document["accessors"].push_back({{"bufferView", asset.document["bufferViews"].size() - 1},
                                         {"componentType", type},
                                         {"count", count},
                                         {"type", "SCALAR"}});
}

std::size_t addValues16(Asset& asset, const Ids& values) {
  const std::vector<std::uint16_t> data(values.begin(), values.end());
  addAccessor(asset, data.data(), data.size() * 2, kGlUnsignedShort, data.size());
  return asset.document["accessors"].size() - 1;
}

Json addEdges(Asset& asset, const EdgeData& data, bool with_normals = false) {
  Json edges = Json::object();
  addAccessor(asset, data.visibility.data(), data.visibility.size(), kGlUnsignedByte, data.visibility.size());
  edges["visibility"] = asset.document["accessors"].size() - 1;
  edges["silhouetteMates"] = addValues16(asset, data.mates);
  if (with_normals) {
    edges["silhouetteNormals"] = addValues16(asset, Ids(data.normals.begin(), data.normals.end()));
  }
  edges["material"] = 0;
  return edges;
}

/// What the extension says of every edge, by its ends and the triangle's third vertex, in ids. A multiset: triangles
/// may be there twice.
std::multiset<std::vector<std::uint32_t>> edgesOf(const Asset& asset, const Json& primitive) {
  const Json& extension = primitive["extensions"][std::string(kEdgeVisibility)];
  const Ids ids = idsOf(asset, primitive), bits = valuesOf(asset, extension["visibility"]);
  const Ids mates = valuesOf(asset, extension["silhouetteMates"]);
  const Ids normals = extension.contains("silhouetteNormals") ? valuesOf(asset, extension["silhouetteNormals"]) : Ids{};
  Ids sequence;
  for (std::uint32_t i = 0; i < ids.size(); ++i) sequence.push_back(i);
  if (primitive.contains("indices")) sequence = valuesOf(asset, primitive["indices"]);
  const Ids triangles = toTriangles(primitive.value("mode", 4U), sequence);
  EXPECT_EQ(bits.size(), (triangles.size() * 2 + 7) / 8);
  std::multiset<std::vector<std::uint32_t>> edges;
  std::size_t silhouette = 0;
  for (std::size_t edge = 0; edge < triangles.size(); ++edge) {
    const std::size_t t = edge / 3 * 3;
    const std::uint32_t value = bits[edge / 4] >> (edge % 4 * 2) & 3;
    std::vector<std::uint32_t> entry;
    for (std::size_t c = 0; c < 3; ++c) entry.push_back(ids[triangles[t + (edge + c) % 3]]);
    entry.push_back(value);
    if (value == 1) {
      entry.push_back(ids[mates.at(silhouette)]);
      if (!normals.empty()) entry.insert(entry.end(), {normals.at(2 * silhouette), normals.at(2 * silhouette + 1)});
      ++silhouette;
    }
    edges.insert(entry);
  }
  EXPECT_EQ(silhouette, mates.size());
  return edges;
}

/// A grid of triangles, a strip and triangles without indices, each with visible edges.
Asset edgesAsset() {
  AssetBuilder builder;
  const std::size_t position = builder.addPositions(gridPositions(8));
  const std::size_t loose = builder.addPositions(gridPositions(5, 20));  // 36 vertices: 12 triangles
  const std::size_t grid = builder.addIndices16(gridIndices(8));
  const std::size_t strip = builder.addIndices16({0, 9, 1, 10, 2, 11, 11, 12, 3});
  builder.addMesh({{{"attributes", {{"POSITION", position}}}, {"indices", grid}},
                   {{"attributes", {{"POSITION", position}}}, {"indices", strip}, {"mode", 5}},
                   {{"attributes", {{"POSITION", loose}}}}});
  Asset asset = builder.build();
  Json& primitives = asset.document["meshes"][0]["primitives"];
  const std::string name(kEdgeVisibility);
  primitives[0]["extensions"][name] = addEdges(asset, edgeData(128, 81));
  primitives[1]["extensions"][name] = addEdges(asset, edgeData(7, 81), true);
  primitives[2]["extensions"][name] = addEdges(asset, edgeData(12, 36));
  addVertexIds(asset);
  return asset;
}

TEST(OrderExtensions, VisibilityFollowsTriangles) {
  const Asset asset = edgesAsset();
  for (const PackOptions& options : bothOrders()) {
    const Asset back = packAndUnpack(asset, options);
    for (std::size_t p = 0; p < 3; ++p) {
      EXPECT_EQ(edgesOf(asset, primitiveOf(asset, p)), edgesOf(back, primitiveOf(back, p))) << p;
      EXPECT_EQ(primitiveOf(back, p)["extensions"][std::string(kEdgeVisibility)]["material"], 0);
    }
  }
}

TEST(OrderExtensions, VisibilityMayBeSharedOrNot) {
  Asset asset = edgesAsset();
  Json& primitives = asset.document["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);  // shows the same
  primitives.push_back(primitives[0]);  // other triangles, the same bits
  primitives[4]["indices"] = addValues16(asset, [] {
    Ids indices = gridIndices(8);
    std::reverse(indices.begin(), indices.end());
    return indices;
  }());
  const Asset back = packAndUnpack(asset);
  for (std::size_t p = 0; p < 5; ++p) {
    EXPECT_EQ(edgesOf(asset, primitiveOf(asset, p)), edgesOf(back, primitiveOf(back, p))) << p;
  }
  const auto visibility = [&](std::size_t p) {
    return primitiveOf(back, p)["extensions"][std::string(kEdgeVisibility)]["visibility"];
  };
  EXPECT_EQ(visibility(0), visibility(3));
  EXPECT_NE(visibility(0), visibility(4));
}

TEST(OrderExtensions, LineStringsFollowVerticesAndKeepTheirBreaks) {
  constexpr std::uint32_t kBreak = 1000;
  for (const std::size_t n : {8, 15, 20}) {  // 81 vertices, 256 (where 255 is a break and no vertex), 441
    Asset asset = gridAsset(n);
    const std::vector<std::uint8_t> strings = {0, 1, 2, 255, 80, 7, 255, 3, 3, 9};
    addAccessor(asset, strings.data(), strings.size(), kGlUnsignedByte, strings.size());
    const std::size_t accessor = asset.document["accessors"].size() - 1;
    Json& extension = asset.document["meshes"][0]["primitives"][0]["extensions"][std::string(kEdgeVisibility)];
    extension["lineStrings"] = {{{"indices", accessor}, {"material", 0}}, {{"indices", accessor}}};
    addVertexIds(asset);
    const auto strings_of = [&](const Asset& of) {
      const Json& primitive = primitiveOf(of);
      const Json& strings_json = primitive["extensions"][std::string(kEdgeVisibility)]["lineStrings"];
      EXPECT_EQ(strings_json[0]["indices"], strings_json[1]["indices"]);
      const std::size_t index = strings_json[0]["indices"];
      const std::uint32_t type = of.document["accessors"][index]["componentType"];
      const Ids ids = idsOf(of, primitive);
      Ids out;
      for (const std::uint32_t i : valuesOf(of, strings_json[0]["indices"])) {
        out.push_back(i == restartValue(glTypeBytes(type, "")) ? kBreak : ids.at(i));
      }
      return out;
    };
    for (const PackOptions& options : bothOrders()) {
      const Asset back = packAndUnpack(asset, options);
      EXPECT_EQ(strings_of(back), (Ids{0, 1, 2, kBreak, 80, 7, kBreak, 3, 3, 9})) << n;
    }
  }
}

TEST(OrderExtensions, OutlinesFollowVertices) {
  for (const PackOptions& options : bothOrders()) {
    Asset asset = gridAsset();
    const std::size_t outline = addValues16(asset, {3, 4, 4, 80});
    asset.document["meshes"][0]["primitives"][0]["extensions"][std::string(kOutline)]["indices"] = outline;
    addVertexIds(asset);
    const Asset back = packAndUnpack(asset, options);
    const Ids ids = idsOf(back, primitiveOf(back));
    Ids named;
    for (const std::uint32_t i : valuesOf(back, primitiveOf(back)["extensions"][std::string(kOutline)]["indices"])) {
      named.push_back(ids.at(i));
    }
    EXPECT_EQ(named, (Ids{3, 4, 4, 80}));
  }
}

TEST(OrderExtensions, WhatCannotBeRewrittenKeepsTheMeshAndSaysWhy) {
  const std::string name(kEdgeVisibility);
  const auto reason = [&](auto&& spoil) {
    Asset asset = edgesAsset();
    spoil(asset, asset.document["meshes"][0]["primitives"][0]["extensions"][name]);
    const Json before = asset.document;
    const Expected<PackReport> report = packAsset(asset);
    EXPECT_TRUE(report) << report.failure().message;
    EXPECT_EQ(asset.document, before);
    EXPECT_EQ(report->kept.size(), 1U);
    return report->kept.empty() ? std::string() : report->kept[0].reason;
  };
  const auto expect = [&](auto&& spoil, const char* text) {
    const std::string found = reason(spoil);
    EXPECT_NE(found.find(text), std::string::npos) << found;
  };
  const auto accessor = [](Asset& asset, const Json& index) -> Json& {
    return asset.document["accessors"][index.get<std::size_t>()];
  };
  expect([&](Asset& a, Json& e) { accessor(a, e["visibility"])["count"] = 95; }, "expected 96, two bits");
  expect([&](Asset& a, Json& e) { accessor(a, e["visibility"])["componentType"] = 5120; }, "expected SCALAR of 5121");
  expect([&](Asset& a, Json& e) { accessor(a, e["silhouetteMates"])["count"] = 3; }, "the number of silhouette edges");
  expect([&](Asset&, Json& e) { e["visibility"] = 999; }, "999");
  expect([&](Asset&, Json& e) { e["new"] = 1; }, "the member \"new\"");
  expect([&](Asset&, Json& e) { e["extensions"]["FOO_faces"]["triangles"] = 1; },
         "an extension inside EXT_mesh_primitive");
}

// -------------------------------------------------------------------------------------------------------- Manifold

/// A tube closed to a ring: two rows of quads over n columns, cut open along a seam where the vertices are there twice,
/// its two rows a primitive each. One index array holds both, and the merged triangles are the same array with sparse
/// values. Not closed at its rims, which nothing here asks for.
struct ManifoldAsset {
  Asset asset;
  Ids merge_at, merge_to;
};

ManifoldAsset manifoldAsset(std::size_t n, bool sparse = true) {
  AssetBuilder builder;
  std::vector<float> xyz, uv;
  const auto columns = static_cast<std::uint32_t>(n + 1);
  for (std::uint32_t row = 0; row < 3; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const float angle = 6.2831853F * static_cast<float>(column % n) / static_cast<float>(n);
      xyz.insert(xyz.end(), {std::cos(angle), std::sin(angle), static_cast<float>(row)});
      uv.insert(uv.end(), {static_cast<float>(column), static_cast<float>(row)});
    }
  }
  Ids indices;
  for (std::uint32_t row = 0; row < 2; ++row) {
    for (std::uint32_t column = 0; column < n; ++column) {
      const std::uint32_t a = row * columns + column, b = a + columns;
      indices.insert(indices.end(), {a, a + 1, b, b, a + 1, b + 1});
    }
  }
  ManifoldAsset out;
  for (std::uint32_t i = 0; i < indices.size(); ++i) {
    if (indices[i] % columns != n) continue;
    out.merge_at.push_back(i);
    out.merge_to.push_back(indices[i] - static_cast<std::uint32_t>(n));
  }
  const auto shorts = [](const Ids& values) { return std::vector<std::uint16_t>(values.begin(), values.end()); };
  const std::size_t position = builder.addPositions(xyz);
  const std::size_t coordinate = builder.addAccessor(uv, kGlFloat, "VEC2", uv.size() / 2);
  const std::size_t view = builder.addView(shorts(indices));
  const std::size_t half = indices.size() / 2;
  const std::size_t first = builder.addAccessorOf(view, kGlUnsignedShort, "SCALAR", half);
  const std::size_t second = builder.addAccessorOf(view, kGlUnsignedShort, "SCALAR", half, {{"byteOffset", 2 * half}});
  const std::size_t at_view = builder.addView(shorts(out.merge_at)), to_view = builder.addView(shorts(out.merge_to));
  const std::size_t count = out.merge_at.size();
  const std::size_t merge_at = builder.addAccessorOf(at_view, kGlUnsignedShort, "SCALAR", count);
  const std::size_t merge_to = builder.addAccessorOf(to_view, kGlUnsignedShort, "SCALAR", count);
  const Json sparse_json = {{"count", count},
                            {"indices", {{"bufferView", at_view}, {"componentType", kGlUnsignedShort}}},
                            {"values", {{"bufferView", to_view}}}};
  std::size_t manifold = 0;
  if (sparse) {
    manifold = builder.addAccessorOf(view, kGlUnsignedShort, "SCALAR", indices.size(), {{"sparse", sparse_json}});
  } else {
    Ids merged = indices;
    for (std::size_t i = 0; i < count; ++i) merged[out.merge_at[i]] = out.merge_to[i];
    manifold = builder.addAccessor(shorts(merged), kGlUnsignedShort, "SCALAR", merged.size());
  }
  const Json attributes = {{"POSITION", position}, {"TEXCOORD_0", coordinate}};
  builder.addMesh({{{"attributes", attributes}, {"indices", first}, {"material", 0}},
                   {{"attributes", attributes}, {"indices", second}, {"material", 1}}});
  builder.document()["meshes"][0]["extensions"][std::string(kManifold)] = {
      {"manifoldPrimitive", {{"indices", manifold}, {"mode", 4}, {"attributes", {{"POSITION", position}}}}},
      {"mergeIndices", merge_at},
      {"mergeValues", merge_to}};
  out.asset = builder.build();
  addVertexIds(out.asset);
  return out;
}

Ids named(const Ids& vertices, const Ids& ids) {
  Ids out;
  for (const std::uint32_t vertex : vertices) out.push_back(ids.at(vertex));
  return out;
}

/// The extension says the same, in ids, as it did; its rules hold.
void expectManifold(const Asset& asset, const Ids& merge_at, const Ids& merge_to) {
  const Json& mesh = asset.document["meshes"][0];
  const Json& extension = mesh["extensions"][std::string(kManifold)];
  const Json& accessors = asset.document["accessors"];
  const Ids ids = idsOf(asset, mesh["primitives"][0]);
  EXPECT_EQ(extension["manifoldPrimitive"]["attributes"]["POSITION"], mesh["primitives"][0]["attributes"]["POSITION"]);
  EXPECT_EQ(mesh["primitives"][0]["attributes"], mesh["primitives"][1]["attributes"]);
  EXPECT_EQ(valuesOf(asset, extension["mergeIndices"]), merge_at);
  EXPECT_EQ(named(valuesOf(asset, extension["mergeValues"]), ids), merge_to);
  Ids all;
  for (const Json& primitive : mesh["primitives"]) {
    for (const std::uint32_t vertex : valuesOf(asset, primitive["indices"])) all.push_back(ids.at(vertex));
  }
  for (std::size_t i = 0; i < merge_at.size(); ++i) all.at(merge_at[i]) = merge_to[i];
  EXPECT_EQ(named(valuesOf(asset, extension["manifoldPrimitive"]["indices"]), ids), all);
  const Json& manifold = accessors[extension["manifoldPrimitive"]["indices"].get<std::size_t>()];
  const auto index = [&](std::size_t p) -> const Json& {
    return accessors[mesh["primitives"][p]["indices"].get<std::size_t>()];
  };
  EXPECT_EQ(index(0)["bufferView"], index(1)["bufferView"]);
  if (!manifold.contains("sparse")) return;
  EXPECT_EQ(manifold["bufferView"], index(0)["bufferView"]);
  const Json& values = accessors[extension["mergeValues"].get<std::size_t>()];
  EXPECT_EQ(manifold["sparse"]["values"]["bufferView"], values["bufferView"]);
  EXPECT_EQ(manifold["sparse"]["values"].value("byteOffset", 0), values.value("byteOffset", 0));
  EXPECT_EQ(manifold["componentType"], values["componentType"]);
}

TEST(OrderExtensions, ManifoldsStayWhole) {
  for (const bool sparse : {true, false}) {
    const ManifoldAsset made = manifoldAsset(12, sparse);
    expectManifold(made.asset, made.merge_at, made.merge_to);
    for (const PackOptions& options : bothOrders()) {
      Asset packed = made.asset;
      const Expected<PackReport> report = packAsset(packed, options);
      ASSERT_TRUE(report) << report.failure().message;
      ASSERT_EQ(report->streams.size(), 1U);
      ASSERT_EQ(report->warnings.empty(), false);
      EXPECT_NE(report->warnings[0].find("EXT_mesh_manifold"), std::string::npos) << report->warnings[0];
      expectManifold(packAndUnpack(made.asset, options), made.merge_at, made.merge_to);
      // No array is there twice: the positions went into the stream, the indices moved.
      EXPECT_LE(packed.buffers[0].bytes.size(), made.asset.buffers[0].bytes.size());
    }
    expectRoundTrip(made.asset);
  }
}

TEST(OrderExtensions, AMeshMayShareWhatAManifoldKeeps) {
  // The same triangles and the same visible edges in a mesh that is a manifold, where triangles keep their order, and
  // in one that is none.
  Asset asset = manifoldAsset(12).asset;
  Json& meshes = asset.document["meshes"];
  meshes[0]["primitives"][0]["extensions"][std::string(kEdgeVisibility)] = addEdges(asset, edgeData(24, 39), true);
  meshes.push_back({{"primitives", {meshes[0]["primitives"][0]}}});
  for (const PackOptions& options : bothOrders()) {
    const Asset back = packAndUnpack(asset, options);
    for (const std::size_t mesh : {0, 1}) {
      const Json& before = asset.document["meshes"][mesh]["primitives"][0];
      const Json& after = back.document["meshes"][mesh]["primitives"][0];
      EXPECT_EQ(edgesOf(asset, before), edgesOf(back, after)) << mesh;
    }
  }
}

TEST(OrderExtensions, ManifoldsOutsideTheirRulesStayAsTheyAre) {
  const auto reason = [](auto&& spoil) {
    ManifoldAsset made = manifoldAsset(6);
    spoil(made.asset);
    const Json before = made.asset.document;
    const Expected<PackReport> report = packAsset(made.asset);
    EXPECT_TRUE(report) << report.failure().message;
    EXPECT_EQ(made.asset.document, before);
    return report->kept.empty() ? std::string() : report->kept[0].reason;
  };
  const std::string fan = reason([](Asset& a) { a.document["meshes"][0]["primitives"][1]["mode"] = 6; });
  EXPECT_NE(fan.find("/meshes/0/primitives/1: found other than indexed triangles"), std::string::npos) << fan;
  const std::string targets = reason([](Asset& a) {
    a.document["meshes"][0]["extensions"][std::string(kManifold)]["manifoldPrimitive"]["material"] = 0;
  });
  EXPECT_NE(targets.find("the member \"material\""), std::string::npos) << targets;
  const std::string misplaced = reason([](Asset& a) {
    a.document["meshes"][0]["primitives"][0]["extensions"][std::string(kManifold)]["mergeIndices"] = 0;
  });
  EXPECT_NE(misplaced.find("EXT_mesh_manifold may name"), std::string::npos) << misplaced;
}

}  // namespace
}  // namespace tsc::test
