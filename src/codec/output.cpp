#include "output.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "checksum.h"

namespace tsc {
namespace {

/// Little-endian.
template <class T>
void store(std::byte* to, T value) {
  if constexpr (std::endian::native == std::endian::little) {
    std::memcpy(to, &value, sizeof value);
  } else {
    std::byte bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    for (std::size_t i = 0; i < sizeof value; ++i) to[i] = bytes[sizeof value - 1 - i];
  }
}

/// Calls visit(vertex, position) for each vertex of a table.
template <class Visit>
void forVertices(std::span<const std::uint32_t> numbers, const Points& points, std::size_t count, Visit visit) {
  if (numbers.empty()) {
    for (std::size_t i = 0; i < count; ++i) visit(i, points[i]);
  } else {
    for (std::size_t i = 0; i < count; ++i) visit(i, points[numbers[i]]);
  }
}

template <class T>
Status writeIntegerPositions(const Header& header, std::span<const std::uint32_t> numbers, const Points& points,
                             std::span<std::byte> output) {
  const std::size_t stride = positionStride(header.position_type);
  std::fill(output.begin(), output.end(), std::byte{0});
  Status status;
  forVertices(numbers, points, output.size() / stride, [&](std::size_t i, const Vec3& q) {
    for (int a = 0; a < 3; ++a) {
      const std::int64_t value = header.anchor[a] + q[a];
      if (value < std::numeric_limits<T>::min() || value > std::numeric_limits<T>::max()) {
        status = Error{ErrorCode::kInvalidCount, "integer position", 0, value, std::numeric_limits<T>::max()};
      }
      store(output.data() + i * stride + a * sizeof(T), static_cast<T>(value));
    }
  });
  return status;
}

Status writeFloatPositions(const Header& header, std::span<const std::uint32_t> numbers, const Points& points,
                           std::span<std::byte> output) {
  const Lattice lattice(header);
  double largest = 0;
  forVertices(numbers, points, output.size() / 12, [&](std::size_t i, const Vec3& q) {
    for (int a = 0; a < 3; ++a) {
      const double exact = lattice.coordinate(q[a], a);
      largest = std::max(largest, std::abs(exact));
      store(output.data() + 12 * i + 4 * a, static_cast<float>(exact));
    }
  });
  if (!(largest <= double{std::numeric_limits<float>::max()})) {
    return Error{ErrorCode::kInvalidCount, "float position", 0, 0, 0};
  }
  return {};
}

template <class T>
void writeIndicesAs(std::span<const std::uint32_t> indices, std::span<std::byte> output) {
  for (std::size_t i = 0; i < indices.size(); ++i) store(output.data() + i * sizeof(T), static_cast<T>(indices[i]));
}

}  // namespace

Lattice::Lattice(const Header& header) : fine_step_(std::ldexp(double{header.step}, -header.positions.fine_bits)) {
  for (int a = 0; a < 3; ++a) {
    origin_[a] = header.anchored ? 0 : double{header.origin[a]};
    anchor_[a] = header.anchored ? std::ldexp(static_cast<double>(header.anchor[a]), header.positions.fine_bits) : 0;
  }
}

Status writePositions(const Header& header, std::span<const std::uint32_t> numbers, const Points& points,
                      std::span<std::byte> output) {
  switch (header.position_type) {
    case ComponentType::kInt8: return writeIntegerPositions<std::int8_t>(header, numbers, points, output);
    case ComponentType::kUint8: return writeIntegerPositions<std::uint8_t>(header, numbers, points, output);
    case ComponentType::kInt16: return writeIntegerPositions<std::int16_t>(header, numbers, points, output);
    case ComponentType::kUint16: return writeIntegerPositions<std::uint16_t>(header, numbers, points, output);
    default: return writeFloatPositions(header, numbers, points, output);
  }
}

void writeIndices(ComponentType type, std::span<const std::uint32_t> indices, std::span<std::byte> output) {
  switch (type) {
    case ComponentType::kUint8: return writeIndicesAs<std::uint8_t>(indices, output);
    case ComponentType::kUint16: return writeIndicesAs<std::uint16_t>(indices, output);
    default: return writeIndicesAs<std::uint32_t>(indices, output);
  }
}

Status writeOutputs(const Header& header, const Assignment& assignment, const Points& points,
                    std::span<const std::span<std::byte>> outputs) {
  std::size_t next = 0;
  for (const std::vector<std::uint32_t>& numbers : assignment.table_position) {
    if (Status status = writePositions(header, numbers, points, outputs[next++])) return status;
  }
  for (std::size_t p = 0; p < assignment.primitive_indices.size(); ++p) {
    writeIndices(header.index_types[p], assignment.primitive_indices[p], outputs[next++]);
  }
  return {};
}

std::uint32_t checksumOf(std::span<const std::byte> header_bytes, std::span<const std::span<std::byte>> outputs) {
  std::uint64_t hash = xxh64(header_bytes, 0);
  for (const std::span<std::byte> output : outputs) hash = xxh64(output, hash);
  return static_cast<std::uint32_t>(hash);
}

}  // namespace tsc
