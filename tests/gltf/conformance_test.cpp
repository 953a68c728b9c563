// The rules for packed assets: each one broken in turn, by the document and by the data.
#include "conformance.h"

#include <gtest/gtest.h>

#include <functional>

#include "assets.h"
#include "data_access.h"
#include "json_document.h"

namespace tsc::test {
namespace {

const std::string& extensionName() {
  static const std::string name(kExtensionName);
  return name;
}

/// A packed asset and where its parts are.
struct Packed {
  Asset asset;
  std::size_t positions = 0, indices = 0, stream = 0, order = 0;  // views
  std::size_t position_accessor = 0, index_accessor = 0;

  Json& view(std::size_t index) { return asset.document["bufferViews"][index]; }
  Json& extension(std::size_t index) { return view(index)["extensions"][extensionName()]; }
  Json& accessor(std::size_t index) { return asset.document["accessors"][index]; }
  Json& primitive() { return asset.document["meshes"][0]["primitives"][0]; }
  Json& bufferOf(std::size_t index) { return asset.document["buffers"][view(index)["buffer"].get<std::size_t>()]; }
};

Packed packed(Asset asset, const PackOptions& options = {}) {
  Packed result;
  result.asset = std::move(asset);
  const Expected<PackReport> report = packAsset(result.asset, options);
  EXPECT_TRUE(report) << report.failure().message;
  result.position_accessor = result.primitive()["attributes"]["POSITION"];
  result.index_accessor = result.primitive()["indices"];
  result.positions = result.accessor(result.position_accessor)["bufferView"];
  result.indices = result.accessor(result.index_accessor)["bufferView"];
  result.stream = result.extension(result.positions)["bufferView"];
  if (options.keep_order) result.order = result.extension(result.positions)["order"]["bufferView"];
  return result;
}

PackOptions withFallback() {
  PackOptions options;
  options.fallback = true;
  return options;
}

Asset shortPositions() {
  AssetBuilder builder;
  const std::vector<std::int16_t> xyz = {0, 0, 0, 0, 10, 0, 0, 0, 0, 20, -5, 0, 7, 7, 7, 0};
  const std::size_t view = builder.addView(xyz, {{"byteStride", 8}});
  const std::size_t position =
      builder.addAccessorOf(view, kGlShort, "VEC3", 4, {{"min", {0, 0, -5}}, {"max", {10, 20, 7}}});
  const std::size_t indices = builder.addIndices16({0, 1, 2, 2, 1, 3});
  builder.addMesh({{{"attributes", {{"POSITION", position}}}, {"indices", indices}}});
  builder.document()["extensionsUsed"] = {"KHR_mesh_quantization"};
  builder.document()["extensionsRequired"] = {"KHR_mesh_quantization"};
  return builder.build();
}

/// What unpacking says of the asset after `spoil`. Must be invalid input. `checked_first`: inspecting says it as well.
std::string refusal(Packed asset, const std::function<void(Packed&)>& spoil, bool checked_first = true) {
  spoil(asset);
  if (checked_first) {
    EXPECT_FALSE(inspectAsset(asset.asset));
  }
  const Outcome outcome = unpackAsset(asset.asset);
  EXPECT_TRUE(outcome) << "not refused";
  if (!outcome) return "";
  EXPECT_EQ(outcome->kind, FailureKind::kInvalidInput);
  return outcome->message;
}

std::string refusal(const std::function<void(Packed&)>& spoil) { return refusal(packed(gridAsset()), spoil); }

::testing::AssertionResult has(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) {
    if (message.find(part) == std::string::npos) return ::testing::AssertionFailure() << message << " without " << part;
  }
  return ::testing::AssertionSuccess();
}

std::string viewAt(std::size_t view) { return "/bufferViews/" + std::to_string(view); }

TEST(Conformance, WhatPackWritesKeepsToIt) {
  PackOptions ordered;
  ordered.keep_order = true;
  for (const PackOptions& options : {PackOptions{}, withFallback(), ordered}) {
    for (const Asset& input : {gridAsset(), shortPositions()}) {
      Packed asset = packed(input, options);
      EXPECT_EQ(checkConformance(asset.asset).size(), 1U);
      const Outcome outcome = unpackAsset(asset.asset);
      EXPECT_FALSE(outcome) << outcome->message;
    }
  }
}

TEST(Conformance, TheExtensionIsDeclared) {
  const std::string used = refusal([](Packed& p) { p.asset.document["extensionsUsed"] = {"KHR_materials_unlit"}; });
  EXPECT_TRUE(has(used, {"/extensionsUsed: found no", "has it"}));
  const auto undeclared = [](Packed& p) {
    p.asset.document.erase("extensionsUsed");
    p.asset.document.erase("extensionsRequired");
  };
  EXPECT_TRUE(has(refusal(undeclared), {"/extensionsUsed"}));
  EXPECT_TRUE(has(refusal(packed(gridAsset(), withFallback()), undeclared), {"/extensionsUsed"}));
  const std::string required = refusal([](Packed& p) { p.asset.document.erase("extensionsRequired"); });
  EXPECT_TRUE(has(required, {"/extensionsRequired: found no", "has no bytes"}));
}

TEST(Conformance, PackingSeesWhatIsNotDeclared) {
  Packed asset = packed(gridAsset(), withFallback());
  asset.asset.document.erase("extensionsUsed");
  PackOptions options;
  const Expected<PackReport> again = packAsset(asset.asset, options);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.failure().kind, FailureKind::kUsage);
  options.repack = true;
  const Expected<PackReport> repacked = packAsset(asset.asset, options);
  ASSERT_FALSE(repacked);
  EXPECT_EQ(repacked.failure().kind, FailureKind::kInvalidInput);
}

