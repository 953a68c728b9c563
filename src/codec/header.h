// The header: all that decoding needs to know before the first symbol (BITSTREAM.md, section 2).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "assignment.h"
#include "positions.h"
#include "tsc/codec.h"

namespace tsc {

struct Header {
  PositionParameters positions;
  ComponentType position_type = ComponentType::kFloat32;
  bool has_references = false;
  bool anchored = false;
  float step = 1;                        ///< tangential step; 1 for integer positions, not stored
  std::array<float, 3> origin{};         ///< float positions that are not anchored
  std::array<std::int64_t, 3> anchor{};  ///< otherwise: the origin in steps
  SurfaceCounts surface;
  Assignment::Counts counts;
  std::vector<ComponentType> index_types;  ///< per primitive
};

/// Appends the header to `bytes`.
void writeHeader(const Header& header, std::vector<std::byte>& bytes);

/// Reads and checks the header; `size` receives its length. Every count is checked against `limits` before anything is
/// allocated for it. Errors: kTruncated, kUnsupportedVersion, kReservedBits, kInvalidCount, kLimitExceeded.
[[nodiscard]] Status readHeader(std::span<const std::byte> stream, const DecodeLimits& limits, Header& header,
                                std::size_t& size);

/// The outputs that a stream with this header decodes to.
std::vector<OutputInfo> outputsOf(const Header& header);

}  // namespace tsc
