// Faces that are no part of the surface (degenerate ones and duplicates), and table vertices that no face uses.
//
// A duplicate names the surface face that it repeats. Other side faces give their vertices one by one, relative to the
// vertex before. The encoder may order and rotate them, which keeps the numbers small.
#include <algorithm>
#include <array>
#include <tuple>

#include "assignment_state.h"

namespace tsc {
namespace {

enum Kind : std::uint32_t {
  kCorner0,      ///< the same vertex as the face's first corner
  kCorner1,      ///< the same vertex as its second
  kExisting,     ///< another known vertex of the table
  kNewVertex,    ///< a new vertex at a known position
  kNewPosition,  ///< a new vertex at a new position
  kKindCount
};

/// A side face as it is coded.
struct PlannedFace {
  std::uint32_t primitive = 0;
  std::uint32_t duplicate_of = kNone;  ///< surface face
  std::uint32_t first_index = kNone;   ///< decoded index of the first corner's vertex, if known beforehand
  std::uint32_t id = 0;                ///< in the input
  std::uint32_t rotation = 0;          ///< input corner that comes first
};

using Triple = std::array<std::uint32_t, 3>;

/// First corner of the rotation that has the smallest value in front.
std::uint32_t smallestCorner(const Triple& values) {
  return static_cast<std::uint32_t>(std::min_element(values.begin(), values.end()) - values.begin());
}
Triple rotated(const Triple& values, std::uint32_t first) {
  return {values[first], values[(first + 1) % 3], values[(first + 2) % 3]};
}

/// The encoder's order of the side faces: by primitive, duplicates first, then by the vertices that they use.
std::vector<PlannedFace> planFaces(const AssignmentState<Writing>& state) {
  const AssignmentInput& input = *state.input;
  std::vector<PlannedFace> faces(input.side_faces.size());
  struct Key {
    Triple positions;
    std::uint32_t side_face;
    bool operator<(const Key& other) const { return positions < other.positions; }
  };
  std::vector<Key> keys;
  std::vector<std::uint32_t> rotation_to_key(faces.size());
  for (std::uint32_t i = 0; i < faces.size(); ++i) {
    const auto& face = input.side_faces[i];
    const std::uint32_t table = state.counts.primitive_table[face.primitive];
    Triple positions, indices;
    for (int k = 0; k < 3; ++k) {
      positions[k] = input.welded_position[input.table_welded[table][face.table_vertex[k]]];
      indices[k] = state.decoded_index[table][face.table_vertex[k]];
    }
    const std::uint32_t rotation = smallestCorner(indices);
    faces[i] = {face.primitive, kNone, indices[rotation], i, rotation};
    rotation_to_key[i] = smallestCorner(positions);
    keys.push_back({rotated(positions, rotation_to_key[i]), i});
  }
  std::stable_sort(keys.begin(), keys.end());

  for (std::uint32_t f = 0; f < state.surface.faceCount() && !keys.empty(); ++f) {
    if (state.face_primitive[f] == kNone) continue;
    Triple positions;
    for (int k = 0; k < 3; ++k) positions[k] = state.map.positionOf(state.surface.corner_vertex[3 * f + k]);
    const std::uint32_t first = smallestCorner(positions);
    const auto [begin, end] = std::equal_range(keys.begin(), keys.end(), Key{rotated(positions, first), 0});
    for (auto key = begin; key != end; ++key) {
      PlannedFace& face = faces[key->side_face];
      face.duplicate_of = f;
      face.rotation = (rotation_to_key[key->side_face] + 3 - first) % 3;
    }
  }
  const auto sort_key = [](const PlannedFace& face) {
    const bool duplicate = face.duplicate_of != kNone;
    return std::tuple(face.primitive, !duplicate, duplicate ? face.duplicate_of : face.first_index, face.id);
  };
  std::sort(faces.begin(), faces.end(),
            [&](const PlannedFace& a, const PlannedFace& b) { return sort_key(a) < sort_key(b); });
  return faces;
}

template <class Direction>
class SideFaceCoder {
 public:
  explicit SideFaceCoder(AssignmentState<Direction>& state) : state_(state) {}

  Status run() {
    std::uint64_t count = 0;
    for (const std::uint32_t unused : state_.unused_faces) count += unused;
    if (count == 0) return {};
    last_index_.assign(state_.counts.table_vertex_count.size(), 0);
    std::vector<PlannedFace> plan;
    if constexpr (Direction::kWrites) plan = planFaces(state_);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (state_.direction.overrun()) return state_.truncated("side faces");
      PlannedFace face;
      if constexpr (Direction::kWrites) face = plan[i];
      if (Status status = codeFace(face)) return status;
    }
    return {};
  }

