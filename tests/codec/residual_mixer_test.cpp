#include "residual_mixer.h"

#include <gtest/gtest.h>

#include <random>

namespace tsc {
namespace {

struct Coded {
  ResidualEvidence evidence;
  std::int32_t residual;
};

std::vector<Coded> randomResiduals(std::uint32_t seed, int prediction_count) {
  std::mt19937 random(seed);
  std::vector<Coded> all;
  for (int i = 0; i < 20000; ++i) {
    Coded coded;
    ResidualEvidence& e = coded.evidence;
    e.unit_shift = static_cast<int>(random() % 20);
    e.voters = static_cast<int>(random() % 4);
    const auto number = [&] { return static_cast<std::int32_t>(random()) >> (3 + random() % 28); };
    for (std::size_t k = 0; k < static_cast<std::size_t>(prediction_count); ++k) {
      e.prediction[k] = std::clamp(number(), -kPredictionLimit, kPredictionLimit);
      e.prediction_context[k] = static_cast<std::uint8_t>(random() % kPredictionContexts);
      e.present[k] = k == 0 || k > kVoters || static_cast<int>(k) <= e.voters;
    }
    for (std::uint16_t& context : e.context) context = static_cast<std::uint16_t>(random() % kContextValues);
    e.weight_set = {static_cast<std::uint8_t>(random() % 14), static_cast<std::uint8_t>(random() % 36)};
    coded.residual = random() % 4 == 0 ? e.prediction[0] >> 4 : number();
    all.push_back(coded);
  }
  all[7].residual = (1 << 28) - 1;
  all[8].residual = -(1 << 28);
  all[9].residual = 1 << 23;
  return all;
}

TEST(ResidualMixer, EveryResidualComesBack) {
  for (const int prediction_count : {1 + kVoters, kMixedPredictions}) {
    const std::vector<Coded> all = randomResiduals(5, prediction_count);
    EntropyWriter writer;
    ResidualMixer<Writing> encoder(Writing{writer}, prediction_count);
    for (const Coded& coded : all) ASSERT_EQ(encoder.code(coded.evidence, coded.residual), coded.residual);
    std::vector<std::byte> bytes;
    writer.finish(2, bytes);
    EntropyReader reader(bytes);
    ResidualMixer<Reading> decoder(Reading{reader}, prediction_count);
    for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(decoder.code(all[i].evidence, 0), all[i].residual) << i;
    EXPECT_TRUE(reader.atEnd());
    EXPECT_EQ(reader.states(), finalStates(2));
  }
}

TEST(ResidualMixer, APredictionThatHoldsCostsNextToNothing) {
  EntropyWriter writer;
  ResidualMixer<Writing> encoder(Writing{writer}, kMixedPredictions);
  std::mt19937 random(6);
  std::size_t mark = 0;
  for (int i = 0; i < 6000; ++i) {
    if (i == 5000) mark = writer.mark();
    ResidualEvidence e;
    e.unit_shift = 4;
    e.voters = 3;
    for (std::size_t k = 0; k < 4; ++k) {
      e.prediction[k] = 16 * (static_cast<std::int32_t>(random() % 400) - 200);
      e.present[k] = true;
    }
    encoder.code(e, e.prediction[2] / 16);
  }
  EXPECT_LT(writer.bitsSince(mark) / 1000, 0.8);
}

TEST(ResidualMixer, DamagedStreamsStayWithinRange) {
  std::mt19937 random(7);
  std::vector<std::byte> bytes(40000);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  EntropyReader reader(bytes);
  ResidualMixer<Reading> decoder(Reading{reader}, kMixedPredictions);
  for (const Coded& coded : randomResiduals(8, kMixedPredictions)) {
    ASSERT_LE(std::abs(std::int64_t{decoder.code(coded.evidence, 0)}), std::int64_t{1} << 30);
  }
}

}  // namespace
}  // namespace tsc
