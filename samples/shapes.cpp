#include "shapes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "triangulate.h"

namespace tsc::samples {
namespace {

using glm::dvec2;
using glm::dvec3;

template <class Vector>
std::vector<float> toFloats(const std::vector<Vector>& values) {
  std::vector<float> floats;
  for (const Vector& value : values) {
    for (int i = 0; i < Vector::length(); ++i) floats.push_back(static_cast<float>(value[i]));
  }
  return floats;
}

/// 1 at the centre, 0 from `radius` on, smooth between.
double bump(dvec3 p, dvec3 centre, double radius) {
  const double d2 = glm::dot(p - centre, p - centre) / (radius * radius);
  return d2 >= 1 ? 0 : (1 - d2) * (1 - d2) * (1 - d2);
}

std::vector<dvec2> circle(dvec2 centre, double radius, int segments, bool clockwise) {
  std::vector<dvec2> points;
  for (int i = 0; i < segments; ++i) {
    const double angle = (clockwise ? -2 : 2) * kPi * i / segments;
    points.push_back(centre + radius * dvec2(cosine(angle), sine(angle)));
  }
  return points;
}

/// A rectangle with quarter circles at its corners, counter-clockwise; also a slot when the corners use up one side.
std::vector<dvec2> roundedRectangle(dvec2 centre, dvec2 half, double radius, int corner_segments) {
  std::vector<dvec2> points;
  const std::array<dvec2, 4> signs = {dvec2(1, 1), dvec2(-1, 1), dvec2(-1, -1), dvec2(1, -1)};
  for (int corner = 0; corner < 4; ++corner) {
    for (int i = 0; i <= corner_segments; ++i) {
      const double angle = kPi / 2 * (corner + static_cast<double>(i) / corner_segments);
      const dvec2 point = centre + signs[corner] * (half - radius) + radius * dvec2(cosine(angle), sine(angle));
      if (points.empty() || glm::distance(points.back(), point) > 1e-9) points.push_back(point);
    }
  }
  return points;
}

/// A planar face at height `y` with the loops as its borders (x, z of the part), looking up or down.
void addCap(Surface& part, const std::vector<std::vector<dvec2>>& loops, double y, bool up) {
  const auto base = static_cast<std::uint32_t>(part.positions.size());
  for (const auto& loop : loops) {
    for (const dvec2& point : loop) {
      part.positions.push_back({point.x, y, -point.y});
      part.normals.push_back({0, up ? 1 : -1, 0});
    }
  }
  std::vector<std::uint32_t> triangles = clipEars(loops);
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    if (!up) std::swap(triangles[i + 1], triangles[i + 2]);
  }
  for (const std::uint32_t index : triangles) part.indices.push_back(base + index);
}

/// The wall over a loop from `low` to `high`; a wall quad's side looks to the right of the loop's direction. Smooth
/// walls share vertices between neighbours.
void addWall(Surface& part, const std::vector<dvec2>& loop, double low, double high, bool smooth) {
  const std::size_t n = loop.size();
  const auto outward = [&](std::size_t edge) {
    const dvec2 along = glm::normalize(loop[(edge + 1) % n] - loop[edge % n]);
    return dvec3(along.y, 0, along.x);
  };
  const auto addPair = [&](std::size_t i, dvec3 normal) {
    for (const double y : {low, high}) {
      part.positions.push_back({loop[i % n].x, y, -loop[i % n].y});
      part.normals.push_back(normal);
    }
  };
  const auto base = static_cast<std::uint32_t>(part.positions.size());
  for (std::size_t i = 0; i < n; ++i) {
    if (smooth) {
      addPair(i, glm::normalize(outward(i + n - 1) + outward(i)));
    } else {
      addPair(i, outward(i));
      addPair(i + 1, outward(i));
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const auto left = static_cast<std::uint32_t>(base + (smooth ? 2 * i : 4 * i));
    const auto right = static_cast<std::uint32_t>(base + (smooth ? 2 * ((i + 1) % n) : 4 * i + 2));
    part.indices.insert(part.indices.end(), {left, right, right + 1, left, right + 1, left + 1});
  }
}

}  // namespace

double sine(double radians) {
  const double turns = radians / (2 * kPi);
  const double x = (turns - std::floor(turns + 0.5)) * (2 * kPi);  // floor is exact, unlike libm's sin
  double term = x, sum = x;
  for (int i = 1; i < 16; ++i) {
    term *= -x * x / ((2 * i) * (2 * i + 1));
    sum += term;
  }
  return sum;
}

double Random::next() {
  std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) / 9007199254740992.0;  // 53 bits over 2^53
}

