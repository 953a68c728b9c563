// References along cuts. Both sides of a cut run through the same positions, so once one vertex of the second side is
// known to repeat a position, its neighbour along the boundary most likely repeats that position's neighbour. The
// boundary is what the dummy faces tell: dummy face (dummy, a, b) says that b follows a.
//
// Traps: every list is walked to a fixed depth only, so that time stays linear on hostile streams.
#include "references.h"

#include <algorithm>
#include <array>

#include "direction.h"

namespace tsc {
namespace {

constexpr std::uint32_t kMaxCandidates = 15;  ///< symbol 15 is the escape
constexpr std::uint32_t kMaxInstances = 8;    ///< cut vertices looked at for one position
constexpr std::uint32_t kMaxNeighbours = 24;  ///< steps around one vertex when looking for candidates

/// Positions that a vertex may repeat, the likeliest first.
struct Candidates {
  std::array<std::uint32_t, kMaxCandidates> position;
  std::uint32_t count = 0;
  /// 0: no boundary neighbour suggests one; 1: only the boundary turning back at its end does; 2: one neighbour's copy
  /// does; 3: both neighbours' copies suggest the same.
  std::uint32_t confidence = 0;

  bool full() const { return count == kMaxCandidates; }
  std::uint32_t indexOf(std::uint32_t wanted) const {
    const auto end = position.begin() + count;
    return static_cast<std::uint32_t>(std::find(position.begin(), end, wanted) - position.begin());
  }
  void add(std::uint32_t candidate) {
    if (candidate != kNone && !full() && indexOf(candidate) == count) position[count++] = candidate;
  }
};

template <class Direction>
class ReferenceCoder {
 public:
  /// `map` is filled on the way. `truth` is the complete map when writing.
  ReferenceCoder(const Surface& surface, Direction direction, PositionMap& map, const PositionMap* truth)
      : surface_(surface), direction_(direction), map_(map), truth_(truth) {
    const std::uint32_t vertex_count = surface.vertexCount();
    map_.vertex_position.assign(vertex_count, kNone);
    map_.position_count = 0;
    older_.assign(vertex_count, kNone);
    newest_.reserve(vertex_count);
    neighbours_with_copies_.assign(vertex_count, 0);
    findBoundary();
  }

  Status run() {
    for (std::uint32_t v = 0; v < surface_.real_count; ++v) {
      if (direction_.overrun()) return error(ErrorCode::kTruncated, "references", 0, 0);
      std::uint32_t position = map_.position_count;
      if (position > 0) {
        if (Status status = codeVertex(v, position)) return status;
      }
      place(v, position);
    }
    return {};
  }

 private:
  Status error(ErrorCode code, const char* where, std::int64_t found, std::int64_t expected) const {
    return Error{code, where, direction_.position(), found, expected};
  }

  std::uint32_t positionOf(std::uint32_t vertex) const {
    return vertex == kNone ? kNone : map_.vertex_position[vertex];
  }

  void findBoundary() {
    boundary_next_.assign(surface_.vertexCount(), kNone);
    boundary_previous_.assign(surface_.vertexCount(), kNone);
    for (std::uint32_t c = 0; c < surface_.corner_vertex.size(); ++c) {
      if (!surface_.isDummy(surface_.corner_vertex[c])) continue;
      const std::uint32_t from = surface_.corner_vertex[nextCorner(c)];
      const std::uint32_t to = surface_.corner_vertex[previousCorner(c)];
      boundary_next_[from] = to;
      boundary_previous_[to] = from;
    }
  }

  /// Whether v repeats a position, and which; `position` is the next new one before and v's position after.
  Status codeVertex(std::uint32_t v, std::uint32_t& position) {
    Candidates candidates;
    addAlongBoundary(v, candidates);
    const bool at_boundary = boundary_next_[v] != kNone;
    const std::uint32_t near = std::min<std::uint32_t>(neighbours_with_copies_[v], 2);
    bool repeats = false;
    if constexpr (Direction::kWrites) repeats = truth_->vertex_position[v] != position;
    repeats = direction_.bit(repeats_[candidates.confidence][near][at_boundary], repeats);
    if (!repeats) return {};

    addAround(v, candidates);
    std::uint32_t index = 0;
    if constexpr (Direction::kWrites) {
      index = candidates.indexOf(truth_->vertex_position[v]);
      if (index == candidates.count) index = kMaxCandidates;
    }
    index = direction_.symbol(which_[candidates.confidence], index);
    if (index < candidates.count) {
      position = candidates.position[index];
      return {};
    }
    if (index != kMaxCandidates) {
      return error(ErrorCode::kInvalidSymbol, "references: candidate", index, candidates.count);
    }
    std::uint32_t back = 0;
    if constexpr (Direction::kWrites) back = position - 1 - truth_->vertex_position[v];
    back = direction_.integer(back_, back);
    if (back >= position) return error(ErrorCode::kInvalidSymbol, "references: position", back, position);
    position -= 1 + back;
    return {};
  }

  /// Calls visit(w) for the known vertices at `position`, newest first.
  template <class Visit>
  void forInstances(std::uint32_t position, Visit visit) const {
    std::uint32_t w = newest_[position];
    for (std::uint32_t i = 0; i < kMaxInstances && w != kNone; ++i, w = older_[w]) visit(w);
  }