 private:
  Status codeFace(PlannedFace& face) {
    if (Status status = codePrimitive(face.primitive)) return status;
    const std::uint32_t primitive = face.primitive;
    --state_.unused_faces[primitive];
    const std::uint32_t table = state_.counts.primitive_table[primitive];
    Triple input = {kNone, kNone, kNone}, indices;
    if constexpr (Direction::kWrites) {
      const auto& vertex = state_.input->side_faces[face.id].table_vertex;
      input = rotated({vertex[0], vertex[1], vertex[2]}, face.rotation);
      state_.order->triangle[primitive].push_back(3 * (state_.surface.faceCount() + face.id) + face.rotation);
    }
    const bool duplicate =
        state_.real_face_count > 0 && state_.direction.bit(is_duplicate_, face.duplicate_of != kNone);
    Status status =
        duplicate ? codeDuplicate(face.duplicate_of, table, input, indices) : codeCorners(table, input, indices);
    if (status) return status;
    for (const std::uint32_t index : indices) state_.out.primitive_indices[primitive].push_back(index);
    return {};
  }

  Status codePrimitive(std::uint32_t& primitive) {
    const auto count = static_cast<std::uint32_t>(state_.unused_faces.size());
    if (count > 1) {
      std::int64_t coded = last_primitive_;
      if (!state_.direction.bit(same_primitive_, primitive == last_primitive_)) {
        if (Status status =
                codeRelative(primitive_, primitive, last_primitive_, count, "side faces: primitive", coded)) {
          return status;
        }
      }
      primitive = static_cast<std::uint32_t>(coded);
    } else {
      primitive = 0;
    }
    if (state_.unused_faces[primitive] == 0) {
      const std::int64_t expected = state_.counts.primitive_face_count[primitive];
      return state_.error(ErrorCode::kInvalidCount, "side faces: faces of a primitive", expected + 1, expected);
    }
    last_primitive_ = primitive;
    return {};
  }

  /// Codes `value`, which is below `limit`, by its distance from `reference`.
  Status codeRelative(IntegerModel& model, std::uint32_t value, std::uint32_t reference, std::uint32_t limit,
                      const char* where, std::int64_t& coded) {
    const auto distance = static_cast<std::int32_t>(value - reference);
    coded = std::int64_t{reference} + unzigzag(state_.direction.integer(model, zigzag(distance)));
    if (coded < 0 || coded >= limit) return state_.error(ErrorCode::kInvalidSymbol, where, coded, limit);
    return {};
  }

  Status codeDuplicate(std::uint32_t duplicate_of, std::uint32_t table, const Triple& input, Triple& indices) {
    std::int64_t face = 0;
    if (Status status = codeRelative(duplicate_, duplicate_of, last_duplicate_, state_.surface.faceCount(),
                                     "side faces: duplicate of face", face)) {
      return status;
    }
    const auto original = static_cast<std::uint32_t>(face);
    if (state_.face_primitive[original] == kNone) {
      return state_.error(ErrorCode::kInvalidSymbol, "side faces: duplicate of a dummy face", original, 0);
    }
    last_duplicate_ = original;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t corner = 3 * original + k;
      if (state_.counts.one_vertex_per_position) {
        indices[k] = state_.cornerIndex(corner);
        continue;
      }
      const std::uint32_t position = state_.map.positionOf(state_.surface.corner_vertex[corner]);
      std::uint32_t id = kNone;
      if (Status status =
              state_.chooseVertex(position, table, state_.corner_id[corner], kNone, input[k], duplicate_vertex_, id)) {
        return status;
      }
      indices[k] = state_.vertices[id].index;
    }
    return {};
  }

