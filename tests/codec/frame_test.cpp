// Frames against a reference in 64-bit integers, which is what BITSTREAM.md, section 6.4, has.
#include "frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tsc {
namespace {

constexpr int kOne = 1 << kFrameBits;

Integers lanes(int x, int y, int z, int last = 0) { return Integers{x, y, z, last}; }

/// Of all magnitudes up to 2^27. Lane 3 is a valence.
Integers randomPoint(std::mt19937& random) {
  const int bits = static_cast<int>(random() % 28);
  const auto coordinate = [&] { return static_cast<int>(random() % (2u << bits)) - (1 << bits); };
  const int x = coordinate(), y = coordinate(), z = coordinate();
  return lanes(x, y, z, static_cast<int>(random() % 1000));
}

// --- The reference ---

/// v / 2^n without the fraction.
std::int64_t towardZero(std::int64_t v, int n) { return v < 0 ? -(-v >> n) : v >> n; }
WideVec3 towardZero(const WideVec3& v, int n) { return {towardZero(v.x, n), towardZero(v.y, n), towardZero(v.z, n)}; }

/// To 24 significant bits, ties to even.
std::int64_t roundedTo24Bits(std::int64_t v) {
  const std::int64_t m = std::abs(v);
  const int excess = std::max(0, static_cast<int>(std::bit_width(static_cast<std::uint64_t>(m))) - 24);
  const std::int64_t unit = std::int64_t{1} << excess, rest = m % unit;
  std::int64_t whole = m / unit;
  if (2 * rest > unit || (2 * rest == unit && whole % 2 == 1)) ++whole;
  return v < 0 ? -whole * unit : whole * unit;
}

WideVec3 scaledAsWritten(const WideVec3& v) {
  const WideVec3 r(roundedTo24Bits(v.x), roundedTo24Bits(v.y), roundedTo24Bits(v.z));
  const int excess = magnitudeBits(WideVec3(std::max({std::abs(r.x), std::abs(r.y), std::abs(r.z)}), 0, 0)) - 11;
  return excess >= 0 ? towardZero(r, excess) : r * (std::int64_t{1} << -excess);
}

WideVec3 unitAsWritten(const WideVec3& v) {
  const std::int64_t square = dot(v, v);
  const int rest = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(square))) - 8;
  const std::int64_t bound = ((square >> rest) + 1) << rest;
  std::int64_t root = 0;  // the largest one whose square times the bound is at most 2^46
  for (std::int64_t bit = 1 << 14; bit > 0; bit >>= 1) {
    if ((root + bit) * (root + bit) * bound <= std::int64_t{1} << 46) root += bit;
  }
  return towardZero(v * root, 11);
}

struct PlainFrame {
  WideVec3 normal{kOne, 0, 0}, first{0, kOne, 0}, second{0, 0, kOne};
};

PlainFrame frameAsWritten(Basis basis, Integers left, Integers right, Integers base, Integers prediction) {
  const auto wide = [](Integers v) { return WideVec3(vectorOf(v)); };
  const WideVec3 gate = scaledAsWritten(wide(left) - wide(right));
  const WideVec3 across = cross(gate, scaledAsWritten(wide(base) - wide(right)));
  PlainFrame frame;
  if (across == WideVec3(0)) return frame;
  const WideVec3 normal = unitAsWritten(scaledAsWritten(across));
  if (basis == Basis::kGate) {
    const WideVec3 first = unitAsWritten(gate);
    return {normal, first, towardZero(cross(normal, first), kFrameBits)};
  }
  const WideVec3 upright = cross(normal, scaledAsWritten(wide(prediction) - wide(base)));
  if (upright == WideVec3(0)) return frame;
  const WideVec3 second = unitAsWritten(scaledAsWritten(upright));
  return {normal, towardZero(cross(second, normal), kFrameBits), second};
}

WideVec3 wideOf(Lanes axis) { return {axis[0], axis[1], axis[2]}; }
WideVec3 wideOf(Floats v) {
  return {static_cast<std::int64_t>(v[0]), static_cast<std::int64_t>(v[1]), static_cast<std::int64_t>(v[2])};
}