  /// Calls visit(neighbour) for at most `limit` vertices around v.
  template <class Visit>
  void forNeighbours(std::uint32_t v, std::uint32_t limit, Visit visit) const {
    const std::uint32_t first = surface_.vertex_corner[v];
    std::uint32_t c = first;
    do {
      visit(surface_.corner_vertex[nextCorner(c)]);
      c = nextAroundVertex(surface_, c);
    } while (c != first && --limit > 0);
  }

  /// What the boundary suggests: faces of equal orientation meet at a cut, so that its two sides run through it in
  /// opposite directions, and their dummy faces, being on the other side of it, in opposite directions too: a step
  /// from v along one boundary meets the copy of that step's end, from which the same step leads to v's copy.
  void addAlongBoundary(std::uint32_t v, Candidates& candidates) const {
    const std::uint32_t by_next = addFrom(v, boundary_next_[v], boundary_next_, candidates);
    const std::uint32_t by_previous = addFrom(v, boundary_previous_[v], boundary_previous_, candidates);
    if (by_next != kNone || by_previous != kNone) {
      candidates.confidence = by_next == by_previous ? 3 : 2;
    } else {
      candidates.confidence = candidates.count > 0 ? 1 : 0;
    }
  }

  /// Adds what one boundary neighbour of v suggests; returns the first suggestion that comes from a copy of it.
  std::uint32_t addFrom(std::uint32_t v, std::uint32_t neighbour, const std::vector<std::uint32_t>& step,
                        Candidates& candidates) const {
    std::uint32_t from_copy = kNone;
    const std::uint32_t position = positionOf(neighbour);
    if (position == kNone) return kNone;
    forInstances(position, [&](std::uint32_t w) {
      const std::uint32_t candidate = step[w] == v ? kNone : positionOf(step[w]);
      if (from_copy == kNone && w != neighbour) from_copy = candidate;
      candidates.add(candidate);
    });
    return from_copy;
  }

  /// What is adjacent to copies of v's neighbours in any way.
  void addAround(std::uint32_t v, Candidates& candidates) const {
    forNeighbours(v, kMaxNeighbours, [&](std::uint32_t u) {
      const std::uint32_t position = positionOf(u);
      if (position == kNone || older_[newest_[position]] == kNone || candidates.full()) return;
      forInstances(position, [&](std::uint32_t w) {
        if (w == u || candidates.full()) return;
        candidates.add(positionOf(boundary_previous_[w]));
        candidates.add(positionOf(boundary_next_[w]));
        forNeighbours(w, kMaxNeighbours, [&](std::uint32_t x) { candidates.add(positionOf(x)); });
      });
    });
  }

  /// Records v's position. Each vertex marks its neighbours at most once: when its position is first seen twice.
  void place(std::uint32_t v, std::uint32_t position) {
    map_.vertex_position[v] = position;
    if (position == map_.position_count) {
      ++map_.position_count;
      newest_.push_back(v);
      return;
    }
    const std::uint32_t earlier = newest_[position];
    if (older_[earlier] == kNone) markNeighbours(earlier);
    markNeighbours(v);
    older_[v] = earlier;
    newest_[position] = v;
  }

  void markNeighbours(std::uint32_t v) {
    forNeighbours(v, kNone, [&](std::uint32_t u) {
      if (neighbours_with_copies_[u] < 2) ++neighbours_with_copies_[u];
    });
  }

  const Surface& surface_;
  Direction direction_;
  PositionMap& map_;
  const PositionMap* truth_;
  std::vector<std::uint32_t> boundary_next_, boundary_previous_;  ///< per vertex; kNone off the boundary
  std::vector<std::uint32_t> newest_;                             ///< per position: the last vertex placed there
  std::vector<std::uint32_t> older_;                              ///< per vertex: the one placed there before it
  std::vector<std::uint8_t> neighbours_with_copies_;              ///< per vertex, up to 2
  BitModel repeats_[4][3][2];  ///< by confidence, neighbours with copies, at the boundary
  SymbolModel which_[4];       ///< by confidence
  IntegerModel back_;
};

}  // namespace

PositionMap numberPositions(std::span<const std::uint32_t> vertex_welded, std::uint32_t welded_count,
                            std::vector<std::uint32_t>& welded_position) {
  PositionMap map;
  map.vertex_position.reserve(vertex_welded.size());
  welded_position.assign(welded_count, kNone);
  bool repeats = false;
  for (const std::uint32_t welded : vertex_welded) {
    if (welded != kNone) {
      repeats |= welded_position[welded] != kNone;
      if (welded_position[welded] == kNone) welded_position[welded] = map.position_count++;
    }
    map.vertex_position.push_back(welded == kNone ? kNone : welded_position[welded]);
  }
  if (!repeats) map.vertex_position = {};
  return map;
}

void encodeReferences(const Surface& surface, const PositionMap& map, bool has_references, EntropyWriter& writer) {
  if (!has_references) return;
  PositionMap known;
  // Writing cannot fail: every error is about a symbol read.
  (void)ReferenceCoder<Writing>(surface, Writing{writer}, known, &map).run();
}

Status decodeReferences(const Surface& surface, bool has_references, EntropyReader& reader, PositionMap& map) {
  if (has_references) return ReferenceCoder<Reading>(surface, Reading{reader}, map, nullptr).run();
  map = {{}, surface.real_count};
  return {};
}

}  // namespace tsc