  Status codeCorners(std::uint32_t table, const Triple& input, Triple& indices) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t reference = k == 0 ? last_index_[table] : indices[k - 1];
      if (Status status = codeCorner(k, table, reference, input[k], indices)) return status;
    }
    last_index_[table] = indices[0];
    return {};
  }

  /// What the encoder says about a corner.
  Kind kindOf(std::uint32_t k, std::uint32_t table, std::uint32_t input, const Triple& indices, std::uint32_t& index,
              std::uint32_t& position) const {
    if constexpr (Direction::kWrites) {
      index = state_.decoded_index[table][input];
      position = state_.knownPosition(table, input);
      if (index == kNone) return position == kNone ? kNewPosition : kNewVertex;
      if (k > 0 && index == indices[0]) return kCorner0;
      if (k > 1 && index == indices[1]) return kCorner1;
    }
    return kExisting;
  }

  Status codeCorner(std::uint32_t k, std::uint32_t table, std::uint32_t reference, std::uint32_t input,
                    Triple& indices) {
    std::uint32_t index = 0, position = 0;
    std::uint32_t kind = kindOf(k, table, input, indices, index, position);
    kind = state_.direction.symbol(kind_[k], kind);
    const std::uint32_t size = state_.tableSize(table);
    std::int64_t coded = 0;
    switch (kind) {
      case kCorner0:
      case kCorner1:
        if (kind >= k) break;
        indices[k] = indices[kind];
        return {};
      case kExisting:
        if (Status status = codeRelative(index_[k], index, reference, size, "side faces: vertex", coded)) {
          return status;
        }
        indices[k] = static_cast<std::uint32_t>(coded);
        return {};
      case kNewVertex: {
        if (state_.counts.one_vertex_per_position) break;
        const std::uint32_t near = reference < size ? state_.out.table_position[table][reference] : 0;
        if (Status status =
                codeRelative(position_, position, near, state_.out.position_count, "side faces: position", coded)) {
          return status;
        }
        indices[k] = size;
        return state_.createVertex(table, static_cast<std::uint32_t>(coded), input);
      }
      case kNewPosition: indices[k] = size; return state_.createVertexAndPosition(table, input);
    }
    return state_.error(ErrorCode::kInvalidSymbol, "side faces: kind of corner", kind, kKindCount);
  }

  AssignmentState<Direction>& state_;
  std::uint32_t last_primitive_ = 0;
  std::uint32_t last_duplicate_ = 0;
  std::vector<std::uint32_t> last_index_;  ///< per table: first vertex of the last side face that was no duplicate
  BitModel same_primitive_, is_duplicate_;
  IntegerModel primitive_, duplicate_, position_;
  VertexChoiceModel duplicate_vertex_;
  SymbolModel kind_[3];    ///< by corner
  IntegerModel index_[3];  ///< by corner
};

/// Writing: the vertices of a table that no face uses, those at equal positions next to each other, new positions by
/// their rank.
std::vector<std::uint32_t> unusedVertices(const AssignmentState<Writing>& state, std::uint32_t table) {
  std::vector<std::uint32_t> unused;
  for (std::uint32_t i = 0; i < state.decoded_index[table].size(); ++i) {
    if (state.decoded_index[table][i] == kNone) unused.push_back(i);
  }
  const auto sort_key = [&](std::uint32_t i) {
    const std::uint32_t welded = state.input->table_welded[table][i];
    const std::vector<std::uint64_t>& rank = state.input->welded_rank;
    return std::tuple(state.knownPosition(table, i), rank.empty() ? 0 : rank[welded], welded, i);
  };
  std::sort(unused.begin(), unused.end(), [&](std::uint32_t a, std::uint32_t b) { return sort_key(a) < sort_key(b); });
  return unused;
}

}  // namespace

template <class Direction>
Status codeSideFaces(AssignmentState<Direction>& state) {
  return SideFaceCoder<Direction>(state).run();
}

template <class Direction>
Status codeUnusedVertices(AssignmentState<Direction>& state) {
  BitModel is_new_position;
  IntegerModel distance;
  const auto table_count = static_cast<std::uint32_t>(state.counts.table_vertex_count.size());
  for (std::uint32_t table = 0; table < table_count; ++table) {
    const std::uint32_t first = state.tableSize(table), end = state.counts.table_vertex_count[table];
    // With one vertex per position nothing is read here; the positions come later, at 3 * 2^-11 bits each at least,
    // since no symbol's frequency exceeds 2^15 - 15. The 8 bytes are those in the coder's state.
    if (state.counts.one_vertex_per_position && (end - first) / 8192 > state.direction.remaining() + 8) {
      return state.truncated("unused vertices");
    }
    std::vector<std::uint32_t> unused;
    if constexpr (Direction::kWrites) unused = unusedVertices(state, table);
    std::int64_t position = 0;
    for (std::uint32_t i = first; i < end; ++i) {
      if (state.direction.overrun()) return state.truncated("unused vertices");
      std::uint32_t input = kNone, known = kNone, step = 0;
      if constexpr (Direction::kWrites) {
        input = unused[i - first];
        known = state.knownPosition(table, input);
        if (known != kNone) step = zigzag(static_cast<std::int32_t>(known - static_cast<std::uint32_t>(position)));
      }
      Status status;
      if (state.counts.one_vertex_per_position || state.direction.bit(is_new_position, known == kNone)) {
        position = state.out.position_count;
        status = state.createVertexAndPosition(table, input);
      } else {
        position += unzigzag(state.direction.integer(distance, step));
        if (position < 0 || position >= state.out.position_count) {
          return state.error(ErrorCode::kInvalidSymbol, "unused vertices: position", position,
                             state.out.position_count);
        }
        status = state.createVertex(table, static_cast<std::uint32_t>(position), input);
      }
      if (status) return status;
    }
  }
  return {};
}

template Status codeSideFaces(AssignmentState<Writing>&);
template Status codeSideFaces(AssignmentState<Reading>&);
template Status codeUnusedVertices(AssignmentState<Writing>&);
template Status codeUnusedVertices(AssignmentState<Reading>&);

}  // namespace tsc
