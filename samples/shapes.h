// The shapes of the sample assets. No function of libm but the exactly rounded square root is used, so that every
// machine makes the same bytes.
#pragma once

#include <array>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tsc::samples {

inline constexpr double kPi = 3.14159265358979323846;

double sine(double radians);
inline double cosine(double radians) { return sine(radians + kPi / 2); }

/// A triangle mesh with one normal a vertex.
struct Surface {
  std::vector<glm::dvec3> positions;
  std::vector<glm::dvec3> normals;
  std::vector<glm::dvec2> uvs;  ///< empty, or one a vertex
  std::vector<std::uint32_t> indices;

  std::vector<float> positionFloats() const;
  std::vector<float> normalFloats() const;
  std::vector<float> uvFloats() const;
};

/// Area-weighted vertex normals.
void computeNormals(Surface& surface);

/// The unit sphere: an icosahedron with each triangle split into four, `levels` times.
Surface icosphere(int levels);

/// Small random numbers in [0, 1), the same everywhere (SplitMix64).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double next();

 private:
  std::uint64_t state_;
};

/// A sea slug: lobes, two horns and fine folds.
Surface slug();

/// A flange with a boss, five bores and a slot. Faces meet at hard edges; planar faces are triangulated into slivers.
Surface flange();

/// One profile turned about the y axis, a seam at angle 0. Profile points that stand twice make a hard edge.
Surface turned(const std::vector<glm::dvec2>& profile, int segments);

/// A square of side 2 about the origin, irregular triangles, rotated about the x axis.
Surface rotatedPlane(double degrees);

}  // namespace tsc::samples
