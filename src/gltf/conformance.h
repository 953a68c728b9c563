// What a packed asset must keep to before its streams are decoded, and after: the rules for assets under "Conformance"
// in extension-spec/README.md. Rules 3 and 13 are left to the codec, packed_views.h and original_order.h.
//
// A document may contradict its streams in ways that plain glTF readers would fall over (or worse) later, when nothing
// tells the cause any more. So whatever breaks a rule is refused with its place, what was found and what was expected.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "packed_views.h"
#include "tsc/codec.h"
#include "tsc/gltf.h"

namespace tsc {

/// A POSITION accessor on a compressed view.
struct PackedPositions {
  std::size_t accessor = 0;
  std::size_t output = 0;
};

/// One stream of an asset that keeps to the rules.
struct PackedStream {
  std::size_t view = 0;           ///< that holds it
  std::vector<PackedView> views;  ///< one or more, each another output
  StreamInfo info;
  std::vector<PackedPositions> positions;
};

/// Checks the document and the streams' headers: rules 1, 2, 4 to 7, 9 to 11 and the exclusions. Decodes nothing and
/// allocates in proportion to the input. Raises kInvalidInput, and kUnsupported where a stream's bytes are elsewhere.
std::vector<PackedStream> checkConformance(const Asset& asset);

/// Checks what only the decoded arrays (in their original order, if that is kept) can tell: that bounds are those of
/// the positions (rule 8), and that fallback data is the same (rule 12). Raises kInvalidInput.
void checkDecoded(const Asset& asset, const PackedStream& stream, const std::vector<std::vector<std::byte>>& decoded);

}  // namespace tsc
