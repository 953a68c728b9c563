#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>

#include "meshes.h"

namespace tsc {
namespace {

using namespace test;

TEST(Metro, OfATranslatedCube) {
  // By hand, for a shift by s = 1/4 along x: the face left behind is s away; of the face now inside, each point is
  // min(s, distance to its square's border) away; on the four sides a strip of width s is up to s away.
  const double s = 0.25;
  const double inside = s * s - 8.0 / 3 * s * s * s + 2 * s * s * s * s;
  const double rms = std::sqrt((s * s + inside + 4 * s * s * s / 3) / 6);
  const MeshArrays cube = unitCube();
  const auto errors = metro(cube.view(), translated(cube, s, 0, 0).view());
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->rms_a_to_b, rms, 0.002 * rms);
  EXPECT_NEAR(errors->rms_b_to_a, rms, 0.002 * rms);
  EXPECT_NEAR(errors->hausdorff(), s, 1e-12);
  EXPECT_NEAR(errors->area_a, 6, 1e-12);
  EXPECT_EQ(errors->samples, 50'000u);
}

TEST(Metro, OfOneMovedVertex) {
  const MeshArrays cube = unitCube();
  MeshArrays moved = cube;
  moved.positions[3 * 7 + 0] += 0.5;  // straight out of the face x = 1
  const auto errors = metro(cube.view(), moved.view());
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->max_b_to_a, 0.5, 1e-12);
  EXPECT_LT(errors->max_a_to_b, 0.5);
}

TEST(Metro, IsSymmetricAndRepeatable) {
  const MeshArrays torus = bumpyTorus(24, 12), other = jittered(torus, 0.01);
  const auto ab = metro(torus.view(), other.view()), again = metro(torus.view(), other.view());
  const auto ba = metro(other.view(), torus.view());
  ASSERT_TRUE(ab && again && ba);
  EXPECT_EQ(ab->rms(), ba->rms());
  EXPECT_EQ(ab->hausdorff(), ba->hausdorff());
  EXPECT_EQ(ab->rms_a_to_b, ba->rms_b_to_a);
  EXPECT_EQ(ab->rms_a_to_b, again->rms_a_to_b);
}

TEST(Metro, OfASurfaceWithItselfInOtherTriangles) {
  MeshArrays other = unitCube();
  other.indices = {0, 3, 1, 0, 2, 3, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                   2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  const auto errors = metro(unitCube().view(), other.view());
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->hausdorff(), 0, 1e-12);
}

TEST(Metro, HoldsFarFromTheOriginAndAtAnyScale) {
  const MeshArrays torus = bumpyTorus(16, 8), other = jittered(torus, 1e-7);
  const auto near = metro(torus.view(), other.view());
  MeshArrays large = torus, large_other = other;
  for (double& x : large.positions) x = x * 1e30;
  for (double& x : large_other.positions) x = x * 1e30;
  const auto scaled = metro(large.view(), large_other.view());
  ASSERT_TRUE(near && scaled);
  EXPECT_GT(near->rms(), 1e-9);  // finer than float could tell
  EXPECT_LT(near->hausdorff(), 2e-7);
  EXPECT_NEAR(scaled->rms() / 1e30, near->rms(), 1e-6 * near->rms());
}

double bruteForceDistance(const glm::dvec3& p, const MeshArrays& mesh) {
  // Independent of the library: minimizes over a fine barycentric grid, then refines around the best.
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
    glm::dvec3 c[3];
    for (int k = 0; k < 3; ++k) {
      const double* x = &mesh.positions[3 * mesh.indices[t + k]];
      c[k] = {x[0], x[1], x[2]};
    }
    double u = 1.0 / 3, v = 1.0 / 3;
    for (double step = 0.5; step > 1e-9; step *= 0.6) {
      double local = std::numeric_limits<double>::infinity(), best_u = u, best_v = v;
      for (int i = -4; i <= 4; ++i) {
        for (int j = -4; j <= 4; ++j) {
          const double x = std::clamp(u + i * step / 3, 0.0, 1.0), y = std::clamp(v + j * step / 3, 0.0, 1.0 - x);
          const double d = glm::distance(p, (1 - x - y) * c[0] + x * c[1] + y * c[2]);
          if (d < local) local = d, best_u = x, best_v = y;
        }
      }
      u = best_u, v = best_v;
      best = std::min(best, local);
    }
  }
  return best;
}

TEST(DistancesToSurface, AgreeWithBruteForce) {
  const MeshArrays torus = bumpyTorus(8, 6);
  std::vector<double> points;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  for (int i = 0; i < 3 * 60; ++i) points.push_back(coordinate(random));
  const auto distances = distancesToSurface(points, torus.view());
  ASSERT_TRUE(distances);
  for (std::size_t i = 0; i < distances->size(); ++i) {
    const glm::dvec3 p(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    EXPECT_NEAR((*distances)[i], bruteForceDistance(p, torus), 1e-6) << i;
  }
}

TEST(Metro, RefusesWhatCannotBeMeasured) {
  const MeshArrays cube = unitCube();
  MeshArrays nan = cube, past = cube, flat = cube;
  nan.positions[4] = std::numeric_limits<double>::quiet_NaN();
  past.indices[3] = 8;
  std::fill(flat.positions.begin(), flat.positions.end(), 1.0);
  const SurfaceView none{cube.positions, {}};
  EXPECT_EQ(metro(cube.view(), none).error().code, QualityErrorCode::kNoFaces);
  EXPECT_EQ(metro(nan.view(), cube.view()).error().code, QualityErrorCode::kNonFinitePosition);
  EXPECT_EQ(metro(cube.view(), past.view()).error().code, QualityErrorCode::kInvalidIndex);
  EXPECT_EQ(metro(flat.view(), cube.view()).error().code, QualityErrorCode::kNoFaces);
  const SurfaceView broken{cube.positions, std::span(cube.indices).first(4)};
  EXPECT_EQ(metro(broken, cube.view()).error().code, QualityErrorCode::kInvalidIndex);
}

}  // namespace
}  // namespace tsc
