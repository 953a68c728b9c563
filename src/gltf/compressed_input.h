// Input that other extensions compressed: meshopt's buffer views (libmeshoptimizer) and Draco's primitives (libdraco).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "json_document.h"
#include "tsc/gltf.h"

namespace tsc {

class DataAccess;
struct AccessorInfo;

/// Where a view's compressed data lies, and how it was compressed.
struct MeshoptRange {
  std::string place;
  std::uint64_t buffer = 0;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::uint64_t stride = 0;
  std::uint64_t count = 0;
  std::string mode;
  std::string filter;
};

/// The meshopt extension of a buffer view, if it has one.
std::optional<MeshoptRange> findMeshoptRange(const JsonView& view);

/// Decodes a view of `length` bytes. Raises kInvalidInput on bad data, kUnsupported on what the library cannot decode.
std::vector<std::byte> decodeMeshopt(const Asset& asset, const MeshoptRange& range, std::uint64_t length);

/// One attribute or the indices of a Draco primitive, in the types that the accessors ask for.
struct DracoData {
  std::uint64_t vertex_count = 0;
  std::vector<std::uint32_t> indices;                        ///< 3 a triangle
  std::map<std::string, std::vector<std::byte>> attributes;  ///< packed elements
};

/// Decodes a Draco bitstream. `ids` gives the Draco id of each attribute, `infos` its accessor.
DracoData decodeDraco(std::span<const std::byte> bytes, const std::map<std::string, std::uint32_t>& ids,
                      const std::map<std::string, AccessorInfo>& infos, const std::string& place);

}  // namespace tsc
