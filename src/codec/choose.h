// The choice of how positions are coded: what the caller leaves open is tried, and the least bits at equal error win
// (BITSTREAM.md, section 10).
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "entropy.h"
#include "header.h"
#include "lattice.h"
#include "positions.h"

namespace tsc {

/// The positions to code.
struct PositionInput {
  const Surface& surface;
  const PositionMap& map;
  std::span<const float> welded_positions;         ///< x y z of each welded vertex
  std::span<const std::uint32_t> position_welded;  ///< welded vertex of each surface position
};

inline constexpr double kLeastError = 0.15;  // a uniform error has 1/4

/// One way to code the positions, tried on all or on the first of them.
struct Trial {
  PositionParameters parameters;
  EntropyWriter writer;
  std::vector<Vec3> decoded;
  std::uint32_t position_count = 0;  ///< of those tried
  double bits = 0;
  double squared_error = 0;  ///< sum over positions, in squared steps

  /// Bits at equal mean squared error: halving the error costs half a bit a coordinate. What is coded exactly, such as
  /// vertices without a stencil, earns no more than rounding to a finer normal would.
  double cost() const {
    const auto n = static_cast<double>(position_count);
    return bits + 1.5 * n * approximateLog2(std::max(squared_error / std::max(n, 1.0), kLeastError));
  }
};

/// The cheapest way that the options allow. `header` gives the lattice.
Trial bestPositions(const PositionInput& input, const Header& header, const EncodeOptions& options, const Box& box);

}  // namespace tsc
