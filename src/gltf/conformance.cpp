// See conformance.h and conformance_rules.h: declarations, compressed views and the views that hold streams, and the
// decoded arrays. Numbers in comments are those of the rules.
#include "conformance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>

#include "conformance_rules.h"
#include "data_access.h"
#include "references.h"
#include "stream_check.h"

namespace tsc {
namespace {

// ---------------------------------------------------------------------------------------- Declarations, stream views

void checkDeclared(const Json& document) {
  for (const char* key : {"bufferViews", "buffers"}) {
    for (std::size_t i = 0; i < countOf(document, key); ++i) {
      const JsonView holder = elementOf(document, key, i);
      if (findExtension(holder.json(), kExtensionName) == nullptr) continue;
      expectListed(document, "extensionsUsed", holder.pointer() + " has it");
      return;
    }
  }
}

/// Whether a number under `key` of the object at `place` is the index of a buffer view, as in references.h.
bool namesView(std::string_view place, std::string_view key) {
  if (key == "bufferView") return true;
  return place.starts_with("/extensions/EXT_structural_metadata/propertyTables/") &&
         (key == "values" || key == "arrayOffsets" || key == "stringOffsets");
}

/// Calls `visit` for everything but compressed views that names a buffer view. `place` points to `value`.
void findReferences(const Json& value, std::string& place,
                    const std::function<void(const std::string& place, std::uint64_t view)>& visit) {
  const std::size_t length = place.size();
  const auto descend = [&](const std::string& step, const Json& member) {
    place += '/';
    place += step;
    findReferences(member, place, visit);
    place.resize(length);
  };
  if (value.is_array()) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (value[i].is_structured()) descend(number(i), value[i]);
    }
  } else if (value.is_object()) {
    for (const auto& [key, member] : value.items()) {
      const auto index = namesView(place, key) ? wholeNumber(member) : std::nullopt;
      if (index) visit(place + "/" + key, *index);
      if (member.is_structured() && key != "extras" && key != kExtensionName) descend(key, member);
    }
  }
}

/// 2, but for the references.
void checkHolder(const Json& document, std::size_t index) {
  const JsonView view = elementOf(document, "bufferViews", index);
  const std::string why = "on a buffer view that holds a stream or an order";
  expectUndefined(view, "byteStride", why);
  expectUndefined(view, "target", why);
  for (const std::string_view name : kMeshoptNames) {
    if (findExtension(view.json(), name) == nullptr) continue;
    failInvalid(view.pointer() + "/extensions/" + std::string(name),
                "found a compressed buffer view, expected a plain one, for it holds a stream or an order");
  }
}

/// 2: streams and orders serve nothing else.
void checkHolders(const Json& document, const std::vector<PackedStream>& streams) {
  std::set<std::uint64_t> holders;
  for (const PackedStream& stream : streams) {
    holders.insert(stream.view);
    if (const auto order = stream.views.front().order) holders.insert(*order);
  }
  for (const std::uint64_t holder : holders) checkHolder(document, holder);
  if (holders.empty()) return;
  std::string root;
  findReferences(document, root, [&](const std::string& place, std::uint64_t view) {
    if (holders.count(view) == 0) return;
    failInvalid(place, "found " + number(view) + ", which holds a stream or an order, expected another buffer view");
  });
}

// ------------------------------------------------------------------------------------------------- Compressed views

/// 4.
void checkOutputs(const PackedStream& stream) {
  std::map<std::size_t, const PackedView*> named;
  for (const PackedView& view : stream.views) {
    if (view.output >= stream.info.outputs.size()) {
      failInvalid(view.place + "/output",
                  "found " + number(view.output) + ", expected one below " + number(stream.info.outputs.size()));
    }
    const auto [first, added] = named.emplace(view.output, &view);
    if (!added) {
      failInvalid(view.place + "/output", "found " + number(view.output) + ", which " + first->second->place +
                                              " names as well, expected each output once");
    }
  }
}

/// 5, 6 and the exclusions.
void checkLayout(const Json& document, const PackedView& packed, const OutputInfo& output) {
  const JsonView view = elementOf(document, "bufferViews", packed.view);
  expectIfDefined(view, "byteLength", output.byte_length, "the length of the decoded array");
  if (isPositions(output)) {
    expectIfDefined(view, "byteStride", output.byte_stride, "the stride of the decoded positions");
    if (output.byte_stride != 3 * componentSize(output.type) && !view.find("byteStride")) {
      failInvalid(view.pointer() + "/byteStride", "missing, expected " + number(output.byte_stride) +
                                                      ", for the decoded positions have bytes between them");
    }
  } else {
    expectUndefined(view, "byteStride", "on a buffer view of indices");
  }
  expectIfDefined(view, "target", isPositions(output) ? kArrayBuffer : kElementArrayBuffer,
                  isPositions(output) ? "for it holds positions" : "for it holds indices");
  for (const std::string_view name : kMeshoptNames) {
    if (findExtension(view.json(), name) == nullptr) continue;
    failInvalid(view.pointer() + "/extensions/" + std::string(name),
                "found beside " + std::string(kExtensionName) + ", expected one of the two");
  }
}

// ---------------------------------------------------------------------------------------------------- Decoded arrays

