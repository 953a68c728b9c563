// Connectivity by vertex degrees, in the manner of Touma and Gotsman (Triangle Mesh Compression, 1998), on closed
// surfaces: one symbol for each new vertex, splits and handles by slot number (BITSTREAM.md, section 5).
//
// A component starts with one face. Then, while the front has nodes: the pivot is the node of smallest free valence.
// If that is 0, the face between its two edges is known and closed without a symbol. Otherwise the face on its gate has
// a third vertex, the tip, which is new (its degree is coded) or lies on the front (a split; the node is coded, and how
// many of its free edges go to either side).
//
// Both directions run the same `Traversal`; they differ in the `Events` that tell it what it cannot know. The decoder's
// events check ranges, the traversal checks everything that depends on its state, so that a hostile stream ends in an
// error. Each turn of its loop takes O(1) and adds a face, of which there are no more than the header says.
#include "connectivity.h"

#include <algorithm>
#include <array>
#include <bit>

#include "context_tables.h"
#include "front.h"
#include "models.h"

namespace tsc {
namespace {

// The symbols of a tip. kFirstDegree..kEscapeDegree - 1: a new vertex of that degree, by symbol = degree - 3.
constexpr std::uint32_t kFirstDegree = 3;
constexpr std::uint32_t kEscapeDegree = 15;
constexpr std::uint32_t kSymbolEscape = 12;  ///< a new vertex of degree 15 or more; the excess follows
constexpr std::uint32_t kSymbolDegree2 = 13;
constexpr std::uint32_t kSymbolSplit = 14;
constexpr std::uint32_t kSymbolDummy = 15;  ///< a new dummy vertex; its degree follows

/// What the decoder has to be told about a face.
struct Tip {
  bool is_split = false;
  // New vertex:
  bool is_dummy = false;
  std::uint32_t degree = 0;
  // Split:
  std::uint32_t node = 0;          ///< of the front
  std::uint32_t right_valence = 0;  ///< free edges between the gate's start and the node's edge
};

std::uint32_t degreeClass(const Tip& tip) { return tip.is_dummy ? 0 : std::min(tip.degree, kEscapeDegree); }

/// The edge to grow from and the nodes around it, seen from the pivot: `other` is the gate's other end.
struct Gate {
  std::uint32_t start;  ///< node whose edge is the gate: the pivot, or the node before it
  std::uint32_t pivot, other, beyond_pivot, beyond_other;
};

/// Of the pivot's two edges the one to the vertex of smaller degree, which costs fewer bits; the one that leaves it
/// when they are equal. A dummy counts as the largest: over the edge of a hole there is no parallelogram.
Gate gateAt(const Front& front, std::uint32_t pivot) {
  const std::uint32_t next = front[pivot].next;
  const std::uint32_t previous = front[pivot].previous;
  const auto rank = [&](std::uint32_t node) { return front[node].degree_class - 1u; };
  const bool enters = rank(previous) < rank(next);
  const std::uint32_t other = enters ? previous : next;
  const std::uint32_t beyond_other = enters ? front[other].previous : front[other].next;
  return {enters ? previous : pivot, pivot, other, enters ? next : previous, beyond_other};
}

/// Contexts for a tip. Degrees: a, b of the gate's ends, c, z of their neighbours on the loop, o of the vertex that
/// faces the gate, p of the one that faces the pivot's other edge. Free valences of the gate's ends.
inline AveragedModel::Context contextOf(const Front& front, const Gate& gate) {
  const Front::Node& pivot = front[gate.pivot];
  const Front::Node& other = front[gate.other];
  const Front::Node& beyond_pivot = front[gate.beyond_pivot];
  const bool leaves_pivot = gate.start == gate.pivot;
  const std::uint32_t a = pivot.degree_class;
  const std::uint32_t b = other.degree_class;
  const std::uint32_t c = front[gate.beyond_other].degree_class;
  const std::uint32_t z = beyond_pivot.degree_class;
  const std::uint32_t o = (leaves_pivot ? pivot : other).facing_class;
  const std::uint32_t p = (leaves_pivot ? beyond_pivot : pivot).facing_class;
  const std::uint32_t pivot_free = std::min(pivot.free_valence, 15u);
  const std::uint32_t other_free = std::min(other.free_valence, 15u);
  return {a << 4 | b, a << 16 | b << 12 | c << 8 | z << 4 | o,
          a << 20 | b << 16 | p << 12 | z << 8 | pivot_free << 4 | other_free};
}

/// Distribution of tips before anything is known: cumulative frequencies below each symbol.
constexpr std::array<std::int16_t, 16> kTipPrior = {0,     1200,  4200,  11200, 20800, 26000, 28200, 29300,
                                                    29900, 30300, 30600, 30800, 31000, 31300, 31400, 32200};

/// The node `distance` steps along the loop from the gate, away from it on the pivot's side or on the other end's.
std::uint32_t nodeNear(const Front& front, const Gate& gate, std::uint32_t distance, bool on_pivot_side) {
  const bool forward = on_pivot_side == (gate.start != gate.pivot);
  std::uint32_t node = on_pivot_side ? gate.pivot : gate.other;
  while (distance-- > 0) node = forward ? front[node].next : front[node].previous;
  return node;
}

/// All models of this stage. `put...` and `get...` mirror each other line by line.
class TipCoder {
 public:
  explicit TipCoder(std::uint32_t vertex_count) : tips_(kTipPrior, vertex_count) {}

