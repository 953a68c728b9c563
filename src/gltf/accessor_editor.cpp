// See accessor_editor.h.
#include "accessor_editor.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <string_view>
#include <type_traits>

#include "fault.h"
#include "json_document.h"

namespace tsc {
namespace {

std::size_t roundUp(std::size_t value, std::size_t multiple) { return (value + multiple - 1) / multiple * multiple; }

/// Writes an offset, leaving out what is the default and was not there.
void setOffset(Json& holder, std::uint64_t offset) {
  if (offset != 0 || holder.contains("byteOffset")) holder["byteOffset"] = offset;
}

template <class T>
Json componentAt(const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(value));
  if constexpr (std::is_floating_point_v<T>) return double{value};
  return value;
}

Json readComponent(const std::byte* bytes, std::uint32_t gl_type) {
  switch (gl_type) {
    case kGlByte: return componentAt<std::int8_t>(bytes);
    case kGlUnsignedByte: return componentAt<std::uint8_t>(bytes);
    case kGlShort: return componentAt<std::int16_t>(bytes);
    case kGlUnsignedShort: return componentAt<std::uint16_t>(bytes);
    case kGlUnsignedInt: return componentAt<std::uint32_t>(bytes);
    default: return componentAt<float>(bytes);
  }
}

/// Bounds that are stated become those of the data. What was compressed with loss often states those from before.
void correctBounds(Json& accessor, const AccessorInfo& info, const std::vector<std::byte>& elements) {
  const std::size_t components = info.element_bytes / info.component_bytes;
  for (const char* key : {"min", "max"}) {
    const bool is_min = std::string_view(key) == "min";
    Json* bounds = accessor.contains(key) ? &accessor[key] : nullptr;
    if (bounds == nullptr || !bounds->is_array() || bounds->size() != components || elements.empty()) continue;
    for (std::size_t c = 0; c < components; ++c) {
      Json best = readComponent(elements.data() + c * info.component_bytes, info.component_type);
      for (std::size_t at = c * info.component_bytes; at < elements.size(); at += info.element_bytes) {
        Json value = readComponent(elements.data() + at, info.component_type);
        if (is_min ? value < best : best < value) best = std::move(value);
      }
      if ((*bounds)[c] != best) (*bounds)[c] = std::move(best);
    }
  }
}

}  // namespace

std::size_t AccessorEditor::claim(std::size_t old) {
  if (taken_.insert(old).second) return old;
  return add(original_.document["accessors"][old]);
}

std::size_t AccessorEditor::add(Json accessor) {
  Json& accessors = asset_.document["accessors"];
  accessors.push_back(std::move(accessor));
  return accessors.size() - 1;
}

std::uint64_t AccessorEditor::pool(PoolKind kind, std::size_t stride) {
  const auto [entry, added] = pools_.emplace(std::pair(kind, stride), 0);
  if (added) {
    Json properties = Json::object();
    if (kind == PoolKind::kAttributes) {
      properties["byteStride"] = stride;
      properties["target"] = kArrayBuffer;
    } else if (kind == PoolKind::kIndices) {
      properties["target"] = kElementArrayBuffer;
    }
    entry->second = buffers_.add(std::move(properties));
  }
  return entry->second;
}

void AccessorEditor::setView(std::size_t accessor, std::uint64_t view, std::uint64_t offset) {
  Json& entry = json(accessor);
  entry["bufferView"] = view;
  setOffset(entry, offset);
  entry.erase("sparse");
}

void AccessorEditor::storeElements(std::size_t accessor, std::span<const std::byte> elements,
                                   std::size_t element_bytes) {
  const std::size_t stride = roundUp(element_bytes, 4);
  const std::uint64_t view = pool(PoolKind::kAttributes, stride);
  std::vector<std::byte>& bytes = buffers_.bytes(view);
  const std::size_t offset = bytes.size();
  const std::size_t count = elements.size() / element_bytes;
  bytes.resize(offset + count * stride);
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(bytes.data() + offset + i * stride, elements.data() + i * element_bytes, element_bytes);
  }
  attribute_bytes_ += count * stride;
  Json& entry = json(accessor);
  entry["bufferView"] = view;
  setOffset(entry, offset);
}

void AccessorEditor::reorderSparse(std::size_t accessor, const AccessorInfo& info,
                                   std::span<const std::uint32_t> order) {
  std::vector<std::uint32_t> new_index(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) new_index[order[i]] = static_cast<std::uint32_t>(i);
  const SparseInfo old = data_.sparse(info);
  std::vector<std::size_t> rank(old.indices.size());
  std::iota(rank.begin(), rank.end(), std::size_t{0});
  // Stable, so that of values given twice for one vertex the last still wins.
  std::stable_sort(rank.begin(), rank.end(),
                   [&](std::size_t a, std::size_t b) { return new_index[old.indices[a]] < new_index[old.indices[b]]; });
  std::vector<std::uint32_t> indices;
  std::vector<std::byte> values(old.values.size());
  for (std::size_t i = 0; i < rank.size(); ++i) {
    indices.push_back(new_index[old.indices[rank[i]]]);
    std::memcpy(values.data() + i * info.element_bytes, old.values.data() + rank[i] * info.element_bytes,
                info.element_bytes);
  }
  storeSparse(accessor, "indices", writeUnsigned(indices, glTypeBytes(old.index_type, "")));
  storeSparse(accessor, "values", values);
}

