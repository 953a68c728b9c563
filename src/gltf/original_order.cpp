// See original_order.h.
#include "original_order.h"

#include <cstring>
#include <optional>

#include "../codec/checksum.h"
#include "data_access.h"
#include "fault.h"

namespace tsc {
namespace {

constexpr std::size_t kChecksumBytes = 8;

std::uint64_t zigzag(std::int64_t value) {
  return value >= 0 ? 2 * static_cast<std::uint64_t>(value) : 2 * static_cast<std::uint64_t>(-value) - 1;
}

std::int64_t unzigzag(std::uint64_t value) {
  const auto half = static_cast<std::int64_t>(value / 2);
  return value % 2 == 0 ? half : -half - 1;
}

void putNumber(std::uint64_t value, std::vector<std::byte>& out) {
  for (; value >= 128; value /= 128) out.push_back(static_cast<std::byte>(value % 128 + 128));
  out.push_back(static_cast<std::byte>(value));
}

void putChecksum(std::vector<std::byte>& bytes) {
  const std::uint64_t sum = xxh64(bytes, 0);
  for (std::size_t i = 0; i < kChecksumBytes; ++i) bytes.push_back(static_cast<std::byte>(sum >> (8 * i)));
}

/// Reads the numbers of one order view.
class OrderReader {
 public:
  OrderReader(std::span<const std::byte> bytes, const std::string& place) : bytes_(bytes), place_(place) {
    if (bytes.size() < kChecksumBytes)
      failInvalid(place, "found " + number(bytes.size()) + " bytes, expected 8 or more");
    bytes_ = bytes.first(bytes.size() - kChecksumBytes);
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < kChecksumBytes; ++i) {
      sum |= std::to_integer<std::uint64_t>(bytes[bytes_.size() + i]) << (8 * i);
    }
    if (sum != xxh64(bytes_, 0)) failInvalid(place, "the order is damaged: its checksum does not match");
  }

  struct Element {
    std::uint32_t source;
    std::uint32_t corner;
  };

  /// A permutation of `count` numbers; `corners` is 3 for triangles and 1 for vertices.
  std::vector<Element> read(std::uint64_t count, std::uint32_t corners) {
    // Each element takes a byte at least, so that a count alone allocates nothing.
    if (count > bytes_.size() - at_) failInvalid(place_, "the order ends before its content does");
    std::vector<Element> elements;
    elements.reserve(count);
    std::vector<bool> seen(count);
    std::int64_t previous = -1;
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t value = readNumber();
      const std::int64_t source = previous + 1 + unzigzag(value / corners);
      if (source < 0 || static_cast<std::uint64_t>(source) >= count || seen[static_cast<std::size_t>(source)]) {
        failInvalid(place_, "the order names element " + std::to_string(source) + " of " + number(count) +
                                ", expected each one once");
      }
      seen[static_cast<std::size_t>(source)] = true;
      elements.push_back({static_cast<std::uint32_t>(source), static_cast<std::uint32_t>(value % corners)});
      previous = source;
    }
    return elements;
  }

  void expectEnd() const {
    if (at_ != bytes_.size()) failInvalid(place_, "found " + number(bytes_.size() - at_) + " bytes after the order");
  }

 private:
  std::uint64_t readNumber() {
    std::uint64_t value = 0;
    // 5 bytes hold all that is needed: 3 * 2^33.
    for (int shift = 0; shift < 35; shift += 7) {
      if (at_ == bytes_.size()) failInvalid(place_, "the order ends before its content does");
      const auto byte = std::to_integer<std::uint64_t>(bytes_[at_++]);
      value |= byte % 128 << shift;
      if (byte < 128) return value;
    }
    failInvalid(place_, "found a number of more than 5 bytes");
  }

  std::span<const std::byte> bytes_;
  const std::string& place_;
  std::size_t at_ = 0;
};

using Elements = std::vector<OrderReader::Element>;

void restoreVertices(const Elements& order, std::size_t stride, std::vector<std::byte>& positions) {
  std::vector<std::byte> restored(positions.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    std::memcpy(restored.data() + order[i].source * stride, positions.data() + i * stride, stride);
  }
  positions = std::move(restored);
}

void restoreTriangles(const Elements& order, const Elements& vertices, std::size_t index_bytes,
                      std::vector<std::byte>& indices) {
  const std::vector<std::uint32_t> decoded = readUnsigned(indices, index_bytes);
  std::vector<std::uint32_t> restored(decoded.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      // The decoder has checked each index against its table.
      restored[std::size_t{3} * order[i].source + (order[i].corner + corner) % 3] =
          vertices[decoded[3 * i + corner]].source;
    }
  }
  indices = writeUnsigned(restored, index_bytes);
}

}  // namespace

std::vector<std::byte> writeOriginalOrder(const EncodeResult& result) {
  std::vector<std::byte> bytes;
  for (const std::vector<std::uint32_t>& order : result.vertex_order) {
    std::int64_t previous = -1;
    for (const std::uint32_t vertex : order) {
      putNumber(zigzag(vertex - previous - 1), bytes);
      previous = vertex;
    }
  }
  for (const std::vector<std::uint32_t>& order : result.triangle_order) {
    std::int64_t previous = -1;
    for (const std::uint32_t entry : order) {
      const std::int64_t triangle = entry / 3;
      putNumber(3 * zigzag(triangle - previous - 1) + entry % 3, bytes);
      previous = triangle;
    }
  }
  putChecksum(bytes);
  return bytes;
}

void restoreOriginalOrder(std::span<const std::byte> order, const std::vector<OutputInfo>& outputs,
                          std::vector<std::vector<std::byte>>& decoded, const std::string& place) {
  OrderReader reader(order, place);
  std::vector<Elements> tables;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const OutputInfo& output = outputs[i];
    if (output.kind == OutputInfo::Kind::kPositions) {
      tables.push_back(reader.read(output.count, 1));
      restoreVertices(tables.back(), output.byte_stride, decoded[i]);
    } else {
      restoreTriangles(reader.read(output.count / 3, 3), tables.at(output.table), componentSize(output.type),
                       decoded[i]);
    }
  }
  reader.expectEnd();
}

}  // namespace tsc
