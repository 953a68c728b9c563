// The stencils of a vertex in the order in which they lie around it, for effort max (BITSTREAM.md, section 6.9.1).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "stencil.h"
#include "surface.h"

namespace tsc {

/// A complete parallelogram, and the corner of its base triangle at `base`. Vertices by when they are coded.
struct ArcStencil {
  std::uint32_t left;
  std::uint32_t right;
  std::uint32_t base;
  std::uint32_t base_corner;
  std::uint32_t face;  ///< as in Stencils
};

struct Arc {
  int count = 0;
  std::array<ArcStencil, kMaxStencils> list;
};

/// The stencils, chained where one's `right` is another's `left`: first one that follows no other, then each time the
/// one that follows, or the first that is left.
inline Arc arcOf(const CodingOrder& order, const Stencils& stencils) {
  Arc arc;
  arc.count = stencils.count;
  const auto count = static_cast<std::size_t>(arc.count);
  for (std::size_t j = 0; j < count; ++j) {
    const Parallelogram p = stencils[j];
    const std::uint32_t face = stencils.face(j);
    arc.list[j] = {p.left, p.right, p.base, order.surface->opposite[order.firstCorner(face)], face};
  }
  for (std::size_t j = 0; j < count; ++j) {
    std::size_t next = j;
    for (std::size_t i = count; i-- > j;) {
      bool follows = false;
      for (std::size_t k = j; k < count; ++k) follows |= k != i && arc.list[k].right == arc.list[i].left;
      if (j == 0 ? !follows : arc.list[j - 1].right == arc.list[i].left) next = i;
    }
    std::swap(arc.list[j], arc.list[next]);
  }
  return arc;
}

/// When the vertices beyond the edges base-left and right-base of a stencil's base triangle are coded.
struct Wings {
  std::uint32_t left;
  std::uint32_t right;
};
inline Wings wingsOf(const CodingOrder& order, const ArcStencil& s) {
  // The gate runs from left to right in the vertex's face, and so from right to left in the base triangle.
  const std::uint32_t at_right = nextCorner(s.base_corner);
  const std::uint32_t at_left = previousCorner(s.base_corner);
  return {order.timeAt(order.surface->opposite[at_right]), order.timeAt(order.surface->opposite[at_left])};
}

}  // namespace tsc
