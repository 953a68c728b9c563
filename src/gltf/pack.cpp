// Packing: surveys the meshes, codes each group as one stream, checks it, and patches the document.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#include "accessor_editor.h"
#include "buffer_editor.h"
#include "data_access.h"
#include "fault.h"
#include "json_document.h"
#include "mesh_groups.h"
#include "precision.h"
#include "references.h"
#include "stream_check.h"

namespace tsc {
namespace {

constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

std::string number(std::uint64_t value) { return std::to_string(value); }

ComponentType codecType(std::uint32_t gl_type) {
  switch (gl_type) {
    case kGlByte:
      return ComponentType::kInt8;
    case kGlUnsignedByte:
      return ComponentType::kUint8;
    case kGlShort:
      return ComponentType::kInt16;
    case kGlUnsignedShort:
      return ComponentType::kUint16;
    case kGlUnsignedInt:
      return ComponentType::kUint32;
    default:
      return ComponentType::kFloat32;
  }
}

/// Packed VEC3 elements of any type as floats, which hold all integers of up to 16 bits.
std::vector<float> toFloats(const std::vector<std::byte>& elements, std::uint32_t gl_type) {
  const ComponentType type = codecType(gl_type);
  const std::size_t size = componentSize(type);
  const std::size_t count = elements.size() / (3 * size);
  std::vector<std::byte> strided(count * positionStride(type));
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(strided.data() + i * positionStride(type), elements.data() + i * 3 * size, 3 * size);
  }
  return positionsAsFloats(strided, type);
}

/// A group coded: what the codec got, what it gave, what came back.
struct CodedGroup {
  const MeshGroup* group = nullptr;
  std::vector<std::vector<float>> positions;  ///< by table; the mesh borrows them
  Mesh mesh;
  EncodeResult result;
  std::vector<std::vector<std::byte>> decoded;
};

void setBounds(Json& accessor, const std::vector<float>& positions) {
  std::array<float, 3> low{}, high{};
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::size_t axis = i % 3;
    low[axis] = i < 3 ? positions[i] : std::min(low[axis], positions[i]);
    high[axis] = i < 3 ? positions[i] : std::max(high[axis], positions[i]);
  }
  // As doubles: a float has a short decimal of its own there, and every reader rounds it back to the same float.
  accessor["min"] = Json::array({double{low[0]}, double{low[1]}, double{low[2]}});
  accessor["max"] = Json::array({double{high[0]}, double{high[1]}, double{high[2]}});
}

class Packer {
 public:
  Packer(Asset& asset, const PackOptions& options)
      : asset_(asset), original_(asset), options_(options), data_(original_), buffers_(asset) {}

  PackReport run() {
    report_.input_bytes = sizeOf(original_);
    survey_ = surveyMeshes(original_, data_);
    report_.kept = survey_.kept;
    codeGroups();
    AccessorEditor accessors(asset_, original_, data_, buffers_, foreignAccessors());
    accessors_ = &accessors;
    for (CodedGroup& coded : coded_) patchGroup(coded);
    if (!coded_.empty()) finishDocument();
    report_.attribute_bytes = accessors.attributeBytes();
    report_.output_bytes = sizeOf(asset_);
    return std::move(report_);
  }

 private:
  static std::uint64_t triangleCount(const MeshGroup& group) {
    std::uint64_t count = 0;
    for (const CodedPrimitive& primitive : group.primitives) count += primitive.triangles.size() / 3;
    return count;
  }

  static std::uint64_t sizeOf(const Asset& asset) {
    std::uint64_t bytes = writeJson(asset.document).size();
    for (const Buffer& buffer : asset.buffers) {
      if (buffer.source != Buffer::Source::kDataUri || buffer.modified) bytes += buffer.bytes.size();
    }
    return bytes;
  }

  /// Accessors that must keep their data: of animations, skins, instances, unknown extensions, and of the primitives
  /// that are not packed.
  std::set<std::uint64_t> foreignAccessors() const {
    std::set<std::uint64_t> foreign = accessorsOutsideMeshes(original_.document);
    for (const std::uint64_t candidate : unknownNumbers(original_.document)) foreign.insert(candidate);
    std::set<std::size_t> packed_primitives;
    for (const CodedGroup& coded : coded_) {
      for (const GroupTable& table : coded.group->tables)
        packed_primitives.insert(table.users.begin(), table.users.end());
    }
    for (std::size_t i = 0; i < survey_.primitives.size(); ++i) {
      if (packed_primitives.count(i) > 0) continue;
      const PrimitiveInfo& info = survey_.primitives[i];
      if (info.position) foreign.insert(*info.position);
      if (info.indices) foreign.insert(*info.indices);
      for (const AttributeUse& use : info.attributes) foreign.insert(use.accessor);
    }
    return foreign;
  }