  /// Degrees of a component's first three vertices.
  void putStart(EntropyWriter& writer, std::uint32_t degree) {
    start_degree_.put(writer, std::min(degree, kEscapeDegree));
    if (degree >= kEscapeDegree) large_degree_.put(writer, degree - kEscapeDegree);
  }
  std::uint32_t getStart(EntropyReader& reader) {
    const std::uint32_t degree = start_degree_.get(reader);
    return degree < kEscapeDegree ? degree : large_degree_.get(reader) + kEscapeDegree;
  }

  void put(EntropyWriter& writer, const Front& front, const Gate& gate, const Tip& tip) {
    const AveragedModel::Context context = contextOf(front, gate);
    if (tip.is_split) {
      tips_.put(writer, context, kSymbolSplit);
      putSplit(writer, front, gate, tip);
    } else if (tip.is_dummy) {
      tips_.put(writer, context, kSymbolDummy);
      dummy_degree_.put(writer, tip.degree - 2);
    } else if (tip.degree >= kEscapeDegree) {
      tips_.put(writer, context, kSymbolEscape);
      large_degree_.put(writer, tip.degree - kEscapeDegree);
    } else {
      tips_.put(writer, context, tip.degree == 2 ? kSymbolDegree2 : tip.degree - kFirstDegree);
    }
  }
  Tip get(EntropyReader& reader, const Front& front, const Gate& gate) {
    Tip tip;
    const std::uint32_t symbol = tips_.get(reader, contextOf(front, gate));
    if (symbol < kSymbolEscape) [[likely]] {
      tip.degree = symbol + kFirstDegree;
    } else if (symbol == kSymbolSplit) {
      getSplit(reader, front, gate, tip);
    } else if (symbol == kSymbolDummy) {
      tip.is_dummy = true;
      tip.degree = dummy_degree_.get(reader) + 2;
    } else {
      tip.degree = symbol == kSymbolDegree2 ? 2 : large_degree_.get(reader) + kEscapeDegree;
    }
    return tip;
  }

 private:
  /// A split within so many steps of the gate is coded by distance; 0 stands for a slot number. The bound keeps a
  /// hostile stream linear.
  static constexpr std::uint32_t kMaxDistance = 15;

