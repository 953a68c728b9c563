// Which vertex of one mesh is which of another: by position and connectivity, whatever the order.
//
// Triangles are matched, and with them their corners. In each part of A that is connected over edges with exactly two
// triangles, one seed triangle is matched to a triangle of B with a near centroid; all others follow over the corner
// table, where each step has one way to go. A contradiction discards the seed's match and the next nearest is tried.
// Traps: soups and mirrored or regular meshes have many correspondences, so small error decides between them; welding
// comes first because any soup of n triangles "matches" any other.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>

#include "surface_tools.h"
#include "triangle_finder.h"

namespace tsc {
namespace {

/// The proper triangles of one mesh at one level of welding, on its own numbering of the vertices they use.
struct Topology {
  std::vector<std::uint32_t> indices;        ///< node of each corner, nodes numbered by first appearance
  std::vector<std::uint32_t> source_corner;  ///< corner of the input that each corner came from
  std::vector<glm::dvec3> positions;         ///< of nodes
  std::vector<std::uint32_t> twin;

  [[nodiscard]] std::size_t faceCount() const { return indices.size() / 3; }
};

/// `node(v)` is the node that vertex v belongs to, below the vertex count.
template <class Node>
Topology buildTopology(const SurfaceView& surface, Node node) {
  Topology topology;
  std::vector<std::uint32_t> number(surface.positions.size(), kNone);
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    const std::array<std::uint32_t, 3> corners = {node(surface.indices[i]), node(surface.indices[i + 1]),
                                                  node(surface.indices[i + 2])};
    if (!isProper(corners[0], corners[1], corners[2])) continue;
    for (int k = 0; k < 3; ++k) {
      if (number[corners[k]] == kNone) {
        number[corners[k]] = static_cast<std::uint32_t>(topology.positions.size());
        topology.positions.push_back(pointAt(surface.positions, surface.indices[i + k]));
      }
      topology.indices.push_back(number[corners[k]]);
      topology.source_corner.push_back(static_cast<std::uint32_t>(i + k));
    }
  }
  topology.twin = pairEdges(topology.indices, topology.positions.size());
  return topology;
}

std::size_t rotated(std::size_t corner, std::size_t by) { return corner - corner % 3 + (corner % 3 + by) % 3; }

/// Corner-to-corner match of A's triangles with B's, part by part.
class Matcher {
 public:
  Matcher(const Topology& a, const Topology& b)
      : a_(a),
        b_(b),
        b_corner_(a.faceCount(), kNone),
        a_face_(b.faceCount(), kNone),
        b_node_(a.positions.size(), kNone),
        a_node_(b.positions.size(), kNone),
        finder_(b.positions, b.indices),
        b_face_start_(b.positions.size() + 1, 0),
        b_faces_(b.indices.size()) {
    for (const std::uint32_t node : b.indices) ++b_face_start_[node + 1];
    std::partial_sum(b_face_start_.begin(), b_face_start_.end(), b_face_start_.begin());
    std::vector<std::uint32_t> next(b_face_start_.begin(), b_face_start_.end() - 1);
    for (std::uint32_t c = 0; c < b.indices.size(); ++c) b_faces_[next[b.indices[c]]++] = c / 3;
  }

  /// For each face of A the corner of B that its first corner is; empty if there is no correspondence.
  std::vector<std::uint32_t> run() {
    std::vector<Part> open = parts();
    // Large parts are sure by themselves. Of small ones, those with the most nodes matched already come first, again
    // and again as more become matched: where points have merged, a free choice made too early can be wrong.
    constexpr std::size_t kLargePart = 64;
    for (const int needed : {-1, 3, 2, 3, 1, 2, 3, 0}) {
      std::vector<Part> left;
      for (const Part& part : open) {
        const bool due = needed < 0 ? part.faces >= kLargePart : matchedNodes(part.seed) >= needed;
        if (!due) left.push_back(part);
        else if (!matchPart(part)) return {};
      }
      open = std::move(left);
    }
    return std::move(b_corner_);
  }

 private:
  struct Part {
    std::uint32_t seed;  ///< its face whose shortest side is longest, so hardest to mistake
    double mean_edge;
    std::size_t faces;
  };
  struct Candidate {
    double squared_distance;
    std::uint32_t b_corner;
  };

