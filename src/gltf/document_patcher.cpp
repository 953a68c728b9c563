// See document_patcher.h.
#include "document_patcher.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "fault.h"
#include "json_document.h"
#include "references.h"
#include "stream_check.h"

namespace tsc {
namespace {

constexpr std::uint64_t kNoOrder = UINT64_MAX;
constexpr std::uint64_t kNoView = UINT64_MAX;

std::vector<std::uint32_t> inverse(std::span<const std::uint32_t> order) {
  std::vector<std::uint32_t> inverted(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) inverted[order[i]] = static_cast<std::uint32_t>(i);
  return inverted;
}

void setBounds(Json& accessor, const std::vector<float>& positions, ComponentType type) {
  std::array<float, 3> low{}, high{};
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::size_t axis = i % 3;
    low[axis] = i < 3 ? positions[i] : std::min(low[axis], positions[i]);
    high[axis] = i < 3 ? positions[i] : std::max(high[axis], positions[i]);
  }
  // Floats as doubles: they have a short decimal of their own there, and every reader rounds it back to the same float.
  const auto json = [&](float value) {
    return type == ComponentType::kFloat32 ? Json(double{value}) : Json(static_cast<std::int64_t>(value));
  };
  accessor["min"] = Json::array({json(low[0]), json(low[1]), json(low[2])});
  accessor["max"] = Json::array({json(high[0]), json(high[1]), json(high[2])});
}

}  // namespace

DocumentPatcher::DocumentPatcher(Asset& asset, const Asset& original, DataAccess& data, BufferEditor& buffers,
                                 const MeshSurvey& survey, const std::vector<CodedGroup>& coded,
                                 const PackOptions& options)
    : asset_(asset),
      original_(original),
      data_(data),
      buffers_(buffers),
      survey_(survey),
      options_(options),
      accessors_(asset, original, data, buffers, foreignAccessors(coded)),
      order_patcher_(asset, data, accessors_) {}

/// With the order kept, data that is plain in the asset need not move at all.
bool DocumentPatcher::staysAsItIs(std::size_t accessor) const {
  return options_.keep_order && !data_.isCompressed(accessor);
}

/// The same of indices that are not coded. Those of EXT_mesh_manifold are parts of one array, and stay together.
bool DocumentPatcher::keepsIndices(const PrimitiveInfo& info) const {
  return staysAsItIs(*info.indices) || (options_.keep_order && info.plain_indices);
}

/// Accessors that must keep their data: of animations, skins, instances, unknown extensions, of the primitives that are
/// not packed, and where the order is kept also the attributes of those that are.
std::set<std::uint64_t> DocumentPatcher::foreignAccessors(const std::vector<CodedGroup>& coded) const {
  std::set<std::uint64_t> foreign = accessorsOutsideMeshes(original_.document);
  for (const std::uint64_t candidate : unknownNumbers(original_.document)) foreign.insert(candidate);
  std::set<std::size_t> moving, coded_triangles;
  for (const CodedGroup& group : coded) {
    for (const GroupTable& table : group.group->tables) moving.insert(table.users.begin(), table.users.end());
    for (const CodedPrimitive& primitive : group.group->primitives) {
      coded_triangles.insert(primitive.users.begin(), primitive.users.end());
    }
  }
  for (std::size_t i = 0; i < survey_.primitives.size(); ++i) {
    const PrimitiveInfo& info = survey_.primitives[i];
    const bool moves = moving.count(i) > 0;
    if (info.position && !moves) foreign.insert(*info.position);
    const bool plain = coded_triangles.count(i) == 0 || info.plain_indices;
    if (info.indices && (!moves || (plain && keepsIndices(info)))) foreign.insert(*info.indices);
    for (const AttributeUse& use : info.attributes) {
      if (!moves || staysAsItIs(use.accessor)) foreign.insert(use.accessor);
    }
  }
  insertOrderAccessors(moving, foreign);
  return foreign;
}

