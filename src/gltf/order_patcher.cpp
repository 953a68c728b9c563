// See order_patcher.h.
#include "order_patcher.h"

#include <cstring>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace tsc {
namespace {

std::vector<std::uint32_t> renumbered(std::vector<std::uint32_t> vertices, std::span<const std::uint32_t> new_index) {
  for (std::uint32_t& vertex : vertices) vertex = new_index[vertex];
  return vertices;
}

}  // namespace

Json& OrderPatcher::edgesJson(const PrimitiveInfo& info) {
  Json& primitive = asset_.document["meshes"][info.mesh]["primitives"][info.primitive];
  return primitive["extensions"][std::string(kEdgeVisibility)];
}

void OrderPatcher::patchVertices(const PrimitiveInfo& info, IndexSpace& space, bool same_triangles) {
  if (info.outline) {
    const std::size_t accessor = accessors_.renumber(*info.outline, space);
    Json& primitive = asset_.document["meshes"][info.mesh]["primitives"][info.primitive];
    primitive["extensions"][std::string(kOutline)]["indices"] = accessor;
  }
  if (!info.edges) return;
  for (std::size_t i = 0; i < info.edges->line_strings.size(); ++i) {
    const std::size_t accessor = moveLineStrings(info.edges->line_strings[i], space);
    edgesJson(info)["lineStrings"][i]["indices"] = accessor;
  }
  if (info.edges->mates && same_triangles) {
    const std::size_t accessor = accessors_.renumber(*info.edges->mates, space);
    edgesJson(info)["silhouetteMates"] = accessor;
  }
}

std::size_t OrderPatcher::moveLineStrings(std::size_t old, IndexSpace& space) {
  const auto [entry, added] = space.line_strings.emplace(old, 0);
  if (!added) return entry->second;
  const AccessorInfo info = data_.accessor(old);
  const std::uint32_t type = indexTypeFor(info.component_type, space.order.size());
  const std::uint32_t restart = restartValue(glTypeBytes(type, ""));
  entry->second = accessors_.claim(old);
  accessors_.setIndices(
      entry->second,
      tsc::moveLineStrings(data_.indices(info), space.new_index, restartValue(info.component_bytes), restart), type);
  return entry->second;
}

void OrderPatcher::patchTriangles(std::span<const PrimitiveInfo* const> users,
                                  std::span<const std::uint32_t> triangle_order,
                                  std::span<const std::uint32_t> new_index) {
  // Silhouettes are numbered by the visibility beside them, so only what is shared as a whole stays shared.
  std::map<std::tuple<std::size_t, std::optional<std::size_t>, std::optional<std::size_t>>, Json> patched;
  for (const PrimitiveInfo* user : users) {
    if (!user->edges || !user->edges->visibility) continue;
    const EdgeVisibility& old = *user->edges;
    const auto [entry, added] = patched.emplace(std::tuple(*old.visibility, old.mates, old.normals), Json::object());
    Json& edges = entry->second;
    if (added) {
      std::vector<std::uint32_t> silhouettes;
      const std::vector<std::byte> bits =
          reorderVisibility(data_.elements(data_.accessor(*old.visibility)), triangle_order, silhouettes);
      const std::size_t accessor = accessors_.claim(*old.visibility);
      accessors_.storeBytes(accessor, bits);
      edges["visibility"] = accessor;
      if (old.mates) patchMates(edges, *old.mates, silhouettes, new_index);
      if (old.normals) patchNormals(edges, *old.normals, silhouettes);
    }
    for (const auto& [key, value] : edges.items()) edgesJson(*user)[key] = value;
  }
}

void OrderPatcher::patchMates(Json& edges, std::size_t old, std::span<const std::uint32_t> silhouettes,
                              std::span<const std::uint32_t> new_index) {
  const AccessorInfo info = data_.accessor(old);
  const std::vector<std::uint32_t> mates = data_.indices(info);
  std::vector<std::uint32_t> moved;
  for (const std::uint32_t silhouette : silhouettes) moved.push_back(new_index[mates[silhouette]]);
  const std::size_t accessor = accessors_.claim(old);
  accessors_.setIndices(accessor, moved, indexTypeFor(info.component_type, new_index.size()));
  edges["silhouetteMates"] = accessor;
}

