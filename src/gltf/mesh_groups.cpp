// See mesh_groups.h.
#include "mesh_groups.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <span>

#include "draco_reader.h"
#include "fault.h"
#include "references.h"

namespace tsc {
namespace {

std::optional<std::size_t> optionalIndex(const JsonView& holder, std::string_view key) {
  const auto member = holder.find(key);
  if (!member) return std::nullopt;
  return member->asUint();
}

/// Extensions that name vertices or triangles by their order without a number that would show it.
bool namesOrderSilently(std::string_view extension) { return extension == "FB_ngon_encoding"; }

enum class Holder { kMesh, kPrimitive };

/// Whether an extension that can be rewritten stands where it has no meaning that could be.
bool isMisplaced(std::string_view extension, Holder kind) {
  if (extension == kManifold) return kind != Holder::kMesh;
  return (extension == kOutline || extension == kEdgeVisibility) && kind != Holder::kPrimitive;
}

/// Why the order of a primitive's vertices or triangles must not change, as far as its extensions tell, those aside
/// that can be rewritten.
std::string orderReason(const Json& holder, Holder kind) {
  const auto extensions = holder.find("extensions");
  if (extensions == holder.end() || !extensions->is_object()) return {};
  for (const auto& [name, value] : extensions->items()) {
    Json alone = Json::object();
    alone["extensions"][name] = value;
    const bool numbers = !unknownNumbers(alone).empty();
    if (numbers || namesOrderSilently(name) || isMisplaced(name, kind)) {
      const bool nested = numbers && classify(name) != ExtensionClass::kUnknown;
      return (nested ? "an extension inside " : "the extension ") + name +
             " may name its vertices or triangles by index";
    }
    if (name != "EXT_mesh_features" || !value.is_object() || !value.contains("featureIds")) continue;
    for (const Json& ids : value["featureIds"]) {
      const bool implicit = ids.is_object() && !ids.contains("attribute") && !ids.contains("texture");
      if (implicit) return "EXT_mesh_features numbers its features by the order of vertices";
    }
  }
  return {};
}

void readAttributes(const JsonView& attributes, std::optional<std::size_t> target, PrimitiveInfo& info) {
  for (const auto& [name, value] : attributes.asObject().items()) {
    const std::size_t accessor = attributes[name].asUint();
    if (name == "POSITION" && !target) {
      info.position = accessor;
    } else {
      info.attributes.push_back({target, name, accessor});
    }
  }
}

PrimitiveInfo readPrimitive(const JsonView& json, std::size_t mesh, std::size_t index) {
  PrimitiveInfo info;
  info.mesh = mesh;
  info.primitive = index;
  info.mode = static_cast<std::uint32_t>(json.uintOr("mode", kTriangles, kTriangleFan));
  readAttributes(json["attributes"], std::nullopt, info);
  if (const auto targets = json.find("targets")) {
    for (std::size_t i = 0; i < targets->size(); ++i) readAttributes(targets->at(i), i, info);
  }
  info.indices = optionalIndex(json, "indices");
  info.keep_reason = orderReason(json.json(), Holder::kPrimitive);
  return info;
}

/// Disjoint sets of small integers.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::size_t a, std::size_t b) {
    a = find(a);
    b = find(b);
    // The smaller index leads, so that groups come in the order of the document.
    if (a < b) parent_[b] = a;
    if (b < a) parent_[a] = b;
  }

 private:
  std::vector<std::size_t> parent_;
};

struct TableDraft {
  std::size_t accessor;
  AccessorInfo info;
  std::vector<std::size_t> users;
  std::string reason;  ///< why it cannot be packed
};

class Surveyor {
 public:
  Surveyor(const Asset& asset, DataAccess& data, bool order_kept)
      : asset_(asset), data_(data), order_kept_(order_kept), draco_(data) {}

  MeshSurvey run() {
    readPrimitives();
    draftTables();
    buildGroups();
    return std::move(survey_);
  }

 private:
  void readPrimitives() {
    const std::size_t mesh_count = countOf(asset_.document, "meshes");
    for (std::size_t m = 0; m < mesh_count; ++m) {
      const JsonView mesh = elementOf(asset_.document, "meshes", m);
      const std::string mesh_reason = orderReason(mesh.json(), Holder::kMesh);
      const std::size_t first = survey_.primitives.size();
      const JsonView primitives = mesh["primitives"];
      for (std::size_t p = 0; p < primitives.size(); ++p) {
        const JsonView json = primitives.at(p);
        PrimitiveInfo info = readPrimitive(json, m, p);
        if (info.keep_reason.empty()) info.keep_reason = mesh_reason;
        if (order_kept_) info.keep_reason.clear();
        try {
          draco_.read(json, info);
        } catch (const Fault& fault) {
          if (fault.failure().kind != FailureKind::kUnsupported) throw;
          info.keep_reason = fault.failure().message;
        }
        readOrderExtensions(json, info);
        survey_.primitives.push_back(std::move(info));
      }
      readMeshManifold(mesh, m, std::span(survey_.primitives).subspan(first));
    }
  }

