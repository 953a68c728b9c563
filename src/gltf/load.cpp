// Loading an asset: container, document, buffers.
#include <algorithm>

#include "container.h"
#include "fault.h"
#include "file_io.h"
#include "json_document.h"

namespace tsc {
namespace {

/// Gives the bytes of an external buffer or raises a failure that names the place.
using Opener = std::function<std::vector<std::byte>(std::string_view uri, std::string_view place)>;

/// Meshopt's fallback buffers hold what decoding gives as well, for readers that cannot decode. Nothing that can needs
/// their bytes, and they may be missing.
bool isMeshoptFallback(const Json& buffer) {
  for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const Json* extension = findExtension(buffer, name);
    if (extension != nullptr && extension->is_object() && extension->value("fallback", Json(false)) == Json(true)) {
      return true;
    }
  }
  return false;
}

Buffer loadBuffer(const JsonView& entry, std::size_t index, std::optional<std::span<const std::byte>> bin,
                  const Opener& open) {
  const std::uint64_t length = entry["byteLength"].asUint();
  Buffer buffer;
  std::string origin;
  if (const auto uri = entry.find("uri")) {
    const std::string text = uri->asString();
    if (isDataUri(text)) {
      buffer.source = Buffer::Source::kDataUri;
      buffer.bytes = decodeDataUri(text, uri->pointer());
      origin = "data URI";
    } else {
      try {
        buffer.bytes = open(text, uri->pointer());
      } catch (const Fault& fault) {
        if (fault.failure().kind != FailureKind::kIo || !isMeshoptFallback(entry.json())) throw;
        buffer.source = Buffer::Source::kPlaceholder;
        return buffer;
      }
      buffer.source = Buffer::Source::kFile;
      origin = text;
    }
  } else if (index == 0 && bin) {
    buffer.source = Buffer::Source::kGlbChunk;
    buffer.bytes.assign(bin->begin(), bin->end());
    origin = "BIN chunk";
  } else {
    // Without a URI the bytes come from elsewhere; whoever needs them will say that they are missing.
    buffer.source = Buffer::Source::kPlaceholder;
    return buffer;
  }
  if (buffer.bytes.size() < length) {
    failInvalid(entry.pointer() + "/byteLength", "found " + std::to_string(length) + ", expected at most " +
                                                     std::to_string(buffer.bytes.size()) + ", the size of the " +
                                                     origin);
  }
  buffer.bytes.resize(length);
  return buffer;
}

void checkVersion(const Json& document) {
  const JsonView asset = JsonView(document)["asset"];
  const std::string version = asset["version"].asString();
  if (version.substr(0, 2) != "2.") {
    fail(FailureKind::kUnsupported, "/asset/version", "found glTF version " + version.substr(0, 20) + ", expected 2.0");
  }
  if (const auto minimum = asset.find("minVersion"); minimum && minimum->asString() != "2.0") {
    fail(FailureKind::kUnsupported, "/asset/minVersion",
         "found " + minimum->asString().substr(0, 20) + ", expected 2.0");
  }
}

void loadContent(Asset& asset, std::span<const std::byte> bytes, const Opener& open) {
  if (bytes.empty()) failInvalid("", "found nothing at all, expected a glTF document or a GLB file");
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::optional<std::span<const std::byte>> bin;
  if (isGlb(bytes)) {
    Glb glb = parseGlb(bytes);
    asset.is_glb = true;
    asset.extra_chunks = std::move(glb.extra_chunks);
    text = glb.json;
    bin = glb.bin;
  }
  asset.document = parseJson(text, asset.options.limits.max_json_depth);
  checkVersion(asset.document);
  const std::size_t count = countOf(asset.document, "buffers");
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < count; ++i) {
    asset.buffers.push_back(loadBuffer(elementOf(asset.document, "buffers", i), i, bin, open));
    total += asset.buffers.back().bytes.size();
    if (total > asset.options.limits.max_input_bytes) {
      failInvalid("/buffers", "larger than " + std::to_string(asset.options.limits.max_input_bytes) +
                                  " bytes together, the limit for input");
    }
  }
}

}  // namespace

Expected<Asset> loadAsset(const std::filesystem::path& path, const LoadOptions& options) {
  Expected<std::vector<std::byte>> bytes = readFile(path, options.limits.max_input_bytes);
  if (!bytes) return bytes.failure();
  return guarded(path.string(), [&] {
    Asset asset;
    asset.name = path.string();
    asset.folder = path.parent_path();
    asset.options = options;
    loadContent(asset, *bytes, [&](std::string_view uri, std::string_view place) {
      const std::filesystem::path file = resolveUri(uri, asset.folder, options.allow_external, place);
      Expected<std::vector<std::byte>> content = readFile(file, options.limits.max_input_bytes);
      if (!content) fail(content.failure().kind, place, content.failure().message);
      return *std::move(content);
    });
    return asset;
  });
}

Expected<Asset> loadAsset(std::span<const std::byte> bytes, std::string_view name, const UriResolver& resolver,
                          const LoadOptions& options) {
  return guarded(name, [&] {
    Asset asset;
    asset.name = name;
    asset.options = options;
    loadContent(asset, bytes, [&](std::string_view uri, std::string_view place) {
      std::optional<std::vector<std::byte>> content;
      if (resolver) content = resolver(percentDecode(uri));
      if (!content)
        fail(FailureKind::kIo, place, "nothing is known of the file \"" + std::string(uri.substr(0, 80)) + "\"");
      return *std::move(content);
    });
    return asset;
  });
}

}  // namespace tsc
