#include "context_tables.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace tsc {
namespace {

constexpr std::array<std::int16_t, 16> kPrior = {0,     1000,  3000,  9000,  12000, 15000, 17000, 18000,
                                                 20000, 22000, 24000, 26000, 28000, 29000, 30000, 31000};

/// BITSTREAM.md, sections 4.4 and 5.3, in plain integers.
class PlainModel {
 public:
  explicit PlainModel(int table_bits) : table_bits_(table_bits) {}

  std::uint32_t get(EntropyReader& reader, const AveragedModel::Context& context) {
    Table& parent = tables_.try_emplace({0, context.parent}, Table{prior(), 13000}).first->second;
    const Table copy = {parent.below, 4096};
    Table& a = tables_.try_emplace({1, numberOf(context.first)}, copy).first->second;
    Table& b = tables_.try_emplace({2, numberOf(context.second)}, copy).first->second;
    std::array<int, 17> mean{};
    for (std::size_t s = 1; s < 16; ++s) mean[s] = (a.below[s] + b.below[s]) / 2;
    mean[16] = 32768;
    const auto slot = static_cast<int>(reader.peek());
    std::uint32_t symbol = 0;
    while (mean[symbol + 1] <= slot) ++symbol;
    reader.advance(static_cast<std::uint32_t>(mean[symbol]),
                   static_cast<std::uint32_t>(mean[symbol + 1] - mean[symbol]));
    for (Table* table : {&parent, &a, &b}) update(*table, static_cast<int>(symbol));
    return symbol;
  }

 private:
  struct Table {
    std::array<int, 16> below;
    int age;
  };

  static std::array<int, 16> prior() {
    std::array<int, 16> below;
    std::copy(kPrior.begin(), kPrior.end(), below.begin());
    return below;
  }
  std::uint32_t numberOf(std::uint32_t context) const {
    return static_cast<std::uint32_t>(std::uint64_t{context} * 0x9e3779b1u % (std::uint64_t{1} << 32) >>
                                      (32 - table_bits_));
  }
  static void update(Table& table, int symbol) {
    const int rate = 3 + (table.age >= 17920) + (table.age >= 26624) + (table.age >= 31744) + (table.age >= 32512);
    for (int s = 1; s < 16; ++s) {
      int& below = table.below[static_cast<std::size_t>(s)];
      below += (s + (s > symbol ? 32752 : 0) - below) >> rate;
    }
    table.age += (32767 - table.age) >> rate;
  }

  int table_bits_;
  std::map<std::pair<int, std::uint32_t>, Table> tables_;
};

struct Coded {
  AveragedModel::Context context;
  std::uint32_t symbol;
};

std::vector<Coded> randomSymbols(std::uint32_t count) {
  std::mt19937 random(1);
  std::vector<Coded> all(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    // Few contexts, so that tables grow old, and many, so that they share numbers.
    const std::uint32_t few = random() % 5, many = static_cast<std::uint32_t>(random());
    all[i].context = {few * 51, i % 2 == 0 ? few : many, i % 3 == 0 ? few * 7 : many ^ 0x55555555u};
    all[i].symbol = random() % 4 == 0 ? random() % 16 : (few + i / 5000) % 16;
  }
  return all;
}

/// For few symbols there are 2^6 tables, for many 2^12, and between the two as many as the symbols' number has bits.
TEST(AveragedModel, IsThatOfTheFormat) {
  const std::pair<std::uint32_t, int> sizes[] = {{0, 6}, {63, 6}, {64, 7}, {1000, 10}, {4095, 12}, {1u << 29, 12}};
  const std::vector<Coded> all = randomSymbols(20000);
  for (const auto& [symbol_count, table_bits] : sizes) {
    EntropyWriter writer;
    AveragedModel encoder(kPrior, symbol_count);
    for (const Coded& c : all) encoder.put(writer, c.context, c.symbol);
    std::vector<std::byte> bytes;
    writer.finish(9, bytes);
    EntropyReader reader(bytes), plain_reader(bytes);
    AveragedModel decoder(kPrior, symbol_count);
    PlainModel plain(table_bits);
    for (const Coded& c : all) {
      ASSERT_EQ(decoder.get(reader, c.context), c.symbol);
      ASSERT_EQ(plain.get(plain_reader, c.context), c.symbol);
      ASSERT_EQ(reader.state(), plain_reader.state());
    }
    EXPECT_TRUE(reader.atEnd());
    EXPECT_EQ(reader.state(), finalState(9));
  }
}

}  // namespace
}  // namespace tsc
