// Local orthonormal bases in integers (paper, eq. 5 and eq. 7; BITSTREAM.md, section 6.4).
//
// Axes are in units of 2^-13. Every intermediate is an integer below 2^53, square root and division are followed at
// once by floor, so that all machines find the same basis.
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

inline constexpr int kFrameBits = 13;
inline constexpr int kUnitInputBits = 14;  // a vector is scaled to this many bits before it is normalised

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

/// Three axes, in lanes x y z; lane 3 is 0. Components are within 16 bits.
struct Frame {
  Integers normal = {1 << kFrameBits, 0, 0, 0};  ///< x1
  Integers first = {0, 1 << kFrameBits, 0, 0};   ///< x2
  Integers second = {0, 0, 1 << kFrameBits, 0};  ///< x3 = x1 x x2
};

/// `v` at a length between 2^13 and 2^14 * sqrt(3): its largest component scaled by a power of two to kUnitInputBits
/// bits. Lane 3 becomes 0.
TSC_ALWAYS_INLINE Integers scaledForUnit(Integers v) {
  const Integers vector = v & Integers{-1, -1, -1, 0};
  return scaled(vector, kUnitInputBits - magnitudeBits(vector));
}

/// Of vectors within +-2^14.
inline Integers crossProduct(Integers a, Integers b) {
  const Integers a_yzx = __builtin_shufflevector(a, a, 1, 2, 0, 3), a_zxy = __builtin_shufflevector(a, a, 2, 0, 1, 3);
  const Integers b_yzx = __builtin_shufflevector(b, b, 1, 2, 0, 3), b_zxy = __builtin_shufflevector(b, b, 2, 0, 1, 3);
  return shortProducts(a_yzx, b_zxy, a_zxy, -b_yzx);
}

/// floor(2^28 / sqrt(n)) for n in the middle of [i, i + 1) * 2^19; for i below 128, of which there are none, 0.
inline constexpr int kRootShift = 19;
inline constexpr std::array<std::int16_t, (3 << (28 - kRootShift)) + 1> kReciprocalRoots = [] {
  std::array<std::int16_t, (3 << (28 - kRootShift)) + 1> table{};
  std::int64_t root = 1 << 13;
  for (std::int64_t i = 128; i < std::ssize(table); ++i) {
    const std::int64_t middle = (2 * i + 1) << (kRootShift - 1);
    while ((root + 1) * (root + 1) <= middle) ++root;
    table[static_cast<std::size_t>(i)] = static_cast<std::int16_t>((std::int64_t{1} << 28) / root);
  }
  return table;
}();

/// `v`, as `scaledForUnit` gives it and not zero, at a length of 2^13, to 2^-8 of it.
inline Integers unitVector(Integers v) {
  Integers square = shortProducts(v, v);
  square += __builtin_shufflevector(square, square, 2, 3, 0, 1);
  square += __builtin_shufflevector(square, square, 1, 0, 3, 2);  // in [2^26, 3 * 2^28]
  return shortProducts(v, splatInteger(kReciprocalRoots[static_cast<std::size_t>(square[0] >> kRootShift)])) >> 15;
}

/// The basis at a base triangle: x1 its normal, x2 along the gate (eq. 5) or from the base vertex to the prediction
/// (eq. 7; made orthogonal to x1). On a sliver without a normal, or where x2 vanishes: the coordinate axes.
TSC_ALWAYS_INLINE Frame frameAt(Basis basis, Integers left, Integers right, Integers base, Integers prediction) {
  const Integers gate = scaledForUnit(left - right);
  const Integers across = crossProduct(gate, scaledForUnit(base - right));
  if (isZero(across)) [[unlikely]]
    return {};
  const Integers normal = unitVector(scaledForUnit(across));
  if (basis == Basis::kGate) {
    const Integers first = unitVector(gate);
    return {normal, first, crossProduct(normal, first) >> kFrameBits};
  }
  // The prediction may lie outside the plane of the base triangle, even above the base vertex: by way of x3, the axes
  // are orthogonal however small its part within the plane.
  const Integers upright = crossProduct(normal, scaledForUnit(prediction - base));
  if (isZero(upright)) return {};
  const Integers second = unitVector(scaledForUnit(upright));
  return {normal, crossProduct(second, normal) >> kFrameBits, second};
}

/// Local coordinates of a lattice displacement within +-2^30, rounded.
inline WideVec3 toLocal(const Frame& frame, const WideVec3& displacement) {
  const auto along = [&](Integers axis) {
    return (axis[0] * displacement.x + axis[1] * displacement.y + axis[2] * displacement.z + (1 << (kFrameBits - 1))) >>
           kFrameBits;
  };
  return {along(frame.normal), along(frame.first), along(frame.second)};
}

/// The lattice displacement of local coordinates (normal, first, second), |local| < 2^30.
TSC_ALWAYS_INLINE Integers toLattice(const Frame& frame, Integers local) {
  constexpr std::int32_t kHalf = 1 << (kFrameBits - 1);
  if (isZero((local + (1 << 15)) >> 16)) [[likely]] {
    const Integers along_normal = __builtin_shufflevector(local, local, 0, 0, 0, 0);
    const Integers along_first = __builtin_shufflevector(local, local, 1, 1, 1, 1);
    const Integers along_second = __builtin_shufflevector(local, local, 2, 2, 2, 2);
    return (shortProducts(frame.normal, along_normal, frame.first, along_first) +
            shortProducts(frame.second, along_second) + kHalf) >>
           kFrameBits;
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
