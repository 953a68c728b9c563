// See conformance_rules.h: the buffers in which compressed views lie.
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "conformance_rules.h"
#include "data_access.h"

namespace tsc {
namespace {

bool isMarked(const JsonView& buffer) {
  const Json* extension = findExtension(buffer.json(), kExtensionName);
  if (extension == nullptr) return false;
  const JsonView json(*extension, buffer.pointer() + "/extensions/" + std::string(kExtensionName));
  const std::optional<JsonView> fallback = json.find("fallback");
  return fallback && fallback->asBool();
}

/// 10, for a view in a buffer without bytes.
void checkPlaceholder(const Asset& asset, const PackedView& packed, std::uint64_t index, std::uint64_t offset) {
  const JsonView buffer = elementOf(asset.document, "buffers", index);
  const std::string because = "for " + viewPlace(packed.view) + " lies in it and it has no bytes";
  if (!isMarked(buffer)) {
    failInvalid(buffer.pointer(),
                "found no \"fallback\": true of " + std::string(kExtensionName) + ", expected it, " + because);
  }
  if (asset.is_glb && index == 0) {
    failInvalid(buffer.pointer(), "found the first buffer of a GLB file, expected a later one, " + because);
  }
  const std::uint64_t size = buffer["byteLength"].asUint();
  if (offset > size || packed.byte_length > size - offset) {
    failInvalid(buffer.pointer() + "/byteLength", "found " + number(size) + ", expected enough for " +
                                                      viewPlace(packed.view) + ": bytes " + number(offset) + " to " +
                                                      number(offset) + " + " + number(packed.byte_length));
  }
}

}  // namespace

bool hasNoBytes(const Asset& asset, std::uint64_t buffer) {
  return buffer < asset.buffers.size() && asset.buffers[buffer].source == Buffer::Source::kPlaceholder;
}

void checkPlaces(const Asset& asset, const std::vector<PackedStream>& streams) {
  std::vector<std::tuple<std::uint64_t, std::uint64_t, std::uint64_t, std::size_t>> ranges;  // buffer, begin, end, view
  bool required = false;
  for (const PackedStream& stream : streams) {
    for (const PackedView& packed : stream.views) {
      const JsonView view = elementOf(asset.document, "bufferViews", packed.view);
      const std::uint64_t buffer = view["buffer"].asUint(), offset = view.uintOr("byteOffset", 0);
      if (hasNoBytes(asset, buffer)) {
        if (!required)
          expectListed(asset.document, "extensionsRequired", view.pointer() + " has no bytes in the asset");
        required = true;  // looked up once, for the list may be long
        checkPlaceholder(asset, packed, buffer, offset);
      } else {
        bufferRange(asset, buffer, offset, packed.byte_length, view.pointer());
      }
      if (packed.byte_length > 0) ranges.emplace_back(buffer, offset, offset + packed.byte_length, packed.view);
    }
  }
  std::sort(ranges.begin(), ranges.end());
  for (std::size_t i = 1; i < ranges.size(); ++i) {
    const auto& [before_buffer, before_begin, before_end, before] = ranges[i - 1];
    const auto& [buffer, begin, end, view] = ranges[i];
    if (buffer != before_buffer || begin >= before_end) continue;
    failInvalid(viewPlace(view) + "/byteOffset", "found " + number(begin) + ", expected " + number(before_end) +
                                                     " or more, where " + viewPlace(before) + " ends in buffer " +
                                                     number(buffer));
  }
}

void checkMarkedBuffers(const Json& document) {
  std::vector<bool> marked;
  for (std::size_t i = 0; i < countOf(document, "buffers"); ++i) {
    marked.push_back(isMarked(elementOf(document, "buffers", i)));
  }
  const auto check = [&](const JsonView& range) {
    const auto buffer = range.find("buffer");
    const auto index = buffer ? wholeNumber(buffer->json()) : std::nullopt;
    if (!index || *index >= marked.size() || !marked[*index]) return;
    failInvalid(buffer->pointer(), "found " + number(*index) +
                                       ", which is marked as fallback, expected another buffer for a view without " +
                                       std::string(kExtensionName));
  };
  for (std::size_t i = 0; i < countOf(document, "bufferViews"); ++i) {
    const JsonView view = elementOf(document, "bufferViews", i);
    if (findExtension(view.json(), kExtensionName) != nullptr) continue;
    check(view);
    for (const std::string_view name : kMeshoptNames) {
      const Json* range = findExtension(view.json(), name);
      if (range != nullptr) check(JsonView(*range, view.pointer() + "/extensions/" + std::string(name)));
    }
  }
}

}  // namespace tsc
