// See compare_assets.h.
#include "compare_assets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "json_document.h"
#include "mesh_groups.h"

namespace tsc::test {
namespace {

std::array<float, 3> positionAt(const std::vector<std::byte>& elements, const AccessorInfo& info, std::size_t i) {
  std::array<float, 3> out{};
  const std::byte* at = elements.data() + i * info.element_bytes;
  for (std::size_t axis = 0; axis < 3; ++axis, at += info.component_bytes) {
    switch (info.component_type) {
      case kGlByte: out[axis] = static_cast<float>(std::to_integer<std::int8_t>(*at)); break;
      case kGlUnsignedByte: out[axis] = static_cast<float>(std::to_integer<std::uint8_t>(*at)); break;
      case kGlShort: {
        std::int16_t value;
        std::memcpy(&value, at, 2);
        out[axis] = value;
        break;
      }
      case kGlUnsignedShort: {
        std::uint16_t value;
        std::memcpy(&value, at, 2);
        out[axis] = value;
        break;
      }
      default: std::memcpy(&out[axis], at, 4);
    }
  }
  return out;
}

PrimitiveContent readPrimitive(const PrimitiveInfo& info, DataAccess& data) {
  PrimitiveContent content;
  content.mode = info.isTriangles() ? std::uint32_t{kTriangles} : info.mode;
  const AccessorInfo position = data.accessor(*info.position);
  std::vector<std::uint32_t> ids(position.count);
  for (const AttributeUse& use : info.attributes) {
    if (use.name != "_TEST_ID") continue;
    const std::vector<std::byte> bytes = data.elements(data.accessor(use.accessor));
    for (std::size_t i = 0; i < ids.size(); ++i) {
      float id;
      std::memcpy(&id, bytes.data() + 4 * i, 4);
      ids[i] = static_cast<std::uint32_t>(id);
    }
  }
  const std::vector<std::byte> positions = data.elements(position);
  for (std::size_t i = 0; i < ids.size(); ++i) content.positions[ids[i]] = positionAt(positions, position, i);
  for (const AttributeUse& use : info.attributes) {
    const AccessorInfo accessor = data.accessor(use.accessor);
    const std::vector<std::byte> bytes = data.elements(accessor);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      content.attributes[ids[i]] +=
          use.name + (use.target ? std::to_string(*use.target) : "") + "=" +
          std::string(reinterpret_cast<const char*>(bytes.data()) + i * accessor.element_bytes, accessor.element_bytes);
    }
  }
  std::vector<std::uint32_t> sequence(position.count);
  std::iota(sequence.begin(), sequence.end(), 0U);
  if (info.indices) sequence = data.indices(data.accessor(*info.indices));
  if (info.isTriangles()) {
    const std::vector<std::uint32_t> triangles = toTriangles(info.mode, sequence);
    for (std::size_t i = 0; i + 2 < triangles.size(); i += 3) {
      std::array<std::uint32_t, 3> t{ids[triangles[i]], ids[triangles[i + 1]], ids[triangles[i + 2]]};
      const auto smallest = [](const auto& a) { return std::min_element(a.begin(), a.end()) - a.begin(); };
      std::rotate(t.begin(), t.begin() + smallest(t), t.end());
      if (t[0] == t[2]) t = {t[0], t[0], t[1]};  // of a degenerate one, one rotation
      content.triangles.push_back(t);
    }
    std::sort(content.triangles.begin(), content.triangles.end());
  } else {
    for (const std::uint32_t index : sequence) content.elements.push_back(ids.at(index));
    if (info.mode == kPoints && !info.indices) std::sort(content.elements.begin(), content.elements.end());
  }
  return content;
}

}  // namespace

