// The paper's codec as a model in double precision: what its Figure 2 shows of the first triangle, without the integer
// arithmetic that makes our codec's streams the same on every machine.
#pragma once

#include "measure.h"

namespace tsc::bench {

struct PaperModel {
  bool exact_start = true;         ///< the first triangle as it is, or rounded to the tangential step
  std::uint32_t normal_scale = 1;  ///< normal step = step / normal_scale
  int lattice_bits = 0;            ///< decoded positions are rounded to step / 2^lattice_bits; 0: not at all
};

/// Parallelogram prediction (eq. 1) along a breadth-first traversal, residuals in the tip-aligned basis (eq. 7), bits
/// by the entropy of each component's values. Connectivity is charged at what our own codec spends on it. For a mesh of
/// one edge-connected part; throws std::runtime_error on another. Borrows `mesh`.
StepCodec makePaperModel(const BenchMesh& mesh, const PaperModel& model);

}  // namespace tsc::bench
