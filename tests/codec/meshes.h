// Small meshes made by code, for tests: regular, open, closed, with handles, non-manifold, two-sided, random.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tsc/codec.h"

namespace tsc::meshes {

struct Triangles {
  std::vector<float> positions;        ///< x y z a vertex
  std::vector<std::uint32_t> indices;  ///< 3 a triangle

  std::uint32_t vertexCount() const { return static_cast<std::uint32_t>(positions.size() / 3); }
  std::uint32_t faceCount() const { return static_cast<std::uint32_t>(indices.size() / 3); }

  std::uint32_t addVertex(float x, float y, float z) {
    for (const float coordinate : {x, y, z}) positions.push_back(coordinate);
    return vertexCount() - 1;
  }
  void addFace(std::uint32_t a, std::uint32_t b, std::uint32_t c) { indices.insert(indices.end(), {a, b, c}); }

  /// One table, one primitive. Borrows this object.
  Mesh mesh() const {
    Mesh mesh;
    mesh.tables.push_back({positions});
    mesh.primitives.push_back({0, indices});
    return mesh;
  }
};

inline constexpr float kPi = 3.14159265f;

/// An open grid of columns x rows quads in the plane z = height(x, y).
template <class Height>
Triangles grid(std::uint32_t columns, std::uint32_t rows, Height height) {
  Triangles mesh;
  for (std::uint32_t y = 0; y <= rows; ++y) {
    for (std::uint32_t x = 0; x <= columns; ++x) {
      const auto fx = static_cast<float>(x);
      const auto fy = static_cast<float>(y);
      mesh.addVertex(fx, fy, height(fx, fy));
    }
  }
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t a = y * (columns + 1) + x;
      mesh.addFace(a, a + 1, a + columns + 2);
      mesh.addFace(a, a + columns + 2, a + columns + 1);
    }
  }
  return mesh;
}
inline Triangles grid(std::uint32_t columns, std::uint32_t rows) {
  return grid(columns, rows, [](float x, float y) { return std::sin(0.3f * x) * std::cos(0.2f * y); });
}

/// A closed surface of the torus' topology, every vertex of degree 6; u and v at least 3.
inline Triangles torus(std::uint32_t u_count, std::uint32_t v_count) {
  Triangles mesh;
  for (std::uint32_t u = 0; u < u_count; ++u) {
    for (std::uint32_t v = 0; v < v_count; ++v) {
      const float a = 2 * kPi * static_cast<float>(u) / static_cast<float>(u_count);
      const float b = 2 * kPi * static_cast<float>(v) / static_cast<float>(v_count);
      mesh.addVertex((3 + std::cos(b)) * std::cos(a), (3 + std::cos(b)) * std::sin(a), std::sin(b));
    }
  }
  for (std::uint32_t u = 0; u < u_count; ++u) {
    for (std::uint32_t v = 0; v < v_count; ++v) {
      const std::uint32_t u1 = (u + 1) % u_count;
      const std::uint32_t v1 = (v + 1) % v_count;
      mesh.addFace(u * v_count + v, u1 * v_count + v, u1 * v_count + v1);
      mesh.addFace(u * v_count + v, u1 * v_count + v1, u * v_count + v1);
    }
  }
  return mesh;
}

