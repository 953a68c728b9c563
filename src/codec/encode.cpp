// Encoding: the stages of decode.cpp run the other way, and the check of the result.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "choose.h"
#include "connectivity.h"
#include "extra_positions.h"
#include "format.h"
#include "header.h"
#include "lattice.h"
#include "output.h"

namespace tsc {
namespace {

/// A mesh that has been welded, cut and numbered as the decoder will number it.
struct Prepared {
  WeldResult welded;
  Surface surface;
  PositionMap map;
  std::vector<std::uint32_t> position_welded;  ///< welded vertex of each surface position
  std::vector<std::uint32_t> face_input;       ///< per surface face: input face over all primitives, or kNone
  std::vector<std::uint8_t> face_rotation;     ///< per surface face: input corner that became its first
  AssignmentInput assignment;
};

Error bad(const char* where, std::int64_t found, std::int64_t expected) {
  return Error{ErrorCode::kInvalidArgument, where, 0, found, expected};
}

Status checkOptions(const EncodeOptions& options) {
  if (options.normal_scale < 1 || options.normal_scale > kMaxNormalScale) {
    return bad("normal scale", options.normal_scale, kMaxNormalScale);
  }
  if (options.mode > Mode::kTangent) return bad("mode", static_cast<int>(options.mode), 2);
  if (options.basis > Basis::kTip) return bad("basis", static_cast<int>(options.basis), 2);
  if (options.predictor > Predictor::kAdaptive) return bad("predictor", static_cast<int>(options.predictor), 5);
  if (options.order > Order::kDegree) return bad("order", static_cast<int>(options.order), 2);
  if (options.effort > Effort::kMax) return bad("effort", static_cast<int>(options.effort), 1);
  return {};
}

struct IntegerRange {
  float lowest;
  float highest;
};

/// Values of an integer position type; all of them are floats too.
IntegerRange rangeOf(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8: return {-128, 127};
    case ComponentType::kUint8: return {0, 255};
    case ComponentType::kInt16: return {-32768, 32767};
    default: return {0, 65535};
  }
}

Status checkMesh(const Mesh& mesh) {
  const bool is_float = mesh.position_type == ComponentType::kFloat32;
  if (!is_float && mesh.position_type >= ComponentType::kUint32) {
    return bad("position type", static_cast<int>(mesh.position_type), static_cast<int>(ComponentType::kFloat32));
  }
  const IntegerRange range = rangeOf(mesh.position_type);
  std::uint64_t total = 0;
  for (const VertexTable& table : mesh.tables) {
    if (table.positions.size() % 3 != 0) return bad("table size", static_cast<std::int64_t>(table.positions.size()), 3);
    total += table.positions.size() / 3;
    for (std::size_t i = 0; i < table.positions.size(); ++i) {
      if (!std::isfinite(table.positions[i])) {
        return Error{ErrorCode::kNonFinitePosition, "vertex", 0, static_cast<std::int64_t>(i / 3), 0};
      }
      const float x = table.positions[i];
      if (!is_float && (x < range.lowest || x > range.highest || x != std::floor(x))) {
        return bad("vertex that its integer type cannot hold", static_cast<std::int64_t>(i / 3), 0);
      }
    }
  }
  for (const Primitive& primitive : mesh.primitives) {
    if (primitive.table >= mesh.tables.size()) {
      return bad("table of primitive", primitive.table, static_cast<std::int64_t>(mesh.tables.size()));
    }
    const std::size_t count = mesh.tables[primitive.table].positions.size() / 3;
    if (primitive.indices.size() % 3 != 0)
      return bad("index count", static_cast<std::int64_t>(primitive.indices.size()), 3);
    const ComponentType type = primitive.index_type;
    if (type != ComponentType::kUint8 && type != ComponentType::kUint16 && type != ComponentType::kUint32) {
      return bad("index type", static_cast<int>(type), static_cast<int>(ComponentType::kUint32));
    }
    const std::size_t size = componentSize(type);
    if (size < 4 && count > std::size_t{1} << 8 * size) {
      return bad("index type for the vertex count", static_cast<std::int64_t>(count), std::int64_t{1} << 8 * size);
    }
    for (const std::uint32_t index : primitive.indices) {
      if (index >= count) return bad("index", index, static_cast<std::int64_t>(count));
    }
    total += primitive.indices.size() / 3;
  }
  constexpr std::uint64_t kLimit = 1u << 28;
  if (total > kLimit) return bad("vertices and triangles", static_cast<std::int64_t>(total), kLimit);
  return {};
}

/// Input corner (over all primitives) at corner c of a decoded face, from its input face and rotation.
std::uint32_t inputCorner(const Prepared& prepared, std::uint32_t face, std::uint32_t corner) {
  return 3 * prepared.face_input[face] + (prepared.face_rotation[face] + corner) % 3;
}

/// Where a point lies on Hilbert's curve, by 21 bits of each coordinate (Skilling, Programming the Hilbert Curve,
/// 2004).
std::uint64_t hilbertRank(glm::uvec3 x) {
  constexpr int kBits = 21;
  for (std::uint32_t q = 1u << (kBits - 1); q > 1; q >>= 1) {
    for (int a = 0; a < 3; ++a) {
      if (x[a] & q) {
        x[0] ^= q - 1;
      } else {
        const std::uint32_t swapped = (x[0] ^ x[a]) & (q - 1);
        x[0] ^= swapped;
        x[a] ^= swapped;
      }
    }
  }
  x[1] ^= x[0];
  x[2] ^= x[1];
  std::uint32_t turned = 0;
  for (std::uint32_t q = 1u << (kBits - 1); q > 1; q >>= 1) turned ^= x[2] & q ? q - 1 : 0;
  std::uint64_t rank = 0;
  for (int bit = kBits - 1; bit >= 0; --bit) {
    for (int a = 0; a < 3; ++a) rank = rank << 1 | ((x[a] ^ turned) >> bit & 1);
  }
  return rank;
}

std::vector<std::uint64_t> curveRanks(std::span<const float> positions, const Box& box) {
  const double extent = box.extent();
  const double scale = extent > 0 ? (std::ldexp(1.0, 21) - 1) / extent : 0;
  std::vector<std::uint64_t> ranks(positions.size() / 3);
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    const glm::dvec3 position(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
    ranks[i] = hilbertRank(glm::uvec3((position - box.lower) * scale));
  }
  return ranks;
}

Prepared prepare(const Mesh& mesh, Effort effort, EntropyWriter& writer) {
  Prepared p;
  p.welded = weld(mesh);
  const CutMesh cut = cutToManifold(p.welded.mesh.positions, p.welded.mesh.corner_vertex);
  const ConnectivityOrder order = encodeConnectivity(cut.surface, effort, writer, p.surface);

  std::vector<std::uint32_t> vertex_welded(p.surface.vertexCount());
  for (std::uint32_t v = 0; v < p.surface.vertexCount(); ++v) vertex_welded[v] = cut.welded_vertex[order.vertex[v]];
  const auto welded_count = static_cast<std::uint32_t>(p.welded.mesh.positions.size() / 3);
  p.map = numberPositions(vertex_welded, welded_count, p.assignment.welded_position);
  p.position_welded.resize(p.map.position_count);
  for (std::uint32_t w = 0; w < welded_count; ++w) {
    if (p.assignment.welded_position[w] != kNone) p.position_welded[p.assignment.welded_position[w]] = w;
  }

  // Only unused vertices need ranks.
  if (p.map.position_count < welded_count) p.assignment.welded_rank = curveRanks(p.welded.mesh.positions, boxOf(mesh));

  std::vector<std::uint32_t> face_primitive;  // of each input face
  std::vector<std::uint32_t> corner_index;    // table vertex of each input corner
  for (std::uint32_t i = 0; i < mesh.primitives.size(); ++i) {
    const std::span<const std::uint32_t> indices = mesh.primitives[i].indices;
    face_primitive.insert(face_primitive.end(), indices.size() / 3, i);
    corner_index.insert(corner_index.end(), indices.begin(), indices.end());
  }
  const std::uint32_t faces = p.surface.faceCount();
  p.face_input.resize(faces);
  p.face_rotation.resize(faces);
  p.assignment.face_primitive.assign(faces, kNone);
  p.assignment.corner_vertex.assign(3 * std::size_t{faces}, kNone);
  for (std::uint32_t f = 0; f < faces; ++f) {
    const std::uint32_t input = cut.input_face[order.corner[f] / 3];
    p.face_input[f] = input;
    p.face_rotation[f] = static_cast<std::uint8_t>(order.corner[f] % 3);
    if (input == kNone) continue;
    p.assignment.face_primitive[f] = face_primitive[input];
    for (std::uint32_t c = 0; c < 3; ++c) p.assignment.corner_vertex[3 * f + c] = corner_index[inputCorner(p, f, c)];
  }
  for (const std::uint32_t f : cut.side_faces) {
    p.assignment.side_faces.push_back(
        {face_primitive[f], {corner_index[3 * f], corner_index[3 * f + 1], corner_index[3 * f + 2]}});
    p.face_input.push_back(f);
    p.face_rotation.push_back(0);
  }
  p.assignment.table_welded = p.welded.table_vertex_to_welded;
  return p;
}

void measure(const Mesh& mesh, std::span<const std::vector<std::byte>> outputs, EncodeResult& result) {
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.tables.size(); ++t) {
    if (mesh.position_type != ComponentType::kFloat32) continue;
    for (std::size_t i = 0; i < result.vertex_order[t].size(); ++i, ++count) {
      glm::vec3 decoded;
      std::memcpy(&decoded, outputs[t].data() + 12 * i, 12);
      const float* input = mesh.tables[t].positions.data() + 3 * std::size_t{result.vertex_order[t][i]};
      const glm::dvec3 error = glm::dvec3(decoded) - glm::dvec3(input[0], input[1], input[2]);
      squares += glm::dot(error, error);
      result.max_error = std::max(result.max_error, std::sqrt(glm::dot(error, error)));
    }
  }
  result.rms_error = count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0;
}

}  // namespace

