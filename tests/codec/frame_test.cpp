#include "frame.h"

#include <gtest/gtest.h>

#include <random>

namespace tsc {
namespace {

constexpr int kOne = 1 << kFrameBits;

Vec3 randomPoint(std::mt19937& random) {
  // Of all magnitudes up to 2^26.
  const int bits = static_cast<int>(random() % 26) + 1;
  const auto coordinate = [&] { return static_cast<int>(random() % (1u << bits)) - (1 << (bits - 1)); };
  const int x = coordinate(), y = coordinate();
  return {x, y, coordinate()};
}

/// Lengths and angles within 2^-12.
void expectOrthonormal(const Frame& frame) {
  const Vec3* axes[3] = {&frame.normal, &frame.first, &frame.second};
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const double product =
          static_cast<double>(dot(WideVec3(*axes[i]), WideVec3(*axes[j]))) / (static_cast<double>(kOne) * kOne);
      ASSERT_NEAR(product, i == j ? 1 : 0, std::ldexp(1.0, -12)) << i << ' ' << j;
    }
  }
}

TEST(Frame, IntegerSquareRootAndDivision) {
  for (std::int64_t r : {0ll, 1ll, 2ll, 3ll, 1000ll, 46341ll, (1ll << 26) - 1}) {
    EXPECT_EQ(integerSqrt(r * r), r);
    if (r > 0) {
      EXPECT_EQ(integerSqrt(r * r - 1), r - 1);
    }
    EXPECT_EQ(integerSqrt(r * r + 2 * r), r);
  }
  std::mt19937_64 random(1);
  for (int i = 0; i < 100000; ++i) {
    const auto a = static_cast<std::int64_t>(random() >> 13 >> random() % 51);
    const auto b = static_cast<std::int64_t>(1 + (random() >> 13 >> random() % 51));
    ASSERT_EQ(floorDivide(a, b), a / b);
  }
}

TEST(Frame, UnitVectorByHand) {
  EXPECT_EQ(unitVector({0, 0, 0}), Vec3(0));
  EXPECT_EQ(unitVector({5, 0, 0}), Vec3(kOne, 0, 0));
  EXPECT_EQ(unitVector({0, -7, 0}), Vec3(0, -kOne, 0));
  // 3-4-5: 0.6 * 2^14 = 9830.4, 0.8 * 2^14 = 13107.2.
  EXPECT_EQ(unitVector({3, 0, 4}), Vec3(9830, 0, 13107));
  EXPECT_EQ(unitVector({3ll << 40, -4ll << 40, 0}), Vec3(9830, -13107, 0));
}

TEST(Frame, OrthonormalWhateverTheTriangle) {
  std::mt19937 random(2);
  for (int i = 0; i < 200000; ++i) {
    const Vec3 left = randomPoint(random), right = randomPoint(random), base = randomPoint(random);
    const Vec3 prediction = i % 2 == 0 ? left + right - base : randomPoint(random);
    for (const Basis basis : {Basis::kGate, Basis::kTip}) {
      const Frame frame = frameAt(basis, left, right, base, prediction);
      expectOrthonormal(frame);
      if (testing::Test::HasFailure()) return;
    }
  }
}

TEST(Frame, GateAlignedByHand) {
  // A triangle in the plane z = 0: gate from (0, 0) to (10, 0), base below it.
  const Frame frame = frameAt(Basis::kGate, {10, 0, 0}, {0, 0, 0}, {5, -8, 0}, {5, 8, 0});
  EXPECT_EQ(frame.normal, Vec3(0, 0, -kOne));
  EXPECT_EQ(frame.first, Vec3(kOne, 0, 0));
  EXPECT_EQ(frame.second, Vec3(0, -kOne, 0));
}

TEST(Frame, TipAlignedByHand) {
  const Frame frame = frameAt(Basis::kTip, {10, 0, 0}, {0, 0, 0}, {5, -8, 0}, {5, 8, 0});
  EXPECT_EQ(frame.normal, Vec3(0, 0, -kOne));
  EXPECT_EQ(frame.first, Vec3(0, kOne, 0)) << "from the base vertex to the prediction";
  // A prediction outside the plane is projected into it.
  EXPECT_EQ(frameAt(Basis::kTip, {10, 0, 0}, {0, 0, 0}, {5, -8, 0}, {5, 8, 4}).first, Vec3(0, kOne, 0));
}

TEST(Frame, DegenerateTrianglesGiveTheAxes) {
  const auto expectAxes = [](const Frame& frame) {
    EXPECT_EQ(frame.normal, Vec3(kOne, 0, 0));
    EXPECT_EQ(frame.first, Vec3(0, kOne, 0));
    EXPECT_EQ(frame.second, Vec3(0, 0, kOne));
  };
  for (const Basis basis : {Basis::kGate, Basis::kTip}) {
    expectAxes(frameAt(basis, {1, 2, 3}, {1, 2, 3}, {9, 9, 9}, {0, 0, 0}));
    expectAxes(frameAt(basis, {0, 0, 0}, {2, 2, 2}, {5, 5, 5}, {7, 7, 7}));
  }
  expectAxes(frameAt(Basis::kTip, {10, 0, 0}, {0, 0, 0}, {5, -8, 0}, {5, -8, 0}));
  expectAxes(frameAt(Basis::kTip, {10, 0, 0}, {0, 0, 0}, {5, -8, 0}, {5, -8, 6}));
}

TEST(Frame, ThereAndBack) {
  std::mt19937 random(3);
  for (int i = 0; i < 10000; ++i) {
    const Vec3 left = randomPoint(random), right = randomPoint(random), base = randomPoint(random);
    const Frame frame = frameAt(Basis::kGate, left, right, base, base);
    const Vec3 displacement(static_cast<int>(random() % 2001) - 1000, static_cast<int>(random() % 2001) - 1000,
                            static_cast<int>(random() % 2001) - 1000);
    const Vec3 back = toLattice(frame, toLocal(frame, displacement));
    for (int a = 0; a < 3; ++a) ASSERT_LE(std::abs(back[a] - displacement[a]), 2);
  }
}

}  // namespace
}  // namespace tsc
