#include "residual_coder.h"

#include <gtest/gtest.h>

#include <random>

#include "format.h"

namespace tsc {
namespace {

struct Coded {
  int count_class;
  std::array<int, 3> table, shift;
  std::array<CandidateContext, 3> candidates;
  std::array<std::int32_t, 3> residual;
};

std::vector<Coded> randomResiduals(std::uint32_t seed, int fine_bits) {
  std::mt19937 random(seed);
  const std::int32_t limit = static_cast<std::int32_t>(kResidualLimit >> fine_bits) - (1 << kShiftClasses);
  std::vector<Coded> all;
  for (int i = 0; i < 20000; ++i) {
    Coded coded;
    coded.count_class = static_cast<int>(random() % kCountClasses);
    for (std::size_t a = 0; a < 3; ++a) {
      const int scale = static_cast<int>(random() % (i % 2 == 0 ? kScaleClasses : 10));
      coded.shift[a] = std::max(0, scale - kFirstWideScale) >> 1;
      coded.table[a] = kRatioClasses * scale + static_cast<int>(random() % 5) + 5 * coded.count_class;
      CandidateContext& c = coded.candidates[a];
      c.count_class = coded.count_class;
      c.hits_around = random() % 3;
      const auto number = [&](int bits) {
        return static_cast<std::int32_t>(random()) >> (31 - random() % static_cast<unsigned>(bits));
      };
      for (std::int32_t& candidate : c.residual) candidate = number(16);
      const std::int32_t near = number(coded.shift[a] + 3), far = number(32 - 4 - fine_bits);
      coded.residual[a] = std::clamp(random() % 4 == 0   ? c.residual[random() % 2]
                                     : random() % 4 == 0 ? far
                                                         : near,
                                     -limit, limit);
    }
    all.push_back(coded);
  }
  return all;
}

/// The three residuals as the position coder codes them: bins, then what lies below those of components without a hit.
template <bool kWithCandidates, class Direction>
std::array<std::int32_t, 3> code(ResidualCoder<Direction>& coder, Hot<Direction>& hot, const Coded& coded,
                                 std::uint32_t& hits) {
  typename ResidualCoder<Direction>::Progress progress;
  const auto one = [&]<int kAxis>() {
    if constexpr (kWithCandidates) {
      return coder.template code<kAxis>(hot, coded.table[kAxis], coded.shift[kAxis], coded.candidates[kAxis], progress,
                                        coded.residual[kAxis]);
    } else {
      return coder.template code<kAxis>(hot, coded.table[kAxis], coded.shift[kAxis], coded.residual[kAxis]);
    }
  };
  std::array<std::int32_t, 3> value;
  value[0] = one.template operator()<0>();
  value[1] = one.template operator()<1>();
  value[2] = one.template operator()<2>();
  hits = progress.hits;
  for (std::size_t a = 0; a < 3; ++a) {
    if (hits >> a & 1) continue;
    const std::int32_t below = coded.residual[a] - value[a];
    if (Direction::kWrites) {
      EXPECT_EQ(below >> coded.shift[a], 0) << "the bin holds the residual";
    }
    hot.endGroup();
    value[a] += static_cast<std::int32_t>(hot.raw(static_cast<std::uint32_t>(below), coded.shift[a]));
  }
  hot.endGroup();
  return value;
}

template <bool kWithCandidates>
void expectRoundTrip(int fine_bits, bool exact_hits, bool second_tells) {
  const std::vector<Coded> all = randomResiduals(5, fine_bits);
  const std::array<int, 3> step_bits = {fine_bits, fine_bits, fine_bits};
  EntropyWriter writer;
  Writing writing{writer};
  Hot<Writing> hot_writing(writing);
  ResidualCoder<Writing> encoder(writing, exact_hits, second_tells, step_bits);
  std::vector<std::uint32_t> all_hits;
  for (const Coded& coded : all) {
    std::uint32_t hits = 0;
    ASSERT_EQ(code<kWithCandidates>(encoder, hot_writing, coded, hits), coded.residual);
    for (std::size_t a = 0; a < 3; ++a) {
      if ((hits >> a & 1) == 0) continue;
      ASSERT_GT(coded.shift[a], 0) << "where bins are as wide as a step they say all";
      const auto& candidate = coded.candidates[a].residual;
      ASSERT_TRUE(coded.residual[a] == candidate[0] || coded.residual[a] == candidate[1]);
    }
    all_hits.push_back(hits);
  }
  EXPECT_EQ(std::any_of(all_hits.begin(), all_hits.end(), [](auto h) { return h != 0; }), exact_hits);
  std::vector<std::byte> bytes;
  writer.finish(2, bytes);
  EntropyReader reader(bytes);
  Reading reading{reader};
  Hot<Reading> hot_reading(reading);
  ResidualCoder<Reading> decoder(reading, exact_hits, second_tells, step_bits);
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::uint32_t hits = 0;
    // Reading must not look at what it is to find.
    Coded unknown = all[i];
    unknown.residual = {-77, 77, 0};
    ASSERT_EQ(code<kWithCandidates>(decoder, hot_reading, unknown, hits), all[i].residual) << i;
    ASSERT_EQ(hits, all_hits[i]) << i;
  }
  hot_reading.to(reading);
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.state(), finalState(2));
}