std::vector<float> Surface::positionFloats() const { return toFloats(positions); }

std::vector<float> Surface::normalFloats() const {
  // glTF wants unit length after rounding too: 0.0005 is allowed, float rounding is far below.
  return toFloats(normals);
}

std::vector<float> Surface::uvFloats() const { return toFloats(uvs); }

void computeNormals(Surface& surface) {
  surface.normals.assign(surface.positions.size(), dvec3(0));
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    const std::uint32_t* corner = &surface.indices[i];
    const dvec3 origin = surface.positions[corner[0]];
    const dvec3 normal = glm::cross(surface.positions[corner[1]] - origin, surface.positions[corner[2]] - origin);
    for (int k = 0; k < 3; ++k) surface.normals[corner[k]] += normal;
  }
  for (dvec3& normal : surface.normals) {
    const double length = glm::length(normal);
    normal = length > 0 ? normal / length : dvec3(0, 1, 0);
  }
}

Surface icosphere(int levels) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  Surface sphere;
  sphere.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  sphere.indices = {0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4,  11, 10, 2,  10, 7, 6, 7, 1, 8,
                    3, 9,  4, 3, 4, 2, 3, 2, 6, 3, 6, 8,  3, 8,  9,  4, 9, 5, 2, 4,  11, 6,  2,  10, 8,  6, 7, 9, 8, 1};
  for (dvec3& p : sphere.positions) p = glm::normalize(p);
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [entry, added] = middles.try_emplace(std::minmax(a, b), sphere.positions.size());
      if (added) sphere.positions.push_back(glm::normalize(sphere.positions[a] + sphere.positions[b]));
      return entry->second;
    };
    std::vector<std::uint32_t> finer;
    for (std::size_t i = 0; i < sphere.indices.size(); i += 3) {
      const std::uint32_t a = sphere.indices[i], b = sphere.indices[i + 1], c = sphere.indices[i + 2];
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca});
    }
    sphere.indices = std::move(finer);
  }
  computeNormals(sphere);
  return sphere;
}

Surface slug() {
  Surface body = icosphere(5);
  for (dvec3& p : body.positions) {
    const dvec3 n = p;
    double radius = 1 + 0.45 * bump(n, {0.7, 0.5, 0}, 0.9) + 0.3 * bump(n, {-0.9, 0.1, 0.1}, 0.7);
    radius += 0.5 * bump(n, {0.75, 0.55, 0.35}, 0.28) + 0.5 * bump(n, {0.75, 0.55, -0.35}, 0.28);  // horns
    radius += 0.03 * sine(9 * n.x + 2 * sine(4 * n.z)) * (1 - n.y * n.y);                          // folds
    radius += 0.012 * sine(23 * n.z + 5 * n.y) * sine(19 * n.x);
    p = radius * n * dvec3(1.6, 0.8, 0.9);
    p.z += 0.25 * sine(1.3 * p.x);                                  // the body bends
    p.y = std::max(p.y, -0.45) + 0.15 * std::min(p.y + 0.45, 0.0);  // and rests on its sole
  }
  computeNormals(body);
  return body;
}

