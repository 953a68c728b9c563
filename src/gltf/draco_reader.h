// Primitives compressed with KHR_draco_mesh_compression: what they hold, in the place of their accessors' data.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "data_access.h"
#include "json_document.h"
#include "mesh_groups.h"

namespace tsc {

class DracoReader {
 public:
  explicit DracoReader(DataAccess& data) : data_(data) {}

  /// Decodes a primitive, if it is Draco's, into overlays of `data`. Raises kInvalidInput and kUnsupported.
  void read(const JsonView& primitive, PrimitiveInfo& info);

 private:
  bool hasPlainData(const PrimitiveInfo& info) const;
  void claim(std::size_t accessor, std::size_t view, const std::string& place);

  DataAccess& data_;
  std::map<std::size_t, std::size_t> owners_;  ///< view of the Draco stream, by accessor
};

}  // namespace tsc
