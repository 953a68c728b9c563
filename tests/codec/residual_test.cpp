#include "residual.h"

#include <gtest/gtest.h>

#include <random>

namespace tsc {
namespace {

/// Cumulative frequencies ascend: with one more for each bin of the window, every bin has a frequency.
template <int kBins>
void expectTable(const BinTable<kBins>& table) {
  int before = 0;
  for (std::size_t i = 1; i < kBins; ++i) {
    ASSERT_GE(table.below[i], before) << i;
    before = table.below[i];
  }
  ASSERT_LE(before, kTableTotal);
  ASSERT_GE(table.below[0], 0) << "the age";
}

template <class Table>
class BinTables : public testing::Test {};
using Tables = testing::Types<CentredTable, ShiftedTable>;
TYPED_TEST_SUITE(BinTables, Tables);

TYPED_TEST(BinTables, StartAroundTheirCentre) {
  for (const int decay : {6, 19, 44}) {
    const TypeParam table(decay);
    expectTable(table);
    EXPECT_EQ(table.below[0], 0);
    const std::size_t centre = table.below.size() / 2;
    const int largest = table.below[centre + 1] - table.below[centre];
    for (std::size_t i = 1; i + 1 < table.below.size(); ++i) {
      if (i != centre) {
        EXPECT_LT(table.below[i + 1] - table.below[i], largest) << i;
      }
    }
  }
}

TEST(BinTable, FirstOnesByHand) {
  EXPECT_EQ(CentredTable(8).below, (std::array<std::int16_t, 16>{0, 94, 189, 284, 379, 480, 622, 1096, 4226, 28603,
                                                                31734, 32208, 32350, 32451, 32546, 32641}));
  EXPECT_EQ(ShiftedTable(42).below[16], 13054);
}

TEST(BinTable, FirstUpdateByHand) {
  CentredTable table(8);
  const CentredTable before = table;
  table.update(8);
  for (std::size_t i = 1; i < 16; ++i) {
    const int target = i > 8 ? kTableTotal : 0;
    EXPECT_EQ(table.below[i], before.below[i] + ((target - before.below[i]) >> 3));
  }
  EXPECT_EQ(table.below[0], 32767 >> 3);
}

TEST(BinTable, SlowsDownWithAge) {
  CentredTable table(8);
  std::vector<int> updates_at_rate(7, 0);
  for (int i = 0; i < 1000; ++i) {
    ++updates_at_rate[kAdaptationRates[static_cast<std::size_t>(table.below[0] >> 8)]];
    table.update(8);
  }
  EXPECT_EQ(updates_at_rate, (std::vector<int>{0, 0, 0, 4, 8, 28, 960}));
}

TYPED_TEST(BinTables, StayTablesWhateverComes) {
  std::mt19937 random(1);
  TypeParam table(19);
  const auto bins = static_cast<int>(table.below.size());
  for (int i = 0; i < 1'000'000; ++i) {
    // Noise, one bin over and over, the two ends in turn, and bins in a row.
    const int phase = i / 1000 % 4;
    const int bin = phase == 0   ? static_cast<int>(random() % static_cast<unsigned>(bins))
                    : phase == 1 ? i / 4000 % bins
                    : phase == 2 ? i % 2 * (bins - 1)
                                 : i % bins;
    table.update(bin);
    if (i % 13 == 0) expectTable(table);
    if (testing::Test::HasFailure()) return;
  }
}

TEST(MixWeights, SharesStayWithinTheirSum) {
  std::mt19937 random(2);
  MixWeights weights;
  for (unsigned i = 0; i < 600'000; ++i) {
    std::array<std::uint32_t, kExperts> frequency{};
    for (unsigned j = 0; j < kExperts; ++j) {
      const unsigned phase = i / 2000 % 3;
      frequency[j] = phase == 0   ? static_cast<unsigned>(random()) % kTableTotal
                     : phase == 1 ? (i / 6000 % kExperts == j ? kTableTotal : 0)
                                  : 0;
    }
    weights.update(frequency);
    std::uint32_t sum = 0;
    for (const std::uint32_t share : weights.share) {
      ASSERT_LE(share, 65535u);
      sum += share;
    }
    ASSERT_LE(sum, 65536u + 3);
  }
  for (const std::uint32_t share : weights.share) EXPECT_GT(share, 100u) << "none dies out";
}

struct Step {
  int bin, first_offset, second_offset;
  bool mixed, learns;
};

std::vector<Step> steps(bool adversarial) {
  std::mt19937 random(3);
  std::vector<Step> all;
  for (int i = 0; i < 60000; ++i) {
    const auto offset = [&] { return static_cast<int>(random() % (2 * kMaxOffset + 1)) - kMaxOffset; };
    int first = offset(), second = offset();
    auto bin = static_cast<int>(i % 3 == 0 ? random() % kWindowBins : static_cast<unsigned>(i / 999 % kWindowBins));
    if (adversarial) {
      // Long runs of one bin, until all tables have given up all others; then the others.
      bin = i % 4000 < 3900 ? i / 4000 % 2 * (kWindowBins - 1) : i % kWindowBins;
      first = second = i / 8000 % 2 == 0 ? kMaxOffset : -kMaxOffset;
    }
    all.push_back({bin, first, second, i % 5 != 0, i % 4 != 3});
  }
  return all;
}

template <class Coder>
void code(Coder& coder, const std::vector<Step>& all) {
  CentredTable centred(25);
  ShiftedTable shifted(25);
  MixWeights weights;
  for (const Step& s : all) {
    const int bin = s.mixed ? codeBin<2>(coder, centred, shifted, s.first_offset, s.second_offset, weights, s.learns, s.bin)
                            : codeBin<1>(coder, centred, s.bin);
    ASSERT_EQ(bin, s.bin);
  }
}

TEST(Bin, EveryBinComesBackFromEveryOffset) {
  for (const bool adversarial : {false, true}) {
    const std::vector<Step> all = steps(adversarial);
    EntropyWriter writer;
    Writing writing{writer};
    Hot<Writing> encoder(writing);
    code(encoder, all);
    std::vector<std::byte> bytes;
    writer.finish(1, bytes);
    EntropyReader reader(bytes);
    Reading reading{reader};
    Hot<Reading> decoder(reading);
    code(decoder, all);
    decoder.to(reading);
    EXPECT_TRUE(reader.atEnd());
    EXPECT_EQ(reader.states(), finalStates(1));
  }
}

}  // namespace
}  // namespace tsc
