// Local orthonormal bases in integers (paper, eq. 5 and eq. 7; BITSTREAM.md, section 6.4).
//
// Axes are in units of 2^-14. Every intermediate is an integer below 2^53, square root and division are followed at
// once by floor, so that all machines find the same basis.
#pragma once

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

inline constexpr int kFrameBits = 14;
inline constexpr int kUnitInputBits = 24;  // a vector is scaled to this many bits before it is normalised

// GLM's own products are for floating point only.
inline std::int64_t dot(const WideVec3& a, const WideVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline WideVec3 cross(const WideVec3& a, const WideVec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline std::int64_t largestMagnitude(const WideVec3& v) {
  return std::max(std::max(std::abs(v.x), std::abs(v.y)), std::abs(v.z));
}

/// floor(sqrt(n)) for 0 <= n < 2^52: the nearest double to a square root that is no integer never reaches the next one.
inline std::int64_t integerSqrt(std::int64_t n) { return static_cast<std::int64_t>(std::sqrt(static_cast<double>(n))); }

/// floor(a / b) for 0 <= a < 2^51, b > 0.
inline std::int64_t floorDivide(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<double>(a) / static_cast<double>(b));
}

/// `v` with its largest component scaled by a power of two to `bits` bits; right shifts round down.
inline WideVec3 scaledTo(const WideVec3& v, int bits) {
  const int shift = bits - std::bit_width(static_cast<std::uint64_t>(largestMagnitude(v)));
  if (shift >= 0) return v * (std::int64_t{1} << shift);
  return {v.x >> -shift, v.y >> -shift, v.z >> -shift};
}

/// `v` at length 2^14, rounded; zero for zero. Components below 2^50.
inline Vec3 unitVector(const WideVec3& v) {
  if (v == WideVec3(0)) return Vec3(0);
  const WideVec3 scaled = scaledTo(v, kUnitInputBits);
  const std::int64_t length = integerSqrt(dot(scaled, scaled));  // in [2^23, 2^25]
  const std::int64_t reciprocal = floorDivide(std::int64_t{1} << 44, length);
  const WideVec3 unit = scaled * reciprocal + (std::int64_t{1} << 29);
  return Vec3(unit.x >> 30, unit.y >> 30, unit.z >> 30);
}

/// `v` shifted right until no component needs more than `kUnitInputBits` bits.
inline WideVec3 limited(const Vec3& v) {
  const WideVec3 wide(v);
  return largestMagnitude(wide) >> kUnitInputBits == 0 ? wide : scaledTo(wide, kUnitInputBits);
}

struct Frame {
  Vec3 normal{1 << kFrameBits, 0, 0};  ///< x1
  Vec3 first{0, 1 << kFrameBits, 0};   ///< x2
  Vec3 second{0, 0, 1 << kFrameBits};  ///< x3 = x1 x x2
};

/// The lattice displacement of local coordinates (normal, first, second), |local| < 2^36.
inline Vec3 toLattice(const Frame& frame, const WideVec3& local) {
  const WideVec3 sum = WideVec3(frame.normal) * local.x + WideVec3(frame.first) * local.y +
                       WideVec3(frame.second) * local.z + (std::int64_t{1} << (kFrameBits - 1));
  return Vec3(sum.x >> kFrameBits, sum.y >> kFrameBits, sum.z >> kFrameBits);
}

/// Local coordinates of a lattice displacement, rounded.
inline WideVec3 toLocal(const Frame& frame, const Vec3& displacement) {
  const WideVec3 d(displacement);
  const std::int64_t half = std::int64_t{1} << (kFrameBits - 1);
  return {(dot(WideVec3(frame.normal), d) + half) >> kFrameBits, (dot(WideVec3(frame.first), d) + half) >> kFrameBits,
          (dot(WideVec3(frame.second), d) + half) >> kFrameBits};
}

/// The basis at a base triangle: x1 its normal, x2 along the gate (eq. 5) or from the base vertex to the prediction
/// (eq. 7; made orthogonal to x1). On a sliver without a normal, or where x2 vanishes: the coordinate axes.
TSC_ALWAYS_INLINE Frame frameAt(Basis basis, const Vec3& left, const Vec3& right, const Vec3& base,
                                const Vec3& prediction) {
  const WideVec3 gate = limited(left - right);
  const Vec3 normal = unitVector(cross(gate, limited(base - right)));
  if (normal == Vec3(0)) return {};
  const auto crossUnit = [](const Vec3& a, const Vec3& b) {
    const WideVec3 product = cross(WideVec3(a), WideVec3(b)) + (std::int64_t{1} << (kFrameBits - 1));
    return Vec3(product.x >> kFrameBits, product.y >> kFrameBits, product.z >> kFrameBits);
  };
  if (basis == Basis::kGate) {
    const Vec3 first = unitVector(gate);
    return {normal, first, crossUnit(normal, first)};
  }
  // The prediction may lie outside the plane of the base triangle, even above the base vertex: by way of x3, the axes
  // are orthogonal however small its part within the plane.
  const Vec3 second = unitVector(cross(WideVec3(normal), limited(prediction - base)));
  if (second == Vec3(0)) return {};
  return {normal, crossUnit(second, normal), second};
}

}  // namespace tsc
