// Triangles as a closed, oriented, manifold surface, which is what the connectivity coder codes.
//
// Positions are welded; degenerate and duplicate triangles are set aside; the rest is cut apart wherever it is not an
// oriented 2-manifold, so that one position may be met by several *cut vertices*. Each loop of boundary edges is then
// closed by a fan of dummy faces around one dummy vertex: every corner has an opposite, and no umbrella has an end.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "buffer.h"
#include "tsc/codec.h"

namespace tsc {

inline constexpr std::uint32_t kNone = 0xffffffffu;
/// Faces, dummies included, are fewer than this: the count of corners at a position fits 29 bits.
inline constexpr std::uint32_t kMaxSurfaceFaces = (1u << 29) / 3;

inline std::uint32_t nextCorner(std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
inline std::uint32_t previousCorner(std::uint32_t corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

/// What the header says of a surface.
struct SurfaceCounts {
  std::uint32_t faces = 0;  ///< those of dummies included; even
  std::uint32_t real_vertices = 0;
  std::uint32_t dummies = 0;

  std::uint32_t vertices() const { return real_vertices + dummies; }
  friend bool operator==(const SurfaceCounts&, const SurfaceCounts&) = default;
};

/// A corner table (Rossignac). Corner c belongs to face c / 3; corners run counter-clockwise. Both the encoder and the
/// decoder hold it in the decoder's numbering: faces, real vertices and dummies, each in the order in which decoding
/// creates them.
struct Surface {
  Buffer<std::uint32_t> corner_vertex;  ///< vertex at each corner, 3 a face
  Buffer<std::uint32_t> opposite;       ///< corner facing the same edge from the other side; never kNone
  Buffer<std::uint32_t> vertex_corner;  ///< for each vertex one of its corners, the same on both sides
  std::uint32_t real_count = 0;         ///< vertices of the mesh, which come first
  std::uint32_t dummy_count = 0;        ///< vertices that close holes, numbered after them
  bool isDummy(std::uint32_t vertex) const { return vertex >= real_count; }
  std::uint32_t vertexCount() const { return real_count + dummy_count; }
  std::uint32_t faceCount() const { return static_cast<std::uint32_t>(corner_vertex.size() / 3); }
  SurfaceCounts counts() const { return {faceCount(), real_count, dummy_count}; }
};

/// Next corner at the same vertex, counter-clockwise: across the edge that leaves the vertex to the left.
inline std::uint32_t nextAroundVertex(const Surface& surface, std::uint32_t corner) {
  return nextCorner(surface.opposite[nextCorner(corner)]);
}

/// Triangles over welded vertices, ready to be cut.
struct WeldedMesh {
  std::vector<float> positions;              ///< x y z of each distinct position; -0 is +0
  std::vector<std::uint32_t> corner_vertex;  ///< welded vertex of each input corner, primitives concatenated
};

/// The encoder's view of a mesh: what the connectivity coder gets.
struct CutMesh {
  Surface surface;  ///< real faces first in input order without the side faces, then the dummy faces
  std::vector<std::uint32_t> welded_vertex;  ///< for each cut vertex its welded vertex; kNone for dummies
  std::vector<std::uint32_t> input_face;     ///< for each real face of the surface: the input face; kNone for dummies
  std::vector<std::uint32_t> side_faces;     ///< input faces that are degenerate, or duplicate an earlier face's three
                                             ///< vertices in the same orientation
};

/// A mesh whose tables have been welded.
struct WeldResult {
  WeldedMesh mesh;
  std::vector<std::vector<std::uint32_t>> table_vertex_to_welded;  ///< [table][vertex] -> welded vertex
};

/// Welds by bit-exact position (-0 and +0 are one), over all tables; unused vertices too. Welded vertices are numbered
/// by first appearance in the tables. Every index must be below its table's vertex count, and fewer than 2^32 - 1
/// corners and vertices are allowed in all. Linear time (hashing).
WeldResult weld(const Mesh& mesh);

/// Cuts to an oriented edge-manifold and vertex-manifold surface. An edge met by more than two faces pairs those of
/// opposite direction with the flattest dihedral angle first; a face is never paired with its own flip side, so
/// two-sided geometry becomes two sheets. `corner_vertex` may be any triangle soup over the vertices of
/// `welded_positions`. Deterministic on every platform, O(n log n) at worst, no recursion.
CutMesh cutToManifold(std::span<const float> welded_positions, std::span<const std::uint32_t> corner_vertex);

}  // namespace tsc