  /// Codes all groups before anything is patched, for a group that cannot be coded must find its data unchanged.
  void codeGroups() {
    std::uint64_t total = 0, done = 0;
    for (const MeshGroup& group : survey_.groups) total += triangleCount(group);
    for (const MeshGroup& group : survey_.groups) {
      if (options_.progress) options_.progress(done, total);
      done += triangleCount(group);
      try {
        coded_.push_back(codeGroup(group));
      } catch (const Fault& fault) {
        if (fault.failure().kind != FailureKind::kUnsupported) throw;
        for (const std::size_t mesh : group.meshes) {
          report_.kept.push_back({mesh, std::nullopt, meshLabel(original_.document, mesh), fault.failure().message});
        }
      }
    }
    if (options_.progress) options_.progress(done, total);
  }

  void patchGroup(CodedGroup& coded) {
    const MeshGroup& group = *coded.group;
    const std::uint64_t stream = buffers_.add(Json::object(), BufferEditor::Place::kLast);
    std::vector<std::uint64_t> outputs;
    for (std::size_t i = 0; i < coded.decoded.size(); ++i) outputs.push_back(addOutput(group, coded, stream, i));
    buffers_.bytes(stream) = std::move(coded.result.bytes);
    for (std::size_t t = 0; t < group.tables.size(); ++t) patchTable(group, coded, t, outputs);
    for (std::size_t p = 0; p < group.primitives.size(); ++p) patchIndices(group, coded, p, outputs);
  }

  CodedGroup readGroup(const MeshGroup& group) {
    CodedGroup coded;
    coded.group = &group;
    coded.mesh.position_type = codecType(group.component_type);
    for (const GroupTable& table : group.tables) {
      coded.positions.push_back(toFloats(data_.elements(data_.accessor(table.accessor)), group.component_type));
      for (std::size_t i = 0; i < coded.positions.back().size(); ++i) {
        if (!std::isfinite(coded.positions.back()[i])) {
          failInvalid("/accessors/" + number(table.accessor),
                      "vertex " + number(i / 3) + " has a coordinate that is not finite, expected a number");
        }
      }
    }
    for (const std::vector<float>& positions : coded.positions) coded.mesh.tables.push_back({positions});
    for (const CodedPrimitive& primitive : group.primitives) {
      coded.mesh.primitives.push_back(
          {static_cast<std::uint32_t>(primitive.table), primitive.triangles, codecType(primitive.component_type)});
    }
    return coded;
  }

  CodedGroup codeGroup(const MeshGroup& group) {
    CodedGroup coded = readGroup(group);
    const EncodeOptions encode_options = chooseEncodeOptions(coded.mesh, options_, group.label);
    Result<EncodeResult> result = encode(coded.mesh, encode_options);
    if (!result) failEncode(result.error(), group);
    coded.result = *std::move(result);
    const double bound = guaranteedError(coded.mesh, encode_options);
    coded.decoded = decodeAndCompare(coded.mesh, coded.result, bound, group.label);
    reportStream(group, coded, bound);
    coded.positions = {};
    coded.mesh.tables = {};
    coded.mesh.primitives = {};
    return coded;
  }

  [[noreturn]] static void failEncode(const Error& error, const MeshGroup& group) {
    switch (error.code) {
      case ErrorCode::kLatticeTooFine:
      case ErrorCode::kBoundNotMet:
        fail(FailureKind::kBound, group.label, describe(error));
      case ErrorCode::kInvalidArgument:
        fail(FailureKind::kUsage, group.label, describe(error));
      default:
        fail(FailureKind::kInvalidInput, group.label, describe(error));
    }
  }

  void reportStream(const MeshGroup& group, const CodedGroup& coded, double bound) {
    StreamReport stream;
    stream.meshes = group.meshes;
    stream.label = group.label;
    for (const std::vector<float>& positions : coded.positions) stream.vertices += positions.size() / 3;
    stream.unique_positions = coded.result.unique_positions;
    stream.triangles = triangleCount(group);
    stream.input_position_bytes = stream.vertices * 3 * componentSize(coded.mesh.position_type);
    for (const CodedPrimitive& primitive : group.primitives) {
      if (!primitive.indices) continue;
      const AccessorInfo info = data_.accessor(*primitive.indices);
      stream.input_index_bytes += info.count * info.component_bytes;
    }
    stream.stream_bytes = coded.result.bytes.size();
    stream.bits = coded.result.bits;
    stream.modes = coded.result.modes;
    stream.max_error = coded.result.max_error;
    stream.rms_error = coded.result.rms_error;
    stream.guaranteed_error = bound;
    stream.diagonal = diagonalOf(coded.mesh);
    report_.streams.push_back(std::move(stream));
  }