/// 8, of one of `min` and `max`.
void checkBound(const JsonView& accessor, const char* key, const std::array<float, 3>& expected, bool is_float) {
  const JsonView bound = accessor[key];
  bool fits = bound.size() == 3;
  for (std::size_t axis = 0; fits && axis < 3; ++axis) {
    const Json& value = bound.json()[axis];
    fits = value.is_number();
    if (!fits) break;
    const double found = value.get<double>();
    // Bounds of floats are written as decimals, which readers round to floats. (glTF 2.0, 3.6.2.5)
    fits = is_float && std::abs(found) <= double{std::numeric_limits<float>::max()}
               ? static_cast<float>(found) == expected[axis]
               : found == double{expected[axis]};
  }
  if (fits) return;
  const Json wanted = Json::array({double{expected[0]}, double{expected[1]}, double{expected[2]}});
  failInvalid(bound.pointer(), "found " + writeJson(bound.json()).substr(0, 120) + ", expected " + writeJson(wanted) +
                                   ", the bound of the decoded positions");
}

struct Bounds {
  std::array<float, 3> low{}, high{};
};

Bounds boundsOf(const std::vector<float>& positions) {
  Bounds bounds;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::size_t axis = i % 3;
    bounds.low[axis] = i < 3 ? positions[i] : std::min(bounds.low[axis], positions[i]);
    bounds.high[axis] = i < 3 ? positions[i] : std::max(bounds.high[axis], positions[i]);
  }
  return bounds;
}

/// 12.
void checkFallback(const Asset& asset, const PackedView& packed, const std::vector<std::byte>& decoded) {
  const JsonView view = elementOf(asset.document, "bufferViews", packed.view);
  const std::uint64_t buffer = view["buffer"].asUint();
  if (hasNoBytes(asset, buffer)) return;
  const std::span<const std::byte> stored =
      bufferRange(asset, buffer, view.uintOr("byteOffset", 0), packed.byte_length, view.pointer());
  const auto [found, expected] = std::mismatch(stored.begin(), stored.end(), decoded.begin(), decoded.end());
  if (found == stored.end() && expected == decoded.end()) return;
  const auto at = static_cast<std::uint64_t>(found - stored.begin());
  failInvalid(view.pointer(), "found " + number(std::to_integer<std::uint64_t>(*found)) + " in byte " + number(at) +
                                  " of the fallback data, expected " +
                                  number(std::to_integer<std::uint64_t>(*expected)) + " as in the decoded array");
}

}  // namespace

/// Raises a failure if member `key` of `holder` is there and not `expected`.
void expectIfDefined(const JsonView& holder, const char* key, std::uint64_t expected, const std::string& why) {
  const std::optional<JsonView> member = holder.find(key);
  if (member && member->asUint() != expected) {
    failInvalid(member->pointer(), "found " + brief(member->json()) + ", expected " + number(expected) + ", " + why);
  }
}

void expectUndefined(const JsonView& holder, const char* key, const std::string& why) {
  const std::optional<JsonView> member = holder.find(key);
  if (member) failInvalid(member->pointer(), "found " + brief(member->json()) + ", expected none " + why);
}

void expectListed(const Json& document, const char* list, const std::string& cause) {
  const std::optional<JsonView> names = JsonView(document).find(list);
  for (std::size_t i = 0; names && i < names->size(); ++i) {
    if (names->at(i).json() == kExtensionName) return;
  }
  failInvalid("/" + std::string(list), "found no \"" + std::string(kExtensionName) + "\", expected it, for " + cause);
}

std::vector<PackedStream> checkConformance(const Asset& asset) {
  const Json& document = asset.document;
  checkDeclared(document);
  std::vector<PackedStream> streams;
  for (auto& [view, views] : findPackedViews(document)) streams.push_back({view, views, {}, {}});
  checkHolders(document, streams);
  DataAccess data(asset);
  for (PackedStream& stream : streams) {
    Result<StreamInfo> info =
        readStreamInfo(data.viewBytes(stream.view), DecodeLimits{asset.options.limits.max_output_bytes});
    if (!info) failStream(viewPlace(stream.view), info.error());
    stream.info = *std::move(info);
    checkOutputs(stream);
    for (const PackedView& view : stream.views) checkLayout(document, view, stream.info.outputs[view.output]);
  }
  checkPlaces(asset, streams);
  checkMarkedBuffers(document);
  checkUses(document, streams);
  return streams;
}

void checkDecoded(const Asset& asset, const PackedStream& stream, const std::vector<std::vector<std::byte>>& decoded) {
  for (const PackedView& view : stream.views) checkFallback(asset, view, decoded.at(view.output));
  std::map<std::size_t, Bounds> bounds;  // by output
  for (const PackedPositions& positions : stream.positions) {
    const OutputInfo& output = stream.info.outputs[positions.output];
    const auto [entry, added] = bounds.emplace(positions.output, Bounds{});
    if (added) entry->second = boundsOf(positionsAsFloats(decoded.at(positions.output), output.type));
    const JsonView accessor = elementOf(asset.document, "accessors", positions.accessor);
    if (output.count == 0) continue;
    checkBound(accessor, "min", entry->second.low, output.type == ComponentType::kFloat32);
    checkBound(accessor, "max", entry->second.high, output.type == ComponentType::kFloat32);
  }
}

}  // namespace tsc
