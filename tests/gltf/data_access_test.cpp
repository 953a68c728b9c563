// Reading accessors: strides, matrices, sparse data, and every way to lie about a range.
#include "data_access.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "assets.h"
#include "fault.h"

namespace tsc::test {
namespace {

/// The message of the fault that `body` raises, or nothing.
std::string faultOf(const std::function<void()>& body) {
  try {
    body();
  } catch (const Fault& fault) {
    return fault.failure().message;
  }
  return {};
}

TEST(DataAccess, StridesAndMatrixColumns) {
  AssetBuilder builder;
  std::vector<std::uint8_t> bytes(64);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i);
  const std::size_t strided = builder.addView(bytes, {{"byteStride", 8}});
  const std::size_t plain = builder.addView(bytes);
  const std::size_t vec3 = builder.addAccessorOf(strided, kGlUnsignedByte, "VEC3", 3, {{"byteOffset", 4}});
  const std::size_t mat3 = builder.addAccessorOf(plain, kGlUnsignedByte, "MAT3", 2);
  const Asset asset = builder.build();
  DataAccess data(asset);
  const std::vector<std::byte> elements = data.elements(data.accessor(vec3));
  ASSERT_EQ(elements.size(), 9U);
  EXPECT_EQ(std::to_integer<int>(elements[0]), 4);
  EXPECT_EQ(std::to_integer<int>(elements[3]), 12);
  EXPECT_EQ(std::to_integer<int>(elements[8]), 22);
  EXPECT_EQ(data.accessor(mat3).element_bytes, 12U);  // three columns of three bytes, each padded to four
  EXPECT_EQ(data.elements(data.accessor(mat3)).size(), 24U);
}

TEST(DataAccess, SparseValuesWithAndWithoutBase) {
  AssetBuilder builder;
  const std::size_t base = builder.addView(std::vector<float>{1, 2, 3, 4});
  const std::size_t indices = builder.addView(std::vector<std::uint8_t>{1, 3});
  const std::size_t values = builder.addView(std::vector<float>{20, 40});
  const Json sparse = {{"count", 2},
                       {"indices", {{"bufferView", indices}, {"componentType", kGlUnsignedByte}}},
                       {"values", {{"bufferView", values}}}};
  const std::size_t with = builder.addAccessorOf(base, kGlFloat, "SCALAR", 4, {{"sparse", sparse}});
  builder.document()["accessors"].push_back(
      {{"componentType", kGlFloat}, {"count", 4}, {"type", "SCALAR"}, {"sparse", sparse}});
  Asset asset = builder.build();
  const auto floats = [](const std::vector<std::byte>& bytes) {
    std::vector<float> out(bytes.size() / 4);
    std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
  };
  {
    DataAccess data(asset);
    EXPECT_EQ(floats(data.elements(data.accessor(with))), (std::vector<float>{1, 20, 3, 40}));
    EXPECT_EQ(floats(data.elements(data.accessor(with + 1))), (std::vector<float>{0, 20, 0, 40}));
  }
  asset.document["accessors"][with]["count"] = 3;  // now the second index is outside
  DataAccess data(asset);
  EXPECT_NE(faultOf([&] { data.elements(data.accessor(with)); }).find("found 3, expected one below 3"),
            std::string::npos);
}

TEST(DataAccess, RangesThatDoNotFitAreNamed) {
  const auto message = [](const std::function<void(Json&)>& spoil) {
    Asset asset = gridAsset();
    spoil(asset.document);
    return faultOf([&] {
      DataAccess data(asset);
      data.elements(data.accessor(0));
    });
  };
  EXPECT_EQ(message([](Json&) {}), "");
  EXPECT_NE(message([](Json& d) { d["accessors"][0]["count"] = 82; }).find("/accessors/0"), std::string::npos);
  EXPECT_NE(message([](Json& d) { d["accessors"][0]["count"] = -1; }).find("/accessors/0/count"), std::string::npos);
  EXPECT_NE(message([](Json& d) { d["accessors"][0]["byteOffset"] = UINT64_MAX; }), "");
  EXPECT_NE(message([](Json& d) { d["accessors"][0]["componentType"] = 1; }).find("componentType"), std::string::npos);
  EXPECT_NE(message([](Json& d) { d["accessors"][0]["type"] = "VEC9"; }).find("VEC9"), std::string::npos);
  EXPECT_NE(message([](Json& d) { d["bufferViews"][0]["byteLength"] = UINT64_MAX; }), "");
  EXPECT_NE(message([](Json& d) { d["bufferViews"][0]["buffer"] = 7; }).find("found 7"), std::string::npos);
  EXPECT_NE(message([](Json& d) { d["bufferViews"][0]["byteStride"] = 4; }).find("byteStride"), std::string::npos);
  EXPECT_NE(message([](Json& d) { d["accessors"][0]["bufferView"] = 99; }).find("99"), std::string::npos);
}

TEST(DataAccess, HugeCountsWithoutDataAllocateNothing) {
  AssetBuilder builder;
  builder.document()["accessors"].push_back({{"componentType", kGlFloat}, {"count", UINT32_MAX}, {"type", "MAT4"}});
  const Asset asset = builder.build();
  DataAccess data(asset);
  EXPECT_NE(faultOf([&] { data.elements(data.accessor(0)); }).find("too many"), std::string::npos);
}

TEST(DataAccess, AccessorsOverTheSameBytesHaveOneStandIn) {
  AssetBuilder builder;
  const std::size_t view = builder.addView(gridPositions(2));
  const std::size_t a = builder.addAccessorOf(view, kGlFloat, "VEC3", 9);
  const std::size_t b = builder.addAccessorOf(view, kGlFloat, "VEC3", 9, {{"name", "again"}, {"byteOffset", 0}});
  const std::size_t c = builder.addAccessorOf(view, kGlFloat, "VEC3", 8);
  const std::size_t d = builder.addAccessorOf(view, kGlFloat, "VEC3", 8, {{"byteOffset", 12}});
  const Asset asset = builder.build();
  DataAccess data(asset);
  EXPECT_EQ(data.canonical(a), a);
  EXPECT_EQ(data.canonical(b), a);
  EXPECT_EQ(data.canonical(c), c);
  EXPECT_EQ(data.canonical(d), d);
}

TEST(DataAccess, UnsignedNumbersOfEveryWidth) {
  for (const std::size_t bytes : {1U, 2U, 4U}) {
    const std::vector<std::uint32_t> values = {0, 1, bytes == 1 ? 255U : bytes == 2 ? 65535U : UINT32_MAX};
    EXPECT_EQ(readUnsigned(writeUnsigned(values, bytes), bytes), values);
  }
}

}  // namespace
}  // namespace tsc::test