Surface flange() {
  constexpr double kBase = 0.0, kPlate = 0.012, kTop = 0.045;  // metres
  const std::vector<dvec2> outline = roundedRectangle({0, 0}, {0.06, 0.04}, 0.01, 12);
  const std::vector<dvec2> boss = circle({-0.015, 0}, 0.022, 96, false);
  std::vector<std::vector<dvec2>> bores;
  for (const double x : {-0.048, 0.048}) {
    for (const double y : {-0.028, 0.028}) bores.push_back(circle({x, y}, 0.0045, 40, true));
  }
  std::vector<dvec2> slot = roundedRectangle({0.032, 0}, {0.004, 0.018}, 0.004, 10);
  std::ranges::reverse(slot);
  bores.push_back(std::move(slot));
  const std::vector<dvec2> shaft = circle({-0.015, 0}, 0.014, 80, true);
  const auto loopsWith = [&](const std::vector<dvec2>& inner) {
    std::vector<std::vector<dvec2>> loops = {outline};
    loops.insert(loops.end(), bores.begin(), bores.end());
    loops.push_back(inner);
    return loops;
  };
  std::vector<dvec2> boss_hole = boss;
  std::ranges::reverse(boss_hole);

  Surface part;
  addCap(part, loopsWith(boss_hole), kPlate, true);
  addCap(part, loopsWith(shaft), kBase, false);
  addCap(part, {boss, shaft}, kTop, true);
  addWall(part, outline, kBase, kPlate, false);
  for (const auto& bore : bores) addWall(part, bore, kBase, kPlate, true);
  addWall(part, boss, kPlate, kTop, true);
  addWall(part, shaft, kBase, kTop, true);
  return part;
}

Surface turned(const std::vector<glm::dvec2>& profile, int segments) {
  Surface result;
  const std::size_t n = profile.size();
  const auto slope = [&](std::size_t a, std::size_t b) {
    const dvec2 along = profile[b] - profile[a];
    return glm::length(along) > 0 ? dvec2(along.y, -along.x) / glm::length(along) : dvec2(0);
  };
  for (std::size_t i = 0; i < n; ++i) {
    dvec2 normal = (i > 0 ? slope(i - 1, i) : dvec2(0)) + (i + 1 < n ? slope(i, i + 1) : dvec2(0));
    normal = glm::normalize(normal);
    for (int s = 0; s <= segments; ++s) {
      const double angle = 2 * kPi * (s % segments) / segments;  // the seam's two sides are equal to the last bit
      const double c = cosine(angle), w = -sine(angle);
      result.positions.push_back({profile[i].x * c, profile[i].y, profile[i].x * w});
      result.normals.push_back({normal.x * c, normal.y, normal.x * w});
      result.uvs.push_back({static_cast<double>(s) / segments, static_cast<double>(i) / static_cast<double>(n - 1)});
    }
  }
  const auto row = static_cast<std::uint32_t>(segments + 1);
  for (std::uint32_t i = 0; i + 1 < n; ++i) {
    if (profile[i] == profile[i + 1]) continue;  // a hard edge
    for (std::uint32_t s = 0; s + 1 < row; ++s) {
      const std::uint32_t a = i * row + s, b = a + 1, c = a + row, d = c + 1;
      if (profile[i].x > 0) result.indices.insert(result.indices.end(), {a, b, c});
      if (profile[i + 1].x > 0) result.indices.insert(result.indices.end(), {b, d, c});
    }
  }
  return result;
}

Surface rotatedPlane(double degrees) {
  constexpr int kSide = 24;
  Random random(2);
  std::vector<dvec2> points;
  for (int i = 0; i <= kSide; ++i) {
    for (int j = 0; j <= kSide; ++j) {
      const bool x_inside = i > 0 && i<kSide, y_inside = j> 0 && j < kSide;
      const double dx = x_inside ? 0.9 * (random.next() - 0.5) : 0, dy = y_inside ? 0.9 * (random.next() - 0.5) : 0;
      points.push_back({2 * (i + dx) / kSide - 1, 2 * (j + dy) / kSide - 1});
    }
  }
  const double c = cosine(degrees * kPi / 180), s = sine(degrees * kPi / 180);
  Surface plane;
  for (const dvec2& p : points) {
    plane.positions.push_back({p.x, c * p.y, s * p.y});
    plane.normals.push_back({0, -s, c});
  }
  plane.indices = delaunay(points);
  return plane;
}

}  // namespace tsc::samples
