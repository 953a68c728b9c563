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
#include "stencil.h"

namespace tsc {

inline constexpr int kFeatureSize = 15;  // bits of the largest feature

/// Four vectors in the local frame: lane j of component a is of vector j.
using LocalVectors = std::array<Integers, 3>;

/// Turns vectors of the lattice to the local frame, four at a time.
class ToLocal {
 public:
  /// `tangent`: whether the frame is another than the coordinate axes.
  ToLocal(const Frame& frame, bool tangent) : tangent_(tangent) {
    if (!tangent) return;
    const Lanes axes[3] = {frame.normal, frame.first, frame.second};
    for (std::size_t a = 0; a < 3; ++a) {
      const Integers axis = (Integers)axes[a];
      x_and_y_[a] = __builtin_shufflevector(axis, axis, 0, 0, 0, 0);
      z_[a] = __builtin_shufflevector(axis, axis, 1, 1, 1, 1);
    }
  }

  /// Rounded; components of the vectors within +-2^29.
  TSC_ALWAYS_INLINE LocalVectors operator()(Integers a, Integers b, Integers c, Integers d) const {
    const auto [x, y, z] = transposed(a, b, c, d);
    if (!tangent_) return {x, y, z};
    // In two parts of 15 bits; products with an axis fit 16 by 16 bits.
    constexpr int kPart = 15, kMask = (1 << kPart) - 1;
    const Lanes low = (Lanes)((x & kMask) | (y & kMask) << 16), low_z = (Lanes)(z & kMask);
    const Lanes high = (Lanes)(((x >> kPart) & 0xffff) | (y >> kPart) << 16), high_z = (Lanes)(z >> kPart);
    LocalVectors local;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Lanes x_and_y = (Lanes)x_and_y_[axis], only_z = (Lanes)z_[axis];
      const Integers low_sum = pairProducts(low, x_and_y) + pairProducts(low_z, only_z);
      const Integers high_sum = pairProducts(high, x_and_y) + pairProducts(high_z, only_z);
      local[axis] = (high_sum << (kPart - kFrameBits)) + ((low_sum + (1 << (kFrameBits - 1))) >> kFrameBits);
    }
    return local;
  }

 private:
  bool tangent_;
  Integers x_and_y_[3];  ///< of each axis, in the lower and the upper half of every lane
  Integers z_[3];        ///< in the lower half
};

/// What is known around a vertex that is coded at `time`.
struct MixedSurrounding {
  const CodingOrder& order;
  std::span<const VertexState> states;
  std::uint32_t time;

  Integers point(std::uint32_t at) const { return states[at].point & Integers{-1, -1, -1, 0}; }
  Integers surprise(std::uint32_t at) const { return states[at].surprise(); }
  Integers height(const ArcStencil& s) const {
    const Integers base = point(s.base);
    return ((point(s.left) - base) + (point(s.right) - base)) >> 1;
  }
  Integers gate(const ArcStencil& s) const { return point(s.left) - point(s.right); }

  /// How the surface bends over the other two edges of a stencil's base triangle; 0 where nothing is known beyond.
  std::array<Integers, 2> bends(const ArcStencil& s) const {
    const Wings wings = wingsOf(order, s);
    const Integers from = point(s.base);
    return {wings.left < time ? point(wings.left) - from - gate(s) : Integers{},
            wings.right < time ? point(wings.right) - from + gate(s) : Integers{}};
  }
};

/// floor of the lengths of four vectors, or coarser where any is long.
inline Integers lengthsOf(Integers a, Integers b, Integers c, Integers d) {
  const Transposed v = transposed(a, b, c, d);
  const int shift = magnitudeBits(magnitudes(v.x) | magnitudes(v.y) | magnitudes(v.z)) <= 25 ? 0 : 6;
  const auto half = [&](auto part) {
    const Doubles x = part(v.x >> shift), y = part(v.y >> shift), z = part(v.z >> shift);
    return roots(x * x + y * y + z * z);
  };
  const Doubles low = half(firstTwo), high = half(lastTwo);
  return Integers{static_cast<std::int32_t>(low[0]), static_cast<std::int32_t>(low[1]),
                  static_cast<std::int32_t>(high[0]), static_cast<std::int32_t>(high[1])}
         << shift;
}

