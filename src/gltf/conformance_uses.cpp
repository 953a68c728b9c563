// See conformance_rules.h: accessors on compressed views, and the primitives that use them.
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "conformance_rules.h"
#include "data_access.h"
#include "mesh_groups.h"

namespace tsc {
namespace {

constexpr std::string_view kDraco = "KHR_draco_mesh_compression";

/// The glTF number of a component type.
std::uint32_t glType(ComponentType type) {
  constexpr std::array<std::uint32_t, 6> kTypes = {kGlByte,          kGlUnsignedByte, kGlShort,
                                                   kGlUnsignedShort, kGlUnsignedInt,  kGlFloat};
  return kTypes[static_cast<std::size_t>(type)];
}

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

}  // namespace

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

}  // namespace tsc
