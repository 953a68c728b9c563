// Positions that the surface does not have: those of side faces and unused vertices (BITSTREAM.md, section 6.8).
#pragma once

#include <span>

#include "entropy.h"
#include "positions.h"

namespace tsc {

/// How coarse extra positions are: multiples of 2^bits on the fine lattice. Whole steps, or half ones where a finer
/// normal step asks for more.
inline int extraPositionBits(const PositionParameters& parameters) {
  return parameters.fine_bits - (parameters.normal_scale > 1 ? 1 : 0);
}

/// Codes positions that only side faces and unused vertices have, as many as `decoded` holds, as multiples of 2^bits.
void encodeExtraPositions(std::span<const glm::dvec3> target, int bits, EntropyWriter& writer, std::span<Vec3> decoded);
/// Errors: kTruncated.
[[nodiscard]] Status decodeExtraPositions(EntropyReader& reader, int bits, std::span<Vec3> decoded);

}  // namespace tsc