TEST(ResidualCoder, EveryResidualComesBack) {
  for (const int fine_bits : {0, kFineBits}) {
    for (const bool second_tells : {false, true}) {
      expectRoundTrip<true>(fine_bits, false, second_tells);
      expectRoundTrip<true>(fine_bits, true, second_tells);
    }
    expectRoundTrip<false>(fine_bits, false, false);
  }
}

/// What the last of many equal vertices costs.
double bitsOfTheLast(bool exact_hits, bool second_tells, const Coded& coded, bool varies) {
  EntropyWriter writer;
  Writing writing{writer};
  Hot<Writing> hot(writing);
  ResidualCoder<Writing> coder(writing, exact_hits, second_tells, {0, 0, 0});
  std::mt19937 random(1);
  std::size_t mark = 0;
  double bits = 0;
  for (int i = 0; i < 5000; ++i) {
    Coded c = coded;
    if (varies) {
      // Residuals all over the window, each where the first candidate lies.
      for (std::size_t a = 0; a < 3; ++a) {
        c.residual[a] = static_cast<std::int32_t>(random() % 13) - 6;
        c.candidates[a].residual = {c.residual[a], -3};
      }
    }
    mark = writer.mark();
    std::uint32_t hits = 0;
    code<true>(coder, hot, c, hits);
    if (i >= 4000) bits += writer.bitsSince(mark) / 1000;
  }
  return bits;
}

Coded vertex(int scale) {
  Coded c;
  c.count_class = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    c.table[a] = kRatioClasses * scale + 5;
    c.shift[a] = std::max(0, scale - kFirstWideScale) >> 1;
    c.candidates[a] = {{0, 0}, 1, 0};
    c.residual[a] = 0;
  }
  return c;
}

TEST(ResidualCoder, TheTellingCandidatesPlaceIsLearned) {
  const Coded coded = vertex(6);
  // 13 values are log2(13) = 3.7 bits each; half of the average belongs to the table that knows no candidate.
  const double with = bitsOfTheLast(false, false, coded, true), without = bitsOfTheLast(false, true, coded, true);
  EXPECT_LT(with, 3 * 1.2);
  EXPECT_GT(without, 3 * 3.3) << "the second candidate says nothing";
}

TEST(ResidualCoder, HitsSayTheLowBitsToo) {
  Coded coded = vertex(16);  // bins of 2^5
  for (std::size_t a = 0; a < 3; ++a) coded.residual[a] = coded.candidates[a].residual[0] = 100 + static_cast<int>(a);
  EXPECT_GT(bitsOfTheLast(false, false, coded, false), 15.0);
  EXPECT_LT(bitsOfTheLast(true, false, coded, false), 0.5);
}

/// Whatever the bytes, residuals stay so small that no later sum overflows.
TEST(ResidualCoder, HostileBytesStayWithinTheLimit) {
  std::mt19937 random(7);
  for (const int fine_bits : {0, kFineBits}) {
    for (const bool exact_hits : {false, true}) {
      const std::vector<Coded> all = randomResiduals(6, fine_bits);
      std::vector<std::byte> bytes(40000);
      // Long runs of ones choose the last bins, and lengths of 30 bits.
      for (std::size_t i = 0; i < bytes.size(); ++i) {
        bytes[i] = static_cast<std::byte>(i % 1000 < 500 ? 0xff : random());
      }
      EntropyReader reader(bytes);
      Reading reading{reader};
      Hot<Reading> hot(reading);
      ResidualCoder<Reading> decoder(reading, exact_hits, false, {fine_bits, fine_bits, fine_bits});
      for (const Coded& coded : all) {
        std::uint32_t hits = 0;
        for (const std::int32_t value : code<true>(decoder, hot, coded, hits)) {
          ASSERT_LE(std::abs(std::int64_t{value}), (kResidualLimit >> fine_bits) + (1 << kShiftClasses));
        }
      }
    }
  }
}

}  // namespace
}  // namespace tsc
