#include "entropy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tsc {
namespace {

std::vector<std::uint32_t> wordsOf(const std::vector<std::byte>& bytes) {
  std::vector<std::uint32_t> words;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    words.push_back(static_cast<std::uint32_t>(bytes[i]) | static_cast<std::uint32_t>(bytes[i + 1]) << 8);
  }
  return words;
}

TEST(Entropy, NothingIsTheChecksumAlone) {
  std::vector<std::byte> bytes;
  EntropyWriter().finish(0x89abcdef, bytes);
  EXPECT_EQ(wordsOf(bytes), (std::vector<std::uint32_t>{1, 0xcdef, 1, 0x89ab, 1, 0})) << "high words first";
  EntropyReader reader(bytes);
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.states(), finalStates(0x89abcdef));
}

// One symbol by hand: state x = 2^16, symbol [start, start + f) = [8192, 24576).
// x' = floor(x / f) * 2^15 + x mod f + start = 2^2 * 2^15 + 0 + 2^13 = 2^17 + 2^13.
TEST(Entropy, OneSymbolByHand) {
  EntropyWriter writer;
  writer.put<2>(8192, 16384);
  EXPECT_NEAR(writer.bitsSince(0), 1, 1e-9);
  std::vector<std::byte> bytes;
  writer.finish(0, bytes);
  EXPECT_EQ(wordsOf(bytes), (std::vector<std::uint32_t>{1, 0, 1, 0, 2, 8192}));
  EntropyReader reader(bytes);
  EXPECT_EQ(reader.peek<2>(), 8192u);
  reader.advance<2>(8192, 16384);
  EXPECT_EQ(reader.states(), finalStates(0));
  EXPECT_TRUE(reader.atEnd());
}

/// A symbol of a lane, and raw bits behind it.
struct Symbol {
  int lane;
  std::uint32_t start, frequency, raw;
  int raw_bits;
  std::uint64_t long_raw;
  int long_bits;
};

std::vector<Symbol> randomSymbols(std::mt19937& random) {
  std::vector<Symbol> symbols(random() % 400);
  for (Symbol& s : symbols) {
    s.lane = static_cast<int>(random() % kCoderLanes);
    s.frequency = 1 + random() % (random() % 2 == 0 ? 5 : kProbabilityOne - 2);
    s.start = static_cast<std::uint32_t>(random() % (kProbabilityOne - s.frequency + 1));
    s.raw_bits = static_cast<int>(random() % 33);
    s.raw = static_cast<std::uint32_t>(random());
    if (s.raw_bits < 32) s.raw &= (1u << s.raw_bits) - 1;
    s.long_bits = static_cast<int>(random() % 43);
    s.long_raw = (std::uint64_t{random()} << 32 | random()) & ((std::uint64_t{1} << s.long_bits) - 1);
  }
  return symbols;
}

void put(EntropyWriter& writer, const Symbol& s) {
  if (s.lane == 0) writer.put<0>(s.start, s.frequency);
  if (s.lane == 1) writer.put<1>(s.start, s.frequency);
  if (s.lane == 2) writer.put<2>(s.start, s.frequency);
  writer.putRaw(s.raw, s.raw_bits);
  writer.putLongRaw(s.long_raw, s.long_bits);
}

template <int kLane>
bool getsSymbol(EntropyReader& reader, const Symbol& s) {
  const bool found = reader.peek<kLane>() >= s.start && reader.peek<kLane>() < s.start + s.frequency;
  if (found) reader.advance<kLane>(s.start, s.frequency);
  return found;
}

/// Whether the symbol and its raw bits come next.
bool gets(EntropyReader& reader, const Symbol& s) {
  const bool found = s.lane == 0   ? getsSymbol<0>(reader, s)
                     : s.lane == 1 ? getsSymbol<1>(reader, s)
                                   : getsSymbol<2>(reader, s);
  return found && reader.getRaw(s.raw_bits) == s.raw && reader.getLongRaw(s.long_bits) == s.long_raw;
}

