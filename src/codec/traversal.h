// Growth of a surface face by face, the same for encoding and decoding (BITSTREAM.md, section 5.2).
//
// A component starts with one face. Then, while the front has nodes: where a node's free valence is 0, the face between
// its two edges is known and closed without a symbol. Otherwise the pivot is the node of smallest free valence, and the
// face on its gate has a third vertex, the tip, which is new (its degree is coded) or lies on the front (a split; the
// node is coded, and how many of its free edges go to either side). If the pivot then has free valence 0, it is closed
// at once.
//
// The two directions differ in the `Events` that tell the traversal what it cannot know. The decoder's events check
// ranges, the traversal checks everything that depends on its state, so that a hostile stream ends in an error. Each
// turn of its loop takes O(1) on average and adds a face, of which there are no more than the header says.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "edges.h"
#include "front.h"
#include "gate.h"
#include "surface.h"
#include "tips.h"
#include "tsc/codec.h"

namespace tsc {

/// Grows `surface` face by face.
///
/// Events:
///   void start(std::uint32_t (&degrees)[3])             degrees of a new component's first face
///   void face(std::uint32_t gate_corner)                a face is being glued to `gate_corner` by its first corner
///   Tip tip(const Gate&, const Front&)                  its third vertex
///   void vertex(std::uint32_t vertex, std::uint32_t corner)
///                                                       a new vertex at a corner
///   void edge(std::uint32_t node, std::uint32_t corner) the node's edge is now the one that `corner` faces
///   bool failed()                                       asked now and then; true ends the traversal
///
/// `Edges` is what is kept of the edges, `SurfaceEdges` or `StencilEdges`.
template <class Events, class Edges>
class Traversal {
 public:
  Traversal(Events& events, const Edges& edges, Surface& surface, const SurfaceCounts& counts)
      : events_(events), edges_(edges), surface_(surface), counts_(counts), corner_count_(3 * counts.faces) {}

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
    if (error_) return error_;
    if (!front_.empty() || corners_ != corner_count_ || vertices_ != counts_.real_vertices ||
        dummies_ != counts_.dummies) {
      return fault(ErrorCode::kInvalidCount);
    }
    resize(corners_, vertices_);
    edges_.finish();
    surface_.real_count = counts_.real_vertices;
    surface_.dummy_count = counts_.dummies;
    return {};
  }

 private:
  /// Between two calls of `makeRoom`. A turn adds at most two faces, one vertex and one node.
  static constexpr std::uint32_t kTurns = 128;

  Error fault(ErrorCode code) const { return {code, "connectivity", 0, vertices_, counts_.real_vertices}; }
  bool fail(ErrorCode code) {
    error_ = fault(code);
    return false;
  }

  /// Asks for memory, which the system gives only once it is touched, so that few meshes are copied as they grow.
  void reserve() {
    constexpr std::uint32_t kMost = 1 << 22;
    const std::size_t corners = 3 * (std::size_t{std::min(corner_count_ / 3, kMost)} + 2 * kTurns + 1);
    const std::size_t vertices = std::size_t{std::min(counts_.real_vertices, kMost)} + kTurns + 3;
    surface_ = {};
    surface_.corner_vertex.reserve(corners);
    edges_.reserve(corners, vertices);
  }

  void resize(std::size_t corners, std::size_t vertices) {
    surface_.corner_vertex.resize(corners);
    edges_.resize(corners, vertices);
  }

  /// For a component's start and so many turns. Memory follows what has been decoded, not what the header claims.
  void makeRoom(std::size_t turns) {
    resize(corners_ + 3 * (2 * turns + 1), vertices_ + turns + 3);
    front_.makeRoom(turns + 3, 5 * turns + 3);
  }

  /// One more face, or two. False where the component is complete or the stream is wrong.
  bool takeTurn() {
    std::uint32_t node = front_.takeClosable();
    if (node == Front::kNoNode) {
      node = front_.takePivot();
      if (node == Front::kNoNode)
        return front_.empty() ? false : fail(ErrorCode::kInvalidCount);  // nothing but dummies
      if (!extend(gateAt(front_, node))) return false;
      if (front_[node].free_valence > 1) {
        front_.decrementFreeValence(node);
        return true;
      }
      // Most pivots have one free edge. These need not pass through the queue.
      front_[node].free_valence = 0;
    }
    return close(node);
  }

  void setCorners(std::uint32_t base, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::uint32_t* const corners = &surface_.corner_vertex[base];
    corners[0] = a;
    corners[1] = b;
    corners[2] = c;
  }

  void setEdge(std::uint32_t node, std::uint32_t corner, std::uint32_t vertex, std::uint32_t facing_class) {
    front_.setEdge(node, Edges::facing(corner, vertex), facing_class);
    events_.edge(node, corner);
  }