/// A closed sphere of `rings` x `sectors`, with two poles of degree `sectors` (at least 2; 2 rings at least).
inline Triangles sphere(std::uint32_t rings, std::uint32_t sectors) {
  Triangles mesh;
  for (std::uint32_t r = 1; r < rings; ++r) {
    for (std::uint32_t s = 0; s < sectors; ++s) {
      const float a = kPi * static_cast<float>(r) / static_cast<float>(rings);
      const float b = 2 * kPi * static_cast<float>(s) / static_cast<float>(sectors);
      mesh.addVertex(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
    }
  }
  const std::uint32_t north = mesh.addVertex(0, 0, 1);
  const std::uint32_t south = mesh.addVertex(0, 0, -1);
  const std::uint32_t last = (rings - 2) * sectors;
  for (std::uint32_t s = 0; s < sectors; ++s) {
    const std::uint32_t s1 = (s + 1) % sectors;
    mesh.addFace(north, s, s1);
    mesh.addFace(south, last + s1, last + s);
    for (std::uint32_t r = 0; r + 2 < rings; ++r) {
      mesh.addFace(r * sectors + s, (r + 1) * sectors + s, (r + 1) * sectors + s1);
      mesh.addFace(r * sectors + s, (r + 1) * sectors + s1, r * sectors + s1);
    }
  }
  return mesh;
}

inline Triangles tetrahedron() {
  return {{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}};
}

inline Triangles triangle() { return {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}}; }

/// `count` triangles around one vertex; a closed disc or an open fan.
inline Triangles fan(std::uint32_t count, bool closed) {
  Triangles mesh;
  mesh.addVertex(0, 0, 0);
  const std::uint32_t rim = closed ? count : count + 1;
  for (std::uint32_t i = 0; i < rim; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / static_cast<float>(count + 1);
    mesh.addVertex(std::cos(a), std::sin(a), 0);
  }
  for (std::uint32_t i = 0; i < count; ++i) mesh.addFace(0, 1 + i, 1 + (i + 1) % rim);
  return mesh;
}

/// `pages` quads on one common edge, alternating in orientation.
inline Triangles book(std::uint32_t pages) {
  Triangles mesh;
  const std::uint32_t a = mesh.addVertex(0, 0, 0);
  const std::uint32_t b = mesh.addVertex(0, 0, 1);
  for (std::uint32_t i = 0; i < pages; ++i) {
    const float angle = 2 * kPi * static_cast<float>(i) / static_cast<float>(pages);
    const std::uint32_t c = mesh.addVertex(std::cos(angle), std::sin(angle), 1);
    const std::uint32_t d = mesh.addVertex(std::cos(angle), std::sin(angle), 0);
    if (i % 2 == 0) {
      mesh.addFace(a, b, c);
      mesh.addFace(a, c, d);
    } else {
      mesh.addFace(b, a, c);
      mesh.addFace(c, a, d);
    }
  }
  return mesh;
}

inline Triangles moebiusStrip(std::uint32_t count) {
  Triangles mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / static_cast<float>(count);
    for (const float w : {-0.3f, 0.3f}) {
      const float r = 1 + w * std::cos(a / 2);
      mesh.addVertex(r * std::cos(a), r * std::sin(a), w * std::sin(a / 2));
    }
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t a = 2 * i;
    const bool wraps = i + 1 == count;
    const std::uint32_t c = wraps ? 1 : a + 2;  // the strip comes back upside down
    const std::uint32_t d = wraps ? 0 : a + 3;
    mesh.addFace(a, c, d);
    mesh.addFace(a, d, a + 1);
  }
  return mesh;
}

/// The mesh and its flip side on the same vertices.
inline Triangles twoSided(Triangles mesh) {
  const std::vector<std::uint32_t> front = mesh.indices;
  for (std::size_t i = 0; i < front.size(); i += 3) mesh.addFace(front[i], front[i + 2], front[i + 1]);
  return mesh;
}

/// Copies of a mesh beside each other.
inline Triangles repeated(const Triangles& one, std::uint32_t count) {
  Triangles mesh;
  for (std::uint32_t copy = 0; copy < count; ++copy) {
    const std::uint32_t base = mesh.vertexCount();
    for (std::size_t i = 0; i < one.positions.size(); i += 3) {
      mesh.addVertex(one.positions[i] + 10.0f * static_cast<float>(copy), one.positions[i + 1], one.positions[i + 2]);
    }
    for (const std::uint32_t index : one.indices) mesh.indices.push_back(base + index);
  }
  return mesh;
}

