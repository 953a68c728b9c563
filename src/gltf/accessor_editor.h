// Rewriting the accessors of packed meshes in the document: which may be edited in place, which must be cloned because
// somebody else still needs the old data, and where reordered data goes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <vector>

#include "buffer_editor.h"
#include "data_access.h"
#include "tsc/gltf.h"

namespace tsc {

using AccessorMap = std::map<std::size_t, std::size_t>;  ///< old accessor -> new

/// One vertex table while its accessors are rewritten.
struct IndexSpace {
  std::vector<std::uint32_t> order;      ///< old vertex of each new one
  std::vector<std::uint32_t> new_index;  ///< the inverse
  AccessorMap attributes;
  AccessorMap stored;  ///< by `DataAccess::canonical`
  AccessorMap indices;
  AccessorMap line_strings;  ///< indices too, with values between them that mean no vertex
};

class AccessorEditor {
 public:
  /// `foreign`: accessors whose present data somebody outside the packed meshes needs. `data` reads `original`, an
  /// unchanged copy of the asset; edits go to `asset`.
  AccessorEditor(Asset& asset, const Asset& original, DataAccess& data, BufferEditor& buffers,
                 std::set<std::uint64_t> foreign)
      : asset_(asset), original_(original), data_(data), buffers_(buffers), taken_(std::move(foreign)) {}

  /// An accessor that begins as a copy of `old` and may be edited: `old` itself for the first caller, if nobody else
  /// needs it; otherwise a new one.
  std::size_t claim(std::size_t old);

  /// A new accessor.
  std::size_t add(Json accessor);

  Json& json(std::size_t accessor) { return asset_.document["accessors"][accessor]; }

  /// The vertex attribute `old` in another order: element i of the result is element order[i]. Gives the accessor that
  /// has it. Sparse accessors stay sparse.
  std::size_t reorder(std::size_t old, std::span<const std::uint32_t> order);

  /// The accessor `old`, whose bytes are those of one that `reorder` made `stored` of: gives one over the same new
  /// bytes.
  std::size_t follow(std::size_t old, std::size_t stored);

  /// Points `accessor` at `indices`, written with `component_type` into a view for indices.
  void setIndices(std::size_t accessor, std::span<const std::uint32_t> indices, std::uint32_t component_type);

  /// The vertex indices `old`, their values renumbered: gives the accessor that has them. One and the same for all who
  /// ask with the same `space`.
  std::size_t renumber(std::size_t old, IndexSpace& space);

  /// Points `accessor` at bytes of its own, at a multiple of four in a view for data of any kind.
  void storeBytes(std::size_t accessor, std::span<const std::byte> bytes);

  /// The same for a part of an accessor: its member `sparse.indices` or `sparse.values`.
  void storeSparse(std::size_t accessor, const char* part, std::span<const std::byte> bytes);

  /// States the bounds of an index accessor anew, where it states any.
  void updateIndexBounds(std::size_t accessor, std::span<const std::uint32_t> indices);

  /// Points an accessor at the start of a view (or at `offset` in it); no sparse data any more.
  void setView(std::size_t accessor, std::uint64_t view, std::uint64_t offset = 0);

  /// Bytes of attributes carried along.
  std::uint64_t attributeBytes() const { return attribute_bytes_; }

 private:
  /// Views that many accessors share: one per stride for attributes, one per type for indices, one for other data.
  enum class PoolKind { kAttributes, kIndices, kData };
  std::uint64_t pool(PoolKind kind, std::size_t stride);
  /// Where the bytes went: view and offset.
  std::pair<std::uint64_t, std::size_t> addData(std::span<const std::byte> bytes);
  void storeElements(std::size_t accessor, std::span<const std::byte> elements, std::size_t element_bytes);
  void reorderSparse(std::size_t accessor, const AccessorInfo& info, std::span<const std::uint32_t> order);

  Asset& asset_;
  const Asset& original_;
  DataAccess& data_;
  BufferEditor& buffers_;
  std::set<std::uint64_t> taken_;
  std::map<std::pair<PoolKind, std::size_t>, std::uint64_t> pools_;
  std::uint64_t attribute_bytes_ = 0;
};

}  // namespace tsc
