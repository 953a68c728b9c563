// See stream_check.h.
#include "stream_check.h"

#include <cmath>
#include <cstring>

#include "data_access.h"
#include "fault.h"

namespace tsc {
namespace {

[[noreturn]] void failCheck(const std::string& label, const std::string& what) {
  fail(FailureKind::kBound, label, "the self-check failed: " + what + "; nothing was written");
}

template <class T>
float componentAt(const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(value));
  return static_cast<float>(value);
}

float readComponent(const std::byte* bytes, ComponentType type) {
  switch (type) {
    case ComponentType::kInt8:
      return componentAt<std::int8_t>(bytes);
    case ComponentType::kUint8:
      return componentAt<std::uint8_t>(bytes);
    case ComponentType::kInt16:
      return componentAt<std::int16_t>(bytes);
    case ComponentType::kUint16:
      return componentAt<std::uint16_t>(bytes);
    case ComponentType::kUint32:
      return componentAt<std::uint32_t>(bytes);
    default:
      return componentAt<float>(bytes);
  }
}

bool isPermutation(const std::vector<std::uint32_t>& order, std::size_t count) {
  if (order.size() != count) return false;
  std::vector<bool> seen(count);
  for (const std::uint32_t i : order) {
    if (i >= count || seen[i]) return false;
    seen[i] = true;
  }
  return true;
}

void compareTable(const VertexTable& table, const std::vector<std::uint32_t>& order, const std::vector<float>& decoded,
                  double bound, const std::string& label) {
  const std::size_t count = table.positions.size() / 3;
  if (decoded.size() != count * 3) failCheck(label, "another number of vertices came back");
  if (!isPermutation(order, count)) failCheck(label, "the vertices are not a permutation of the input's");
  for (std::size_t i = 0; i < count; ++i) {
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double difference = static_cast<double>(decoded[3 * i + axis]) - table.positions[3 * order[i] + axis];
      square += difference * difference;
    }
    if (!(std::sqrt(square) <= bound)) {
      failCheck(label, "vertex " + std::to_string(order[i]) + " is off by " + std::to_string(std::sqrt(square)) +
                           ", expected at most " + std::to_string(bound));
    }
  }
}

void comparePrimitive(const Primitive& primitive, const std::vector<std::uint32_t>& triangle_order,
                      const std::vector<std::uint32_t>& vertex_order, const std::vector<std::uint32_t>& decoded,
                      const std::string& label) {
  const std::size_t triangles = primitive.indices.size() / 3;
  if (decoded.size() != triangles * 3 || triangle_order.size() != triangles) {
    failCheck(label, "another number of triangles came back");
  }
  std::vector<bool> seen(triangles);
  for (std::size_t i = 0; i < triangles; ++i) {
    const std::size_t source = triangle_order[i] / 3;
    const std::size_t first = triangle_order[i] % 3;
    if (source >= triangles || seen[source]) failCheck(label, "the triangles are not a permutation of the input's");
    seen[source] = true;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = decoded[3 * i + corner];
      const std::uint32_t expected = primitive.indices[3 * source + (first + corner) % 3];
      if (vertex >= vertex_order.size() || vertex_order[vertex] != expected) {
        failCheck(label, "triangle " + std::to_string(source) + " came back over other vertices");
      }
    }
  }
}

}  // namespace

std::vector<float> positionsAsFloats(const std::vector<std::byte>& bytes, ComponentType type) {
  const std::size_t stride = positionStride(type);
  const std::size_t size = componentSize(type);
  std::vector<float> positions(bytes.size() / stride * 3);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    positions[i] = readComponent(bytes.data() + i / 3 * stride + i % 3 * size, type);
  }
  return positions;
}

std::vector<std::vector<std::byte>> decodeAndCompare(const Mesh& mesh, const EncodeResult& result, double bound,
                                                     const std::string& label) {
  Result<std::vector<std::vector<std::byte>>> decoded = decode(result.bytes);
  if (!decoded) failCheck(label, describe(decoded.error()));
  const std::size_t tables = mesh.tables.size();
  if (decoded->size() != tables + mesh.primitives.size() || result.vertex_order.size() != tables ||
      result.triangle_order.size() != mesh.primitives.size()) {
    failCheck(label, "another number of arrays came back");
  }
  for (std::size_t t = 0; t < tables; ++t) {
    compareTable(mesh.tables[t], result.vertex_order[t], positionsAsFloats((*decoded)[t], mesh.position_type), bound,
                 label);
  }
  for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
    const Primitive& primitive = mesh.primitives[p];
    comparePrimitive(primitive, result.triangle_order[p], result.vertex_order[primitive.table],
                     readUnsigned((*decoded)[tables + p], componentSize(primitive.index_type)), label);
  }
  return *std::move(decoded);
}

}  // namespace tsc
