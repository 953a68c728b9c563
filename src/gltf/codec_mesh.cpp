// See codec_mesh.h.
#include "codec_mesh.h"

#include <cmath>
#include <cstring>

#include "fault.h"
#include "original_order.h"
#include "precision.h"
#include "stream_check.h"

namespace tsc {
namespace {

/// What the codec is given: a mesh that borrows the positions beside it.
struct CodecInput {
  std::vector<std::vector<float>> positions;  ///< by table
  Mesh mesh;
};

/// Packed VEC3 elements of any type as floats, which hold all integers of up to 16 bits.
std::vector<float> toFloats(const std::vector<std::byte>& elements, std::uint32_t gl_type) {
  const ComponentType type = codecType(gl_type);
  const std::size_t size = componentSize(type);
  const std::size_t count = elements.size() / (3 * size);
  std::vector<std::byte> strided(count * positionStride(type));
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(strided.data() + i * positionStride(type), elements.data() + i * 3 * size, 3 * size);
  }
  return positionsAsFloats(strided, type);
}

CodecInput readGroup(const MeshGroup& group, DataAccess& data) {
  CodecInput input;
  input.mesh.position_type = codecType(group.component_type);
  for (const GroupTable& table : group.tables) {
    input.positions.push_back(toFloats(data.elements(data.accessor(table.accessor)), group.component_type));
    const std::vector<float>& positions = input.positions.back();
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if (!std::isfinite(positions[i])) {
        failInvalid("/accessors/" + number(table.accessor),
                    "vertex " + number(i / 3) + " has a coordinate that is not finite, expected a number");
      }
    }
  }
  for (const std::vector<float>& positions : input.positions) input.mesh.tables.push_back({positions});
  for (const CodedPrimitive& primitive : group.primitives) {
    input.mesh.primitives.push_back(
        {static_cast<std::uint32_t>(primitive.table), primitive.triangles, codecType(primitive.component_type)});
  }
  return input;
}

[[noreturn]] void failEncode(const Error& error, const std::string& label) {
  switch (error.code) {
    case ErrorCode::kLatticeTooFine:
    case ErrorCode::kBoundNotMet: fail(FailureKind::kBound, label, describe(error));
    case ErrorCode::kInvalidArgument: fail(FailureKind::kUsage, label, describe(error));
    default: fail(FailureKind::kInvalidInput, label, describe(error));
  }
}

StreamReport reportStream(const MeshGroup& group, const CodecInput& input, const CodedGroup& coded, DataAccess& data,
                          double bound) {
  StreamReport stream;
  stream.meshes = group.meshes;
  stream.label = group.label;
  for (const std::vector<float>& positions : input.positions) stream.vertices += positions.size() / 3;
  stream.unique_positions = coded.result.unique_positions;
  stream.triangles = triangleCount(group);
  stream.input_position_bytes = stream.vertices * 3 * componentSize(input.mesh.position_type);
  for (const CodedPrimitive& primitive : group.primitives) {
    if (!primitive.indices) continue;
    const AccessorInfo info = data.accessor(*primitive.indices);
    stream.input_index_bytes += info.count * info.component_bytes;
  }
  stream.stream_bytes = coded.result.bytes.size();
  stream.order_bytes = coded.order.size();
  stream.bits = coded.result.bits;
  stream.modes = coded.result.modes;
  stream.max_error = coded.result.max_error;
  stream.rms_error = coded.result.rms_error;
  stream.guaranteed_error = bound;
  stream.diagonal = diagonalOf(input.mesh);
  return stream;
}

/// Puts the decoded arrays into the original order, from the bytes that will be stored, and checks that it is.
void keepOrder(const MeshGroup& group, const Mesh& mesh, double bound, CodedGroup& coded) {
  coded.order = writeOriginalOrder(coded.result);
  const Result<StreamInfo> info = readStreamInfo(coded.result.bytes);
  if (!info) failEncode(info.error(), group.label);
  restoreOriginalOrder(coded.order, info->outputs, coded.decoded, group.label);
  for (std::size_t t = 0; t < group.tables.size(); ++t) {
    const std::vector<float> restored = positionsAsFloats(coded.decoded[t], mesh.position_type);
    for (std::size_t i = 0; i < restored.size(); i += 3) {
      double square = 0;
      for (std::size_t axis = i; axis < i + 3; ++axis) {
        const double difference = double{restored[axis]} - double{mesh.tables[t].positions[axis]};
        square += difference * difference;
      }
      if (std::sqrt(square) <= bound) continue;
      fail(FailureKind::kBound, group.label,
           "the self-check failed: vertex " + number(i / 3) + " was not restored to its place");
    }
  }
  for (std::size_t p = 0; p < group.primitives.size(); ++p) {
    const CodedPrimitive& primitive = group.primitives[p];
    const std::size_t bytes = componentSize(codecType(primitive.component_type));
    if (readUnsigned(coded.decoded[group.tables.size() + p], bytes) != primitive.triangles) {
      fail(FailureKind::kBound, group.label, "the self-check failed: the original order was not restored");
    }
  }
}

}  // namespace

ComponentType codecType(std::uint32_t gl_type) {
  switch (gl_type) {
    case kGlByte: return ComponentType::kInt8;
    case kGlUnsignedByte: return ComponentType::kUint8;
    case kGlShort: return ComponentType::kInt16;
    case kGlUnsignedShort: return ComponentType::kUint16;
    case kGlUnsignedInt: return ComponentType::kUint32;
    default: return ComponentType::kFloat32;
  }
}

std::uint64_t triangleCount(const MeshGroup& group) {
  std::uint64_t count = 0;
  for (const CodedPrimitive& primitive : group.primitives) count += primitive.triangles.size() / 3;
  return count;
}

CodedGroup codeGroup(const MeshGroup& group, DataAccess& data, const PackOptions& options) {
  const CodecInput input = readGroup(group, data);
  const EncodeOptions encode_options = chooseEncodeOptions(input.mesh, options, group.label);
  Result<EncodeResult> result = encode(input.mesh, encode_options);
  if (!result) failEncode(result.error(), group.label);
  CodedGroup coded;
  coded.group = &group;
  coded.position_type = input.mesh.position_type;
  coded.result = *std::move(result);
  const double bound = guaranteedError(input.mesh, encode_options);
  coded.decoded = decodeAndCompare(input.mesh, coded.result, bound, group.label);
  if (options.keep_order) keepOrder(group, input.mesh, bound, coded);
  coded.report = reportStream(group, input, coded, data, bound);
  return coded;
}

}  // namespace tsc
