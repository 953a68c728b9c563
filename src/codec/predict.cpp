#include "predict.h"

namespace tsc {
namespace {

constexpr int kAngleInputBits = 17;
constexpr int kCrossBits = 24;

/// Umbrellas are walked this far at most: a hostile stream could otherwise make the sum of walks quadratic.
constexpr int kMaxAngleWalk = 32;

constexpr std::int32_t kMaxValence = 255;  // more makes no difference to an angle

/// atan(y / x) for 0 <= y <= x, x > 0: pi/4 t + 0.273 t (1 - t), off by less than 0.004.
std::int64_t octantAngle(std::int64_t y, std::int64_t x) {
  const std::int64_t t = floorDivide(y << 15, x);
  return (t >> 2) + ((t * (kHalfTurn - t) * 2847) >> 30);  // 0.273 / pi * 2^15 = 2847
}

/// Angle in [0, pi] of a vector with y >= 0.
std::int64_t angleOf(std::int64_t y, std::int64_t x) {
  const std::int64_t ax = std::abs(x);
  if (y == 0 && ax == 0) return 0;
  const std::int64_t first_quadrant = y <= ax ? octantAngle(y, ax) : kHalfTurn / 2 - octantAngle(ax, y);
  return x >= 0 ? first_quadrant : kHalfTurn - first_quadrant;
}

/// Bhaskara's rational sine for an angle in [0, pi], in units of 2^-15.
std::int64_t sine(std::int64_t angle) {
  const std::int64_t u = angle * (kHalfTurn - angle);  // at most 2^28
  return floorDivide((16 * u) << 15, 5 * kHalfTurn * kHalfTurn - 4 * u);
}

}  // namespace

Angle innerAngle(const Vec3& tip, const Vec3& a, const Vec3& b) {
  // One common scale for both sides keeps the angle.
  WideVec3 u(a - tip);
  WideVec3 v(b - tip);
  const int excess = std::max(magnitudeBits(u), magnitudeBits(v)) - kAngleInputBits;
  if (excess > 0) {
    u = {u.x >> excess, u.y >> excess, u.z >> excess};
    v = {v.x >> excess, v.y >> excess, v.z >> excess};
  }
  const std::int64_t cosine = dot(u, v);  // below 2^38
  const WideVec3 normal = cross(u, v);    // components below 2^37
  const int cross_bits = magnitudeBits(normal);
  const int shift = std::max(0, cross_bits - kCrossBits);
  const WideVec3 small(normal.x >> shift, normal.y >> shift, normal.z >> shift);
  const std::int64_t length = integerSqrt(dot(small, small)) << shift;
  if (length == 0) return {};
  const std::int64_t magnitude = std::min(floorDivide(std::abs(cosine) << 12, length), kCotangentLimit);
  return {angleOf(length, cosine), cosine < 0 ? -magnitude : magnitude};
}

std::int64_t cotangentOf(std::int64_t angle) {
  const std::int64_t clamped = std::clamp<std::int64_t>(angle, 256, kHalfTurn - 256);
  const std::int64_t sin = sine(clamped);
  const std::int64_t from_middle = kHalfTurn / 2 - clamped;
  const std::int64_t cosine = sine(std::abs(from_middle));  // |cos t| = sin |pi/2 - t|
  const std::int64_t magnitude = floorDivide(cosine << 12, sin);
  return from_middle < 0 ? -magnitude : magnitude;
}

ExpectedAngles expectedAngles(const AngleContext& context, std::uint32_t time, std::uint32_t face, std::int32_t valence,
                              bool use_known_angles) {
  const CodingOrder& order = context.order;
  const std::span<const VertexState> states = context.states;
  const std::uint32_t* const times = order.corner_time.data() + face;
  const auto byValence = [](std::int32_t faces) {
    return floorDivide(2 * kHalfTurn, std::clamp(faces, 3, kMaxValence));
  };
  ExpectedAngles expected{byValence(states[times[1]].valence()), byValence(states[times[2]].valence()),
                          byValence(valence)};
  if (use_known_angles) {
    // What the triangles with three known corners leave of the full turn, shared by the rest.
    const auto remaining = [&](std::uint32_t first_corner, std::int64_t fallback) {
      const Vec3 tip = vectorOf(states[order.timeAt(first_corner)].point);
      std::int64_t left_over = 2 * kHalfTurn;
      std::int64_t unknown = 0;
      std::uint32_t corner = first_corner;
      int steps = 0;
      do {
        const std::uint32_t a = order.timeAt(nextCorner(corner));
        const std::uint32_t b = order.timeAt(previousCorner(corner));
        if (a < time && b < time) {
          left_over -= innerAngle(tip, vectorOf(states[a].point), vectorOf(states[b].point)).value;
        } else {
          ++unknown;
        }
        corner = nextAroundVertex(*order.surface, corner);
      } while (corner != first_corner && ++steps < kMaxAngleWalk);
      return unknown > 0 && left_over > 0 ? floorDivide(left_over, unknown) : fallback;
    };
    const std::uint32_t at_tip = order.firstCorner(face);
    expected.left = remaining(nextCorner(at_tip), expected.left);
    expected.right = remaining(previousCorner(at_tip), expected.right);
  }
  const std::int64_t sum = expected.left + expected.right + expected.tip;
  expected.left = floorDivide(expected.left * kHalfTurn, sum);
  expected.right = floorDivide(expected.right * kHalfTurn, sum);
  expected.tip = kHalfTurn - expected.left - expected.right;
  return expected;
}

WideVec3 weightedParallelogram(const Vec3& left, const Vec3& right, const Vec3& base, ExpectedAngles expected) {
  const std::int64_t alpha = innerAngle(left, right, base).cotangent;
  const std::int64_t beta = innerAngle(right, base, left).cotangent;
  const std::int64_t gamma = cotangentOf(expected.left);
  const std::int64_t delta = cotangentOf(expected.right);
  const std::int64_t sum = gamma + delta;
  if (sum < kCotangentOne / 16) return WideVec3(left + right - base);
  const auto ratio = [&](std::int64_t numerator) {
    const std::int64_t magnitude = floorDivide(std::abs(numerator) << 12, sum);
    return numerator < 0 ? -magnitude : magnitude;
  };
  const std::int64_t w1 = ratio(beta + delta);
  const std::int64_t w2 = ratio(alpha + gamma);
  constexpr std::int64_t kLimit = 8 << 12;
  if (std::abs(w1) > kLimit || std::abs(w2) > kLimit) return WideVec3(left + right - base);
  const WideVec3 offset = WideVec3(left - base) * w1 + WideVec3(right - base) * w2 + (std::int64_t{1} << 11);
  return WideVec3(base) + WideVec3(offset.x >> 12, offset.y >> 12, offset.z >> 12);
}

}  // namespace tsc
