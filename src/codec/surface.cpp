// From triangle soup to a closed, oriented, manifold surface: weld, set aside, pair half-edges, close holes.
//
// A half-edge is named by the corner that faces it: the half-edge of corner c runs from the vertex at nextCorner(c) to
// the vertex at previousCorner(c).
//
// Trap: which half-edges are paired decides the encoder's bytes, which are the same on every platform. The geometry
// here uses + - * / and square root in double only, and this library is compiled without fused operations.
#include "surface.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace tsc {
namespace {

// ------------------------------------------------------------------------------------------------------------ Weld

using PositionBits = std::array<std::uint32_t, 3>;

PositionBits positionBits(const float* position) {
  PositionBits bits;
  for (int axis = 0; axis < 3; ++axis) bits[axis] = std::bit_cast<std::uint32_t>(position[axis] + 0.0f);  // -0 -> +0
  return bits;
}

std::uint64_t hashPosition(const PositionBits& bits) {
  std::uint64_t hash = (static_cast<std::uint64_t>(bits[1]) << 32 | bits[0]) * 0x9e3779b97f4a7c15u;
  hash = (hash ^ hash >> 32 ^ bits[2]) * 0xd6e8feb86659fd93u;
  return (hash ^ hash >> 32) * 0xd6e8feb86659fd93u;
}

// ------------------------------------------------------------------------------------------- Grouping by a small key

/// Items grouped by key in linear time (counting sort): group k is items[first[k] .. first[k + 1]), each group in
/// increasing order.
struct Groups {
  std::vector<std::uint32_t> first;
  std::vector<std::uint32_t> items;
};

/// Groups the items 0..item_count by key(item) < key_count; items with key kNone are left out.
template <class Key>
Groups groupBy(std::uint32_t item_count, std::size_t key_count, Key key) {
  Groups groups;
  groups.first.assign(key_count + 1, 0);
  for (std::uint32_t item = 0; item < item_count; ++item) {
    if (const std::uint32_t k = key(item); k != kNone) ++groups.first[k];
  }
  std::uint32_t end = 0;
  for (std::uint32_t& first : groups.first) first = end += first;
  groups.items.resize(end);
  for (std::uint32_t item = item_count; item-- > 0;) {
    if (const std::uint32_t k = key(item); k != kNone) groups.items[--groups.first[k]] = item;
  }
  return groups;
}

/// Sorts what is nearly always a handful.
template <class T>
void sortFew(std::vector<T>& items) {
  constexpr std::size_t kFew = 24;
  if (items.size() > kFew) return std::sort(items.begin(), items.end());
  for (std::size_t i = 1; i < items.size(); ++i) {
    const T item = items[i];
    std::size_t k = i;
    for (; k > 0 && item < items[k - 1]; --k) items[k] = items[k - 1];
    items[k] = item;
  }
}

// ------------------------------------------------------------------------------------------------------- Side faces

/// 1 for each face that is degenerate or repeats an earlier face's three vertices in the same orientation.
std::vector<std::uint8_t> findSideFaces(std::span<const std::uint32_t> corner_vertex, std::size_t vertex_count) {
  const auto face_count = static_cast<std::uint32_t>(corner_vertex.size() / 3);
  std::vector<std::uint8_t> is_side(face_count, 0);

  // The same cyclic triple, started at its smallest vertex, for each face.
  struct Triple {
    std::uint32_t smallest, second, third;
  };
  const auto triple = [&](std::uint32_t face) {
    const std::uint32_t* v = &corner_vertex[std::size_t{3} * face];
    const int k = v[0] < v[1] ? (v[0] < v[2] ? 0 : 2) : (v[1] < v[2] ? 1 : 2);
    return Triple{v[k], v[(k + 1) % 3], v[(k + 2) % 3]};
  };
  for (std::uint32_t face = 0; face < face_count; ++face) {
    const std::uint32_t* v = &corner_vertex[std::size_t{3} * face];
    is_side[face] = v[0] == v[1] || v[1] == v[2] || v[2] == v[0];
  }
  const auto smallest = [&](std::uint32_t face) { return is_side[face] ? kNone : triple(face).smallest; };
  const Groups by_vertex = groupBy(face_count, vertex_count, smallest);

  struct Rest {
    std::uint64_t vertices;
    std::uint32_t face;
    auto operator<=>(const Rest&) const = default;
  };
  std::vector<Rest> rests;
  for (std::size_t vertex = 0; vertex < vertex_count; ++vertex) {
    if (by_vertex.first[vertex + 1] - by_vertex.first[vertex] < 2) continue;
    rests.clear();
    for (std::uint32_t i = by_vertex.first[vertex]; i < by_vertex.first[vertex + 1]; ++i) {
      const Triple t = triple(by_vertex.items[i]);
      rests.push_back({static_cast<std::uint64_t>(t.second) << 32 | t.third, by_vertex.items[i]});
    }
    sortFew(rests);
    for (std::size_t i = 1; i < rests.size(); ++i) {
      if (rests[i].vertices == rests[i - 1].vertices) is_side[rests[i].face] = 1;
    }
  }
  return is_side;
}

// ---------------------------------------------------------------------------------------------------------- Pairing

struct Vector {
  double x, y, z;
};
Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Pairs the half-edges of one undirected edge: those that run from its smaller to its larger vertex (`up`) with those
/// that run the other way (`down`).
class EdgePairing {
 public:
  EdgePairing(std::span<const float> positions, std::span<const std::uint32_t> input_vertex,
              std::span<std::uint32_t> opposite)
      : positions_(positions), vertex_(input_vertex), opposite_(opposite) {}

