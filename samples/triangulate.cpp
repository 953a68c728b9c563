#include "triangulate.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace tsc::samples {
namespace {

using Point = glm::dvec2;

/// Twice the signed area of a triangle; positive if it turns left.
double turn(Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

bool insideTriangle(Point p, Point a, Point b, Point c) {
  return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

bool segmentsCross(Point a, Point b, Point c, Point d) {
  return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

/// Joins a hole to the polygon by the shortest pair of points that sees each other; the bridge is walked twice.
void bridgeHole(std::vector<std::uint32_t>& polygon, const std::vector<std::uint32_t>& hole,
                std::span<const Point> points, const std::vector<std::array<std::uint32_t, 2>>& edges) {
  double best = 1e300;
  std::size_t best_outer = 0, best_hole = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    for (std::size_t j = 0; j < hole.size(); ++j) {
      const Point a = points[polygon[i]], b = points[hole[j]], d = b - a;
      const double length = d.x * d.x + d.y * d.y;
      if (length >= best) continue;
      const bool hidden = std::ranges::any_of(
          edges, [&](const auto& edge) { return segmentsCross(a, b, points[edge[0]], points[edge[1]]); });
      if (hidden) continue;
      best = length;
      best_outer = i;
      best_hole = j;
    }
  }
  std::vector<std::uint32_t> bridge;
  for (std::size_t j = 0; j <= hole.size(); ++j) bridge.push_back(hole[(best_hole + j) % hole.size()]);
  bridge.push_back(polygon[best_outer]);
  polygon.insert(polygon.begin() + static_cast<std::ptrdiff_t>(best_outer) + 1, bridge.begin(), bridge.end());
}

bool isEar(const std::vector<std::uint32_t>& polygon, std::size_t i, std::span<const Point> points) {
  const std::size_t n = polygon.size();
  const Point a = points[polygon[(i + n - 1) % n]], b = points[polygon[i]], c = points[polygon[(i + 1) % n]];
  if (turn(a, b, c) <= 0) return false;
  return std::ranges::none_of(polygon, [&](std::uint32_t index) {
    const Point p = points[index];
    return p != a && p != b && p != c && insideTriangle(p, a, b, c);
  });
}

/// Whether `p` lies inside the circle through a counter-clockwise triangle.
bool insideCircle(Point p, Point a, Point b, Point c) {
  a -= p, b -= p, c -= p;
  const double a2 = a.x * a.x + a.y * a.y, b2 = b.x * b.x + b.y * b.y, c2 = c.x * c.x + c.y * c.y;
  return a.x * (b.y * c2 - b2 * c.y) - a.y * (b.x * c2 - b2 * c.x) + a2 * (b.x * c.y - b.y * c.x) > 1e-12;
}

}  // namespace

std::vector<std::uint32_t> clipEars(const std::vector<std::vector<glm::dvec2>>& loops) {
  std::vector<Point> points;
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<std::vector<std::uint32_t>> rings;
  for (const auto& loop : loops) {
    const auto base = static_cast<std::uint32_t>(points.size()), size = static_cast<std::uint32_t>(loop.size());
    rings.emplace_back();
    for (std::uint32_t i = 0; i < size; ++i) {
      rings.back().push_back(base + i);
      edges.push_back({base + i, base + (i + 1) % size});
    }
    points.insert(points.end(), loop.begin(), loop.end());
  }
  std::vector<std::uint32_t> polygon = rings[0];
  for (std::size_t i = 1; i < rings.size(); ++i) bridgeHole(polygon, rings[i], points, edges);

  std::vector<std::uint32_t> triangles;
  std::size_t at = 0, failures = 0;
  while (polygon.size() > 2 && failures < polygon.size()) {
    const std::size_t n = polygon.size();
    at %= n;
    if (!isEar(polygon, at, points)) {
      ++at, ++failures;
      continue;
    }
    triangles.insert(triangles.end(), {polygon[(at + n - 1) % n], polygon[at], polygon[(at + 1) % n]});
    polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(at));
    failures = 0;
  }
  return triangles;
}

std::vector<std::uint32_t> delaunay(std::span<const glm::dvec2> input) {
  // Bowyer-Watson: each point removes the triangles whose circle holds it and fills the hole with a fan.
  std::vector<Point> points(input.begin(), input.end());
  const auto first_helper = static_cast<std::uint32_t>(points.size());
  points.insert(points.end(), {{-1000, -1000}, {1000, -1000}, {0, 1000}});
  std::vector<std::array<std::uint32_t, 3>> triangles = {{first_helper, first_helper + 1, first_helper + 2}};
  for (std::uint32_t p = 0; p < first_helper; ++p) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> rim;
    std::erase_if(triangles, [&](const auto& t) {
      if (!insideCircle(points[p], points[t[0]], points[t[1]], points[t[2]])) return false;
      for (int i = 0; i < 3; ++i) rim[{t[i], t[(i + 1) % 3]}] = 1;
      return true;
    });
    for (const auto& [edge, unused] : rim) {
      if (!rim.contains({edge.second, edge.first})) triangles.push_back({edge.first, edge.second, p});
    }
  }
  std::vector<std::uint32_t> result;
  for (const auto& t : triangles) {
    if (t[0] >= first_helper || t[1] >= first_helper || t[2] >= first_helper) continue;
    if (turn(points[t[0]], points[t[1]], points[t[2]]) < 1e-9) continue;  // on the hull
    result.insert(result.end(), t.begin(), t.end());
  }
  return result;
}

}  // namespace tsc::samples