  std::vector<Part> parts() const {
    std::vector<Part> parts;
    std::vector<bool> seen(a_.faceCount(), false);
    std::vector<std::uint32_t> stack;
    for (std::uint32_t first = 0; first < a_.faceCount(); ++first) {
      if (seen[first]) continue;
      Part part{first, 0, 0};
      double longest = -1;
      std::size_t edges = 0;
      stack.assign(1, first);
      seen[first] = true;
      while (!stack.empty()) {
        const std::uint32_t face = stack.back();
        stack.pop_back();
        ++part.faces;
        double shortest = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 3; ++k) {
          const double length = glm::distance(cornerA(3 * face + k), cornerA(rotated(3 * face + k, 1)));
          shortest = std::min(shortest, length);
          part.mean_edge += length;
          ++edges;
          const std::uint32_t twin = a_.twin[3 * face + k];
          if (twin == kNone || seen[twin / 3]) continue;
          seen[twin / 3] = true;
          stack.push_back(twin / 3);
        }
        if (shortest > longest) {
          longest = shortest;
          part.seed = face;
        }
      }
      part.mean_edge /= static_cast<double>(edges);
      parts.push_back(part);
    }
    std::stable_sort(parts.begin(), parts.end(), [](const Part& x, const Part& y) { return x.faces > y.faces; });
    return parts;
  }

  const glm::dvec3& cornerA(std::size_t corner) const { return a_.positions[a_.indices[corner]]; }
  const glm::dvec3& cornerB(std::size_t corner) const { return b_.positions[b_.indices[corner]]; }

  int matchedNodes(std::uint32_t face) const {
    int count = 0;
    for (std::uint32_t k = 0; k < 3; ++k) count += b_node_[a_.indices[3 * face + k]] != kNone;
    return count;
  }

  bool matchPart(const Part& part) {
    // More coincident triangles than the first search returns would hide the right one.
    for (const std::size_t neighbours : {8, 256}) {
      double best = std::numeric_limits<double>::infinity();
      std::uint32_t best_corner = kNone;
      for (const Candidate& candidate : candidates(part.seed, neighbours)) {
        const double mean_squared = spread(part.seed, candidate.b_corner);
        if (mean_squared < 0) continue;
        // Clearly right: do not look for symmetries of the connectivity.
        if (std::sqrt(mean_squared) < part.mean_edge / 4) return true;
        if (mean_squared < best) {
          best = mean_squared;
          best_corner = candidate.b_corner;
        }
        undo();
      }
      if (best_corner != kNone) return spread(part.seed, best_corner) >= 0;
    }
    return false;
  }

  /// Free triangles of B near a face of A, in three rotations each, nearest first, that agree with the nodes matched
  /// so far.
  std::vector<Candidate> candidates(std::uint32_t face, std::size_t neighbours) const {
    std::vector<Candidate> result;
    for (const std::uint32_t b_face : facesNear(face, neighbours)) {
      if (a_face_[b_face] != kNone) continue;
      for (std::uint32_t turn = 0; turn < 3; ++turn) {
        Candidate candidate{0, 3 * b_face + turn};
        if (!agrees(face, candidate.b_corner)) continue;
        for (std::uint32_t k = 0; k < 3; ++k) {
          const glm::dvec3 offset = cornerB(rotated(candidate.b_corner, k)) - cornerA(3 * face + k);
          candidate.squared_distance += glm::dot(offset, offset);
        }
        result.push_back(candidate);
      }
    }
    std::stable_sort(result.begin(), result.end(),
                     [](const Candidate& x, const Candidate& y) { return x.squared_distance < y.squared_distance; });
    return result;
  }