void expectFrame(const Frame& found, const PlainFrame& expected) {
  ASSERT_EQ(wideOf(found.normal), expected.normal);
  ASSERT_EQ(wideOf(found.first), expected.first);
  ASSERT_EQ(wideOf(found.second), expected.second);
  for (const Lanes axis : {found.normal, found.first, found.second}) {
    ASSERT_EQ(axis[3], 0);
    for (int i = 0; i < 4; ++i) ASSERT_EQ(axis[i + 4], axis[i]) << "the same again";
  }
}

glm::dvec3 axisOf(Lanes v) { return glm::dvec3(v[0], v[1], v[2]) / double{kOne}; }

/// Lengths below 1 by at most 2^-8 and what rounding takes, of the third axis, a product, by twice that; right angles
/// within 2^-9.
void expectNearlyOrthonormal(const Frame& frame, Basis basis) {
  const glm::dvec3 axes[3] = {axisOf(frame.normal), axisOf(frame.first), axisOf(frame.second)};
  for (int i = 0; i < 3; ++i) {
    const bool product = i == (basis == Basis::kGate ? 2 : 1);
    ASSERT_LE(glm::length(axes[i]), 1) << i;
    ASSERT_GT(glm::length(axes[i]), 1 - (product ? 2 : 1) * (std::ldexp(1.0, -8) + std::ldexp(1.0, -10))) << i;
    for (int j = 0; j < i; ++j) ASSERT_NEAR(glm::dot(axes[i], axes[j]), 0, std::ldexp(1.0, -9)) << i << ' ' << j;
  }
  ASSERT_GT(glm::dot(glm::cross(axes[0], axes[1]), axes[2]), 0) << "right-handed";
}

// --- The tests ---

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

TEST(Frame, ReciprocalRootsAreThoseOfTheLargestSquares) {
  ASSERT_EQ(kReciprocalRoots.size(), 4u << 7) << "squares of 21 to 24 bits";
  for (std::size_t i = 0; i < kReciprocalRoots.size(); ++i) {
    const double bound = std::ldexp(static_cast<double>(129 + i % 128), static_cast<int>(i / 128) + 13);
    EXPECT_EQ(kReciprocalRoots[i] * 2048, std::floor(std::sqrt(std::ldexp(1.0, 46) / bound)));
  }
}

TEST(Frame, VectorsAreScaledToElevenBits) {
  const auto expectScaled = [](Integers v, const WideVec3& expected) {
    const Floats found = scaledForUnit(v);
    EXPECT_EQ(wideOf(found), expected);
    EXPECT_EQ(found[3], 0);
  };
  expectScaled(lanes(0, 0, 0, 77), {0, 0, 0});
  expectScaled(lanes(1, 0, 0, -5), {1024, 0, 0});
  expectScaled(lanes(-1, 0, 0), {-1024, 0, 0});
  expectScaled(lanes(-64, 63, 3), {-1024, 1008, 48});
  expectScaled(lanes(1 << 28, -1, -12345678), {1024, 0, -47});
  expectScaled(lanes(4095, -4095, 3), {2047, -2047, 1});   // towards zero
  expectScaled(lanes((1 << 25) - 1, 0, 0), {1024, 0, 0});  // 2^25 in 24 bits
  expectScaled(lanes((1 << 24) - 1, 0, 0), {2047, 0, 0});
}

TEST(Frame, ScaledVectorsAreAsWritten) {
  std::mt19937 random(4);
  for (int i = 0; i < 300000; ++i) {
    const Integers v = randomPoint(random) - randomPoint(random);  // lane 3 is anything
    const Floats found = scaledForUnit(v);
    ASSERT_EQ(wideOf(found), scaledAsWritten(WideVec3(vectorOf(v))));
    ASSERT_EQ(found[3], 0);
    if (vectorOf(v) != Vec3(0)) {
      ASSERT_EQ(magnitudeBits(WideVec3(wideOf(found))), kUnitInputBits);
    }
  }
}

