// Positions: prediction, residual in a local basis, reconstruction (BITSTREAM.md, section 6).
#pragma once

#include <span>
#include <vector>

#include "entropy.h"
#include "frame.h"
#include "order.h"
#include "references.h"
#include "stencil.h"
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
  bool candidates = false;         ///< single parallelograms have a part in the probabilities of residuals
  bool exact_hits = false;         ///< then residuals may also be signalled as exactly theirs
};

/// What coding starts from. Depends on nothing but the order, so that trials share it.
struct CodingStart {
  CodingOrder order;
  Buffer<VertexState> states;  ///< by time
};
/// The result refers to `surface` and `map`.
CodingStart codingStart(const Surface& surface, const PositionMap& map, Order order);

/// Codes the positions that the surface has, or the first `count` in the order of coding. `target` holds them by
/// position number, in steps and within +-2^26 on the fine lattice; `decoded`, if given, receives what the decoder will
/// have. Returns the sum of squared distances between the two, on the fine lattice.
double encodePositions(const CodingStart& start, const PositionParameters& parameters,
                       std::span<const glm::dvec3> target, EntropyWriter& writer, std::vector<Vec3>* decoded,
                       std::uint32_t count = kNone);
/// Codes the positions whose `states` these are, into their points. Errors: kTruncated.
[[nodiscard]] Status decodePositions(const CodingOrder& order, const PositionParameters& parameters,
                                     EntropyReader& reader, std::span<VertexState> states);

/// Coded positions by number.
std::vector<Vec3> pointsOf(const CodingOrder& order, std::span<const VertexState> states);

}  // namespace tsc
