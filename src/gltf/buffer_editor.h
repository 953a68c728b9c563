// Adding, replacing and dropping buffer views while everything else keeps its index and its bytes.
//
// New views take the slots of dropped ones, so that other indices need not change. Bytes are removed from a buffer only
// where dropped or replaced views alone covered them. Between construction and `commit` an accessor names a new view by
// the id that `add` gave.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "tsc/gltf.h"

namespace tsc {

class BufferEditor {
 public:
  enum class Place {
    kAnywhere,  ///< in a free slot, or at the end
    kLast,      ///< after all others, so that it can be dropped again without renumbering
  };

  explicit BufferEditor(Asset& asset);

  /// A new view with the given properties (all but buffer, byteOffset, byteLength), to be filled through `bytes`.
  std::uint64_t add(Json properties, Place place = Place::kAnywhere);
  /// The bytes of a new view; alignment in the buffer is four.
  std::vector<std::byte>& bytes(std::uint64_t id);
  /// Makes a new view a range of the placeholder buffer, without bytes.
  void makePlaceholder(std::uint64_t id, std::uint64_t byte_length);

  /// Gives a view of the document other bytes. Its other properties may be edited in the document.
  void replace(std::size_t view, std::vector<std::byte> bytes);

  /// Cuts a view of the document down to its bytes `begin` to `end`; what was around them is removed unless others use
  /// it. `begin` must be a multiple of eight.
  void trim(std::size_t view, std::uint64_t begin, std::uint64_t end);

  /// Tells that nobody but this library can mean a view: it may go even if an unknown extension has a number like it.
  void release(std::size_t view) { released_.insert(view); }

  /// Whether a number that may be a reference could mean this view.
  bool maybeNamed(std::size_t view) const { return unknown_.count(view) > 0; }

  /// Carries everything out: views that had a user and have none now are dropped, buffers compacted, references
  /// renumbered where they must be.
  void commit();

 private:
  struct NewView {
    Json properties;
    std::vector<std::byte> bytes;
    std::uint64_t placeholder_length = 0;
    bool placeholder = false;
    Place place = Place::kAnywhere;
    std::size_t slot = 0;
  };
  struct Replacement {
    std::size_t view;
    std::vector<std::byte> bytes;
  };
  struct Range {
    std::uint64_t begin;
    std::uint64_t end;
  };

  struct TrimmedRange {
    std::size_t buffer;
    Range range;
  };

  std::set<std::size_t> usedViews();
  std::size_t targetBuffer();
  std::vector<bool> droppedViews();
  void overwriteInPlace();
  void releaseBytes(const std::vector<bool>& dropped);
  void compactBuffer(std::size_t buffer, std::vector<Range> released, std::vector<Range> kept);
  std::uint64_t append(std::size_t buffer, std::span<const std::byte> bytes);
  void placeViews(const std::vector<bool>& dropped);
  void removeEmptyBuffers(const std::set<std::size_t>& referenced_before);
  std::set<std::size_t> referencedBuffers();
  Json makeView(NewView& view, std::size_t target);

  Asset& asset_;
  std::set<std::uint64_t> unknown_;  ///< numbers that may be references
  std::set<std::size_t> used_before_;
  std::vector<NewView> new_;
  std::vector<Replacement> replaced_;
  std::vector<TrimmedRange> trimmed_;
  std::set<std::size_t> released_;
  std::uint64_t placeholder_bytes_ = 0;
};

}  // namespace tsc
