// Pack's edits to the document: accessors and primitives of coded meshes point at what their streams decode to, and
// everything else that follows the order of their vertices moves along, or stays where that order is kept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "accessor_editor.h"
#include "buffer_editor.h"
#include "codec_mesh.h"
#include "data_access.h"
#include "mesh_groups.h"
#include "order_patcher.h"
#include "tsc/gltf.h"

namespace tsc {

class DocumentPatcher {
 public:
  /// `data` reads `original`, an unchanged copy of the asset; edits go to `asset`. `coded`: all groups to be patched.
  DocumentPatcher(Asset& asset, const Asset& original, DataAccess& data, BufferEditor& buffers,
                  const MeshSurvey& survey, const std::vector<CodedGroup>& coded, const PackOptions& options);

  /// Patches one group; its stream's bytes move into the buffers.
  void patch(CodedGroup& coded);

  /// When all groups are patched: cuts old views down to what those accessors need that still use them.
  void trimViews();

  /// Bytes of attributes carried along.
  std::uint64_t attributeBytes() const { return accessors_.attributeBytes(); }

  /// What a person might want to know.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  /// What is left of an old view once the packed data has gone.
  struct ViewUse {
    std::vector<std::size_t> accessors;
    std::uint64_t begin = UINT64_MAX;
    std::uint64_t end = 0;
    bool lost_some = false;
  };

  std::map<std::uint64_t, ViewUse> remainingUses();
  std::uint64_t addOutput(const CodedGroup& coded, std::size_t output, std::uint64_t stream, std::uint64_t order);
  void patchTable(const CodedGroup& coded, std::size_t table, std::uint64_t view);
  void patchIndices(const CodedGroup& coded, std::size_t primitive, std::uint64_t view);
  std::size_t patchPosition(std::size_t old, const CodedGroup& coded, std::size_t table, std::uint64_t view);
  std::size_t moveAttribute(std::size_t old, IndexSpace& space);
  void moveIndices(const PrimitiveInfo& info, IndexSpace& space);
  void patchManifold(const Manifold& manifold, const CodedGroup& coded, std::size_t table, std::uint64_t view,
                     AccessorMap& positions, IndexSpace& space);
  bool isNeeded(const CodedPrimitive& primitive) const;
  Json& primitiveJson(const PrimitiveInfo& info);
  bool staysAsItIs(std::size_t accessor) const;
  bool keepsIndices(const PrimitiveInfo& info) const;
  std::set<std::uint64_t> foreignAccessors(const std::vector<CodedGroup>& coded) const;
  void insertOrderAccessors(const std::set<std::size_t>& moving, std::set<std::uint64_t>& foreign) const;

  Asset& asset_;
  const Asset& original_;
  DataAccess& data_;
  BufferEditor& buffers_;
  const MeshSurvey& survey_;
  const PackOptions& options_;
  AccessorEditor accessors_;
  OrderPatcher order_patcher_;
  std::vector<std::string> warnings_;
};

}  // namespace tsc