/// Accessors that extensions of meshes and primitives name, where they are not rewritten. `moving`: the primitives
/// whose vertices are packed.
void DocumentPatcher::insertOrderAccessors(const std::set<std::size_t>& moving,
                                           std::set<std::uint64_t>& foreign) const {
  std::set<std::size_t> manifold_meshes;
  const auto insert = [&](const std::optional<std::size_t>& accessor) {
    if (accessor) foreign.insert(*accessor);
  };
  for (std::size_t i = 0; i < survey_.primitives.size(); ++i) {
    const PrimitiveInfo& info = survey_.primitives[i];
    const bool moves = moving.count(i) > 0;
    if (moves && info.plain_indices) manifold_meshes.insert(info.mesh);
    const Json& json = original_.document["meshes"][info.mesh]["primitives"][info.primitive];
    if (!moves || (!info.outline && !info.edges)) {
      foreign.merge(numbersOfOrderExtensions(json));
      continue;
    }
    if (info.edges && (options_.keep_order || info.plain_indices)) {  // what goes by the order of triangles
      insert(info.edges->visibility);
      insert(info.edges->normals);
    }
    if (!options_.keep_order) continue;
    insert(info.outline);
    if (!info.edges) continue;
    insert(info.edges->mates);
    foreign.insert(info.edges->line_strings.begin(), info.edges->line_strings.end());
  }
  for (std::size_t m = 0; m < countOf(original_.document, "meshes"); ++m) {
    if (manifold_meshes.count(m) == 0) foreign.merge(numbersOfOrderExtensions(original_.document["meshes"][m]));
  }
  for (const Manifold& manifold : survey_.manifolds) {
    insert(manifold.merge_indices);
    if (!options_.keep_order) continue;
    foreign.insert(manifold.indices);
    insert(manifold.merge_values);
  }
}

void DocumentPatcher::patch(CodedGroup& coded) {
  const MeshGroup& group = *coded.group;
  const std::uint64_t stream = buffers_.add(Json::object(), BufferEditor::Place::kLast);
  buffers_.bytes(stream) = std::move(coded.result.bytes);
  std::uint64_t order = kNoOrder;
  if (options_.keep_order) {
    order = buffers_.add(Json::object(), BufferEditor::Place::kLast);
    buffers_.bytes(order) = std::move(coded.order);
  }
  std::vector<std::uint64_t> views;
  for (std::size_t i = 0; i < coded.decoded.size(); ++i) {
    const bool needed = i < group.tables.size() || isNeeded(group.primitives[i - group.tables.size()]);
    views.push_back(needed ? addOutput(coded, i, stream, order) : kNoView);
  }
  for (std::size_t t = 0; t < group.tables.size(); ++t) patchTable(coded, t, views[t]);
  for (std::size_t p = 0; p < group.primitives.size(); ++p) patchIndices(coded, p, views[group.tables.size() + p]);
}

/// Whether some primitive takes its indices from the stream.
bool DocumentPatcher::isNeeded(const CodedPrimitive& primitive) const {
  return std::any_of(primitive.users.begin(), primitive.users.end(),
                     [&](std::size_t user) { return !survey_.primitives[user].plain_indices; });
}

/// The view of decoded array `output`.
std::uint64_t DocumentPatcher::addOutput(const CodedGroup& coded, std::size_t output, std::uint64_t stream,
                                         std::uint64_t order) {
  Json properties = Json::object();
  const bool is_positions = output < coded.group->tables.size();
  if (is_positions) properties["byteStride"] = positionStride(coded.position_type);
  properties["target"] = is_positions ? kArrayBuffer : kElementArrayBuffer;
  Json& extension = properties["extensions"][std::string(kExtensionName)];
  extension["bufferView"] = stream;
  extension["output"] = output;
  if (order != kNoOrder) extension["order"]["bufferView"] = order;
  const std::uint64_t view = buffers_.add(std::move(properties));
  if (options_.fallback) {
    buffers_.bytes(view) = coded.decoded[output];
  } else {
    buffers_.makePlaceholder(view, coded.decoded[output].size());
  }
  return view;
}

