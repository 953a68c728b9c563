// Two triangulations of the plane: ear clipping of a polygon with holes (long slivers, as CAD kernels write them) and
// Delaunay of scattered points (well shaped, irregular).
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace tsc::samples {

/// Indices into the loops' points, one loop after the other. The outline runs counter-clockwise, holes clockwise, each
/// inside the outline and apart from the others.
std::vector<std::uint32_t> clipEars(const std::vector<std::vector<glm::dvec2>>& loops);

/// Triangles, counter-clockwise, of the convex hull of `points`. Quadratic in time.
std::vector<std::uint32_t> delaunay(std::span<const glm::dvec2> points);

}  // namespace tsc::samples
