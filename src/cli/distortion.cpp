#include "distortion.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

// Reading accessors, Draco and meshopt data is the glTF library's inner business; done twice it would drift apart.
#include "../gltf/data_access.h"
#include "../gltf/fault.h"
#include "../gltf/json_document.h"
#include "../gltf/mesh_groups.h"

namespace tsc::cli {
namespace {

using Matrix = std::array<double, 16>;  // column-major

constexpr Matrix kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix result{};
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      for (int k = 0; k < 4; ++k) result[4 * column + row] += a[4 * k + row] * b[4 * column + k];
    }
  }
  return result;
}

template <std::size_t kCount>
std::array<double, kCount> numbersOr(const Json& node, const char* key, std::array<double, kCount> values) {
  const auto found = node.find(key);
  if (found == node.end() || !found->is_array() || found->size() != kCount) return values;
  for (std::size_t i = 0; i < kCount; ++i) {
    if ((*found)[i].is_number()) values[i] = (*found)[i].template get<double>();
  }
  return values;
}

Matrix localMatrix(const Json& node) {
  if (node.contains("matrix")) return numbersOr<16>(node, "matrix", kIdentity);
  const auto t = numbersOr<3>(node, "translation", {0, 0, 0});
  const auto [x, y, z, w] = numbersOr<4>(node, "rotation", {0, 0, 0, 1});
  const auto s = numbersOr<3>(node, "scale", {1, 1, 1});
  // clang-format off
  return {s[0] * (1 - 2 * (y * y + z * z)), s[0] * 2 * (x * y + z * w), s[0] * 2 * (x * z - y * w), 0,
          s[1] * 2 * (x * y - z * w), s[1] * (1 - 2 * (x * x + z * z)), s[1] * 2 * (y * z + x * w), 0,
          s[2] * 2 * (x * z + y * w), s[2] * 2 * (y * z - x * w), s[2] * (1 - 2 * (x * x + y * y)), 0,
          t[0], t[1], t[2], 1};
  // clang-format on
}

/// Fills in where each mesh stands. Pictures alone depend on it, so what makes no sense is passed over.
void placeMeshes(const Json& document, std::vector<NamedSurface>& surfaces) {
  const std::size_t node_count = countOf(document, "nodes");
  std::vector<bool> seen(node_count, false);  // a node has one parent; hostile documents may have cycles
  std::vector<std::pair<std::size_t, Matrix>> open;
  const auto addNodes = [&](const Json& holder, const char* key, const Matrix& parent) {
    const auto found = holder.find(key);
    if (found == holder.end() || !found->is_array()) return;
    for (const Json& entry : *found) {
      if (!entry.is_number_unsigned() || entry.get<std::size_t>() >= node_count) continue;
      const auto index = entry.get<std::size_t>();
      if (seen[index]) continue;
      seen[index] = true;
      open.emplace_back(index, parent);
    }
  };
  const std::size_t scene_count = countOf(document, "scenes");
  const auto chosen = document.find("scene");
  const std::size_t scene = chosen != document.end() && chosen->is_number_unsigned() ? chosen->get<std::size_t>() : 0;
  if (scene >= scene_count || !document["scenes"][scene].is_object()) return;
  addNodes(document["scenes"][scene], "nodes", kIdentity);
  while (!open.empty()) {
    const auto [index, parent] = open.back();
    open.pop_back();
    const Json& node = document["nodes"][index];
    if (!node.is_object()) continue;
    const Matrix matrix = product(parent, localMatrix(node));
    const auto mesh = node.find("mesh");
    if (mesh != node.end() && mesh->is_number_unsigned() && mesh->get<std::size_t>() < surfaces.size()) {
      surfaces[mesh->get<std::size_t>()].placements.push_back(matrix);
    }
    addNodes(node, "children", matrix);
  }
}

template <class T>
void appendComponents(std::span<const std::byte> bytes, double scale, double lowest, std::vector<double>& values) {
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    values.push_back(std::max(static_cast<double>(value) * scale, lowest));
  }
}

/// Coordinates as glTF means them: integers as they are, or scaled to [-1, 1] if normalized. (glTF 2.0, 3.6.2.2)
void appendPositions(const Asset& asset, DataAccess& data, std::size_t accessor, std::vector<double>& values) {
  const AccessorInfo info = data.accessor(accessor);
  const JsonView view = elementOf(asset.document, "accessors", accessor);
  if (info.type != "VEC3") failInvalid(view.pointer(), "found type " + info.type + " for positions, expected VEC3");
  const auto flag = view.find("normalized");
  const bool normalized = flag && flag->asBool();
  const std::vector<std::byte> bytes = data.elements(info);
  constexpr double kNoLimit = -std::numeric_limits<double>::infinity();
  const double lowest = normalized ? -1 : kNoLimit;
  switch (info.component_type) {
    case kGlByte: return appendComponents<std::int8_t>(bytes, normalized ? 1 / 127.0 : 1, lowest, values);
    case kGlUnsignedByte: return appendComponents<std::uint8_t>(bytes, normalized ? 1 / 255.0 : 1, lowest, values);
    case kGlShort: return appendComponents<std::int16_t>(bytes, normalized ? 1 / 32767.0 : 1, lowest, values);
    case kGlUnsignedShort: return appendComponents<std::uint16_t>(bytes, normalized ? 1 / 65535.0 : 1, lowest, values);
    case kGlUnsignedInt: return appendComponents<std::uint32_t>(bytes, 1, kNoLimit, values);
    case kGlFloat: {
      // Without the comparison above, so that a NaN is seen as one.
      for (std::size_t at = 0; at + 4 <= bytes.size(); at += 4) {
        float value;
        std::memcpy(&value, bytes.data() + at, 4);
        values.push_back(value);
      }
    }
  }
}