void addVertexIds(Asset& asset) {
  std::map<std::size_t, std::size_t> id_accessors;  // by POSITION accessor
  Json& document = asset.document;
  Buffer ids;
  ids.modified = true;
  const std::size_t buffer = asset.buffers.size();
  for (std::size_t m = 0; m < countOf(document, "meshes"); ++m) {
    for (Json& primitive : document["meshes"][m]["primitives"]) {
      if (!primitive["attributes"].contains("POSITION")) continue;
      const std::size_t position = primitive["attributes"]["POSITION"];
      if (id_accessors.count(position) == 0) {
        const std::size_t count = document["accessors"][position]["count"];
        const std::size_t offset = ids.bytes.size();
        for (std::size_t i = 0; i < count; ++i) {
          const float id = static_cast<float>(i);
          const auto* bytes = reinterpret_cast<const std::byte*>(&id);
          ids.bytes.insert(ids.bytes.end(), bytes, bytes + 4);
        }
        document["bufferViews"].push_back({{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", count * 4}});
        document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                         {"componentType", kGlFloat},
                                         {"count", count},
                                         {"type", "SCALAR"}});
        id_accessors[position] = document["accessors"].size() - 1;
      }
      primitive["attributes"]["_TEST_ID"] = id_accessors[position];
    }
  }
  if (ids.bytes.empty()) return;
  document["buffers"].push_back({{"byteLength", ids.bytes.size()}});
  asset.buffers.push_back(std::move(ids));
}

std::vector<PrimitiveContent> contentOf(const Asset& asset) {
  DataAccess data(asset);
  const MeshSurvey survey = surveyMeshes(asset, data);
  std::vector<PrimitiveContent> contents;
  for (const PrimitiveInfo& info : survey.primitives) {
    if (!info.position) continue;
    const AccessorInfo position = data.accessor(*info.position);
    if (!position.view && !position.sparse && !data.hasOverlay(*info.position)) continue;
    contents.push_back(readPrimitive(info, data));
  }
  return contents;
}

void expectSame(const Asset& before, const Asset& after, double bound) {
  const std::vector<PrimitiveContent> a = contentOf(before);
  const std::vector<PrimitiveContent> b = contentOf(after);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t p = 0; p < a.size(); ++p) {
    EXPECT_EQ(a[p].mode, b[p].mode) << "primitive " << p;
    EXPECT_TRUE(a[p].triangles == b[p].triangles) << "triangles of primitive " << p;
    EXPECT_TRUE(a[p].elements == b[p].elements) << "points or lines of primitive " << p;
    EXPECT_TRUE(a[p].attributes == b[p].attributes) << "attributes of primitive " << p;
    ASSERT_EQ(a[p].positions.size(), b[p].positions.size()) << "primitive " << p;
    double largest = 0;
    for (const auto& [id, position] : a[p].positions) {
      const std::array<float, 3>& other = b[p].positions.at(id);
      double square = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        square += std::pow(static_cast<double>(position[axis]) - other[axis], 2);
      }
      largest = std::max(largest, std::sqrt(square));
    }
    EXPECT_LE(largest, bound) << "positions of primitive " << p;
  }
}

void expectWatertight(const Asset& before, const Asset& after) {
  DataAccess data(before);
  const MeshSurvey survey = surveyMeshes(before, data);
  const std::vector<PrimitiveContent> a = contentOf(before);
  const std::vector<PrimitiveContent> b = contentOf(after);
  ASSERT_EQ(a.size(), b.size());
  std::map<std::pair<std::size_t, std::array<float, 3>>, std::array<float, 3>> decoded;  // by mesh and position
  std::size_t p = 0;
  for (const PrimitiveInfo& info : survey.primitives) {
    if (!info.position || p >= a.size()) continue;
    if (!info.isTriangles()) {
      ++p;
      continue;
    }
    for (const auto& [id, position] : a[p].positions) {
      const auto [entry, added] = decoded.emplace(std::pair(info.mesh, position), b[p].positions.at(id));
      if (!added && entry->second != b[p].positions.at(id)) {
        ADD_FAILURE() << "equal positions of mesh " << info.mesh << " decode differently";
        return;
      }
    }
    ++p;
  }
}

}  // namespace tsc::test
