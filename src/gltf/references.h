// Who names what in a document: buffer views, accessors and buffers, by index. Extensions that this library does not
// know may name any of them under any key, so every whole number inside one counts as a possible reference.
#pragma once

#include <cstddef>
#include <functional>
#include <set>
#include <string_view>
#include <vector>

#include "tsc/gltf.h"

namespace tsc {

/// What an extension's numbers can mean for us.
enum class ExtensionClass {
  kIndependent,  ///< names no vertex, triangle, accessor or buffer view, or only in ways handled here
  kUnknown,
};

/// Classifies an extension by name, wherever it stands.
ExtensionClass classify(std::string_view extension);

/// Calls `visit` for every whole number that is known to name a buffer view: under the key "bufferView" anywhere
/// outside `extras`, and in EXT_structural_metadata's property tables.
void visitBufferViewReferences(Json& document, const std::function<void(Json& index)>& visit);

/// Every whole number inside extensions of class kUnknown, anywhere in `value` (not inside `extras`, and not those
/// under the key "bufferView").
std::set<std::uint64_t> unknownNumbers(const Json& value);

/// Accessors named by animations, skins and EXT_mesh_gpu_instancing.
std::set<std::uint64_t> accessorsOutsideMeshes(const Json& document);

/// Where a buffer's bytes went.
struct BufferMove {
  std::size_t buffer = 0;
  std::uint64_t offset = 0;  ///< added to each offset into it
};

/// Renumbers the buffers that buffer views name, moves[old] giving the new place.
void moveBuffers(Json& document, const std::vector<BufferMove>& moves);

/// Calls `visit` for every object that is a range of a buffer (members buffer, byteOffset, byteLength): buffer views
/// and meshopt's compressed ranges.
void visitBufferRanges(Json& document, const std::function<void(Json& range, std::size_t view)>& visit);

}  // namespace tsc
