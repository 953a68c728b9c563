// What lies in lanes, against plain definitions one lane at a time.
#include "lanes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tsc {
namespace {

constexpr int kRuns = 20000;

/// Random numbers of all magnitudes and, every fourth, the ends of the range.
class Numbers {
 public:
  std::int32_t below(int bits) {
    const std::int32_t most = static_cast<std::int32_t>((std::int64_t{1} << bits) - 1);
    if (random_() % 4 == 0) {
      const std::int32_t ends[] = {-most - 1, -most, -1, 0, 1, most};
      return ends[random_() % 6];
    }
    const auto value = static_cast<std::int32_t>(random_()) >> (31 - bits);
    return value >> random_() % static_cast<unsigned>(bits + 1);
  }
  Integers integers(int bits) {
    Integers v;
    for (int i = 0; i < 4; ++i) v[i] = below(bits);
    return v;
  }
  Lanes lanes() {
    Lanes v;
    for (int i = 0; i < 8; ++i) v[i] = static_cast<std::int16_t>(below(15));
    return v;
  }
  unsigned operator()() { return random_(); }

 private:
  std::mt19937 random_{1};
};

std::int16_t saturated(std::int64_t x) { return static_cast<std::int16_t>(std::clamp<std::int64_t>(x, -32768, 32767)); }
std::int16_t wrapped(std::int64_t x) { return static_cast<std::int16_t>(x); }

TEST(Lanes, SixteenBitArithmetic) {
  Numbers numbers;
  for (int run = 0; run < kRuns; ++run) {
    const Lanes a = numbers.lanes(), b = numbers.lanes();
    const Lanes low = atMost(a, b), high = atLeast(a, b), sum = saturatedSum(a, b), more = greater(a, b);
    const Lanes product = multiplyHigh(a, b), unsigned_product = multiplyHighUnsigned(a, b);
    for (int i = 0; i < 8; ++i) {
      ASSERT_EQ(low[i], std::min(a[i], b[i]));
      ASSERT_EQ(high[i], std::max(a[i], b[i]));
      ASSERT_EQ(sum[i], saturated(a[i] + b[i]));
      ASSERT_EQ(more[i], a[i] > b[i] ? -1 : 0);
      ASSERT_EQ(product[i], (a[i] * b[i]) >> 16);
      const auto ua = static_cast<std::uint16_t>(a[i]), ub = static_cast<std::uint16_t>(b[i]);
      ASSERT_EQ(unsigned_product[i], wrapped((std::uint32_t{ua} * ub) >> 16));
    }
  }
}

TEST(Lanes, ThirtyTwoBitArithmetic) {
  Numbers numbers;
  for (int run = 0; run < kRuns; ++run) {
    const Integers a = numbers.integers(30), b = numbers.integers(30);
    const auto limit = static_cast<std::int32_t>(numbers() % (1u << 27));
    const Integers least = smaller(a, b), within = bounded(a, limit), magnitude = magnitudes(a), last = withLast(a, 42);
    for (int i = 0; i < 4; ++i) {
      ASSERT_EQ(least[i], std::min(a[i], b[i]));
      ASSERT_EQ(within[i], std::clamp(a[i], -limit, limit));
      ASSERT_EQ(magnitude[i], std::abs(a[i]));
      ASSERT_EQ(last[i], i == 3 ? 42 : a[i]);
    }
    const int shift = static_cast<int>(numbers() % 40) - 20;
    const Integers small = numbers.integers(shift > 0 ? 30 - shift : 30);
    const Integers times = scaled(small, shift);
    for (int i = 0; i < 4; ++i) {
      ASSERT_EQ(times[i], shift >= 0 ? small[i] * (1 << shift) : small[i] >> -shift);
    }
    ASSERT_EQ(isZero(a), a[0] == 0 && a[1] == 0 && a[2] == 0 && a[3] == 0);
  }
  EXPECT_TRUE(isZero(Integers{}));
  for (int i = 0; i < 4; ++i) {
    Integers one{};
    one[i] = 1 << 8 * i;
    EXPECT_FALSE(isZero(one));
  }
}

TEST(Lanes, WideningAndPacking) {
  Numbers numbers;
  for (int run = 0; run < kRuns; ++run) {
    const Integers low = numbers.integers(30), high = numbers.integers(17);
    const Lanes both = packed(low, high);
    for (int i = 0; i < 4; ++i) {
      ASSERT_EQ(both[i], saturated(low[i]));
      ASSERT_EQ(both[i + 4], saturated(high[i]));
    }
    std::array<std::int16_t, 8> stored;
    storeLanes(stored.data(), both);
    const Integers first = widened(stored.data()), second = widenedHigh(both);
    for (int i = 0; i < 4; ++i) {
      ASSERT_EQ(first[i], both[i]);
      ASSERT_EQ(second[i], both[i + 4]);
    }
    const Integers v = numbers.integers(15);
    const Lanes spread = splatLane<2>(v);
    for (int i = 0; i < 8; ++i) ASSERT_EQ(spread[i], v[2]);
  }
}

TEST(Lanes, SumsOfProducts) {
  Numbers numbers;
  for (int run = 0; run < kRuns; ++run) {
    Lanes a = numbers.lanes(), b = numbers.lanes();
    a >>= 2;  // eight products fit 32 bits
    b >>= 2;
    std::int64_t sum = 0;
    const Integers pairs = pairProducts(a, b);
    for (int i = 0; i < 8; ++i) sum += std::int64_t{a[i]} * b[i];
    for (int i = 0; i < 4; ++i) ASSERT_EQ(pairs[i], a[2 * i] * b[2 * i] + a[2 * i + 1] * b[2 * i + 1]);
    ASSERT_EQ(dotProduct(a, b), sum);

    const Integers p = numbers.integers(15), q = numbers.integers(14), r = numbers.integers(15),
                   s = numbers.integers(14);
    const Integers one = shortProducts(p, q), two = shortProducts(p, q, r, s);
    for (int i = 0; i < 4; ++i) {
      ASSERT_EQ(one[i], p[i] * q[i]);
      ASSERT_EQ(two[i], p[i] * q[i] + r[i] * s[i]);
    }
    const Integers x = numbers.integers(28), y = numbers.integers(28), z = numbers.integers(28);
    const Integers sums = laneSums(x, y, z);
    ASSERT_EQ(sums[0], x[0] + x[1] + x[2] + x[3]);
    ASSERT_EQ(sums[1], y[0] + y[1] + y[2] + y[3]);
    ASSERT_EQ(sums[2], z[0] + z[1] + z[2] + z[3]);
    ASSERT_EQ(sums[3], 0);
  }
}

TEST(Lanes, MagnitudeBitsCountWhatTwosComplementNeeds) {
  EXPECT_EQ(magnitudeBits(Integers{}), 0);
  EXPECT_EQ(magnitudeBits(Integers{-1, -1, -1, -1}), 0);
  EXPECT_EQ(magnitudeBits(Integers{-8, 3, 0, 0}), 3);
  EXPECT_EQ(magnitudeBits(Integers{8, 3, 0, 0}), 4);
  EXPECT_EQ(magnitudeBits(Integers{0, 0, 0, -(1 << 30) - 1}), 31);
}

TEST(Lanes, ScaledDownRoundsHalvesUp) {
  Numbers numbers;
  const auto expected = [](std::int64_t v, int shift, int limit) {
    const std::int64_t rounded = shift == 0 ? v : (v + (std::int64_t{1} << (shift - 1))) >> shift;
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(rounded, -limit, limit));
  };
  for (int shift = 0; shift <= 18; ++shift) {
    // Around every half and whole within the limit and beyond.
    for (int halves = -20; halves <= 20; ++halves) {
      const std::int32_t middle = (halves * (1 << shift)) >> 1;
      const Integers v = {middle - 1, middle, middle + 1, middle * 3};
      const Integers found = scaledDown(v, splatInteger(shift), 8);
      for (int i = 0; i < 4; ++i) ASSERT_EQ(found[i], expected(v[i], shift, 8)) << v[i] << " >> " << shift;
    }
  }
  for (int run = 0; run < 10 * kRuns; ++run) {
    const Integers v = numbers.integers(static_cast<int>(numbers() % 31));
    Integers shift;
    for (int i = 0; i < 4; ++i) shift[i] = static_cast<std::int32_t>(numbers() % 19);
    const Integers found = scaledDown(v, shift, 8);
    for (int i = 0; i < 4; ++i) ASSERT_EQ(found[i], expected(v[i], shift[i], 8)) << v[i] << " >> " << shift[i];
  }
}

