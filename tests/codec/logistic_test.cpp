#include "logistic.h"

#include <gtest/gtest.h>

#include <random>

namespace tsc {
namespace {

TEST(Logistic, SquashGrowsAndMirrors) {
  EXPECT_EQ(squash(0), 32768);
  for (int x = -kStretchLimit; x < kStretchLimit; ++x) {
    ASSERT_LE(squash(x), squash(x + 1)) << x;
    ASSERT_NEAR(squash(x) + squash(-x), 65536, 2) << x;
  }
  EXPECT_GE(squash(-kStretchLimit), 1);
  EXPECT_LE(squash(kStretchLimit), 65535);
}

TEST(Logistic, StretchUndoesSquash) {
  EXPECT_EQ(kStretch[2048], 0);
  for (int i = 0; i < 4096; ++i) {
    const int x = kStretch[static_cast<std::size_t>(i)];
    ASSERT_LE(std::abs(x), kStretchLimit);
    if (x < kStretchLimit) {
      ASSERT_GE(squash(x), 16 * i);
    }
    if (x > -kStretchLimit) {
      ASSERT_LT(squash(x - 1), 16 * i);
    }
  }
}

TEST(Chance, ApproachesWhatComes) {
  Chance chance;
  EXPECT_EQ(chance.stretched(), 0);
  for (int i = 0; i < 1000; ++i) chance.update(true);
  EXPECT_GT(chance.stretched(), 1400);
  for (int i = 0; i < 5000; ++i) chance.update(false);
  EXPECT_LT(chance.stretched(), -1400);
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i) chance.update(random() % 4 == 0);
  EXPECT_NEAR(squash(chance.stretched()), 16384, 4000);
}

TEST(Chance, AnInertOneLearnsNothing) {
  Chance chance{0, Chance::kInert};
  for (int i = 0; i < 100; ++i) chance.update(i % 3 == 0);
  EXPECT_EQ(chance.stretched(), 0);
  EXPECT_EQ(chance.count, Chance::kInert);
}

TEST(MixerWeights, LearnWhichInputIsRight) {
  MixerWeights weights;
  std::mt19937 random(2);
  int squares = 0;
  for (int i = 0; i < 4000; ++i) {
    const bool bit = random() % 2 != 0;
    MixerInputs inputs{};
    inputs[0] = bit ? 300 : -300;
    for (std::size_t k = 1; k < 12; ++k) inputs[k] = static_cast<std::int16_t>(random() % 1200) - 600;
    const int error = (bit ? 65535 : 0) - squash(weights.mix(inputs));
    weights.learn(inputs, error);
    if (i >= 3000) squares += std::abs(error) < 8192;
  }
  EXPECT_GT(squares, 950);
}

TEST(MixerWeights, StayDefinedWhateverComes) {
  MixerWeights weights;
  MixerInputs inputs;
  inputs.fill(kStretchLimit);
  for (int i = 0; i < 100000; ++i) {
    const int x = weights.mix(inputs);
    ASSERT_LE(std::abs(x), kStretchLimit);
    weights.learn(inputs, i % 1000 < 999 ? 65535 : -65535);
  }
}

TEST(EightWeights, DoAsSixteenWouldWithNoOtherInputs) {
  MixerWeights sixteen;
  EightWeights eight;
  std::mt19937 random(3);
  for (int i = 0; i < 4000; ++i) {
    MixerInputs inputs{};
    for (std::size_t k = 0; k < 8; ++k) {
      inputs[k] = static_cast<std::int16_t>(random() % (2 * kStretchLimit + 1)) - kStretchLimit;
    }
    const int error = static_cast<int>(random() % 131071) - 65535;
    ASSERT_EQ(eight.mix(loadLanes(inputs.data())), sixteen.mix(inputs));
    eight.learn(loadLanes(inputs.data()), error);
    sixteen.learn(inputs, error);
  }
}

}  // namespace
}  // namespace tsc
