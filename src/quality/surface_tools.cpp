// Checking, welding and edge pairing, as the measures need them.
#include "surface_tools.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>

namespace tsc {

std::optional<QualityError> checkSurface(const SurfaceView& surface) {
  const auto& indices = surface.indices;
  if (indices.size() % 3 != 0) {
    return QualityError{QualityErrorCode::kInvalidIndex,
                        std::to_string(indices.size()) + " indices are not a multiple of three"};
  }
  bool any = false;
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    for (std::size_t k = i; k < i + 3; ++k) {
      if (indices[k] >= surface.positions.size()) {
        return QualityError{QualityErrorCode::kInvalidIndex, "index " + std::to_string(indices[k]) + " in a mesh of " +
                                                                 std::to_string(surface.positions.size()) +
                                                                 " vertices"};
      }
      const auto [x, y, z] = surface.positions[indices[k]];
      if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z)) {
        return QualityError{QualityErrorCode::kNonFinitePosition,
                            "vertex " + std::to_string(indices[k]) + " has a coordinate that is not finite"};
      }
    }
    any = any || isProper(indices[i], indices[i + 1], indices[i + 2]);
  }
  if (!any) return QualityError{QualityErrorCode::kNoFaces, "the mesh has no faces"};
  return std::nullopt;
}

Welding weldPositions(const PositionView& positions) {
  const std::size_t count = positions.size();
  Welding welding;
  welding.point_of_vertex.resize(count);
  // Open addressing at most half full; slots hold points.
  const std::size_t capacity = std::bit_ceil(2 * count + 2);
  std::vector<std::uint32_t> slots(capacity, kNone);
  for (std::size_t v = 0; v < count; ++v) {
    const auto position = positions[v];
    std::uint64_t hash = 0;
    for (const double coordinate : position) {
      const auto bits = std::bit_cast<std::uint64_t>(coordinate + 0.0);  // -0 becomes +0
      hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
    std::size_t slot = hash & (capacity - 1);
    while (slots[slot] != kNone && positions[welding.vertex_of_point[slots[slot]]] != position) {
      slot = (slot + 1) & (capacity - 1);
    }
    if (slots[slot] == kNone) {
      slots[slot] = static_cast<std::uint32_t>(welding.vertex_of_point.size());
      welding.vertex_of_point.push_back(static_cast<std::uint32_t>(v));
    }
    welding.point_of_vertex[v] = slots[slot];
  }
  return welding;
}

std::vector<std::uint32_t> pairEdges(std::span<const std::uint32_t> indices, std::size_t vertex_count) {
  struct Side {
    std::uint32_t high;
    std::uint32_t corner;
  };
  const auto ends = [&](std::size_t corner) {
    const std::size_t first = corner - corner % 3;
    return std::minmax(indices[first + (corner - first + 1) % 3], indices[first + (corner - first + 2) % 3]);
  };
  // Sides in buckets by their lower vertex, then sorted by the higher one: equal neighbours share an edge.
  std::vector<std::uint32_t> start(vertex_count + 1, 0);
  for (std::size_t c = 0; c < indices.size(); ++c) ++start[ends(c).first + 1];
  for (std::size_t v = 0; v < vertex_count; ++v) start[v + 1] += start[v];
  std::vector<Side> sides(indices.size());
  std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
  for (std::size_t c = 0; c < indices.size(); ++c) {
    const auto [low, high] = ends(c);
    sides[next[low]++] = {high, static_cast<std::uint32_t>(c)};
  }
  std::vector<std::uint32_t> twin(indices.size(), kNone);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const auto begin = sides.begin() + start[v];
    const auto end = sides.begin() + start[v + 1];
    std::sort(begin, end,
              [](const Side& a, const Side& b) { return a.high != b.high ? a.high < b.high : a.corner < b.corner; });
    for (auto run = begin; run != end;) {
      auto stop = run;
      while (stop != end && stop->high == run->high) ++stop;
      if (stop - run == 2) {
        twin[run[0].corner] = run[1].corner;
        twin[run[1].corner] = run[0].corner;
      }
      run = stop;
    }
  }
  return twin;
}

void Box::add(const glm::dvec3& point) {
  low = empty ? point : glm::min(low, point);
  high = empty ? point : glm::max(high, point);
  empty = false;
}

double Box::diagonal() const { return empty ? 0 : glm::length(high - low); }

Box boxOf(const SurfaceView& surface) {
  Box box;
  for (const std::uint32_t index : surface.indices) {
    if (index < surface.positions.size()) box.add(pointAt(surface.positions, index));
  }
  return box;
}

double boundingBoxDiagonal(const SurfaceView& surface) { return boxOf(surface).diagonal(); }

}  // namespace tsc
