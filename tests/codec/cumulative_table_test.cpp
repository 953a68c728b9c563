#include "cumulative_table.h"

#include <gtest/gtest.h>

#include <random>

namespace tsc {
namespace {

/// Rates that grow at four ages, as those of the connectivity do.
constexpr TableRates kSlowingRates = [] {
  TableRates rates{};
  for (std::size_t age = 0; age < rates.size(); ++age) {
    rates[age] = 3 + (age >= 70) + (age >= 104) + (age >= 124) + (age >= 127);
  }
  return rates;
}();
/// All the same, the fastest ones that the stages use.
constexpr TableRates kFastRates = [] {
  TableRates rates{};
  rates.fill(3);
  return rates;
}();

CumulativeTable uniform() {
  CumulativeTable table;
  for (int s = 1; s < 16; ++s) table.lanes[s] = static_cast<std::int16_t>(2048 * s);
  return table;
}

template <class Table>
void expectTable(const Table& table) {
  ASSERT_EQ(table.below(0), 0u);
  ASSERT_EQ(table.below(16), kProbabilityOne);
  for (std::uint32_t s = 0; s < 16; ++s) ASSERT_GT(table.below(s + 1), table.below(s)) << s;
}

template <class Table>
void expectFindsEachOwner(const Table& table) {
  for (std::uint32_t slot = 0; slot < kProbabilityOne; ++slot) {
    const std::uint32_t symbol = table.find(slot);
    ASSERT_LE(table.below(symbol), slot);
    ASSERT_GT(table.below(symbol + 1), slot);
  }
}

/// Symbols that are hard on a table: noise, one over and over, the two ends in turn, and all in a row.
std::uint32_t hostileSymbol(std::mt19937& random, std::uint32_t i) {
  switch (i / 1000 % 4) {
    case 0: return random() % 16;
    case 1: return i / 4000 % 16;
    case 2: return i % 2 * 15;
    default: return i % 16;
  }
}

// Rate 3. Targets of symbol 5: s up to 5, s + 2^15 - 16 beyond.
TEST(CumulativeTable, FirstUpdateByHand) {
  CumulativeTable table = uniform();
  table.update(5, kSlowingRates);
  EXPECT_EQ(table.below(1), 2048 + ((1 - 2048) >> 3));
  EXPECT_EQ(table.below(5), 10240 + ((5 - 10240) >> 3));
  EXPECT_EQ(table.below(6), 12288u + ((6 + 32752 - 12288) >> 3));
  EXPECT_EQ(table.below(15), 30720u + ((15 + 32752 - 30720) >> 3));
  EXPECT_EQ(table.lanes[0], 32767 >> 3) << "the age";
}

TEST(CumulativeTable, UpdatesAreThoseOfPlainIntegers) {
  std::mt19937 random(1);
  for (const TableRates& rates : {kSlowingRates, kFastRates}) {
    CumulativeTable table = uniform();
    std::array<int, 16> plain;
    for (std::size_t s = 0; s < 16; ++s) plain[s] = table.lanes[s];
    for (std::uint32_t i = 0; i < 100'000; ++i) {
      const std::uint32_t symbol = hostileSymbol(random, i);
      const int rate = rates[static_cast<std::size_t>(plain[0] >> 8)];
      plain[0] += (32767 - plain[0]) >> rate;
      for (int s = 1; s < 16; ++s) {
        int& below = plain[static_cast<std::size_t>(s)];
        below += (s + (static_cast<std::uint32_t>(s) > symbol ? 32752 : 0) - below) >> rate;
      }
      table.update(symbol, rates);
      for (std::size_t s = 0; s < 16; ++s) ASSERT_EQ(table.lanes[s], plain[s]) << i << ' ' << s;
    }
  }
}

TEST(CumulativeTable, EverySymbolKeepsAFrequencyWhateverComes) {
  std::mt19937 random(2);
  for (const TableRates& rates : {kSlowingRates, kFastRates}) {
    CumulativeTable table = uniform();
    for (std::uint32_t i = 0; i < 300'000; ++i) {
      table.update(hostileSymbol(random, i), rates);
      if (i % 7 == 0) expectTable(table);
      ASSERT_GE(table.lanes[0], 0) << "the age stays within 15 bits";
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(CumulativeTable, SlowsDownWithAge) {
  CumulativeTable table = uniform();
  std::vector<int> updates_at_rate(8, 0);
  for (int i = 0; i < 1000; ++i) {
    ++updates_at_rate[static_cast<std::size_t>(kSlowingRates[static_cast<std::size_t>(table.lanes[0] >> 8)])];
    table.update(8, kSlowingRates);
  }
  EXPECT_EQ(updates_at_rate[0] + updates_at_rate[1] + updates_at_rate[2], 0);
  EXPECT_EQ(updates_at_rate[3], 6);
  for (std::size_t rate = 3; rate < 7; ++rate) EXPECT_LT(updates_at_rate[rate], updates_at_rate[rate + 1]) << rate;
}

TEST(CumulativeTable, FindsTheOwnerOfEachSlot) {
  CumulativeTable table = uniform();
  expectFindsEachOwner(table);
  for (const std::uint32_t symbol : {0u, 15u, 7u}) {
    for (int i = 0; i < 2000; ++i) table.update(symbol, kFastRates);  // all others at frequency 1 or nearly so
    expectFindsEachOwner(table);
  }
}

TEST(AveragedTables, AreHalvesOfTheSums) {
  std::mt19937 random(3);
  CumulativeTable a = uniform(), b = uniform();
  for (std::uint32_t i = 0; i < 40'000; ++i) {
    a.update(hostileSymbol(random, i), kFastRates);
    b.update(hostileSymbol(random, i / 3), kSlowingRates);
    const AveragedTables average(a, b);
    expectTable(average);
    for (std::uint32_t s = 1; s < 16; ++s) ASSERT_EQ(average.below(s), (a.below(s) + b.below(s)) >> 1) << s;
    if (i % 1999 == 0) expectFindsEachOwner(average);
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(AveragedTables, AreNeverCertain) {
  CumulativeTable first = uniform(), last = uniform();
  for (int i = 0; i < 5000; ++i) first.update(0, kFastRates);
  for (int i = 0; i < 5000; ++i) last.update(15, kFastRates);
  for (const auto& [a, b] : {std::pair{first, first}, {last, last}, {first, last}}) {
    const AveragedTables average(a, b);
    expectTable(average);
    expectFindsEachOwner(average);
  }
}

}  // namespace
}  // namespace tsc
