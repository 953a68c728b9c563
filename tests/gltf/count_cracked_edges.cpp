// The program of corpus_report.mjs that counts cracks: count_cracked_edges FILE… prints a line of JSON a file.
//
// An edge is shared if triangles of two or more primitives of a mesh have it, that is, edges whose two ends have the
// same bits. It is cracked when after compression its ends no longer have the same bits in all those primitives.
// Counted after packing and unpacking with this library's defaults, and after libdraco, which codes each primitive by
// itself as Draco's own glTF tools do: with its default speed and 14 and 11 bits for positions. Integer positions,
// which Draco codes without loss, are left as they are.
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>

#include <array>
#include <bit>
#include <cstdio>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "assets.h"
#include "compare_assets.h"
#include "data_access.h"
#include "json_document.h"
#include "mesh_groups.h"

namespace tsc::test {
namespace {

using Bits = std::array<std::uint32_t, 3>;
using Triangles = std::vector<std::uint32_t>;
using Positions = std::map<std::uint32_t, Bits>;  ///< by vertex number

struct PrimitiveShape {
  std::size_t mesh = 0;
  bool is_float = true;
  std::vector<Bits> positions;
  Triangles triangles;
};

/// Bits of positions of any type; zeros of both signs are one.
std::vector<Bits> readPositions(const AccessorInfo& info, DataAccess& data) {
  const std::vector<std::byte> bytes = data.elements(info);
  std::vector<Bits> positions(info.count);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint32_t& bits = positions[i][axis];
      std::memcpy(&bits, bytes.data() + i * info.element_bytes + axis * info.component_bytes, info.component_bytes);
      if (info.component_type == kGlFloat && bits == 0x80000000U) bits = 0;
    }
  }
  return positions;
}

/// The triangle primitives whose positions are in the asset.
std::vector<PrimitiveShape> shapesOf(const Asset& asset) {
  DataAccess data(asset);
  std::vector<PrimitiveShape> shapes;
  for (const PrimitiveInfo& info : surveyMeshes(asset, data).primitives) {
    if (!info.position || !info.isTriangles()) continue;
    const AccessorInfo position = data.accessor(*info.position);
    if (!position.view && !position.sparse && !data.hasOverlay(*info.position)) continue;
    std::vector<std::uint32_t> sequence(position.count);
    for (std::uint32_t i = 0; i < sequence.size(); ++i) sequence[i] = i;
    if (info.indices) sequence = data.indices(data.accessor(*info.indices));
    shapes.push_back({info.mesh, position.component_type == kGlFloat, readPositions(position, data),
                      toTriangles(info.mode, std::move(sequence))});
  }
  return shapes;
}

/// An edge as one primitive has it: its ends in the order of their bits.
struct EdgeUse {
  std::size_t primitive;
  std::uint32_t a, b;
};
using SharedEdges = std::vector<std::vector<EdgeUse>>;

SharedEdges findSharedEdges(const std::vector<PrimitiveShape>& shapes) {
  std::map<std::tuple<std::size_t, Bits, Bits>, std::vector<EdgeUse>> edges;
  for (std::size_t p = 0; p < shapes.size(); ++p) {
    const PrimitiveShape& shape = shapes[p];
    const bool alone =
        (p == 0 || shapes[p - 1].mesh != shape.mesh) && (p + 1 == shapes.size() || shapes[p + 1].mesh != shape.mesh);
    if (alone) continue;
    for (std::size_t i = 0; i < shape.triangles.size(); ++i) {
      std::uint32_t a = shape.triangles[i], b = shape.triangles[i % 3 == 2 ? i - 2 : i + 1];
      if (shape.positions.at(b) < shape.positions.at(a)) std::swap(a, b);
      if (shape.positions[a] == shape.positions[b]) continue;
      edges[{shape.mesh, shape.positions[a], shape.positions[b]}].push_back({p, a, b});
    }
  }
  SharedEdges shared;
  for (auto& [key, uses] : edges) {
    std::set<std::size_t> primitives;
    for (const EdgeUse& use : uses) primitives.insert(use.primitive);
    if (primitives.size() > 1) shared.push_back(std::move(uses));
  }
  return shared;
}

/// `after`: of each primitive, the positions that its vertices came to have. A vertex that is gone cracks nothing.
std::size_t countCracked(const SharedEdges& shared, const std::vector<Positions>& after) {
  std::size_t cracked = 0;
  for (const std::vector<EdgeUse>& uses : shared) {
    std::set<Bits> a, b;
    for (const EdgeUse& use : uses) {
      const Positions& positions = after[use.primitive];
      if (const auto found = positions.find(use.a); found != positions.end()) a.insert(found->second);
      if (const auto found = positions.find(use.b); found != positions.end()) b.insert(found->second);
    }
    cracked += a.size() > 1 || b.size() > 1 ? 1 : 0;
  }
  return cracked;
}

Positions unchanged(const PrimitiveShape& shape) {
  Positions positions;
  for (std::uint32_t i = 0; i < shape.positions.size(); ++i) positions[i] = shape.positions[i];
  return positions;
}

