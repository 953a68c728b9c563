// Connectivity by vertex degrees, in the manner of Touma and Gotsman (Triangle Mesh Compression, 1998), on closed
// surfaces: one symbol for each new vertex, splits and handles by node number (BITSTREAM.md, section 5).
//
// A component starts with one face. Then, while the front has nodes: where a node's free valence is 0, the face between
// its two edges is known and closed without a symbol. Otherwise the pivot is the node of smallest free valence, and the
// face on its gate has a third vertex, the tip, which is new (its degree is coded) or lies on the front (a split; the
// node is coded, and how many of its free edges go to either side). If the pivot then has free valence 0, it is closed
// at once.
//
// Both directions run the same `Traversal`; they differ in the `Events` that tell it what it cannot know. The decoder's
// events check ranges, the traversal checks everything that depends on its state, so that a hostile stream ends in an
// error. Each turn of its loop takes O(1) on average and adds a face, of which there are no more than the header says.
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
  std::uint32_t degree = 0;
  std::uint32_t degree_class = 0;
  // Split:
  std::uint32_t node = 0;           ///< of the front
  std::uint32_t right_valence = 0;  ///< free edges between the gate's start and the node's edge
};

std::uint32_t degreeClass(std::uint32_t degree) { return std::min(degree, kEscapeDegree) - 1; }
Tip newVertex(std::uint32_t degree) { return {.degree = degree, .degree_class = degreeClass(degree)}; }
Tip newDummy(std::uint32_t degree) { return {.degree = degree, .degree_class = Front::kDummyClass}; }

/// The edge to grow from and the nodes around it, seen from the pivot: `other` is the gate's other end.
struct Gate {
  std::uint32_t direction;  ///< from the pivot to `other` along the loop: 1 forward, 0 backward
  std::uint32_t pivot, other, beyond_pivot, beyond_other;

  /// The node whose edge is the gate, and the one where that edge ends. Without a branch, which could not be predicted.
  std::uint32_t start() const { return other ^ ((other ^ pivot) & (0 - direction)); }
  std::uint32_t end() const { return pivot ^ other ^ start(); }
};

/// Of the pivot's two edges the one to the vertex of smaller degree, which costs fewer bits; the one that leaves it
/// when they are equal. A dummy counts as the largest: over the edge of a hole there is no parallelogram.
inline Gate gateAt(const Front& front, std::uint32_t pivot) {
  const Front::Node& node = front[pivot];
  const std::uint32_t direction = front[node.previous()].degree_class >= front[node.next()].degree_class;
  const std::uint32_t other = node.link[direction];
  return {direction, pivot, other, node.link[1 - direction], front[other].link[direction]};
}

/// Contexts for a tip. Degrees: a, b of the gate's ends, c, z of their neighbours on the loop, o of the vertex that
/// faces the gate, p of the one that faces the pivot's other edge. Free valences of the gate's ends.
inline AveragedModel::Context contextOf(const Front& front, const Gate& gate) {
  const Front::Node& pivot = front[gate.pivot];
  const Front::Node& other = front[gate.other];
  const Front::Node& beyond_pivot = front[gate.beyond_pivot];
  const std::uint32_t ab = std::uint32_t{pivot.degree_class} << 4 | other.degree_class;
  const std::uint32_t c = front[gate.beyond_other].degree_class;
  const std::uint32_t z = beyond_pivot.degree_class;
  const std::uint32_t o = front[gate.start()].facing_class;
  const std::uint32_t p = front[gate.direction != 0 ? gate.beyond_pivot : gate.pivot].facing_class;
  const std::uint32_t pivot_free = std::min(pivot.free_valence, 15u);
  const std::uint32_t other_free = std::min(other.free_valence, 15u);
  return {ab, ab << 12 | c << 8 | z << 4 | o, ab << 16 | p << 12 | z << 8 | pivot_free << 4 | other_free};
}

/// Distribution of tips before anything is known: cumulative frequencies below each symbol.
constexpr std::array<std::int16_t, 16> kTipPrior = {0,     1200,  4200,  11200, 20800, 26000, 28200, 29300,
                                                    29900, 30300, 30600, 30800, 31000, 31300, 31400, 32200};