TEST(Conformance, StreamViewsArePlainAndServeNothingElse) {
  EXPECT_TRUE(has(refusal([](Packed& p) { p.view(p.stream)["byteStride"] = 12; }), {"/byteStride: found 12"}));
  EXPECT_TRUE(has(refusal([](Packed& p) { p.view(p.stream)["target"] = 34962; }), {"/target: found 34962"}));
  for (const std::string name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const auto compress = [&](Packed& p) { p.view(p.stream)["extensions"][name] = {{"buffer", 0}}; };
    EXPECT_TRUE(has(refusal(compress), {"/extensions/" + name, "holds a stream"}));
  }
  const std::string accessor = refusal([](Packed& p) {
    p.asset.document["accessors"].push_back(
        {{"bufferView", p.stream}, {"componentType", 5121}, {"count", 1}, {"type", "SCALAR"}});
  });
  EXPECT_TRUE(has(accessor, {"/accessors/4/bufferView", "which holds a stream"}));
  const std::string image = refusal([](Packed& p) {
    p.asset.document["images"] = {{{"bufferView", p.stream}, {"mimeType", "image/png"}}};
  });
  EXPECT_TRUE(has(image, {"/images/0/bufferView"}));
  const std::string table = refusal([](Packed& p) {
    p.asset.document["extensions"]["EXT_structural_metadata"]["propertyTables"] = {
        {{"properties", {{"name", {{"values", p.stream}}}}}}};
  });
  EXPECT_TRUE(has(table, {"/propertyTables/0/properties/name/values"}));
  PackOptions options;
  options.keep_order = true;
  const Packed ordered = packed(gridAsset(), options);
  EXPECT_TRUE(has(refusal(ordered, [](Packed& p) { p.view(p.order)["target"] = 34962; }), {viewAt(ordered.order)}));
}

TEST(Conformance, EachOutputIsNamedOnce) {
  const std::string again = refusal([](Packed& p) {
    Json copy = p.view(p.positions);
    p.asset.document["bufferViews"].push_back(copy);
  });
  EXPECT_TRUE(has(again, {"/output: found 0", "names as well", "each output once"}));
  EXPECT_TRUE(has(refusal([](Packed& p) { p.extension(p.indices)["output"] = 2; }), {"found 2", "below 2"}));
  EXPECT_TRUE(has(refusal([](Packed& p) { p.view(p.indices)["byteLength"] = 6; }), {"/byteLength: found 6"}));
}

TEST(Conformance, ViewsFitTheirOutputs) {
  const auto set = [](std::size_t Packed::*which, const char* key, int value) {
    return refusal([=](Packed& p) { p.view(p.*which)[key] = value; });
  };
  EXPECT_TRUE(has(set(&Packed::positions, "byteStride", 16), {"/byteStride: found 16, expected 12"}));
  EXPECT_TRUE(has(set(&Packed::positions, "target", 34963), {"/target: found 34963, expected 34962"}));
  EXPECT_TRUE(has(set(&Packed::indices, "byteStride", 4), {"/byteStride: found 4, expected none"}));
  EXPECT_TRUE(has(set(&Packed::indices, "target", 34962), {"/target: found 34962, expected 34963"}));
  const auto erase = [](Packed& p) { p.view(p.positions).erase("byteStride"); };
  EXPECT_TRUE(has(refusal(packed(shortPositions()), erase), {"/byteStride: missing, expected 8"}));
  Packed optional = packed(gridAsset());
  erase(optional);
  optional.view(optional.indices).erase("target");
  EXPECT_FALSE(unpackAsset(optional.asset));
  const auto meshopt = [](Packed& p) { p.view(p.indices)["extensions"]["EXT_meshopt_compression"] = Json::object(); };
  EXPECT_TRUE(has(refusal(meshopt), {"/extensions/EXT_meshopt_compression", "one of the two"}));
}