TEST(Lanes, LogarithmsAreLinearBetweenPowersOfTwo) {
  for (std::int32_t x = 1; x < 1 << 24; x += x < 70000 ? 1 : 997) {
    const int e = static_cast<int>(std::bit_width(static_cast<std::uint32_t>(x))) - 1;
    const std::int64_t expected = (std::int64_t{e} << 23) + ((std::int64_t{x} - (1 << e)) << (23 - e));
    ASSERT_EQ(logarithms(splatInteger(x))[0], expected) << x;
    ASSERT_NEAR(static_cast<double>(expected) / (1 << 23), std::log2(x), 0.0861) << x;
  }
  EXPECT_EQ(logarithms(splatInteger((1 << 24) - 1))[3], (24 << 23) - 1);
}

TEST(Lanes, TranspositionSignsAndHighProducts) {
  const auto [x, y, z] =
      transposed(Integers{1, 2, 3, 4}, Integers{5, 6, 7, 8}, Integers{9, 10, 11, 12}, Integers{13, 14, 15, 16});
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(x[i], 1 + 4 * i);
    EXPECT_EQ(y[i], 2 + 4 * i);
    EXPECT_EQ(z[i], 3 + 4 * i);
  }
  EXPECT_EQ(signBits(Integers{-1, 0, 5, -7}), 0b1001u);
  std::mt19937 random(9);
  for (int i = 0; i < 1000; ++i) {
    const auto factor = static_cast<std::uint32_t>(random());
    Integers v;
    for (int k = 0; k < 4; ++k) v[k] = static_cast<std::int32_t>(random());
    const Integers high = wordProductsHigh(v, factor);
    for (int k = 0; k < 4; ++k) {
      ASSERT_EQ(static_cast<std::uint32_t>(high[k]), std::uint64_t{static_cast<std::uint32_t>(v[k])} * factor >> 32);
    }
  }
}

