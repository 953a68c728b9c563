// From what the user asks for (bits, a bound, a size) to the options of one stream.
#pragma once

#include <string>

#include "tsc/codec.h"
#include "tsc/gltf.h"

namespace tsc {

/// Length of the diagonal of the bounding box of all positions.
double diagonalOf(const Mesh& mesh);

/// The codec's options for this mesh. Raises kUsage for impossible values, kBound where no step meets the bound.
EncodeOptions chooseEncodeOptions(const Mesh& mesh, const PackOptions& options, const std::string& label);

/// Raises kUsage where an option is out of its range.
void checkPackOptions(const PackOptions& options);

}  // namespace tsc
