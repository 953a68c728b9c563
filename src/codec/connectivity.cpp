// Connectivity by vertex degrees, in the manner of Touma and Gotsman (Triangle Mesh Compression, 1998), on closed
// surfaces: one symbol for each new vertex, splits and handles by node number (BITSTREAM.md, section 5).
//
// Both directions run the same `Traversal` and the same `TipCoder`; what only one of them knows stands here.
#include "connectivity.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "averaged_tips.h"
#include "direction.h"
#include "mixed_tips.h"
#include "tips.h"
#include "traversal.h"

namespace tsc {
namespace {

// --------------------------------------------------------------------------------------------------------- Encoding

template <class Symbols>
class EncoderEvents {
 public:
  EncoderEvents(const Surface& surface, EntropyWriter& writer)
      : surface_(surface),
        coder_(Writing{writer}, surface.vertexCount()),
        degree_(surface.vertexCount(), 0),
        is_met_(surface.vertexCount(), 0),
        is_known_(surface.faceCount(), 0),
        corner_node_(surface.corner_vertex.size(), kNone) {
    for (const std::uint32_t vertex : surface.corner_vertex) ++degree_[vertex];
    order_.vertex.resize(surface.vertexCount());
    order_.corner.reserve(surface.faceCount());
  }

  ConnectivityOrder takeOrder() { return std::move(order_); }

  /// The first face in the input's order that is not known yet, and is not a dummy's.
  void start(std::uint32_t (&degrees)[3]) {
    while (is_known_[next_start_] || touchesDummy(next_start_)) ++next_start_;
    addFace(3 * next_start_);
    for (std::uint32_t k = 0; k < 3; ++k) {
      degrees[k] = degree_[surface_.corner_vertex[3 * next_start_ + k]];
      coder_.codeStart(degrees[k]);
    }
  }

  void face(std::uint32_t gate_corner) { addFace(surface_.opposite[input(gate_corner)]); }

  Tip tip(const Gate& gate, const Front& front) {
    const std::uint32_t corner = order_.corner.back();
    const std::uint32_t vertex = surface_.corner_vertex[corner];
    const Tip tip = is_met_[vertex]            ? findNode(corner, front)
                    : surface_.isDummy(vertex) ? newDummy(degree_[vertex])
                                               : newVertex(degree_[vertex]);
    coder_.code(front, gate, tip);
    return tip;
  }

  void vertex(std::uint32_t vertex, std::uint32_t corner) {
    order_.vertex[vertex] = surface_.corner_vertex[input(corner)];
    is_met_[order_.vertex[vertex]] = 1;
  }

  void edge(std::uint32_t node, std::uint32_t corner) { corner_node_[input(corner)] = node; }
  bool failed() const { return false; }

 private:
  /// The input's corner for one of the decoder's.
  std::uint32_t input(std::uint32_t corner) const {
    const std::uint32_t first = order_.corner[corner / 3];
    const std::uint32_t rotated = first + corner % 3;
    return rotated / 3 == first / 3 ? rotated : rotated - 3;
  }

  bool touchesDummy(std::uint32_t face) const {
    const std::uint32_t* v = &surface_.corner_vertex[std::size_t{3} * face];
    return surface_.isDummy(std::max({v[0], v[1], v[2]}));
  }

  void addFace(std::uint32_t first_corner) {
    order_.corner.push_back(first_corner);
    is_known_[first_corner / 3] = 1;
  }

