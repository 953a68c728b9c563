// The original order of vertices and triangles, for assets whose packed form must keep it (--keep-order).
//
// A stream decodes to vertices and triangles in an order of its own. Where
// `extensions.EXT_mesh_tangentspace_compression` of a buffer view has a member `order`, the arrays that the view stands
// for are those of the stream, put back by the permutations in the buffer view `order.bufferView`. All views of one
// stream name the same one.
//
// Its bytes: for each output of the stream, in the order of the outputs, one variable-length number an element; at the
// end the XXH64 (seed 0) of all bytes before, little-endian. Numbers are LEB128: 7 bits a byte, lowest first, the top
// bit set on all bytes but the last.
//   Positions: element i says which original vertex v(i) the decoded vertex i is: zigzag(v(i) - v(i-1) - 1), v(-1) =
//   -1. Indices:   element i says which original triangle t(i) the decoded triangle i is, and at which of its corners
//   k(i)
//              that one begins (decoded corner c is original corner (k + c) mod 3):
//              3 * zigzag(t(i) - t(i-1) - 1) + k(i), t(-1) = -1.
// zigzag(x) is 2x for x >= 0 and -2x - 1 otherwise.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "tsc/codec.h"

namespace tsc {

/// The bytes of the order view for what `encode` gave.
std::vector<std::byte> writeOriginalOrder(const EncodeResult& result);

/// Puts decoded arrays back into their original order: vertices, triangles, first corners, and the vertex numbers in
/// the triangles. Raises kInvalidInput, naming `place`, where `order` is damaged or does not fit; input may be hostile.
void restoreOriginalOrder(std::span<const std::byte> order, const std::vector<OutputInfo>& outputs,
                          std::vector<std::vector<std::byte>>& decoded, const std::string& place);

}  // namespace tsc
