// What is known around a vertex when its position is coded (paper, Figure 1; BITSTREAM.md, section 6.2).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "frame.h"
#include "surface.h"

namespace tsc {

/// What the position coder remembers of a vertex: half a cache line.
struct VertexState {
  Vec3 position{0};                          ///< on the fine lattice
  std::array<std::uint16_t, 3> magnitude{};  ///< of the residual per component, saturated
  std::uint8_t hits = 0;                     ///< components that were exactly a candidate's, a bit each
  std::uint8_t valence = 0;                  ///< faces at the vertex, those of dummies included, saturated
  Vec3 surprise{0};                          ///< position - average of parallelograms
};

/// A complete parallelogram: gate left-right and base vertex are known, their faces exist.
struct Stencil {
  std::uint32_t left;
  std::uint32_t right;
  std::uint32_t base;
};

inline constexpr int kMaxStencils = 4;

struct Stencils {
  int count = 0;
  std::array<Stencil, kMaxStencils + 1> list;  ///< the last only serves the search
  std::uint32_t neighbour = kNone;             ///< where count is 0: the last known neighbour in that order
  std::uint8_t valence = 0;                    ///< faces at the vertex, those of dummies included, saturated
};

/// The complete parallelograms at `vertex`, in counter-clockwise order from `vertex_corner`, the first kMaxStencils.
/// `known` is 1 for the vertices whose position is known.
TSC_ALWAYS_INLINE Stencils stencilsAt(const Surface& surface, const std::vector<std::uint8_t>& known,
                                      std::uint32_t vertex) {
  Stencils result;
  const std::uint32_t* const vertices = surface.corner_vertex.data();
  const std::uint32_t* const opposites = surface.opposite.data();
  const std::uint32_t start = surface.vertex_corner[vertex];
  std::uint32_t at_vertex = start;
  std::uint32_t right_corner = previousCorner(start);
  std::uint32_t left_corner = nextCorner(start);
  std::uint32_t left = vertices[left_corner];
  std::uint8_t left_known = known[left];
  std::uint32_t count = 0;
  int valence = 0;
  do {
    const std::uint32_t right = vertices[right_corner];
    const std::uint32_t base = vertices[opposites[at_vertex]];
    const std::uint8_t right_known = known[right];
    // Without branches: what is known around a vertex follows no pattern that a processor could learn.
    result.list[count] = {left, right, base};
    count += left_known & right_known & known[base] & static_cast<std::uint8_t>(count < kMaxStencils);
    ++valence;
    // Across the edge from the vertex to `right`, which is the left vertex of the next face. The corner that faces the
    // edge there is at the next face's right vertex.
    right_corner = opposites[left_corner];
    const std::uint32_t first = right_corner / 3 * 3;
    at_vertex = right_corner + 1 - 3 * static_cast<std::uint32_t>(right_corner == first + 2);
    left_corner = 3 * first + 3 - at_vertex - right_corner;
    left = right;
    left_known = right_known;
  } while (at_vertex != start);
  result.count = static_cast<int>(count);
  result.valence = static_cast<std::uint8_t>(std::min(valence, 255));
  if (count == 0) {
    std::uint32_t corner = start;
    do {
      const std::uint32_t neighbour = vertices[previousCorner(corner)];
      if (known[neighbour]) result.neighbour = neighbour;
      corner = nextAroundVertex(surface, corner);
    } while (corner != start);
  }
  return result;
}

}  // namespace tsc
