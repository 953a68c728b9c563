// Which vertices of the surface repeat a position (BITSTREAM.md, section 7.1): cutting the mesh into a manifold leaves
// several cut vertices at one position, and only the first of them carries coordinates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "entropy.h"
#include "surface.h"
#include "tsc/codec.h"

namespace tsc {

/// For each vertex of the surface its position number: positions are numbered by first appearance in the surface's
/// vertex order; a vertex with an earlier number repeats that position. kNone, or any number beyond, for dummies.
struct PositionMap {
  std::vector<std::uint32_t> vertex_position;  ///< empty where no position repeats: vertices have the same numbers
  std::uint32_t position_count = 0;

  bool isIdentity() const { return vertex_position.empty(); }
  std::uint32_t positionOf(std::uint32_t vertex) const {
    return vertex_position.empty() ? vertex : vertex_position[vertex];
  }
};

/// Numbers the positions of a surface. `vertex_welded` holds for each vertex of the surface its welded vertex (kNone
/// for dummies), each below `welded_count`. `welded_position` receives for each welded vertex its position number,
/// kNone where the surface does not have it.
PositionMap numberPositions(std::span<const std::uint32_t> vertex_welded, std::uint32_t welded_count,
                            std::vector<std::uint32_t>& welded_position);

/// `has_references` is a header flag: false when no position repeats, and nothing is then coded.
void encodeReferences(const Surface& surface, const PositionMap& map, bool has_references, EntropyWriter& writer);
/// Linear time and memory in the surface, whatever the stream says. Errors: kTruncated, kInvalidSymbol.
[[nodiscard]] Status decodeReferences(const Surface& surface, bool has_references, EntropyReader& reader,
                                      PositionMap& map);

}  // namespace tsc
