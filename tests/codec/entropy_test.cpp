#include "entropy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tsc {
namespace {

std::uint32_t wordAt(const std::vector<std::byte>& bytes, std::size_t i) {
  std::uint32_t word = 0;
  for (std::size_t k = 4; k-- > 0;) word = word << 8 | static_cast<std::uint32_t>(bytes[4 * i + k]);
  return word;
}

TEST(Entropy, NothingIsTheChecksumAlone) {
  std::vector<std::byte> bytes;
  EntropyWriter().finish(0x89abcdef, bytes);
  ASSERT_EQ(bytes.size(), 8u);
  EXPECT_EQ(wordAt(bytes, 0), 1u) << "high word of the state, which starts at 2^32 + checksum";
  EXPECT_EQ(wordAt(bytes, 1), 0x89abcdefu);
  EntropyReader reader(bytes);
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.state(), kCoderStateMin + 0x89abcdef);
}

// One symbol by hand: state x = 2^32, symbol [start, start + f) = [8192, 24576).
// x' = floor(x / f) * 2^15 + x mod f + start = 2^18 * 2^15 + 0 + 2^13 = 2^33 + 2^13.
TEST(Entropy, OneSymbolByHand) {
  EntropyWriter writer;
  writer.put(8192, 16384);
  EXPECT_NEAR(writer.bitsSince(0), 1, 1e-9);
  std::vector<std::byte> bytes;
  writer.finish(0, bytes);
  ASSERT_EQ(bytes.size(), 8u);
  EXPECT_EQ(wordAt(bytes, 0), 2u);
  EXPECT_EQ(wordAt(bytes, 1), 8192u);
  EntropyReader reader(bytes);
  EXPECT_EQ(reader.peek(), 8192u);
  reader.advance(8192, 16384);
  EXPECT_EQ(reader.state(), kCoderStateMin);
  EXPECT_TRUE(reader.atEnd());
}

TEST(Entropy, RandomSymbolsAndRawBits) {
  std::mt19937 random(1);
  for (int run = 0; run < 200; ++run) {
    struct Symbol {
      std::uint32_t start, frequency, raw;
      int raw_bits;
    };
    std::vector<Symbol> symbols;
    EntropyWriter writer;
    for (std::uint32_t i = random() % 400; i > 0; --i) {
      const std::uint32_t frequency = 1 + random() % (random() % 2 == 0 ? 5 : kProbabilityOne - 2);
      Symbol s{static_cast<std::uint32_t>(random() % (kProbabilityOne - frequency + 1)), frequency,
               static_cast<std::uint32_t>(random()), static_cast<int>(random() % 33)};
      if (s.raw_bits < 32) s.raw &= (1u << s.raw_bits) - 1;
      symbols.push_back(s);
      writer.put(s.start, s.frequency);
      writer.putRaw(s.raw, s.raw_bits);
    }
    const auto checksum = static_cast<std::uint32_t>(random());
    std::vector<std::byte> bytes;
    writer.finish(checksum, bytes);
    EXPECT_LE(8.0 * static_cast<double>(bytes.size()), writer.bitsSince(0) * 1.001 + 64.1);
    EntropyReader reader(bytes);
    for (const Symbol& s : symbols) {
      ASSERT_GE(reader.peek(), s.start);
      ASSERT_LT(reader.peek(), s.start + s.frequency);
      reader.advance(s.start, s.frequency);
      ASSERT_EQ(reader.getRaw(s.raw_bits), s.raw);
    }
    EXPECT_TRUE(reader.atEnd());
    EXPECT_EQ(reader.remaining(), 0u);
    EXPECT_EQ(reader.state(), kCoderStateMin + checksum);
  }
}

TEST(Entropy, AppendedWritersAreOneStream) {
  EntropyWriter all, first, second;
  for (EntropyWriter* writer : {&all, &first}) writer->put(3, 77);
  const std::size_t mark = all.mark();
  for (EntropyWriter* writer : {&all, &second}) writer->putRaw(1234, 11);
  EXPECT_NEAR(all.bitsSince(mark), 11, 1e-9);
  first.append(second);
  std::vector<std::byte> expected, found;
  all.finish(5, expected);
  first.finish(5, found);
  EXPECT_EQ(found, expected);
}

TEST(Entropy, ReadingPastTheEndIsNoticed) {
  for (const std::size_t size : {0u, 1u, 4u, 7u}) {
    const std::vector<std::byte> bytes(size, std::byte{0xff});
    EntropyReader reader(bytes);
    EXPECT_TRUE(reader.overrun()) << size;
    EXPECT_FALSE(reader.atEnd());
  }
  const std::vector<std::byte> bytes(8, std::byte{0xff});
  EntropyReader reader(bytes);
  EXPECT_FALSE(reader.overrun());
  for (int i = 0; i < 40; ++i) reader.getRaw(14);
  EXPECT_TRUE(reader.overrun());
  EXPECT_FALSE(reader.atEnd());
}

TEST(Entropy, ApproximateLog2) {
  for (double x = 1e-12; x < 1e12; x *= 1.0371) EXPECT_NEAR(approximateLog2(x), std::log2(x), 2e-5);
  for (int e = -40; e < 40; ++e) EXPECT_EQ(approximateLog2(std::ldexp(1.0, e)), e);
}

}  // namespace
}  // namespace tsc