  void putSplit(EntropyWriter& writer, const Front& front, const Gate& gate, const Tip& tip) {
    std::uint32_t distance = 1;
    bool on_pivot_side = false;
    for (; distance <= kMaxDistance; ++distance) {
      if (nodeNear(front, gate, distance, false) == tip.node) break;
      on_pivot_side = nodeNear(front, gate, distance, true) == tip.node;
      if (on_pivot_side) break;
    }
    const bool is_near = distance <= kMaxDistance;
    split_distance_.put(writer, is_near ? distance : 0);
    if (is_near) {
      split_side_.put(writer, on_pivot_side);
    } else {
      writer.putRaw(Front::slotOf(tip.node), slotBits(front));
    }
    const std::uint32_t shared = front[tip.node].free_valence - 2;
    if (shared > 0) right_valence_[std::min(shared, 15u)].put(writer, tip.right_valence);
  }
  /// Whether the node can be split at all, and so, is the caller's to check.
  void getSplit(EntropyReader& reader, const Front& front, const Gate& gate, Tip& tip) {
    tip.is_split = true;
    if (const std::uint32_t distance = split_distance_.get(reader); distance > 0) {
      tip.node = nodeNear(front, gate, distance, split_side_.get(reader));
    } else {
      const std::uint32_t slot = reader.getRaw(slotBits(front));
      tip.node = slot < front.slotCount() ? Front::nodeAt(slot) : Front::kNoNode;
    }
    const std::uint32_t free_valence = front[tip.node].free_valence;
    if (free_valence > 2) tip.right_valence = right_valence_[std::min(free_valence - 2, 15u)].get(reader);
  }

  static int slotBits(const Front& front) { return static_cast<int>(std::bit_width(front.slotCount() - 1)); }

  AveragedModel tips_;
  SymbolModel start_degree_, split_distance_;
  BitModel split_side_;
  IntegerModel dummy_degree_, large_degree_;
  std::array<IntegerModel, 16> right_valence_;
};

/// Grows `surface` face by face.
///
/// Events:
///   bool start(std::uint32_t face, std::uint32_t (&degrees)[3])   degrees of a new component's first face
///   void face(std::uint32_t face, std::uint32_t gate_corner)      `face` is being glued to `gate_corner`
///   bool tip(std::uint32_t face, const Gate&, const Front&, Tip&)  its third vertex
///   void vertex(std::uint32_t vertex, std::uint32_t corner)       a new vertex at a corner
///   void edge(std::uint32_t node, std::uint32_t corner)           the node's edge is now the one that `corner` faces
/// False ends the traversal with kTruncated.
template <class Events>
class Traversal {
 public:
  Traversal(Events& events, Surface& surface, std::uint32_t face_count, std::uint32_t vertex_count)
      : events_(events), surface_(surface), face_count_(face_count), vertex_count_(vertex_count) {}

  Status run() {
    surface_ = {};
    grow(std::min(face_count_, kFirstFaces), std::min(vertex_count_, kFirstFaces));
    Status status;
    while (faces_ < face_count_ && !status) {
      if (faces_ == face_capacity_) {
        grow(std::min<std::uint64_t>(face_count_, 2 * std::uint64_t{faces_}), vertex_capacity_);
      }
      if (front_.empty()) {
        status = startComponent();
      } else if (!front_.hasPivot()) {
        status = fault(ErrorCode::kInvalidCount);  // nothing but dummies
      } else if (const std::uint32_t pivot = front_.pivot(); front_[pivot].free_valence == 0) {
        status = close(pivot);
      } else {
        status = extend(gateAt(front_, pivot));
      }
    }
    if (!status && (!front_.empty() || vertices_ != vertex_count_)) status = fault(ErrorCode::kInvalidCount);
    return status;
  }

 private:
  static constexpr std::uint32_t kFirstFaces = 1 << 18;

  Status fault(ErrorCode code) const { return Error{code, "connectivity", 0, vertices_, vertex_count_}; }

  /// Memory follows what has been decoded, not what the header claims.
  void grow(std::uint64_t faces, std::uint64_t vertices) {
    surface_.corner_vertex.resize(3 * faces);
    surface_.opposite.resize(3 * faces, kNone);
    surface_.vertex_corner.resize(vertices);
    surface_.is_dummy.resize(vertices);
    face_capacity_ = static_cast<std::uint32_t>(faces);
    vertex_capacity_ = static_cast<std::uint32_t>(vertices);
  }

