// See draco_reader.h.
#include "draco_reader.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "compressed_input.h"
#include "fault.h"

namespace tsc {

void DracoReader::read(const JsonView& primitive, PrimitiveInfo& info) {
  const Json* extension = findExtension(primitive.json(), "KHR_draco_mesh_compression");
  if (extension == nullptr) return;
  info.draco = true;
  // A decoder gives plain triangles, whatever the mode says.
  info.mode = kTriangles;
  if (hasPlainData(info)) return;
  const JsonView json(*extension, primitive.pointer() + "/extensions/KHR_draco_mesh_compression");
  const std::size_t view = json["bufferView"].asUint();
  std::map<std::string, std::uint32_t> ids;
  std::map<std::string, AccessorInfo> infos;
  const JsonView attributes = json["attributes"];
  for (const auto& [name, id] : attributes.asObject().items()) {
    ids[name] = static_cast<std::uint32_t>(attributes[name].asUint(UINT32_MAX));
    infos[name] = data_.accessor(primitive["attributes"][name].asUint());
  }
  DracoData decoded = decodeDraco(data_.viewBytes(view), ids, infos, json.pointer());
  for (auto& [name, bytes] : decoded.attributes) {
    claim(infos[name].index, view, json.pointer());
    data_.overlay(infos[name].index, std::move(bytes), decoded.vertex_count);
  }
  if (!info.indices) fail(FailureKind::kUnsupported, primitive.pointer(), "a Draco primitive without indices");
  const AccessorInfo indices = data_.accessor(*info.indices);
  const std::uint64_t largest = (std::uint64_t{1} << (8 * indices.component_bytes)) - 1;
  if (decoded.vertex_count > largest) {
    failInvalid(json.pointer(), "found " + number(decoded.vertex_count) + " vertices, too many for the index accessor");
  }
  claim(indices.index, view, json.pointer());
  data_.overlay(indices.index, writeUnsigned(decoded.indices, indices.component_bytes), decoded.indices.size());
}

/// Whether the accessors hold the same data without Draco: then it is exact, and nothing need be decoded.
bool DracoReader::hasPlainData(const PrimitiveInfo& info) const {
  const auto is_plain = [&](std::size_t index) {
    const AccessorInfo accessor = data_.accessor(index);
    return accessor.view.has_value() || accessor.sparse;
  };
  const bool attributes = std::all_of(info.attributes.begin(), info.attributes.end(),
                                      [&](const AttributeUse& use) { return is_plain(use.accessor); });
  return attributes && info.position && is_plain(*info.position) && info.indices && is_plain(*info.indices) &&
         !data_.hasOverlay(*info.position) && !data_.hasOverlay(*info.indices);
}

void DracoReader::claim(std::size_t accessor, std::size_t view, const std::string& place) {
  const auto [entry, added] = owners_.emplace(accessor, view);
  if (!added && entry->second != view) {
    fail(FailureKind::kUnsupported, place, "accessor " + number(accessor) + " belongs to two Draco streams");
  }
}

}  // namespace tsc
