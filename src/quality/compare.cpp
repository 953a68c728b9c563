// All measures over lists of meshes, and their totals.
#include <algorithm>
#include <cmath>

#include "surface_tools.h"

namespace tsc {
namespace {

QualityError inMesh(const NamedSurface& mesh, const QualityError& error) {
  return {error.code, (mesh.name.empty() ? "" : "mesh \"" + mesh.name + "\": ") + error.message};
}

/// Vertex errors and DAME where the meshes correspond; without them if connectivity differs.
std::optional<QualityError> measureMatched(const SurfaceView& a, const SurfaceView& b, MeshComparison& result) {
  Measured<Correspondence> match = matchVertices(a, b);
  if (!match) {
    if (match.error().code == QualityErrorCode::kConnectivityDiffers) return std::nullopt;
    return match.error();
  }
  std::vector<std::uint32_t> once(match->b_of_a.size(), kUnmatchedVertex);
  for (const std::uint32_t v : match->representatives) once[v] = match->b_of_a[v];
  auto vertices = vertexErrors(a.positions, b.positions, once);
  if (!vertices) return vertices.error();
  auto angles = dame(a, b.positions, match->b_of_a);
  if (!angles) return angles.error();
  result.correspondence = *std::move(match);
  result.vertices = *vertices;
  result.dame = *angles;
  return std::nullopt;
}

Measured<MeshComparison> compareMesh(const NamedSurface& a, const NamedSurface& b, const MetroOptions& options) {
  for (const NamedSurface* mesh : {&a, &b}) {
    if (auto error = checkSurface(mesh->view())) {
      return QualityError{error->code, std::string(mesh == &a ? "first" : "second") + " file: " + error->message};
    }
  }
  MeshComparison result;
  result.name = a.name;
  result.vertices_a = a.positions.size() / 3;
  result.vertices_b = b.positions.size() / 3;
  result.triangles_a = a.indices.size() / 3;
  result.triangles_b = b.indices.size() / 3;
  result.diagonal = boundingBoxDiagonal(a.view());
  if (auto error = measureMatched(a.view(), b.view(), result)) return *std::move(error);
  auto distances = metro(a.view(), b.view(), options);
  if (!distances) return distances.error();
  result.metro = *distances;
  return result;
}

VertexErrors totalVertexErrors(std::span<const MeshComparison> meshes) {
  VertexErrors total;
  for (const MeshComparison& mesh : meshes) {
    total.count += mesh.vertices->count;
    total.mse += mesh.vertices->mse * static_cast<double>(mesh.vertices->count);
    total.max = std::max(total.max, mesh.vertices->max);
  }
  total.mse /= static_cast<double>(total.count);
  total.rms = std::sqrt(total.mse);
  return total;
}

DameError totalDame(std::span<const MeshComparison> meshes) {
  DameError total;
  for (const MeshComparison& mesh : meshes) {
    total.edges += mesh.dame->edges;
    total.skipped_edges += mesh.dame->skipped_edges;
    total.value += mesh.dame->value * static_cast<double>(mesh.dame->edges);
  }
  if (total.edges > 0) total.value /= static_cast<double>(total.edges);
  return total;
}

MetroErrors totalMetro(std::span<const MeshComparison> meshes) {
  MetroErrors total;
  for (const MeshComparison& mesh : meshes) {
    const MetroErrors& part = mesh.metro;
    total.rms_a_to_b += part.rms_a_to_b * part.rms_a_to_b * part.area_a;
    total.rms_b_to_a += part.rms_b_to_a * part.rms_b_to_a * part.area_b;
    total.max_a_to_b = std::max(total.max_a_to_b, part.max_a_to_b);
    total.max_b_to_a = std::max(total.max_b_to_a, part.max_b_to_a);
    total.area_a += part.area_a;
    total.area_b += part.area_b;
    total.samples += part.samples;
  }
  total.rms_a_to_b = std::sqrt(total.rms_a_to_b / total.area_a);
  total.rms_b_to_a = std::sqrt(total.rms_b_to_a / total.area_b);
  return total;
}

MeshComparison totalOf(std::span<const MeshComparison> meshes, std::span<const NamedSurface> a) {
  MeshComparison total;
  total.name = "total";
  Box box;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    total.vertices_a += meshes[i].vertices_a;
    total.vertices_b += meshes[i].vertices_b;
    total.triangles_a += meshes[i].triangles_a;
    total.triangles_b += meshes[i].triangles_b;
    const Box mesh_box = boxOf(a[i].view());
    box.add(mesh_box.low);
    box.add(mesh_box.high);
  }
  total.diagonal = box.diagonal();
  total.metro = totalMetro(meshes);
  if (std::all_of(meshes.begin(), meshes.end(), [](const auto& mesh) { return mesh.vertices.has_value(); })) {
    total.vertices = totalVertexErrors(meshes);
    total.dame = totalDame(meshes);
  }
  return total;
}

}  // namespace

Measured<Comparison> compareScenes(std::span<const NamedSurface> a, std::span<const NamedSurface> b,
                                   const MetroOptions& options) {
  if (a.size() != b.size()) {
    return QualityError{QualityErrorCode::kCountMismatch, "the first file has " + std::to_string(a.size()) +
                                                              " meshes, the second " + std::to_string(b.size())};
  }
  if (a.empty()) return QualityError{QualityErrorCode::kNoFaces, "there are no meshes with faces"};
  Comparison comparison;
  for (std::size_t i = 0; i < a.size(); ++i) {
    auto mesh = compareMesh(a[i], b[i], options);
    if (!mesh) return inMesh(a[i], mesh.error());
    comparison.meshes.push_back(*std::move(mesh));
  }
  comparison.total = totalOf(comparison.meshes, a);
  return comparison;
}

Measured<std::vector<double>> vertexErrorField(const NamedSurface& a, const NamedSurface& b,
                                               const MeshComparison& result) {
  if (!result.correspondence) return distancesToSurface(b.positions, a.view());
  std::vector<double> field(b.positions.size() / 3, 0);
  const PositionView positions_a(a.positions), positions_b(b.positions);
  const auto& b_of_a = result.correspondence->b_of_a;
  if (b_of_a.size() != positions_a.size()) {
    return QualityError{QualityErrorCode::kCountMismatch, "the comparison is not of these meshes"};
  }
  // At point level copies of a point in B may have no counterpart of their own: they share their point's error.
  const Welding welding = weldPositions(positions_b);
  std::vector<double> of_point(welding.vertex_of_point.size(), 0);
  for (std::size_t v = 0; v < b_of_a.size(); ++v) {
    if (b_of_a[v] >= field.size()) continue;
    const glm::dvec3 offset = pointAt(positions_b, b_of_a[v]) - pointAt(positions_a, v);
    double& error = of_point[welding.point_of_vertex[b_of_a[v]]];
    error = std::max(error, std::sqrt(offset.x * offset.x + offset.y * offset.y + offset.z * offset.z));
  }
  for (std::size_t w = 0; w < field.size(); ++w) field[w] = of_point[welding.point_of_vertex[w]];
  return field;
}

}  // namespace tsc
