#include "residual.h"

#include <gtest/gtest.h>

namespace tsc {
namespace {

TEST(FirstWindow, ByHand) {
  // Weights fall by 1/8 a bin, over 64: 64 64 64 64 68 96 320 2112 16448 2112 ...; 32752 parts of their sum, and one
  // more for each bin.
  const CumulativeTable table = firstWindow(8);
  const std::int16_t expected[16] = {0,    95,    191,   287,   383,   485,   628,   1104,
                                     4236, 28626, 31759, 32235, 32378, 32480, 32576, 32672};
  for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(table.lanes[i], expected[i]) << i;
}

TEST(FirstWindow, FallsOffOnBothSidesOfTheCentre) {
  for (int decay = 1; decay < 64; ++decay) {
    const CumulativeTable table = firstWindow(decay);
    EXPECT_EQ(table.lanes[0], 0) << "the age";
    const auto share = [&](int bin) {
      const auto b = static_cast<std::uint32_t>(bin);
      return static_cast<int>(table.below(b + 1) - table.below(b));
    };
    for (int distance = 0; distance < kWindowCentre; ++distance) {
      EXPECT_GE(share(kWindowCentre - distance) + 1, share(kWindowCentre - distance - 1)) << decay;
      if (distance == kWindowCentre - 1) continue;
      EXPECT_NEAR(share(kWindowCentre - distance), share(kWindowCentre + distance), 1) << decay;
    }
    EXPECT_GT(share(0), 32) << "no bin is far from possible";
  }
}

TEST(ResidualRates, GrowAfterFourTwelveAndFortyUpdates) {
  CumulativeTable table = firstWindow(8);
  std::vector<int> updates_at_rate(7, 0);
  for (int i = 0; i < 1000; ++i) {
    ++updates_at_rate[static_cast<std::size_t>(kResidualRates[static_cast<std::size_t>(table.lanes[0] >> 8)])];
    table.update(8, kResidualRates);
  }
  EXPECT_EQ(updates_at_rate, (std::vector<int>{0, 0, 0, 4, 8, 28, 960}));
}

}  // namespace
}  // namespace tsc
