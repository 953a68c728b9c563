// A Laplacian baseline: delta coordinates with anchors, the family that "Error propagation control in Laplacian mesh
// compression" (Vasa & Dvorak 2018, EPC) belongs to and the paper's third competitor.
//
// This is our own re-implementation of the idea, not of EPC itself, whose code is not public: high-pass quantisation
// after Sorkine, Cohen-Or & Toledo 2003. Each vertex sends its offset from its neighbours' mean, quantised uniformly;
// every 200th vertex also sends its position; the decoder solves for the positions by least squares.
#pragma once

#include <memory>

#include "measure.h"

namespace tsc::bench {

class LaplacianCodec {
 public:
  /// Factorises the system, once for all steps; seconds from 100,000 vertices on. Throws std::runtime_error when that
  /// fails.
  explicit LaplacianCodec(const BenchMesh& mesh);
  ~LaplacianCodec();

  /// Quantises offsets with `step` and anchors with the same, codes both with adaptive models, solves, measures.
  /// Connectivity is charged at what our own codec spends on it.
  CodecPoint run(double step) const;

 private:
  struct System;
  std::unique_ptr<System> system_;
};

}  // namespace tsc::bench