  /// Around a node that is matched already, or else by centroid.
  std::vector<std::uint32_t> facesNear(std::uint32_t face, std::size_t neighbours) const {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t b_node = b_node_[a_.indices[3 * face + k]];
      if (b_node == kNone) continue;
      return {b_faces_.begin() + b_face_start_[b_node], b_faces_.begin() + b_face_start_[b_node + 1]};
    }
    return finder_.nearest((cornerA(3 * face) + cornerA(3 * face + 1) + cornerA(3 * face + 2)) / 3.0, neighbours);
  }

  bool agrees(std::uint32_t face, std::uint32_t b_corner) const {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t node = a_.indices[3 * face + k], b_node = b_.indices[rotated(b_corner, k)];
      if (b_node_[node] != b_node && (b_node_[node] != kNone || a_node_[b_node] != kNone)) return false;
    }
    return true;
  }

  /// Matches the whole part from one face; the mean squared distance of its corners, or -1, all undone, if it fails.
  double spread(std::uint32_t face, std::uint32_t b_corner) {
    matched_faces_.clear();
    matched_nodes_.clear();
    if (!assign(face, b_corner)) return undo();
    double sum = 0;
    for (std::size_t i = 0; i < matched_faces_.size(); ++i) {  // grows as faces are matched
      const std::uint32_t current = matched_faces_[i];
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::size_t corner = 3 * current + k;
        const std::size_t counterpart = rotated(b_corner_[current], k);
        const glm::dvec3 offset = cornerB(counterpart) - cornerA(corner);
        sum += glm::dot(offset, offset);
        const std::uint32_t twin_a = a_.twin[corner], twin_b = b_.twin[counterpart];
        if ((twin_a == kNone) != (twin_b == kNone)) return undo();
        if (twin_a == kNone) continue;
        // The corner of B that answers to the first corner of twin_a's face.
        const std::size_t first = rotated(twin_b, 3 - twin_a % 3);
        if (!assign(twin_a / 3, static_cast<std::uint32_t>(first))) return undo();
      }
    }
    return sum / (3.0 * static_cast<double>(matched_faces_.size()));
  }

  bool assign(std::uint32_t face, std::uint32_t b_corner) {
    if (b_corner_[face] != kNone || a_face_[b_corner / 3] != kNone) return b_corner_[face] == b_corner;
    b_corner_[face] = b_corner;
    a_face_[b_corner / 3] = face;
    matched_faces_.push_back(face);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t node = a_.indices[3 * face + k];
      const std::uint32_t b_node = b_.indices[rotated(b_corner, k)];
      if (b_node_[node] == b_node) continue;
      if (b_node_[node] != kNone || a_node_[b_node] != kNone) return false;
      b_node_[node] = b_node;
      a_node_[b_node] = node;
      matched_nodes_.push_back(node);
    }
    return true;
  }

  double undo() {
    for (const std::uint32_t face : matched_faces_) {
      a_face_[b_corner_[face] / 3] = kNone;
      b_corner_[face] = kNone;
    }
    for (const std::uint32_t node : matched_nodes_) {
      a_node_[b_node_[node]] = kNone;
      b_node_[node] = kNone;
    }
    matched_faces_.clear();
    matched_nodes_.clear();
    return -1;
  }

  const Topology& a_;
  const Topology& b_;
  std::vector<std::uint32_t> b_corner_;  ///< per face of A: the corner of B that its first corner is
  std::vector<std::uint32_t> a_face_;    ///< its inverse on faces
  std::vector<std::uint32_t> b_node_;    ///< per node of A, and the inverse: both one to one
  std::vector<std::uint32_t> a_node_;
  std::vector<std::uint32_t> matched_faces_;  ///< by the current part
  std::vector<std::uint32_t> matched_nodes_;
  TriangleFinder finder_;
  std::vector<std::uint32_t> b_face_start_;  ///< where each node's faces begin in `b_faces_`
  std::vector<std::uint32_t> b_faces_;
};

struct FaceMatch {
  std::vector<std::uint32_t> b_corner;  ///< per face of A; empty: none
  double mean_squared = std::numeric_limits<double>::infinity();
};

double meanSquaredDistance(const Topology& a, const Topology& b, const std::vector<std::uint32_t>& b_corner) {
  double sum = 0;
  for (std::size_t corner = 0; corner < a.indices.size(); ++corner) {
    const std::size_t counterpart = rotated(b_corner[corner / 3], corner % 3);
    const glm::dvec3 offset = b.positions[b.indices[counterpart]] - a.positions[a.indices[corner]];
    sum += glm::dot(offset, offset);
  }
  return sum / static_cast<double>(a.indices.size());
}

double meanEdge(const Topology& topology) {
  double sum = 0;
  for (std::size_t c = 0; c < topology.indices.size(); ++c) {
    sum += glm::distance(topology.positions[topology.indices[c]], topology.positions[topology.indices[rotated(c, 1)]]);
  }
  return sum / static_cast<double>(topology.indices.size());
}