TEST(Conformance, AccessorsFitTheirOutputs) {
  const auto set = [](std::size_t Packed::*which, const char* key, const Json& value) {
    return refusal([=](Packed& p) { p.accessor(p.*which)[key] = value; });
  };
  EXPECT_TRUE(has(set(&Packed::position_accessor, "count", 80), {"/count: found 80, expected 81"}));
  EXPECT_TRUE(has(set(&Packed::position_accessor, "componentType", 5123), {"found 5123, expected 5126"}));
  EXPECT_TRUE(has(set(&Packed::position_accessor, "type", "VEC2"), {"found \"VEC2\", expected \"VEC3\""}));
  EXPECT_TRUE(has(set(&Packed::position_accessor, "byteOffset", 12), {"/byteOffset: found 12, expected 0"}));
  EXPECT_TRUE(has(set(&Packed::position_accessor, "sparse", Json::object()), {"/sparse: found"}));
  EXPECT_TRUE(has(set(&Packed::index_accessor, "componentType", 5121), {"found 5121, expected 5123"}));
  EXPECT_TRUE(has(set(&Packed::index_accessor, "count", 3), {"found 3, expected 384"}));
  EXPECT_TRUE(has(set(&Packed::index_accessor, "type", "VEC3"), {"expected \"SCALAR\""}));
}