  /// Pairs two half-edges of opposite direction unless one is paired or they are flip sides.
  void tryPair(std::uint32_t up, std::uint32_t down) {
    if (opposite_[up] != kNone || opposite_[down] != kNone || areFlipSides(up, down)) return;
    opposite_[up] = down;
    opposite_[down] = up;
  }

  void pairAll(std::vector<std::uint32_t>& up, std::vector<std::uint32_t>& down) {
    if (up.empty() || down.empty()) return;
    if (up.size() == 1 && down.size() == 1) {
      tryPair(up[0], down[0]);
    } else if (up.size() * down.size() <= kMaxExhaustivePairs) {
      pairFlattest(up, down);
    } else {
      pairByAngle(up, down);
    }
  }

 private:
  /// Beyond this a book of n pages would take O(n^2).
  static constexpr std::size_t kMaxExhaustivePairs = 256;

  /// Faces on the same edge with the same apex are each other's flip side.
  bool areFlipSides(std::uint32_t up, std::uint32_t down) const { return vertex_[up] == vertex_[down]; }

  struct Candidate {
    double cosine;
    std::uint32_t up, down;
  };

  void pairFlattest(const std::vector<std::uint32_t>& up, const std::vector<std::uint32_t>& down) {
    candidates_.clear();
    for (const std::uint32_t u : up) {
      const Vector normal = faceNormal(u);
      for (const std::uint32_t d : down) {
        const Vector other = faceNormal(d);
        const double lengths = std::sqrt(dot(normal, normal)) * std::sqrt(dot(other, other));
        // Without a normal, no pair is less flat.
        candidates_.push_back({lengths > 0 ? dot(normal, other) / lengths : -2.0, u, d});
      }
    }
    // Stable, so that ties go to the earlier corners.
    std::stable_sort(candidates_.begin(), candidates_.end(),
                     [](const Candidate& a, const Candidate& b) { return a.cosine > b.cosine; });
    for (const Candidate& candidate : candidates_) tryPair(candidate.up, candidate.down);
  }

  /// Two faces that continue each other flatly have the same normal. So both sides, sorted by the angle of their
  /// normals about the edge, are paired in order.
  void pairByAngle(std::vector<std::uint32_t>& up, std::vector<std::uint32_t>& down) {
    const Vector reference = faceNormal(up[0]);
    const Vector axis = point(previousCorner(up[0])) - point(nextCorner(up[0]));
    const Vector across = cross(axis, reference);
    const double axis_length = std::sqrt(dot(axis, axis));
    const auto sortByAngle = [&](std::vector<std::uint32_t>& corners) {
      std::vector<std::pair<double, std::uint32_t>> angles;
      for (const std::uint32_t corner : corners) {
        const Vector normal = faceNormal(corner);
        const double x = dot(normal, reference) * axis_length;
        const double y = dot(normal, across);
        const double sum = std::abs(x) + std::abs(y);
        const double quarter = sum > 0 ? y / sum : 0;  // grows with the angle while x > 0
        angles.emplace_back(x >= 0 ? quarter : 2 - quarter, corner);
      }
      std::sort(angles.begin(), angles.end());
      for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = angles[i].second;
    };
    sortByAngle(up);
    sortByAngle(down);
    for (std::size_t i = 0; i < std::min(up.size(), down.size()); ++i) tryPair(up[i], down[i]);
  }

  Vector point(std::uint32_t corner) const {
    const float* p = &positions_[std::size_t{3} * vertex_[corner]];
    return {p[0], p[1], p[2]};
  }

  /// Not normalised. |components| < 2^258, so their squares and products of squares stay finite.
  Vector faceNormal(std::uint32_t corner) const {
    const Vector apex = point(corner);
    return cross(point(nextCorner(corner)) - apex, point(previousCorner(corner)) - apex);
  }

