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

/// Codes the positions that the surface has, or the first `count` in the order of coding. `target` holds them by
/// position number, in units of the fine lattice and within +-2^26; `decoded` receives what the decoder will have.
/// Returns the sum of squared distances between the two, in these units.
double encodePositions(const Surface& surface, const PositionMap& map, const PositionParameters& parameters,
                       std::span<const glm::dvec3> target, EntropyWriter& writer, std::vector<Vec3>& decoded,
                       std::uint32_t count = kNone);
/// `edges_end_here`: nothing after this needs the surface's edges, whose memory is then given back before the result
/// takes its own. Errors: kTruncated.
[[nodiscard]] Status decodePositions(Surface& surface, const PositionMap& map, const PositionParameters& parameters,
                                     bool edges_end_here, EntropyReader& reader, std::vector<Vec3>& decoded);

}  // namespace tsc
