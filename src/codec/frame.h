// Local orthonormal bases in integers (paper, eq. 5 and eq. 7; BITSTREAM.md, section 6.4).
//
// Axes are in units of 2^-12. Every intermediate is an integer; those carried in floats are at most 2^24, which floats
// hold exactly, and what they are multiplied by to be scaled is a power of two, so that all machines find the same
// basis.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <glm/glm.hpp>

#include "lanes.h"
#include "tsc/codec.h"

namespace tsc {

using Vec3 = glm::ivec3;        // positions and displacements on the fine lattice
using WideVec3 = glm::i64vec3;  // products of these

inline Vec3 vectorOf(Integers v) { return {v[0], v[1], v[2]}; }
inline Integers lanesOf(const Vec3& v) { return Integers{v.x, v.y, v.z, 0}; }

inline constexpr int kFrameBits = 12;
inline constexpr int kUnitInputBits = 11;  // a vector is scaled to this many bits before it is normalised

// GLM's own products are for floating point only.
inline std::int64_t dot(const WideVec3& a, const WideVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline WideVec3 cross(const WideVec3& a, const WideVec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Bits of the largest magnitude.
inline int magnitudeBits(const WideVec3& v) {
  return std::bit_width(static_cast<std::uint64_t>(std::abs(v.x) | std::abs(v.y) | std::abs(v.z)));
}

/// floor(sqrt(n)) for 0 <= n < 2^52: the nearest double to a square root that is no integer never reaches the next one.
inline std::int64_t integerSqrt(std::int64_t n) { return static_cast<std::int64_t>(std::sqrt(static_cast<double>(n))); }

/// floor(a / b) for 0 <= a < 2^51, b > 0.
inline std::int64_t floorDivide(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<double>(a) / static_cast<double>(b));
}

/// x y z, 0 and the same again.
inline Lanes twice(Integers v) { return packed(v, v); }

/// Three axes: x y z 0 in 16-bit lanes, twice. Their lengths are at most 2^kFrameBits.
struct Frame {
  Lanes normal = twice(Integers{1 << kFrameBits, 0, 0, 0});  ///< x1
  Lanes first = twice(Integers{0, 1 << kFrameBits, 0, 0});   ///< x2
  Lanes second = twice(Integers{0, 0, 1 << kFrameBits, 0});  ///< x3 = x1 x x2
};

/// An integer vector, lane 3 being 0, with its largest component scaled by a power of two to kUnitInputBits bits,
/// rounded towards zero. Zero stays zero.
TSC_ALWAYS_INLINE Floats scaledForUnit(Floats v) {
  Floats size = magnitudes(v);
  size = larger(size, __builtin_shufflevector(size, size, 2, 3, 0, 1));
  size = larger(size, __builtin_shufflevector(size, size, 1, 0, 3, 2));
  // 2^(kUnitInputBits - 1 - exponent of the size). For a vector of zeros it does not matter.
  constexpr std::uint32_t kTop = (2u * 127 + kUnitInputBits - 1) << 23;
  return floatsOf(truncated(v * (Floats)(kTop - ((Words)size & 0x7f800000u))));
}
/// Of a displacement; lane 3 is anything. Where components take more than 24 bits they are rounded to these first.
TSC_ALWAYS_INLINE Floats scaledForUnit(Integers v) { return scaledForUnit(floatsOf(v & Integers{-1, -1, -1, 0})); }

/// Of integer vectors whose lengths' product is at most 2^24.
inline Floats crossProduct(Floats a, Floats b) {
  const Floats zxy = a * __builtin_shufflevector(b, b, 1, 2, 0, 3) - __builtin_shufflevector(a, a, 1, 2, 0, 3) * b;
  return __builtin_shufflevector(zxy, zxy, 1, 2, 0, 3);
}

/// floor(2^(kFrameBits + 11) / sqrt(n)) times 2^-11, for the largest n of those that share their exponent and the first
/// kRootBits of the fraction; n from 2^20 on.
inline constexpr int kRootBits = 7;
inline constexpr int kLeastSquareBits = 2 * (kUnitInputBits - 1);
inline constexpr std::array<float, 4 << kRootBits> kReciprocalRoots = [] {
  std::array<float, 4 << kRootBits> table{};
  std::int64_t root = std::int64_t{1} << (kFrameBits + 1);
  for (std::int64_t i = 0; i < std::ssize(table); ++i) {
    const std::int64_t fraction = (1 << kRootBits) + (i & ((1 << kRootBits) - 1)) + 1;
    const std::int64_t largest = fraction << ((i >> kRootBits) + kLeastSquareBits - kRootBits);
    while (root * root * largest > std::int64_t{1} << (2 * kFrameBits + 22)) --root;
    table[static_cast<std::size_t>(i)] = static_cast<float>(root) / (1 << 11);
  }
  return table;
}();

/// `v`, as `scaledForUnit` gives it, at a length of 2^kFrameBits, less by at most 2^-7 of it; false if it is zero.
TSC_ALWAYS_INLINE bool unitVector(Floats v, Integers& unit) {
  const Floats squares = v * v;
  const Floats square = squares + __builtin_shufflevector(squares, squares, 1, 2, 0, 3) +
                        __builtin_shufflevector(squares, squares, 2, 0, 1, 3);
  const std::int32_t root = ((Integers)square)[0] >> (23 - kRootBits);
  constexpr std::int32_t kFirst = (127 + kLeastSquareBits) << kRootBits;
  if (root < kFirst) [[unlikely]]
    return false;
  unit = truncated(v * (Floats{} + kReciprocalRoots[static_cast<std::size_t>(root - kFirst)]));
  return true;
}

/// The basis at a base triangle: x1 its normal, x2 along the gate (eq. 5) or from the base vertex to the prediction
/// (eq. 7; made orthogonal to x1). On a sliver without a normal, or where x2 vanishes: the coordinate axes.
TSC_ALWAYS_INLINE Frame frameAt(Basis basis, Integers left, Integers right, Integers base, Integers prediction) {
  constexpr float kUnit = 1.0f / (1 << kFrameBits);
  const Floats gate = scaledForUnit(left - right);
  const Floats across = crossProduct(gate, scaledForUnit(base - right));
  Integers normal, first, second;
  if (!unitVector(scaledForUnit(across), normal)) return {};
  if (basis == Basis::kGate) {
    if (!unitVector(gate, first)) return {};
    second = truncated(crossProduct(floatsOf(normal), floatsOf(first)) * kUnit);
  } else {
    // The prediction may lie outside the plane of the base triangle, even above the base vertex: by way of x3, the axes
    // are orthogonal however small its part within the plane.
    const Floats upright = crossProduct(floatsOf(normal), scaledForUnit(prediction - base));
    if (!unitVector(scaledForUnit(upright), second)) return {};
    first = truncated(crossProduct(floatsOf(second), floatsOf(normal)) * kUnit);
  }
  return {twice(normal), twice(first), twice(second)};
}

/// Local coordinates of two lattice displacements in 16-bit lanes x y z, anything; rounded down.
TSC_ALWAYS_INLINE std::array<Integers, 2> toLocal(const Frame& frame, Lanes two) {
  const Integers normal = pairProducts(two, frame.normal), first = pairProducts(two, frame.first);
  const Integers second = pairProducts(two, frame.second);
  const Integers low = __builtin_shufflevector(normal, first, 0, 4, 1, 5);
  const Integers high = __builtin_shufflevector(normal, first, 2, 6, 3, 7);
  const Integers low_rest = __builtin_shufflevector(second, Integers{}, 0, 4, 1, 5);
  const Integers high_rest = __builtin_shufflevector(second, Integers{}, 2, 6, 3, 7);
  const auto sum = [](Integers a, Integers b) {
    return (__builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7)) >> kFrameBits;
  };
  return {sum(low, low_rest), sum(high, high_rest)};
}

/// The lattice displacement of local coordinates (normal, first, second, 0), |local| < 2^30.
TSC_ALWAYS_INLINE Integers toLattice(const Frame& frame, Integers local) {
  constexpr std::int32_t kHalf = 1 << (kFrameBits - 1);
  if (isZero((local + (1 << 15)) >> 16)) [[likely]] {
    const Integers short_local = (Integers)packed(local, local);
    const Lanes two = (Lanes)__builtin_shufflevector(short_local, short_local, 0, 0, 0, 0);
    const Lanes third = (Lanes)__builtin_shufflevector(short_local, short_local, 1, 1, 1, 1);
    const Lanes normal_and_first = __builtin_shufflevector(frame.normal, frame.first, 0, 8, 1, 9, 2, 10, 3, 11);
    const Lanes only_second = __builtin_shufflevector(frame.second, Lanes{}, 0, 8, 1, 9, 2, 10, 3, 11);
    return (pairProducts(normal_and_first, two) + pairProducts(only_second, third) + kHalf) >> kFrameBits;
  }
  Integers result{};
  for (int i = 0; i < 3; ++i) {
    result[i] =
        static_cast<std::int32_t>((std::int64_t{frame.normal[i]} * local[0] + std::int64_t{frame.first[i]} * local[1] +
                                   std::int64_t{frame.second[i]} * local[2] + kHalf) >>
                                  kFrameBits);
  }
  return result;
}

}  // namespace tsc
