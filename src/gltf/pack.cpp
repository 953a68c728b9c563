// Packing: surveys the meshes, codes each group as one stream, checks it, and patches the document.
#include "buffer_editor.h"
#include "codec_mesh.h"
#include "data_access.h"
#include "document_patcher.h"
#include "fault.h"
#include "json_document.h"
#include "mesh_groups.h"
#include "precision.h"

namespace tsc {
namespace {

std::uint64_t sizeOf(const Asset& asset) {
  std::uint64_t bytes = writeJson(asset.document).size();
  for (const Buffer& buffer : asset.buffers) {
    if (buffer.source != Buffer::Source::kDataUri || buffer.modified) bytes += buffer.bytes.size();
  }
  return bytes;
}

/// Codes all groups before anything is patched, for a group that cannot be coded must find its data unchanged.
std::vector<CodedGroup> codeGroups(const Asset& asset, const MeshSurvey& survey, DataAccess& data,
                                   const PackOptions& options, std::vector<KeptReport>& kept) {
  std::vector<CodedGroup> coded;
  std::uint64_t total = 0, done = 0;
  for (const MeshGroup& group : survey.groups) total += triangleCount(group);
  for (const MeshGroup& group : survey.groups) {
    if (options.progress) options.progress(done, total);
    done += triangleCount(group);
    try {
      coded.push_back(codeGroup(group, data, options));
    } catch (const Fault& fault) {
      if (fault.failure().kind != FailureKind::kUnsupported) throw;
      for (const std::size_t mesh : group.meshes) {
        kept.push_back({mesh, std::nullopt, meshLabel(asset.document, mesh), fault.failure().message});
      }
    }
  }
  if (options.progress) options.progress(done, total);
  return coded;
}

/// Takes a compression that was decoded out of the lists, if nothing uses it any more.
void undeclareIfUnused(Json& document, std::string_view name) {
  const auto uses = [&](const char* key) {
    for (std::size_t i = 0; i < countOf(document, key); ++i) {
      if (findExtension(document[key][i], name) != nullptr) return true;
    }
    return false;
  };
  bool used = uses("buffers") || uses("bufferViews");
  for (std::size_t m = 0; m < countOf(document, "meshes"); ++m) {
    for (const Json& primitive : document["meshes"][m]["primitives"]) {
      used = used || findExtension(primitive, name) != nullptr;
    }
  }
  if (!used) undeclareExtension(document, name);
}

PackReport pack(Asset& asset, const PackOptions& options) {
  const Asset original = asset;  // read from, while `asset` changes
  DataAccess data(original);
  BufferEditor buffers(asset);
  PackReport report;
  report.input_bytes = report.output_bytes = sizeOf(original);
  const MeshSurvey survey = surveyMeshes(original, data, options.keep_order);
  report.kept = survey.kept;
  std::vector<CodedGroup> coded = codeGroups(original, survey, data, options, report.kept);
  if (coded.empty()) return report;

  DocumentPatcher patcher(asset, original, data, buffers, survey, coded, options);
  for (CodedGroup& group : coded) {
    patcher.patch(group);
    report.streams.push_back(std::move(group.report));
  }
  patcher.trimViews();
  buffers.commit();
  declareExtension(asset.document, kExtensionName, !options.fallback);
  for (const char* name : {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    undeclareIfUnused(asset.document, name);
  }
  report.attribute_bytes = patcher.attributeBytes();
  report.output_bytes = sizeOf(asset);
  report.warnings = patcher.warnings();
  if (report.output_bytes > report.input_bytes && !options.fallback) {
    report.warnings.push_back("packed, the asset takes " + std::to_string(report.output_bytes) +
                              " bytes, more than the " + std::to_string(report.input_bytes) + " before");
  }
  return report;
}

}  // namespace

Expected<PackReport> packAsset(Asset& asset, const PackOptions& options) {
  return guarded(asset.name, [&] {
    checkPackOptions(options);
    if (isPacked(asset)) {
      if (!options.repack) {
        fail(FailureKind::kUsage, "", "the asset is packed already; --repack packs it again");
      }
      const std::string name = std::exchange(asset.name, {});
      Outcome unpacked = unpackAsset(asset);
      asset.name = name;
      raiseIfFailed(std::move(unpacked));
    }
    return pack(asset, options);
  });
}

}  // namespace tsc