  bool startComponent() {
    if (counts_.real_vertices - vertices_ < 3) return fail(ErrorCode::kInvalidCount);
    const std::uint32_t base = corners_;
    corners_ += 3;
    std::uint32_t degrees[3];
    events_.start(degrees);
    if (std::min({degrees[0], degrees[1], degrees[2]}) < 2) return fail(ErrorCode::kInvalidSymbol);
    std::uint32_t nodes[3];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = vertices_++;
      edges_.addVertex(vertex, degrees[k], base + k);
      events_.vertex(vertex, base + k);
      surface_.corner_vertex[base + k] = vertex;
      nodes[k] = front_.add(vertex, degreeClass(degrees[k]), degrees[k] - 2);
      front_.enterQueue(nodes[k]);
    }
    // The unknown side is outside: the loop runs against the face. Edge k + 1 -> k is faced by corner k + 2.
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t from = nodes[(k + 1) % 3];
      const std::uint32_t facing = (k + 2) % 3;
      front_.link(from, nodes[k]);
      setEdge(from, base + facing, front_[nodes[facing]].vertex, front_[nodes[facing]].degree_class);
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
    // The newer of left and right comes first, without a branch, which could not be predicted.
    const std::uint32_t turn = right.vertex > left.vertex;
    const std::uint32_t base = corners_;
    const std::uint32_t at_left = base + turn, at_middle = base + 1 + turn, at_right = base + 2 - 2 * turn;
    corners_ += 3;
    const std::uint32_t gate = middle.facing ^ ((middle.facing ^ left.facing) & (0 - turn));
    events_.face(gate);
    surface_.corner_vertex[at_left] = left.vertex;
    surface_.corner_vertex[at_middle] = middle.vertex;
    surface_.corner_vertex[at_right] = right.vertex;
    edges_.glue(at_left, middle.facing);
    edges_.glue(at_right, left.facing);
    const std::uint32_t newer = std::max(left.vertex, right.vertex);
    edges_.addFace(base, newer, left.vertex ^ right.vertex ^ newer, middle.vertex, gate);
    if (is_last) [[unlikely]] {
      edges_.glue(at_middle, right.facing);
      front_.remove(before);
      front_.remove(after);
    } else {
      front_.link(before, after);
      setEdge(before, at_middle, middle.vertex, middle.degree_class);
      front_.decrementFreeValence(before);
      front_.decrementFreeValence(after);
    }
    front_.remove(node);
    return true;
  }

  /// The face on the gate, where no free valence is 0: its tip is new or on the front. The pivot's edge is the
  /// caller's.
  bool extend(const Gate& gate) {
    const std::uint32_t start = gate.start();
    const std::uint32_t end = gate.end();
    const std::uint32_t base = corners_;
    corners_ += 3;
    events_.face(front_[start].facing);
    const Tip tip = events_.tip(gate, front_);

    const std::uint32_t left = front_[start].vertex, right = front_[end].vertex, facing = front_[start].facing;
    std::uint32_t before_end = 0;  // the node whose edge becomes tip -> end
    std::uint32_t vertex = 0;      // the tip
    if (tip.is_split) [[unlikely]] {
      before_end = split(start, end, tip.node, tip.right_valence);
      if (before_end == Front::kNoNode) return fail(ErrorCode::kInvalidSymbol);
      vertex = front_[before_end].vertex;
      edges_.addFace(base, vertex, left, right, facing);
    } else {
      if (tip.degree_class == Front::kDummyClass) [[unlikely]] {
        if (dummies_ == counts_.dummies) return fail(ErrorCode::kInvalidCount);
        vertex = counts_.real_vertices + dummies_++;
        edges_.addDummy(base);
      } else {
        if (vertices_ == counts_.real_vertices) [[unlikely]]
          return fail(ErrorCode::kInvalidCount);
        vertex = vertices_++;
        edges_.addTip(vertex, tip.degree, base, left, right, facing);
      }
      events_.vertex(vertex, base);
      before_end = front_.add(vertex, tip.degree_class, tip.degree - 2);
      front_.link(start, before_end);
    }
    front_.link(before_end, end);

    setCorners(base, vertex, left, right);
    edges_.glue(base, facing);
    setEdge(start, base + 2, right, front_[end].degree_class);
    setEdge(before_end, base + 1, left, front_[start].degree_class);
    front_.decrementFreeValence(gate.other);
    front_.enterQueue(before_end);
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
  Edges edges_;
  Surface& surface_;
  Front front_;
  const SurfaceCounts counts_;
  const std::uint32_t corner_count_;
  std::uint32_t corners_ = 0;
  std::uint32_t vertices_ = 0;  ///< real ones
  std::uint32_t dummies_ = 0;
  Status error_;
};

}  // namespace tsc
