// From the decoded surface back to tables and primitives (BITSTREAM.md, section 7): which primitive each face belongs
// to, which table vertex each corner uses, the faces that are no part of the surface, and table vertices that no face
// uses. Which cut vertices repeat a position comes before, in references.h.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "entropy.h"
#include "references.h"
#include "surface.h"
#include "tsc/codec.h"

namespace tsc {

/// Which table vertices there are and how faces use them; what the header's counts and flags say is in `Counts`.
struct Assignment {
  /// Header fields. The numbers of side faces and of unused vertices follow from them and the surface.
  struct Counts {
    std::vector<std::uint32_t> table_vertex_count;    ///< per table
    std::vector<std::uint32_t> primitive_table;       ///< per primitive
    std::vector<std::uint32_t> primitive_face_count;  ///< per primitive, side faces included
    bool one_vertex_per_position = false;  ///< one table, every position exactly one vertex: corners need no symbols
  };
  /// Per table: position number of each vertex. Empty with one vertex per position, where the numbers are the same.
  std::vector<std::vector<std::uint32_t>> table_position;
  std::vector<Buffer<std::uint32_t>> primitive_indices;  ///< per primitive: 3 table vertices a face; surface faces in
                                                         ///< their order, then side faces
  std::uint32_t position_count = 0;  ///< the surface's, and those that only side faces and unused vertices have
};

/// The encoder's input, in the decoder's numbering of surface faces and vertices.
struct AssignmentInput {
  std::vector<std::uint32_t> face_primitive;  ///< per surface face; kNone for dummy faces
  std::vector<std::uint32_t> corner_vertex;   ///< per surface corner: input table vertex; kNone on dummy faces
  struct SideFace {
    std::uint32_t primitive;
    std::uint32_t table_vertex[3];  ///< input table vertices
  };
  std::vector<SideFace> side_faces;
  std::vector<std::vector<std::uint32_t>> table_welded;  ///< per table: welded vertex of each input vertex
  std::vector<std::uint32_t> welded_position;  ///< per welded vertex: position number, kNone where the surface does not
                                               ///< have it; see numberPositions
  /// Per welded vertex: unused vertices come in this order, next to each other those that lie near. By number if empty.
  std::vector<std::uint64_t> welded_rank;
};

/// How the decoder's numbering maps to the input's.
struct AssignmentOrder {
  std::vector<std::vector<std::uint32_t>> vertex;  ///< per table: input vertex of each decoded vertex
  /// Per primitive, for each decoded triangle: 3 * face + first corner. `face` is a surface face, with first corner 0,
  /// or the surface's face count + i for side face i. Decoded corner c is that face's corner (first corner + c) % 3.
  std::vector<std::vector<std::uint32_t>> triangle;
  std::vector<std::uint32_t> extra_positions;  ///< welded vertex of each position beyond the surface's, in order
};

/// The header fields for an input whose primitives use the tables `primitive_table`.
Assignment::Counts countAssignment(const AssignmentInput& input, std::span<const std::uint32_t> primitive_table);

/// Codes the assignment and returns in `decoded` what the decoder will have.
/// `positions` holds for each of the surface's map.position_count positions its decoded lattice coordinates, within
/// +-kCoordinateLimit and the same on both sides; seams follow the creases that they show. It may be empty on both
/// sides, at some cost in bits.
AssignmentOrder encodeAssignment(const Surface& surface, const PositionMap& map, std::span<const glm::ivec3> positions,
                                 const AssignmentInput& input, const Assignment::Counts& counts, EntropyWriter& writer,
                                 Assignment& decoded);

/// `counts` must have been checked against the caller's limits, and each primitive_table against the number of tables.
/// Linear time and memory in `counts` and the surface, whatever the stream says. Takes its result from the surface's
/// memory where it can.
/// Errors: kTruncated, kInvalidSymbol, kInvalidCount.
[[nodiscard]] Status decodeAssignment(Surface&& surface, const PositionMap& map, std::span<const glm::ivec3> positions,
                                      const Assignment::Counts& counts, EntropyReader& reader, Assignment& assignment);

}  // namespace tsc
