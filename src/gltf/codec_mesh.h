// One group of meshes through the codec: accessors in; a checked stream, and what it decodes to, out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "data_access.h"
#include "mesh_groups.h"
#include "tsc/gltf.h"

namespace tsc {

/// The codec's name for a component type of glTF.
ComponentType codecType(std::uint32_t gl_type);

/// A group coded.
struct CodedGroup {
  const MeshGroup* group = nullptr;
  ComponentType position_type = ComponentType::kFloat32;
  EncodeResult result;
  std::vector<std::byte> order;                 ///< the original order; empty unless it is kept
  std::vector<std::vector<std::byte>> decoded;  ///< what readers will see: in the original order if that is kept
  StreamReport report;
};

std::uint64_t triangleCount(const MeshGroup& group);

/// Codes a group, decodes the stream again and compares. Raises what `chooseEncodeOptions`, the codec and the
/// comparison find.
CodedGroup codeGroup(const MeshGroup& group, DataAccess& data, const PackOptions& options);

}  // namespace tsc
