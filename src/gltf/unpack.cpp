// Unpacking: decodes every stream into plain buffer views and takes the extension out of the document.
#include <map>

#include "buffer_editor.h"
#include "data_access.h"
#include "fault.h"
#include "json_document.h"
#include "packed_views.h"

namespace tsc {
namespace {

std::string number(std::uint64_t value) { return std::to_string(value); }

/// Decodes one stream into the views that name it. `budget` bounds the decoded bytes of the whole asset.
void unpackStream(const Asset& asset, std::size_t stream, const std::vector<PackedView>& views, std::uint64_t& budget,
                  BufferEditor& buffers) {
  DataAccess data(asset);
  const std::string place = "/bufferViews/" + number(stream);
  const std::span<const std::byte> bytes = data.viewBytes(stream);
  const DecodeLimits limits{budget};
  const Result<StreamInfo> info = readStreamInfo(bytes, limits);
  if (!info) failInvalid(place, describe(info.error()));
  for (const PackedView& view : views) {
    if (view.output >= info->outputs.size()) {
      failInvalid(view.place + "/output",
                  "found " + number(view.output) + ", expected one below " + number(info->outputs.size()));
    }
    if (view.byte_length != info->outputs[view.output].byte_length) {
      failInvalid("/bufferViews/" + number(view.view) + "/byteLength",
                  "found " + number(view.byte_length) + ", expected " + number(info->outputs[view.output].byte_length) +
                      ", the length of the decoded array");
    }
  }
  Result<std::vector<std::vector<std::byte>>> decoded = decode(bytes, limits);
  if (!decoded) failInvalid(place, describe(decoded.error()));
  for (const std::vector<std::byte>& output : *decoded) budget -= std::min<std::uint64_t>(budget, output.size());
  std::map<std::size_t, std::size_t> uses;
  for (const PackedView& view : views) ++uses[view.output];
  for (const PackedView& view : views) {
    std::vector<std::byte>& output = (*decoded)[view.output];
    buffers.replace(view.view, --uses[view.output] == 0 ? std::move(output) : output);
  }
}

void unpack(Asset& asset) {
  const std::map<std::size_t, std::vector<PackedView>> streams = findPackedViews(asset.document);
  BufferEditor buffers(asset);
  std::uint64_t budget = asset.options.limits.max_output_bytes;
  for (const auto& [stream, views] : streams) unpackStream(asset, stream, views, budget, buffers);
  for (const auto& [stream, views] : streams) {
    for (const PackedView& view : views) eraseExtension(asset.document["bufferViews"][view.view], kExtensionName);
  }
  buffers.commit();
  for (std::size_t i = 0; i < countOf(asset.document, "buffers"); ++i) {
    eraseExtension(asset.document["buffers"][i], kExtensionName);
  }
  undeclareExtension(asset.document, kExtensionName);
}

}  // namespace

bool isPacked(const Asset& asset) {
  const Json& document = asset.document;
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    const auto names = document.find(list);
    if (names == document.end() || !names->is_array()) continue;
    for (const Json& name : *names) {
      if (name == kExtensionName) return true;
    }
  }
  return false;
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
