#include "logistic.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

namespace tsc {
namespace {

using Weights = LaneWeights<8, 2000, 3000, 1500>;

TEST(Chances, ApproachWhatComesEachByItself) {
  Integers chance = splatInteger(chances::kUnknown);
  EXPECT_TRUE(isZero(chances::stretched(chance)));
  for (int i = 0; i < 3000; ++i) chance = chances::updated(chance, splatInteger(65535));
  for (int k = 0; k < 4; ++k) EXPECT_GT(chances::stretched(chance)[k], 900);
  for (int i = 0; i < 5000; ++i) chance = chances::updated(chance, Integers{0, 65535, 0, 65535});
  EXPECT_LT(chances::stretched(chance)[0], -900);
  EXPECT_GT(chances::stretched(chance)[1], 900);
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i) chance = chances::updated(chance, splatInteger(random() % 4 == 0 ? 65535 : 0));
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(chance[k] & 0xffff, 16384, 4000);
}

TEST(Chances, OneUpdateAsWritten) {
  for (std::int32_t p = 0; p < 65536; p += 77) {
    for (std::int32_t rate = chances::kSlowest; rate < 32768; rate += 501) {
      const std::int32_t next_rate = std::max<std::int32_t>(rate - (rate * rate >> 16), chances::kSlowest);
      const auto product = [&](std::int32_t x) { return static_cast<std::int32_t>(std::int64_t{x} * rate >> 16); };
      const Integers chance = splatInteger(rate << 16 | p);
      const std::int32_t down = p - product(p), up = 65535 - ((65535 - p) - product(65535 - p));
      EXPECT_EQ(chances::updated(chance, splatInteger(0))[3], next_rate << 16 | down);
      EXPECT_EQ(chances::updated(chance, splatInteger(65535))[1], next_rate << 16 | up);
    }
  }
}

TEST(Chances, StretchedGrowsAndMirrors) {
  const auto stretched = [](std::int32_t p) { return chances::stretched(splatInteger(p))[0]; };
  EXPECT_EQ(stretched(65535), 17 * 128 - 1);
  for (std::int32_t p = 0; p < 65535; ++p) {
    ASSERT_LE(stretched(p), stretched(p + 1)) << p;
    ASSERT_NEAR(stretched(p) + stretched(65535 - p), 0, 1) << p;
  }
}

TEST(Squash, GrowsAndMirrors) {
  EXPECT_EQ(squash(0), 32768);
  for (int x = -kStretchLimit; x < kStretchLimit; ++x) {
    ASSERT_LE(squash(x), squash(x + 1)) << x;
    ASSERT_NEAR(squash(x) + squash(-x), 65536, 2) << x;
  }
  EXPECT_GE(squash(-kStretchLimit), 1);
  EXPECT_LE(squash(kStretchLimit), 65535);
}

TEST(Squash, UndoesStretching) {
  // One input and a weight that turns its 2^-7 octaves into 2^-8 nats: off by little more than the two interpolations.
  for (std::int32_t p = 256; p <= 65536 - 256; p += 16) {
    const std::int32_t weight = 22713;  // 2 ln 2 in units of 2^-14
    const int mixed = mixedProbability(weight * chances::stretched(splatInteger(p))[0]);
    ASSERT_NEAR(mixed, p, 0.08 * std::min(p, 65536 - p) + 1) << p;
  }
}

TEST(LaneWeights, LearnWhichInputIsRight) {
  Weights weights;
  std::mt19937 random(2);
  int squares = 0;
  for (int i = 0; i < 4000; ++i) {
    const bool bit = random() % 2 != 0;
    Lanes inputs{};
    inputs[0] = bit ? 300 : -300;
    for (int k = 1; k < 8; ++k) inputs[k] = static_cast<std::int16_t>(static_cast<int>(random() % 1200) - 600);
    const int error = (bit ? 65535 : 0) - mixedProbability(dotProduct(weights.part(0), inputs));
    weights.learn(0, inputs, weights.step(error));
    if (i >= 3000) squares += std::abs(error) < 16384;
  }
  EXPECT_GT(squares, 900);
}

TEST(LaneWeights, StayWithinBoundsWhateverComes) {
  LaneWeights<8, 5500, 32767, 1500> weights;
  const Lanes inputs = splat(17 * 128 - 1);
  for (int i = 0; i < 100000; ++i) {
    const int probability = mixedProbability(dotProduct(weights.part(0), inputs));
    ASSERT_GE(probability, 1);
    ASSERT_LE(probability, 65535);
    const std::int16_t before = weights.weight[0];
    const bool up = i % 1000 < 999;
    weights.learn(0, inputs, weights.step(up ? 65535 : -65535));
    ASSERT_TRUE(up ? weights.weight[0] >= before : weights.weight[0] <= before) << i;
  }
  EXPECT_GE(weights.rate, 1500);
}

}  // namespace
}  // namespace tsc
