#include "tsc/tinygltf.h"

#include <gtest/gtest.h>

#include "assets.h"

namespace tsc::test {
namespace {

TEST(TinyGltf, LoadsPackedBytes) {
  Asset asset = gridAsset();
  ASSERT_TRUE(packAsset(asset));
  const Expected<std::vector<std::byte>> glb = writeGlb(asset);
  ASSERT_TRUE(glb);
  tinygltf::Model model;
  const Outcome outcome = loadModel(*glb, model);
  ASSERT_FALSE(outcome) << outcome->message;
  ASSERT_EQ(model.meshes.size(), 1U);
  const tinygltf::Primitive& primitive = model.meshes[0].primitives[0];
  EXPECT_EQ(model.accessors[static_cast<std::size_t>(primitive.attributes.at("POSITION"))].count, 81U);
  EXPECT_EQ(model.accessors[static_cast<std::size_t>(primitive.indices)].count, 384U);
}

TEST(TinyGltf, FailuresAreValues) {
  tinygltf::Model model;
  const Outcome missing = loadModel(std::filesystem::path("/nonexistent.glb"), model);
  ASSERT_TRUE(missing);
  EXPECT_EQ(missing->kind, FailureKind::kIo);
  const std::string text = "not json";
  EXPECT_TRUE(loadModel(std::as_bytes(std::span(text)), model));
}

}  // namespace
}  // namespace tsc::test
