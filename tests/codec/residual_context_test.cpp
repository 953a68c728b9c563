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
    const std::int64_t expected = 192 * own + 16 * total + 3 * spread + 256;
    ASSERT_LT(expected, 1 << 24);
    ASSERT_EQ(contexts.scale(a), (logarithm(expected) - (8 << 23)) >> 22);
    const std::int64_t shift = std::max<std::int64_t>(0, (logarithm(expected) - (11 << 23) - 1677721) >> 23);
    ASSERT_EQ(contexts.shift(a), shift);
    ASSERT_EQ(contexts.shifts[a], shift) << "not bounded, and need not be";
    const std::int64_t ratio = (logarithm(spread + 1) - logarithm(16 * own + total + 16) + (3 << 23)) >> 23;
    ASSERT_EQ(contexts.ratio(a), std::clamp<std::int64_t>(ratio, 0, 4) + 5 * around.count_class);
    ASSERT_GE(contexts.scale(a), 0);
    ASSERT_LT(contexts.scale(a), kScaleClasses);
    ASSERT_LT(contexts.shift(a), kShiftClasses);
    ASSERT_LT(contexts.ratio(a), kRatioClasses);
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
    around.magnitude[3] = static_cast<std::int32_t>(random() % 43);  // hits
    around.spread[3] = static_cast<std::int32_t>(random() >> 14);    // of valences
    expectAsWritten(around);
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(ResidualContext, AtTheEnds) {
  Neighbourhood around{};
  expectAsWritten(around);
  around.magnitude = Integers{6 * kMaxMagnitude, 6 * kMaxMagnitude, 6 * kMaxMagnitude, 42};
  around.spread = splatInteger(kMaxSpread);
  around.count_class = 2;
  expectAsWritten(around);
  EXPECT_EQ(residualContexts(around).shift(0), kShiftClasses - 1) << "none is never used";
}

}  // namespace
}  // namespace tsc
