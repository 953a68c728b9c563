// What must hold for every closed surface.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "surface.h"

namespace tsc {

inline void expectClosedManifold(const Surface& surface) {
  const std::uint32_t corners = 3 * surface.faceCount();
  ASSERT_EQ(surface.corner_vertex.size(), corners);
  ASSERT_EQ(surface.opposite.size(), corners);
  ASSERT_EQ(surface.vertex_corner.size(), surface.vertexCount());
  std::vector<std::uint32_t> degree(surface.vertexCount(), 0);
  for (std::uint32_t c = 0; c < corners; ++c) {
    const std::uint32_t o = surface.opposite[c];
    ASSERT_LT(o, corners);
    ASSERT_NE(o, c);
    ASSERT_EQ(surface.opposite[o], c);
    ASSERT_EQ(surface.corner_vertex[nextCorner(c)], surface.corner_vertex[previousCorner(o)]);
    ASSERT_EQ(surface.corner_vertex[previousCorner(c)], surface.corner_vertex[nextCorner(o)]);
    ASSERT_LT(surface.corner_vertex[c], surface.vertexCount());
    ASSERT_NE(surface.corner_vertex[c], surface.corner_vertex[nextCorner(c)]);
    ++degree[surface.corner_vertex[c]];
  }
  for (std::uint32_t v = 0; v < surface.vertexCount(); ++v) {
    const std::uint32_t first = surface.vertex_corner[v];
    ASSERT_EQ(surface.corner_vertex[first], v);
    std::uint32_t turns = 0;
    std::uint32_t corner = first;
    do {
      ASSERT_EQ(surface.corner_vertex[corner], v);
      if (surface.isDummy(v)) {
        ASSERT_FALSE(surface.isDummy(surface.corner_vertex[nextCorner(corner)]));
      }
      corner = nextAroundVertex(surface, corner);
      ++turns;
    } while (corner != first && turns <= degree[v]);
    ASSERT_EQ(turns, degree[v]) << "the faces at a vertex are one umbrella";
  }
}

}  // namespace tsc