  void glue(std::uint32_t a, std::uint32_t b) {
    surface_.opposite[a] = b;
    surface_.opposite[b] = a;
  }

  void setEdge(std::uint32_t node, std::uint32_t corner, std::uint32_t facing_class) {
    front_[node].corner = corner;
    front_[node].facing_class = static_cast<std::uint16_t>(facing_class);
    events_.edge(node, corner);
  }

  /// The caller has checked that one more is allowed.
  std::uint32_t addVertex(std::uint32_t corner, const Tip& tip) {
    if (vertices_ == vertex_capacity_) {
      grow(face_capacity_, std::min<std::uint64_t>(vertex_count_, 2 * std::uint64_t{vertices_}));
    }
    surface_.vertex_corner[vertices_] = corner;
    surface_.is_dummy[vertices_] = tip.is_dummy;
    events_.vertex(vertices_, corner);
    return vertices_++;
  }

  Status startComponent() {
    if (vertex_count_ - vertices_ < 3) return fault(ErrorCode::kInvalidCount);
    const std::uint32_t base = 3 * faces_;
    std::uint32_t degrees[3];
    if (!events_.start(faces_++, degrees)) return fault(ErrorCode::kTruncated);
    if (std::min({degrees[0], degrees[1], degrees[2]}) < 2) return fault(ErrorCode::kInvalidSymbol);
    std::uint32_t nodes[3];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const Tip tip{.degree = degrees[k]};
      const std::uint32_t vertex = addVertex(base + k, tip);
      surface_.corner_vertex[base + k] = vertex;
      nodes[k] = front_.add(vertex, degreeClass(tip), degrees[k] - 2);
      front_.enterQueue(nodes[k]);
    }
    // The unknown side is outside: the loop runs against the face. Edge k + 1 -> k is faced by corner k + 2.
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t from = nodes[(k + 1) % 3];
      const std::uint32_t facing = (k + 2) % 3;
      front_.link(from, nodes[k]);
      setEdge(from, base + facing, front_[nodes[facing]].degree_class);
    }
    return {};
  }

  /// The face between the pivot's two edges.
  Status close(std::uint32_t pivot) {
    const std::uint32_t before = front_[pivot].previous;
    const std::uint32_t after = front_[pivot].next;
    if (before == after) return fault(ErrorCode::kInvalidSymbol);  // no face has two corners at one vertex
    const bool is_last = front_[after].next == before && front_[before].free_valence == 0 &&
                         front_[after].free_valence == 0;
    if (!is_last && (front_[before].free_valence == 0 || front_[after].free_valence == 0)) {
      return fault(ErrorCode::kInvalidSymbol);
    }
    const std::uint32_t face = faces_++;
    const std::uint32_t base = 3 * face;
    events_.face(face, front_[pivot].corner);
    surface_.corner_vertex[base] = front_[before].vertex;
    surface_.corner_vertex[base + 1] = front_[pivot].vertex;
    surface_.corner_vertex[base + 2] = front_[after].vertex;
    glue(base, front_[pivot].corner);
    glue(base + 2, front_[before].corner);
    if (is_last) {
      glue(base + 1, front_[after].corner);
      front_.remove(before);
      front_.remove(after);
    } else {
      front_.link(before, after);
      setEdge(before, base + 1, front_[pivot].degree_class);
      front_.setFreeValence(before, front_[before].free_valence - 1);
      front_.setFreeValence(after, front_[after].free_valence - 1);
    }
    front_.remove(pivot);
    return {};
  }