/// Rewrites everything that lives in one table's index space, except the coded triangles.
void DocumentPatcher::patchTable(const CodedGroup& coded, std::size_t t, std::uint64_t view) {
  const GroupTable& table = coded.group->tables[t];
  IndexSpace space;
  space.order = coded.result.vertex_order[t];
  if (options_.keep_order) std::iota(space.order.begin(), space.order.end(), 0U);
  space.new_index = inverse(space.order);
  std::set<std::size_t> coded_users;
  for (const CodedPrimitive& primitive : coded.group->primitives) {
    if (primitive.table == t) coded_users.insert(primitive.users.begin(), primitive.users.end());
  }
  AccessorMap positions;
  for (const std::size_t user : table.users) {
    const PrimitiveInfo& info = survey_.primitives[user];
    const auto [entry, added] = positions.emplace(*info.position, 0);
    if (added) entry->second = patchPosition(*info.position, coded, t, view);
    primitiveJson(info)["attributes"]["POSITION"] = entry->second;
  }
  for (const Manifold& manifold : survey_.manifolds) patchManifold(manifold, coded, t, view, positions, space);
  for (const std::size_t user : table.users) {
    const PrimitiveInfo& info = survey_.primitives[user];
    for (const AttributeUse& use : info.attributes) {
      const std::size_t accessor = moveAttribute(use.accessor, space);
      Json& json = primitiveJson(info);
      (use.target ? json["targets"][*use.target] : json["attributes"])[use.name] = accessor;
    }
    const bool plain = coded_users.count(user) == 0 || info.plain_indices;
    if (plain) moveIndices(info, space);
    if (!options_.keep_order) order_patcher_.patchVertices(info, space, plain);
  }
}

void DocumentPatcher::patchManifold(const Manifold& manifold, const CodedGroup& coded, std::size_t t,
                                    std::uint64_t view, AccessorMap& positions, IndexSpace& space) {
  std::vector<const PrimitiveInfo*> users;
  for (const std::size_t user : coded.group->tables[t].users) {
    const PrimitiveInfo& info = survey_.primitives[user];
    if (info.mesh == manifold.mesh) users.push_back(&info);
  }
  if (users.empty()) return;
  const auto [entry, added] = positions.emplace(manifold.position, 0);
  if (added) entry->second = patchPosition(manifold.position, coded, t, view);
  Json& extension = asset_.document["meshes"][manifold.mesh]["extensions"][std::string(kManifold)];
  extension["manifoldPrimitive"]["attributes"]["POSITION"] = entry->second;
  warnings_.push_back(meshLabel(original_.document, manifold.mesh) + ": the indices stay uncompressed, for " +
                      std::string(kManifold) + " needs those of all primitives in one plain array");
  if (!options_.keep_order) order_patcher_.patchManifold(manifold, users, space);
}

std::size_t DocumentPatcher::patchPosition(std::size_t old, const CodedGroup& coded, std::size_t t,
                                           std::uint64_t view) {
  const std::size_t position = accessors_.claim(old);
  if (position != old && !data_.isCompressed(old)) {
    warnings_.push_back(coded.group->label + ": the positions of accessor " + number(old) +
                        " stay in the asset uncompressed as well, for something else may use them");
  }
  accessors_.setView(position, view);
  Json& json = accessors_.json(position);
  json["count"] = coded.result.vertex_order[t].size();
  setBounds(json, positionsAsFloats(coded.decoded[t], coded.position_type), coded.position_type);
  return position;
}

std::size_t DocumentPatcher::moveAttribute(std::size_t old, IndexSpace& space) {
  if (staysAsItIs(old)) return old;
  const auto [entry, added] = space.attributes.emplace(old, 0);
  if (!added) return entry->second;
  // Accessors over the same bytes share the moved ones too.
  const auto [stored, first] = space.stored.emplace(data_.canonical(old), 0);
  if (first) stored->second = accessors_.reorder(old, space.order);
  entry->second = first ? stored->second : accessors_.follow(old, stored->second);
  return entry->second;
}

Json& DocumentPatcher::primitiveJson(const PrimitiveInfo& info) {
  return asset_.document["meshes"][info.mesh]["primitives"][info.primitive];
}

/// Indices that are not coded (points, lines) follow the vertices to their new places.
void DocumentPatcher::moveIndices(const PrimitiveInfo& info, IndexSpace& space) {
  if (info.indices) {
    if (keepsIndices(info)) return;
    const std::size_t accessor = accessors_.renumber(*info.indices, space);
    primitiveJson(info)["indices"] = accessor;
  } else if (info.mode != kPoints && !options_.keep_order) {
    const std::size_t accessor = accessors_.add(Json::object());
    accessors_.setIndices(accessor, space.new_index, indexTypeFor(kGlUnsignedShort, space.order.size()));
    primitiveJson(info)["indices"] = accessor;
  }
}

