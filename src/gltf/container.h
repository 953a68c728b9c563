// The containers of glTF: GLB files, data URIs, base64 and percent-encoding. Pure functions over bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tsc/gltf.h"

namespace tsc {

inline constexpr std::uint32_t kGlbMagic = 0x46546C67;      // "glTF"
inline constexpr std::uint32_t kGlbJsonChunk = 0x4E4F534A;  // "JSON"
inline constexpr std::uint32_t kGlbBinChunk = 0x004E4942;   // "BIN\0"

/// What a GLB file holds.
struct Glb {
  std::string_view json;                          ///< borrowed from the input
  std::optional<std::span<const std::byte>> bin;  ///< borrowed; the chunk with its padding
  std::vector<GlbChunk> extra_chunks;
};

/// Whether the bytes begin as a GLB file does.
bool isGlb(std::span<const std::byte> bytes);

/// Takes a GLB file apart. Raises kInvalidInput with the byte offset of the fault.
Glb parseGlb(std::span<const std::byte> bytes);

/// Puts a GLB file together. Raises kUnsupported if it would be larger than the 4 GiB its header can state.
std::vector<std::byte> buildGlb(std::string_view json, std::optional<std::span<const std::byte>> bin,
                                std::span<const GlbChunk> extra_chunks);

/// Whether a URI carries its data itself.
bool isDataUri(std::string_view uri);

/// The bytes of a data URI, base64 or percent-encoded. `place` goes into the failure raised on a bad one.
std::vector<std::byte> decodeDataUri(std::string_view uri, std::string_view place);

/// A data URI of type application/octet-stream.
std::string encodeDataUri(std::span<const std::byte> bytes);

/// "%20" and its like replaced by what they stand for; a stray "%" is kept as it is.
std::string percentDecode(std::string_view text);

/// A file name as a relative URI.
std::string percentEncode(std::string_view file_name);

}  // namespace tsc
