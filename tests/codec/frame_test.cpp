#include "frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tsc {
namespace {

constexpr int kOne = 1 << kFrameBits;

Integers lanes(int x, int y, int z, int last = 0) { return Integers{x, y, z, last}; }

Integers randomPoint(std::mt19937& random) {
  // Of all magnitudes up to 2^26. Lane 3 is a valence.
  const int bits = static_cast<int>(random() % 27);
  const auto coordinate = [&] { return static_cast<int>(random() % (2u << bits)) - (1 << bits); };
  const int x = coordinate(), y = coordinate(), z = coordinate();
  return lanes(x, y, z, static_cast<int>(random() % 1000));
}

glm::dvec3 axisOf(Integers v) { return glm::dvec3(v[0], v[1], v[2]) / double{kOne}; }

/// Lengths within 2^-8, of the third axis, a product, within twice that; right angles within 2^-10.
void expectNearlyOrthonormal(const Frame& frame, Basis basis) {
  const glm::dvec3 axes[3] = {axisOf(frame.normal), axisOf(frame.first), axisOf(frame.second)};
  for (int i = 0; i < 3; ++i) {
    const bool product = i == (basis == Basis::kGate ? 2 : 1);
    ASSERT_NEAR(glm::length(axes[i]), 1, std::ldexp(1.0, product ? -7 : -8)) << i;
    for (int j = 0; j < i; ++j) ASSERT_NEAR(glm::dot(axes[i], axes[j]), 0, std::ldexp(1.0, -10)) << i << ' ' << j;
  }
  ASSERT_GT(glm::dot(glm::cross(axes[0], axes[1]), axes[2]), 0) << "right-handed";
  for (const Integers axis : {frame.normal, frame.first, frame.second}) ASSERT_EQ(axis[3], 0);
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

TEST(Frame, ReciprocalRootsAreThoseOfTheMiddles) {
  for (std::size_t i = 0; i < kReciprocalRoots.size(); ++i) {
    if (i < 128) {
      EXPECT_EQ(kReciprocalRoots[i], 0) << "there are none";
      continue;
    }
    const std::int64_t root = integerSqrt((2 * static_cast<std::int64_t>(i) + 1) << 18);
    EXPECT_EQ(kReciprocalRoots[i], (1 << 28) / root);
  }
  EXPECT_EQ(kReciprocalRoots.size() - 1, 3u << 9) << "the largest square, of three components of -2^14";
}

TEST(Frame, VectorsAreScaledToFourteenBits) {
  const auto expectScaled = [](Integers v, Integers expected) {
    const Integers found = scaledForUnit(v);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(found[i], expected[i]) << i;
  };
  expectScaled(lanes(0, 0, 0, 77), lanes(0, 0, 0));
  expectScaled(lanes(1, 0, 0, -5), lanes(8192, 0, 0));
  expectScaled(lanes(-1, 0, 0), lanes(-16384, 0, 0));
  expectScaled(lanes(-64, 64, 3), lanes(-8192, 8192, 384));
  expectScaled(lanes(1 << 28, -1, 12345), lanes(8192, -1, 0));
  expectScaled(lanes((1 << 28) - 1, -(1 << 28), 0), lanes(16383, -16384, 0));
  std::mt19937 random(4);
  for (int i = 0; i < 100000; ++i) {
    const Integers v = randomPoint(random);
    const Integers found = scaledForUnit(v);
    ASSERT_EQ(found[3], 0);
    if (v[0] == 0 && v[1] == 0 && v[2] == 0) continue;
    ASSERT_EQ(magnitudeBits(found), kUnitInputBits);
  }
}

TEST(Frame, UnitVectorByHand) {
  // 2^28 >> 19 = 512, whose middle has the root 16391; floor(2^28 / 16391) = 16377.
  EXPECT_EQ(vectorOf(unitVector(lanes(0, 0, -16384))), Vec3(0, 0, -8189));
  EXPECT_EQ(vectorOf(unitVector(lanes(8192, -8192, 0))), Vec3(5787, -5787, 0));
}

TEST(Frame, UnitVectorsHaveTheirLength) {
  std::mt19937 random(5);
  double shortest = 1, longest = 1;
  const auto measure = [&](Integers v) {
    const glm::dvec3 unit = axisOf(unitVector(v));
    shortest = std::min(shortest, glm::length(unit));
    longest = std::max(longest, glm::length(unit));
    const glm::dvec3 exact = glm::normalize(glm::dvec3(v[0], v[1], v[2]));
    ASSERT_LT(glm::length(unit / glm::length(unit) - exact), 3e-4) << "two components off by one";
  };
  for (int i = 0; i < 1'000'000; ++i) {
    const auto coordinate = [&] { return static_cast<int>(random() % 32768) - 16384; };
    const int x = coordinate(), y = coordinate(), z = coordinate();
    const Integers v = lanes(x, y, z);
    if (magnitudeBits(v) == kUnitInputBits) measure(v);
  }
  for (const int x : {-16384, -8193, 8192, 16383}) {
    for (const int y : {-16384, -1, 0, 1, 16383}) {
      for (const int z : {-16384, 0, 16383}) measure(lanes(x, y, z));
    }
  }
  EXPECT_GT(shortest, 1 - std::ldexp(1.0, -8));
  EXPECT_LT(longest, 1 + std::ldexp(1.0, -8));
}

TEST(Frame, CrossProductsAreExact) {
  std::mt19937 random(6);
  const auto coordinate = [&] {
    constexpr int kEnds[] = {-16384, 16384, -1, 0, 1};
    return random() % 4 == 0 ? kEnds[random() % 5] : static_cast<int>(random() % 32769) - 16384;
  };
  for (int i = 0; i < 100000; ++i) {
    Vec3 a, b;
    for (int k = 0; k < 3; ++k) a[k] = coordinate(), b[k] = coordinate();
    const Integers found = crossProduct(lanesOf(a), lanesOf(b));
    ASSERT_EQ(WideVec3(vectorOf(found)), cross(WideVec3(a), WideVec3(b)));
    ASSERT_EQ(found[3], 0);
  }
}

TEST(Frame, NearlyOrthonormalWhateverTheTriangle) {
  std::mt19937 random(2);
  for (int i = 0; i < 200000; ++i) {
    const Integers left = randomPoint(random), right = randomPoint(random);
    // Every third base lies near the gate.
    const Integers base = i % 3 == 0 ? ((left + right) >> 1) + (randomPoint(random) >> 24) : randomPoint(random);
    const Integers prediction = i % 2 == 0 ? left + right - base : randomPoint(random);
    for (const Basis basis : {Basis::kGate, Basis::kTip}) {
      expectNearlyOrthonormal(frameAt(basis, left, right, base, prediction), basis);
      if (testing::Test::HasFailure()) return;
    }
  }
}

TEST(Frame, GateAlignedByHand) {
  // As in BITSTREAM.md, section 6.4.
  const Frame frame = frameAt(Basis::kGate, lanes(64, 0, 0, 6), lanes(0, 64, 0, 5), lanes(0, 0, 0, 9), lanes(64, 64, 0));
  EXPECT_EQ(vectorOf(frame.normal), Vec3(0, 0, -8189));
  EXPECT_EQ(vectorOf(frame.first), Vec3(5787, -5787, 0));
  EXPECT_EQ(vectorOf(frame.second), Vec3(-5785, -5785, 0));
}

TEST(Frame, TipAlignedAlongThePrediction) {
  const Integers left = lanes(10, 0, 0), right = lanes(0, 0, 0), base = lanes(5, -8, 0);
  // A prediction outside the plane is projected into it.
  for (const int z : {0, 4}) {
    const Frame frame = frameAt(Basis::kTip, left, right, base, lanes(5, 8, z));
    EXPECT_LT(glm::length(axisOf(frame.normal) - glm::dvec3(0, 0, -1)), 0.01);
    EXPECT_LT(glm::length(axisOf(frame.first) - glm::dvec3(0, 1, 0)), 0.01) << "from the base vertex to the prediction";
  }
}

TEST(Frame, DegenerateTrianglesGiveTheAxes) {
  const auto expectAxes = [](const Frame& frame) {
    EXPECT_EQ(vectorOf(frame.normal), Vec3(kOne, 0, 0));
    EXPECT_EQ(vectorOf(frame.first), Vec3(0, kOne, 0));
    EXPECT_EQ(vectorOf(frame.second), Vec3(0, 0, kOne));
  };
  for (const Basis basis : {Basis::kGate, Basis::kTip}) {
    expectAxes(frameAt(basis, lanes(1, 2, 3), lanes(1, 2, 3), lanes(9, 9, 9), lanes(0, 0, 0)));
    expectAxes(frameAt(basis, lanes(0, 0, 0), lanes(2, 2, 2), lanes(6, 6, 6), lanes(7, 7, 7)));
  }
  expectAxes(frameAt(Basis::kTip, lanes(10, 0, 0), lanes(0, 0, 0), lanes(5, -8, 0), lanes(5, -8, 0)));
  expectAxes(frameAt(Basis::kTip, lanes(10, 0, 0), lanes(0, 0, 0), lanes(5, -8, 0), lanes(5, -8, 6)));
}

/// Both paths, of coordinates within 16 bits and of larger ones, against 64-bit arithmetic.
TEST(Frame, ToLatticeRoundsTheSum) {
  std::mt19937 random(3);
  for (int i = 0; i < 200000; ++i) {
    const Frame frame = frameAt(i % 2 == 0 ? Basis::kGate : Basis::kTip, randomPoint(random), randomPoint(random),
                                randomPoint(random), randomPoint(random));
    const int bits = 1 + static_cast<int>(random() % 29);
    Integers local{};
    for (int a = 0; a < 3; ++a) local[a] = static_cast<int>(random() % (2u << bits)) - (1 << bits);
    if (i % 5 == 0) local[static_cast<int>(random() % 3)] = i % 2 == 0 ? 32767 : 32768;
    if (i % 7 == 0) local[static_cast<int>(random() % 3)] = i % 2 == 0 ? -32768 : -32769;
    const Integers found = toLattice(frame, local);
    for (int k = 0; k < 3; ++k) {
      const std::int64_t sum = std::int64_t{frame.normal[k]} * local[0] + std::int64_t{frame.first[k]} * local[1] +
                               std::int64_t{frame.second[k]} * local[2];
      ASSERT_EQ(found[k], (sum + (kOne >> 1)) >> kFrameBits) << i;
    }
  }
}

TEST(Frame, ThereAndNearlyBack) {
  std::mt19937 random(3);
  for (int i = 0; i < 10000; ++i) {
    const Frame frame = frameAt(Basis::kGate, randomPoint(random), randomPoint(random), randomPoint(random), Integers{});
    const auto coordinate = [&] { return static_cast<int>(random() % 2001) - 1000; };
    const int x = coordinate(), y = coordinate();
    const Vec3 displacement(x, y, coordinate());
    const Vec3 local(toLocal(frame, WideVec3(displacement)));
    const Vec3 back = vectorOf(toLattice(frame, lanesOf(local)));
    // Each length comes in twice.
    for (int a = 0; a < 3; ++a) ASSERT_NEAR(back[a], displacement[a], 2 + 1800 * std::ldexp(1.0, -6)) << i;
  }
}

}  // namespace
}  // namespace tsc
