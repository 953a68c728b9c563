// See references.h.
#include "references.h"

#include <algorithm>
#include <array>
#include <string>

#include "fault.h"
#include "json_document.h"

namespace tsc {
namespace {

/// Extensions whose numbers are indices of materials, textures, images, lights, nodes or scenes, or plain values; or
/// whose accessors and buffer views are found by the functions below and in order_extensions.h.
constexpr std::array kIndependentNames = {
    std::string_view("ADOBE_materials_clearcoat_specular"),
    std::string_view("ADOBE_materials_clearcoat_tint"),
    std::string_view("ADOBE_materials_thin_transparency"),
    std::string_view("AGI_articulations"),
    std::string_view("AGI_stk_metadata"),
    std::string_view("CESIUM_RTC"),
    std::string_view("CESIUM_primitive_outline"),
    std::string_view("EXT_instance_features"),
    std::string_view("EXT_lights_ies"),
    std::string_view("EXT_mesh_features"),
    std::string_view("EXT_mesh_gpu_instancing"),
    std::string_view("EXT_mesh_manifold"),
    std::string_view("EXT_mesh_primitive_edge_visibility"),
    std::string_view("EXT_meshopt_compression"),
    std::string_view("EXT_structural_metadata"),
    std::string_view("EXT_texture_astc"),
    std::string_view("EXT_texture_avif"),
    std::string_view("EXT_texture_webp"),
    std::string_view("GOOGLE_texture_basis"),
    std::string_view("GRIFFEL_bim_data"),
    std::string_view("KHR_animation_pointer"),
    std::string_view("KHR_draco_mesh_compression"),
    std::string_view("KHR_lights_punctual"),
    std::string_view("KHR_mesh_quantization"),
    std::string_view("KHR_meshopt_compression"),
    std::string_view("KHR_node_hoverability"),
    std::string_view("KHR_node_selectability"),
    std::string_view("KHR_node_visibility"),
    std::string_view("KHR_techniques_webgl"),
    std::string_view("KHR_texture_basisu"),
    std::string_view("KHR_texture_transform"),
    std::string_view("KHR_xmp"),
    std::string_view("KHR_xmp_json_ld"),
    std::string_view("MSFT_lod"),
    std::string_view("MSFT_packing_normalRoughnessMetallic"),
    std::string_view("MSFT_packing_occlusionRoughnessMetallic"),
    std::string_view("MSFT_screencoverage"),
    std::string_view("MSFT_texture_dds"),
    std::string_view("VRM"),
    std::string_view("VRMC_materials_mtoon"),
    std::string_view("VRMC_node_constraint"),
    std::string_view("VRMC_springBone"),
    std::string_view("VRMC_vrm"),
};

/// Whole families of material extensions. KHR_materials_variants names materials and variants only.
constexpr std::array kIndependentPrefixes = {
    std::string_view("KHR_materials_"), std::string_view("EXT_materials_"), std::string_view("BENTLEY_materials_"),
    std::string_view("MSFT_material"),  std::string_view("EXT_lights_"),
};

void visitKeys(Json& value, std::string_view wanted, const std::function<void(Json&)>& visit) {
  if (!value.is_structured()) return;
  if (value.is_array()) {
    for (Json& element : value) visitKeys(element, wanted, visit);
    return;
  }
  for (auto& [key, member] : value.items()) {
    if (key == "extras") continue;
    if (key == wanted && wholeNumber(member)) {
      visit(member);
    } else {
      visitKeys(member, wanted, visit);
    }
  }
}

void collectNumbers(const Json& value, std::string_view key, std::set<std::uint64_t>& numbers) {
  if (const auto number = wholeNumber(value)) {
    if (key != "bufferView") numbers.insert(*number);
  } else if (value.is_array()) {
    for (const Json& element : value) collectNumbers(element, key, numbers);
  } else if (value.is_object()) {
    for (const auto& [name, member] : value.items()) collectNumbers(member, name, numbers);
  }
}

void collectUnknown(const Json& value, std::set<std::uint64_t>& numbers) {
  if (value.is_array()) {
    for (const Json& element : value) collectUnknown(element, numbers);
  } else if (value.is_object()) {
    for (const auto& [key, member] : value.items()) {
      if (key == "extras") continue;
      if (key != "extensions" || !member.is_object()) {
        collectUnknown(member, numbers);
        continue;
      }
      for (const auto& [name, extension] : member.items()) {
        if (classify(name) == ExtensionClass::kUnknown) {
          collectNumbers(extension, name, numbers);
        } else {
          collectUnknown(extension, numbers);
        }
      }
    }
  }
}

void insertNumber(const Json& value, std::set<std::uint64_t>& numbers) {
  if (const auto number = wholeNumber(value)) numbers.insert(*number);
}

Json* memberOf(Json& holder, const char* key) {
  if (!holder.is_object()) return nullptr;
  const auto found = holder.find(key);
  return found == holder.end() ? nullptr : &*found;
}

Json* arrayOf(Json& document, const char* key) {
  Json* array = memberOf(document, key);
  return array != nullptr && array->is_array() ? array : nullptr;
}

}  // namespace

ExtensionClass classify(std::string_view extension) {
  if (extension == kExtensionName) return ExtensionClass::kIndependent;
  const bool named =
      std::find(kIndependentNames.begin(), kIndependentNames.end(), extension) != kIndependentNames.end();
  const bool in_family =
      std::any_of(kIndependentPrefixes.begin(), kIndependentPrefixes.end(),
                  [&](std::string_view prefix) { return extension.substr(0, prefix.size()) == prefix; });
  return named || in_family ? ExtensionClass::kIndependent : ExtensionClass::kUnknown;
}

void visitBufferViewReferences(Json& document, const std::function<void(Json&)>& visit) {
  visitKeys(document, "bufferView", visit);
  Json* extensions = memberOf(document, "extensions");
  Json* metadata = extensions != nullptr ? memberOf(*extensions, "EXT_structural_metadata") : nullptr;
  Json* tables = metadata != nullptr ? arrayOf(*metadata, "propertyTables") : nullptr;
  if (tables == nullptr) return;
  for (Json& table : *tables) {
    Json* properties = memberOf(table, "properties");
    if (properties == nullptr || !properties->is_object()) continue;
    for (auto& [name, property] : properties->items()) {
      for (const char* key : {"values", "arrayOffsets", "stringOffsets"}) {
        Json* index = memberOf(property, key);
        if (index != nullptr && wholeNumber(*index)) visit(*index);
      }
    }
  }
}

std::set<std::uint64_t> unknownNumbers(const Json& value) {
  std::set<std::uint64_t> numbers;
  collectUnknown(value, numbers);
  return numbers;
}

std::set<std::uint64_t> accessorsOutsideMeshes(const Json& document) {
  std::set<std::uint64_t> accessors;
  for (std::size_t i = 0; i < countOf(document, "animations"); ++i) {
    const JsonView animation = elementOf(document, "animations", i);
    const auto samplers = animation.find("samplers");
    for (std::size_t k = 0; samplers && k < samplers->size(); ++k) {
      for (const char* key : {"input", "output"}) {
        if (const auto index = samplers->at(k).find(key)) insertNumber(index->json(), accessors);
      }
    }
  }
  for (std::size_t i = 0; i < countOf(document, "skins"); ++i) {
    if (const auto index = elementOf(document, "skins", i).find("inverseBindMatrices")) {
      insertNumber(index->json(), accessors);
    }
  }
  for (std::size_t i = 0; i < countOf(document, "nodes"); ++i) {
    const Json* instancing = findExtension(elementOf(document, "nodes", i).json(), "EXT_mesh_gpu_instancing");
    if (instancing == nullptr || !instancing->is_object() || !instancing->contains("attributes")) continue;
    for (const Json& index : (*instancing)["attributes"]) insertNumber(index, accessors);
  }
  return accessors;
}

void visitBufferRanges(Json& document, const std::function<void(Json&, std::size_t)>& visit) {
  Json* views = arrayOf(document, "bufferViews");
  if (views == nullptr) return;
  for (std::size_t i = 0; i < views->size(); ++i) {
    Json& view = (*views)[i];
    if (!view.is_object()) continue;
    visit(view, i);
    Json* extensions = memberOf(view, "extensions");
    if (extensions == nullptr) continue;
    for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
      Json* range = memberOf(*extensions, name);
      if (range != nullptr && range->is_object()) visit(*range, i);
    }
  }
}

void moveBuffers(Json& document, const std::vector<BufferMove>& moves) {
  visitBufferRanges(document, [&](Json& range, std::size_t view) {
    const JsonView place(range, "/bufferViews/" + std::to_string(view));
    const std::uint64_t old = place["buffer"].asUint();
    if (old >= moves.size()) {
      failInvalid(place.pointer() + "/buffer",
                  "found " + std::to_string(old) + ", expected one below " + std::to_string(moves.size()));
    }
    const BufferMove& move = moves[old];
    if (move.buffer != old) range["buffer"] = move.buffer;
    if (move.offset != 0) range["byteOffset"] = place.uintOr("byteOffset", 0) + move.offset;
  });
}

}  // namespace tsc
