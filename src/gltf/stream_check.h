// The self-check of pack: decodes a stream and compares it with what went in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tsc/codec.h"

namespace tsc {

/// Decodes `result.bytes` and compares: the same triangles over the same corners, every vertex once, each position
/// within `bound`. Gives the decoded arrays, or raises kBound naming `label`.
std::vector<std::vector<std::byte>> decodeAndCompare(const Mesh& mesh, const EncodeResult& result, double bound,
                                                     const std::string& label);

/// Decoded positions of one output as floats, 3 a vertex, whatever their type.
std::vector<float> positionsAsFloats(const std::vector<std::byte>& bytes, ComponentType type);

}  // namespace tsc
