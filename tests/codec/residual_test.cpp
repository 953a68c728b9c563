#include "residual.h"

#include <gtest/gtest.h>

#include <random>

namespace tsc {
namespace {

void expectTable(const BinTable& table) {
  // Lane 0 counts updates; the others ascend and leave room for a frequency of one for each bin of the window.
  for (int i = 2; i < kTableBins; ++i) ASSERT_GE(table.below[i], table.below[i - 1]) << i;
  ASSERT_GE(table.below[1], 0);
  ASSERT_LE(table.below[kTableBins - 1], kTableTotal);
}

TEST(BinTable, StartsAroundItsCentre) {
  const BinTable table;
  expectTable(table);
  EXPECT_EQ(table.below[0], 0);
  int largest = 0, at = 0;
  for (int i = 1; i + 1 < kTableBins; ++i) {
    const int frequency = table.below[i + 1] - table.below[i];
    if (frequency > largest) {
      largest = frequency;
      at = i;
    }
  }
  EXPECT_EQ(at, kTableCentre);
}

TEST(BinTable, StaysATableWhateverComes) {
  std::mt19937 random(1);
  BinTable table;
  for (int i = 0; i < 1'000'000; ++i) {
    table.update(static_cast<int>(i / 1000 % 2 == 0 ? random() % kTableBins : i / 5000 % kTableBins));
    if (i % 13 == 0) expectTable(table);
    if (testing::Test::HasFailure()) return;
  }
}

TEST(MixWeights, SharesStayWithinTheirSum) {
  std::mt19937 random(2);
  for (int experts = 1; experts <= kMaxExperts; ++experts) {
    MixWeights weights(experts);
    for (int i = 0; i < 300'000; ++i) {
      std::array<std::uint32_t, kMaxExperts> frequency{};
      for (int j = 0; j < experts; ++j) {
        frequency[static_cast<std::size_t>(j)] =
            i / 2000 % 2 == 0 ? random() % kTableTotal : (i / 4000 % experts == j ? kTableTotal : 0);
      }
      weights.update(frequency);
      std::uint32_t sum = 0;
      for (const std::uint32_t share : weights.share) {
        ASSERT_LE(share, 65535u);
        sum += share;
      }
      ASSERT_LE(sum, 65536u + 4);
    }
    for (int j = 0; j < experts; ++j) EXPECT_GT(weights.share[static_cast<std::size_t>(j)], 100u) << "none dies out";
  }
}

TEST(Bin, EveryBinComesBackFromEveryOffset) {
  std::mt19937 random(3);
  struct Step {
    int bin, first_offset, second_offset;
  };
  std::vector<Step> steps;
  for (int i = 0; i < 30000; ++i) {
    const auto offset = [&] { return static_cast<int>(random() % (2 * kMaxOffset + 1)) - kMaxOffset; };
    const int first = offset(), second = offset();
    steps.push_back({static_cast<int>(i % 3 == 0 ? random() % kWindowBins : i / 999 % kWindowBins), first, second});
  }
  const auto run = [&](auto direction) {
    BinTable common, single;
    MixWeights weights(3);
    for (const Step& step : steps) {
      const Mixture<3> mixture{{&common, &single, &single}, {0, step.first_offset, step.second_offset}};
      ASSERT_EQ(codeBin<1>(direction, mixture, weights, step.bin), step.bin);
    }
  };
  EntropyWriter writer;
  run(Writing{writer});
  std::vector<std::byte> bytes;
  writer.finish(1, bytes);
  EntropyReader reader(bytes);
  run(Reading{reader});
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.state(), kCoderStateMin + 1);
}

}  // namespace
}  // namespace tsc
