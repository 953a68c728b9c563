#include "entropy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tsc {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytesOf(std::initializer_list<int> values) {
  Bytes bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

Bytes finished(const EntropyWriter& writer, std::uint32_t checksum) {
  Bytes bytes;
  writer.finish(checksum, bytes);
  return bytes;
}

TEST(Entropy, NothingIsTheChecksumAlone) {
  const Bytes bytes = finished(EntropyWriter(), 0x89abcdef);
  EXPECT_EQ(bytes, bytesOf({1, 0, 0, 0, 0x89, 0xab, 0xcd, 0xef})) << "high byte first";
  const EntropyReader reader(bytes);
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.state(), finalState(0x89abcdef));
}

// State x = 2^56, symbol [start, start + f) = [8192, 24576).
// x' = floor(x / f) * 2^15 + x mod f + start = 2^42 * 2^15 + 0 + 2^13.
TEST(Entropy, OneSymbolByHand) {
  EntropyWriter writer;
  writer.put(8192, 16384);
  EXPECT_NEAR(writer.bitsSince(0), 1, 1e-9);
  const Bytes bytes = finished(writer, 0);
  EXPECT_EQ(bytes, bytesOf({2, 0, 0, 0, 0, 0, 0x20, 0}));
  EntropyReader reader(bytes);
  EXPECT_EQ(reader.peek(), 8192u);
  reader.advance(8192, 16384);
  EXPECT_EQ(reader.state(), finalState(0));
  EXPECT_TRUE(reader.atEnd());
}

// The least frequency: x = 2^56 + 239 would become 2^71, so that its low byte goes first. x' = 2^48 * 2^15 + 5.
TEST(Entropy, OneSymbolThatTakesAByteByHand) {
  EntropyWriter writer;
  writer.put(5, 1);
  const Bytes bytes = finished(writer, 239);
  EXPECT_EQ(bytes, bytesOf({0x80, 0, 0, 0, 0, 0, 0, 5, 239}));
  EntropyReader reader(bytes);
  EXPECT_EQ(reader.remaining(), 1u);
  EXPECT_EQ(reader.peek(), 5u);
  reader.advance(5, 1);
  EXPECT_EQ(reader.state(), finalState(239));
  EXPECT_TRUE(reader.atEnd());
}

// The largest group: all but the highest byte of the state goes first, 1 is left, and nothing is refilled until the
// end.
TEST(Entropy, AGroupByHand) {
  EntropyWriter writer;
  for (const std::uint32_t start : {0x7001u, 0x0002u, 0x1003u}) writer.putGrouped(start, 1);
  writer.putRaw(0x5a5, 11);
  EXPECT_NEAR(writer.bitsSince(0), kGroupBits, 1e-9);
  const std::uint64_t first = std::uint64_t{1} << 56 | std::uint64_t{0x5a5} << 45 | std::uint64_t{0x1003} << 30 |
                              std::uint64_t{0x0002} << 15 | 0x7001;
  Bytes expected;
  for (int shift = 56; shift >= 0; shift -= 8) expected.push_back(static_cast<std::byte>(first >> shift & 0xff));
  for (const std::byte byte : bytesOf({0, 0, 0, 0x12, 0x34, 0x56, 0x78})) expected.push_back(byte);
  const Bytes bytes = finished(writer, 0x12345678);
  EXPECT_EQ(bytes, expected);
  EntropyReader reader(bytes);
  for (const std::uint32_t start : {0x7001u, 0x0002u, 0x1003u}) {
    EXPECT_EQ(reader.peek(), start);
    reader.advanceGrouped(start, 1);
    EXPECT_EQ(reader.remaining(), 7u) << "no refill within a group";
  }
  EXPECT_EQ(reader.getRaw(11), 0x5a5u);
  EXPECT_EQ(reader.state(), finalState(0x12345678));
  EXPECT_TRUE(reader.atEnd());
}

