// Small surfaces made by code, for the tests of the codec's stages.
#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "surface.h"

namespace tsc::test {

/// A surface from closed, oriented triangles; the last `dummy_count` vertices are dummies.
inline Surface closedSurface(std::uint32_t vertex_count, std::uint32_t dummy_count,
                             const std::vector<std::uint32_t>& corner_vertex) {
  Surface surface;
  surface.vertex_corner.assign(vertex_count, kNone);
  surface.real_count = vertex_count - dummy_count;
  surface.dummy_count = dummy_count;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> corner_facing;
  for (std::uint32_t c = 0; c < corner_vertex.size(); ++c) {
    if (surface.vertex_corner[corner_vertex[c]] == kNone) surface.vertex_corner[corner_vertex[c]] = c;
    corner_facing[{corner_vertex[nextCorner(c)], corner_vertex[previousCorner(c)]}] = c;
  }
  for (std::uint32_t c = 0; c < corner_vertex.size(); ++c) {
    surface.opposite.push_back(corner_facing.at({corner_vertex[previousCorner(c)], corner_vertex[nextCorner(c)]}));
  }
  surface.corner_vertex.assign(corner_vertex.begin(), corner_vertex.end());
  return surface;
}

inline Surface tetrahedron() { return closedSurface(4, 0, {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2}); }

/// Two triangles 0 1 2, 0 2 3 and four dummy faces around vertex 4.
inline Surface sheet() { return closedSurface(5, 1, {0, 1, 2, 0, 2, 3, 1, 0, 4, 2, 1, 4, 3, 2, 4, 0, 3, 4}); }

/// Twelve triangles; faces 2 i and 2 i + 1 are side i.
inline Surface cube() {
  const std::uint32_t sides[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                     {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  std::vector<std::uint32_t> corners;
  for (const auto& s : sides) corners.insert(corners.end(), {s[0], s[1], s[2], s[0], s[2], s[3]});
  return closedSurface(8, 0, corners);
}

/// A torus of width x height quads, each at least 3.
inline Surface torus(std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint32_t> corners;
  const auto at = [&](std::uint32_t x, std::uint32_t y) { return y % height * width + x % width; };
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      corners.insert(corners.end(), {at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      corners.insert(corners.end(), {at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  return closedSurface(width * height, 0, corners);
}

/// An open grid of (width - 1) x (height - 1) quads, closed by one dummy.
inline Surface grid(std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint32_t> corners;
  const std::uint32_t dummy = width * height;
  const auto at = [&](std::uint32_t x, std::uint32_t y) { return y * width + x; };
  for (std::uint32_t y = 0; y + 1 < height; ++y) {
    for (std::uint32_t x = 0; x + 1 < width; ++x) {
      corners.insert(corners.end(), {at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      corners.insert(corners.end(), {at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  for (std::uint32_t x = 0; x + 1 < width; ++x) {
    corners.insert(corners.end(), {at(x + 1, 0), at(x, 0), dummy});
    corners.insert(corners.end(), {at(x, height - 1), at(x + 1, height - 1), dummy});
  }
  for (std::uint32_t y = 0; y + 1 < height; ++y) {
    corners.insert(corners.end(), {at(0, y), at(0, y + 1), dummy});
    corners.insert(corners.end(), {at(width - 1, y + 1), at(width - 1, y), dummy});
  }
  return closedSurface(dummy + 1, 1, corners);
}

}  // namespace tsc::test
