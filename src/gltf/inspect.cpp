// Counting what an asset holds, without decoding it.
#include <set>

#include "conformance.h"
#include "data_access.h"
#include "fault.h"
#include "json_document.h"
#include "mesh_groups.h"

namespace tsc {
namespace {

std::uint64_t triangleCount(std::uint32_t mode, std::uint64_t elements) {
  if (mode == kTriangles) return elements / 3;
  if (mode < kTriangles || elements < 3) return 0;
  return elements - 2;
}

std::optional<std::size_t> viewOfAccessor(const JsonView& root, std::uint64_t accessor) {
  const auto view = root["accessors"].at(accessor).find("bufferView");
  if (!view) return std::nullopt;
  return view->asUint();
}

/// Counts the primitives; `meshes_of_view` learns which meshes use a view for positions or indices.
void countMeshes(const Asset& asset, AssetSummary& summary,
                 std::map<std::size_t, std::set<std::size_t>>& meshes_of_view) {
  const JsonView root(asset.document);
  std::set<std::uint64_t> positions;
  summary.meshes = countOf(asset.document, "meshes");
  for (std::size_t m = 0; m < summary.meshes; ++m) {
    const JsonView primitives = elementOf(asset.document, "meshes", m)["primitives"];
    for (std::size_t p = 0; p < primitives.size(); ++p) {
      const JsonView primitive = primitives.at(p);
      ++summary.primitives;
      const auto position = primitive["attributes"].find("POSITION");
      if (!position) continue;
      const std::uint64_t accessor = position->asUint();
      std::uint64_t elements = root["accessors"].at(accessor)["count"].asUint();
      if (positions.insert(accessor).second) summary.vertices += elements;
      if (const auto view = viewOfAccessor(root, accessor)) meshes_of_view[*view].insert(m);
      if (const auto indices = primitive.find("indices")) {
        elements = root["accessors"].at(indices->asUint())["count"].asUint();
        if (const auto view = viewOfAccessor(root, indices->asUint())) meshes_of_view[*view].insert(m);
      }
      summary.triangles +=
          triangleCount(static_cast<std::uint32_t>(primitive.uintOr("mode", kTriangles, kTriangleFan)), elements);
    }
  }
}

StreamSummary summarise(const Asset& asset, const PackedStream& stream,
                        std::map<std::size_t, std::set<std::size_t>>& meshes_of_view) {
  DataAccess data(asset);
  StreamSummary summary;
  summary.buffer_view = stream.view;
  summary.stream_bytes = data.viewBytes(stream.view).size();
  if (const auto order = stream.views.front().order) summary.order_bytes = data.viewBytes(*order).size();
  summary.info = stream.info;
  for (const OutputInfo& output : summary.info.outputs) {
    summary.decoded_bytes += output.byte_length;
    (output.kind == OutputInfo::Kind::kPositions ? summary.vertices : summary.triangles) += output.count;
  }
  summary.triangles /= 3;
  std::set<std::size_t> meshes;
  for (const PackedView& view : stream.views)
    meshes.insert(meshes_of_view[view.view].begin(), meshes_of_view[view.view].end());
  summary.meshes.assign(meshes.begin(), meshes.end());
  for (const std::size_t mesh : meshes) {
    summary.label += (summary.label.empty() ? "" : ", ") + meshLabel(asset.document, mesh);
  }
  return summary;
}

}  // namespace

Expected<AssetSummary> inspectAsset(const Asset& asset) {
  return guarded(asset.name, [&] {
    AssetSummary summary;
    summary.packed = isPacked(asset);
    summary.json_bytes = writeJson(asset.document).size();
    for (const Buffer& buffer : asset.buffers) summary.buffer_bytes += buffer.bytes.size();
    for (std::size_t i = 0; i < countOf(asset.document, "extensionsUsed"); ++i) {
      summary.extensions_used.push_back(elementOf(asset.document, "extensionsUsed", i).asString());
    }
    std::map<std::size_t, std::set<std::size_t>> meshes_of_view;
    countMeshes(asset, summary, meshes_of_view);
    for (const PackedStream& stream : checkConformance(asset)) {
      summary.streams.push_back(summarise(asset, stream, meshes_of_view));
    }
    return summary;
  });
}

}  // namespace tsc