TEST(Entropy, RawBitsHaveTheLowOnesFirst) {
  EntropyWriter whole, parts;
  whole.putRaw(0b1'01101, 6);
  parts.putRawGrouped(0b01, 2);
  parts.putRawGrouped(0b1011, 4);
  parts.endGroup();
  EXPECT_EQ(finished(whole, 3), finished(parts, 3));
  // x' = x * 2^6 + value.
  const Bytes bytes = finished(whole, 3);
  EXPECT_EQ(bytes, bytesOf({0x40, 0, 0, 0, 0, 0, 0, 3 << 6 | 0b101101}));
  EntropyReader reader(bytes);
  EXPECT_EQ(reader.getRawGrouped(2), 0b01u);
  EXPECT_EQ(reader.getRaw(4), 0b1011u);
  EXPECT_TRUE(reader.atEnd());
}

/// The decoder as BITSTREAM.md, section 3, has it: a byte at a time.
class PlainReader {
 public:
  explicit PlainReader(const Bytes& bytes) : bytes_(bytes) {
    for (int i = 0; i < 8; ++i) state = state * 256 + next();
  }
  void symbol(std::uint32_t start, std::uint32_t frequency) {
    state = frequency * (state / kProbabilityOne) + state % kProbabilityOne - start;
  }
  std::uint64_t raw(int count) {
    const std::uint64_t value = state % (std::uint64_t{1} << count);
    state /= std::uint64_t{1} << count;
    return value;
  }
  void endGroup() {
    while (state < std::uint64_t{1} << 56) state = state * 256 + next();
  }
  std::uint64_t state = 0;
  std::size_t at = 0;

 private:
  std::uint64_t next() { return at < bytes_.size() ? static_cast<std::uint64_t>(bytes_[at++]) : 0; }
  const Bytes& bytes_;
};

/// A symbol, or raw bits where the frequency is 0.
struct Part {
  std::uint32_t start, frequency;
  std::uint64_t raw;
  int raw_bits;
};
using Group = std::vector<Part>;

/// As many parts as a group has room for.
Group randomGroup(std::mt19937& random) {
  Group group;
  int room = kGroupBits;
  do {
    Part p{};
    if (room >= kProbabilityBits && random() % 3 != 0) {
      p.frequency = 1 + random() % (random() % 2 == 0 ? 5 : kProbabilityOne - 2);
      p.start = static_cast<std::uint32_t>(random() % (kProbabilityOne - p.frequency + 1));
      room -= kProbabilityBits;
    } else {
      p.raw_bits = static_cast<int>(random() % static_cast<unsigned>(std::min(room, 42) + 1));
      p.raw = (std::uint64_t{random()} << 32 | random()) & ((std::uint64_t{1} << p.raw_bits) - 1);
      room -= p.raw_bits;
    }
    group.push_back(p);
  } while (room > 0 && random() % 4 != 0);
  return group;
}

std::vector<Group> randomGroups(std::mt19937& random, std::size_t count) {
  std::vector<Group> groups(count);
  for (Group& group : groups) group = randomGroup(random);
  return groups;
}

void put(EntropyWriter& writer, const Group& group) {
  for (const Part& p : group) {
    if (p.frequency > 0) {
      writer.putGrouped(p.start, p.frequency);
    } else {
      writer.putRawGrouped(p.raw, p.raw_bits);
    }
  }
  writer.endGroup();
}

/// Whether the group comes next.
bool gets(EntropyReader& reader, const Group& group) {
  for (const Part& p : group) {
    if (p.frequency == 0) {
      if (reader.getRawGrouped(p.raw_bits) != p.raw) return false;
    } else {
      if (reader.peek() < p.start || reader.peek() >= p.start + p.frequency) return false;
      reader.advanceGrouped(p.start, p.frequency);
    }
  }
  reader.endGroup();
  return true;
}

TEST(Entropy, RandomGroupsComeBackAndAreAsWritten) {
  std::mt19937 random(1);
  for (int run = 0; run < 300; ++run) {
    const std::vector<Group> groups = randomGroups(random, random() % 300);
    EntropyWriter writer;
    for (const Group& group : groups) put(writer, group);
    const auto checksum = static_cast<std::uint32_t>(random());
    const Bytes bytes = finished(writer, checksum);
    EXPECT_LE(8.0 * static_cast<double>(bytes.size()), writer.bitsSince(0) * 1.001 + 64 + 8);
    EntropyReader reader(bytes);
    PlainReader plain(bytes);
    for (const Group& group : groups) {
      ASSERT_TRUE(gets(reader, group));
      for (const Part& p : group) {
        if (p.frequency > 0) {
          plain.symbol(p.start, p.frequency);
        } else {
          ASSERT_EQ(plain.raw(p.raw_bits), p.raw);
        }
      }
      plain.endGroup();
      ASSERT_EQ(reader.state(), plain.state);
      ASSERT_EQ(reader.position(), plain.at);
    }
    EXPECT_TRUE(reader.atEnd());
    EXPECT_EQ(reader.remaining(), 0u);
    EXPECT_EQ(reader.state(), finalState(checksum));
  }
}

/// Symbols come right as long as their bytes are there, and whoever looks at the end sees that some were not.
TEST(Entropy, TruncatedPayloads) {
  std::mt19937 random(2);
  const std::vector<Group> groups = randomGroups(random, 60);
  EntropyWriter writer;
  for (const Group& group : groups) put(writer, group);
  const Bytes bytes = finished(writer, 77);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EntropyReader reader(std::span<const std::byte>(bytes).first(size));
    std::size_t right = 0;
    while (right < groups.size() && !reader.overrun() && gets(reader, groups[right])) ++right;
    EXPECT_TRUE(reader.overrun() || right == groups.size()) << size << ": no wrong symbol but by running over the end";
    EXPECT_FALSE(reader.atEnd() && reader.state() == finalState(77)) << size;
  }
}

