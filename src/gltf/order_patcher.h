// Pack's edits to the extensions of order_extensions.h: their accessors follow the vertices and triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>

#include "accessor_editor.h"
#include "data_access.h"
#include "mesh_groups.h"
#include "order_extensions.h"
#include "tsc/gltf.h"

namespace tsc {

class OrderPatcher {
 public:
  /// `data` reads an unchanged copy of the asset; edits go to `asset`, through `accessors`.
  OrderPatcher(Asset& asset, DataAccess& data, AccessorEditor& accessors)
      : asset_(asset), data_(data), accessors_(accessors) {}

  /// What names vertices of a primitive, when they have got the numbers of `space`. `same_triangles`: its triangles
  /// keep their order; otherwise `patchTriangles` must follow.
  void patchVertices(const PrimitiveInfo& info, IndexSpace& space, bool same_triangles);

  /// What goes by the order of a primitive's triangles. `triangle_order` is `EncodeResult::triangle_order`. One call
  /// for all primitives that have these triangles, so that those that share accessors still do.
  void patchTriangles(std::span<const PrimitiveInfo* const> users, std::span<const std::uint32_t> triangle_order,
                      std::span<const std::uint32_t> new_index);

  /// The indices of EXT_mesh_manifold and those of the mesh's primitives, `users`, in it: one array, renumbered. The
  /// primitives' accessors go into `space.indices`.
  void patchManifold(const Manifold& manifold, std::span<const PrimitiveInfo* const> users, IndexSpace& space);

 private:
  Json& edgesJson(const PrimitiveInfo& info);
  std::size_t moveLineStrings(std::size_t old, IndexSpace& space);
  void patchMates(Json& edges, std::size_t old, std::span<const std::uint32_t> silhouettes,
                  std::span<const std::uint32_t> new_index);
  void patchNormals(Json& edges, std::size_t old, std::span<const std::uint32_t> silhouettes);
  void patchMerges(const Manifold& manifold, const AccessorInfo& indices, std::size_t accessor, std::uint32_t type,
                   std::span<const std::uint32_t> new_index);

  Asset& asset_;
  DataAccess& data_;
  AccessorEditor& accessors_;
};

}  // namespace tsc
