// Positions: prediction, residual in a local basis, reconstruction (BITSTREAM.md, section 6).
#pragma once

#include <span>
#include <vector>

#include "entropy.h"
#include "frame.h"
#include "references.h"
#include "surface.h"
#include "tsc/codec.h"

namespace tsc {

/// How positions are coded; all of it stands in the header.
struct PositionParameters {
  Mode mode = Mode::kLattice;
  Basis basis = Basis::kGate;
  Predictor predictor = Predictor::kAverage;
  Order order = Order::kTraversal;
  Effort effort = Effort::kDefault;
  int fine_bits = 0;               ///< k: the fine lattice has 2^k points to a tangential step; 0 in lattice mode
  std::uint32_t normal_scale = 1;  ///< in tangent mode
  bool exact_hits = false;         ///< residuals may be signalled as exactly a candidate's
};

/// Codes the positions that the surface has. `target` holds them by position number, in units of the fine lattice and
/// within +-2^26; `decoded` receives what the decoder will have.
void encodePositions(const Surface& surface, const PositionMap& map, const PositionParameters& parameters,
                     std::span<const glm::dvec3> target, EntropyWriter& writer, std::vector<Vec3>& decoded);
/// Errors: kTruncated.
[[nodiscard]] Status decodePositions(const Surface& surface, const PositionMap& map,
                                     const PositionParameters& parameters, EntropyReader& reader,
                                     std::vector<Vec3>& decoded);

/// Codes positions that only side faces and unused vertices have, as many as `decoded` holds.
void encodeExtraPositions(std::span<const glm::dvec3> target, EntropyWriter& writer, std::span<Vec3> decoded);
/// Errors: kTruncated.
[[nodiscard]] Status decodeExtraPositions(EntropyReader& reader, std::span<Vec3> decoded);

}  // namespace tsc