  /// The face on the gate, where no free valence is 0: its tip is new or on the front.
  Status extend(const Gate& gate) {
    const std::uint32_t start = gate.start;
    const std::uint32_t end = front_[start].next;
    const std::uint32_t face = faces_++;
    const std::uint32_t base = 3 * face;
    Tip tip;
    events_.face(face, front_[start].corner);
    if (!events_.tip(face, gate, front_, tip)) return fault(ErrorCode::kTruncated);

    std::uint32_t before_end = 0;  // the node whose edge becomes tip -> end
    if (tip.is_split) {
      if (!front_.isUsed(tip.node) || tip.node == start || tip.node == end || front_[tip.node].free_valence < 2 ||
          tip.right_valence > front_[tip.node].free_valence - 2) {
        return fault(ErrorCode::kInvalidSymbol);
      }
      const std::uint32_t left_valence = front_[tip.node].free_valence - 2 - tip.right_valence;
      before_end = front_.add(front_[tip.node].vertex, front_[tip.node].degree_class, left_valence);
      front_.link(front_[tip.node].previous, before_end);
      front_.link(start, tip.node);
      front_.setFreeValence(tip.node, tip.right_valence);
    } else {
      if (vertices_ == vertex_count_) return fault(ErrorCode::kInvalidCount);
      if (tip.degree > face_count_) return fault(ErrorCode::kInvalidSymbol);
      before_end = front_.add(addVertex(base, tip), degreeClass(tip), tip.degree - 2);
      front_.link(start, before_end);
    }
    front_.link(before_end, end);

    surface_.corner_vertex[base] = front_[before_end].vertex;
    surface_.corner_vertex[base + 1] = front_[start].vertex;
    surface_.corner_vertex[base + 2] = front_[end].vertex;
    glue(base, front_[start].corner);
    setEdge(start, base + 2, front_[end].degree_class);
    setEdge(before_end, base + 1, front_[start].degree_class);
    front_.setFreeValence(start, front_[start].free_valence - 1);
    front_.setFreeValence(end, front_[end].free_valence - 1);
    front_.enterQueue(before_end);
    return {};
  }

  Events& events_;
  Surface& surface_;
  Front front_;
  const std::uint32_t face_count_;
  const std::uint32_t vertex_count_;
  std::uint32_t faces_ = 0;
  std::uint32_t vertices_ = 0;
  std::uint32_t face_capacity_ = 0;  ///< of the surface's arrays
  std::uint32_t vertex_capacity_ = 0;
};

// --------------------------------------------------------------------------------------------------------- Encoding

class EncoderEvents {
 public:
  EncoderEvents(const Surface& surface, EntropyWriter& writer)
      : surface_(surface),
        writer_(writer),
        coder_(surface.vertexCount()),
        degree_(surface.vertexCount(), 0),
        is_met_(surface.vertexCount(), 0),
        is_known_(surface.faceCount(), 0),
        corner_node_(surface.corner_vertex.size(), kNone) {
    for (const std::uint32_t vertex : surface.corner_vertex) ++degree_[vertex];
    order_.vertex.reserve(surface.vertexCount());
    order_.corner.reserve(surface.faceCount());
  }

  ConnectivityOrder takeOrder() { return std::move(order_); }

  /// The first face in the input's order that is not known yet, and is not a dummy's.
  bool start(std::uint32_t, std::uint32_t (&degrees)[3]) {
    while (is_known_[next_start_] || touchesDummy(next_start_)) ++next_start_;
    addFace(3 * next_start_);
    for (std::uint32_t k = 0; k < 3; ++k) {
      degrees[k] = degree_[surface_.corner_vertex[3 * next_start_ + k]];
      coder_.putStart(writer_, degrees[k]);
    }
    return true;
  }

  void face(std::uint32_t, std::uint32_t gate_corner) { addFace(surface_.opposite[input(gate_corner)]); }

  bool tip(std::uint32_t face, const Gate& gate, const Front& front, Tip& tip) {
    const std::uint32_t corner = order_.corner[face];
    const std::uint32_t vertex = surface_.corner_vertex[corner];
    tip.is_split = is_met_[vertex] != 0;
    if (tip.is_split) {
      findNode(corner, front, tip);
    } else {
      tip.is_dummy = surface_.is_dummy[vertex] != 0;
      tip.degree = degree_[vertex];
    }
    coder_.put(writer_, front, gate, tip);
    return true;
  }

  void vertex(std::uint32_t, std::uint32_t corner) {
    order_.vertex.push_back(surface_.corner_vertex[input(corner)]);
    is_met_[order_.vertex.back()] = 1;
  }

