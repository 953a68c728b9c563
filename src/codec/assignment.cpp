// The stages of the assignment in their order: primitives of the faces, corners (corners.cpp), side faces and unused
// vertices (side_faces.cpp). Each is one text for both directions.
#include "assignment.h"

#include <algorithm>
#include <array>
#include <utility>

#include "assignment_state.h"

namespace tsc {
namespace {

/// Primitives of faces, told from those of the known neighbours.
template <class Direction>
class PrimitiveCoder {
 public:
  explicit PrimitiveCoder(AssignmentState<Direction>& state) : state_(state) {}

  Status run() {
    const auto face_count = state_.surface.faceCount();
    for (std::uint32_t f = 0; f < face_count; ++f) {
      if (state_.face_primitive[f] == kNone) continue;
      if (state_.direction.overrun()) return state_.truncated("face primitives");
      std::uint32_t primitive = 0;
      if constexpr (Direction::kWrites) primitive = state_.input->face_primitive[f];
      if (Status status = codeFace(f, primitive)) return status;
      if (state_.unused_faces[primitive]-- == 0) {
        const std::int64_t expected = state_.counts.primitive_face_count[primitive];
        return state_.error(ErrorCode::kInvalidCount, "face primitives: faces of a primitive", expected + 1, expected);
      }
      state_.face_primitive[f] = primitive;
    }
    return {};
  }

 private:
  // Symbols: 0..2 a neighbour's primitive, then the recently used ones, then the escape.
  static constexpr std::uint32_t kNeighbours = 3;
  static constexpr std::uint32_t kRecent = 12;
  static constexpr std::uint32_t kEscape = 15;

  /// The distinct primitives across the three edges that are known: the most frequent, then the newest face's first.
  struct Neighbours {
    std::array<std::uint32_t, kNeighbours> primitive;
    std::array<std::uint32_t, kNeighbours> times = {};
    std::uint32_t distinct = 0;
    std::uint32_t known = 0;
  };

  /// Faces before f are known; those after it still have the mark of a real face, 0.
  Neighbours neighboursOf(std::uint32_t f) const {
    Neighbours neighbours;
    std::array<std::uint32_t, kNeighbours> newest = {};
    for (std::uint32_t c = 3 * f; c < 3 * f + 3; ++c) {
      const std::uint32_t other = state_.surface.opposite[c] / 3;
      if (other >= f || state_.face_primitive[other] == kNone) continue;
      const std::uint32_t primitive = state_.face_primitive[other];
      ++neighbours.known;
      std::uint32_t i = 0;
      while (i < neighbours.distinct && neighbours.primitive[i] != primitive) ++i;
      if (i == neighbours.distinct) neighbours.primitive[neighbours.distinct++] = primitive;
      ++neighbours.times[i];
      newest[i] = std::max(newest[i], other);
      for (; i > 0 && std::pair(neighbours.times[i], newest[i]) > std::pair(neighbours.times[i - 1], newest[i - 1]);
           --i) {
        std::swap(neighbours.primitive[i], neighbours.primitive[i - 1]);
        std::swap(neighbours.times[i], neighbours.times[i - 1]);
        std::swap(newest[i], newest[i - 1]);
      }
    }
    return neighbours;
  }

  Status codeFace(std::uint32_t f, std::uint32_t& primitive) {
    const Neighbours neighbours = neighboursOf(f);
    std::uint32_t symbol = 0;
    if constexpr (Direction::kWrites) symbol = symbolOf(primitive, neighbours);
    symbol = state_.direction.symbol(model_[neighbours.known][neighbours.distinct], symbol);
    if (symbol < kNeighbours) {
      if (symbol >= neighbours.distinct) return invalid(symbol, neighbours.distinct);
      primitive = neighbours.primitive[symbol];
      return {};
    }
    if (symbol != kEscape) {
      if (symbol - kNeighbours >= recent_count_) return invalid(symbol - kNeighbours, recent_count_);
      primitive = recent_[symbol - kNeighbours];
    } else {
      const auto limit = static_cast<std::uint32_t>(state_.unused_faces.size());
      primitive = state_.direction.integer(escaped_, primitive);
      if (primitive >= limit) return invalid(primitive, limit);
    }
    moveToFront(primitive);
    return {};
  }

  Status invalid(std::uint32_t found, std::uint32_t limit) const {
    return state_.error(ErrorCode::kInvalidSymbol, "face primitives: primitive", found, limit);
  }

  std::uint32_t symbolOf(std::uint32_t primitive, const Neighbours& neighbours) const {
    for (std::uint32_t i = 0; i < neighbours.distinct; ++i) {
      if (neighbours.primitive[i] == primitive) return i;
    }
    for (std::uint32_t i = 0; i < recent_count_; ++i) {
      if (recent_[i] == primitive) return kNeighbours + i;
    }
    return kEscape;
  }

  void moveToFront(std::uint32_t primitive) {
    std::uint32_t i = 0;
    while (i < recent_count_ && recent_[i] != primitive) ++i;
    if (i == recent_count_) {
      if (recent_count_ < kRecent) {
        ++recent_count_;
      } else {
        --i;
      }
    }
    for (; i > 0; --i) recent_[i] = recent_[i - 1];
    recent_[0] = primitive;
  }

