// Decoded arrays and their checksum: the end of decoding, which the encoder does as well (BITSTREAM.md, section 8).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "assignment.h"
#include "header.h"

namespace tsc {

/// Position of a lattice point in position units: computed in double, rounded once to float (section 6.1).
class Lattice {
 public:
  explicit Lattice(const Header& header);
  /// In double; finite as a float in every valid stream.
  double coordinate(std::int32_t q, int axis) const {
    return origin_[axis] + (static_cast<double>(q) + anchor_[axis]) * fine_step_;
  }

 private:
  std::array<double, 3> origin_;
  std::array<double, 3> anchor_;  ///< on the fine lattice
  double fine_step_;
};

/// Lattice positions by number: the first may still stand in their states.
struct Points {
  std::span<const VertexState> states;
  std::span<const Vec3> others;

  Vec3 operator[](std::size_t position) const {
    return position < states.size() ? vectorOf(states[position].point) : others[position - states.size()];
  }
};

/// Fills the output of a table, whose size is that of `outputsOf(header)`; `numbers` as in Assignment::table_position.
/// Error: kInvalidCount for a position out of its type's range.
[[nodiscard]] Status writePositions(const Header& header, std::span<const std::uint32_t> numbers, const Points& points,
                                    std::span<std::byte> output);

/// Fills the output of a primitive.
void writeIndices(ComponentType type, std::span<const std::uint32_t> indices, std::span<std::byte> output);

/// Fills all outputs: tables, then primitives.
[[nodiscard]] Status writeOutputs(const Header& header, const Assignment& assignment, const Points& points,
                                  std::span<const std::span<std::byte>> outputs);

/// Chained over the header's bytes and all outputs; the low 32 bits.
std::uint32_t checksumOf(std::span<const std::byte> header_bytes, std::span<const std::span<std::byte>> outputs);

}  // namespace tsc
