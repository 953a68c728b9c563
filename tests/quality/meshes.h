// Small meshes made by code, for the tests of the measures.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "tsc/quality.h"

namespace tsc::test {

struct MeshArrays {
  std::vector<double> positions;
  std::vector<std::uint32_t> indices;

  [[nodiscard]] SurfaceView view() const { return {positions, indices}; }
  [[nodiscard]] NamedSurface named(const std::string& name = "mesh") const { return {name, positions, indices, {}}; }
  [[nodiscard]] std::size_t vertexCount() const { return positions.size() / 3; }
};

/// The unit cube, faces outwards.
inline MeshArrays unitCube() {
  MeshArrays cube;
  for (int v = 0; v < 8; ++v) {
    for (int axis = 0; axis < 3; ++axis) cube.positions.push_back(v >> axis & 1);
  }
  cube.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                  2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return cube;
}

inline MeshArrays translated(MeshArrays mesh, double x, double y, double z) {
  const double offset[3] = {x, y, z};
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) mesh.positions[i] += offset[i % 3];
  return mesh;
}

/// A closed torus with bumps: no two triangles alike, valence 6 everywhere.
inline MeshArrays bumpyTorus(std::uint32_t rings, std::uint32_t sides) {
  MeshArrays torus;
  for (std::uint32_t i = 0; i < rings; ++i) {
    for (std::uint32_t j = 0; j < sides; ++j) {
      const double u = 2 * std::numbers::pi * i / rings, v = 2 * std::numbers::pi * j / sides;
      const double radius = 0.3 + 0.03 * std::sin(3 * u + 2 * v) + 0.02 * std::cos(u - v);
      const double ring = 1 + radius * std::cos(v);
      torus.positions.insert(torus.positions.end(), {ring * std::cos(u), ring * std::sin(u), radius * std::sin(v)});
      const auto at = [&](std::uint32_t a, std::uint32_t b) { return a % rings * sides + b % sides; };
      torus.indices.insert(torus.indices.end(), {at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      torus.indices.insert(torus.indices.end(), {at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return torus;
}

inline MeshArrays jittered(MeshArrays mesh, double size, std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> offset(-size, size);
  for (double& coordinate : mesh.positions) coordinate += offset(random);
  return mesh;
}

inline MeshArrays quantized(MeshArrays mesh, double step) {
  for (double& coordinate : mesh.positions) coordinate = std::round(coordinate / step) * step;
  return mesh;
}

struct Shuffled {
  MeshArrays mesh;
  std::vector<std::uint32_t> new_of_old;
};

/// The same mesh with vertices, triangles and first corners in another order.
inline Shuffled shuffled(const MeshArrays& mesh, std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  Shuffled result;
  result.new_of_old.resize(mesh.vertexCount());
  std::iota(result.new_of_old.begin(), result.new_of_old.end(), 0u);
  std::shuffle(result.new_of_old.begin(), result.new_of_old.end(), random);
  result.mesh.positions.resize(mesh.positions.size());
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    std::copy_n(&mesh.positions[3 * v], 3, &result.mesh.positions[3 * result.new_of_old[v]]);
  }
  std::vector<std::uint32_t> order(mesh.indices.size() / 3);
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), random);
  for (const std::uint32_t t : order) {
    const std::uint32_t turn = random() % 3;
    for (std::uint32_t k = 0; k < 3; ++k) {
      result.mesh.indices.push_back(result.new_of_old[mesh.indices[3 * t + (k + turn) % 3]]);
    }
  }
  return result;
}

/// A vertex a corner.
inline MeshArrays soup(const MeshArrays& mesh) {
  MeshArrays result;
  for (const std::uint32_t v : mesh.indices) {
    result.indices.push_back(static_cast<std::uint32_t>(result.vertexCount()));
    result.positions.insert(result.positions.end(), &mesh.positions[3 * v], &mesh.positions[3 * v] + 3);
  }
  return result;
}

/// Two triangles on the edge from the origin to (0, 1, 0); the second is turned up by `angle` from flat.
inline MeshArrays hinge(double angle) {
  return {{0, 0, 0, 0, 1, 0, -1, 0.5, 0, std::cos(angle), 0.5, std::sin(angle)}, {0, 1, 2, 1, 0, 3}};
}

}  // namespace tsc::test