void OrderPatcher::patchNormals(Json& edges, std::size_t old, std::span<const std::uint32_t> silhouettes) {
  const AccessorInfo info = data_.accessor(old);
  const std::vector<std::byte> normals = data_.elements(info);
  const std::size_t pair_bytes = 2 * info.element_bytes;
  std::vector<std::byte> moved(normals.size());
  for (std::size_t i = 0; i < silhouettes.size(); ++i) {
    std::memcpy(moved.data() + i * pair_bytes, normals.data() + silhouettes[i] * pair_bytes, pair_bytes);
  }
  const std::size_t accessor = accessors_.claim(old);
  accessors_.storeBytes(accessor, moved);
  edges["silhouetteNormals"] = accessor;
}

void OrderPatcher::patchManifold(const Manifold& manifold, std::span<const PrimitiveInfo* const> users,
                                 IndexSpace& space) {
  const AccessorInfo info = data_.accessor(manifold.indices);
  const std::vector<std::uint32_t> base =
      renumbered(readUnsigned(data_.baseElements(info), info.component_bytes), space.new_index);
  const std::uint32_t type = indexTypeFor(info.component_type, space.order.size());
  const std::size_t accessor = accessors_.claim(manifold.indices);
  Json& json = accessors_.json(accessor);
  const std::optional<Json> sparse = info.sparse ? std::optional(json["sparse"]) : std::nullopt;
  accessors_.setIndices(accessor, base, type);
  if (sparse) accessors_.json(accessor)["sparse"] = *sparse;
  if (!info.sparse) space.indices.emplace(manifold.indices, accessor);
  patchMerges(manifold, info, accessor, type, space.new_index);
  Json& extension = asset_.document["meshes"][manifold.mesh]["extensions"][std::string(kManifold)];
  extension["manifoldPrimitive"]["indices"] = accessor;

  // The primitives' indices are parts of the same bytes, before and after.
  const std::uint64_t view = accessors_.json(accessor)["bufferView"];
  const std::uint64_t begin = accessors_.json(accessor).value("byteOffset", std::uint64_t{0});
  for (const PrimitiveInfo* user : users) {
    const AccessorInfo part = data_.accessor(*user->indices);
    const bool is_part = !part.sparse && part.view == info.view && part.component_type == info.component_type &&
                         part.offset >= info.offset && (part.offset - info.offset) % info.component_bytes == 0 &&
                         (part.offset - info.offset) / info.component_bytes + part.count <= info.count;
    if (!is_part || space.indices.count(part.index) > 0) continue;
    const std::uint64_t first = (part.offset - info.offset) / info.component_bytes;
    const std::size_t moved = accessors_.claim(part.index);
    accessors_.setView(moved, view, begin + first * glTypeBytes(type, ""));
    accessors_.json(moved)["componentType"] = type;
    accessors_.updateIndexBounds(moved, std::span(base).subspan(first, part.count));
    space.indices.emplace(part.index, moved);
  }
}

/// Which vertices are merged into which: in the sparse values of the indices, and once more in `merge_values`. Where in
/// the array they are merged stays as it was. Both had the same bytes, and have them again.
void OrderPatcher::patchMerges(const Manifold& manifold, const AccessorInfo& indices, std::size_t accessor,
                               std::uint32_t type, std::span<const std::uint32_t> new_index) {
  const std::size_t bytes = glTypeBytes(type, "");
  std::optional<std::vector<std::uint32_t>> values;
  if (indices.sparse) {
    values = renumbered(readUnsigned(data_.sparse(indices).values, indices.component_bytes), new_index);
    accessors_.storeSparse(accessor, "values", writeUnsigned(*values, bytes));
  }
  if (!manifold.merge_values) return;
  const std::vector<std::uint32_t> merged =
      renumbered(data_.indices(data_.accessor(*manifold.merge_values)), new_index);
  const std::size_t merge_values = accessors_.claim(*manifold.merge_values);
  Json& extension = asset_.document["meshes"][manifold.mesh]["extensions"][std::string(kManifold)];
  extension["mergeValues"] = merge_values;
  if (values == merged) {
    const Json& stored = accessors_.json(accessor)["sparse"]["values"];
    accessors_.setView(merge_values, stored["bufferView"], stored.value("byteOffset", std::uint64_t{0}));
  } else {
    accessors_.storeBytes(merge_values, writeUnsigned(merged, bytes));
  }
  accessors_.json(merge_values)["componentType"] = type;
  accessors_.updateIndexBounds(merge_values, merged);
}

}  // namespace tsc
