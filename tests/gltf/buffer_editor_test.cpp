// Views added, replaced and dropped, while all others keep their bytes.
#include "buffer_editor.h"

#include <gtest/gtest.h>

#include "assets.h"
#include "data_access.h"

namespace tsc::test {
namespace {

std::vector<std::byte> filled(std::size_t count, int value) {
  return std::vector<std::byte>(count, static_cast<std::byte>(value));
}

std::vector<std::byte> bytesOf(const Asset& asset, std::size_t view) {
  DataAccess data(asset);
  const auto bytes = data.viewBytes(view);
  return {bytes.begin(), bytes.end()};
}

/// Three views of 16 bytes, holding 1, 2 and 3, each with an image that uses it.
Asset threeViews() {
  AssetBuilder builder;
  for (int i = 0; i < 3; ++i) {
    const std::size_t view = builder.addView(filled(16, i + 1));
    builder.document()["images"].push_back({{"bufferView", view}, {"mimeType", "image/png"}});
  }
  return builder.build();
}

TEST(BufferEditor, NothingToDoChangesNothing) {
  Asset asset = threeViews();
  const Json before = asset.document;
  BufferEditor(asset).commit();
  EXPECT_EQ(asset.document, before);
  EXPECT_FALSE(asset.buffers[0].modified);
}

TEST(BufferEditor, ADroppedViewGivesItsPlaceToANewOne) {
  Asset asset = threeViews();
  BufferEditor editor(asset);
  const std::uint64_t id = editor.add(Json{{"target", 34962}});
  editor.bytes(id) = filled(8, 9);
  asset.document["images"][1]["bufferView"] = id;
  editor.commit();
  ASSERT_EQ(asset.document["bufferViews"].size(), 3U);
  EXPECT_EQ(asset.document["images"][1]["bufferView"], 1);
  EXPECT_EQ(bytesOf(asset, 0), filled(16, 1));
  EXPECT_EQ(bytesOf(asset, 1), filled(8, 9));
  EXPECT_EQ(bytesOf(asset, 2), filled(16, 3));
  EXPECT_EQ(asset.buffers[0].bytes.size(), 40U);  // the old bytes are gone
  EXPECT_EQ(asset.document["buffers"][0]["byteLength"], 40);
}

TEST(BufferEditor, ViewsBehindADroppedOneMoveUp) {
  Asset asset = threeViews();
  BufferEditor editor(asset);
  asset.document["images"].erase(0);
  editor.commit();
  ASSERT_EQ(asset.document["bufferViews"].size(), 2U);
  EXPECT_EQ(bytesOf(asset, asset.document["images"][0]["bufferView"]), filled(16, 2));
  EXPECT_EQ(bytesOf(asset, asset.document["images"][1]["bufferView"]), filled(16, 3));
}

TEST(BufferEditor, ViewsThatAnUnknownExtensionMayNameKeepTheirIndex) {
  Asset asset = threeViews();
  asset.document["extensions"]["FOO_data"]["view"] = 2;
  BufferEditor editor(asset);
  asset.document["images"].erase(0);
  editor.commit();
  EXPECT_EQ(asset.document["bufferViews"].size(), 3U);
  EXPECT_EQ(bytesOf(asset, 2), filled(16, 3));
}

TEST(BufferEditor, OverlappingViewsKeepTheSharedBytes) {
  Asset asset = threeViews();
  asset.document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 8}, {"byteLength", 16}});
  asset.document["images"].push_back({{"bufferView", 3}});
  BufferEditor editor(asset);
  asset.document["images"].erase(0);
  editor.commit();
  const std::size_t last = asset.document["images"].back()["bufferView"];
  std::vector<std::byte> expected = filled(8, 1);
  expected.resize(16, std::byte{2});
  EXPECT_EQ(bytesOf(asset, last), expected);
}

TEST(BufferEditor, ReplacedViewsMayGrow) {
  Asset asset = threeViews();
  BufferEditor editor(asset);
  editor.replace(0, filled(100, 7));
  editor.replace(2, filled(16, 8));
  editor.commit();
  EXPECT_EQ(bytesOf(asset, 0), filled(100, 7));
  EXPECT_EQ(bytesOf(asset, 1), filled(16, 2));
  EXPECT_EQ(bytesOf(asset, 2), filled(16, 8));
}

TEST(BufferEditor, PlaceholdersComeInABufferOfTheirOwn) {
  Asset asset = threeViews();
  BufferEditor editor(asset);
  const std::uint64_t id = editor.add(Json::object());
  editor.makePlaceholder(id, 1000);
  asset.document["images"][0]["bufferView"] = id;
  editor.commit();
  ASSERT_EQ(asset.buffers.size(), 2U);
  EXPECT_EQ(asset.buffers[1].source, Buffer::Source::kPlaceholder);
  EXPECT_EQ(asset.document["buffers"][1]["byteLength"], 1000);
  EXPECT_FALSE(asset.document["buffers"][1].contains("uri"));
}

}  // namespace
}  // namespace tsc::test