  std::span<const float> positions_;
  std::span<const std::uint32_t> vertex_;  ///< welded vertex of each corner
  std::span<std::uint32_t> opposite_;
  std::vector<Candidate> candidates_;
};

/// Opposite corners over welded vertices; kNone at boundaries.
Buffer<std::uint32_t> pairHalfEdges(std::span<const float> positions, std::span<const std::uint32_t> vertex) {
  const auto corner_count = static_cast<std::uint32_t>(vertex.size());
  Buffer<std::uint32_t> opposite(corner_count, kNone);
  const auto smaller_end = [&](std::uint32_t corner) {
    return std::min(vertex[nextCorner(corner)], vertex[previousCorner(corner)]);
  };
  const Groups by_vertex = groupBy(corner_count, positions.size() / 3, smaller_end);

  EdgePairing pairing(positions, vertex, opposite);
  std::vector<std::uint64_t> half_edges;  // larger end, then corner
  std::vector<std::uint32_t> up, down;
  for (std::uint32_t u = 0; u + 1 < by_vertex.first.size(); ++u) {
    half_edges.clear();
    for (std::uint32_t i = by_vertex.first[u]; i < by_vertex.first[u + 1]; ++i) {
      const std::uint32_t corner = by_vertex.items[i];
      const std::uint64_t larger = std::max(vertex[nextCorner(corner)], vertex[previousCorner(corner)]);
      half_edges.push_back(larger << 32 | corner);
    }
    sortFew(half_edges);
    for (std::size_t i = 0; i < half_edges.size();) {
      const std::uint64_t larger = half_edges[i] >> 32;
      const auto is_other = [&](std::size_t k) { return k >= half_edges.size() || half_edges[k] >> 32 != larger; };
      if (!is_other(i + 1) && is_other(i + 2)) {  // the usual case
        const auto a = static_cast<std::uint32_t>(half_edges[i]);
        const auto b = static_cast<std::uint32_t>(half_edges[i + 1]);
        if ((vertex[nextCorner(a)] == u) != (vertex[nextCorner(b)] == u)) pairing.tryPair(a, b);
        i += 2;
        continue;
      }
      up.clear();
      down.clear();
      for (; i < half_edges.size() && half_edges[i] >> 32 == larger; ++i) {
        const auto corner = static_cast<std::uint32_t>(half_edges[i]);
        (vertex[nextCorner(corner)] == u ? up : down).push_back(corner);
      }
      pairing.pairAll(up, down);
    }
  }
  return opposite;
}

// ------------------------------------------------------------------------------------------------ Umbrellas and holes

/// Gives each umbrella a vertex of its own, numbered by its first corner. `input_vertex` is the welded vertex of each
/// corner.
void numberUmbrellas(std::span<const std::uint32_t> input_vertex, CutMesh& cut) {
  Surface& surface = cut.surface;
  const auto corner_count = static_cast<std::uint32_t>(input_vertex.size());
  surface.corner_vertex.assign(corner_count, kNone);
  // The next corner to the left, found for all in memory's order: the walks below then wait for one load a step.
  std::vector<std::uint32_t> left(corner_count);
  for (std::uint32_t base = 0; base < corner_count; base += 3) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t across = surface.opposite[base + (k + 1) % 3];
      left[base + k] = across == kNone ? kNone : nextCorner(across);
    }
  }
  for (std::uint32_t first = 0; first < corner_count; ++first) {
    if (surface.corner_vertex[first] != kNone) continue;
    const std::uint32_t vertex = surface.real_count++;
    surface.vertex_corner.push_back(first);
    cut.welded_vertex.push_back(input_vertex[first]);
    // All the way around to the left; where that ends at a boundary, from the start to the right.
    std::uint32_t corner = first;
    do {
      surface.corner_vertex[corner] = vertex;
      corner = left[corner];
    } while (corner != kNone && corner != first);
    if (corner == first) continue;
    for (std::uint32_t across = surface.opposite[previousCorner(first)]; across != kNone;
         across = surface.opposite[previousCorner(corner)]) {
      corner = previousCorner(across);
      surface.corner_vertex[corner] = vertex;
    }
  }
}

/// The boundary half-edge that starts where boundary half-edge `corner` ends. An umbrella with a boundary has exactly
/// one half-edge in and one out, so every boundary is a simple loop.
std::uint32_t nextOnBoundary(const Surface& surface, std::uint32_t corner) {
  std::uint32_t turn = nextCorner(corner);
  while (surface.opposite[turn] != kNone) turn = nextCorner(surface.opposite[turn]);
  return turn;
}