TEST(Lanes, FirstAbove) {
  Numbers numbers;
  for (int run = 0; run < kRuns; ++run) {
    std::array<std::int16_t, 16> ascending;
    for (std::int16_t& x : ascending) x = static_cast<std::int16_t>(numbers() & 0x7fff);
    std::sort(ascending.begin() + 1, ascending.end());  // lane 0 is anything
    const auto value = run % 2 == 0 ? ascending[numbers() % 16] : static_cast<std::int16_t>(numbers() & 0x7fff);
    std::uint32_t expected = 1;
    while (expected < 16 && ascending[expected] <= value) ++expected;
    ASSERT_EQ(firstAbove(loadLanes(ascending.data()), loadLanes(ascending.data() + 8), value), expected);
  }
}

TEST(Lanes, ShiftedDownRoundsDown) {
  Numbers numbers;
  for (int run = 0; run < kRuns; ++run) {
    const Lanes v = numbers.lanes();
    const Lanes found = shiftedDown(v, run % 16);
    for (int i = 0; i < 8; ++i) ASSERT_EQ(found[i], v[i] >> run % 16);
  }
}

TEST(Lanes, PairsOfEqual) {
  const Lanes values = {1, 2, 3, 9, 1, 2, 3, 9};
  EXPECT_EQ(pairsOfEqual(values, Lanes{0, 0, 0, 9, 0, 0, 0, 9}), 0u) << "lanes 3 and 7 do not count";
  EXPECT_EQ(pairsOfEqual(values, Lanes{1, 0, 0, 0, 0, 2, 0, 0}), 0b101u);
  EXPECT_EQ(pairsOfEqual(values, Lanes{1, 0, 3, 0, 1, 0, 0, 0}), 0b10001u);
  EXPECT_EQ(pairsOfEqual(values, Lanes{2, 3, 1, 0, 3, 1, 2, 0}), 0u);
  Numbers numbers;
  for (int run = 0; run < kRuns; ++run) {
    Lanes few, others;
    for (int i = 0; i < 8; ++i) others[i] = static_cast<std::int16_t>(numbers() % 3);
    for (int i = 0; i < 4; ++i) few[i] = few[i + 4] = static_cast<std::int16_t>(numbers() % 3);
    std::uint32_t expected = 0;
    for (int a = 0; a < 3; ++a) {
      if (few[a] == others[a] || few[a] == others[a + 4]) expected |= 1u << (2 * a);
    }
    ASSERT_EQ(pairsOfEqual(few, others), expected);
  }
}

TEST(Lanes, FloatsThatHoldIntegers) {
  Numbers numbers;
  for (int run = 0; run < kRuns; ++run) {
    const Integers a = numbers.integers(30), b = numbers.integers(30);
    const Floats fa = floatsOf(a), fb = floatsOf(b), least = smaller(fa, fb), most = larger(fa, fb);
    const Floats magnitude = magnitudes(fa);
    for (int i = 0; i < 4; ++i) {
      ASSERT_EQ(fa[i], static_cast<float>(a[i])) << "24 bits, ties to even";
      ASSERT_EQ(least[i], std::min(fa[i], fb[i]));
      ASSERT_EQ(most[i], std::max(fa[i], fb[i]));
      ASSERT_EQ(magnitude[i], std::abs(fa[i]));
    }
    const Integers small = numbers.integers(23);
    const Integers quarter = truncated(floatsOf(small) * 0.25f);
    for (int i = 0; i < 4; ++i) ASSERT_EQ(quarter[i], small[i] / 4) << "towards zero";
  }
  EXPECT_EQ(truncated(floatsOf(Integers{(1 << 24) + 1, (1 << 24) + 3, -(1 << 25) - 2, -(1 << 25) - 6}))[0], 1 << 24);
  EXPECT_EQ(truncated(floatsOf(Integers{(1 << 24) + 1, (1 << 24) + 3, -(1 << 25) - 2, -(1 << 25) - 6}))[1],
            (1 << 24) + 4);
  EXPECT_EQ(truncated(floatsOf(Integers{0, 0, -(1 << 25) - 2, -(1 << 25) - 6}))[3], -(1 << 25) - 8);
}

}  // namespace
}  // namespace tsc
