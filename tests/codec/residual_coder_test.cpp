#include "residual_coder.h"

#include <gtest/gtest.h>

#include <random>

namespace tsc {
namespace {

struct Coded {
  Component component;
  ResidualContext context;
  std::int32_t residual;
};

std::vector<Coded> randomResiduals(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Coded> all;
  for (int i = 0; i < 20000; ++i) {
    Surroundings around;
    around.stencil_count = 1 + static_cast<int>(random() % 4);
    for (int a = 0; a < 3; ++a) {
      around.residual[a] = (random() % (16 * kMaxMagnitude)) >> random() % 18;
      around.disagreement[a] = (random() % (1u << 21)) >> random() % 21;
    }
    around.gate = random() >> random() % 32;
    Coded coded;
    coded.component.axis = static_cast<int>(random() % 3);
    coded.component.count_class = std::min(around.stencil_count, kCountClasses) - 1;
    coded.component.candidate_count = std::min(around.stencil_count, kCandidates);
    coded.component.hits_around = static_cast<int>(random() % 3);
    coded.component.hits = static_cast<std::uint8_t>(random() % 8);
    coded.context = residualContext(around, coded.component.axis);
    const auto number = [&] { return static_cast<std::int32_t>(random()) >> (4 + random() % 28); };
    for (std::int32_t& candidate : coded.component.candidates) candidate = number();
    coded.residual = random() % 4 == 0 ? coded.component.candidates[0] : number();
    all.push_back(coded);
  }
  return all;
}

TEST(ResidualCoder, EveryResidualComesBack) {
  for (const Effort effort : {Effort::kDefault, Effort::kMax}) {
    for (const bool exact_hits : {false, true}) {
      const std::vector<Coded> all = randomResiduals(5);
      EntropyWriter writer;
      ResidualCoder<Writing> encoder(Writing{writer}, exact_hits, effort);
      std::vector<std::uint8_t> hits;
      for (Coded coded : all) {
        ASSERT_EQ(encoder.code(coded.component, coded.context, coded.residual), coded.residual);
        hits.push_back(coded.component.hits);
      }
      std::vector<std::byte> bytes;
      writer.finish(2, bytes);
      EntropyReader reader(bytes);
      ResidualCoder<Reading> decoder(Reading{reader}, exact_hits, effort);
      for (std::size_t i = 0; i < all.size(); ++i) {
        Component component = all[i].component;
        ASSERT_EQ(decoder.code(component, all[i].context, 0), all[i].residual) << i;
        ASSERT_EQ(component.hits, hits[i]) << i;
      }
      EXPECT_TRUE(reader.atEnd());
      EXPECT_EQ(reader.state(), kCoderStateMin + 2);
    }
  }
}

TEST(ResidualContext, StaysWithinItsRanges) {
  std::mt19937 random(6);
  for (int i = 0; i < 200000; ++i) {
    Surroundings around;
    around.stencil_count = 1 + static_cast<int>(random() % 6);
    for (int a = 0; a < 3; ++a) {
      around.residual[a] = 16 * kMaxMagnitude >> random() % 19;
      around.disagreement[a] = (1u << 21) >> random() % 22;
    }
    around.gate = 0xffffffffu >> random() % 32;
    for (int a = 0; a < 3; ++a) {
      const ResidualContext context = residualContext(around, a);
      ASSERT_GE(context.shift, 0);
      ASSERT_LT(context.shift, kShiftClasses);
      ASSERT_GE(context.scale, 0);
      ASSERT_LT(context.scale, kScaleClasses);
      ASSERT_GE(context.ratio, 0);
      ASSERT_LT(context.ratio, kRatioClasses);
    }
  }
}

}  // namespace
}  // namespace tsc
