// Connectivity: the surface as vertex degrees, split and merge events (BITSTREAM.md, section 5).
#pragma once

#include "buffer.h"
#include "entropy.h"
#include "stencil.h"
#include "surface.h"
#include "tsc/codec.h"

namespace tsc {

// In the decoded numbering, a component's first face holds its first three vertices, all real, at its corners. Every
// later face has its gate's corners at 1 and 2, so `opposite` of its corner 0 lies in a face known before; a vertex
// that is new with it stands at corner 0, and that is its `vertex_corner`. A face that is closed between two known ones
// has the newer end of the edge that it leaves open at corner 0.

/// What the encoder learns about the decoder's numbering.
struct ConnectivityOrder {
  std::vector<std::uint32_t> vertex;  ///< for each decoded vertex, the vertex of the encoder's surface
  std::vector<std::uint32_t> corner;  ///< for each decoded face, the encoder's corner that became its first
};

/// Codes `surface`; returns it in the decoder's numbering through `decoded`, equal to what `decodeConnectivity` will
/// produce, and how that maps to the input numbering. O(n log n) at worst. `surface` must be closed, each vertex one
/// umbrella, each face with three different vertices, at most one of them a dummy, as `cutToManifold` gives it.
ConnectivityOrder encodeConnectivity(const Surface& surface, Effort effort, EntropyWriter& writer, Surface& decoded);

/// Decodes a surface of exactly these counts, those of the header. Linear time; memory for 2^18 faces, of which only
/// what is used is touched, then at most twice what the stream has given so far, whatever the header says. Errors:
/// kTruncated, kInvalidSymbol, kInvalidCount.
[[nodiscard]] Status decodeConnectivity(EntropyReader& reader, Effort effort, const SurfaceCounts& counts,
                                        Surface& surface);

/// The same at effort default without the surface's edges, `opposite` and `vertex_corner`: enters into `states` the
/// stencils that `collectStencils` would find, for positions that are coded in the order of the vertices.
[[nodiscard]] Status decodeConnectivity(EntropyReader& reader, const SurfaceCounts& counts, Surface& surface,
                                        Buffer<VertexState>& states);

}  // namespace tsc