/// The better of the order as it stands, where that is a correspondence, and of the search. What the search finds
/// farther away than an edge is no answer but a symmetry of the connectivity, or a soup that matches any other.
FaceMatch matchFaces(const Topology& a, const Topology& b) {
  FaceMatch match;
  if (a.indices.size() != b.indices.size() || a.positions.size() != b.positions.size()) return match;
  const double mean_edge = meanEdge(a);
  if (a.indices == b.indices) {
    match.b_corner.resize(a.faceCount());
    for (std::size_t face = 0; face < a.faceCount(); ++face)
      match.b_corner[face] = static_cast<std::uint32_t>(3 * face);
    match.mean_squared = meanSquaredDistance(a, b, match.b_corner);
    if (std::sqrt(match.mean_squared) < mean_edge / 4) return match;
  }
  FaceMatch found{Matcher(a, b).run()};
  if (found.b_corner.empty()) return match;
  found.mean_squared = meanSquaredDistance(a, b, found.b_corner);
  return std::sqrt(found.mean_squared) < mean_edge && found.mean_squared < match.mean_squared ? found : match;
}

/// Turns matched corners into matched vertices: one to one if the vertex tables allow it, else point to point.
Correspondence correspondenceOf(const SurfaceView& a, const SurfaceView& b, const Topology& topology_a,
                                const Topology& topology_b, const FaceMatch& match) {
  Correspondence result;
  result.b_of_a.assign(a.positions.size(), kUnmatchedVertex);
  std::vector<std::uint32_t> a_of_b(b.positions.size(), kUnmatchedVertex);
  std::vector<std::uint32_t> first_of_node(topology_a.positions.size(), kNone);
  for (std::size_t corner = 0; corner < topology_a.indices.size(); ++corner) {
    const std::size_t counterpart = rotated(match.b_corner[corner / 3], corner % 3);
    const std::uint32_t v = a.indices[topology_a.source_corner[corner]];
    const std::uint32_t w = b.indices[topology_b.source_corner[counterpart]];
    if ((result.b_of_a[v] != kUnmatchedVertex && result.b_of_a[v] != w) ||
        (a_of_b[w] != kUnmatchedVertex && a_of_b[w] != v)) {
      result.level = Correspondence::Level::kPoints;
    }
    if (result.b_of_a[v] == kUnmatchedVertex) result.b_of_a[v] = w;
    a_of_b[w] = v;
    std::uint32_t& first = first_of_node[topology_a.indices[corner]];
    if (first == kNone) first = v;
  }
  if (result.level == Correspondence::Level::kPoints) {
    result.representatives = std::move(first_of_node);
  } else {
    for (std::uint32_t v = 0; v < result.b_of_a.size(); ++v) {
      if (result.b_of_a[v] != kUnmatchedVertex) result.representatives.push_back(v);
    }
  }
  return result;
}

}  // namespace

Measured<Correspondence> matchVertices(const SurfaceView& a, const SurfaceView& b) {
  for (const SurfaceView* surface : {&a, &b}) {
    if (auto error = checkSurface(*surface)) return *std::move(error);
  }
  const Welding welding_a = weldPositions(a.positions), welding_b = weldPositions(b.positions);
  const auto point_a = [&](std::uint32_t v) { return welding_a.point_of_vertex[v]; };
  const auto point_b = [&](std::uint32_t v) { return welding_b.point_of_vertex[v]; };
  {
    const Topology points_a = buildTopology(a, point_a), points_b = buildTopology(b, point_b);
    const FaceMatch match = matchFaces(points_a, points_b);
    if (!match.b_corner.empty()) return correspondenceOf(a, b, points_a, points_b, match);
  }
  // Coarse rounding can merge points that were apart; then the vertices as they stand may still correspond. Here a
  // match far off says nothing even in the order as it stands: tables with a vertex a corner match any other of that
  // size.
  const auto self = [](std::uint32_t v) { return v; };
  const Topology raw_a = buildTopology(a, self), raw_b = buildTopology(b, self);
  const FaceMatch match = matchFaces(raw_a, raw_b);
  if (match.b_corner.empty() || std::sqrt(match.mean_squared) > meanEdge(raw_a)) {
    return QualityError{QualityErrorCode::kConnectivityDiffers, "connectivity differs"};
  }
  return correspondenceOf(a, b, raw_a, raw_b, match);
}

}  // namespace tsc