  /// An extension that cannot be rewritten is no reason to keep the mesh where the order is kept anyway.
  void keepFor(const Fault& fault, PrimitiveInfo& info) const {
    if (!order_kept_ && info.keep_reason.empty()) info.keep_reason = fault.failure().message;
  }

  void readOrderExtensions(const JsonView& json, PrimitiveInfo& info) {
    if (!info.position) return;
    try {
      const std::uint64_t vertices = data_.accessor(*info.position).count;
      const std::uint64_t corners = info.indices ? data_.accessor(*info.indices).count : vertices;
      const std::uint64_t triangles = info.mode == kTriangles ? corners / 3 : std::max<std::uint64_t>(corners, 2) - 2;
      const PrimitiveSize size = {vertices, info.isTriangles() ? triangles : 0};
      std::optional<std::size_t> outline = readOutline(json, size, data_);
      info.edges = readEdgeVisibility(json, size, data_);
      info.outline = outline;
    } catch (const Fault& fault) {
      keepFor(fault, info);
    }
  }

  void readMeshManifold(const JsonView& mesh, std::size_t index, std::span<PrimitiveInfo> primitives) {
    try {
      const std::optional<Manifold> manifold = readManifold(mesh, index, data_);
      if (!manifold) return;
      for (const PrimitiveInfo& info : primitives) {
        const bool fits = info.mode == kTriangles && info.indices && info.position && !info.draco &&
                          data_.canonical(*info.position) == data_.canonical(manifold->position);
        if (!fits) {
          fail(FailureKind::kUnsupported, mesh.pointer() + "/primitives/" + number(info.primitive),
               "found other than indexed triangles over the positions of " + std::string(kManifold) +
                   ", expected those alone");
        }
      }
      survey_.manifolds.push_back(*manifold);
      for (PrimitiveInfo& info : primitives) info.plain_indices = true;
    } catch (const Fault& fault) {
      for (PrimitiveInfo& info : primitives) keepFor(fault, info);
    }
  }

  void checkPosition(const PrimitiveInfo& info, TableDraft& table) const {
    const std::string place = "/accessors/" + number(table.accessor);
    const AccessorInfo& position = table.info;
    if (position.type != "VEC3" || position.component_type == kGlUnsignedInt) {
      failInvalid(place, "found " + position.type + " of " + number(position.component_type) +
                             ", expected positions: VEC3 of 5126 (or 5120 to 5123 with KHR_mesh_quantization)");
    }
    if (!position.view && !position.sparse && !data_.hasOverlay(table.accessor)) {
      table.reason = "its positions are not in the asset";
    }
    for (const AttributeUse& use : info.attributes) {
      const AccessorInfo other = data_.accessor(use.accessor);
      if (other.count != position.count) {
        failInvalid("/accessors/" + number(use.accessor) + "/count",
                    "found " + number(other.count) + ", expected " + number(position.count) + " as in POSITION");
      }
    }
  }

  void draftTables() {
    std::map<std::size_t, std::size_t> table_of_accessor;
    for (std::size_t i = 0; i < survey_.primitives.size(); ++i) {
      const PrimitiveInfo& info = survey_.primitives[i];
      table_of_primitive_.push_back(SIZE_MAX);
      if (!info.position) continue;
      const auto [entry, added] = table_of_accessor.emplace(data_.canonical(*info.position), tables_.size());
      if (added) tables_.push_back({entry->first, data_.accessor(entry->first), {}, {}});
      TableDraft& table = tables_[entry->second];
      table_of_primitive_[i] = entry->second;
      table.users.push_back(i);
      checkPosition(info, table);
      if (!info.keep_reason.empty()) table.reason = info.keep_reason;
      if (info.isTriangles() && info.mode == kTriangles && info.indices &&
          data_.accessor(*info.indices).count % 3 != 0) {
        table.reason = "the number of its indices is not a multiple of three";
      }
    }
  }

  /// Tables that must stay together: those of the triangles of one mesh.
  DisjointSets uniteTables() const {
    DisjointSets sets(tables_.size());
    std::map<std::size_t, std::size_t> first_table;  // by mesh
    for (std::size_t i = 0; i < survey_.primitives.size(); ++i) {
      const PrimitiveInfo& info = survey_.primitives[i];
      if (table_of_primitive_[i] == SIZE_MAX || !info.isTriangles()) continue;
      const auto [entry, added] = first_table.emplace(info.mesh, table_of_primitive_[i]);
      if (!added) sets.unite(entry->second, table_of_primitive_[i]);
    }
    return sets;
  }

  void buildGroups() {
    DisjointSets sets = uniteTables();
    std::map<std::size_t, std::vector<std::size_t>> members;
    for (std::size_t t = 0; t < tables_.size(); ++t) members[sets.find(t)].push_back(t);
    for (const auto& [root, tables] : members) {
      std::string reason;
      for (const std::size_t t : tables) {
        if (!tables_[t].reason.empty() && reason.empty()) reason = tables_[t].reason;
      }
      if (!reason.empty()) {
        keep(tables, reason);
        continue;
      }
      std::map<std::uint32_t, std::vector<std::size_t>> by_type;
      for (const std::size_t t : tables) by_type[tables_[t].info.component_type].push_back(t);
      for (const auto& [type, same_type] : by_type) addGroup(same_type, type);
    }
  }

