// Saving an asset: which buffer becomes the BIN chunk or a file, which external files travel along.
#include <map>
#include <set>

#include "container.h"
#include "fault.h"
#include "file_io.h"
#include "json_document.h"
#include "references.h"

namespace tsc {
namespace fs = std::filesystem;
namespace {

using Source = Buffer::Source;

constexpr int kGltfIndent = 2;

/// Whether a buffer still is what its URI says.
bool isAtItsUri(const Buffer& buffer) {
  return !buffer.modified && (buffer.source == Source::kFile || buffer.source == Source::kDataUri);
}

/// Whether a GLB must carry the buffer: it is stored nowhere else, or the asset becomes a GLB for the first time.
bool belongsInGlb(const Asset& asset, const Buffer& buffer) {
  if (buffer.source == Source::kPlaceholder) return false;
  return !asset.is_glb || !isAtItsUri(buffer);
}

/// Whether an entry says nothing but where its bytes are, so that it can melt into another buffer.
bool isBare(const Json& entry) {
  for (const auto& [key, value] : entry.items()) {
    if (key != "byteLength" && key != "uri") return false;
  }
  return true;
}

struct GlbContent {
  Json document;
  std::optional<std::vector<std::byte>> bin;
};

/// Gathers the buffers that a GLB carries in one BIN chunk, which must be buffer 0. A buffer with properties of its own
/// keeps its entry, as a data URI.
GlbContent gatherForGlb(const Asset& asset) {
  GlbContent content{asset.document, std::nullopt};
  std::vector<std::size_t> embedded;
  for (std::size_t i = 0; i < asset.buffers.size(); ++i) {
    if (belongsInGlb(asset, asset.buffers[i])) embedded.push_back(i);
  }
  if (embedded.empty()) return content;  // a GLB without BIN chunk
  Json& entries = content.document["buffers"];
  std::vector<BufferMove> moves(asset.buffers.size());
  Json new_entries = Json::array();
  new_entries.push_back(entries[embedded.front()]);
  std::vector<std::byte> bin = asset.buffers[embedded.front()].bytes;
  moves[embedded.front()] = {0, 0};
  for (std::size_t i = 0; i < asset.buffers.size(); ++i) {
    if (i == embedded.front()) continue;
    const Buffer& buffer = asset.buffers[i];
    if (belongsInGlb(asset, buffer) && isBare(entries[i])) {
      bin.resize((bin.size() + 7) / 8 * 8);
      moves[i] = {0, bin.size()};
      bin.insert(bin.end(), buffer.bytes.begin(), buffer.bytes.end());
      continue;
    }
    moves[i] = {new_entries.size(), 0};
    new_entries.push_back(entries[i]);
    if (belongsInGlb(asset, buffer)) new_entries.back()["uri"] = encodeDataUri(buffer.bytes);
  }
  new_entries[0].erase("uri");
  if (new_entries[0]["byteLength"] != bin.size()) new_entries[0]["byteLength"] = bin.size();
  entries = std::move(new_entries);
  moveBuffers(content.document, moves);
  content.bin = std::move(bin);
  return content;
}

std::vector<std::byte> makeGlb(const Asset& asset) {
  const GlbContent content = gatherForGlb(asset);
  const std::string json = writeJson(content.document);
  std::optional<std::span<const std::byte>> bin;
  if (content.bin) bin = *content.bin;
  return buildGlb(json, bin, asset.extra_chunks);
}

/// Relative URIs of files that the document names, wherever it does, except those of `skipped` buffers.
void collectUris(const Json& value, const std::string& key, std::set<std::string>& uris) {
  if (value.is_string()) {
    const bool names_file = key == "uri" || key == "schemaUri";
    if (names_file && !isDataUri(value.get_ref<const std::string&>())) uris.insert(value.get<std::string>());
  } else if (value.is_structured()) {
    for (const auto& [name, member] : value.items()) collectUris(member, name, uris);
  }
}

bool sameFolder(const fs::path& a, const fs::path& b) {
  return fs::weakly_canonical(a.empty() ? "." : a) == fs::weakly_canonical(b.empty() ? "." : b);
}

/// Adds the external files that `document` names to the batch, where the output lies in another folder.
void copyExternalFiles(const Asset& asset, const Json& document, const fs::path& folder,
                       const std::set<std::string>& own_files, bool force, FileBatch& batch) {
  const bool from_memory = asset.folder.empty() && asset.name.find('/') == std::string::npos && !fs::exists(asset.name);
  if (from_memory || sameFolder(asset.folder, folder)) return;
  std::set<std::string> uris;
  collectUris(document, "", uris);
  for (const std::string& uri : uris) {
    if (own_files.count(uri) > 0) continue;
    fs::path source;
    try {
      source = resolveUri(uri, asset.folder, /*allow_external=*/false, "");
    } catch (const Fault&) {
      // A web address stays valid anywhere. A path that leaves the folder cannot be carried to another one.
      if (uri.find("://") != std::string::npos) continue;
      fail(FailureKind::kUsage, "",
           "the asset names \"" + uri + "\" outside its folder; write the output into " +
               (asset.folder.empty() ? std::string(".") : asset.folder.string()));
    }
    std::error_code ignored;
    if (!fs::is_regular_file(source, ignored)) continue;  // the input lacked it as well
    const std::vector<std::byte> bytes = valueOrRaise(readFile(source, asset.options.limits.max_input_bytes));
    const fs::path target = folder / fs::relative(source, asset.folder.empty() ? "." : asset.folder);
    if (fs::exists(target, ignored)) {
      const Expected<std::vector<std::byte>> present = readFile(target, bytes.size());
      if (present && *present == bytes) continue;
    }
    fs::create_directories(target.parent_path());
    batch.add(target, bytes, force);
  }
}

/// Gives each buffer that has no valid URI a file beside the document.
Json placeBuffers(const Asset& asset, const fs::path& path, bool force, FileBatch& batch,
                  std::set<std::string>& own_files) {
  Json document = asset.document;
  std::size_t files = 0;
  for (std::size_t i = 0; i < asset.buffers.size(); ++i) {
    const Buffer& buffer = asset.buffers[i];
    if (buffer.source == Source::kPlaceholder || isAtItsUri(buffer)) continue;
    const std::string name = path.stem().string() + (files == 0 ? std::string() : '_' + std::to_string(files)) + ".bin";
    ++files;
    document["buffers"][i]["uri"] = percentEncode(name);
    own_files.insert(percentEncode(name));
    batch.add(path.parent_path() / name, buffer.bytes, force);
  }
  return document;
}

void save(const Asset& asset, const fs::path& path, const SaveOptions& options) {
  const std::string extension = lowerExtension(path);
  FileBatch batch;
  std::set<std::string> own_files;
  if (extension == ".gltf") {
    if (!asset.extra_chunks.empty()) {
      fail(FailureKind::kUnsupported, "", "the input has GLB chunks that only a .glb file can hold");
    }
    const Json document = placeBuffers(asset, path, options.force, batch, own_files);
    copyExternalFiles(asset, document, path.parent_path(), own_files, options.force, batch);
    const std::string text = writeJson(document, kGltfIndent) + "\n";
    batch.add(path, std::as_bytes(std::span(text)), options.force);
  } else if (extension == ".glb") {
    copyExternalFiles(asset, gatherForGlb(asset).document, path.parent_path(), own_files, options.force, batch);
    batch.add(path, makeGlb(asset), options.force);
  } else {
    fail(FailureKind::kUsage, path.string(), "found the extension \"" + extension + "\", expected .gltf or .glb");
  }
  batch.commit();
}

}  // namespace

Outcome saveAsset(const Asset& asset, const fs::path& path, const SaveOptions& options) {
  return guardedOutcome("", [&] { save(asset, path, options); });
}

Expected<std::vector<std::byte>> writeGlb(const Asset& asset) {
  return guarded(asset.name, [&] { return makeGlb(asset); });
}

}  // namespace tsc