TEST(Frame, UnitVectorByHand) {
  const auto unitOf = [](const WideVec3& v) {
    Integers unit{};
    EXPECT_TRUE(unitVector(floatsOf(lanesOf(Vec3(v))), unit));
    return WideVec3(vectorOf(unit));
  };
  // 2^20 has the first seven fraction bits 0: bound 129 * 2^13, root floor(2^23 / sqrt(1056768)) = 8160.
  EXPECT_EQ(unitOf({0, 0, -1024}), WideVec3(0, 0, -4080));
  EXPECT_EQ(unitOf({1024, -1024, 0}), WideVec3(2885, -2885, 0));
  Integers untouched = lanes(1, 2, 3);
  EXPECT_FALSE(unitVector(Floats{}, untouched));
}

TEST(Frame, UnitVectorsAreAsWritten) {
  std::mt19937 random(5);
  double shortest = 1, longest = 0;
  for (int i = 0; i < 500'000; ++i) {
    const auto coordinate = [&] {
      constexpr int kEnds[] = {-2047, -1024, -1, 0, 1, 1023, 2047};
      return random() % 8 == 0 ? kEnds[random() % 7] : static_cast<int>(random() % 4095) - 2047;
    };
    WideVec3 v(coordinate(), coordinate(), coordinate());
    if (magnitudeBits(v) < kUnitInputBits) v[static_cast<int>(random() % 3)] = random() % 2 == 0 ? 1024 : -1500;
    Integers unit;
    ASSERT_TRUE(unitVector(floatsOf(lanesOf(Vec3(v))), unit));
    const WideVec3 found(vectorOf(unit));
    ASSERT_EQ(found, unitAsWritten(v));
    const double length = glm::length(glm::dvec3(found)) / kOne;
    shortest = std::min(shortest, length);
    longest = std::max(longest, length);
  }
  EXPECT_GT(shortest, 1 - std::ldexp(1.0, -7));
  EXPECT_LE(longest, 1);
}

TEST(Frame, CrossProductsAreExact) {
  std::mt19937 random(6);
  const auto coordinate = [&](int limit) {
    return random() % 4 == 0 ? limit * (1 - static_cast<int>(random() % 3))
                             : static_cast<int>(random() % (2u * static_cast<unsigned>(limit) + 1)) - limit;
  };
  for (int i = 0; i < 100000; ++i) {
    // Two scaled vectors; or one of them and an axis.
    WideVec3 a, b;
    for (int k = 0; k < 3; ++k) a[k] = coordinate(2047), b[k] = coordinate(i % 2 == 0 ? 2047 : 2364);
    const Floats found = crossProduct(floatsOf(lanesOf(Vec3(a))), floatsOf(lanesOf(Vec3(b))));
    ASSERT_EQ(wideOf(found), cross(a, b));
    ASSERT_EQ(found[3], 0);
  }
}

TEST(Frame, AsWrittenWhateverTheTriangle) {
  std::mt19937 random(2);
  for (int i = 0; i < 300000; ++i) {
    const Integers left = randomPoint(random), right = randomPoint(random);
    // Every third base lies near the gate.
    const Integers base = i % 3 == 0 ? ((left + right) >> 1) + (randomPoint(random) >> 25) : randomPoint(random);
    const Integers prediction = i % 2 == 0 ? left + right - base : randomPoint(random);
    for (const Basis basis : {Basis::kGate, Basis::kTip}) {
      const Frame frame = frameAt(basis, left, right, base, prediction);
      expectFrame(frame, frameAsWritten(basis, left, right, base, prediction));
      expectNearlyOrthonormal(frame, basis);
      if (testing::Test::HasFailure()) return;
    }
  }
}

TEST(Frame, AsWrittenAtTheEnds) {
  constexpr int kEnds[] = {-(1 << 27), -(1 << 27) + 1, -1, 0, 1, (1 << 24) + 1, (1 << 27) - 1};
  std::mt19937 random(7);
  const auto end = [&] { return lanes(kEnds[random() % 7], kEnds[random() % 7], kEnds[random() % 7]); };
  for (int i = 0; i < 100000; ++i) {
    const Integers left = end(), right = end(), base = end();
    // A prediction is within three times as much.
    const Integers prediction = i % 2 == 0 ? left + right - base : end();
    for (const Basis basis : {Basis::kGate, Basis::kTip}) {
      expectFrame(frameAt(basis, left, right, base, prediction), frameAsWritten(basis, left, right, base, prediction));
      if (testing::Test::HasFailure()) return;
    }
  }
}

