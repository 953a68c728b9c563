// Which table vertex each corner of the surface uses.
//
// Vertex by vertex, the corners around it are told apart where a *seam* enters: an edge at whose two sides the vertex
// is another table vertex. Seams run along paths of edges, so the other end of an edge, if known, is the best context
// (as in Draco's and Isenburg's seam coding). First one flag says that no seam enters here; otherwise the corners are
// walked in order.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "assignment_state.h"
#include "frame.h"

namespace tsc {
namespace {

// Cosines between the normals of two faces, in units of 2^-10, that separate the bends.
constexpr int kCosineBits = 10;
constexpr std::int32_t kFlat = 1004;   // 0.98
constexpr std::int32_t kCurved = 922;  // 0.9
constexpr std::int32_t kSharp = 717;   // 0.7

/// Largest component below 2^14 in magnitude or equal, so that products of two normals fit 32 bits. Zero for a face
/// without area, which bends nothing.
struct FaceNormal {
  std::array<std::int16_t, 3> direction = {};
  std::int16_t length = 0;  ///< rounded down
};
constexpr int kNormalBits = 14;

/// A real corner around a vertex.
struct FanCorner {
  std::uint32_t corner;
  std::uint32_t primitive;
  std::uint32_t edge;  ///< EdgeState of the edge from the corner before it
  std::uint32_t bend;  ///< of the surface at that edge, 0..3
};

/// `v` with its largest component scaled by a power of two to `bits` bits; right shifts round down.
WideVec3 scaledTo(const WideVec3& v, int bits) {
  const int shift = bits - magnitudeBits(v);
  if (shift >= 0) return v * (std::int64_t{1} << shift);
  return {v.x >> -shift, v.y >> -shift, v.z >> -shift};
}

/// `v` shifted right until no component needs more than kEdgeBits bits.
WideVec3 limited(const glm::ivec3& v) {
  constexpr int kEdgeBits = 24;
  const WideVec3 wide(v);
  return magnitudeBits(wide) <= kEdgeBits ? wide : scaledTo(wide, kEdgeBits);
}

enum EdgeState : std::uint32_t { kUnknown, kSmooth, kSeam };
enum StartKind : std::uint32_t { kAfterBoundary, kAfterSeam, kAnywhere };

/// The real corners around a vertex and what is known of the edges between them, at their other ends.
struct Fan {
  std::vector<FanCorner> corners;
  StartKind start_kind = kAnywhere;
  std::uint32_t seams = 0;
  std::uint32_t smooth = 0;
  std::uint32_t bend = 0;  ///< the largest of its edges'
  bool at_boundary = false;
  bool primitives_differ = false;
  bool tables_differ = false;
};

template <class Direction>
class CornerCoder {
 public:
  explicit CornerCoder(AssignmentState<Direction>& state) : state_(state), surface_(state.surface) {}

  Status run() {
    state_.corner_id.assign(surface_.corner_vertex.size(), kNone);
    if (!state_.positions.empty()) findNormals();
    for (std::uint32_t v = 0; v < surface_.real_count; ++v) {
      if (state_.direction.overrun()) return state_.truncated("corners");
      collectFan(v);
      if (fan_.corners.empty()) continue;
      if (Status status = codeFan(state_.map.positionOf(v))) return status;
    }
    // A surface whose umbrellas miss corners is no manifold; what follows relies on every corner being known.
    for (std::uint32_t f = 0, c = 0; f < surface_.faceCount(); ++f, c += 3) {
      const std::uint32_t known = std::max({state_.corner_id[c], state_.corner_id[c + 1], state_.corner_id[c + 2]});
      if (known == kNone && state_.face_primitive[f] != kNone) {
        return state_.error(ErrorCode::kInvalidSymbol, "corners: surface", c, 0);
      }
    }
    return {};
  }

 private:
  std::uint32_t tableOf(const FanCorner& at) const { return state_.counts.primitive_table[at.primitive]; }
  std::uint32_t inputVertex(const FanCorner& at) const {
    if constexpr (Direction::kWrites) return state_.input->corner_vertex[at.corner];
    return kNone;
  }