/// Adds a primitive's triangles; `first_vertex` remembers where each position accessor begins in the surface.
void appendPrimitive(const Asset& asset, DataAccess& data, const PrimitiveInfo& primitive,
                     std::map<std::size_t, std::size_t>& first_vertex, NamedSurface& surface) {
  if (!primitive.isTriangles() || !primitive.position) return;
  const auto [entry, is_new] = first_vertex.try_emplace(*primitive.position, surface.positions.size() / 3);
  if (is_new) appendPositions(asset, data, *primitive.position, surface.positions);
  const std::size_t vertex_count = data.accessor(*primitive.position).count;
  std::vector<std::uint32_t> indices;
  if (primitive.indices) {
    indices = data.indices(data.accessor(*primitive.indices));
  } else {
    for (std::size_t v = 0; v < vertex_count; ++v) indices.push_back(static_cast<std::uint32_t>(v));
  }
  for (const std::uint32_t index : indices) {
    if (index < vertex_count) continue;
    failInvalid("/meshes/" + std::to_string(primitive.mesh) + "/primitives/" + std::to_string(primitive.primitive),
                "index " + std::to_string(index) + " of " + std::to_string(vertex_count) + " vertices");
  }
  for (const std::uint32_t index : toTriangles(primitive.mode, std::move(indices))) {
    surface.indices.push_back(static_cast<std::uint32_t>(entry->second + index));
  }
}

std::vector<NamedSurface> surfacesOfPlain(const Asset& asset) {
  DataAccess data(asset);
  const MeshSurvey survey = surveyMeshes(asset, data);  // decodes Draco primitives into `data`
  std::vector<NamedSurface> surfaces(countOf(asset.document, "meshes"));
  for (std::size_t i = 0; i < surfaces.size(); ++i) surfaces[i].name = meshLabel(asset.document, i);
  std::vector<std::map<std::size_t, std::size_t>> first_vertex(surfaces.size());
  for (const PrimitiveInfo& primitive : survey.primitives) {
    appendPrimitive(asset, data, primitive, first_vertex[primitive.mesh], surfaces[primitive.mesh]);
  }
  placeMeshes(asset.document, surfaces);
  return surfaces;
}

}  // namespace

Expected<std::vector<NamedSurface>> surfacesOf(const Asset& asset) {
  if (!isPacked(asset)) return guarded(asset.name, [&] { return surfacesOfPlain(asset); });
  Asset plain = asset;
  if (Outcome bad = unpackAsset(plain)) return *std::move(bad);
  return guarded(asset.name, [&] { return surfacesOfPlain(plain); });
}

void dropEmptyMeshes(std::vector<NamedSurface>& a, std::vector<NamedSurface>& b) {
  if (a.size() != b.size()) {
    for (auto* surfaces : {&a, &b}) std::erase_if(*surfaces, [](const auto& mesh) { return mesh.indices.empty(); });
    return;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].indices.empty() && b[i].indices.empty()) continue;
    if (kept != i) {
      a[kept] = std::move(a[i]);
      b[kept] = std::move(b[i]);
    }
    ++kept;
  }
  a.resize(kept);
  b.resize(kept);
}

Failure toFailure(const QualityError& error) {
  switch (error.code) {
    case QualityErrorCode::kUnreadableFile: return {FailureKind::kIo, error.message};
    case QualityErrorCode::kUnsupportedFile: return {FailureKind::kUnsupported, error.message};
    default: return {FailureKind::kInvalidInput, error.message};
  }
}

Expected<Json> packDistortion(const Asset& original, const Asset& packed, const MetroOptions& options) {
  auto before = surfacesOf(original);
  if (!before) return before.failure();
  auto after = surfacesOf(packed);
  if (!after) return after.failure();
  dropEmptyMeshes(*before, *after);
  if (before->empty()) return Json(nullptr);
  const auto comparison = compareScenes(*before, *after, options);
  if (!comparison) return toFailure(comparison.error());
  return Json::parse(comparisonJson(*comparison));
}

Json reportDistortion(const Asset& original, const Asset& packed, const std::string& input, bool quiet) {
  auto distortion = packDistortion(original, packed);
  if (distortion) return std::move(*distortion);
  if (!quiet) {
    fmt::print(stderr, "gltf-tsc: warning: {}: distortion was not measured: {}\n", input, distortion.failure().message);
  }
  return nullptr;
}

}  // namespace tsc::cli
