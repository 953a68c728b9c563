// What must hold for every mesh that is coded and decoded, whatever the options.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "meshes.h"
#include "tsc/codec.h"

namespace tsc::test {

/// A mesh that owns its arrays.
struct OwnedMesh {
  struct Faces {
    std::uint32_t table = 0;
    std::vector<std::uint32_t> indices;
    ComponentType index_type = ComponentType::kUint32;
  };
  std::vector<std::vector<float>> tables;
  std::vector<Faces> primitives;
  ComponentType position_type = ComponentType::kFloat32;

  OwnedMesh() = default;
  explicit OwnedMesh(const meshes::Triangles& triangles)
      : tables{triangles.positions}, primitives{{0, triangles.indices}} {}

  /// Borrows this object.
  Mesh mesh() const {
    Mesh mesh;
    mesh.position_type = position_type;
    for (const auto& positions : tables) mesh.tables.push_back({positions});
    for (const Faces& faces : primitives) mesh.primitives.push_back({faces.table, faces.indices, faces.index_type});
    return mesh;
  }
};

inline std::vector<std::span<std::byte>> spansOf(std::vector<std::vector<std::byte>>& outputs) {
  return {outputs.begin(), outputs.end()};
}

template <class T>
T loadAt(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// Component `i` of an array, as a number. The tests run on little-endian machines.
inline double component(std::span<const std::byte> bytes, ComponentType type, std::size_t offset) {
  switch (type) {
    case ComponentType::kInt8: return loadAt<std::int8_t>(bytes, offset);
    case ComponentType::kUint8: return loadAt<std::uint8_t>(bytes, offset);
    case ComponentType::kInt16: return loadAt<std::int16_t>(bytes, offset);
    case ComponentType::kUint16: return loadAt<std::uint16_t>(bytes, offset);
    case ComponentType::kUint32: return loadAt<std::uint32_t>(bytes, offset);
    case ComponentType::kFloat32: return loadAt<float>(bytes, offset);
  }
  return 0;
}

using Point = std::array<double, 3>;

/// A decoded mesh as numbers.
struct DecodedMesh {
  std::vector<std::vector<Point>> tables;
  std::vector<std::vector<std::uint32_t>> primitives;
};

inline DecodedMesh toNumbers(std::span<const OutputInfo> infos, std::span<const std::vector<std::byte>> outputs) {
  DecodedMesh mesh;
  for (std::size_t o = 0; o < infos.size(); ++o) {
    const OutputInfo& info = infos[o];
    const std::size_t size = componentSize(info.type);
    if (info.kind == OutputInfo::Kind::kPositions) {
      std::vector<Point>& points = mesh.tables.emplace_back(info.count);
      for (std::size_t i = 0; i < info.count; ++i) {
        for (std::size_t a = 0; a < 3; ++a) {
          points[i][a] = component(outputs[o], info.type, i * info.byte_stride + a * size);
        }
      }
    } else {
      std::vector<std::uint32_t>& indices = mesh.primitives.emplace_back(info.count);
      for (std::size_t i = 0; i < info.count; ++i) {
        indices[i] = static_cast<std::uint32_t>(component(outputs[o], info.type, i * size));
      }
    }
  }
  return mesh;
}

/// The decoded mesh as input for another round.
inline OwnedMesh toInput(const DecodedMesh& decoded, const OwnedMesh& like) {
  OwnedMesh mesh = like;
  for (std::size_t t = 0; t < mesh.tables.size(); ++t) {
    mesh.tables[t].clear();
    for (const Point& point : decoded.tables[t]) {
      for (const double x : point) mesh.tables[t].push_back(static_cast<float>(x));
    }
  }
  for (std::size_t p = 0; p < mesh.primitives.size(); ++p) mesh.primitives[p].indices = decoded.primitives[p];
  return mesh;
}

struct RoundTrip {
  std::string fault;  ///< empty if everything holds
  EncodeResult encoded;
  DecodedMesh decoded;
};

inline bool isPermutation(std::span<const std::uint32_t> order, std::size_t count) {
  std::vector<std::uint8_t> met(count, 0);
  for (const std::uint32_t i : order) {
    if (i >= count || met[i]++ != 0) return false;
  }
  return order.size() == count;
}

/// The same triangles over the same corners.
inline std::string faultInFaces(const OwnedMesh& input, const RoundTrip& trip) {
  for (std::size_t p = 0; p < input.primitives.size(); ++p) {
    const std::vector<std::uint32_t>& given = input.primitives[p].indices;
    const std::vector<std::uint32_t>& decoded = trip.decoded.primitives[p];
    const std::vector<std::uint32_t>& order = trip.encoded.triangle_order[p];
    const std::vector<std::uint32_t>& vertex_order = trip.encoded.vertex_order[input.primitives[p].table];
    if (decoded.size() != given.size() || 3 * order.size() != given.size()) return "number of triangles";
    std::vector<std::uint8_t> met(order.size(), 0);
    for (std::size_t t = 0; t < order.size(); ++t) {
      const std::uint32_t triangle = order[t] / 3;
      if (triangle >= order.size() || met[triangle]++ != 0) return "triangle_order is no permutation";
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::uint32_t index = decoded[3 * t + c];
        if (index >= vertex_order.size()) return "decoded index out of range";
        if (vertex_order[index] != given[3 * triangle + (order[t] % 3 + c) % 3]) return "corner of another vertex";
      }
    }
  }
  return {};
}

/// Each position within `bound`, and equal positions equal.
inline std::string faultInPositions(const OwnedMesh& input, const RoundTrip& trip, double bound) {
  std::map<std::array<std::uint32_t, 3>, Point> decoded_of;
  double largest = 0;
  for (std::size_t t = 0; t < input.tables.size(); ++t) {
    const std::vector<std::uint32_t>& order = trip.encoded.vertex_order[t];
    if (!isPermutation(order, input.tables[t].size() / 3)) return "vertex_order is no permutation";
    for (std::size_t i = 0; i < order.size(); ++i) {
      const float* given = &input.tables[t][3 * std::size_t{order[i]}];
      const Point& decoded = trip.decoded.tables[t][i];
      std::array<std::uint32_t, 3> key;
      double squares = 0;
      for (std::size_t a = 0; a < 3; ++a) {
        key[a] = std::bit_cast<std::uint32_t>(given[a] == 0 ? 0.0f : given[a]);
        squares += (decoded[a] - given[a]) * (decoded[a] - given[a]);
      }
      largest = std::max(largest, std::sqrt(squares));
      const auto [entry, is_new] = decoded_of.try_emplace(key, decoded);
      if (!is_new && std::memcmp(entry->second.data(), decoded.data(), sizeof decoded) != 0) {
        return "equal positions decoded to different ones";
      }
    }
  }
  if (!(largest <= bound)) {
    return "error " + std::to_string(largest) + " above the bound " + std::to_string(bound);
  }
  const bool is_float = input.position_type == ComponentType::kFloat32;
  if (is_float && trip.encoded.max_error != largest) return "max_error is not the largest error";
  if (trip.encoded.rms_error > trip.encoded.max_error * (1 + 1e-12)) return "rms_error above max_error";
  if (trip.encoded.unique_positions != decoded_of.size()) return "unique_positions";
  return {};
}

/// Types and counts of the outputs.
inline std::string faultInInfo(const OwnedMesh& input, const StreamInfo& info, const EncodeResult& encoded) {
  if (info.outputs.size() != input.tables.size() + input.primitives.size()) return "number of outputs";
  for (std::size_t o = 0; o < info.outputs.size(); ++o) {
    const OutputInfo& output = info.outputs[o];
    const bool is_table = o < input.tables.size();
    if (is_table != (output.kind == OutputInfo::Kind::kPositions)) return "kind of an output";
    if (output.byte_length != output.count * output.byte_stride) return "byte_length";
    if (is_table) {
      if (output.type != input.position_type || output.table != o) return "type of a table";
      if (output.count != input.tables[o].size() / 3) return "vertex count";
      if (output.byte_stride != positionStride(output.type)) return "stride";
    } else {
      const OwnedMesh::Faces& faces = input.primitives[o - input.tables.size()];
      if (output.type != faces.index_type || output.table != faces.table) return "type or table of a primitive";
      if (output.count != faces.indices.size()) return "index count";
    }
  }
  const StreamModes &a = info.modes, &b = encoded.modes;
  if (a.mode != b.mode || a.basis != b.basis || a.predictor != b.predictor || a.order != b.order ||
      a.effort != b.effort || a.normal_scale != b.normal_scale || a.step != b.step) {
    return "modes";
  }
  return {};
}

inline std::string faultInBits(const EncodeResult& encoded) {
  const StreamBits& b = encoded.bits;
  const double sum = b.header + b.connectivity + b.positions + b.references + b.corners + b.side_faces;
  const double spent = 8 * static_cast<double>(encoded.bytes.size());
  // Each of the coder's three states starts with 16 to 17 bits, and may end with up to 16 that no symbol fills.
  const bool holds = spent >= sum * 0.998 + 47 && spent <= sum * 1.002 + 100;
  return holds ? "" : "bits: " + std::to_string(sum) + " of " + std::to_string(spent);
}

/// Encodes, decodes and checks everything that the contract of `encode` promises.
inline RoundTrip roundTrip(const OwnedMesh& input, const EncodeOptions& options) {
  RoundTrip trip;
  const Mesh mesh = input.mesh();
  Result<EncodeResult> encoded = encode(mesh, options);
  if (!encoded) {
    trip.fault = "encode: " + describe(encoded.error());
    return trip;
  }
  trip.encoded = std::move(*encoded);
  const Result<StreamInfo> info = readStreamInfo(trip.encoded.bytes);
  const auto outputs = decode(trip.encoded.bytes);
  if (!info || !outputs) {
    trip.fault = "decode: " + describe(info ? outputs.error() : info.error());
    return trip;
  }
  trip.decoded = toNumbers(info->outputs, *outputs);
  trip.fault = faultInInfo(input, *info, trip.encoded);
  if (trip.fault.empty()) trip.fault = faultInPositions(input, trip, guaranteedError(mesh, options));
  if (trip.fault.empty()) trip.fault = faultInFaces(input, trip);
  if (trip.fault.empty()) trip.fault = faultInBits(trip.encoded);
  return trip;
}

/// All choices that can be forced, in words that tell them apart.
inline std::vector<std::pair<std::string, EncodeOptions>> allChoices() {
  std::vector<std::pair<std::string, EncodeOptions>> all;
  for (const Mode mode : {Mode::kLattice, Mode::kTangent}) {
    for (const Basis basis : {Basis::kGate, Basis::kTip}) {
      if (mode == Mode::kLattice && basis == Basis::kTip) continue;
      for (int predictor = 1; predictor <= static_cast<int>(Predictor::kAdaptive); ++predictor) {
        for (const Order order : {Order::kTraversal, Order::kDegree}) {
          EncodeOptions options;
          options.mode = mode;
          options.basis = basis;
          options.predictor = static_cast<Predictor>(predictor);
          options.order = order;
          all.emplace_back(std::string(mode == Mode::kLattice  ? "lattice"
                                       : basis == Basis::kGate ? "gate"
                                                               : "tip") +
                               " predictor " + std::to_string(predictor) +
                               (order == Order::kDegree ? " degree" : " traversal"),
                           options);
        }
      }
    }
  }
  return all;
}

}  // namespace tsc::test
