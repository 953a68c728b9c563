// The error as vertex colours of a GLB, for any glTF viewer.
#include <cstring>
#include <nlohmann/json.hpp>

#include "colour_scale.h"
#include "file_bytes.h"
#include "surface_tools.h"

namespace tsc {
namespace {

using nlohmann::ordered_json;

// Values of glTF 2.0.
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;

/// Collects arrays in one buffer, each with its view and accessor.
class Arrays {
 public:
  template <class T>
  std::size_t add(const std::vector<T>& values, int component_type, const char* type, std::size_t components,
                  int target) {
    const std::size_t byte_length = values.size() * sizeof(T);  // of 2- or 4-byte values in even number: aligned
    views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", byte_length}, {"target", target}});
    accessors.push_back({{"bufferView", views.size() - 1},
                         {"componentType", component_type},
                         {"count", values.size() / components},
                         {"type", type}});
    bytes.append(reinterpret_cast<const char*>(values.data()), byte_length);
    return accessors.size() - 1;
  }

  std::string bytes;
  ordered_json views = ordered_json::array();
  ordered_json accessors = ordered_json::array();
};

double linearFromSrgb(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

ordered_json addPrimitive(const NamedSurface& mesh, const std::vector<double>& field, const ColourScale& scale,
                          Arrays& arrays) {
  std::vector<float> positions(mesh.positions.begin(), mesh.positions.end());
  std::vector<std::uint16_t> colours;
  std::array<float, 3> low, high;
  low.fill(std::numeric_limits<float>::max());
  high.fill(std::numeric_limits<float>::lowest());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    // Vertices that no triangle uses may be anything; glTF wants finite numbers.
    if (!std::isfinite(positions[i])) positions[i] = 0;
    low[i % 3] = std::min(low[i % 3], positions[i]);
    high[i % 3] = std::max(high[i % 3], positions[i]);
  }
  for (const double error : field) {
    const glm::dvec3 colour = turbo(scale.share(error));
    for (int k = 0; k < 3; ++k) {
      colours.push_back(static_cast<std::uint16_t>(std::lround(65535 * linearFromSrgb(colour[k]))));
    }
    colours.push_back(65535);
  }
  const std::size_t position = arrays.add(positions, kFloat, "VEC3", 3, kArrayBuffer);
  arrays.accessors[position]["min"] = low;
  arrays.accessors[position]["max"] = high;
  const std::size_t colour = arrays.add(colours, kUnsignedShort, "VEC4", 4, kArrayBuffer);
  arrays.accessors[colour]["normalized"] = true;
  const std::size_t indices = arrays.add(mesh.indices, kUnsignedInt, "SCALAR", 1, kElementArrayBuffer);
  return {{"attributes", {{"POSITION", position}, {"COLOR_0", colour}}}, {"indices", indices}, {"material", 0}};
}

std::string glbOf(const ordered_json& document, std::string binary) {
  std::string text = document.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string glb;
  const auto word = [&](std::size_t value) {
    for (int shift = 0; shift < 32; shift += 8) glb.push_back(static_cast<char>(value >> shift & 0xff));
  };
  glb += "glTF";
  word(2);
  word(12 + 8 + text.size() + 8 + binary.size());
  word(text.size());
  glb += "JSON" + text;
  word(binary.size());
  glb += std::string("BIN\0", 4) + binary;
  return glb;
}

}  // namespace

std::optional<QualityError> writeHeatmapGlb(const std::filesystem::path& path, std::span<const NamedSurface> a,
                                            std::span<const NamedSurface> b, const Comparison& comparison) {
  const auto fields = errorFields(a, b, comparison);
  if (!fields) return fields.error();
  const ColourScale scale(*fields);
  const std::string legend =
      measureName(comparison) + ": dark blue 0, green " + withShare(scale.top / 2, comparison.total.diagonal) +
      ", dark red " + withShare(scale.top, comparison.total.diagonal) + ", largest " + shortNumber(scale.largest);
  Arrays arrays;
  ordered_json document;
  document["asset"] = {{"version", "2.0"}, {"generator", "gltf-tsc compare"}};
  document["scene"] = 0;
  document["scenes"] = {{{"name", legend}, {"nodes", ordered_json::array()}}};
  document["nodes"] = ordered_json::array();
  document["meshes"] = ordered_json::array();
  const auto addNode = [&](ordered_json node) {
    document["scenes"][0]["nodes"].push_back(document["nodes"].size());
    document["nodes"].push_back(std::move(node));
  };
  for (std::size_t i = 0; i < b.size(); ++i) {
    document["meshes"].push_back(
        {{"name", b[i].name + " | " + legend}, {"primitives", {addPrimitive(b[i], (*fields)[i], scale, arrays)}}});
    if (b[i].placements.empty()) addNode({{"name", b[i].name}, {"mesh", i}});
    for (const auto& matrix : b[i].placements) addNode({{"name", b[i].name}, {"mesh", i}, {"matrix", matrix}});
  }
  document["materials"] = {{{"name", legend},
                            {"doubleSided", true},
                            {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}}};
  document["accessors"] = std::move(arrays.accessors);
  document["bufferViews"] = std::move(arrays.views);
  document["buffers"] = {{{"byteLength", arrays.bytes.size()}}};
  return writeFileBytes(path, glbOf(document, std::move(arrays.bytes)));
}

}  // namespace tsc
