#include "checksum.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string_view>
#include <vector>

namespace tsc {
namespace {

std::uint64_t hashOf(std::string_view text, std::uint64_t seed = 0) {
  return xxh64(std::as_bytes(std::span(text)), seed);
}

// Values of the reference implementation, one for each path through the function: empty, bytes, words, and 32-byte
// stripes.
TEST(Checksum, KnownValues) {
  EXPECT_EQ(hashOf(""), 0xef46db3751d8e999u);
  EXPECT_EQ(hashOf("a"), 0xd24ec4f1a98c6e5bu);
  EXPECT_EQ(hashOf("abc"), 0x44bc2cf5ad770999u);
  EXPECT_EQ(hashOf("Nobody inspects the spammish repetition"), 0xfbcea83c8a378bf1u);
}

/// The reference's self-test: bytes from a generator, with and without a seed.
TEST(Checksum, SanityBuffer) {
  std::vector<std::byte> buffer(222);
  std::uint64_t generator = 2654435761u;
  for (std::byte& byte : buffer) {
    byte = static_cast<std::byte>(generator >> 56);
    generator *= 11400714785074694797u;
  }
  struct Known {
    std::size_t length;
    std::uint64_t seed, hash;
  };
  constexpr std::uint64_t kSeed = 2654435761u;
  for (const Known& known :
       {Known{0, 0, 0xef46db3751d8e999u}, Known{0, kSeed, 0xac75fda2929b17efu}, Known{1, 0, 0xe934a84adb052768u},
        Known{1, kSeed, 0x5014607643a9b4c3u}, Known{4, 0, 0x9136a0dca57457eeu}, Known{14, 0, 0x8282dcc4994e35c8u},
        Known{14, kSeed, 0xc3bd6bf63deb6df0u}, Known{222, 0, 0xb641ae8cb691c174u},
        Known{222, kSeed, 0x20cb8ab7ae10c14au}}) {
    EXPECT_EQ(xxh64(std::span(buffer).first(known.length), known.seed), known.hash) << known.length;
  }
}

}  // namespace
}  // namespace tsc