  void edge(std::uint32_t node, std::uint32_t corner) { corner_node_[input(corner)] = node; }

 private:
  /// The input's corner for one of the decoder's.
  std::uint32_t input(std::uint32_t corner) const {
    const std::uint32_t first = order_.corner[corner / 3];
    const std::uint32_t rotated = first + corner % 3;
    return rotated / 3 == first / 3 ? rotated : rotated - 3;
  }

  bool touchesDummy(std::uint32_t face) const {
    const std::uint32_t* v = &surface_.corner_vertex[std::size_t{3} * face];
    return surface_.is_dummy[v[0]] || surface_.is_dummy[v[1]] || surface_.is_dummy[v[2]];
  }

  void addFace(std::uint32_t first_corner) {
    order_.corner.push_back(first_corner);
    is_known_[first_corner / 3] = 1;
  }

  /// The front's node for the unknown sector that holds `tip_corner`. Turns both ways in step, so that the cost is that
  /// of the smaller part, and over all splits of a vertex O(n log n).
  void findNode(std::uint32_t tip_corner, const Front& front, Tip& tip) const {
    std::uint32_t right = tip_corner;
    std::uint32_t left = tip_corner;
    for (std::uint32_t passed = 0;; ++passed) {
      const std::uint32_t across_right = surface_.opposite[previousCorner(right)];
      if (is_known_[across_right / 3]) {
        tip.node = corner_node_[across_right];
        tip.right_valence = passed - 1;
        return;
      }
      const std::uint32_t across_left = surface_.opposite[nextCorner(left)];
      if (is_known_[across_left / 3]) {
        tip.node = front[corner_node_[across_left]].next;
        tip.right_valence = front[tip.node].free_valence - 2 - (passed - 1);
        return;
      }
      right = previousCorner(across_right);
      left = nextCorner(across_left);
    }
  }

  const Surface& surface_;
  EntropyWriter& writer_;
  TipCoder coder_;
  ConnectivityOrder order_;
  std::vector<std::uint32_t> degree_;
  std::vector<std::uint8_t> is_met_;
  std::vector<std::uint8_t> is_known_;      ///< per input face
  std::vector<std::uint32_t> corner_node_;  ///< per input corner: the node whose edge it faced last
  std::uint32_t next_start_ = 0;
};

// --------------------------------------------------------------------------------------------------------- Decoding

class DecoderEvents {
 public:
  DecoderEvents(EntropyReader& reader, std::uint32_t vertex_count) : reader_(reader), coder_(vertex_count) {}

  bool start(std::uint32_t, std::uint32_t (&degrees)[3]) {
    for (std::uint32_t& degree : degrees) degree = coder_.getStart(reader_);
    return !reader_.overrun();
  }

  bool tip(std::uint32_t, const Gate& gate, const Front& front, Tip& tip) {
    tip = coder_.get(reader_, front, gate);
    return !reader_.overrun();
  }

  void face(std::uint32_t, std::uint32_t) {}
  void vertex(std::uint32_t, std::uint32_t) {}
  void edge(std::uint32_t, std::uint32_t) {}

 private:
  EntropyReader& reader_;
  TipCoder coder_;
};

}  // namespace

ConnectivityOrder encodeConnectivity(const Surface& surface, EntropyWriter& writer, Surface& decoded) {
  EncoderEvents events(surface, writer);
  Traversal traversal(events, decoded, surface.faceCount(), surface.vertexCount());
  // Every surface that keeps its invariants can be coded.
  [[maybe_unused]] const Status status = traversal.run();
  return events.takeOrder();
}

Status decodeConnectivity(EntropyReader& reader, std::uint32_t face_count, std::uint32_t vertex_count,
                          Surface& surface) {
  if (face_count > kMaxSurfaceFaces) {
    return Error{ErrorCode::kInvalidCount, "connectivity", 0, face_count, kMaxSurfaceFaces};
  }
  DecoderEvents events(reader, vertex_count);
  Status status = Traversal(events, surface, face_count, vertex_count).run();
  if (status) status->byte_offset = reader.position();
  return status;
}

}  // namespace tsc