std::pair<std::uint64_t, std::size_t> AccessorEditor::addData(std::span<const std::byte> bytes) {
  const std::uint64_t view = pool(PoolKind::kData, 0);
  std::vector<std::byte>& data = buffers_.bytes(view);
  data.resize(roundUp(data.size(), 4));
  const std::size_t offset = data.size();
  data.insert(data.end(), bytes.begin(), bytes.end());
  attribute_bytes_ += bytes.size();
  return {view, offset};
}

void AccessorEditor::storeBytes(std::size_t accessor, std::span<const std::byte> bytes) {
  const auto [view, offset] = addData(bytes);
  setView(accessor, view, offset);
}

void AccessorEditor::storeSparse(std::size_t accessor, const char* part, std::span<const std::byte> bytes) {
  const auto [view, offset] = addData(bytes);
  Json& holder = json(accessor)["sparse"][part];
  holder["bufferView"] = view;
  setOffset(holder, offset);
}

std::size_t AccessorEditor::reorder(std::size_t old, std::span<const std::uint32_t> order) {
  const AccessorInfo info = data_.accessor(old);
  const bool has_data = info.view || info.sparse || data_.hasOverlay(old);
  if (!has_data) return old;  // all zeros, in any order
  const std::size_t accessor = claim(old);
  if (info.view || data_.hasOverlay(old)) {
    const std::vector<std::byte> base = data_.baseElements(info);
    std::vector<std::byte> reordered(order.size() * info.element_bytes);
    for (std::size_t i = 0; i < order.size(); ++i) {
      std::memcpy(reordered.data() + i * info.element_bytes, base.data() + order[i] * info.element_bytes,
                  info.element_bytes);
    }
    storeElements(accessor, reordered, info.element_bytes);
    if (data_.hasOverlay(old)) json(accessor)["count"] = info.count;
  }
  if (info.sparse) reorderSparse(accessor, info, order);
  if (data_.isCompressed(old)) correctBounds(json(accessor), info, data_.elements(info));
  return accessor;
}

std::size_t AccessorEditor::follow(std::size_t old, std::size_t stored) {
  const std::size_t accessor = claim(old);
  const Json source = json(stored);
  json(accessor)["bufferView"] = source["bufferView"];
  setOffset(json(accessor), source.value("byteOffset", std::uint64_t{0}));
  return accessor;
}

void AccessorEditor::setIndices(std::size_t accessor, std::span<const std::uint32_t> indices,
                                std::uint32_t component_type) {
  const std::size_t component_bytes = glTypeBytes(component_type, "");
  const std::uint64_t view = pool(PoolKind::kIndices, component_bytes);
  std::vector<std::byte>& bytes = buffers_.bytes(view);
  const std::size_t offset = bytes.size();
  const std::vector<std::byte> data = writeUnsigned(indices, component_bytes);
  bytes.insert(bytes.end(), data.begin(), data.end());
  setView(accessor, view, offset);
  Json& entry = json(accessor);
  entry["componentType"] = component_type;
  entry["count"] = indices.size();
  entry["type"] = "SCALAR";
  updateIndexBounds(accessor, indices);
}

std::size_t AccessorEditor::renumber(std::size_t old, IndexSpace& space) {
  const auto [entry, added] = space.indices.emplace(old, 0);
  if (!added) return entry->second;
  const AccessorInfo info = data_.accessor(old);
  std::vector<std::uint32_t> indices = data_.indices(info);
  for (std::uint32_t& index : indices) {
    if (index >= space.new_index.size()) {
      failInvalid("/accessors/" + std::to_string(old), "found vertex index " + std::to_string(index) +
                                                           ", expected one below " +
                                                           std::to_string(space.new_index.size()));
    }
    index = space.new_index[index];
  }
  entry->second = claim(old);
  setIndices(entry->second, indices, indexTypeFor(info.component_type, space.order.size()));
  return entry->second;
}

void AccessorEditor::updateIndexBounds(std::size_t accessor, std::span<const std::uint32_t> indices) {
  Json& entry = json(accessor);
  if (indices.empty()) return;
  const auto [low, high] = std::minmax_element(indices.begin(), indices.end());
  if (entry.contains("min")) entry["min"] = Json::array({*low});
  if (entry.contains("max")) entry["max"] = Json::array({*high});
}

}  // namespace tsc