void DocumentPatcher::patchIndices(const CodedGroup& coded, std::size_t p, std::uint64_t view) {
  const CodedPrimitive& primitive = coded.group->primitives[p];
  const std::size_t output = coded.group->tables.size() + p;
  const std::vector<std::uint32_t> indices =
      readUnsigned(coded.decoded[output], componentSize(codecType(primitive.component_type)));
  AccessorMap patched;  // by the old accessor; all users without indices share one
  std::vector<const PrimitiveInfo*> users;
  for (const std::size_t user : primitive.users) {
    const PrimitiveInfo& info = survey_.primitives[user];
    if (info.plain_indices) continue;
    users.push_back(&info);
    const auto [entry, added] = patched.emplace(info.indices.value_or(SIZE_MAX), 0);
    if (added) {
      entry->second = info.indices ? accessors_.claim(*info.indices) : accessors_.add(Json::object());
      accessors_.setView(entry->second, view);
      Json& accessor = accessors_.json(entry->second);
      accessor["componentType"] = primitive.component_type;
      accessor["count"] = primitive.triangles.size();
      accessor["type"] = "SCALAR";
      accessors_.updateIndexBounds(entry->second, indices);
    }
    Json& json = primitiveJson(info);
    json["indices"] = entry->second;
    if (json.contains("mode") && json["mode"] != kTriangles) json["mode"] = kTriangles;
    if (info.draco) eraseExtension(json, "KHR_draco_mesh_compression");
  }
  if (options_.keep_order) return;
  order_patcher_.patchTriangles(users, coded.result.triangle_order[p],
                                inverse(coded.result.vertex_order[primitive.table]));
}

/// What is left of each old view: which accessors still use it, and which of its bytes.
std::map<std::uint64_t, DocumentPatcher::ViewUse> DocumentPatcher::remainingUses() {
  constexpr std::uint64_t kGranule = 8;
  const Json& before = original_.document;
  std::map<std::uint64_t, ViewUse> uses;
  for (std::size_t i = 0; i < countOf(before, "accessors"); ++i) {
    try {
      const AccessorInfo info = data_.accessor(i);
      if (!info.view) continue;
      ViewUse& use = uses[*info.view];
      if (accessors_.json(i).value("bufferView", UINT64_MAX) != *info.view) {
        use.lost_some = true;
        continue;
      }
      const std::uint64_t stride =
          elementOf(before, "bufferViews", *info.view).uintOr("byteStride", info.element_bytes, 65535);
      use.accessors.push_back(i);
      use.begin = std::min(use.begin, info.offset / kGranule * kGranule);
      if (info.count > 0) use.end = std::max(use.end, info.offset + stride * (info.count - 1) + info.element_bytes);
    } catch (const Fault&) {
      // Broken, but nothing that is packed needs it; its view counts as used by something unknown.
    }
  }
  return uses;
}

void DocumentPatcher::trimViews() {
  std::map<std::uint64_t, std::size_t> references;
  visitBufferViewReferences(asset_.document, [&](Json& index) { ++references[*wholeNumber(index)]; });
  for (const auto& [index, use] : remainingUses()) {
    if (!use.lost_some || use.accessors.empty() || buffers_.maybeNamed(index)) continue;
    const JsonView view = elementOf(original_.document, "bufferViews", index);
    const std::uint64_t length = view["byteLength"].asUint();
    // Pictures, sparse data and the like have no ranges of their own, and compressed views cannot be cut.
    if (references[index] != use.accessors.size() || view.find("extensions")) continue;
    if (use.begin >= use.end || use.end > length || use.end - use.begin == length) continue;
    buffers_.trim(index, use.begin, use.end);
    if (use.begin == 0) continue;
    for (const std::size_t accessor : use.accessors) {
      Json& json = accessors_.json(accessor);
      json["byteOffset"] = json["byteOffset"].get<std::uint64_t>() - use.begin;
    }
  }
}

}  // namespace tsc
