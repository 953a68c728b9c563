// What is known around a vertex when its position is coded (paper, Figure 1; BITSTREAM.md, section 6.2).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lanes.h"
#include "order.h"
#include "surface.h"

namespace tsc {

inline constexpr int kMaxStencils = 3;

/// What is known of a position before it is coded: its valence and its stencils, which are complete parallelograms. The
/// position stands first in a stencil's face; the other two, the gate, are coded before it, and so is the base across.
class UncodedState {
 public:
  struct Stencil {
    std::uint32_t face;  ///< its first corner's number
    std::uint32_t base;  ///< when it is coded
  };

  /// `valence` counts the faces at the vertex, those of dummies included; below 2^29.
  void start(std::uint32_t valence) {
    entries_[0].face = kNone;
    entries_[kMaxStencils].base = valence;
  }
  void start(std::uint32_t valence, const Stencil& first, bool is_complete) {
    entries_[0] = first;
    entries_[kMaxStencils].base = valence + (std::uint32_t{is_complete} << kCountShift);
  }
  void addFace() { ++entries_[kMaxStencils].base; }

  /// A face whose gate is coded before. The first kMaxStencils that are `complete`, their bases being so too, are kept.
  /// Without branches on what follows no pattern that a processor could learn: what is not kept is overwritten.
  TSC_ALWAYS_INLINE void add(const Stencil& stencil, bool complete) {
    const std::uint32_t numbers = entries_[kMaxStencils].base, count = numbers >> kCountShift & 3;
    entries_[count] = stencil;
    const bool is_kept = complete & (count < kMaxStencils);
    entries_[kMaxStencils].base = numbers + (std::uint32_t{is_kept} << kCountShift);
  }

  int count() const { return static_cast<int>(entries_[kMaxStencils].base >> kCountShift & 3); }
  std::int32_t valence() const {
    return static_cast<std::int32_t>(entries_[kMaxStencils].base & ((1u << kCountShift) - 1));
  }
  /// The first is a face without a known base where there are no stencils, and kNone if there is none with a known
  /// gate.
  const Stencil& operator[](std::size_t j) const { return entries_[j]; }

 private:
  static constexpr int kCountShift = 29;

  /// The last is no stencil, and its `base` the valence with the count above it.
  std::array<Stencil, kMaxStencils + 1> entries_;
};

/// What the position coder holds for a position: half a cache line.
struct alignas(32) VertexState {
  union {
    UncodedState uncoded;
    struct {
      Integers point;                      ///< x y z on the fine lattice, and the valence in lane 3
      std::array<std::int16_t, 8> memory;  ///< of how it was coded
    };
  };

  /// Faces at it, those of dummies included.
  std::int32_t valence() const { return point[3]; }
  /// Its position from the average of parallelograms, saturated to 16 bits.
  Integers surprise() const { return widened(memory.data()); }
  /// Of its residual per component, saturated.
  Integers magnitude() const { return widened(memory.data() + 4); }
  /// Bit 2 a is set where component a was exactly a candidate's.
  std::uint32_t hits() const { return static_cast<std::uint16_t>(memory[7]); }
};

/// Numbers of the vertices of a stencil in the order of coding.
struct Parallelogram {
  std::uint32_t left;
  std::uint32_t right;
  std::uint32_t base;
};

/// The stencils of a position that is about to be coded; refers to its state.
class Stencils {
 public:
  /// `corner_time` is that of the order.
  Stencils(const VertexState& state, std::span<const std::uint32_t> corner_time)
      : count(state.uncoded.count()),
        valence(state.uncoded.valence()),
        uncoded_(state.uncoded),
        corner_time_(corner_time.data()) {}

  /// Beyond `count` the first again.
  TSC_ALWAYS_INLINE Parallelogram operator[](std::size_t j) const {
    const UncodedState::Stencil& stencil = uncoded_[static_cast<int>(j) < count ? j : 0];
    const std::uint32_t* const time = corner_time_ + stencil.face;
    return {time[1], time[2], stencil.base};
  }
  /// The number of its first corner.
  std::uint32_t face(std::size_t j) const { return uncoded_[j].face; }
  /// Without a stencil there may still be a gate: that of the first then has no known base.
  bool hasGate() const { return face(0) != kNone; }

  const int count;
  const std::int32_t valence;  ///< faces at the vertex, those of dummies included

 private:
  const UncodedState& uncoded_;
  const std::uint32_t* corner_time_;
};

/// Enters into the states of all positions, which are by time, their stencils: the first kMaxStencils in the order of
/// faces. A face counts for the position that stands first in it, if that is coded after the other two.
inline void collectStencils(const CodingOrder& order, std::span<VertexState> states) {
  for (VertexState& state : states) state.uncoded.start(0);
  for (std::uint32_t face = 0; face < order.corner_time.size(); face += 3) {
    const std::uint32_t* const time = order.corner_time.data() + face;
    for (int k = 0; k < 3; ++k) {
      if (time[k] < states.size()) [[likely]]
        states[time[k]].uncoded.addFace();
    }
    if (time[0] >= states.size() || time[0] <= std::max(time[1], time[2])) continue;
    const std::uint32_t base = order.timeAt(order.surface->opposite[order.firstCorner(face)]);
    states[time[0]].uncoded.add({face, base}, base < time[0]);
  }
}

}  // namespace tsc
