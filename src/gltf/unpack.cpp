// Unpacking: decodes every stream into plain buffer views and takes the extension out of the document.
#include <algorithm>

#include "buffer_editor.h"
#include "conformance.h"
#include "data_access.h"
#include "fault.h"
#include "json_document.h"
#include "original_order.h"

namespace tsc {
namespace {

/// Decodes one stream into the views that name it. `budget` bounds the decoded bytes of the whole asset.
void unpackStream(const Asset& asset, const PackedStream& stream, std::uint64_t& budget, BufferEditor& buffers) {
  DataAccess data(asset);
  Result<std::vector<std::vector<std::byte>>> decoded = decode(data.viewBytes(stream.view), DecodeLimits{budget});
  if (!decoded) failStream("/bufferViews/" + number(stream.view), decoded.error());
  for (const std::vector<std::byte>& output : *decoded) budget -= std::min<std::uint64_t>(budget, output.size());
  if (const auto order = stream.views.front().order) {
    restoreOriginalOrder(data.viewBytes(*order), stream.info.outputs, *decoded,
                         "/bufferViews/" + std::to_string(*order));
  }
  checkDecoded(asset, stream, *decoded);
  buffers.release(stream.view);
  if (const auto order = stream.views.front().order) buffers.release(*order);
  // No two views name the same output.
  for (const PackedView& view : stream.views) buffers.replace(view.view, std::move((*decoded)[view.output]));
}

void unpack(Asset& asset) {
  const std::vector<PackedStream> streams = checkConformance(asset);
  BufferEditor buffers(asset);
  std::uint64_t budget = asset.options.limits.max_output_bytes;
  for (const PackedStream& stream : streams) unpackStream(asset, stream, budget, buffers);
  for (const PackedStream& stream : streams) {
    for (const PackedView& view : stream.views)
      eraseExtension(asset.document["bufferViews"][view.view], kExtensionName);
  }
  buffers.commit();
  for (std::size_t i = 0; i < countOf(asset.document, "buffers"); ++i) {
    eraseExtension(asset.document["buffers"][i], kExtensionName);
  }
  undeclareExtension(asset.document, kExtensionName);
}

bool isListed(const Json& document, const char* list) {
  const auto names = document.find(list);
  return names != document.end() && names->is_array() &&
         std::find(names->begin(), names->end(), kExtensionName) != names->end();
}

/// Whether an element of the root's array `key` has the extension.
bool isUsed(const Json& document, const char* key) {
  const auto elements = document.find(key);
  return elements != document.end() && elements->is_array() &&
         std::any_of(elements->begin(), elements->end(),
                     [](const Json& element) { return findExtension(element, kExtensionName) != nullptr; });
}

}  // namespace

bool isPacked(const Asset& asset) {
  // What is used without being declared counts too: unpacking says what is wrong with it.
  const Json& document = asset.document;
  return isListed(document, "extensionsUsed") || isListed(document, "extensionsRequired") ||
         isUsed(document, "bufferViews") || isUsed(document, "buffers");
}

Outcome unpackAsset(Asset& asset) {
  if (!isPacked(asset)) return std::nullopt;
  return guardedOutcome(asset.name, [&] { unpack(asset); });
}

Expected<std::vector<std::byte>> expand(std::span<const std::byte> bytes, const UriResolver& resolver,
                                        const Limits& limits) {
  Expected<Asset> asset = loadAsset(bytes, "", resolver, {limits, false});
  if (!asset) return asset.failure();
  if (Outcome failure = unpackAsset(*asset)) return *failure;
  return writeGlb(*asset);
}

}  // namespace tsc
