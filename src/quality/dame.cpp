// Dihedral angle mesh error.
// Source: L. Vasa, J. Rus, "Dihedral angle mesh error", Computer Graphics Forum 31(5), 2012. The visibility term, which
// depends on a set of views, is 1 for every edge.
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "surface_tools.h"

namespace tsc {
namespace {

/// Proper triangles of A after welding, as welded indices and as the vertices they came from.
struct Faces {
  std::vector<std::uint32_t> points;
  std::vector<std::uint32_t> vertices;
  std::size_t point_count = 0;
};

Faces weldedFaces(const SurfaceView& surface) {
  const Welding welding = weldPositions(surface.positions);
  Faces faces;
  faces.point_count = welding.vertex_of_point.size();
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    std::uint32_t p[3];
    for (int k = 0; k < 3; ++k) p[k] = welding.point_of_vertex[surface.indices[i + k]];
    if (!isProper(p[0], p[1], p[2])) continue;
    faces.points.insert(faces.points.end(), p, p + 3);
    for (int k = 0; k < 3; ++k) faces.vertices.push_back(surface.indices[i + k]);
  }
  return faces;
}

template <class Position>
std::vector<glm::dvec3> faceNormals(const std::vector<std::uint32_t>& vertices, Position position) {
  std::vector<glm::dvec3> normals(vertices.size() / 3);
  for (std::size_t t = 0; t < normals.size(); ++t) {
    const glm::dvec3 p = position(vertices[3 * t]);
    normals[t] = glm::cross(position(vertices[3 * t + 1]) - p, position(vertices[3 * t + 2]) - p);
  }
  return normals;
}

/// Also false for NaN, which stands for a vertex without a counterpart.
bool hasLength(const glm::dvec3& v) { return glm::dot(v, v) > 0; }

/// Angle from normal `n` to `m` about the edge, which runs along `edge` in the triangle of `n`.
double orientedAngle(const glm::dvec3& n, const glm::dvec3& m, const glm::dvec3& edge) {
  return std::atan2(glm::dot(glm::cross(n, m), edge) / glm::length(edge), glm::dot(n, m));
}

/// `moved(v)` is the new position of vertex v of A.
template <class Moved>
DameError measure(const SurfaceView& a, Moved moved) {
  const Faces faces = weldedFaces(a);
  const auto original = [&](std::uint32_t v) { return pointAt(a.positions, v); };
  const std::vector<std::uint32_t> twin = pairEdges(faces.points, faces.point_count);
  const std::vector<glm::dvec3> normals_a = faceNormals(faces.vertices, original);
  const std::vector<glm::dvec3> normals_b = faceNormals(faces.vertices, moved);

  DameError result;
  double sum = 0;
  for (std::size_t c = 0; c < twin.size(); ++c) {
    const std::size_t d = twin[c];
    if (d == kNone || d < c) continue;
    const std::size_t t = c / 3, u = d / 3;
    const std::size_t from = 3 * t + (c + 1 - 3 * t) % 3, to = 3 * t + (c + 2 - 3 * t) % 3;
    // Consistently oriented neighbours run along their edge in opposite directions.
    if (faces.points[3 * u + (d + 2 - 3 * u) % 3] != faces.points[from]) continue;
    const std::uint32_t tail = faces.vertices[from], head = faces.vertices[to];
    const glm::dvec3 edge_b = moved(head) - moved(tail);
    if (!hasLength(normals_a[t]) || !hasLength(normals_a[u]) || !hasLength(normals_b[t]) || !hasLength(normals_b[u]) ||
        !hasLength(edge_b)) {
      ++result.skipped_edges;
      continue;
    }
    const double before = orientedAngle(normals_a[t], normals_a[u], original(head) - original(tail));
    const double after = orientedAngle(normals_b[t], normals_b[u], edge_b);
    const double flatness = (std::numbers::pi - std::abs(before)) / std::numbers::pi;
    sum += std::abs(before - after) * std::exp(std::log(100.0) * flatness * flatness);
    ++result.edges;
  }
  if (result.edges > 0) result.value = sum / static_cast<double>(result.edges);
  return result;
}

std::optional<QualityError> checkMoved(const SurfaceView& a, const PositionView& b,
                                       std::span<const std::uint32_t> b_of_a) {
  for (const std::uint32_t v : a.indices) {
    const std::uint32_t w = b_of_a.empty() ? v : b_of_a[v];
    if (w == kUnmatchedVertex) continue;
    if (w >= b.size()) {
      return QualityError{QualityErrorCode::kInvalidIndex, "vertex " + std::to_string(v) + " is matched to vertex " +
                                                               std::to_string(w) + " of " + std::to_string(b.size())};
    }
    const auto [x, y, z] = b[w];
    if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z)) {
      return QualityError{QualityErrorCode::kNonFinitePosition,
                          "vertex " + std::to_string(w) + " has a coordinate that is not finite"};
    }
  }
  return std::nullopt;
}

}  // namespace

Measured<DameError> dame(const SurfaceView& a, PositionView b) {
  if (auto error = checkSurface(a)) return *std::move(error);
  if (a.positions.size() != b.size()) {
    return QualityError{QualityErrorCode::kCountMismatch, std::to_string(b.size()) + " vertices where " +
                                                              std::to_string(a.positions.size()) + " were expected"};
  }
  if (auto error = checkMoved(a, b, {})) return *std::move(error);
  return measure(a, [&](std::uint32_t v) { return pointAt(b, v); });
}

Measured<DameError> dame(const SurfaceView& a, PositionView b, std::span<const std::uint32_t> b_of_a) {
  if (auto error = checkSurface(a)) return *std::move(error);
  if (a.positions.size() != b_of_a.size()) {
    return QualityError{QualityErrorCode::kCountMismatch, std::to_string(b_of_a.size()) + " matches for " +
                                                              std::to_string(a.positions.size()) + " vertices"};
  }
  if (auto error = checkMoved(a, b, b_of_a)) return *std::move(error);
  return measure(a, [&](std::uint32_t v) {
    const std::uint32_t w = b_of_a[v];
    return w < b.size() ? pointAt(b, w) : glm::dvec3(std::numeric_limits<double>::quiet_NaN());
  });
}

}  // namespace tsc