TEST(Conformance, IndicesAreTrianglesOfTheirTable) {
  EXPECT_TRUE(has(refusal([](Packed& p) { p.primitive()["mode"] = 1; }), {"/mode: found 1, expected 4"}));
  const std::string place = "/meshes/0/primitives/0/attributes/POSITION";
  const auto other = [](Packed& p) { p.primitive()["attributes"]["POSITION"] = p.primitive()["attributes"]["NORMAL"]; };
  EXPECT_TRUE(has(refusal(other), {place, "output 0 of the stream"}));
  const auto none = [](Packed& p) { p.primitive()["attributes"].erase("POSITION"); };
  EXPECT_TRUE(has(refusal(packed(gridAsset()), none, true), {place, "missing"}));
  const auto positions = [](Packed& p) { p.primitive()["indices"] = p.position_accessor; };
  EXPECT_TRUE(has(refusal(positions), {"/indices", "expected one of indices"}));
  const auto draco = [](Packed& p) {
    p.primitive()["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0}, {"attributes", Json::object()}};
  };
  EXPECT_TRUE(has(refusal(draco), {"KHR_draco_mesh_compression", "one of the two"}));
}

TEST(Conformance, PositionsAreOfTheSameTableAndStream) {
  AssetBuilder builder;
  for (std::size_t m = 0; m < 2; ++m) {
    Json primitives = Json::array();
    for (std::size_t p = 0; p < 2; ++p) {
      const std::size_t position = builder.addPositions(gridPositions(3, static_cast<float>(10 * m + 3 * p)));
      primitives.push_back(
          {{"attributes", {{"POSITION", position}}}, {"indices", builder.addIndices16(gridIndices(3))}});
    }
    builder.addMesh(primitives);
  }
  const Packed both = packed(builder.build());
  for (const std::size_t mesh : {0, 1}) {
    const std::string message = refusal(both, [&](Packed& p) {
      p.primitive()["attributes"]["POSITION"] =
          p.asset.document["meshes"][mesh]["primitives"][1]["attributes"]["POSITION"];
    });
    EXPECT_TRUE(has(message, {"/meshes/0/primitives/0/attributes/POSITION", "whose vertices the indices name"}));
  }
}

TEST(Conformance, PlaceholdersAreMarkedAndLargeEnough) {
  EXPECT_TRUE(has(refusal([](Packed& p) { p.bufferOf(p.positions).erase("extensions"); }), {"/buffers/1", "fallback"}));
  const auto unmark = [](Packed& p) { p.bufferOf(p.positions)["extensions"][extensionName()]["fallback"] = false; };
  EXPECT_TRUE(has(refusal(unmark), {"/buffers/1", "\"fallback\": true"}));
  EXPECT_TRUE(has(refusal([](Packed& p) { p.bufferOf(p.positions)["byteLength"] = 100; }),
                  {"/buffers/1/byteLength: found 100"}));
  const auto overlap = [](Packed& p) { p.view(p.indices)["byteOffset"] = 4; };
  EXPECT_TRUE(has(refusal(overlap), {"/byteOffset: found 4, expected 972", "ends in buffer 1"}));
  const auto far = [](Packed& p) { p.view(p.indices)["byteOffset"] = UINT64_MAX - 4; };
  EXPECT_TRUE(has(refusal(far), {"/buffers/1/byteLength"}));
  const auto nowhere = [](Packed& p) { p.view(p.indices)["buffer"] = 7; };
  EXPECT_TRUE(has(refusal(nowhere), {"/buffer: found 7, expected one below 2"}));
}

TEST(Conformance, AGlbFileDoesNotBeginWithAPlaceholder) {
  const auto swap = [](Packed& p) {
    std::swap(p.asset.document["buffers"][0], p.asset.document["buffers"][1]);
    std::swap(p.asset.buffers[0], p.asset.buffers[1]);
    for (Json& view : p.asset.document["bufferViews"]) view["buffer"] = 1 - view["buffer"].get<int>();
  };
  Packed asset = packed(gridAsset());
  asset.asset.is_glb = true;
  EXPECT_TRUE(has(refusal(asset, swap), {"/buffers/0: found the first buffer of a GLB file"}));
  asset.asset.is_glb = false;
  swap(asset);
  EXPECT_FALSE(unpackAsset(asset.asset));
}

TEST(Conformance, FallbackBuffersHoldCompressedViewsAlone) {
  const std::string message = refusal([](Packed& p) {
    p.asset.document["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 4}});
  });
  EXPECT_TRUE(has(message, {"/buffer: found 1, which is marked as fallback"}));
  const std::string marked = refusal(packed(gridAsset(), withFallback()), [](Packed& p) {
    p.bufferOf(p.positions)["extensions"][extensionName()]["fallback"] = true;
  });
  EXPECT_TRUE(has(marked, {"/buffer: found 0, which is marked as fallback"}));
  EXPECT_TRUE(has(refusal([](Packed& p) { p.bufferOf(p.positions)["extensions"][extensionName()]["fallback"] = 1; }),
                  {"/fallback: found 1, expected true or false"}));
}

TEST(Conformance, BoundsAreThoseOfTheDecodedPositions) {
  const auto message = [](const Asset& asset, const std::function<void(Json&)>& spoil) {
    return refusal(
        packed(asset), [&](Packed& p) { spoil(p.accessor(p.position_accessor)); }, false);
  };
  EXPECT_TRUE(has(message(gridAsset(), [](Json& a) { a["min"][1] = 0.5; }), {"/min: found [", "expected [0.0,0.0,"}));
  EXPECT_TRUE(has(message(gridAsset(), [](Json& a) { a["max"] = {8, 8}; }), {"/max: found [8,8]"}));
  EXPECT_TRUE(has(message(gridAsset(), [](Json& a) { a["max"][0] = 1e300; }), {"/max: found [1e+300"}));
  EXPECT_TRUE(has(message(gridAsset(), [](Json& a) { a["max"][0] = "8"; }), {"/max: found [\"8\""}));
  EXPECT_TRUE(has(message(gridAsset(), [](Json& a) { a.erase("max"); }), {"/max: missing"}));
  EXPECT_TRUE(has(message(shortPositions(), [](Json& a) { a["min"][2] = -4; }), {"/min: found [0,0,-4]"}));
  EXPECT_TRUE(has(message(shortPositions(), [](Json& a) { a["min"][2] = -5.0000001; }), {"/min: found"}));
}

TEST(Conformance, PackingCorrectsTheBoundsOfIntegers) {
  Asset asset = shortPositions();
  asset.document["accessors"][0]["min"] = {1, 2, 3};
  asset.document["accessors"][0].erase("max");
  Packed corrected = packed(asset);
  EXPECT_EQ(writeJson(corrected.accessor(corrected.position_accessor)["min"]), "[0,0,-5]");
  EXPECT_EQ(writeJson(corrected.accessor(corrected.position_accessor)["max"]), "[10,20,7]");
}

TEST(Conformance, BoundsAreComparedAsFloats) {
  Packed asset = packed(gridAsset());
  for (const char* key : {"min", "max"}) {
    for (Json& bound : asset.accessor(asset.position_accessor)[key]) bound = bound.get<double>() * (1 + 1e-12);
  }
  const Outcome outcome = unpackAsset(asset.asset);
  EXPECT_FALSE(outcome) << outcome->message;
}

TEST(Conformance, FallbackDataIsTheDecodedData) {
  const Packed asset = packed(gridAsset(), withFallback());
  for (const std::size_t view : {asset.positions, asset.indices}) {
    const std::string message = refusal(
        asset,
        [&](Packed& p) {
          const std::size_t offset = p.view(view).value("byteOffset", std::size_t{0});
          p.asset.buffers[0].bytes[offset + 5] ^= std::byte{1};
        },
        false);
    EXPECT_TRUE(has(message, {viewAt(view) + ": found ", "in byte 5 of the fallback data"}));
  }
}

}  // namespace
}  // namespace tsc::test
