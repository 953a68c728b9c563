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

/// Vectors of all sizes that positions, candidates and surprises can have.
Surrounding randomSurrounding(std::mt19937& random) {
  Surrounding s;
  const auto vector = [&](int bits) {
    Integers v{};
    for (int i = 0; i < 4; ++i) v[i] = static_cast<int>(random() % (2u << bits)) - (1 << bits);
    return v;
  };
  const int bits = static_cast<int>(random() % 30);
  s.left_surprise = vector(std::min(bits, 15));
  s.right_surprise = vector(std::min(bits, 15));
  s.base_surprise = vector(std::min(bits, 15));
  s.first = vector(std::min(bits, 28));
  s.second = vector(std::min(bits, 28));
  s.height = vector(std::min(bits, 27));
  s.gate = vector(std::min(bits, 27));
  return s;
}

int widthOf(Integers v) {
  int width = 0;
  for (int i = 0; i < 3; ++i) width = std::max(width, static_cast<int>(std::bit_width(static_cast<unsigned>(v[i] < 0 ? ~v[i] : v[i]))));
  return width;
}
std::int32_t shiftedBy(std::int32_t x, int n) { return n >= 0 ? x * (1 << n) : x >> -n; }

TEST(LocalSurrounding, IsEachVectorScaledAndProjected) {
  std::mt19937 random(2);
  for (int run = 0; run < 50000; ++run) {
    const Surrounding s = randomSurrounding(random);
    const Integers vectors[8] = {s.left_surprise, s.right_surprise, s.base_surprise, s.first,
                                 s.height, s.gate, Integers{}, s.second};
    int width = 0;
    for (const Integers v : vectors) width = std::max(width, widthOf(v));
    const Frame frame = frameAt(Basis::kGate, s.gate, Integers{}, s.height, Integers{});
    const Integers axes[3] = {frame.normal, frame.first, frame.second};
    for (const bool local : {false, true}) {
      const LocalSurrounding found = toLocal(frame, local, s);
      ASSERT_EQ(found.scale, kFeatureBits - width);
      const auto candidates = found.candidates();
      for (int a = 0; a < 3; ++a) {
        for (int i = 0; i < 8; ++i) {
          std::int32_t expected = shiftedBy(vectors[i][a], found.scale) >> 3;
          if (local) {
            expected = 0;
            for (int k = 0; k < 3; ++k) expected += (shiftedBy(vectors[i][k], found.scale) * axes[a][k]) >> 16;
          }
          ASSERT_EQ(found.component[a][i], expected) << i;
        }
        ASSERT_EQ(candidates[0][a], shiftedBy(found.component[a][3], 3 - found.scale));
        ASSERT_EQ(candidates[1][a], shiftedBy(found.component[a][7], 3 - found.scale));
      }
    }
  }
}

/// BITSTREAM.md, section 6.5, one weight at a time.
TEST(AdaptiveOffset, IsTheWeightedSumOfFeatures) {
  std::mt19937 random(3);
  AdaptiveOffset adaptive;
  std::int64_t weights[3][8] = {};
  for (int run = 0; run < 20000; ++run) {
    const Surrounding s = randomSurrounding(random);
    const Frame frame = frameAt(Basis::kGate, s.gate, Integers{}, s.height, Integers{});
    const LocalSurrounding local = toLocal(frame, true, s);
    int factors[3];
    for (int& factor : factors) factor = static_cast<int>(random() % 41) - 20;
    if (run % 100 == 0) factors[run % 3] = 1 << 28;
    const Features features(local, factors[0], factors[1], factors[2]);
    const int sources[8] = {0, 1, 2, 3, 4, 4, 5, 4};
    const Integers found = adaptive.offset(features);
    Integers residual{};
    // Long runs of one sign drive weights to their ends.
    for (int a = 0; a < 3; ++a) residual[a] = run % 8000 < 4000 ? 5 - 5 * static_cast<int>(random() % 3) : 1 - run % 3;
    for (int a = 0; a < 3; ++a) {
      std::int64_t sum = 0;
      for (int i = 0; i < 8; ++i) {
        const int factor = i < 5 ? 4 : std::clamp(factors[i - 5], -12, 12);
        const std::int64_t feature = std::int64_t{local.component[a][sources[i]]} * factor;
        ASSERT_EQ(features.component[a][i], feature);
        sum += weights[a][i] * feature;
        const auto sign = [](std::int64_t x) { return (x > 0) - (x < 0); };
        weights[a][i] = std::clamp<std::int64_t>(weights[a][i] + 64 * sign(residual[a]) * sign(feature), -32768, 32767);
      }
      ASSERT_LT(std::abs(sum), std::int64_t{1} << 31);
      const int shift = std::max(14 + local.scale, 0);
      const std::int64_t value = shift > 0 ? (sum + (std::int64_t{1} << (shift - 1))) >> shift : sum;
      ASSERT_EQ(found[a], std::clamp<std::int64_t>(value, -(1 << 26), 1 << 26));
    }
    adaptive.learn(features, residual);
  }
}

}  // namespace
}  // namespace tsc::test
