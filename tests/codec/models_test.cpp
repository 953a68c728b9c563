#include "models.h"

#include <gtest/gtest.h>

#include <random>

#include "direction.h"

namespace tsc {
namespace {

TEST(SymbolModel, StartsUniform) {
  const SymbolModel model;
  for (std::uint32_t s = 0; s <= 16; ++s) EXPECT_EQ(model.below(s), 2048 * s);
}

// First update: rate 3. Targets of symbol 5: s up to 5, s + 2^15 - 16 beyond.
TEST(SymbolModel, FirstUpdateByHand) {
  SymbolModel model;
  model.update(5);
  EXPECT_EQ(model.below(1), 2048 + ((1 - 2048) >> 3));
  EXPECT_EQ(model.below(5), 10240 + ((5 - 10240) >> 3));
  EXPECT_EQ(model.below(6), 12288u + ((6 + 32752 - 12288) >> 3));
  EXPECT_EQ(model.below(15), 30720u + ((15 + 32752 - 30720) >> 3));
}

TEST(SymbolModel, FrequenciesStayPositive) {
  std::mt19937 random(1);
  SymbolModel model;
  for (int i = 0; i < 3'000'000; ++i) {
    // Long runs of one symbol drive the others to the ground; then noise.
    const std::uint32_t symbol = i / 1000 % 3 == 0 ? random() % 16 : i / 5000 % 16;
    model.update(symbol);
    if (i % 7 != 0) continue;
    for (std::uint32_t s = 0; s < 16; ++s) ASSERT_GE(model.below(s + 1), model.below(s) + 1) << i;
  }
}

TEST(SymbolModel, FindsTheOwnerOfEachSlot) {
  SymbolModel model;
  for (int i = 0; i < 100; ++i) model.update(i % 3 == 0 ? 9 : 2);
  for (std::uint32_t slot = 0; slot < kProbabilityOne; ++slot) {
    const std::uint32_t symbol = model.find(slot);
    ASSERT_LE(model.below(symbol), slot);
    ASSERT_GT(model.below(symbol + 1), slot);
  }
}

TEST(Models, EverythingComesBack) {
  std::mt19937 random(2);
  struct Value {
    bool bit;
    std::uint32_t symbol, integer;
  };
  std::vector<Value> values;
  for (int i = 0; i < 20000; ++i) {
    values.push_back({random() % 50 == 0, static_cast<std::uint32_t>(random() % 16 & random()),
                      static_cast<std::uint32_t>(random() % (1u << 30)) >> random() % 31});
  }
  values.push_back({true, 15, (1u << 30) - 1});
  values.push_back({false, 0, 0});
  const auto run = [&](auto direction) {
    BitModel bit;
    SymbolModel symbol;
    IntegerModel integer;
    for (const Value& v : values) {
      EXPECT_EQ(direction.bit(bit, v.bit), v.bit);
      EXPECT_EQ(direction.symbol(symbol, v.symbol), v.symbol);
      EXPECT_EQ(direction.integer(integer, v.integer), v.integer);
    }
  };
  EntropyWriter writer;
  run(Writing{writer});
  std::vector<std::byte> bytes;
  writer.finish(7, bytes);
  EntropyReader reader(bytes);
  run(Reading{reader});
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.state(), finalState(7));
}

TEST(BitModel, LearnsButNeverBecomesCertain) {
  for (const bool likely : {false, true}) {
    BitModel model;
    EntropyWriter writer;
    for (int i = 0; i < 100000; ++i) model.put(writer, likely);
    std::size_t mark = writer.mark();
    model.put(writer, likely);
    EXPECT_LT(writer.bitsSince(mark), 0.003);
    mark = writer.mark();
    model.put(writer, !likely);
    EXPECT_LT(writer.bitsSince(mark), 10.1) << "2^15 / 31 at worst";
  }
}

// 16384 + ((32737 - 16384) >> 5) = 16895; from there, 16895 + ((31 - 16895) >> 5) = 16368.
TEST(HitModel, UpdatesByHand) {
  HitModel model;
  EXPECT_EQ(model.one(true), 16384u);
  model.update(true, true);
  EXPECT_EQ(model.one(true), 16895u);
  model.update(false, true);
  EXPECT_EQ(model.one(true), 16368u);
}

TEST(HitModel, AnImpossibleHitTakesNothingAndTeachesNothing) {
  HitModel model;
  model.update(true, true);
  EXPECT_EQ(model.one(false), 0u);
  model.update(false, false);
  EXPECT_EQ(model.one(true), 16895u);

  EntropyWriter writer;
  Writing writing{writer};
  Hot<Writing> encoder(writing);
  HitModel written, read;
  std::mt19937 random(3);
  std::vector<std::pair<bool, bool>> all;  // possible, hit
  for (int i = 0; i < 2000; ++i) all.emplace_back(random() % 2 == 0, random() % 8 == 0);
  for (const auto& [possible, hit] : all) {
    const std::size_t mark = writer.mark();
    EXPECT_EQ(encoder.hit(written, possible, hit), possible && hit);
    EXPECT_EQ(writer.mark() - mark, possible ? 1u : 0u);
    encoder.endGroup();
  }
  std::vector<std::byte> bytes;
  writer.finish(8, bytes);
  EntropyReader reader(bytes);
  Reading reading{reader};
  Hot<Reading> decoder(reading);
  for (const auto& [possible, hit] : all) {
    ASSERT_EQ(decoder.hit(read, possible, false), possible && hit);
    decoder.endGroup();
  }
  decoder.to(reading);
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.state(), finalState(8));
}

TEST(HitModel, NeverBecomesCertain) {
  for (const bool likely : {false, true}) {
    HitModel model;
    for (int i = 0; i < 10000; ++i) model.update(likely, true);
    EXPECT_NEAR(model.one(true), likely ? kProbabilityOne - 31 : 31, 31);
    EXPECT_GE(model.one(true), 31u);
    EXPECT_LE(model.one(true), kProbabilityOne - 31);
  }
}

TEST(Zigzag, ByHand) {
  EXPECT_EQ(zigzag(0), 0u);
  EXPECT_EQ(zigzag(-1), 1u);
  EXPECT_EQ(zigzag(1), 2u);
  EXPECT_EQ(zigzag(-2147483647 - 1), 0xffffffffu);
  for (const std::int32_t value : {0, 1, -1, 12345, -99999, 2147483647, -2147483647 - 1}) {
    EXPECT_EQ(unzigzag(zigzag(value)), value);
  }
}

}  // namespace
}  // namespace tsc
