#include "mixed_tips.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tsc {
namespace {

TEST(Repetition, ExpectsNothingAtFirst) {
  Repetition repetition(6);
  EXPECT_EQ(repetition.length(), 0u);
  // No eight symbols are like eight before.
  for (const std::uint32_t symbol : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
    repetition.note(symbol);
    EXPECT_EQ(repetition.length(), 0u);
  }
}

TEST(Repetition, FindsWhatCameBefore) {
  constexpr std::uint32_t kPeriod = 11;
  Repetition repetition(14);
  for (std::uint32_t i = 0; i < 100; ++i) {
    if (i >= kPeriod + 8) {
      EXPECT_EQ(repetition.length(), i - kPeriod - 8 + 1);
      EXPECT_EQ(repetition.expected(), i % kPeriod);
    }
    repetition.note(i % kPeriod);
  }
  repetition.note(15);
  EXPECT_EQ(repetition.length(), 0u);
}

/// A front of three nodes, as a component starts.
Front smallFront(std::uint32_t degree_class) {
  Front front;
  front.makeRoom(16, 16);
  for (std::uint32_t i = 0; i < 3; ++i) front.add(i, degree_class, degree_class - 1);
  for (std::uint32_t i = 0; i < 3; ++i) {
    front.link(i, (i + 1) % 3);
    front.setEdge(i, i, degree_class);
  }
  return front;
}

TEST(TipContexts, StayBelowTheirLimit) {
  for (const std::uint32_t degree_class : {1u, 2u, 5u, 14u, Front::kDummyClass}) {
    const Front front = smallFront(degree_class);
    for (std::uint32_t pivot = 0; pivot < 3; ++pivot) {
      for (const std::uint32_t context : tipContextsOf(front, gateAt(front, pivot))) EXPECT_LT(context, 1u << 28);
    }
  }
}

TEST(TipContexts, DoNotDependOnTheDirection) {
  Front forward = smallFront(5), backward = smallFront(5);
  // Node 0 has its neighbour of smaller degree on one side or on the other.
  forward[1].degree_class = backward[2].degree_class = 4;
  forward[2].degree_class = backward[1].degree_class = 6;
  const Gate gate = gateAt(forward, 0), mirrored = gateAt(backward, 0);
  EXPECT_NE(gate.direction, mirrored.direction);
  EXPECT_EQ(tipContextsOf(forward, gate), tipContextsOf(backward, mirrored));
}

std::vector<std::uint32_t> symbolsOf(std::uint32_t seed, std::uint32_t kinds) {
  std::mt19937 random(seed);
  std::vector<std::uint32_t> symbols(5000);
  for (std::uint32_t& symbol : symbols) symbol = random() % kinds;
  return symbols;
}

TEST(MixedTips, EverySymbolComesBack) {
  const Front front = smallFront(5);
  const Gate gate = gateAt(front, 0);
  for (std::uint32_t kinds = 1; kinds <= 16; ++kinds) {
    const std::vector<std::uint32_t> symbols = symbolsOf(kinds, kinds);
    EntropyWriter writer;
    Writing writing{writer};
    MixedTips mixed(5000);
    for (const std::uint32_t symbol : symbols) EXPECT_EQ(mixed.code(writing, front, gate, symbol), symbol);
    EXPECT_LT(writer.bitsSince(0), 5000 * (std::log2(kinds) + 0.15));
    std::vector<std::byte> bytes;
    writer.finish(0, bytes);

    EntropyReader reader(bytes);
    Reading reading{reader};
    MixedTips again(5000);
    for (const std::uint32_t symbol : symbols) ASSERT_EQ(again.code(reading, front, gate, 0), symbol);
    EXPECT_TRUE(reader.atEnd());
  }
}

TEST(MixedTips, RepetitionsCostLittle) {
  const Front front = smallFront(5);
  const Gate gate = gateAt(front, 0);
  std::vector<std::uint32_t> symbols = symbolsOf(1, 12);
  symbols.resize(1000);
  EntropyWriter writer;
  Writing writing{writer};
  MixedTips mixed(5000);
  for (const std::uint32_t symbol : symbols) mixed.code(writing, front, gate, symbol);
  const std::size_t mark = writer.mark();
  const double first = writer.bitsSince(0);
  for (const std::uint32_t symbol : symbols) mixed.code(writing, front, gate, symbol);
  EXPECT_LT(writer.bitsSince(mark), 0.3 * first);
}

}  // namespace
}  // namespace tsc
