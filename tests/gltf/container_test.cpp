#include "container.h"

#include <gtest/gtest.h>

#include "fault.h"

namespace tsc::test {
namespace {

std::vector<std::byte> bytesOf(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

TEST(Container, GlbRoundTripKeepsExtraChunks) {
  const std::vector<std::byte> bin = bytesOf("12345");
  const std::vector<GlbChunk> extra = {{0x12345678, bytesOf("abcd")}};
  const std::vector<std::byte> glb = buildGlb("{}", bin, extra);
  ASSERT_TRUE(isGlb(glb));
  EXPECT_EQ(glb.size() % 4, 0U);
  const Glb parsed = parseGlb(glb);
  EXPECT_EQ(parsed.json, "{}  ");
  ASSERT_TRUE(parsed.bin);
  EXPECT_EQ(parsed.bin->size(), 8U);
  ASSERT_EQ(parsed.extra_chunks.size(), 1U);
  EXPECT_EQ(parsed.extra_chunks[0].type, 0x12345678U);
  EXPECT_EQ(parsed.extra_chunks[0].bytes, extra[0].bytes);
}

TEST(Container, EveryTruncationOfAGlbIsAFault) {
  const std::vector<std::byte> glb = buildGlb("{\"asset\":{}}", bytesOf("12345678"), {});
  for (std::size_t size = 4; size < glb.size(); ++size) {
    EXPECT_THROW(parseGlb(std::span(glb).first(size)), Fault) << size;
  }
}

TEST(Container, DataUris) {
  for (const std::string_view text : {"", "a", "ab", "abc", "abcd"}) {
    const std::vector<std::byte> bytes = bytesOf(text);
    EXPECT_EQ(decodeDataUri(encodeDataUri(bytes), ""), bytes);
  }
  EXPECT_EQ(decodeDataUri("data:,a%20b", ""), bytesOf("a b"));
  EXPECT_THROW(decodeDataUri("data:;base64,a*b", "/buffers/0/uri"), Fault);
  EXPECT_THROW(decodeDataUri("data:nothing", "/buffers/0/uri"), Fault);
}

TEST(Container, PercentEncoding) {
  EXPECT_EQ(percentDecode("a%20b%C3%A9%zz%"), "a b\xC3\xA9%zz%");
  EXPECT_EQ(percentEncode("a b#?.bin"), "a%20b%23%3F.bin");
  EXPECT_EQ(percentDecode(percentEncode("100% \xC3\xA9.bin")), "100% \xC3\xA9.bin");
}

}  // namespace
}  // namespace tsc::test
