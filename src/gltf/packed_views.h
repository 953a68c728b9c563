// Which buffer views of a document are packed, and by which stream.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tsc/gltf.h"

namespace tsc {

/// A buffer view that carries the extension.
struct PackedView {
  std::size_t view = 0;
  std::size_t output = 0;
  std::uint64_t byte_length = 0;
  std::optional<std::size_t> order;  ///< view with the original order, if that is kept
  std::string place;                 ///< JSON pointer of the extension
};

/// Packed views by the view that holds their stream; all of one stream have the same `order`. Raises kInvalidInput on
/// contradictions.
std::map<std::size_t, std::vector<PackedView>> findPackedViews(const Json& document);

}  // namespace tsc