/// Every face whose random number falls below `share` is taken out.
inline Triangles perforated(const Triangles& mesh, double share, std::uint32_t seed) {
  std::mt19937 random(seed);
  Triangles result{mesh.positions, {}};
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    if (random() / 4294967296.0 < share) continue;
    result.addFace(mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]);
  }
  return result;
}

/// The mesh with edges flipped at random, as long as `flips` allows: irregular degrees on the same surface.
inline Triangles shuffledDegrees(Triangles mesh, std::uint32_t flips, std::uint32_t seed) {
  std::mt19937 random(seed);
  const std::uint32_t faces = mesh.faceCount();
  for (std::uint32_t flip = 0; flip < flips; ++flip) {
    // Two faces near each other in the list that share an edge a -> b: (a, b, c) and (b, a, d).
    const std::uint32_t f = random() % faces;
    const std::uint32_t g = (f + 1) % faces;
    std::uint32_t* p = &mesh.indices[3 * f];
    std::uint32_t* q = &mesh.indices[3 * g];
    for (std::uint32_t i = 0; i < 9; ++i) {
      const std::uint32_t a = p[i / 3], b = p[(i / 3 + 1) % 3], c = p[(i / 3 + 2) % 3];
      if (q[i % 3] != b || q[(i % 3 + 1) % 3] != a) continue;
      const std::uint32_t d = q[(i % 3 + 2) % 3];
      if (c == d) break;
      p[0] = a, p[1] = d, p[2] = c;
      q[0] = d, q[1] = b, q[2] = c;
      break;
    }
  }
  return mesh;
}

/// `faces` triangles over `vertices` vertices at random: everything that can be wrong with a mesh.
inline Triangles soup(std::uint32_t vertices, std::uint32_t faces, std::uint32_t seed) {
  std::mt19937 random(seed);
  Triangles mesh;
  for (std::uint32_t i = 0; i < 3 * vertices; ++i) mesh.positions.push_back(static_cast<float>(random() % 64));
  for (std::uint32_t i = 0; i < 3 * faces; ++i) mesh.indices.push_back(random() % vertices);
  return mesh;
}

/// All of the above in small sizes, each with its name.
inline std::vector<std::pair<std::string, Triangles>> samples() {
  std::vector<std::pair<std::string, Triangles>> all = {
      {"empty", {}},
      {"only vertices", {{0, 0, 0, 1, 2, 3}, {}}},
      {"triangle", triangle()},
      {"two-sided triangle", twoSided(triangle())},
      {"tetrahedron", tetrahedron()},
      {"grid", grid(20, 13)},
      {"two-sided grid", twoSided(grid(9, 7))},
      {"torus", torus(12, 17)},
      {"smallest torus", torus(3, 3)},
      {"sphere", sphere(9, 14)},
      {"sphere with poles of degree 2", sphere(4, 2)},
      {"sphere with poles of degree 300", sphere(3, 300)},
      {"open fan", fan(50, false)},
      {"closed fan", fan(50, true)},
      {"book", book(7)},
      {"thick book", book(200)},
      {"Moebius strip", moebiusStrip(30)},
      {"components", repeated(tetrahedron(), 40)},
      {"loose triangles", repeated(triangle(), 100)},
      {"torus with holes", perforated(torus(30, 20), 0.2, 1)},
      {"torus in shreds", perforated(torus(30, 20), 0.6, 2)},
      {"irregular torus", shuffledDegrees(torus(30, 20), 1500, 3)},
      {"irregular two-sided grid", twoSided(perforated(shuffledDegrees(grid(20, 20), 600, 4), 0.05, 5))},
  };
  Triangles mixed = soup(12, 60, 6);
  mixed.indices.insert(mixed.indices.end(), {0, 0, 1, 2, 2, 2});
  mixed.indices.insert(mixed.indices.end(), mixed.indices.begin(), mixed.indices.begin() + 30);
  all.emplace_back("soup with degenerate and duplicate faces", mixed);
  return all;
}

}  // namespace tsc::meshes
