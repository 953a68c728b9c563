// See conformance.h. Numbers in comments are those of the rules.
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
#include <tuple>

#include "compressed_input.h"
#include "data_access.h"
#include "fault.h"
#include "json_document.h"
#include "mesh_groups.h"
#include "stream_check.h"

namespace tsc {
namespace {

constexpr std::uint64_t kArrayBuffer = 34962;
constexpr std::uint64_t kElementArrayBuffer = 34963;
constexpr std::string_view kDraco = "KHR_draco_mesh_compression";
constexpr std::array kMeshoptNames = {std::string_view("EXT_meshopt_compression"),
                                      std::string_view("KHR_meshopt_compression")};

std::string number(std::uint64_t value) { return std::to_string(value); }

std::string viewPlace(std::size_t view) { return "/bufferViews/" + number(view); }

/// The glTF number of a component type.
std::uint32_t glType(ComponentType type) {
  constexpr std::array<std::uint32_t, 6> kTypes = {kGlByte,          kGlUnsignedByte, kGlShort,
                                                   kGlUnsignedShort, kGlUnsignedInt,  kGlFloat};
  return kTypes[static_cast<std::size_t>(type)];
}

bool isPositions(const OutputInfo& output) { return output.kind == OutputInfo::Kind::kPositions; }

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

// ---------------------------------------------------------------------------------------- Declarations, stream views

/// 1. `cause`: what makes it necessary.
void expectListed(const Json& document, const char* list, const std::string& cause) {
  const std::optional<JsonView> names = JsonView(document).find(list);
  for (std::size_t i = 0; names && i < names->size(); ++i) {
    if (names->at(i).json() == kExtensionName) return;
  }
  failInvalid("/" + std::string(list), "found no \"" + std::string(kExtensionName) + "\", expected it, for " + cause);
}

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

// ---------------------------------------------------------------------------------------------------------- Buffers

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

bool hasNoBytes(const Asset& asset, std::uint64_t buffer) {
  return buffer < asset.buffers.size() && asset.buffers[buffer].source == Buffer::Source::kPlaceholder;
}

/// 10: where compressed views lie; 1.
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

/// 11.
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

// ------------------------------------------------------------------------------------------ Accessors and primitives

/// What a compressed view stands for.
struct Compressed {
  PackedStream* stream = nullptr;  ///< none: a plain view
  std::size_t output = 0;
  const OutputInfo& info() const { return stream->info.outputs[output]; }
};

/// By accessor. What has no compressed view, or none that exists, is plain and none of our business.
std::vector<Compressed> compressedAccessors(const Json& document, std::vector<PackedStream>& streams) {
  std::vector<Compressed> by_view(countOf(document, "bufferViews"));
  for (PackedStream& stream : streams) {
    for (const PackedView& view : stream.views) by_view[view.view] = {&stream, view.output};
  }
  std::vector<Compressed> by_accessor(countOf(document, "accessors"));
  for (std::size_t i = 0; i < by_accessor.size(); ++i) {
    const std::optional<JsonView> view = elementOf(document, "accessors", i).find("bufferView");
    const auto index = view ? wholeNumber(view->json()) : std::nullopt;
    if (index && *index < by_view.size()) by_accessor[i] = by_view[*index];
  }
  return by_accessor;
}

/// 7.
void checkAccessor(const JsonView& accessor, const OutputInfo& output) {
  const std::string why = "that of the decoded array";
  for (const auto& [key, expected] :
       {std::pair("componentType", std::uint64_t{glType(output.type)}), std::pair("count", output.count)}) {
    static_cast<void>(accessor[key]);  // required
    expectIfDefined(accessor, key, expected, why);
  }
  const std::string type = isPositions(output) ? "VEC3" : "SCALAR";
  if (accessor["type"].asString() != type) {
    failInvalid(accessor.pointer() + "/type",
                "found " + brief(accessor["type"].json()) + ", expected \"" + type + "\", " + why);
  }
  expectIfDefined(accessor, "byteOffset", 0, "for a compressed buffer view is one array");
  expectUndefined(accessor, "sparse", "on a compressed buffer view");
}

class PrimitiveCheck {
 public:
  explicit PrimitiveCheck(const std::vector<Compressed>& accessors) : accessors_(accessors) {}

  /// 9 and the exclusions. POSITION accessors on compressed views are noted in their streams.
  void check(const JsonView& primitive) const {
    const std::optional<JsonView> attributes = primitive.find("attributes");
    const std::optional<JsonView> position = attributes ? attributes->find("POSITION") : std::nullopt;
    const std::optional<JsonView> indices = primitive.find("indices");
    const Compressed positions = position ? find(position->json()) : Compressed{};
    const Compressed triangles = indices ? find(indices->json()) : Compressed{};
    if (findExtension(primitive.json(), kDraco) != nullptr) checkDraco(primitive);
    if (positions.stream != nullptr && isPositions(positions.info())) {
      positions.stream->positions.push_back({*wholeNumber(position->json()), positions.output});
    }
    if (triangles.stream == nullptr) return;
    if (isPositions(triangles.info())) {
      failInvalid(indices->pointer(), "found " + number(*wholeNumber(indices->json())) +
                                          ", an accessor of decoded positions, expected one of indices");
    }
    expectIfDefined(primitive, "mode", kTriangles, "for its indices are compressed triangles");
    const std::uint32_t table = triangles.info().table;
    if (positions.stream == triangles.stream && positions.output == table) return;
    failInvalid(attributes ? attributes->pointer() + "/POSITION" : primitive.pointer() + "/attributes",
                (position ? "found " + brief(position->json()) : "missing") + ", expected an accessor of output " +
                    number(table) + " of the stream in " + viewPlace(triangles.stream->view) +
                    ", whose vertices the indices name");
  }

 private:
  Compressed find(const Json& accessor) const {
    const auto index = wholeNumber(accessor);
    return index && *index < accessors_.size() ? accessors_[*index] : Compressed{};
  }

  void checkDraco(const JsonView& primitive) const {
    const auto refuse = [&](const Json& accessor, const std::string& what) {
      if (find(accessor).stream == nullptr) return;
      failInvalid(primitive.pointer() + "/extensions/" + std::string(kDraco),
                  "found beside " + what + " on a buffer view with " + std::string(kExtensionName) +
                      ", expected one of the two");
    };
    if (const auto indices = primitive.find("indices")) refuse(indices->json(), "indices");
    std::vector<JsonView> lists;
    if (const auto attributes = primitive.find("attributes")) lists.push_back(*attributes);
    const std::optional<JsonView> targets = primitive.find("targets");
    for (std::size_t i = 0; targets && i < targets->size(); ++i) lists.push_back(targets->at(i));
    for (const JsonView& list : lists) {
      for (const auto& [name, accessor] : list.asObject().items()) refuse(accessor, name);
    }
  }

  const std::vector<Compressed>& accessors_;
};

void checkUses(const Json& document, std::vector<PackedStream>& streams) {
  const std::vector<Compressed> accessors = compressedAccessors(document, streams);
  for (std::size_t i = 0; i < accessors.size(); ++i) {
    if (accessors[i].stream != nullptr) checkAccessor(elementOf(document, "accessors", i), accessors[i].info());
  }
  const PrimitiveCheck primitive_check(accessors);
  for (std::size_t m = 0; m < countOf(document, "meshes"); ++m) {
    const std::optional<JsonView> primitives = elementOf(document, "meshes", m).find("primitives");
    for (std::size_t p = 0; primitives && p < primitives->size(); ++p) primitive_check.check(primitives->at(p));
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
    if (!info) failInvalid(viewPlace(stream.view), describe(info.error()));
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