  void findNormals() {
    normals_.resize(surface_.faceCount());
    const auto at = [&](std::uint32_t corner) {
      return state_.positions[state_.map.positionOf(surface_.corner_vertex[corner])];
    };
    for (std::uint32_t f = 0; f < normals_.size(); ++f) {
      if (state_.face_primitive[f] == kNone) continue;
      const Vec3 tip = at(3 * f);
      const WideVec3 normal = cross(limited(at(3 * f + 1) - tip), limited(at(3 * f + 2) - tip));
      if (normal == WideVec3(0)) continue;
      const WideVec3 scaled = scaledTo(normal, kNormalBits);
      normals_[f].direction = {static_cast<std::int16_t>(scaled.x), static_cast<std::int16_t>(scaled.y),
                               static_cast<std::int16_t>(scaled.z)};
      normals_[f].length = static_cast<std::int16_t>(integerSqrt(dot(scaled, scaled)));
    }
  }

  /// How sharply the surface bends between two faces: seams of normals follow its creases.
  std::uint32_t bendBetween(std::uint32_t a, std::uint32_t b) const {
    if (normals_.empty()) return 0;
    std::int32_t dot = 0;
    for (int k = 0; k < 3; ++k) dot += std::int32_t{normals_[a].direction[k]} * normals_[b].direction[k];
    const std::int32_t one = std::int32_t{normals_[a].length} * normals_[b].length >> kCosineBits;
    return (dot < kFlat * one) + (dot < kCurved * one) + (dot < kSharp * one);
  }

  /// Fills `fan_`. It starts behind the boundary, so that the gap separates no corners; else behind a seam or a change
  /// of primitive, so that few table vertices are met at both ends of the walk.
  void collectFan(std::uint32_t v) {
    fan_.corners.clear();
    fan_.seams = fan_.smooth = fan_.bend = 0;
    fan_.at_boundary = fan_.primitives_differ = fan_.tables_differ = false;
    std::uint32_t after_boundary = kNone, after_seam = kNone, after_change = kNone;
    const std::uint32_t first = surface_.vertex_corner[v];
    // The edge before the first corner comes last.
    std::uint32_t c = first, primitive = state_.face_primitive[first / 3], edge = kUnknown, bend = 0;
    do {
      if (primitive != kNone) fan_.corners.push_back({c, primitive, edge, bend});
      const auto next_place = static_cast<std::uint32_t>(fan_.corners.size());
      const std::uint32_t across = surface_.opposite[nextCorner(c)];
      const std::uint32_t next_primitive = state_.face_primitive[across / 3];
      edge = kUnknown;
      bend = 0;
      if (primitive != kNone && next_primitive != kNone) {
        bend = bendBetween(c / 3, across / 3);
        fan_.bend = std::max(fan_.bend, bend);
        // The other end of the edge, in both faces.
        const std::uint32_t here = state_.corner_id[previousCorner(c)];
        const std::uint32_t there = state_.corner_id[previousCorner(across)];
        if (here != kNone && there != kNone) edge = here == there ? kSmooth : kSeam;
        fan_.smooth += edge == kSmooth;
        fan_.seams += edge == kSeam;
        if (edge == kSeam) after_seam = next_place;
        if (next_primitive != primitive) {
          after_change = next_place;
          const std::vector<std::uint32_t>& table = state_.counts.primitive_table;
          fan_.tables_differ |= table[next_primitive] != table[primitive];
        }
      } else {
        fan_.at_boundary = true;
        if (next_primitive != kNone) after_boundary = next_place;
      }
      c = nextCorner(across);
      primitive = next_primitive;
    } while (c != first);
    if (fan_.corners.empty()) return;
    if (primitive != kNone) {
      fan_.corners[0].edge = edge;
      fan_.corners[0].bend = bend;
    }
    fan_.primitives_differ = after_change != kNone;
    const auto rotateTo = [&](std::uint32_t place) {
      std::rotate(fan_.corners.begin(), fan_.corners.begin() + place % fan_.corners.size(), fan_.corners.end());
    };
    fan_.start_kind = after_boundary != kNone ? kAfterBoundary : after_seam != kNone ? kAfterSeam : kAnywhere;
    if (after_boundary != kNone) {
      rotateTo(after_boundary);
    } else if (after_seam != kNone) {
      rotateTo(after_seam);
    } else if (after_change != kNone) {
      rotateTo(after_change);
    }
  }

