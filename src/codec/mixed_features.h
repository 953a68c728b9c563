// What effort max predicts a position from (BITSTREAM.md, section 6.9.2): vectors that both sides know, in the local
// frame, whose weights are learned by least squares.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "arc.h"
#include "frame.h"
#include "least_squares.h"
#include "predict.h"

namespace tsc {

struct MixedFeatures {
  int count = 0;  ///< padded with zeros to a multiple of 8
  std::array<LeastSquares::Features, 3> component{};

  void add(const WideVec3& local) {
    constexpr std::int64_t kLimit = std::int64_t{1} << 29;
    for (int a = 0; a < 3; ++a) {
      component[static_cast<std::size_t>(a)][static_cast<std::size_t>(count)] =
          static_cast<std::int32_t>(std::clamp(local[a], -kLimit, kLimit));
    }
    ++count;
  }
};

/// floor of the length; up to 2^25.5 a component, beyond that coarser.
inline std::int64_t lengthOf(const WideVec3& v) {
  const int shift = magnitudeBits(v) <= 25 ? 0 : 6;
  const WideVec3 small(v.x >> shift, v.y >> shift, v.z >> shift);
  return integerSqrt(dot(small, small)) << shift;
}

/// What is known around a vertex that is coded at `time`.
struct MixedSurrounding {
  const Surface& surface;
  std::span<const std::uint32_t> corner_time;
  std::span<const VertexState> states;
  std::uint32_t time;

  WideVec3 point(std::uint32_t at) const { return WideVec3(vectorOf(states[at].point)); }
  WideVec3 surprise(std::uint32_t at) const { return WideVec3(vectorOf(states[at].surprise())); }
  bool known(std::uint32_t at) const { return at < time; }
};

/// `valence` is the vertex's.
inline MixedFeatures mixedFeatures(const MixedSurrounding& around, const Arc& arc, std::int32_t valence,
                                   const Frame& frame, bool tangent) {
  MixedFeatures f;
  const auto add = [&](const WideVec3& v) { f.add(toLocal(frame, v)); };
  const auto bounded = [](std::int32_t factor) { return std::int64_t{std::clamp(factor, -12, 12)}; };
  const auto shifted = [](const WideVec3& v, int shift) { return WideVec3(v.x >> shift, v.y >> shift, v.z >> shift); };
  const auto heightOf = [&](const ArcStencil& s) {
    const WideVec3 base = around.point(s.base);
    return shifted(around.point(s.left) - base + around.point(s.right) - base, 1);
  };
  WideVec3 heights(0);
  for (int j = 0; j < arc.count; ++j) {
    const ArcStencil& s = arc.list[static_cast<std::size_t>(j)];
    const WideVec3 height = toLocal(frame, heightOf(s));
    heights += height;
    f.add(height);
    add(around.point(s.left) - around.point(s.right));
    add(around.surprise(s.base));
    if (j == 0) add(around.surprise(s.left));
    add(around.surprise(s.right));
  }
  const ArcStencil& gate = arc.list[0];
  const WideVec3 left = around.point(gate.left), right = around.point(gate.right), base = around.point(gate.base);
  const std::int32_t left_valence = around.states[gate.left].valence();
  const std::int32_t right_valence = around.states[gate.right].valence();
  const std::int32_t base_valence = around.states[gate.base].valence();
  const WideVec3 across = toLocal(frame, left - right);
  const WideVec3 height = toLocal(frame, heightOf(gate));
  f.add(shifted(heights * bounded(valence - 6), 3));
  f.add(shifted(across * bounded(left_valence - right_valence), 2));
  f.add(shifted(height * bounded(left_valence + right_valence - base_valence - 6), 2));
  for (int j = 0; j < std::min(arc.count, 2); ++j) {
    // How the surface bends over the base triangle's other edges.
    const ArcStencil& s = arc.list[static_cast<std::size_t>(j)];
    const Wings wings = wingsOf(around.surface, around.corner_time, s);
    const WideVec3 gate_vector = around.point(s.right) - around.point(s.left);
    const WideVec3 from = around.point(s.base);
    add(around.known(wings.left) ? around.point(wings.left) - from + gate_vector : WideVec3(0));
    add(around.known(wings.right) ? around.point(wings.right) - from - gate_vector : WideVec3(0));
  }
  if (tangent) {
    const std::int64_t to_left = lengthOf(left - base);
    const std::int64_t to_right = lengthOf(right - base);
    f.add({0, 0, lengthOf(left - right)});
    f.add({0, 0, to_left + to_right});
    f.add({0, to_left - to_right, lengthOf(heightOf(gate))});
  }
  f.count = (f.count + 7) / 8 * 8;
  return f;
}

}  // namespace tsc