TEST(Frame, GateAlignedByHand) {
  // As in BITSTREAM.md, section 6.4.
  const Frame frame =
      frameAt(Basis::kGate, lanes(64, 0, 0, 6), lanes(0, 64, 0, 5), lanes(0, 0, 0, 9), lanes(64, 64, 0));
  EXPECT_EQ(wideOf(frame.normal), WideVec3(0, 0, -4080));
  EXPECT_EQ(wideOf(frame.first), WideVec3(2885, -2885, 0));
  EXPECT_EQ(wideOf(frame.second), WideVec3(-2873, -2873, 0));
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
  const auto expectAxes = [](const Frame& frame) { expectFrame(frame, PlainFrame{}); };
  for (const Basis basis : {Basis::kGate, Basis::kTip}) {
    expectAxes(frameAt(basis, lanes(1, 2, 3), lanes(1, 2, 3), lanes(9, 9, 9), lanes(0, 0, 0)));
    expectAxes(frameAt(basis, lanes(0, 0, 0), lanes(2, 2, 2), lanes(6, 6, 6), lanes(7, 7, 7)));
  }
  expectAxes(frameAt(Basis::kTip, lanes(10, 0, 0), lanes(0, 0, 0), lanes(5, -8, 0), lanes(5, -8, 0)));
  expectAxes(frameAt(Basis::kTip, lanes(10, 0, 0), lanes(0, 0, 0), lanes(5, -8, 0), lanes(5, -8, 6)));
}

Frame randomFrame(std::mt19937& random, int i) {
  const Integers left = randomPoint(random), right = randomPoint(random);
  const Integers base = randomPoint(random), prediction = randomPoint(random);
  return frameAt(i % 2 == 0 ? Basis::kGate : Basis::kTip, left, right, base, prediction);
}

/// Both paths, of coordinates within 16 bits and of larger ones, against 64-bit arithmetic.
TEST(Frame, ToLatticeRoundsTheSum) {
  std::mt19937 random(3);
  for (int i = 0; i < 200000; ++i) {
    const Frame frame = randomFrame(random, i);
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

TEST(Frame, ToLocalRoundsDown) {
  std::mt19937 random(8);
  for (int i = 0; i < 200000; ++i) {
    const Frame frame = randomFrame(random, i);
    Lanes two;
    for (int k = 0; k < 8; ++k) two[k] = static_cast<std::int16_t>(random() >> random() % 16);
    if (i % 3 == 0) two[static_cast<int>(random() % 8)] = random() % 2 == 0 ? 32767 : -32768;
    const std::array<Integers, 2> found = toLocal(frame, two);
    const Lanes axes[3] = {frame.normal, frame.first, frame.second};
    for (int j = 0; j < 2; ++j) {
      for (int a = 0; a < 3; ++a) {
        std::int64_t sum = 0;
        for (int k = 0; k < 3; ++k) sum += std::int64_t{two[4 * j + k]} * axes[a][k];
        ASSERT_EQ(found[static_cast<std::size_t>(j)][a], sum >> kFrameBits);
      }
      ASSERT_EQ(found[static_cast<std::size_t>(j)][3], 0);
    }
  }
}

TEST(Frame, ThereAndNearlyBack) {
  std::mt19937 random(3);
  for (int i = 0; i < 10000; ++i) {
    const Integers left = randomPoint(random), right = randomPoint(random), base = randomPoint(random);
    const Frame frame = frameAt(Basis::kGate, left, right, base, Integers{});
    const auto coordinate = [&] { return static_cast<int>(random() % 2001) - 1000; };
    const int x = coordinate(), y = coordinate();
    const Integers displacement = lanes(x, y, coordinate());
    const Integers back = toLattice(frame, toLocal(frame, packed(displacement, displacement))[1]);
    // Each length comes in twice.
    for (int a = 0; a < 3; ++a) ASSERT_NEAR(back[a], displacement[a], 3 + 1800 * std::ldexp(1.0, -6)) << i;
  }
}

}  // namespace
}  // namespace tsc