  /// The view of decoded array `output`.
  std::uint64_t addOutput(const MeshGroup& group, const CodedGroup& coded, std::uint64_t stream, std::size_t output) {
    Json properties = Json::object();
    const bool is_positions = output < group.tables.size();
    if (is_positions) properties["byteStride"] = positionStride(coded.mesh.position_type);
    properties["target"] = is_positions ? kArrayBuffer : kElementArrayBuffer;
    Json& extension = properties["extensions"][std::string(kExtensionName)];
    extension["bufferView"] = stream;
    extension["output"] = output;
    const std::uint64_t view = buffers_.add(std::move(properties));
    if (options_.fallback) {
      buffers_.bytes(view) = coded.decoded[output];
    } else {
      buffers_.makePlaceholder(view, coded.decoded[output].size());
    }
    return view;
  }

  /// Rewrites everything that lives in one table's index space, except the coded triangles.
  void patchTable(const MeshGroup& group, const CodedGroup& coded, std::size_t t,
                  const std::vector<std::uint64_t>& outputs) {
    const GroupTable& table = group.tables[t];
    const std::vector<std::uint32_t>& order = coded.result.vertex_order[t];
    const std::size_t position = accessors_->claim(table.accessor);
    accessors_->setView(position, outputs[t]);
    Json& position_json = accessors_->json(position);
    position_json["count"] = order.size();
    if (coded.mesh.position_type == ComponentType::kFloat32) {
      setBounds(position_json, positionsAsFloats(coded.decoded[t], ComponentType::kFloat32));
    }
    std::map<std::size_t, std::size_t> attributes;
    std::map<std::size_t, std::size_t> remapped;
    std::set<std::size_t> coded_users;
    for (const CodedPrimitive& primitive : group.primitives) {
      if (primitive.table == t) coded_users.insert(primitive.users.begin(), primitive.users.end());
    }
    for (const std::size_t user : table.users) {
      const PrimitiveInfo& info = survey_.primitives[user];
      Json& json = primitiveJson(info);
      json["attributes"]["POSITION"] = position;
      for (const AttributeUse& use : info.attributes) {
        const auto [entry, added] = attributes.emplace(use.accessor, 0);
        if (added) entry->second = accessors_->reorder(use.accessor, order);
        Json& holder = use.target ? json["targets"][*use.target] : json["attributes"];
        holder[use.name] = entry->second;
      }
      if (coded_users.count(user) == 0) remapIndices(info, order, remapped);
      if (info.outline) {
        Json& outline = json["extensions"]["CESIUM_primitive_outline"]["indices"];
        outline = remapAccessor(*info.outline, order, remapped);
      }
    }
  }

  Json& primitiveJson(const PrimitiveInfo& info) {
    return asset_.document["meshes"][info.mesh]["primitives"][info.primitive];
  }

  static std::vector<std::uint32_t> inverse(std::span<const std::uint32_t> order) {
    std::vector<std::uint32_t> inverted(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) inverted[order[i]] = static_cast<std::uint32_t>(i);
    return inverted;
  }

  /// Indices that are not coded (points, lines) follow the vertices to their new places.
  void remapIndices(const PrimitiveInfo& info, std::span<const std::uint32_t> order,
                    std::map<std::size_t, std::size_t>& remapped) {
    Json& json = primitiveJson(info);
    if (info.indices) {
      json["indices"] = remapAccessor(*info.indices, order, remapped);
    } else if (info.mode != kPoints) {
      const std::size_t accessor = accessors_->add(Json::object());
      const std::uint32_t type = order.size() > UINT16_MAX ? kGlUnsignedInt : kGlUnsignedShort;
      accessors_->setIndices(accessor, inverse(order), type);
      json["indices"] = accessor;
    }
  }