/// Closes each boundary loop by a dummy vertex. A loop has at least 2 edges, because no face has two equal vertices. It
/// has 2 only where half-edges of opposite direction on the same edge stayed unpaired, which takes flip sides.
void closeHoles(CutMesh& cut) {
  Surface& surface = cut.surface;
  const auto real_corner_count = static_cast<std::uint32_t>(surface.corner_vertex.size());
  for (std::uint32_t first = 0; first < real_corner_count; ++first) {
    if (surface.opposite[first] != kNone) continue;
    const std::uint32_t dummy = surface.real_count + surface.dummy_count++;
    const auto first_dummy_corner = static_cast<std::uint32_t>(surface.corner_vertex.size());
    surface.vertex_corner.push_back(first_dummy_corner);
    cut.welded_vertex.push_back(kNone);

    // A dummy face has the corners dummy, end, start of its boundary half-edge: it runs against it.
    std::uint32_t corner = first;
    do {
      const std::uint32_t next = nextOnBoundary(surface, corner);
      const auto base = static_cast<std::uint32_t>(surface.corner_vertex.size());
      surface.corner_vertex.insert(surface.corner_vertex.end(), {dummy, surface.corner_vertex[previousCorner(corner)],
                                                                 surface.corner_vertex[nextCorner(corner)]});
      // Corner 2 (start) faces the edge shared with the next dummy face, corner 1 (end) that with the one before.
      surface.opposite.insert(surface.opposite.end(), {corner, base - 1, base + 4});
      cut.input_face.push_back(kNone);
      corner = next;
    } while (corner != first);
    const auto end = static_cast<std::uint32_t>(surface.corner_vertex.size());
    surface.opposite[first_dummy_corner + 1] = end - 1;
    surface.opposite[end - 1] = first_dummy_corner + 1;
    // Only now, so that nextOnBoundary saw the boundary as it was.
    for (std::uint32_t base = first_dummy_corner; base < end; base += 3) {
      surface.opposite[surface.opposite[base]] = base;
    }
  }
}

}  // namespace

WeldResult weld(const Mesh& mesh) {
  WeldResult result;
  std::size_t vertex_count = 0;
  for (const VertexTable& table : mesh.tables) vertex_count += table.positions.size() / 3;

  // Open addressing, at most half full.
  std::vector<std::uint32_t> slots(std::bit_ceil(2 * vertex_count + 1), kNone);
  std::vector<float>& positions = result.mesh.positions;
  positions.reserve(3 * vertex_count);
  for (const VertexTable& table : mesh.tables) {
    std::vector<std::uint32_t>& to_welded = result.table_vertex_to_welded.emplace_back();
    to_welded.reserve(table.positions.size() / 3);
    for (std::size_t i = 0; i + 2 < table.positions.size(); i += 3) {
      const PositionBits bits = positionBits(&table.positions[i]);
      std::size_t slot = hashPosition(bits) & (slots.size() - 1);
      while (slots[slot] != kNone && positionBits(&positions[std::size_t{3} * slots[slot]]) != bits) {
        slot = (slot + 1) & (slots.size() - 1);
      }
      if (slots[slot] == kNone) {
        slots[slot] = static_cast<std::uint32_t>(positions.size() / 3);
        for (const std::uint32_t coordinate : bits) positions.push_back(std::bit_cast<float>(coordinate));
      }
      to_welded.push_back(slots[slot]);
    }
  }
  for (const Primitive& primitive : mesh.primitives) {
    const std::vector<std::uint32_t>& to_welded = result.table_vertex_to_welded[primitive.table];
    for (const std::uint32_t index : primitive.indices) result.mesh.corner_vertex.push_back(to_welded[index]);
  }
  return result;
}

CutMesh cutToManifold(std::span<const float> welded_positions, std::span<const std::uint32_t> corner_vertex) {
  CutMesh cut;
  const std::vector<std::uint8_t> is_side = findSideFaces(corner_vertex, welded_positions.size() / 3);
  std::vector<std::uint32_t> kept;  // welded vertices of the faces that stay
  kept.reserve(corner_vertex.size());
  for (std::uint32_t face = 0; face < is_side.size(); ++face) {
    (is_side[face] ? cut.side_faces : cut.input_face).push_back(face);
    if (!is_side[face]) {
      for (std::size_t c = 0; c < 3; ++c) kept.push_back(corner_vertex[std::size_t{3} * face + c]);
    }
  }
  cut.surface.opposite = pairHalfEdges(welded_positions, kept);
  numberUmbrellas(kept, cut);
  closeHoles(cut);
  return cut;
}

}  // namespace tsc
