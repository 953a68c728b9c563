// See compressed_input.h.
#include "compressed_input.h"

#include <meshoptimizer.h>

#include <span>

#include "data_access.h"
#include "draco_decode.h"
#include "fault.h"

namespace tsc {
namespace {

/// No meshopt codec expands more than this: attributes take 4 bytes a byte column and block of 256 elements, triangles
/// one byte each (12 bytes decoded). So a count is checked before anything is allocated.
constexpr std::uint64_t kMaxMeshoptRatio = 64;

void checkMeshopt(const MeshoptRange& range, std::uint64_t length) {
  if (range.count > UINT32_MAX || range.stride == 0 || range.stride > 256) {
    failInvalid(range.place, "found " + number(range.count) + " elements of " + number(range.stride) +
                                 " bytes, expected at most 4294967295 of 1 to 256");
  }
  const std::uint64_t bytes = range.count * range.stride;
  if (bytes != length) {
    failInvalid(range.place, "found " + number(bytes) + " decoded bytes, expected the view's " + number(length));
  }
  if (bytes > (range.length + 64) * kMaxMeshoptRatio) {
    failInvalid(range.place, "found " + number(range.length) + " compressed bytes, too few for " + number(bytes));
  }
  const bool attributes = range.mode == "ATTRIBUTES";
  const bool triangles = range.mode == "TRIANGLES";
  if (!attributes && !triangles && range.mode != "INDICES") {
    fail(FailureKind::kUnsupported, range.place + "/mode",
         "found \"" + range.mode.substr(0, 20) + "\", expected ATTRIBUTES, TRIANGLES or INDICES");
  }
  const bool stride_fits = attributes ? range.stride % 4 == 0 : range.stride == 2 || range.stride == 4;
  if (!stride_fits || (triangles && range.count % 3 != 0)) {
    failInvalid(range.place, "found " + number(range.count) + " elements of " + number(range.stride) +
                                 " bytes, which mode " + range.mode + " cannot have");
  }
}

void applyFilter(const MeshoptRange& range, std::vector<std::byte>& out) {
  if (range.filter == "NONE") return;
  const bool attributes = range.mode == "ATTRIBUTES";
  if (attributes && range.filter == "OCTAHEDRAL" && (range.stride == 4 || range.stride == 8)) {
    meshopt_decodeFilterOct(out.data(), range.count, range.stride);
  } else if (attributes && range.filter == "QUATERNION" && range.stride == 8) {
    meshopt_decodeFilterQuat(out.data(), range.count, range.stride);
  } else if (attributes && range.filter == "EXPONENTIAL" && range.stride % 4 == 0) {
    meshopt_decodeFilterExp(out.data(), range.count, range.stride);
  } else {
    fail(FailureKind::kUnsupported, range.place + "/filter",
         "found \"" + range.filter.substr(0, 20) + "\" on elements of " + number(range.stride) +
             " bytes, expected OCTAHEDRAL (4, 8), QUATERNION (8) or EXPONENTIAL");
  }
}

}  // namespace

std::optional<MeshoptRange> findMeshoptRange(const JsonView& view) {
  for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const Json* extension = findExtension(view.json(), name);
    if (extension == nullptr) continue;
    const JsonView json(*extension, view.pointer() + "/extensions/" + name);
    MeshoptRange range;
    range.place = json.pointer();
    range.buffer = json["buffer"].asUint();
    range.offset = json.uintOr("byteOffset", 0);
    range.length = json["byteLength"].asUint();
    range.stride = json["byteStride"].asUint();
    range.count = json["count"].asUint();
    range.mode = json["mode"].asString();
    const auto filter = json.find("filter");
    range.filter = filter ? filter->asString() : "NONE";
    return range;
  }
  return std::nullopt;
}

std::vector<std::byte> decodeMeshopt(const Asset& asset, const MeshoptRange& range, std::uint64_t length) {
  checkMeshopt(range, length);
  const auto source = bufferRange(asset, range.buffer, range.offset, range.length, range.place);
  const auto* data = reinterpret_cast<const unsigned char*>(source.data());
  // The high half of the first byte names the codec, the low half its version; Debian's library knows 0 (and 1 for
  // indices).
  const bool attributes = range.mode == "ATTRIBUTES";
  if (attributes && !source.empty() && data[0] == 0xA1) {
    fail(FailureKind::kUnsupported, range.place,
         "found vertex codec version 1, expected 0, which libmeshoptimizer " + number(MESHOPTIMIZER_VERSION / 1000) +
             "." + number(MESHOPTIMIZER_VERSION / 10 % 100) + " can decode");
  }
  std::vector<std::byte> out(range.count * range.stride);
  int result = 0;
  if (attributes) {
    result = meshopt_decodeVertexBuffer(out.data(), range.count, range.stride, data, source.size());
  } else if (range.mode == "TRIANGLES") {
    result = meshopt_decodeIndexBuffer(out.data(), range.count, range.stride, data, source.size());
  } else {
    result = meshopt_decodeIndexSequence(out.data(), range.count, range.stride, data, source.size());
  }
  if (result != 0)
    failInvalid(range.place, "the compressed data is damaged (libmeshoptimizer: " + std::to_string(result) + ")");
  applyFilter(range, out);
  return out;
}

DracoData decodeDraco(std::span<const std::byte> bytes, const std::map<std::string, std::uint32_t>& ids,
                      const std::map<std::string, AccessorInfo>& infos, const std::string& place) {
  std::vector<DracoAttribute> wanted;
  for (const auto& [name, id] : ids) {
    const AccessorInfo& info = infos.at(name);
    wanted.push_back({id, info.component_type, info.element_bytes / info.component_bytes, false, {}});
  }
  DracoMesh mesh;
  std::string error;
  if (!tsc_decode_draco(reinterpret_cast<const char*>(bytes.data()), bytes.size(), mesh, wanted, error)) {
    failInvalid(place, "the Draco data is damaged: " + error);
  }
  DracoData data;
  data.vertex_count = mesh.vertex_count;
  data.indices = std::move(mesh.indices);
  std::size_t next = 0;
  for (const auto& [name, id] : ids) {
    DracoAttribute& attribute = wanted[next++];
    if (!attribute.found) {
      failInvalid(place + "/attributes/" + name, "the Draco data has no id " + number(id) + " of the accessor's type");
    }
    data.attributes[name] = std::move(attribute.values);
  }
  return data;
}

}  // namespace tsc
