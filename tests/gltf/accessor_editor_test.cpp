// Accessors edited in place where nobody else needs them, cloned otherwise.
#include "accessor_editor.h"

#include <gtest/gtest.h>

#include <cstring>

#include "assets.h"

namespace tsc::test {
namespace {

class AccessorEditing : public ::testing::Test {
 protected:
  AccessorEditing() {
    AssetBuilder builder;
    values_ = builder.addAccessor(std::vector<std::uint16_t>{10, 20, 30}, kGlUnsignedShort, "SCALAR", 3);
    others_ = builder.addAccessor(std::vector<float>{1, 2, 3, 4, 5, 6}, kGlFloat, "VEC2", 3);
    original_ = asset_ = builder.build();
  }

  std::vector<float> floats(std::size_t accessor) {
    DataAccess data(asset_);
    const std::vector<std::byte> bytes = data.elements(data.accessor(accessor));
    std::vector<float> out(bytes.size() / 4);
    std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
  }

  Asset asset_, original_;
  std::size_t values_ = 0, others_ = 0;
};

TEST_F(AccessorEditing, TheFirstToClaimGetsTheAccessorItself) {
  DataAccess data(original_);
  BufferEditor buffers(asset_);
  AccessorEditor editor(asset_, original_, data, buffers, {values_});
  EXPECT_EQ(editor.claim(others_), others_);
  EXPECT_EQ(editor.claim(others_), 2U);
  EXPECT_EQ(editor.claim(values_), 3U);  // somebody else needs it
  EXPECT_EQ(asset_.document["accessors"][3], original_.document["accessors"][values_]);
}

TEST_F(AccessorEditing, ReorderedElementsArePaddedToFourBytes) {
  DataAccess data(original_);
  BufferEditor buffers(asset_);
  AccessorEditor editor(asset_, original_, data, buffers, {});
  asset_.document["nodes"] = Json::array();
  const std::vector<std::uint32_t> order = {2, 0, 1};
  const std::size_t pairs = editor.reorder(others_, order);
  const std::size_t shorts = editor.reorder(values_, order);
  buffers.commit();
  EXPECT_EQ(floats(pairs), (std::vector<float>{5, 6, 1, 2, 3, 4}));
  const std::size_t view = asset_.document["accessors"][shorts]["bufferView"];
  EXPECT_EQ(asset_.document["bufferViews"][view]["byteStride"], 4);
  DataAccess after(asset_);
  EXPECT_EQ(after.indices(after.accessor(shorts)), (std::vector<std::uint32_t>{30, 10, 20}));
  EXPECT_EQ(editor.attributeBytes(), 36U);
}

TEST_F(AccessorEditing, IndicesTakeTheTypeThatTheyAreGiven) {
  DataAccess data(original_);
  BufferEditor buffers(asset_);
  AccessorEditor editor(asset_, original_, data, buffers, {});
  const std::size_t accessor = editor.add(Json::object());
  const std::vector<std::uint32_t> indices = {0, 2, 1};
  editor.setIndices(accessor, indices, kGlUnsignedByte);
  buffers.commit();
  DataAccess after(asset_);
  EXPECT_EQ(after.accessor(accessor).component_type, kGlUnsignedByte);
  EXPECT_EQ(after.indices(after.accessor(accessor)), indices);
}

}  // namespace
}  // namespace tsc::test