TEST(Entropy, RandomSymbolsOfAllLanesAndRawBits) {
  std::mt19937 random(1);
  for (int run = 0; run < 200; ++run) {
    const std::vector<Symbol> symbols = randomSymbols(random);
    EntropyWriter writer;
    for (const Symbol& s : symbols) put(writer, s);
    const auto checksum = static_cast<std::uint32_t>(random());
    std::vector<std::byte> bytes;
    writer.finish(checksum, bytes);
    EXPECT_LE(8.0 * static_cast<double>(bytes.size()), writer.bitsSince(0) * 1.001 + 100);
    EntropyReader reader(bytes);
    for (const Symbol& s : symbols) ASSERT_TRUE(gets(reader, s));
    EXPECT_TRUE(reader.atEnd());
    EXPECT_EQ(reader.remaining(), 0u);
    EXPECT_EQ(reader.states(), finalStates(checksum));
  }
}

/// Symbols come right as long as their words are there, and whoever looks at the end sees that some were not.
TEST(Entropy, TruncatedPayloads) {
  std::mt19937 random(2);
  std::vector<Symbol> symbols;
  while (symbols.size() < 50) symbols = randomSymbols(random);
  EntropyWriter writer;
  for (const Symbol& s : symbols) put(writer, s);
  std::vector<std::byte> bytes;
  writer.finish(77, bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EntropyReader reader(std::span<const std::byte>(bytes).first(size));
    std::size_t right = 0;
    while (right < symbols.size() && !reader.overrun() && gets(reader, symbols[right])) ++right;
    EXPECT_TRUE(reader.overrun() || right == symbols.size()) << size << ": no wrong symbol but by running over the end";
    EXPECT_FALSE(reader.atEnd() && reader.states() == finalStates(77)) << size;
  }
}

/// At most one word refills a state, and it never leaves 32 bits, whatever the payload and the intervals.
TEST(Entropy, HostilePayloadsKeepStatesInRange) {
  std::mt19937 random(3);
  for (int run = 0; run < 100; ++run) {
    std::vector<std::byte> bytes(random() % 300);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(run % 3 == 0 ? 0xff : random());
    EntropyReader reader(bytes);
    for (int i = 0; i < 500; ++i) {
      const std::uint32_t slot = reader.peek<1>();
      const std::uint32_t start = random() % (slot + 1);
      const std::uint32_t end = slot + 1 + random() % (kProbabilityOne - slot);
      if (end - start == kProbabilityOne) continue;
      const std::uint64_t wide = std::uint64_t{end - start} * (reader.states()[1] >> kProbabilityBits) + slot - start;
      ASSERT_LT(wide, std::uint64_t{1} << 32);
      const std::size_t before = reader.position();
      reader.advance<1>(start, end - start);
      ASSERT_LE(reader.position(), before + 2);
      if (wide >= kCoderStateMin) {
        ASSERT_EQ(reader.states()[1], wide);
      }
    }
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
  for (const std::size_t size : {0u, 1u, 4u, 7u, 11u}) {
    const std::vector<std::byte> bytes(size, std::byte{0xff});
    EntropyReader reader(bytes);
    EXPECT_TRUE(reader.overrun()) << size;
    EXPECT_FALSE(reader.atEnd());
  }
  for (const std::size_t size : {12u, 13u}) {
    const std::vector<std::byte> bytes(size, std::byte{0xff});
    EntropyReader reader(bytes);
    EXPECT_FALSE(reader.overrun());
    EXPECT_EQ(reader.atEnd(), size == 12) << "half a word is left over";
    for (int i = 0; i < 40; ++i) reader.getRaw(14);
    EXPECT_TRUE(reader.overrun());
    EXPECT_FALSE(reader.atEnd());
  }
}

TEST(Entropy, ApproximateLog2) {
  for (double x = 1e-12; x < 1e12; x *= 1.0371) EXPECT_NEAR(approximateLog2(x), std::log2(x), 2e-5);
  for (int e = -40; e < 40; ++e) EXPECT_EQ(approximateLog2(std::ldexp(1.0, e)), e);
}

}  // namespace
}  // namespace tsc