/// The node `distance` steps along the loop from the gate, away from it on the pivot's side or on the other end's.
std::uint32_t nodeNear(const Front& front, const Gate& gate, std::uint32_t distance, bool on_pivot_side) {
  const std::uint32_t direction = on_pivot_side ? 1 - gate.direction : gate.direction;
  std::uint32_t node = on_pivot_side ? gate.pivot : gate.other;
  while (distance-- > 0) node = front[node].link[direction];
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
    } else if (tip.degree_class == Front::kDummyClass) {
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
    const std::uint32_t symbol = tips_.get(reader, contextOf(front, gate));
    if (symbol < kSymbolEscape) [[likely]] {
      return {.degree = symbol + kFirstDegree, .degree_class = symbol + kFirstDegree - 1};
    }
    return getRare(reader, front, gate.pivot, symbol);
  }

 private:
  /// A split within so many steps of the gate is coded by distance; 0 stands for a node number. The bound keeps a
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
      writer.putRaw(tip.node, nodeBits(front));
    }
    const std::uint32_t shared = front[tip.node].free_valence - 2;
    if (shared > 0) right_valence_[std::min(shared, 15u)].put(writer, tip.right_valence);
  }
  /// Given the pivot and not the gate, so that the gate can stay in registers.
  [[gnu::noinline]] Tip getRare(EntropyReader& reader, const Front& front, std::uint32_t pivot, std::uint32_t symbol) {
    if (symbol == kSymbolSplit) return getSplit(reader, front, gateAt(front, pivot));
    if (symbol == kSymbolDegree2) return newVertex(2);
    if (symbol == kSymbolEscape) return newVertex(large_degree_.get(reader) + kEscapeDegree);
    return newDummy(dummy_degree_.get(reader) + 2);
  }
  /// Whether the node can be split at all, and so, is the caller's to check.
  Tip getSplit(EntropyReader& reader, const Front& front, const Gate& gate) {
    Tip tip{.is_split = true};
    if (const std::uint32_t distance = split_distance_.get(reader); distance > 0) {
      tip.node = nodeNear(front, gate, distance, split_side_.get(reader));
    } else {
      const std::uint32_t node = reader.getRaw(nodeBits(front));
      tip.node = node < front.nodeCount() ? node : gate.start();  // which no split may take
    }
    const std::uint32_t free_valence = front[tip.node].free_valence;
    if (free_valence > 2) tip.right_valence = right_valence_[std::min(free_valence - 2, 15u)].get(reader);
    return tip;
  }

  static int nodeBits(const Front& front) { return static_cast<int>(std::bit_width(front.nodeCount() - 1)); }

  AveragedModel tips_;
  SymbolModel start_degree_, split_distance_;
  BitModel split_side_;
  IntegerModel dummy_degree_, large_degree_;
  std::array<IntegerModel, 16> right_valence_;
};

/// Grows `surface` face by face.
///
/// Events:
///   void start(std::uint32_t (&degrees)[3])             degrees of a new component's first face
///   void face(std::uint32_t gate_corner)                a face is being glued to `gate_corner`
///   Tip tip(const Gate&, const Front&)                  its third vertex
///   void vertex(std::uint32_t corner)                   a new vertex at a corner
///   void edge(std::uint32_t node, std::uint32_t corner) the node's edge is now the one that `corner` faces
///   bool failed()                                       asked now and then; true ends the traversal
template <class Events>
class Traversal {
 public:
  Traversal(Events& events, Surface& surface, std::uint32_t face_count, std::uint32_t vertex_count)
      : events_(events), surface_(surface), corner_count_(3 * face_count), vertex_count_(vertex_count) {}

  Status run() {
    reserve();
    while (corners_ < corner_count_ && !error_) {
      if (events_.failed()) return fault(ErrorCode::kTruncated);
      const std::uint32_t turns = std::min((corner_count_ - corners_) / 3, kTurns);
      makeRoom(turns);
      if (front_.empty()) startComponent();
      for (std::uint32_t turn = 0; turn < turns && corners_ < corner_count_ && takeTurn(); ++turn) {
      }
    }
    if (events_.failed()) return fault(ErrorCode::kTruncated);
    if (!error_ && (!front_.empty() || corners_ != corner_count_ || vertices_ != vertex_count_)) {
      return fault(ErrorCode::kInvalidCount);
    }
    resize(corners_, vertices_);
    return error_;
  }

 private:
  /// Between two calls of `makeRoom`. A turn adds at most two faces, one vertex and one node.
  static constexpr std::uint32_t kTurns = 128;

  Error fault(ErrorCode code) const { return {code, "connectivity", 0, vertices_, vertex_count_}; }
  bool fail(ErrorCode code) {
    error_ = fault(code);
    return false;
  }

  /// Asks for memory, which the system gives only once it is touched, so that few meshes are copied as they grow.
  void reserve() {
    constexpr std::uint32_t kMost = 1 << 22;
    const std::size_t corners = 3 * (std::size_t{std::min(corner_count_ / 3, kMost)} + 2 * kTurns + 1);
    const std::size_t vertices = std::size_t{std::min(vertex_count_, kMost)} + kTurns + 3;
    surface_ = {};
    surface_.corner_vertex.reserve(corners);
    surface_.opposite.reserve(corners);
    surface_.vertex_corner.reserve(vertices);
    surface_.is_dummy.reserve(vertices);
  }

