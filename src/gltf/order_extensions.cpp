// See order_extensions.h.
#include "order_extensions.h"

#include <algorithm>
#include <array>
#include <string>

#include "fault.h"

namespace tsc {
namespace {

std::string inQuotes(std::string_view name) { return '"' + std::string(name.substr(0, 40)) + '"'; }

[[noreturn]] void failRule(const std::string& place, const std::string& message) {
  fail(FailureKind::kUnsupported, place, message + ", so that it cannot follow another order");
}

/// The extension's object, if `holder` has it. Members beside `known`, `extensions` and `extras` may name anything.
std::optional<JsonView> findKnown(const JsonView& holder, std::string_view name,
                                  std::initializer_list<std::string_view> known) {
  const Json* extension = findExtension(holder.json(), name);
  if (extension == nullptr) return std::nullopt;
  const JsonView view(*extension, holder.pointer() + "/extensions/" + std::string(name));
  for (const auto& [key, member] : view.asObject().items()) {
    if (key == "extensions" || key == "extras") continue;
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    failRule(view.pointer(), "found the member " + inQuotes(key) + ", which this version does not know");
  }
  return view;
}

std::optional<std::size_t> optionalAccessor(const JsonView& holder, std::string_view key) {
  const auto member = holder.find(key);
  if (!member) return std::nullopt;
  return member->asUint();
}

std::string accessorPlace(std::size_t accessor) { return "/accessors/" + std::to_string(accessor); }

void expectCount(std::size_t accessor, std::uint64_t found, std::uint64_t expected, const std::string& what) {
  if (found == expected) return;
  failRule(accessorPlace(accessor) + "/count",
           "found " + std::to_string(found) + ", expected " + std::to_string(expected) + ", " + what);
}

/// Vertex numbers; `restart`: a value that is none, beside.
std::vector<std::uint32_t> readVertices(std::size_t accessor, std::uint64_t vertices, DataAccess& data,
                                        std::optional<std::uint32_t> restart = {}) {
  std::vector<std::uint32_t> indices = data.indices(data.accessor(accessor));
  for (const std::uint32_t index : indices) {
    if (index < vertices || index == restart) continue;
    failRule(accessorPlace(accessor),
             "found vertex index " + std::to_string(index) + ", expected one below " + std::to_string(vertices));
  }
  return indices;
}

std::uint32_t visibilityAt(std::span<const std::byte> visibility, std::size_t edge) {
  return std::to_integer<std::uint32_t>(visibility[edge / 4] >> (edge % 4 * 2)) & 3;
}

std::uint64_t countSilhouettes(std::span<const std::byte> visibility, std::uint64_t edges) {
  std::uint64_t count = 0;
  for (std::uint64_t edge = 0; edge < edges; ++edge) count += visibilityAt(visibility, edge) == 1 ? 1 : 0;
  return count;
}

void collectNumbers(const Json& value, std::set<std::uint64_t>& numbers) {
  if (const auto number = wholeNumber(value)) numbers.insert(*number);
  if (!value.is_structured()) return;
  for (const Json& member : value) collectNumbers(member, numbers);
}

}  // namespace

std::optional<std::size_t> readOutline(const JsonView& primitive, const PrimitiveSize& size, DataAccess& data) {
  const auto outline = findKnown(primitive, kOutline, {"indices"});
  const auto indices = outline ? optionalAccessor(*outline, "indices") : std::nullopt;
  if (indices) static_cast<void>(readVertices(*indices, size.vertices, data));
  return indices;
}

std::optional<EdgeVisibility> readEdgeVisibility(const JsonView& primitive, const PrimitiveSize& size,
                                                 DataAccess& data) {
  const auto extension = findKnown(primitive, kEdgeVisibility,
                                   {"visibility", "material", "lineStrings", "silhouetteMates", "silhouetteNormals"});
  if (!extension) return std::nullopt;
  EdgeVisibility edges;
  edges.visibility = optionalAccessor(*extension, "visibility");
  edges.mates = optionalAccessor(*extension, "silhouetteMates");
  edges.normals = optionalAccessor(*extension, "silhouetteNormals");
  std::uint64_t silhouettes = 0;
  if (edges.visibility) {
    const AccessorInfo info = data.accessor(*edges.visibility);
    if (info.type != "SCALAR" || info.component_type != kGlUnsignedByte) {
      failRule(accessorPlace(info.index),
               "found " + info.type + " of " + std::to_string(info.component_type) + ", expected SCALAR of 5121");
    }
    expectCount(info.index, info.count, (size.triangles * 6 + 7) / 8, "two bits for each edge");
    silhouettes = countSilhouettes(data.elements(info), size.triangles * 3);
  }
  if (edges.mates) {
    const std::size_t count = readVertices(*edges.mates, size.vertices, data).size();
    expectCount(*edges.mates, count, silhouettes, "the number of silhouette edges");
  }
  if (edges.normals) {
    const AccessorInfo info = data.accessor(*edges.normals);
    if (info.type != "SCALAR") failRule(accessorPlace(info.index), "found " + info.type + ", expected SCALAR");
    expectCount(info.index, info.count, 2 * silhouettes, "twice the number of silhouette edges");
  }
  const auto strings = extension->find("lineStrings");
  for (std::size_t i = 0; strings && i < strings->size(); ++i) {
    const JsonView string = strings->at(i);
    const std::size_t indices = string["indices"].asUint();
    const std::size_t component_bytes = data.accessor(indices).component_bytes;
    static_cast<void>(readVertices(indices, size.vertices, data, restartValue(component_bytes)));
    edges.line_strings.push_back(indices);
  }
  return edges;
}

std::optional<Manifold> readManifold(const JsonView& mesh, std::size_t index, DataAccess& data) {
  const auto extension = findKnown(mesh, kManifold, {"manifoldPrimitive", "mergeIndices", "mergeValues"});
  if (!extension) return std::nullopt;
  const JsonView primitive = (*extension)["manifoldPrimitive"];
  for (const auto& [key, member] : primitive.asObject().items()) {
    constexpr std::array kKnown = {"attributes", "indices", "mode", "extensions", "extras"};
    if (std::find(kKnown.begin(), kKnown.end(), key) == kKnown.end()) {
      failRule(primitive.pointer(), "found the member " + inQuotes(key) + ", expected attributes, indices and mode");
    }
  }
  const JsonView attributes = primitive["attributes"];
  if (attributes.asObject().size() != 1) failRule(attributes.pointer(), "found others, expected POSITION alone");
  Manifold manifold;
  manifold.mesh = index;
  manifold.position = attributes["POSITION"].asUint();
  manifold.indices = primitive["indices"].asUint();
  manifold.merge_indices = optionalAccessor(*extension, "mergeIndices");
  manifold.merge_values = optionalAccessor(*extension, "mergeValues");
  const std::uint64_t vertices = data.accessor(manifold.position).count;
  const AccessorInfo info = data.accessor(manifold.indices);
  static_cast<void>(readVertices(manifold.indices, vertices, data));
  for (const std::uint32_t vertex : readUnsigned(data.baseElements(info), info.component_bytes)) {
    if (vertex >= vertices) failRule(accessorPlace(info.index), "found vertex index " + std::to_string(vertex));
  }
  if (manifold.merge_values) static_cast<void>(readVertices(*manifold.merge_values, vertices, data));
  return manifold;
}

std::set<std::uint64_t> numbersOfOrderExtensions(const Json& holder) {
  std::set<std::uint64_t> numbers;
  for (const std::string_view name : {kOutline, kEdgeVisibility, kManifold}) {
    const Json* extension = findExtension(holder, name);
    if (extension != nullptr) collectNumbers(*extension, numbers);
  }
  return numbers;
}

std::vector<std::byte> reorderVisibility(std::span<const std::byte> visibility,
                                         std::span<const std::uint32_t> triangle_order,
                                         std::vector<std::uint32_t>& silhouettes) {
  const std::size_t edges = triangle_order.size() * 3;
  std::vector<std::uint32_t> rank(edges);  // of each silhouette among the old ones
  for (std::size_t edge = 0, count = 0; edge < edges; ++edge) {
    rank[edge] = static_cast<std::uint32_t>(count);
    count += visibilityAt(visibility, edge) == 1 ? 1 : 0;
  }
  std::vector<std::byte> reordered(visibility.size());
  for (std::size_t edge = 0; edge < edges; ++edge) {
    // Decoded corner c of a triangle with the value 3 t + k is corner (k + c) mod 3 of triangle t; so are the edges.
    const std::uint32_t from = triangle_order[edge / 3];
    const std::size_t old = from / 3 * 3 + (from % 3 + edge % 3) % 3;
    const std::uint32_t value = visibilityAt(visibility, old);
    reordered[edge / 4] |= static_cast<std::byte>(value << (edge % 4 * 2));
    if (value == 1) silhouettes.push_back(rank[old]);
  }
  return reordered;
}

std::vector<std::uint32_t> moveLineStrings(std::vector<std::uint32_t> indices, std::span<const std::uint32_t> new_index,
                                           std::uint32_t from_restart, std::uint32_t to_restart) {
  for (std::uint32_t& index : indices) index = index == from_restart ? to_restart : new_index[index];
  return indices;
}

std::uint32_t restartValue(std::size_t component_bytes) {
  return static_cast<std::uint32_t>((std::uint64_t{1} << (8 * component_bytes)) - 1);
}

}  // namespace tsc