  /// Whether all corners of the fan use one table vertex, and which; or each corner's.
  Status codeFan(std::uint32_t position) {
    // Where several boundaries meet, faces of different tables need not be adjacent.
    if (!fan_.tables_differ && fan_.at_boundary && state_.counts.table_vertex_count.size() > 1) {
      for (const FanCorner& at : fan_.corners) fan_.tables_differ |= tableOf(at) != tableOf(fan_.corners[0]);
    }
    if (fan_.tables_differ) return walk(position);
    const std::uint32_t input = inputVertex(fan_.corners[0]);
    bool single = true;
    if constexpr (Direction::kWrites) {
      for (const FanCorner& at : fan_.corners) single &= inputVertex(at) == input;
    }
    const bool has_vertices = state_.newest[position] != kNone;
    single = state_.direction.bit(single_[std::min(fan_.seams, 3u)][std::min(fan_.smooth, 2u)][fan_.at_boundary]
                                         [fan_.primitives_differ][has_vertices][fan_.bend],
                                  single);
    if (!single) return walk(position);

    std::uint32_t id = kNone;
    if (Status status = state_.chooseVertex(position, tableOf(fan_.corners[0]), kNone, kNone, input, whole_, id)) {
      return status;
    }
    for (const FanCorner& at : fan_.corners) state_.corner_id[at.corner] = id;
    return {};
  }

  /// Where a walk along the fan stands.
  struct Walk {
    std::uint32_t position;
    std::uint32_t seams_ahead;  ///< known ones
    std::uint32_t seams_found = 0;
    std::uint32_t first_id = kNone;
    const FanCorner* previous = nullptr;
    std::uint32_t previous_id = kNone;
  };

  Status walk(std::uint32_t position) {
    Walk walk{position, fan_.seams - (fan_.start_kind == kAfterSeam ? 1 : 0)};
    for (const FanCorner& at : fan_.corners) {
      if (state_.direction.overrun()) return state_.truncated("corners");
      if (Status status = codeCorner(at, walk)) return status;
      walk.previous = &at;
    }
    return {};
  }

  Status codeCorner(const FanCorner& at, Walk& walk) {
    const std::uint32_t table = tableOf(at);
    VertexChoiceModel* model = &first_;
    std::uint32_t excluded = kNone;
    if (walk.previous) {
      model = &other_table_;
      if (at.edge == kSeam && walk.seams_ahead > 0) --walk.seams_ahead;
      if (tableOf(*walk.previous) == table) {
        if (continues(at, walk)) {
          state_.corner_id[at.corner] = walk.previous_id;
          return {};
        }
        model = &after_seam_[fan_.start_kind];
        excluded = walk.previous_id;
      }
      ++walk.seams_found;
    }
    std::uint32_t id = kNone;
    if (Status status =
            state_.chooseVertex(walk.position, table, walk.first_id, excluded, inputVertex(at), *model, id)) {
      return status;
    }
    state_.corner_id[at.corner] = id;
    if (walk.first_id == kNone) walk.first_id = id;
    walk.previous_id = id;
    return {};
  }

  /// Codes whether a corner uses the vertex of the corner before it.
  bool continues(const FanCorner& at, const Walk& walk) {
    bool same = false;
    if constexpr (Direction::kWrites) same = inputVertex(at) == inputVertex(*walk.previous);
    const bool primitive_changes = at.primitive != walk.previous->primitive;
    // A seam tends to run straight on: to leave by the edge opposite to the one by which it came.
    const auto place = static_cast<std::int32_t>(&at - fan_.corners.data());
    const std::int32_t off_centre = std::abs(2 * place - static_cast<std::int32_t>(fan_.corners.size()));
    BitModel& model = continues_[at.edge][primitive_changes][std::min(walk.seams_found, 2u)][fan_.start_kind]
                                [walk.seams_ahead > 0][std::min(off_centre / 2, 2)][at.bend];
    return state_.direction.bit(model, same);
  }

  AssignmentState<Direction>& state_;
  const Surface& surface_;
  Fan fan_;
  std::vector<FaceNormal> normals_;  ///< per face; empty without positions
  // By known seams, known smooth edges, boundary, primitives differ, position has vertices, largest bend.
  BitModel single_[4][3][2][2][2][4];
  // By edge state, primitive changes, seams found, kind of start, seams ahead, distance from the fan's middle, bend.
  BitModel continues_[3][2][3][3][2][3][4];
  VertexChoiceModel whole_, first_, after_seam_[3], other_table_;
};

}  // namespace

template <class Direction>
Status codeCorners(AssignmentState<Direction>& state) {
  return CornerCoder<Direction>(state).run();
}

template Status codeCorners(AssignmentState<Writing>&);
template Status codeCorners(AssignmentState<Reading>&);

}  // namespace tsc