Result<EncodeResult> encode(const Mesh& mesh, const EncodeOptions& options) {
  if (Status s = checkOptions(options)) return *s;
  if (Status s = checkMesh(mesh)) return *s;
  Header header;
  if (Status s = placeLattice(mesh, options, header)) return *s;

  EncodeResult result;
  EntropyWriter writer;
  Prepared prepared = prepare(mesh, options.effort, writer);
  result.bits.connectivity = writer.bitsSince(0);
  if (prepared.surface.faceCount() >= kMaxSurfaceFaces) {
    return bad("faces, those that close holes included", prepared.surface.faceCount(), kMaxSurfaceFaces);
  }

  std::size_t mark = writer.mark();
  header.has_references = !prepared.map.isIdentity();
  encodeReferences(prepared.surface, prepared.map, header.has_references, writer);
  result.bits.references = writer.bitsSince(mark);

  Trial best = bestPositions({prepared.surface, prepared.map, prepared.welded.mesh.positions, prepared.position_welded},
                             header, options, boxOf(mesh));
  header.positions = best.parameters;
  result.bits.positions = best.bits;
  writer.append(best.writer);

  mark = writer.mark();
  std::vector<std::uint32_t> primitive_table;
  for (const Primitive& primitive : mesh.primitives) primitive_table.push_back(primitive.table);
  header.counts = countAssignment(prepared.assignment, primitive_table);
  Assignment assignment;
  const AssignmentOrder order = encodeAssignment(prepared.surface, prepared.map, best.decoded, prepared.assignment,
                                                 header.counts, writer, assignment);
  result.bits.corners = writer.bitsSince(mark);

  mark = writer.mark();
  std::vector<Vec3> positions = std::move(best.decoded);
  positions.resize(assignment.position_count);
  encodeExtraPositions(targetsOf(prepared.welded.mesh.positions, order.extra_positions, header),
                       extraPositionBits(header.positions), writer,
                       std::span(positions).subspan(prepared.map.position_count));
  result.bits.side_faces = writer.bitsSince(mark);

  header.surface = prepared.surface.counts();
  for (const Primitive& primitive : mesh.primitives) header.index_types.push_back(primitive.index_type);
  writeHeader(header, result.bytes);
  result.bits.header = 8.0 * static_cast<double>(result.bytes.size());

  std::vector<std::vector<std::byte>> outputs;
  std::vector<std::span<std::byte>> spans;
  for (const OutputInfo& info : outputsOf(header)) {
    outputs.emplace_back(static_cast<std::size_t>(info.byte_length));
    spans.emplace_back(outputs.back());
  }
  if (Status s = writeOutputs(header, assignment, {{}, positions}, spans)) return *s;
  writer.finish(checksumOf(result.bytes, spans), result.bytes);

  // The proof that the decoder agrees: same numbers, or no result.
  if (Status s = decode(result.bytes, spans, {std::numeric_limits<std::uint64_t>::max()})) return *s;

  result.vertex_order = order.vertex;
  for (std::size_t p = 0, first = 0; p < mesh.primitives.size(); first += mesh.primitives[p++].indices.size() / 3) {
    std::vector<std::uint32_t>& triangles = result.triangle_order.emplace_back();
    for (const std::uint32_t triangle : order.triangle[p]) {
      const std::uint32_t face = triangle / 3;
      const std::uint32_t corner = (prepared.face_rotation[face] + triangle) % 3;
      triangles.push_back(3 * (prepared.face_input[face] - static_cast<std::uint32_t>(first)) + corner);
    }
  }
  const PositionParameters& p = header.positions;
  result.modes = {p.mode, p.basis, p.predictor, p.order, p.effort, p.normal_scale, double{header.step}};
  result.unique_positions = prepared.welded.mesh.positions.size() / 3;
  measure(mesh, outputs, result);
  EncodeOptions used = options;
  used.mode = p.mode;
  if (result.max_error > guaranteedError(mesh, used)) {
    return Error{ErrorCode::kBoundNotMet, "largest error in millionths of a step", 0,
                 static_cast<std::int64_t>(result.max_error / header.step * 1e6),
                 static_cast<std::int64_t>(guaranteedError(mesh, used) / header.step * 1e6)};
  }
  return result;
}

}  // namespace tsc
