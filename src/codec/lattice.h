// The encoder's lattice: where it lies, how fine it may be, and what it guarantees (BITSTREAM.md, sections 6.1 and 10).
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "frame.h"
#include "header.h"
#include "tsc/codec.h"

namespace tsc {

/// The bounding box of all table vertices.
struct Box {
  glm::dvec3 lower{0};
  glm::dvec3 upper{0};
  double extent() const { return std::max({upper.x - lower.x, upper.y - lower.y, upper.z - lower.z}); }
  double magnitude() const {
    const glm::dvec3 far = glm::max(glm::abs(lower), glm::abs(upper));
    return std::max({far.x, far.y, far.z});
  }
};

Box boxOf(const Mesh& mesh);

/// Whether the finer lattice of tangent mode has room for the mesh.
bool fitsTangentMode(const Box& box, double step);

/// Sets the header's step, and where its lattice starts. Errors: kInvalidArgument, kLatticeTooFine.
[[nodiscard]] Status placeLattice(const Mesh& mesh, const EncodeOptions& options, Header& header);

/// The positions of the given welded vertices, in units of the fine lattice.
std::vector<glm::dvec3> targetsOf(std::span<const float> welded_positions, std::span<const std::uint32_t> welded,
                                  const Header& header);

}  // namespace tsc
