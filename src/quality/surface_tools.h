// What all measures share: checking input, welding bit-equal positions, pairing triangles over edges.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "tsc/quality.h"

namespace tsc {

inline constexpr std::uint32_t kNone = 0xffffffff;

inline glm::dvec3 pointAt(const PositionView& positions, std::size_t vertex) {
  const auto [x, y, z] = positions[vertex];
  return {x, y, z};
}

/// Whether three indices name a triangle with three different vertices.
inline bool isProper(std::uint32_t a, std::uint32_t b, std::uint32_t c) { return a != b && b != c && c != a; }

/// The first of: indices not a multiple of three, an index out of range, a used vertex that is not finite, no triangle.
[[nodiscard]] std::optional<QualityError> checkSurface(const SurfaceView& surface);

/// Vertices of bit-equal position (-0 equal to +0) as one point, points numbered by first appearance.
struct Welding {
  std::vector<std::uint32_t> point_of_vertex;
  std::vector<std::uint32_t> vertex_of_point;  ///< the first vertex of each
};

[[nodiscard]] Welding weldPositions(const PositionView& positions);

/// For corner c (3 * triangle + 0..2) the corner across the edge opposite c, where exactly two triangles share that
/// edge; else `kNone`. Every triangle must be proper.
[[nodiscard]] std::vector<std::uint32_t> pairEdges(std::span<const std::uint32_t> indices, std::size_t vertex_count);

struct Box {
  glm::dvec3 low{0};
  glm::dvec3 high{0};
  bool empty = true;

  void add(const glm::dvec3& point);
  [[nodiscard]] double diagonal() const;
};

/// Around the vertices that triangles use.
[[nodiscard]] Box boxOf(const SurfaceView& surface);

}  // namespace tsc
