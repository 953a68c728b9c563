// See data_access.h. glTF 2.0, sections 3.6.1 and 3.6.2.
#include "data_access.h"

#include <algorithm>
#include <cstring>

#include "compressed_input.h"
#include "fault.h"

namespace tsc {
namespace {

/// Accessors without a view take no space in the file, so that their count alone must not make us allocate.
constexpr std::uint64_t kMaxUnbackedBytes = std::uint64_t{1} << 28;

std::size_t matrixColumns(const std::string& type) {
  if (type == "MAT2") return 2;
  if (type == "MAT3") return 3;
  if (type == "MAT4") return 4;
  return 0;
}

std::size_t elementBytes(const std::string& type, std::size_t component_bytes, const std::string& place) {
  if (const std::size_t columns = matrixColumns(type)) {
    return columns * ((columns * component_bytes + 3) / 4 * 4);  // columns start at multiples of four bytes
  }
  if (type == "SCALAR") return component_bytes;
  if (type == "VEC2") return 2 * component_bytes;
  if (type == "VEC3") return 3 * component_bytes;
  if (type == "VEC4") return 4 * component_bytes;
  failInvalid(place, "found \"" + type.substr(0, 20) + "\", expected an accessor type");
}

}  // namespace

std::size_t glTypeBytes(std::uint32_t component_type, const std::string& place) {
  switch (component_type) {
    case kGlByte:
    case kGlUnsignedByte: return 1;
    case kGlShort:
    case kGlUnsignedShort: return 2;
    case kGlUnsignedInt:
    case kGlFloat: return 4;
    default: failInvalid(place, "found " + number(component_type) + ", expected 5120, 5121, 5122, 5123, 5125 or 5126");
  }
}

std::uint32_t indexTypeFor(std::uint32_t type, std::uint64_t vertex_count) {
  if (type == kGlUnsignedByte && vertex_count > UINT8_MAX) type = kGlUnsignedShort;
  if (type == kGlUnsignedShort && vertex_count > UINT16_MAX) type = kGlUnsignedInt;
  return type;
}

std::vector<std::uint32_t> readUnsigned(std::span<const std::byte> bytes, std::size_t component_bytes) {
  std::vector<std::uint32_t> values(bytes.size() / component_bytes);
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (std::size_t k = 0; k < component_bytes; ++k) {
      values[i] |= std::to_integer<std::uint32_t>(bytes[i * component_bytes + k]) << (8 * k);
    }
  }
  return values;
}

std::vector<std::byte> writeUnsigned(std::span<const std::uint32_t> values, std::size_t component_bytes) {
  std::vector<std::byte> bytes(values.size() * component_bytes);
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (std::size_t k = 0; k < component_bytes; ++k) {
      bytes[i * component_bytes + k] = static_cast<std::byte>(values[i] >> (8 * k));
    }
  }
  return bytes;
}

std::span<const std::byte> bufferRange(const Asset& asset, std::uint64_t buffer, std::uint64_t offset,
                                       std::uint64_t length, const std::string& place) {
  if (buffer >= asset.buffers.size()) {
    failInvalid(place + "/buffer", "found " + number(buffer) + ", expected one below " + number(asset.buffers.size()));
  }
  const Buffer& source = asset.buffers[buffer];
  if (source.source == Buffer::Source::kPlaceholder) {
    // Its owner may supply the bytes by other means, so that the document as such is no worse for it.
    fail(FailureKind::kUnsupported, place + "/buffer",
         "found " + number(buffer) + ", whose bytes are not in the asset");
  }
  const std::uint64_t size = source.bytes.size();
  if (offset > size || length > size - offset) {
    failInvalid(place, "found bytes " + number(offset) + " to " + number(offset) + " + " + number(length) +
                           ", expected them inside the buffer's " + number(size));
  }
  return std::span(source.bytes).subspan(offset, length);
}

AccessorInfo DataAccess::accessor(std::size_t index) const {
  const JsonView json = elementOf(asset_.document, "accessors", index);
  AccessorInfo info;
  info.index = index;
  info.component_type = static_cast<std::uint32_t>(json["componentType"].asUint(UINT32_MAX));
  info.component_bytes = glTypeBytes(info.component_type, json.pointer() + "/componentType");
  info.type = json["type"].asString();
  info.element_bytes = elementBytes(info.type, info.component_bytes, json.pointer() + "/type");
  info.count = json["count"].asUint(UINT32_MAX);
  info.offset = json.uintOr("byteOffset", 0);
  if (const auto view = json.find("bufferView")) info.view = view->asUint();
  info.sparse = json.find("sparse").has_value();
  const auto overlay = overlays_.find(index);
  if (overlay != overlays_.end()) {
    info.count = overlay->second.count;
    info.sparse = false;
  }
  return info;
}

std::span<const std::byte> DataAccess::viewBytes(std::size_t view) {
  const auto decoded = decoded_views_.find(view);
  if (decoded != decoded_views_.end()) return decoded->second;
  const JsonView json = elementOf(asset_.document, "bufferViews", view);
  const std::uint64_t length = json["byteLength"].asUint();
  if (findExtension(json.json(), kExtensionName) != nullptr) {
    fail(FailureKind::kUsage, json.pointer(), "is packed already; unpack the asset first");
  }
  if (const std::optional<MeshoptRange> range = findMeshoptRange(json)) {
    std::vector<std::byte> bytes = decodeMeshopt(asset_, *range, length);
    return decoded_views_[view] = std::move(bytes);
  }
  return bufferRange(asset_, json["buffer"].asUint(), json.uintOr("byteOffset", 0), length, json.pointer());
}

