// What is known around a vertex when its position is coded (paper, Figure 1; BITSTREAM.md, section 6.2).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lanes.h"
#include "surface.h"

namespace tsc {

inline constexpr int kMaxStencils = 3;

/// What the position coder holds for a position: half a cache line. Until it is coded, `point` holds its stencils.
struct alignas(32) VertexState {
  Integers point = {-1, -1, -1, 0};      ///< x y z on the fine lattice, and the valence in lane 3
  std::array<std::int16_t, 8> memory{};  ///< of how it was coded

  /// Faces at it, those of dummies included.
  std::int32_t valence() const { return point[3]; }
  /// Its position from the average of parallelograms, saturated to 16 bits.
  Integers surprise() const { return widened(memory.data()); }
  /// Of its residual per component, saturated.
  Integers magnitude() const { return widened(memory.data() + 4); }
  /// Components that were exactly a candidate's, a bit each.
  std::int32_t hits() const { return memory[7]; }
};

/// A complete parallelogram by its face: the face's corner at the vertex itself is number `corner` & 3 of face
/// `corner` >> 2. The face's other vertices, the gate, are known, and so is the base vertex across.
struct Stencils {
  int count = 0;
  std::array<std::uint32_t, kMaxStencils> corner;  ///< beyond `count` the first again; of a face without a known base
                                                   ///< where count is 0, kNone if there is no face with a known gate
  std::int32_t valence = 0;                        ///< faces at the vertex, those of dummies included
};

/// Numbers of the vertices of a stencil in the order of coding.
struct Parallelogram {
  std::uint32_t left;
  std::uint32_t right;
  std::uint32_t base;
};

namespace stencil_row {
inline constexpr int kCountShift = 29;
inline int count(const Integers& row) { return row[3] >> kCountShift & 3; }
}  // namespace stencil_row

/// Enters into the states which stencils each position will have. `corner_time` holds for each corner when the position
/// at it is coded, later than all for dummies; equal times are one position. A face counts for the last of its three positions,
/// if its base comes before that, too. The first kMaxStencils in the order of faces are kept.
inline void collectStencils(const Surface& surface, std::span<const std::uint32_t> corner_time,
                            std::vector<VertexState>& states) {
  const std::uint32_t faces = surface.faceCount();
  for (std::uint32_t f = 0; f < faces; ++f) {
    const std::uint32_t* const time = corner_time.data() + 3 * std::size_t{f};
    const std::uint32_t early = time[0] < time[1] ? time[0] : time[1];
    const std::uint32_t late = time[0] < time[1] ? time[1] : time[0];
    const bool is_third = time[2] > late;
    const std::uint32_t k = is_third ? 2 : static_cast<std::uint32_t>(time[0] < time[1]);
    const std::uint32_t last = is_third ? time[2] : late;
    const std::uint32_t middle = is_third ? late : time[2] > early ? time[2] : early;
    if (last >= states.size()) [[unlikely]] {
      for (int k = 0; k < 3; ++k) {
        if (time[k] < states.size()) ++states[time[k]].point[3];
      }
      continue;
    }
    for (int i = 0; i < 3; ++i) ++states[time[i]].point[3];
    const std::uint32_t base = corner_time[surface.opposite[3 * f + k]];
    Integers& row = states[last].point;
    const int stencils = stencil_row::count(row);
    // Without branches on what follows no pattern that a processor could learn.
    const bool kept = (stencils < kMaxStencils) & (middle < last);
    Integers passed;
    (kept ? row : passed)[stencils & 3] = static_cast<std::int32_t>(f << 2 | k);
    row[3] += static_cast<std::int32_t>(kept & (base < last)) << stencil_row::kCountShift;
  }
}

/// The stencils that a state holds until its position is coded.
inline Stencils stencilsOf(const VertexState& state) {
  Stencils s;
  s.count = stencil_row::count(state.point);
  s.valence = state.point[3] & ((1 << stencil_row::kCountShift) - 1);
  s.corner[0] = static_cast<std::uint32_t>(state.point[0]);
  s.corner[1] = s.count > 1 ? static_cast<std::uint32_t>(state.point[1]) : s.corner[0];
  s.corner[2] = s.count > 2 ? static_cast<std::uint32_t>(state.point[2]) : s.corner[0];
  return s;
}

inline Parallelogram parallelogramAt(const Surface& surface, std::span<const std::uint32_t> corner_time,
                                     std::uint32_t corner) {
  static constexpr std::array<std::uint8_t, 4> kNext = {1, 2, 0, 0};
  static constexpr std::array<std::uint8_t, 4> kPrevious = {2, 0, 1, 0};
  const std::size_t first = std::size_t{3} * (corner >> 2);
  const std::size_t k = corner & 3;
  return {corner_time[first + kNext[k]], corner_time[first + kPrevious[k]], corner_time[surface.opposite[first + k]]};
}

}  // namespace tsc
