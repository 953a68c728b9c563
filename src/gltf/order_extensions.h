// Extensions of meshes and primitives that name vertices and triangles by number and whose numbers pack can rewrite:
// CESIUM_primitive_outline, EXT_mesh_primitive_edge_visibility (draft) and EXT_mesh_manifold.
//
// An extension that breaks its own rules, or has members that are not known here, cannot be rewritten; then its mesh
// stays as it is, and the reason says what is wrong.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <vector>

#include "data_access.h"
#include "json_document.h"
#include "tsc/gltf.h"

namespace tsc {

inline constexpr std::string_view kOutline = "CESIUM_primitive_outline";
inline constexpr std::string_view kEdgeVisibility = "EXT_mesh_primitive_edge_visibility";
inline constexpr std::string_view kManifold = "EXT_mesh_manifold";

/// Accessors of EXT_mesh_primitive_edge_visibility. Edges are numbered as the triangles have them: edge 3 t + c goes
/// from corner c of triangle t to the next.
struct EdgeVisibility {
  std::optional<std::size_t> visibility;  ///< 2 bits an edge, lowest first; 1 is a silhouette
  std::optional<std::size_t> mates;       ///< a vertex for each silhouette, in the order of the edges
  std::optional<std::size_t> normals;     ///< instead, in earlier drafts: two 16-bit normals for each
  std::vector<std::size_t> line_strings;  ///< vertices; the type's largest value starts another string
};

/// What EXT_mesh_manifold adds to a mesh: its triangles once more, as one primitive in which the vertices along seams
/// are merged. The index accessor is all primitives' indices one after the other, with sparse values where vertices are
/// merged; `merge_indices` and `merge_values` say those values again.
///
/// All the mesh's index accessors are parts of that one array, in its order. A stream gives each primitive an array of
/// its own, and accessors on those can be neither joined nor sparse. So the indices of such a mesh stay plain, with the
/// vertices' new numbers, and its triangles keep their order.
struct Manifold {
  std::size_t mesh = 0;
  std::size_t position = 0;
  std::size_t indices = 0;
  std::optional<std::size_t> merge_indices;
  std::optional<std::size_t> merge_values;
};

/// The vertices behind a primitive, and how many triangles it makes of them.
struct PrimitiveSize {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

/// Reads and checks an extension of a primitive: the accessor of CESIUM_primitive_outline's edges, or the edges'
/// visibility; nothing if the primitive does not have it. Raises kInvalidInput or kUnsupported if it cannot be
/// rewritten.
std::optional<std::size_t> readOutline(const JsonView& primitive, const PrimitiveSize& size, DataAccess& data);
std::optional<EdgeVisibility> readEdgeVisibility(const JsonView& primitive, const PrimitiveSize& size,
                                                 DataAccess& data);

/// The same of EXT_mesh_manifold, as far as it stands in the mesh's own object: not that the primitives fit it.
std::optional<Manifold> readManifold(const JsonView& mesh, std::size_t index, DataAccess& data);

/// Every whole number in these extensions of a mesh or primitive: accessors, if anything.
std::set<std::uint64_t> numbersOfOrderExtensions(const Json& holder);

/// Visibility bits when triangles and their corners change places. `triangle_order` is `EncodeResult::triangle_order`;
/// `silhouettes` gets, for each silhouette in the new order, which one it was in the old.
std::vector<std::byte> reorderVisibility(std::span<const std::byte> visibility,
                                         std::span<const std::uint32_t> triangle_order,
                                         std::vector<std::uint32_t>& silhouettes);

/// Vertex numbers rewritten; `from_restart` and `to_restart`: the values that start another string, before and after.
std::vector<std::uint32_t> moveLineStrings(std::vector<std::uint32_t> indices, std::span<const std::uint32_t> new_index,
                                           std::uint32_t from_restart, std::uint32_t to_restart);

/// The value of an unsigned type that no index may have: all bits set.
std::uint32_t restartValue(std::size_t component_bytes);

}  // namespace tsc