  void resize(std::size_t corners, std::size_t vertices) {
    surface_.corner_vertex.resize(corners);
    surface_.opposite.resize(corners);
    surface_.vertex_corner.resize(vertices);
    surface_.is_dummy.resize(vertices);
  }

  /// For a component's start and so many turns. Memory follows what has been decoded, not what the header claims.
  void makeRoom(std::size_t turns) {
    resize(corners_ + 3 * (2 * turns + 1), vertices_ + turns + 3);
    front_.makeRoom(turns + 3, 5 * turns + 3);
  }

  /// One more face, or two. False where the component is complete or the stream is wrong.
  bool takeTurn() {
    if (const std::uint32_t node = front_.takeClosable(); node != Front::kNoNode) return close(node);
    if (const std::uint32_t node = front_.takePivot(); node != Front::kNoNode) return extend(gateAt(front_, node));
    return front_.empty() ? false : fail(ErrorCode::kInvalidCount);  // nothing but dummies
  }

  void glue(std::uint32_t a, std::uint32_t b) {
    surface_.opposite[a] = b;
    surface_.opposite[b] = a;
  }

  void setCorners(std::uint32_t base, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::uint32_t* const corners = &surface_.corner_vertex[base];
    corners[0] = a;
    corners[1] = b;
    corners[2] = c;
  }

  void setEdge(std::uint32_t node, std::uint32_t corner, std::uint32_t facing_class) {
    front_.setEdge(node, corner, facing_class);
    events_.edge(node, corner);
  }

  /// The caller has checked that one more is allowed.
  std::uint32_t addVertex(std::uint32_t corner, std::uint32_t degree_class) {
    surface_.vertex_corner[vertices_] = corner;
    if (degree_class == Front::kDummyClass) [[unlikely]] surface_.is_dummy[vertices_] = 1;
    events_.vertex(corner);
    return vertices_++;
  }

