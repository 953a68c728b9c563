// What the traversal keeps of the edges between faces: the surface's, or only the stencils that come of them.
//
// An edge of the front is *faced* from its known side by a corner, or by the vertex there where corners do not matter.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "buffer.h"
#include "stencil.h"
#include "surface.h"

namespace tsc {

/// Fills `opposite` and `vertex_corner` of the surface.
class SurfaceEdges {
 public:
  SurfaceEdges(Surface& surface, const SurfaceCounts& counts) : surface_(surface), dummy_count_(counts.dummies) {}

  void reserve(std::size_t corners, std::size_t vertices) {
    surface_.opposite.reserve(corners);
    surface_.vertex_corner.reserve(vertices + std::min<std::size_t>(vertices, dummy_count_));
  }
  void resize(std::size_t corners, std::size_t vertices) {
    surface_.opposite.resize(corners);
    surface_.vertex_corner.resize(vertices);
  }
  void finish() {
    surface_.vertex_corner.insert(surface_.vertex_corner.end(), dummy_corner_.begin(), dummy_corner_.end());
  }

  static std::uint32_t facing(std::uint32_t corner, std::uint32_t) { return corner; }
  void addVertex(std::uint32_t vertex, std::uint32_t, std::uint32_t corner) { surface_.vertex_corner[vertex] = corner; }
  void addTip(std::uint32_t vertex, std::uint32_t, std::uint32_t corner, std::uint32_t, std::uint32_t, std::uint32_t) {
    surface_.vertex_corner[vertex] = corner;
  }
  void addDummy(std::uint32_t corner) { dummy_corner_.push_back(corner); }
  void glue(std::uint32_t corner, std::uint32_t facing) {
    surface_.opposite[corner] = facing;
    surface_.opposite[facing] = corner;
  }
  void addFace(std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t) {}

 private:
  Surface& surface_;
  const std::uint32_t dummy_count_;
  std::vector<std::uint32_t> dummy_corner_;  ///< for each dummy one of its corners
};

/// Enters into the states what `collectStencils` would find on the whole surface, where a vertex's number is its time:
/// the valence of a vertex is its degree, and the first corner of each face is glued to a face before it.
class StencilEdges {
 public:
  StencilEdges(Buffer<VertexState>& states, const SurfaceCounts& counts)
      : states_(states), real_count_(counts.real_vertices) {}

  void reserve(std::size_t, std::size_t vertices) { states_.reserve(vertices); }
  void resize(std::size_t, std::size_t vertices) { states_.resize(vertices); }
  void finish() {}

  static std::uint32_t facing(std::uint32_t, std::uint32_t vertex) { return vertex; }
  void addVertex(std::uint32_t vertex, std::uint32_t degree, std::uint32_t) { states_[vertex].uncoded.start(degree); }
  /// A new vertex and the face that it comes with.
  TSC_ALWAYS_INLINE void addTip(std::uint32_t vertex, std::uint32_t degree, std::uint32_t face, std::uint32_t left,
                                std::uint32_t right, std::uint32_t base) {
    // What comes before is real, and what is not comes after.
    const bool has_gate = std::max(left, right) < vertex;
    states_[vertex].uncoded.start(degree, {has_gate ? face : kNone, base}, has_gate & (base < vertex));
  }
  void addDummy(std::uint32_t) {}
  void glue(std::uint32_t, std::uint32_t) {}
  /// The number of its first corner, its vertices, and what faces the edge of the last two from the other side.
  TSC_ALWAYS_INLINE void addFace(std::uint32_t face, std::uint32_t first, std::uint32_t second, std::uint32_t third,
                                 std::uint32_t base) {
    const bool has_gate = (first < real_count_) & (first > std::max(second, third));
    VertexState& state = has_gate ? states_[first] : nowhere_;
    state.uncoded.add({face, base}, base < first);
  }

 private:
  Buffer<VertexState>& states_;
  const std::uint32_t real_count_;
  VertexState nowhere_{};  ///< takes what is no stencil, without a branch
};

}  // namespace tsc
