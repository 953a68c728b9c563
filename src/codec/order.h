// The order in which positions are coded (BITSTREAM.md, section 6.2).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "references.h"
#include "surface.h"
#include "tsc/codec.h"

namespace tsc {

/// Visits every vertex that is no dummy once, next always one with the most complete parallelograms (three or more
/// count alike; first come, first served), seeding each component with the face of its lowest vertex. `visit(vertex)`
/// returns false to stop. Linear time.
template <class Visit>
void visitByDegree(const Surface& surface, Visit&& visit) {
  constexpr int kCap = 3;
  std::vector<std::uint8_t> visited(surface.vertexCount());
  std::fill(visited.begin() + surface.real_count, visited.end(), std::uint8_t{1});
  std::vector<std::uint8_t> known(surface.vertexCount());
  std::vector<std::uint8_t> degree(surface.vertexCount());
  std::array<std::vector<std::uint32_t>, kCap + 1> queue;
  std::array<std::size_t, kCap + 1> head{};
  bool going = true;

  const auto gain = [&](std::uint32_t v) {
    if (visited[v] || degree[v] == kCap) return;
    queue[++degree[v]].push_back(v);
  };
  const auto take = [&](std::uint32_t v) {
    if (visited[v]) return;
    visited[v] = 1;
    known[v] = 1;
    going = going && visit(v);
    const std::uint32_t start = surface.vertex_corner[v];
    std::uint32_t corner = start;
    do {
      const std::uint32_t next = nextCorner(corner);
      const std::uint32_t previous = previousCorner(corner);
      const std::uint32_t a = surface.corner_vertex[next];
      const std::uint32_t b = surface.corner_vertex[previous];
      // The vertex as base of the tip beyond its opposite edge, and as an end of the gate v-a. The gate v-b is the next
      // face's v-a.
      if (known[a] & known[b]) gain(surface.corner_vertex[surface.opposite[corner]]);
      const std::uint32_t beyond = surface.corner_vertex[surface.opposite[previous]];  // across the edge v-a
      if (known[a] & known[b]) gain(beyond);
      if (known[a] & known[beyond]) gain(b);
      corner = nextCorner(surface.opposite[next]);
    } while (corner != start);
  };

  for (std::uint32_t seed = 0; seed < surface.real_count && going; ++seed) {
    if (visited[seed]) continue;
    const std::uint32_t corner = surface.vertex_corner[seed];
    take(seed);
    take(surface.corner_vertex[nextCorner(corner)]);
    take(surface.corner_vertex[previousCorner(corner)]);
    for (int d = kCap; d > 0 && going;) {
      if (head[d] == queue[d].size()) {
        --d;
        continue;
      }
      const std::uint32_t v = queue[d][head[d]++];
      if (visited[v] || degree[v] != d) continue;
      take(v);
      d = kCap;
    }
  }
}

/// When each position is coded. Refers to the surface and the map that it was made of.
struct CodingOrder {
  const Surface* surface = nullptr;
  /// For each face the times of the positions at its corners, later than all for dummies. They stand as in the surface
  /// where vertices are numbered by time, and otherwise turned so that the last comes first.
  std::span<const std::uint32_t> corner_time;
  std::span<const std::uint32_t> vertex_time;  ///< empty where it is the vertex's number
  std::vector<std::uint32_t> position;         ///< position number by time; empty where they are the same
  std::vector<std::uint32_t> corner_storage, vertex_storage;  ///< of the times, where they are not another's

  std::uint32_t timeAt(std::uint32_t corner) const {
    const std::uint32_t vertex = surface->corner_vertex[corner];
    return vertex_time.empty() ? vertex : vertex_time[vertex];
  }
  std::uint32_t positionAt(std::uint32_t time) const { return position.empty() ? time : position[time]; }
  /// The surface's corner whose time stands first in that of `face`, given by its first corner's number.
  std::uint32_t firstCorner(std::uint32_t face) const {
    std::uint32_t corner = face;
    if (!vertex_time.empty()) {
      while (timeAt(corner) != corner_time[face]) ++corner;
    }
    return corner;
  }
};

inline CodingOrder codingOrder(const Surface& surface, const PositionMap& map, Order order) {
  CodingOrder result;
  result.surface = &surface;
  if (order == Order::kTraversal && map.isIdentity()) {
    result.corner_time = surface.corner_vertex;
    return result;
  }
  result.vertex_time = map.vertex_position;
  if (order == Order::kDegree) {
    std::vector<std::uint32_t> time(map.position_count, kNone);
    result.position.reserve(map.position_count);
    visitByDegree(surface, [&](std::uint32_t v) {
      const std::uint32_t position = map.positionOf(v);
      if (time[position] != kNone) return true;
      time[position] = static_cast<std::uint32_t>(result.position.size());
      result.position.push_back(position);
      return true;
    });
    result.vertex_storage.assign(surface.vertexCount(), kNone);
    for (std::uint32_t v = 0; v < surface.real_count; ++v) result.vertex_storage[v] = time[map.positionOf(v)];
    result.vertex_time = result.vertex_storage;
  }
  result.corner_storage.reserve(surface.corner_vertex.size());
  for (std::size_t c = 0; c < surface.corner_vertex.size(); c += 3) {
    std::array<std::uint32_t, 3> time;
    for (std::size_t k = 0; k < 3; ++k) time[k] = result.vertex_time[surface.corner_vertex[c + k]];
    std::rotate(time.begin(), std::max_element(time.begin(), time.end()), time.end());
    result.corner_storage.insert(result.corner_storage.end(), time.begin(), time.end());
  }
  result.corner_time = result.corner_storage;
  return result;
}

}  // namespace tsc