  AssignmentState<Direction>& state_;
  std::array<std::uint32_t, kRecent> recent_ = {};
  std::uint32_t recent_count_ = 0;
  SymbolModel model_[4][4];  ///< by known and distinct neighbours
  IntegerModel escaped_;
};

template <class Direction>
Status tooManyFaces(const AssignmentState<Direction>& state, std::uint64_t room, std::uint32_t faces) {
  return state.error(ErrorCode::kInvalidCount, "assignment: faces", static_cast<std::int64_t>(room), faces);
}

/// Marks the real faces (primitive 0 for now) and checks that the primitives have room for them.
template <class Direction>
Status findRealFaces(AssignmentState<Direction>& state) {
  const Surface& surface = state.surface;
  const std::uint32_t face_count = surface.faceCount();
  state.face_primitive.resize(face_count);
  for (std::uint32_t f = 0; f < face_count; ++f) {
    const std::uint32_t* corner = &surface.corner_vertex[3 * std::size_t{f}];
    const bool dummy = surface.isDummy(std::max({corner[0], corner[1], corner[2]}));
    state.face_primitive[f] = dummy ? kNone : 0;
    state.real_face_count += !dummy;
  }
  state.unused_faces = state.counts.primitive_face_count;
  std::uint64_t total = 0;
  for (const std::uint32_t count : state.unused_faces) total += count;
  if (total < state.real_face_count) return tooManyFaces(state, total, state.real_face_count);
  return {};
}

/// Creates the surface's vertices where each position has exactly one.
template <class Direction>
Status createVertexPerPosition(AssignmentState<Direction>& state) {
  const std::uint32_t count = state.map.position_count;
  if (state.counts.table_vertex_count.size() != 1) {
    const auto tables = static_cast<std::int64_t>(state.counts.table_vertex_count.size());
    return state.error(ErrorCode::kInvalidCount, "assignment: tables of one vertex per position", tables, 1);
  }
  if (count > state.counts.table_vertex_count[0]) {
    return state.error(ErrorCode::kInvalidCount, "assignment: table vertices", count,
                       state.counts.table_vertex_count[0]);
  }
  if constexpr (Direction::kWrites) {
    state.order->vertex[0].resize(count);
    const AssignmentInput& input = *state.input;
    for (std::uint32_t i = 0; i < input.table_welded[0].size(); ++i) {
      const std::uint32_t position = input.welded_position[input.table_welded[0][i]];
      state.decoded_index[0][i] = position;
      if (position != kNone) state.order->vertex[0][position] = i;
    }
  }
  return {};
}

/// Writes the surface's faces into their primitives.
template <class Direction>
void emitFaces(AssignmentState<Direction>& state) {
  const std::uint32_t face_count = state.surface.faceCount();
  const std::size_t primitive_count = state.counts.primitive_face_count.size();
  for (std::size_t p = 0; p < primitive_count; ++p) {
    const std::uint32_t unused = primitive_count > 1 ? state.unused_faces[p] : 0;
    const std::uint32_t faces = state.counts.primitive_face_count[p] - unused;
    state.out.primitive_indices[p].resize(3 * std::size_t{std::min(faces, state.real_face_count)});
  }
  std::vector<std::uint32_t*> next;
  for (auto& indices : state.out.primitive_indices) next.push_back(indices.data());
  for (std::uint32_t f = 0; f < face_count; ++f) {
    const std::uint32_t primitive = state.face_primitive[f];
    if (primitive == kNone) continue;
    std::uint32_t*& to = next[primitive];
    for (std::uint32_t c = 3 * f; c < 3 * f + 3; ++c) *to++ = state.cornerIndex(c);
    if constexpr (Direction::kWrites) state.order->triangle[primitive].push_back(3 * f);
  }
  if (primitive_count == 1) state.unused_faces[0] -= state.real_face_count;
}

std::uint32_t realFaces(const Surface& surface) {
  if (surface.dummy_count == 0) return surface.faceCount();
  std::uint32_t count = 0;
  for (std::size_t c = 0; c < surface.corner_vertex.size(); c += 3) {
    const std::uint32_t* corner = &surface.corner_vertex[c];
    count += !surface.isDummy(std::max({corner[0], corner[1], corner[2]}));
  }
  return count;
}

/// `emitFaces` for one primitive and one vertex per position, the common case that decoding should not notice.
template <class Direction>
Status emitFacesDirectly(AssignmentState<Direction>& state) {
  const std::uint32_t room = state.counts.primitive_face_count[0];
  state.real_face_count = realFaces(state.surface);
  if (state.real_face_count > room) return tooManyFaces(state, room, state.real_face_count);
  Buffer<std::uint32_t>& indices = state.out.primitive_indices[0];
  // Only side faces look at the surface again. Most often they are few, and find room.
  if (Direction::kWrites || state.real_face_count < room) {
    indices.reserve(
        std::max(state.surface.corner_vertex.size(), 3 * std::size_t{std::min(room, 2 * state.real_face_count)}));
    indices = state.surface.corner_vertex;
  } else if constexpr (!Direction::kWrites) {
    indices = std::move(state.surface.corner_vertex);
  }
  if (!state.map.isIdentity() || state.surface.dummy_count > 0) {
    std::uint32_t* to = indices.data();
    for (std::size_t c = 0; c < indices.size(); c += 3) {
      for (std::size_t k = 0; k < 3; ++k) to[k] = state.map.positionOf(indices[c + k]);
      // Faces with dummies are overwritten by the next.
      if (std::max({to[0], to[1], to[2]}) < state.map.position_count) to += 3;
    }
    indices.resize(3 * std::size_t{state.real_face_count});
  }
  if constexpr (Direction::kWrites) {
    const std::uint32_t face_count = state.surface.faceCount();
    for (std::uint32_t f = 0; f < face_count; ++f) {
      if (state.input->face_primitive[f] != kNone) state.order->triangle[0].push_back(3 * f);
    }
  }
  return {};
}

template <class Direction>
Status codeSurface(AssignmentState<Direction>& state) {
  const bool one_primitive = state.counts.primitive_face_count.size() == 1;
  if (state.counts.one_vertex_per_position) {
    if (Status status = createVertexPerPosition(state)) return status;
    if (one_primitive) {
      if (Status status = emitFacesDirectly(state)) return status;
      state.unused_faces = {state.counts.primitive_face_count[0] - state.real_face_count};
      if (state.unused_faces[0] == 0) return {};
      // Side faces may name real faces.
      state.real_face_count = 0;
      if (Status status = findRealFaces(state)) return status;
      state.unused_faces[0] -= state.real_face_count;
      return {};
    }
  }
  if (Status status = findRealFaces(state)) return status;
  if (!one_primitive) {
    if (Status status = PrimitiveCoder<Direction>(state).run()) return status;
  }
  if (!state.counts.one_vertex_per_position) {
    state.newest.assign(state.map.position_count, kNone);
    state.ids.resize(state.counts.table_vertex_count.size());
    if (Status status = codeCorners(state)) return status;
  }
  emitFaces(state);
  return {};
}

template <class Direction>
Status codeAssignment(AssignmentState<Direction>& state) {
  const std::size_t table_count = state.counts.table_vertex_count.size();
  state.out.table_position.assign(table_count, {});
  state.out.primitive_indices.assign(state.counts.primitive_face_count.size(), {});
  state.out.position_count = state.map.position_count;
  if (Status status = codeSurface(state)) return status;
  if (Status status = codeSideFaces(state)) return status;
  if (Status status = codeUnusedVertices(state)) return status;
  if (state.direction.overrun()) return state.truncated("assignment");
  return {};
}

}  // namespace

Assignment::Counts countAssignment(const AssignmentInput& input, std::span<const std::uint32_t> primitive_table) {
  Assignment::Counts counts;
  counts.primitive_table.assign(primitive_table.begin(), primitive_table.end());
  counts.primitive_face_count.assign(primitive_table.size(), 0);
  for (const std::uint32_t primitive : input.face_primitive) {
    if (primitive != kNone) ++counts.primitive_face_count[primitive];
  }
  for (const auto& face : input.side_faces) ++counts.primitive_face_count[face.primitive];
  for (const auto& welded : input.table_welded) {
    counts.table_vertex_count.push_back(static_cast<std::uint32_t>(welded.size()));
  }
  if (input.table_welded.size() == 1) {
    std::vector<std::uint8_t> met(input.welded_position.size(), 0);
    counts.one_vertex_per_position = std::none_of(input.table_welded[0].begin(), input.table_welded[0].end(),
                                                  [&](std::uint32_t welded) { return met[welded]++ != 0; });
  }
  return counts;
}

AssignmentOrder encodeAssignment(const Surface& surface, const PositionMap& map, std::span<const glm::ivec3> positions,
                                 const AssignmentInput& input, const Assignment::Counts& counts, EntropyWriter& writer,
                                 Assignment& decoded) {
  AssignmentOrder order;
  order.vertex.resize(counts.table_vertex_count.size());
  order.triangle.resize(counts.primitive_face_count.size());
  AssignmentState<Writing> state{surface, map, positions, counts, Writing{writer}, decoded, &input, &order};
  for (const std::uint32_t count : counts.table_vertex_count) {
    state.decoded_index.emplace_back(count, kNone);
  }
  state.welded_position = input.welded_position;
  // Writing cannot fail: every error is about a symbol read or a count that `counts` contradicts.
  (void)codeAssignment(state);
  return order;
}

Status decodeAssignment(Surface&& surface, const PositionMap& map, std::span<const glm::ivec3> positions,
                        const Assignment::Counts& counts, EntropyReader& reader, Assignment& assignment) {
  AssignmentState<Reading> state{surface, map, positions, counts, Reading{reader}, assignment, nullptr, nullptr};
  return codeAssignment(state);
}

}  // namespace tsc