  void keep(const std::vector<std::size_t>& tables, const std::string& reason) {
    std::set<std::size_t> meshes;
    for (const std::size_t t : tables) {
      for (const std::size_t user : tables_[t].users) {
        if (survey_.primitives[user].isTriangles()) meshes.insert(survey_.primitives[user].mesh);
      }
    }
    for (const std::size_t mesh : meshes) {
      survey_.kept.push_back({mesh, std::nullopt, meshLabel(asset_.document, mesh), reason});
    }
  }

  std::vector<std::uint32_t> vertexSequence(const PrimitiveInfo& info, std::uint64_t vertex_count) {
    if (!info.indices) {
      std::vector<std::uint32_t> sequence(vertex_count);
      std::iota(sequence.begin(), sequence.end(), 0U);
      return sequence;
    }
    std::vector<std::uint32_t> sequence = data_.indices(data_.accessor(*info.indices));
    for (const std::uint32_t index : sequence) {
      if (index >= vertex_count) {
        failInvalid("/accessors/" + number(*info.indices),
                    "found vertex index " + number(index) + ", expected one below " + number(vertex_count));
      }
    }
    return sequence;
  }

  /// Indices keep their type; where the type's largest value would be needed, which glTF forbids, it grows.
  std::uint32_t indexType(const PrimitiveInfo& info, std::uint64_t vertex_count) const {
    return indexTypeFor(info.indices ? data_.accessor(*info.indices).component_type : std::uint32_t{kGlUnsignedShort},
                        vertex_count);
  }

  void addGroup(const std::vector<std::size_t>& tables, std::uint32_t component_type) {
    MeshGroup group;
    group.component_type = component_type;
    std::set<std::size_t> meshes;
    try {
      for (const std::size_t t : tables) addTable(tables_[t], group, meshes);
    } catch (const Fault& fault) {
      if (fault.failure().kind != FailureKind::kUnsupported) throw;
      keep(tables, fault.failure().message);
      return;
    }
    if (group.primitives.empty()) return;
    group.meshes.assign(meshes.begin(), meshes.end());
    for (const std::size_t mesh : meshes) {
      group.label += (group.label.empty() ? "" : ", ") + meshLabel(asset_.document, mesh);
    }
    survey_.groups.push_back(std::move(group));
  }

  void addTable(const TableDraft& draft, MeshGroup& group, std::set<std::size_t>& meshes) {
    const std::size_t table = group.tables.size();
    std::map<std::pair<std::size_t, std::uint32_t>, std::size_t> known;  // (indices, mode)
    bool used = false;
    for (const std::size_t user : draft.users) {
      const PrimitiveInfo& info = survey_.primitives[user];
      if (!info.isTriangles()) continue;
      std::optional<std::size_t> indices;
      if (info.indices) indices = data_.canonical(*info.indices);
      const auto [entry, added] =
          known.emplace(std::pair(indices.value_or(SIZE_MAX), info.mode), group.primitives.size());
      if (added) {
        std::vector<std::uint32_t> triangles = toTriangles(info.mode, vertexSequence(info, draft.info.count));
        if (triangles.empty()) {
          known.erase(entry);
          continue;
        }
        group.primitives.push_back(
            {table, indices, info.mode, std::move(triangles), indexType(info, draft.info.count), {}});
      }
      group.primitives[entry->second].users.push_back(user);
      meshes.insert(info.mesh);
      used = true;
    }
    if (used) group.tables.push_back({draft.accessor, draft.users});
  }

  const Asset& asset_;
  DataAccess& data_;
  const bool order_kept_;
  DracoReader draco_;
  MeshSurvey survey_;
  std::vector<TableDraft> tables_;
  std::vector<std::size_t> table_of_primitive_;
};

}  // namespace

std::vector<std::uint32_t> toTriangles(std::uint32_t mode, std::vector<std::uint32_t> indices) {
  if (mode == kTriangles) {
    indices.resize(indices.size() / 3 * 3);
    return indices;
  }
  std::vector<std::uint32_t> triangles;
  if (indices.size() < 3) return triangles;
  triangles.reserve((indices.size() - 2) * 3);
  for (std::size_t i = 0; i + 2 < indices.size(); ++i) {
    if (mode == kTriangleStrip) {
      const std::size_t odd = i % 2;
      triangles.insert(triangles.end(), {indices[i], indices[i + 1 + odd], indices[i + 2 - odd]});
    } else {
      triangles.insert(triangles.end(), {indices[i + 1], indices[i + 2], indices[0]});
    }
  }
  return triangles;
}

std::string meshLabel(const Json& document, std::size_t mesh) {
  const JsonView json = elementOf(document, "meshes", mesh);
  const auto name = json.find("name");
  if (name && name->json().is_string() && !name->asString().empty()) return name->asString();
  return "meshes/" + number(mesh);
}

MeshSurvey surveyMeshes(const Asset& asset, DataAccess& data, bool order_kept) {
  return Surveyor(asset, data, order_kept).run();
}

}  // namespace tsc
