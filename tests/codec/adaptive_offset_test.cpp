// What the adaptive correction learns, seen through the positions that it helps to predict.
#include "adaptive_offset.h"

#include <gtest/gtest.h>

#include <random>

#include "codec_checks.h"

namespace tsc::test {
namespace {

double bitsFor(const OwnedMesh& mesh, Mode mode, Predictor predictor) {
  EncodeOptions options;
  options.step = 0.001;
  options.mode = mode;
  options.predictor = predictor;
  options.order = Order::kTraversal;
  const RoundTrip trip = roundTrip(mesh, options);
  EXPECT_EQ(trip.fault, "");
  return trip.encoded.bits.positions;
}

TEST(AdaptiveOffset, SmoothSurfacesCostLess) {
  // Curvature makes every average of parallelograms err in the same direction, which can be learned.
  const OwnedMesh mesh(meshes::torus(120, 60));
  for (const Mode mode : {Mode::kTangent, Mode::kLattice}) {
    const double average = bitsFor(mesh, mode, Predictor::kAverage);
    EXPECT_LT(bitsFor(mesh, mode, Predictor::kAdaptive), 0.95 * average);
  }
}

TEST(AdaptiveOffset, NoiseDoesNotLeadItAstray) {
  meshes::Triangles noise = meshes::grid(60, 60);
  std::mt19937 random(1);
  for (float& x : noise.positions) x += static_cast<float>(random() % 1000) / 1000;
  const OwnedMesh mesh(noise);
  const double average = bitsFor(mesh, Mode::kTangent, Predictor::kAverage);
  EXPECT_LT(bitsFor(mesh, Mode::kTangent, Predictor::kAdaptive), 1.05 * average);
}

}  // namespace
}  // namespace tsc::test
