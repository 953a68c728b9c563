// What can be packed, and what must be packed together.
//
// A vertex table is the set of vertices behind one POSITION accessor, or several over the same bytes. Primitives that
// use it share its index space, be they triangles, lines or points. The tables of all triangle primitives of one mesh
// go into one stream, and so do meshes that share a table. Where one primitive of such a group cannot be packed, none
// is: its vertices would part from those of its neighbours.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data_access.h"
#include "order_extensions.h"
#include "tsc/gltf.h"

namespace tsc {

/// Modes of primitives, by their glTF number.
enum GlMode : std::uint32_t {
  kPoints = 0,
  kLines = 1,
  kLineLoop = 2,
  kLineStrip = 3,
  kTriangles = 4,
  kTriangleStrip = 5,
  kTriangleFan = 6,
};

/// One place where a primitive names a vertex accessor.
struct AttributeUse {
  std::optional<std::size_t> target;  ///< morph target, or none: the primitive's own attributes
  std::string name;
  std::size_t accessor;
};

struct PrimitiveInfo {
  std::size_t mesh = 0;
  std::size_t primitive = 0;
  std::uint32_t mode = kTriangles;
  std::optional<std::size_t> position;
  std::vector<AttributeUse> attributes;  ///< without the POSITION of the primitive itself
  std::optional<std::size_t> indices;
  std::optional<std::size_t> outline;   ///< vertex indices of CESIUM_primitive_outline
  std::optional<EdgeVisibility> edges;  ///< of EXT_mesh_primitive_edge_visibility
  bool plain_indices = false;           ///< its triangles keep their order, for EXT_mesh_manifold
  std::string keep_reason;              ///< why its vertices must keep their order; empty if they need not
  bool draco = false;                   ///< its accessors' data comes from a Draco stream

  bool isTriangles() const { return mode >= kTriangles; }
};

/// Triangles that are coded once: equal (table, indices, mode), where accessors over the same bytes are equal.
struct CodedPrimitive {
  std::size_t table;  ///< in `MeshGroup::tables`
  std::optional<std::size_t> indices;
  std::uint32_t mode;
  std::vector<std::uint32_t> triangles;  ///< the input, as 3 indices each
  std::uint32_t component_type;          ///< of the decoded indices
  std::vector<std::size_t> users;        ///< in `MeshSurvey::primitives`
};

struct GroupTable {
  std::size_t accessor;
  std::vector<std::size_t> users;  ///< primitives of any mode, in `MeshSurvey::primitives`
};

/// One stream to be.
struct MeshGroup {
  std::vector<std::size_t> meshes;
  std::vector<GroupTable> tables;
  std::vector<CodedPrimitive> primitives;
  std::uint32_t component_type = 0;  ///< of the positions
  std::string label;
};

struct MeshSurvey {
  std::vector<PrimitiveInfo> primitives;
  std::vector<Manifold> manifolds;
  std::vector<MeshGroup> groups;
  std::vector<KeptReport> kept;
};

/// Finds out what can be packed. Decodes Draco primitives into `data` on the way. Raises kInvalidInput on documents
/// that contradict themselves where pack must rely on them. `order_kept`: vertices and triangles will come back in
/// their order, so that no extension can stand in the way by naming them.
MeshSurvey surveyMeshes(const Asset& asset, DataAccess& data, bool order_kept = false);

/// The triangles that a primitive of this mode makes of its vertices, degenerate ones included. (glTF 2.0, 3.7.2.1)
std::vector<std::uint32_t> toTriangles(std::uint32_t mode, std::vector<std::uint32_t> indices);

/// A mesh's name, or "meshes/3".
std::string meshLabel(const Json& document, std::size_t mesh);

}  // namespace tsc