/// One primitive through libdraco, its vertex numbers beside the positions to tell where each vertex went.
std::optional<Positions> throughDraco(const PrimitiveShape& shape, int position_bits) {
  if (!shape.is_float || shape.triangles.empty()) return unchanged(shape);
  const auto count = static_cast<std::uint32_t>(shape.positions.size());
  draco::Mesh mesh;
  mesh.set_num_points(count);
  for (std::size_t i = 0; i + 2 < shape.triangles.size(); i += 3) {
    mesh.AddFace({draco::PointIndex(shape.triangles[i]), draco::PointIndex(shape.triangles[i + 1]),
                  draco::PointIndex(shape.triangles[i + 2])});
  }
  const auto add = [&](draco::GeometryAttribute::Type type, std::int8_t components, draco::DataType data_type,
                       const void* data) {
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, components, data_type, false, components * 4, 0);
    const int id = mesh.AddAttribute(attribute, true, count);
    mesh.attribute(id)->buffer()->Write(0, data, std::size_t{4} * static_cast<std::size_t>(components) * count);
    return id;
  };
  std::vector<std::uint32_t> numbers(count);
  for (std::uint32_t i = 0; i < count; ++i) numbers[i] = i;
  add(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32, shape.positions.data());
  add(draco::GeometryAttribute::GENERIC, 1, draco::DT_UINT32, numbers.data());
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, position_bits);
  draco::EncoderBuffer encoded;
  if (!encoder.EncodeMeshToBuffer(mesh, &encoded).ok()) return std::nullopt;

  draco::DecoderBuffer buffer;
  buffer.Init(encoded.data(), encoded.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return std::nullopt;
  const draco::PointAttribute* position = decoded.value()->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  const draco::PointAttribute* number = decoded.value()->GetNamedAttribute(draco::GeometryAttribute::GENERIC);
  Positions positions;
  for (draco::PointIndex i(0); i < decoded.value()->num_points(); ++i) {
    std::uint32_t vertex = 0;
    std::array<float, 3> place{};
    number->GetMappedValue(i, &vertex);
    position->GetMappedValue(i, place.data());
    for (float& value : place) value += 0.0F;  // zeros of both signs are one
    positions[vertex] = std::bit_cast<Bits>(place);
  }
  return positions;
}

/// Cracked edges after Draco, and the primitives that it could not code.
Json countAfterDraco(const SharedEdges& shared, const std::vector<PrimitiveShape>& shapes, int position_bits) {
  std::set<std::size_t> concerned;
  for (const auto& uses : shared) {
    for (const EdgeUse& use : uses) concerned.insert(use.primitive);
  }
  std::vector<Positions> after(shapes.size());
  std::size_t failed = 0;
  for (const std::size_t p : concerned) {
    std::optional<Positions> positions = throughDraco(shapes[p], position_bits);
    failed += positions ? 0 : 1;
    if (positions) after[p] = *std::move(positions);
  }
  return {{"cracked", countCracked(shared, after)}, {"primitivesFailed", failed}};
}

std::size_t countAfterPacking(const SharedEdges& shared, const Asset& numbered) {
  Asset asset = numbered;
  const Expected<PackReport> report = packAsset(asset);
  if (!report) throw std::runtime_error(report.failure().message);
  if (const Outcome failure = unpackAsset(asset)) throw std::runtime_error(failure->message);
  DataAccess data(asset);
  std::vector<Positions> after;
  for (const PrimitiveInfo& info : surveyMeshes(asset, data).primitives) {
    if (!info.position || !info.isTriangles()) continue;
    const AccessorInfo position = data.accessor(*info.position);
    if (!position.view && !position.sparse && !data.hasOverlay(*info.position)) continue;
    const std::vector<Bits> bits = readPositions(position, data);
    after.emplace_back();
    for (const AttributeUse& use : info.attributes) {
      if (use.name != "_TEST_ID") continue;
      const std::vector<std::byte> ids = data.elements(data.accessor(use.accessor));
      for (std::size_t i = 0; i < bits.size(); ++i) {
        float id;
        std::memcpy(&id, ids.data() + 4 * i, 4);
        after.back()[static_cast<std::uint32_t>(id)] = bits[i];
      }
    }
  }
  return countCracked(shared, after);
}

Json count(const char* file) {
  Json line = {{"file", file}};
  Expected<Asset> asset = loadAsset(std::filesystem::path(file));
  if (!asset) throw std::runtime_error(asset.failure().message);
  addVertexIds(*asset);
  const std::vector<PrimitiveShape> shapes = shapesOf(*asset);
  const SharedEdges shared = findSharedEdges(shapes);
  std::vector<Positions> before;
  for (const PrimitiveShape& shape : shapes) before.push_back(unchanged(shape));
  line["shared"] = shared.size();
  line["before"] = countCracked(shared, before);
  line["after"] = shared.empty() ? 0 : countAfterPacking(shared, *asset);
  line["draco14"] = countAfterDraco(shared, shapes, 14);
  line["draco11"] = countAfterDraco(shared, shapes, 11);
  return line;
}

}  // namespace
}  // namespace tsc::test

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    tsc::Json line;
    try {
      line = tsc::test::count(argv[i]);
    } catch (const std::exception& error) {
      line = {{"file", argv[i]}, {"failed", error.what()}};
    }
    std::puts(line.dump(-1, ' ', false, tsc::Json::error_handler_t::replace).c_str());
  }
  return 0;
}
