#include "residual_mixer.h"

#include <gtest/gtest.h>

#include <random>

namespace tsc {
namespace {

struct Coded {
  ResidualEvidence evidence;
  std::int32_t residual;
};

std::vector<Coded> randomResiduals(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Coded> all;
  for (int i = 0; i < 20000; ++i) {
    Coded coded;
    ResidualEvidence& e = coded.evidence;
    e.unit_shift = static_cast<int>(random() % 20);
    e.voters = 1 + static_cast<int>(random() % 3);
    const auto number = [&] { return static_cast<std::int32_t>(random()) >> (3 + random() % 28); };
    for (std::size_t part = 0; part < 2; ++part) {
      for (int k = 0; k < 4; ++k) {
        e.prediction[part][k] = std::clamp(number(), -kPredictionLimit, kPredictionLimit);
        e.prediction_context[part][k] = static_cast<int>(random() % kPredictionContexts);
      }
    }
    for (int k = 0; k < 4; ++k) {
      e.present[k] = -(k <= e.voters);
      e.context[k] = static_cast<int>(random() % kContextValues);
    }
    e.weight_set = {static_cast<std::uint8_t>(random() % 14), static_cast<std::uint8_t>(random() % 36)};
    coded.residual = random() % 4 == 0 ? e.prediction[0][0] >> 4 : number();
    all.push_back(coded);
  }
  all[7].residual = (1 << 28) - 1;
  all[8].residual = -(1 << 28);
  all[9].residual = 1 << 23;
  return all;
}

TEST(ResidualMixer, EveryResidualComesBack) {
  for (const bool lattice : {false, true}) {
    const std::vector<Coded> all = randomResiduals(5);
    EntropyWriter writer;
    ResidualMixer<Writing> encoder(Writing{writer}, lattice);
    for (const Coded& coded : all) ASSERT_EQ(encoder.code(coded.evidence, coded.residual), coded.residual);
    std::vector<std::byte> bytes;
    writer.finish(2, bytes);
    EntropyReader reader(bytes);
    ResidualMixer<Reading> decoder(Reading{reader}, lattice);
    for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(decoder.code(all[i].evidence, 0), all[i].residual) << i;
    EXPECT_TRUE(reader.atEnd());
    EXPECT_EQ(reader.state(), finalState(2));
  }
}

TEST(ResidualMixer, APredictionThatHoldsCostsNextToNothing) {
  EntropyWriter writer;
  ResidualMixer<Writing> encoder(Writing{writer}, true);
  std::mt19937 random(6);
  std::size_t mark = 0;
  for (int i = 0; i < 6000; ++i) {
    if (i == 5000) mark = writer.mark();
    ResidualEvidence e;
    e.unit_shift = 4;
    e.voters = 3;
    for (int k = 0; k < 4; ++k) e.prediction[0][k] = 16 * (static_cast<std::int32_t>(random() % 400) - 200);
    e.present = splatInteger(-1);
    encoder.code(e, e.prediction[0][2] / 16);
  }
  EXPECT_LT(writer.bitsSince(mark) / 1000, 0.8);
}

TEST(ResidualMixer, DamagedStreamsStayWithinRange) {
  std::mt19937 random(7);
  std::vector<std::byte> bytes(40000);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  EntropyReader reader(bytes);
  ResidualMixer<Reading> decoder(Reading{reader}, true);
  for (const Coded& coded : randomResiduals(8)) {
    ASSERT_LE(std::abs(std::int64_t{decoder.code(coded.evidence, 0)}), std::int64_t{1} << 30);
  }
}

}  // namespace
}  // namespace tsc