std::vector<std::byte> DataAccess::gather(std::size_t view, std::uint64_t offset, std::uint64_t count,
                                          std::size_t element_bytes, bool strided, const std::string& place) {
  const JsonView json = elementOf(asset_.document, "bufferViews", view);
  const std::span<const std::byte> bytes = viewBytes(view);
  std::uint64_t stride = strided ? json.uintOr("byteStride", element_bytes, 65535) : element_bytes;
  if (stride < element_bytes) {
    failInvalid(json.pointer() + "/byteStride",
                "found " + number(stride) + ", expected at least the element's " + number(element_bytes));
  }
  // No overflow: count and stride are below 2^32 and 2^16.
  const std::uint64_t needed = count == 0 ? 0 : stride * (count - 1) + element_bytes;
  if (offset > bytes.size() || needed > bytes.size() - offset) {
    failInvalid(place, "found " + number(count) + " elements at byte " + number(offset) + " which end after " +
                           number(needed) + " bytes, expected them inside the view's " + number(bytes.size()));
  }
  std::vector<std::byte> out(count * element_bytes);
  if (stride == element_bytes) {
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
  } else {
    for (std::uint64_t i = 0; i < count; ++i) {
      std::memcpy(out.data() + i * element_bytes, bytes.data() + offset + i * stride, element_bytes);
    }
  }
  return out;
}

std::vector<std::byte> DataAccess::baseElements(const AccessorInfo& info) {
  const auto overlay = overlays_.find(info.index);
  if (overlay != overlays_.end()) return overlay->second.bytes;
  const std::string place = "/accessors/" + number(info.index);
  if (info.view) return gather(*info.view, info.offset, info.count, info.element_bytes, true, place);
  const std::uint64_t bytes = info.count * info.element_bytes;  // below 2^32 * 64
  if (bytes > std::min(kMaxUnbackedBytes, asset_.options.limits.max_output_bytes)) {
    fail(FailureKind::kUnsupported, place,
         "found " + number(bytes) + " bytes of zeros without a buffer view, too many");
  }
  return std::vector<std::byte>(bytes);
}

SparseInfo DataAccess::sparse(const AccessorInfo& info) {
  const JsonView json = elementOf(asset_.document, "accessors", info.index)["sparse"];
  const std::uint64_t count = json["count"].asUint(info.count);
  const JsonView index_json = json["indices"];
  SparseInfo sparse;
  sparse.index_type = static_cast<std::uint32_t>(index_json["componentType"].asUint(UINT32_MAX));
  if (sparse.index_type != kGlUnsignedByte && sparse.index_type != kGlUnsignedShort &&
      sparse.index_type != kGlUnsignedInt) {
    failInvalid(index_json.pointer() + "/componentType",
                "found " + number(sparse.index_type) + ", expected 5121, 5123 or 5125");
  }
  const std::size_t index_bytes = glTypeBytes(sparse.index_type, index_json.pointer());
  sparse.indices = readUnsigned(gather(index_json["bufferView"].asUint(), index_json.uintOr("byteOffset", 0), count,
                                       index_bytes, false, index_json.pointer()),
                                index_bytes);
  for (const std::uint32_t index : sparse.indices) {
    if (index >= info.count) {
      failInvalid(index_json.pointer(), "found " + number(index) + ", expected one below " + number(info.count));
    }
  }
  const JsonView values = json["values"];
  sparse.values = gather(values["bufferView"].asUint(), values.uintOr("byteOffset", 0), count, info.element_bytes,
                         false, values.pointer());
  return sparse;
}

std::vector<std::byte> DataAccess::elements(const AccessorInfo& info) {
  std::vector<std::byte> out = baseElements(info);
  if (!info.sparse) return out;
  const SparseInfo patch = sparse(info);
  for (std::size_t i = 0; i < patch.indices.size(); ++i) {
    std::memcpy(out.data() + patch.indices[i] * info.element_bytes, patch.values.data() + i * info.element_bytes,
                info.element_bytes);
  }
  return out;
}

std::vector<std::uint32_t> DataAccess::indices(const AccessorInfo& info) {
  const std::string place = "/accessors/" + number(info.index);
  const bool unsigned_type = info.component_type == kGlUnsignedByte || info.component_type == kGlUnsignedShort ||
                             info.component_type == kGlUnsignedInt;
  if (info.type != "SCALAR" || !unsigned_type) {
    failInvalid(place, "found " + info.type + " of " + number(info.component_type) +
                           ", expected indices: SCALAR of 5121, 5123 or 5125");
  }
  return readUnsigned(elements(info), info.component_bytes);
}

void DataAccess::overlay(std::size_t accessor, std::vector<std::byte> bytes, std::uint64_t count) {
  overlays_[accessor] = {std::move(bytes), count};
}

bool DataAccess::isCompressed(std::size_t accessor) const {
  if (hasOverlay(accessor)) return true;
  const JsonView json = elementOf(asset_.document, "accessors", accessor);
  const auto isMeshopt = [&](const JsonView& holder) {
    const auto view = holder.find("bufferView");
    return view && findMeshoptRange(elementOf(asset_.document, "bufferViews", view->asUint())).has_value();
  };
  if (isMeshopt(json)) return true;
  const auto sparse = json.find("sparse");
  return sparse && (isMeshopt((*sparse)["indices"]) || isMeshopt((*sparse)["values"]));
}

std::size_t DataAccess::canonical(std::size_t accessor) {
  const AccessorInfo info = this->accessor(accessor);
  if (!info.view || info.sparse || hasOverlay(accessor)) return accessor;
  return canonical_.emplace(std::tuple(*info.view, info.offset, info.component_type, info.type, info.count), accessor)
      .first->second;
}

}  // namespace tsc
