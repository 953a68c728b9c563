// Reading accessors and buffer views: all component types, strides, sparse data with and without a base view, and views
// compressed with EXT_meshopt_compression or KHR_meshopt_compression. Every range is checked against what holds it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "json_document.h"
#include "tsc/gltf.h"

namespace tsc {

/// Component types of accessors, by their glTF (GL) number.
enum GlType : std::uint32_t {
  kGlByte = 5120,
  kGlUnsignedByte = 5121,
  kGlShort = 5122,
  kGlUnsignedShort = 5123,
  kGlUnsignedInt = 5125,
  kGlFloat = 5126,
};

/// Targets of buffer views, by their glTF (GL) number.
inline constexpr std::uint32_t kArrayBuffer = 34962;
inline constexpr std::uint32_t kElementArrayBuffer = 34963;

/// What an accessor says of itself, checked.
struct AccessorInfo {
  std::size_t index = 0;
  std::uint32_t component_type = 0;
  std::string type;  ///< "SCALAR", "VEC3", ...
  std::size_t component_bytes = 0;
  std::size_t element_bytes = 0;  ///< with the padding of matrix columns
  std::uint64_t count = 0;
  std::optional<std::size_t> view;
  std::uint64_t offset = 0;
  bool sparse = false;
};

/// The sparse part of an accessor.
struct SparseInfo {
  std::uint32_t index_type = 0;
  std::vector<std::uint32_t> indices;  ///< each below the accessor's count
  std::vector<std::byte> values;       ///< packed elements
};

/// Reads an asset that does not change meanwhile. Raises kInvalidInput on whatever contradicts itself.
class DataAccess {
 public:
  explicit DataAccess(const Asset& asset) : asset_(asset) {}

  AccessorInfo accessor(std::size_t index) const;

  /// The bytes of a view, decompressed if need be. Valid as long as this object.
  std::span<const std::byte> viewBytes(std::size_t view);

  /// `element_bytes` * `count` bytes without gaps, sparse values applied.
  std::vector<std::byte> elements(const AccessorInfo& info);

  /// The same without the sparse values; zeros if there is no view.
  std::vector<std::byte> baseElements(const AccessorInfo& info);

  SparseInfo sparse(const AccessorInfo& info);

  /// A SCALAR accessor of unsigned integers.
  std::vector<std::uint32_t> indices(const AccessorInfo& info);

  /// Puts decoded elements in the place of an accessor's own data (Draco).
  void overlay(std::size_t accessor, std::vector<std::byte> bytes, std::uint64_t count);
  bool hasOverlay(std::size_t accessor) const { return overlays_.count(accessor) > 0; }

  /// Whether an accessor's data is Draco's or lies in a view that meshopt compressed.
  bool isCompressed(std::size_t accessor) const;

  /// The accessor that stands for all those over the same bytes, read in the same way: the first one asked about.
  std::size_t canonical(std::size_t accessor);

 private:
  struct Overlay {
    std::vector<std::byte> bytes;
    std::uint64_t count = 0;
  };

  std::vector<std::byte> gather(std::size_t view, std::uint64_t offset, std::uint64_t count, std::size_t element_bytes,
                                bool strided, const std::string& place);

  const Asset& asset_;
  std::map<std::size_t, std::vector<std::byte>> decoded_views_;
  std::map<std::size_t, Overlay> overlays_;
  /// By view, offset, component type, type and count.
  std::map<std::tuple<std::size_t, std::uint64_t, std::uint32_t, std::string, std::uint64_t>, std::size_t> canonical_;
};

/// Bytes `offset`, `length` of buffer `buffer`, checked. `place` goes into the failure.
std::span<const std::byte> bufferRange(const Asset& asset, std::uint64_t buffer, std::uint64_t offset,
                                       std::uint64_t length, const std::string& place);

/// Bytes of one component; raises kInvalidInput for an unknown type.
std::size_t glTypeBytes(std::uint32_t component_type, const std::string& place);

/// Packed unsigned integers of 1, 2 or 4 bytes.
std::vector<std::uint32_t> readUnsigned(std::span<const std::byte> bytes, std::size_t component_bytes);

/// The opposite; each value must fit.
std::vector<std::byte> writeUnsigned(std::span<const std::uint32_t> values, std::size_t component_bytes);

/// The smallest type that holds indices of so many vertices, from `type` on; the largest value of each is forbidden.
std::uint32_t indexTypeFor(std::uint32_t type, std::uint64_t vertex_count);

}  // namespace tsc
