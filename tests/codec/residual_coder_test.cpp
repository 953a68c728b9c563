#include "residual_coder.h"

#include <gtest/gtest.h>

#include <random>

#include "format.h"

namespace tsc {
namespace {

struct Coded {
  std::array<Component, 3> components;
  std::array<std::int32_t, 3> residual;
};

std::vector<Coded> randomResiduals(std::uint32_t seed, int fine_bits) {
  std::mt19937 random(seed);
  const std::int32_t limit = static_cast<std::int32_t>(kResidualLimit >> fine_bits) - (1 << kShiftClasses);
  std::vector<Coded> all;
  for (int i = 0; i < 20000; ++i) {
    Coded coded;
    const auto count_class = static_cast<int>(random() % kCountClasses);
    for (std::size_t a = 0; a < 3; ++a) {
      Component& c = coded.components[a];
      c.count_class = count_class;
      c.shift = static_cast<int>(random() % kShiftClasses);
      c.scale = std::min(2 * c.shift + static_cast<int>(random() % 10), kScaleClasses - 1);
      c.ratio = static_cast<int>(random() % 5) + 5 * count_class;
      c.first_offset = static_cast<int>(random() % (2 * kMaxOffset + 1)) - kMaxOffset;
      c.second_offset = static_cast<int>(random() % (2 * kMaxOffset + 1)) - kMaxOffset;
      c.hits_around = static_cast<int>(random() % 3);
      c.candidates_learn = random() % 4 == 0;
      const auto number = [&] {
        const int most = 32 - 4 - fine_bits;
        return static_cast<std::int32_t>(random()) >> (31 - random() % static_cast<unsigned>(most));
      };
      for (std::int32_t& candidate : c.candidates) candidate = number();
      coded.residual[a] = std::clamp(random() % 4 == 0 ? c.candidates[0] : number(), -limit, limit);
    }
    all.push_back(coded);
  }
  return all;
}

/// The three residuals as the position coder codes them: bins, then what lies below those of components without a hit.
template <bool kWithCandidates, class Direction>
std::array<std::int32_t, 3> code(ResidualCoder<Direction>& coder, Hot<Direction>& hot, const Coded& coded,
                                 std::uint32_t& hits) {
  const auto& [first, second, third] = coded.components;
  std::array<std::int32_t, 3> value = {coder.template code<0, kWithCandidates>(hot, first, hits, coded.residual[0]),
                                       coder.template code<1, kWithCandidates>(hot, second, hits, coded.residual[1]),
                                       coder.template code<2, kWithCandidates>(hot, third, hits, coded.residual[2])};
  for (std::size_t a = 0; a < 3; ++a) {
    if (hits >> a & 1) continue;
    const std::int32_t below = coded.residual[a] - value[a];
    if (Direction::kWrites) {
      EXPECT_EQ(below >> coded.components[a].shift, 0) << "the bin holds the residual";
    }
    value[a] += static_cast<std::int32_t>(hot.longRaw(static_cast<std::uint64_t>(below), coded.components[a].shift));
  }
  return value;
}

template <bool kWithCandidates>
void expectRoundTrip(int fine_bits, bool exact_hits, bool centred_only) {
  const std::vector<Coded> all = randomResiduals(5, fine_bits);
  EntropyWriter writer;
  Writing writing{writer};
  Hot<Writing> hot_writing(writing);
  ResidualCoder<Writing> encoder(writing, exact_hits, centred_only, {fine_bits, fine_bits, fine_bits});
  EXPECT_EQ(encoder.usesCandidates(), kWithCandidates);
  std::vector<std::uint32_t> all_hits;
  for (const Coded& coded : all) {
    std::uint32_t hits = 0;
    ASSERT_EQ(code<kWithCandidates>(encoder, hot_writing, coded, hits), coded.residual);
    all_hits.push_back(hits);
  }
  EXPECT_EQ(std::any_of(all_hits.begin(), all_hits.end(), [](auto h) { return h != 0; }), exact_hits);
  std::vector<std::byte> bytes;
  writer.finish(2, bytes);
  EntropyReader reader(bytes);
  Reading reading{reader};
  Hot<Reading> hot_reading(reading);
  ResidualCoder<Reading> decoder(reading, exact_hits, centred_only, {fine_bits, fine_bits, fine_bits});
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::uint32_t hits = 0;
    ASSERT_EQ(code<kWithCandidates>(decoder, hot_reading, all[i], hits), all[i].residual) << i;
    ASSERT_EQ(hits, all_hits[i]) << i;
  }
  hot_reading.to(reading);
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.states(), finalStates(2));
}

TEST(ResidualCoder, EveryResidualComesBack) {
  for (const int fine_bits : {0, kFineBits}) {
    expectRoundTrip<true>(fine_bits, false, false);
    expectRoundTrip<true>(fine_bits, true, false);
    expectRoundTrip<true>(fine_bits, true, true);
    expectRoundTrip<false>(fine_bits, false, true);
  }
}

/// Whatever the bytes, residuals stay so small that no later sum overflows.
TEST(ResidualCoder, HostileBytesStayWithinTheLimit) {
  std::mt19937 random(7);
  for (const int fine_bits : {0, kFineBits}) {
    const std::vector<Coded> all = randomResiduals(6, fine_bits);
    std::vector<std::byte> bytes(40000);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
    EntropyReader reader(bytes);
    Reading reading{reader};
    Hot<Reading> hot(reading);
    ResidualCoder<Reading> decoder(reading, false, false, {fine_bits, fine_bits, fine_bits});
    for (const Coded& coded : all) {
      std::uint32_t hits = 0;
      for (const std::int32_t value : code<true>(decoder, hot, coded, hits)) {
        ASSERT_LE(std::abs(std::int64_t{value}), (kResidualLimit >> fine_bits) + (1 << kShiftClasses));
      }
    }
  }
}

}  // namespace
}  // namespace tsc
