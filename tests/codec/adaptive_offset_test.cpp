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

/// Vectors of all sizes that positions, candidates and surprises can have, in 16 bits.
Lanes randomPair(std::mt19937& random) {
  Lanes v{};
  const int bits = static_cast<int>(random() % 16);
  for (int i = 0; i < 8; ++i) {
    v[i] = static_cast<std::int16_t>(static_cast<int>(random() % (2u << bits)) - (1 << bits));
  }
  if (random() % 8 == 0) v[static_cast<int>(random() % 8)] = random() % 2 == 0 ? 32767 : -32768;
  return v;
}

Frame randomFrame(std::mt19937& random) {
  const auto point = [&] {
    Integers v{};
    for (int i = 0; i < 3; ++i) v[i] = static_cast<int>(random() % 2001) - 1000;
    return v;
  };
  const Integers left = point(), right = point(), base = point();
  return random() % 4 == 0 ? Frame{} : frameAt(Basis::kGate, left, right, base, left + right - base);
}

/// Signs of a run push weights to their ends, at which sums exceed 32 bits, and wrap.
std::int32_t wrapped(std::int64_t x) { return static_cast<std::int32_t>(static_cast<std::uint32_t>(x)); }

/// BITSTREAM.md, section 6.5, one weight at a time.
TEST(AdaptiveOffset, IsTheWeightedSumOfFeatures) {
  std::mt19937 random(3);
  AdaptiveOffset adaptive;
  std::int64_t weights[3][8] = {};
  bool has_wrapped = false;
  for (int run = 0; run < 40000; ++run) {
    Surrounding s{randomPair(random), randomPair(random), randomPair(random)};
    const Frame frame = randomFrame(random);
    const Lanes axes[3] = {frame.normal, frame.first, frame.second};
    if (run % 8000 > 4000 && run % 3 == 0) {
      for (Lanes* pair : {&s.gate_surprises, &s.base_and_first}) *pair = splat(32767);
    }
    int factors[3];
    for (int& factor : factors) factor = static_cast<int>(random() % 21) - 10;
    if (run % 100 == 0) factors[run % 3] = run % 200 == 0 ? 1 << 28 : -(1 << 28);
    const Features features(frame, s, Integers{0, factors[0], factors[1], factors[2]});
    const Integers found = adaptive.offset(features);
    // The vectors left, right, base, first, height, gate: two in each register.
    const Lanes registers[3] = {s.gate_surprises, s.base_and_first, s.shape};
    Integers residual{};
    // Long runs of one sign drive weights to their ends.
    for (int a = 0; a < 3; ++a) residual[a] = run % 8000 < 4000 ? 1 - run % 3 : 5 - 2 * static_cast<int>(random() % 3);
    for (int a = 0; a < 3; ++a) {
      std::int64_t local[6];
      for (int i = 0; i < 6; ++i) {
        std::int64_t sum = 0;
        for (int k = 0; k < 3; ++k) sum += std::int64_t{registers[i / 2][4 * (i % 2) + k]} * axes[a][k];
        local[i] = sum >> (i < 4 ? 13 : 16);
      }
      const auto bounded = [](int factor) { return std::clamp(factor, -7, 7); };
      const std::int64_t expected[8] = {local[0],
                                        local[1],
                                        local[2],
                                        local[3],
                                        local[4] * 4,
                                        local[4] * bounded(factors[0]),
                                        local[5] * bounded(factors[1]),
                                        local[4] * bounded(factors[2])};
      std::int64_t sum = 0;
      for (int i = 0; i < 8; ++i) {
        ASSERT_EQ(features.component[a][i], expected[i]) << i;
        sum += weights[a][i] * expected[i];
        const auto sign = [](std::int64_t x) { return (x > 0) - (x < 0); };
        weights[a][i] =
            std::clamp<std::int64_t>(weights[a][i] + 64 * sign(residual[a]) * sign(expected[i]), -32768, 32767);
      }
      ASSERT_EQ(found[a], wrapped(sum + (1 << 13)) >> 14);
      has_wrapped |= wrapped(sum + (1 << 13)) != sum + (1 << 13);
    }
    adaptive.learn(features, residual);
  }
  EXPECT_TRUE(has_wrapped) << "what is tested here must come up";
}

}  // namespace
}  // namespace tsc::test