  bool startComponent() {
    if (vertex_count_ - vertices_ < 3) return fail(ErrorCode::kInvalidCount);
    const std::uint32_t base = corners_;
    corners_ += 3;
    std::uint32_t degrees[3];
    events_.start(degrees);
    if (std::min({degrees[0], degrees[1], degrees[2]}) < 2) return fail(ErrorCode::kInvalidSymbol);
    std::uint32_t nodes[3];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = addVertex(base + k, 0);
      surface_.corner_vertex[base + k] = vertex;
      nodes[k] = front_.add(vertex, degreeClass(degrees[k]), degrees[k] - 2);
      front_.enterQueue(nodes[k]);
    }
    // The unknown side is outside: the loop runs against the face. Edge k + 1 -> k is faced by corner k + 2.
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t from = nodes[(k + 1) % 3];
      const std::uint32_t facing = (k + 2) % 3;
      front_.link(from, nodes[k]);
      setEdge(from, base + facing, front_[nodes[facing]].degree_class);
    }
    return true;
  }

  /// The face between the edges of a node of free valence 0.
  bool close(std::uint32_t node) {
    const Front::Node& middle = front_[node];
    const std::uint32_t before = middle.previous();
    const std::uint32_t after = middle.next();
    const Front::Node& left = front_[before];
    const Front::Node& right = front_[after];
    const bool is_last = left.free_valence == 0 || right.free_valence == 0;
    // No face has two corners at one vertex. Neighbours that have no free edges either are those of a loop of three.
    if (before == after || (is_last && (right.next() != before || left.free_valence != right.free_valence)))
      [[unlikely]] {
      return fail(ErrorCode::kInvalidSymbol);
    }
    const std::uint32_t base = corners_;
    corners_ += 3;
    events_.face(middle.corner);
    setCorners(base, left.vertex, middle.vertex, right.vertex);
    glue(base, middle.corner);
    glue(base + 2, left.corner);
    if (is_last) [[unlikely]] {
      glue(base + 1, right.corner);
      front_.remove(before);
      front_.remove(after);
    } else {
      front_.link(before, after);
      setEdge(before, base + 1, middle.degree_class);
      front_.decrementFreeValence(before);
      front_.decrementFreeValence(after);
    }
    front_.remove(node);
    return true;
  }

  /// The face on the gate, where no free valence is 0: its tip is new or on the front.
  bool extend(const Gate& gate) {
    const std::uint32_t start = gate.start();
    const std::uint32_t end = gate.end();
    const std::uint32_t base = corners_;
    corners_ += 3;
    events_.face(front_[start].corner);
    const Tip tip = events_.tip(gate, front_);

    std::uint32_t before_end = 0;  // the node whose edge becomes tip -> end
    if (tip.is_split) [[unlikely]] {
      before_end = split(start, end, tip.node, tip.right_valence);
      if (before_end == Front::kNoNode) return fail(ErrorCode::kInvalidSymbol);
    } else {
      if (vertices_ == vertex_count_) [[unlikely]] return fail(ErrorCode::kInvalidCount);
      before_end = front_.add(addVertex(base, tip.degree_class), tip.degree_class, tip.degree - 2);
      front_.link(start, before_end);
    }
    front_.link(before_end, end);

    setCorners(base, front_[before_end].vertex, front_[start].vertex, front_[end].vertex);
    glue(base, front_[start].corner);
    setEdge(start, base + 2, front_[end].degree_class);
    setEdge(before_end, base + 1, front_[start].degree_class);
    front_.decrementFreeValence(gate.other);
    front_.enterQueue(before_end);
    // Most pivots have one free edge. These need not pass through the queue.
    if (front_[gate.pivot].free_valence == 1) {
      front_[gate.pivot].free_valence = 0;
      return close(gate.pivot);
    }
    front_.decrementFreeValence(gate.pivot);
    return true;
  }

  /// Makes two nodes of one on the front; returns the new one, which stands before the gate's end. kNoNode if that
  /// cannot be.
  [[gnu::noinline]] std::uint32_t split(std::uint32_t start, std::uint32_t end, std::uint32_t node,
                                        std::uint32_t right_valence) {
    if (!front_.isUsed(node) || node == start || node == end || front_[node].free_valence < 2 ||
        right_valence > front_[node].free_valence - 2) {
      return Front::kNoNode;
    }
    const std::uint32_t left_valence = front_[node].free_valence - 2 - right_valence;
    const std::uint32_t before_end = front_.add(front_[node].vertex, front_[node].degree_class, left_valence);
    front_.link(front_[node].previous(), before_end);
    front_.link(start, node);
    front_[node].free_valence = right_valence;
    front_.enterQueue(node);
    return before_end;
  }

  Events& events_;
  Surface& surface_;
  Front front_;
  const std::uint32_t corner_count_;
  const std::uint32_t vertex_count_;
  std::uint32_t corners_ = 0;
  std::uint32_t vertices_ = 0;
  Status error_;
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
  void start(std::uint32_t (&degrees)[3]) {
    while (is_known_[next_start_] || touchesDummy(next_start_)) ++next_start_;
    addFace(3 * next_start_);
    for (std::uint32_t k = 0; k < 3; ++k) {
      degrees[k] = degree_[surface_.corner_vertex[3 * next_start_ + k]];
      coder_.putStart(writer_, degrees[k]);
    }
  }

  void face(std::uint32_t gate_corner) { addFace(surface_.opposite[input(gate_corner)]); }

  Tip tip(const Gate& gate, const Front& front) {
    const std::uint32_t corner = order_.corner.back();
    const std::uint32_t vertex = surface_.corner_vertex[corner];
    const Tip tip = is_met_[vertex]              ? findNode(corner, front)
                    : surface_.is_dummy[vertex] ? newDummy(degree_[vertex])
                                                : newVertex(degree_[vertex]);
    coder_.put(writer_, front, gate, tip);
    return tip;
  }

  void vertex(std::uint32_t corner) {
    order_.vertex.push_back(surface_.corner_vertex[input(corner)]);
    is_met_[order_.vertex.back()] = 1;
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
    return surface_.is_dummy[v[0]] || surface_.is_dummy[v[1]] || surface_.is_dummy[v[2]];
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

  void start(std::uint32_t (&degrees)[3]) {
    for (std::uint32_t& degree : degrees) degree = coder_.getStart(reader_);
  }
  void face(std::uint32_t) {}
  Tip tip(const Gate& gate, const Front& front) { return coder_.get(reader_, front, gate); }
  void vertex(std::uint32_t) {}
  void edge(std::uint32_t, std::uint32_t) {}
  bool failed() const { return reader_.overrun(); }

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
  // A turn may go one face too far before that is noticed.
  if (face_count >= kMaxSurfaceFaces) {
    return Error{ErrorCode::kInvalidCount, "connectivity", 0, face_count, kMaxSurfaceFaces};
  }
  DecoderEvents events(reader, vertex_count);
  Status status = Traversal(events, surface, face_count, vertex_count).run();
  if (status) status->byte_offset = reader.position();
  return status;
}

}  // namespace tsc
