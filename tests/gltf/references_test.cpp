// Who names what in a document.
#include "references.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tsc::test {
namespace {

TEST(References, ExtensionsAreClassified) {
  for (const char* name : {"KHR_materials_unlit", "KHR_materials_variants", "MSFT_lod", "EXT_structural_metadata",
                           "EXT_mesh_tangentspace_compression", "EXT_mesh_manifold", "KHR_draco_mesh_compression"}) {
    EXPECT_EQ(classify(name), ExtensionClass::kIndependent) << name;
  }
  for (const char* name : {"FOO_bar", "FB_ngon_encoding", ""}) {
    EXPECT_EQ(classify(name), ExtensionClass::kUnknown) << name;
  }
}

TEST(References, BufferViewsAreFoundWhereverTheyAreNamed) {
  Json document = Json::parse(R"({
    "accessors": [{"bufferView": 1, "sparse": {"indices": {"bufferView": 2}, "values": {"bufferView": 3}}}],
    "images": [{"bufferView": 4, "extras": {"bufferView": 99}}],
    "extras": {"bufferView": 98},
    "extensions": {
      "FOO_bar": {"deep": [{"bufferView": 5}]},
      "EXT_structural_metadata": {"propertyTables": [
        {"properties": {"a": {"values": 6, "arrayOffsets": 7, "stringOffsets": 8, "offset": 97}}}]}}})");
  std::vector<std::uint64_t> found;
  visitBufferViewReferences(document, [&](Json& index) {
    found.push_back(index.get<std::uint64_t>());
    index = found.back() + 10;
  });
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, (std::vector<std::uint64_t>{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(document["accessors"][0]["sparse"]["values"]["bufferView"], 13);
  EXPECT_EQ(document["images"][0]["extras"]["bufferView"], 99);
}

TEST(References, NumbersInUnknownExtensionsMayMeanAnything) {
  const Json document = Json::parse(R"({
    "extensions": {"FOO_bar": {"a": 3, "b": [4, 5.0, 6.5, -1, "7"], "bufferView": 8},
                   "KHR_lights_punctual": {"lights": [{"intensity": 20, "extensions": {"FOO_light": {"x": 21}}}]}},
    "nodes": [{"mesh": 9, "extras": {"extensions": {"FOO_bar": {"a": 10}}}}]})");
  EXPECT_EQ(unknownNumbers(document), (std::set<std::uint64_t>{3, 4, 5, 21}));
}

TEST(References, AccessorsOfAnimationsSkinsAndInstances) {
  const Json document = Json::parse(R"({
    "animations": [{"samplers": [{"input": 1, "output": 2}]}],
    "skins": [{"inverseBindMatrices": 3}, {}],
    "nodes": [{"extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 4, "_ID": 5}}}}, {}]})");
  EXPECT_EQ(accessorsOutsideMeshes(document), (std::set<std::uint64_t>{1, 2, 3, 4, 5}));
}

TEST(References, BuffersMoveWithMeshoptRanges) {
  Json document = Json::parse(R"({"bufferViews": [
    {"buffer": 1, "byteLength": 4, "byteOffset": 8,
     "extensions": {"EXT_meshopt_compression": {"buffer": 0, "byteOffset": 4, "byteLength": 4}}},
    {"buffer": 0, "byteLength": 4}]})");
  moveBuffers(document, {{1, 100}, {0, 0}});
  EXPECT_EQ(document["bufferViews"][0]["buffer"], 0);
  EXPECT_EQ(document["bufferViews"][0]["byteOffset"], 8);
  EXPECT_EQ(document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["buffer"], 1);
  EXPECT_EQ(document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["byteOffset"], 104);
  EXPECT_EQ(document["bufferViews"][1]["byteOffset"], 100);
  EXPECT_ANY_THROW(moveBuffers(document, {{0, 0}}));
}

}  // namespace
}  // namespace tsc::test