/// What features are made of.
struct FeatureVectors {
  std::array<LocalVectors, 4> part{};  ///< surprises, height, gate and bends; the last two of the other stencils
  LocalVectors sizes{};                ///< lengths, along the tangential axes
  Lanes factors{};                     ///< of height, gate and height: how irregular valences are
};

/// `valence` is the vertex's.
inline FeatureVectors featureVectors(const MixedSurrounding& around, const Arc& arc, std::int32_t valence,
                                     const ToLocal& local, bool tangent) {
  const ArcStencil& gate = arc.list[0];
  const Integers height = around.height(gate), across = around.gate(gate);
  const std::array<Integers, 2> bends = around.bends(gate);
  FeatureVectors f;
  f.part[0] = local(around.surprise(gate.base), around.surprise(gate.left), around.surprise(gate.right), Integers{});
  f.part[1] = local(height, across, bends[0], bends[1]);
  const auto beside = [&](const ArcStencil& s) {
    return local(around.height(s), around.gate(s), around.surprise(s.base), around.surprise(s.right));
  };
  if (arc.count > 1) f.part[2] = beside(arc.list[1]);
  if (arc.count == 2) {
    const std::array<Integers, 2> others = around.bends(arc.list[1]);
    f.part[3] = local(others[0], others[1], Integers{}, Integers{});
  } else if (arc.count > 2) {
    f.part[3] = beside(arc.list[2]);
  }
  if (tangent) {
    const Integers base = around.point(gate.base);
    const Integers length = lengthsOf(across, around.point(gate.left) - base, around.point(gate.right) - base, height);
    f.sizes[1] = Integers{0, 0, length[1] - length[2], 0};
    f.sizes[2] = Integers{length[0], length[1] + length[2], length[3], 0};
  }
  const auto factor = [](std::int32_t irregularity) {
    return static_cast<std::int16_t>(std::clamp(irregularity, -7, 7) * (1 << 12));
  };
  const std::int32_t left = around.states[gate.left].valence(), right = around.states[gate.right].valence();
  const std::int32_t base = around.states[gate.base].valence();
  f.factors = Lanes{0, 0, 0, 0, factor(valence - 6), factor(left - right), factor(left + right - base - 6), 0};
  return f;
}

/// The features of a vertex with `stencil_count` stencils.
inline ScaledFeatures scaledFeatures(const FeatureVectors& f, int stencil_count) {
  ScaledFeatures result;
  result.count = stencil_count > 1 ? 24 : 16;
  const auto fold = [](Integers v) { return v ^ (v >> 31); };
  for (std::size_t a = 0; a < 3; ++a) {
    const Integers low = fold(f.part[0][a]) | fold(f.part[1][a]), high = fold(f.part[2][a]) | fold(f.part[3][a]);
    const int scale = kFeatureSize - magnitudeBits(low | high | fold(f.sizes[a]));
    result.scale[a] = scale;
    const auto shortened = [&](Integers first, Integers last) {
      return atLeast(packed(scaled(first, scale), scaled(last, scale)), splat(1 - (1 << kFeatureSize)));
    };
    const Lanes first = shortened(f.part[0][a], f.part[1][a]);
    const Lanes height_and_gate = __builtin_shufflevector(first, first, 0, 1, 2, 3, 4, 5, 4, 7);
    std::int16_t* const to = result.component[a].data();
    storeLanes(to, first);
    storeLanes(to + 8, shortened(f.sizes[a], Integers{}) + multiplyHigh(height_and_gate, f.factors));
    storeLanes(to + 16, shortened(f.part[2][a], f.part[3][a]));
  }
  return result;
}

/// The features, and their first three as they are: the local surprises of base, left and right of the first stencil.
struct MixedFeatures {
  ScaledFeatures scaled;
  LocalVectors surprise;
};

inline MixedFeatures mixedFeatures(const MixedSurrounding& around, const Arc& arc, std::int32_t valence,
                                   const ToLocal& local, bool tangent) {
  const FeatureVectors vectors = featureVectors(around, arc, valence, local, tangent);
  return {scaledFeatures(vectors, arc.count), vectors.part[0]};
}

}  // namespace tsc
