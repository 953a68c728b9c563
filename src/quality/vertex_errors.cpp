// Distances between corresponding vertices.
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "surface_tools.h"

namespace tsc {
namespace {

QualityError countMismatch(std::size_t found, std::size_t expected) {
  return {QualityErrorCode::kCountMismatch,
          std::to_string(found) + " vertices where " + std::to_string(expected) + " were expected"};
}

/// `counterpart(i)` is the vertex of `b`, or `kUnmatchedVertex`.
template <class Counterpart>
Measured<VertexErrors> measure(const PositionView& a, const PositionView& b, Counterpart counterpart) {
  VertexErrors errors;
  double largest = -1;
  for (std::size_t v = 0; v < a.size(); ++v) {
    const std::uint32_t w = counterpart(v);
    if (w == kUnmatchedVertex) continue;
    if (w >= b.size()) {
      return QualityError{QualityErrorCode::kInvalidIndex, "vertex " + std::to_string(v) + " is matched to vertex " +
                                                               std::to_string(w) + " in a mesh of " +
                                                               std::to_string(b.size())};
    }
    const glm::dvec3 offset = pointAt(b, w) - pointAt(a, v);
    const double squared = glm::dot(offset, offset);
    if (!std::isfinite(squared)) {
      return QualityError{QualityErrorCode::kNonFinitePosition,
                          "vertex " + std::to_string(v) + " has a coordinate that is not finite"};
    }
    errors.mse += squared;
    ++errors.count;
    if (squared > largest) {
      largest = squared;
      errors.worst_vertex = static_cast<std::uint32_t>(v);
    }
  }
  if (errors.count == 0) return QualityError{QualityErrorCode::kNoFaces, "there are no vertices to compare"};
  errors.mse /= static_cast<double>(errors.count);
  errors.rms = std::sqrt(errors.mse);
  errors.max = std::sqrt(largest);
  return errors;
}

}  // namespace

Measured<VertexErrors> vertexErrors(PositionView a, PositionView b) {
  if (a.size() != b.size()) return countMismatch(b.size(), a.size());
  return measure(a, b, [](std::size_t v) { return static_cast<std::uint32_t>(v); });
}

Measured<VertexErrors> vertexErrors(PositionView a, PositionView b, std::span<const std::uint32_t> b_of_a) {
  if (a.size() != b_of_a.size()) return countMismatch(b_of_a.size(), a.size());
  return measure(a, b, [&](std::size_t v) { return b_of_a[v]; });
}

}  // namespace tsc