  std::size_t remapAccessor(std::size_t old, std::span<const std::uint32_t> order,
                            std::map<std::size_t, std::size_t>& remapped) {
    const auto [entry, added] = remapped.emplace(old, 0);
    if (!added) return entry->second;
    const AccessorInfo info = data_.accessor(old);
    std::vector<std::uint32_t> indices = data_.indices(info);
    const std::vector<std::uint32_t> new_index = inverse(order);
    for (std::uint32_t& index : indices) {
      if (index >= new_index.size()) {
        failInvalid("/accessors/" + number(old),
                    "found vertex index " + number(index) + ", expected one below " + number(new_index.size()));
      }
      index = new_index[index];
    }
    std::uint32_t type = info.component_type;
    if (type == kGlUnsignedByte && order.size() > UINT8_MAX) type = kGlUnsignedShort;
    if (type == kGlUnsignedShort && order.size() > UINT16_MAX) type = kGlUnsignedInt;
    const std::size_t accessor = accessors_->claim(old);
    accessors_->setIndices(accessor, indices, type);
    updateIndexBounds(accessor, indices);
    return entry->second = accessor;
  }

  /// An index accessor may state its bounds; they move with the vertices.
  void updateIndexBounds(std::size_t accessor, std::span<const std::uint32_t> indices) {
    Json& json = accessors_->json(accessor);
    if (indices.empty()) return;
    const auto [low, high] = std::minmax_element(indices.begin(), indices.end());
    if (json.contains("min")) json["min"] = Json::array({*low});
    if (json.contains("max")) json["max"] = Json::array({*high});
  }

  void patchIndices(const MeshGroup& group, const CodedGroup& coded, std::size_t p,
                    const std::vector<std::uint64_t>& outputs) {
    const CodedPrimitive& primitive = group.primitives[p];
    const std::size_t output = group.tables.size() + p;
    std::size_t accessor = 0;
    if (primitive.indices) {
      accessor = accessors_->claim(*primitive.indices);
    } else {
      accessor = accessors_->add(Json::object());
    }
    accessors_->setView(accessor, outputs[output]);
    Json& json = accessors_->json(accessor);
    json["componentType"] = primitive.component_type;
    json["count"] = primitive.triangles.size();
    json["type"] = "SCALAR";
    const std::size_t index_bytes = componentSize(codecType(primitive.component_type));
    updateIndexBounds(accessor, readUnsigned(coded.decoded[output], index_bytes));
    for (const std::size_t user : primitive.users) {
      Json& json_primitive = primitiveJson(survey_.primitives[user]);
      json_primitive["indices"] = accessor;
      if (json_primitive.contains("mode") && json_primitive["mode"] != kTriangles) json_primitive["mode"] = kTriangles;
      if (survey_.primitives[user].draco) eraseExtension(json_primitive, "KHR_draco_mesh_compression");
    }
  }

  void finishDocument() {
    buffers_.commit();
    declareExtension(asset_.document, kExtensionName, !options_.fallback);
    undeclareIfUnused("KHR_draco_mesh_compression");
    undeclareIfUnused("EXT_meshopt_compression");
    undeclareIfUnused("KHR_meshopt_compression");
  }

  /// Takes a compression that was decoded out of the lists, if nothing uses it any more.
  void undeclareIfUnused(std::string_view name) {
    const auto uses = [&](const char* key) {
      for (std::size_t i = 0; i < countOf(asset_.document, key); ++i) {
        if (findExtension(asset_.document[key][i], name) != nullptr) return true;
      }
      return false;
    };
    bool used = uses("buffers") || uses("bufferViews");
    for (std::size_t m = 0; m < countOf(asset_.document, "meshes"); ++m) {
      for (const Json& primitive : asset_.document["meshes"][m]["primitives"]) {
        used = used || findExtension(primitive, name) != nullptr;
      }
    }
    if (!used) undeclareExtension(asset_.document, name);
  }

  Asset& asset_;
  const Asset original_;  ///< read from, while `asset_` changes
  const PackOptions& options_;
  DataAccess data_;
  BufferEditor buffers_;
  AccessorEditor* accessors_ = nullptr;
  MeshSurvey survey_;
  std::vector<CodedGroup> coded_;
  PackReport report_;
};

}  // namespace

Expected<PackReport> packAsset(Asset& asset, const PackOptions& options) {
  return guarded(asset.name, [&] {
    checkPackOptions(options);
    if (isPacked(asset)) {
      if (!options.repack) {
        fail(FailureKind::kUsage, "", "the asset is packed already; ask for repacking, or unpack it first");
      }
      const std::string name = std::exchange(asset.name, {});
      Outcome unpacked = unpackAsset(asset);
      asset.name = name;
      raiseIfFailed(std::move(unpacked));
    }
    return Packer(asset, options).run();
  });
}

}  // namespace tsc