  /// The front's node for the unknown sector that holds `tip_corner`. Turns both ways in step, so that the cost is that
  /// of the smaller part, and over all splits of a vertex O(n log n).
  Tip findNode(std::uint32_t tip_corner, const Front& front) const {
    Tip tip{.is_split = true};
    std::uint32_t right = tip_corner;
    std::uint32_t left = tip_corner;
    for (std::uint32_t passed = 0;; ++passed) {
      const std::uint32_t across_right = surface_.opposite[previousCorner(right)];
      if (is_known_[across_right / 3]) {
        tip.node = corner_node_[across_right];
        tip.right_valence = passed - 1;
        return tip;
      }
      const std::uint32_t across_left = surface_.opposite[nextCorner(left)];
      if (is_known_[across_left / 3]) {
        tip.node = front[corner_node_[across_left]].next();
        tip.right_valence = front[tip.node].free_valence - 2 - (passed - 1);
        return tip;
      }
      right = previousCorner(across_right);
      left = nextCorner(across_left);
    }
  }

  const Surface& surface_;
  TipCoder<Writing, Symbols> coder_;
  ConnectivityOrder order_;
  std::vector<std::uint32_t> degree_;
  std::vector<std::uint8_t> is_met_;
  std::vector<std::uint8_t> is_known_;      ///< per input face
  std::vector<std::uint32_t> corner_node_;  ///< per input corner: the node whose edge it faced last
  std::uint32_t next_start_ = 0;
};

// --------------------------------------------------------------------------------------------------------- Decoding

template <class Symbols>
class DecoderEvents {
 public:
  DecoderEvents(EntropyReader& reader, std::uint32_t vertex_count)
      : reader_(reader), coder_(Reading{reader}, vertex_count) {}

  void start(std::uint32_t (&degrees)[3]) {
    for (std::uint32_t& degree : degrees) degree = coder_.codeStart(0);
  }
  void face(std::uint32_t) {}
  Tip tip(const Gate& gate, const Front& front) { return coder_.code(front, gate, kUnknown); }
  void vertex(std::uint32_t, std::uint32_t) {}
  void edge(std::uint32_t, std::uint32_t) {}
  bool failed() const { return reader_.overrun(); }

 private:
  static constexpr Tip kUnknown{};

  EntropyReader& reader_;
  TipCoder<Reading, Symbols> coder_;
};

template <class Symbols>
ConnectivityOrder encodeWith(const Surface& surface, EntropyWriter& writer, Surface& decoded) {
  EncoderEvents<Symbols> events(surface, writer);
  Traversal traversal(events, SurfaceEdges(decoded, surface.counts()), decoded, surface.counts());
  // Every surface that keeps its invariants can be coded.
  [[maybe_unused]] const Status status = traversal.run();
  return events.takeOrder();
}

template <class Symbols, class Edges>
Status decodeWith(EntropyReader& reader, const SurfaceCounts& counts, const Edges& edges, Surface& surface) {
  // A turn may go one face too far before that is noticed.
  if (counts.faces >= kMaxSurfaceFaces) {
    return Error{ErrorCode::kInvalidCount, "connectivity", reader.position(), counts.faces, kMaxSurfaceFaces};
  }
  DecoderEvents<Symbols> events(reader, counts.vertices());
  Status status = Traversal(events, edges, surface, counts).run();
  if (status) status->byte_offset = reader.position();
  return status;
}

}  // namespace

ConnectivityOrder encodeConnectivity(const Surface& surface, Effort effort, EntropyWriter& writer, Surface& decoded) {
  return effort == Effort::kMax ? encodeWith<MixedTips>(surface, writer, decoded)
                                : encodeWith<AveragedTips>(surface, writer, decoded);
}

Status decodeConnectivity(EntropyReader& reader, Effort effort, const SurfaceCounts& counts, Surface& surface) {
  const SurfaceEdges edges(surface, counts);
  return effort == Effort::kMax ? decodeWith<MixedTips>(reader, counts, edges, surface)
                                : decodeWith<AveragedTips>(reader, counts, edges, surface);
}

Status decodeConnectivity(EntropyReader& reader, const SurfaceCounts& counts, Surface& surface,
                          Buffer<VertexState>& states) {
  return decodeWith<AveragedTips>(reader, counts, StencilEdges(states, counts), surface);
}

}  // namespace tsc
