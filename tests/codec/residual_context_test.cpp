#include "residual_context.h"

#include <gtest/gtest.h>

#include <random>

namespace tsc {
namespace {

std::int64_t logarithm(std::int64_t x) {
  const int e = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(x))) - 1;
  return (std::int64_t{e} << 23) + ((x - (std::int64_t{1} << e)) << (23 - e));
}

/// BITSTREAM.md, section 6.6, one component at a time.
void expectAsWritten(const Neighbourhood& around) {
  const ResidualContexts contexts = residualContexts(around);
  const std::int64_t total = std::int64_t{around.magnitude[0]} + around.magnitude[1] + around.magnitude[2];
  for (int a = 0; a < 3; ++a) {
    const std::int64_t own = around.magnitude[a], spread = around.spread[a];
    const std::int64_t mean = 16 * own + total + 16, size = mean + (spread >> 2);
    ASSERT_LT(size, 1 << 24);
    const std::int64_t scale = std::max<std::int64_t>(0, (logarithm(size) - (std::int64_t{9} << 22)) >> 22);
    ASSERT_EQ(contexts.scale(a), scale);
    ASSERT_EQ(contexts.shift(a), std::max<std::int64_t>(0, scale - 6) >> 1);
    ASSERT_EQ(contexts.wideShifts()[a], contexts.shift(a));
    const std::int64_t ratio = (logarithm(spread + 1) - logarithm(mean) + (3 << 23)) >> 23;
    ASSERT_EQ(contexts.table(a) - kRatioClasses * scale,
              std::clamp<std::int64_t>(ratio, 0, 4) + 5 * around.count_class);
    ASSERT_LT(scale, kScaleClasses) << "not bounded from above, and need not be";
    ASSERT_LT(contexts.shift(a), kShiftClasses);
  }
}

TEST(ResidualContext, AsTheFormatHasIt) {
  std::mt19937 random(6);
  for (int i = 0; i < 200000; ++i) {
    Neighbourhood around{};
    around.count_class = static_cast<int>(random() % kCountClasses);
    for (int a = 0; a < 3; ++a) {
      around.magnitude[a] = static_cast<std::int32_t>((random() % (6 * kMaxMagnitude + 1)) >> random() % 17);
      around.spread[a] = static_cast<std::int32_t>((random() % (kMaxSpread + 1)) >> random() % 22);
    }
    around.magnitude[3] = static_cast<std::int32_t>(random() % 127);  // hits
    around.spread[3] = static_cast<std::int32_t>(random() >> 14);     // of valences
    expectAsWritten(around);
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(ResidualContext, AtTheEnds) {
  Neighbourhood around{};
  expectAsWritten(around);
  EXPECT_EQ(residualContexts(around).table(0), 0);
  around.magnitude = Integers{6 * kMaxMagnitude, 6 * kMaxMagnitude, 6 * kMaxMagnitude, 126};
  around.spread = splatInteger(kMaxSpread);
  around.count_class = 2;
  expectAsWritten(around);
  EXPECT_EQ(residualContexts(around).shift(0), kShiftClasses - 1) << "none is never used";
}

// As in BITSTREAM.md, section 6.6: all residuals around are 0, a gate of (4, 0, 0) in lattice mode: 2 * 64 is its half.
TEST(ResidualContext, ByHand) {
  Neighbourhood around{};
  around.spread = Integers{128, 0, 0, 0};
  const ResidualContexts contexts = residualContexts(around);
  // log(16 + 32) = 5 * 2^23 + 2^22, so (11 - 9) * 2^22 >> 22; log(129) - log(16) + 3 * 2^23 is above 5 * 2^23.
  EXPECT_EQ(contexts.table(0), 2 * kRatioClasses + 4);
  EXPECT_EQ(contexts.table(1), 0) << "log(16) = 8 * 2^22, and log(1) - log(16) + 3 * 2^23 is below 0";
  EXPECT_EQ(contexts.shift(0), 0);
}

}  // namespace
}  // namespace tsc