/// Whatever the payload and the intervals, a group leaves something of the state and is refilled to at least 2^56.
TEST(Entropy, HostilePayloadsKeepTheStateInRange) {
  std::mt19937 random(3);
  for (int run = 0; run < 200; ++run) {
    Bytes bytes(random() % 300);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(run % 3 == 0 ? 0xff : run % 3 == 1 ? 0 : random());
    if (!bytes.empty()) bytes[0] |= std::byte{1};
    EntropyReader reader(bytes);
    PlainReader plain(bytes);
    if (bytes.size() < 8) plain.state = kCoderStateMin;
    for (int i = 0; i < 500; ++i) {
      for (int part = 0; part < 3; ++part) {
        const std::uint32_t slot = reader.peek();
        const std::uint32_t start = random() % 3 == 0 ? slot : random() % (slot + 1);
        std::uint32_t end = random() % 3 == 0 ? slot + 1 : slot + 1 + random() % (kProbabilityOne - slot);
        if (end - start == kProbabilityOne) --end;
        reader.advanceGrouped(start, end - start);
        plain.symbol(start, end - start);
      }
      if (random() % 2 == 0) {
        ASSERT_EQ(reader.getRawGrouped(11), plain.raw(11));
      }
      ASSERT_GT(reader.state(), 0u);
      const std::size_t before = reader.position();
      reader.endGroup();
      plain.endGroup();
      ASSERT_GE(reader.state(), kCoderStateMin);
      ASSERT_EQ(reader.state(), plain.state);
      ASSERT_LE(reader.position(), std::min(before + 7, bytes.size()));
    }
    EXPECT_TRUE(reader.overrun());
  }
}

TEST(Entropy, AppendedWritersAreOneStream) {
  EntropyWriter all, first, second;
  for (EntropyWriter* writer : {&all, &first}) writer->put(3, 77);
  const std::size_t mark = all.mark();
  for (EntropyWriter* writer : {&all, &second}) writer->putRaw(1234, 11);
  EXPECT_NEAR(all.bitsSince(mark), 11, 1e-9);
  first.append(second);
  EXPECT_EQ(finished(first, 5), finished(all, 5));
}

TEST(Entropy, ReadingPastTheEndIsNoticed) {
  for (std::size_t size = 0; size < 8; ++size) {
    const Bytes bytes(size, std::byte{0xff});
    const EntropyReader reader(bytes);
    EXPECT_TRUE(reader.overrun()) << size;
    EXPECT_FALSE(reader.atEnd());
    EXPECT_GE(reader.state(), kCoderStateMin) << "still fit to read from";
  }
  for (const std::size_t size : {8u, 9u, 20u}) {
    const Bytes bytes(size, std::byte{0xff});
    EntropyReader reader(bytes);
    EXPECT_FALSE(reader.overrun());
    EXPECT_EQ(reader.atEnd(), size == 8);
    for (int i = 0; i < 40; ++i) reader.getRaw(14);
    EXPECT_TRUE(reader.overrun());
    EXPECT_FALSE(reader.atEnd());
  }
}

TEST(Entropy, AnInitialStateBelowTheLeastIsRefused) {
  EXPECT_FALSE(EntropyReader(bytesOf({1, 0, 0, 0, 0, 0, 0, 0})).overrun());
  EXPECT_TRUE(EntropyReader(bytesOf({0, 255, 255, 255, 255, 255, 255, 255})).overrun());
  EXPECT_TRUE(EntropyReader(Bytes(20)).overrun());
}

TEST(Entropy, ApproximateLog2) {
  for (double x = 1e-12; x < 1e12; x *= 1.0371) EXPECT_NEAR(approximateLog2(x), std::log2(x), 2e-5);
  for (int e = -40; e < 40; ++e) EXPECT_EQ(approximateLog2(std::ldexp(1.0, e)), e);
}

}  // namespace
}  // namespace tsc
