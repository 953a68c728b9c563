// The position stage alone: what is coded is what is decoded, near its target, whatever the parameters.
#include "positions.h"

#include <gtest/gtest.h>

#include <random>

#include "extra_positions.h"
#include "format.h"
#include "meshes.h"
#include "surface_builders.h"

namespace tsc {
namespace {

constexpr std::uint32_t kChecksum = 0x600df00d;

std::vector<PositionParameters> allParameters() {
  std::vector<PositionParameters> all;
  for (const Mode mode : {Mode::kLattice, Mode::kTangent}) {
    for (const Basis basis : {Basis::kGate, Basis::kTip}) {
      for (int predictor = 1; predictor <= 5; ++predictor) {
        for (const Order order : {Order::kTraversal, Order::kDegree}) {
          if (mode == Mode::kLattice && basis == Basis::kTip) continue;
          PositionParameters p;
          p.mode = mode;
          p.basis = basis;
          p.predictor = static_cast<Predictor>(predictor);
          p.order = order;
          p.fine_bits = mode == Mode::kTangent ? kFineBits : 0;
          p.normal_scale = mode == Mode::kTangent ? static_cast<std::uint32_t>(predictor * 3) : 1;
          all.push_back(p);
          p.effort = Effort::kMax;
          all.push_back(p);
          p.effort = Effort::kDefault;
          p.candidates = true;
          all.push_back(p);
          p.exact_hits = true;
          all.push_back(p);
        }
      }
    }
  }
  return all;
}

PositionMap identityMap(const Surface& surface) { return {{}, surface.real_count}; }

std::vector<glm::dvec3> inSteps(std::vector<glm::dvec3> target, const PositionParameters& parameters) {
  for (glm::dvec3& t : target) t /= 1 << parameters.fine_bits;
  return target;
}

/// Codes, decodes and returns what was decoded; `target` is on the fine lattice.
std::vector<Vec3> codedPositions(const Surface& surface, const PositionMap& map, const PositionParameters& parameters,
                                 const std::vector<glm::dvec3>& target) {
  EntropyWriter writer;
  std::vector<Vec3> expected, decoded;
  encodePositions(codingStart(surface, map, parameters.order), parameters, inSteps(target, parameters), writer,
                  &expected);
  std::vector<std::byte> bytes;
  writer.finish(kChecksum, bytes);
  EntropyReader reader(bytes);
  CodingStart start = codingStart(surface, map, parameters.order);
  EXPECT_FALSE(decodePositions(start.order, parameters, reader, start.states));
  decoded = pointsOf(start.order, start.states);
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.state(), finalState(kChecksum));
  EXPECT_EQ(decoded, expected);
  return decoded;
}

void expectNear(const PositionParameters& parameters, const std::vector<Vec3>& decoded,
                const std::vector<glm::dvec3>& target) {
  const double step = std::ldexp(1.0, parameters.fine_bits);
  // Half the diagonal of a cell; in tangent mode the fine lattice adds its own.
  const double bound = step * std::sqrt(0.75) * (1 + 1e-9) + (parameters.fine_bits > 0 ? 2 : 0);
  for (std::size_t i = 0; i < target.size(); ++i) {
    const glm::dvec3 error = glm::dvec3(decoded[i]) - target[i];
    ASSERT_LE(std::sqrt(glm::dot(error, error)), bound) << i;
  }
}

TEST(Positions, ComeBackWithinHalfACell) {
  std::mt19937 random(1);
  const Surface surfaces[] = {test::tetrahedron(), test::sheet(), test::cube(), test::torus(9, 8), test::grid(9, 7)};
  for (const PositionParameters& parameters : allParameters()) {
    for (const Surface& surface : surfaces) {
      for (const double size : {3.0, 1000.0, 3e7}) {
        const PositionMap map = identityMap(surface);
        std::vector<glm::dvec3> target(map.position_count);
        for (glm::dvec3& t : target) {
          for (int a = 0; a < 3; ++a) t[a] = size * (random() / 4294967296.0);
        }
        expectNear(parameters, codedPositions(surface, map, parameters, target), target);
        if (testing::Test::HasFailure()) return;
      }
    }
  }
}

TEST(Positions, RepeatedPositionsAreCodedOnce) {
  const Surface surface = test::grid(5, 5);
  // The last row repeats the first.
  PositionMap map{std::vector<std::uint32_t>(surface.vertexCount(), kNone), 20};
  for (std::uint32_t v = 0; v < surface.real_count; ++v) map.vertex_position[v] = v % 20;
  std::vector<glm::dvec3> target;
  for (int i = 0; i < 20; ++i) target.emplace_back(100.3 * (i % 5), 77.7 * (i / 5), (i * i) % 13);
  for (const PositionParameters& parameters : allParameters()) {
    expectNear(parameters, codedPositions(surface, map, parameters, target), target);
  }
}

TEST(Positions, APlaneThatMeetsItsLatticeIsNearlyFree) {
  const Surface surface = test::grid(40, 40);
  // Written out, since these faces do not have their last vertices first, as they would if they were decoded.
  PositionMap map{std::vector<std::uint32_t>(surface.vertexCount(), kNone), surface.real_count};
  for (std::uint32_t v = 0; v < surface.real_count; ++v) map.vertex_position[v] = v;
  std::vector<glm::dvec3> target;
  for (int i = 0; i < 1600; ++i) target.emplace_back(64 * (i % 40), 64 * (i / 40), 192 * (i % 40));
  for (const PositionParameters& parameters : allParameters()) {
    if (parameters.predictor == Predictor::kWeighted || parameters.predictor == Predictor::kValence) continue;
    EntropyWriter writer;
    encodePositions(codingStart(surface, map, parameters.order), parameters, inSteps(target, parameters), writer,
                    nullptr);
    // Coded row by row, each row starts with two positions that have no parallelogram.
    const double most = parameters.order == Order::kTraversal ? 2 : 1;
    EXPECT_LT(writer.bitsSince(0) / 1600, most) << static_cast<int>(parameters.predictor);
  }
}

TEST(Positions, HostileBytesEndInTime) {
  std::mt19937 random(2);
  const Surface surface = test::torus(20, 20);
  const PositionMap map = identityMap(surface);
  for (const PositionParameters& parameters : allParameters()) {
    for (int i = 0; i < 20; ++i) {
      std::vector<std::byte> bytes(random() % 3000);
      for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
      EntropyReader reader(bytes);
      CodingStart start = codingStart(surface, map, parameters.order);
      if (decodePositions(start.order, parameters, reader, start.states)) continue;
      for (const Vec3& p : pointsOf(start.order, start.states)) {
        for (int a = 0; a < 3; ++a) {
          ASSERT_GE(p[a], -(1 << (kCoordinateBits - 1)));
          ASSERT_LT(p[a], 1 << (kCoordinateBits - 1));
        }
      }
    }
  }
}

TEST(Positions, ExtraOnes) {
  std::mt19937 random(3);
  for (const int fine_bits : {0, kFineBits}) {
    const double size = 1e8 / 3;
    std::vector<glm::dvec3> target(500);
    for (glm::dvec3& t : target) {
      for (int a = 0; a < 3; ++a) t[a] = (random() / 4294967296.0 - 0.5) * size;
    }
    EntropyWriter writer;
    std::vector<Vec3> expected(target.size()), decoded(target.size());
    encodeExtraPositions(target, fine_bits, writer, expected);
    std::vector<std::byte> bytes;
    writer.finish(kChecksum, bytes);
    EntropyReader reader(bytes);
    EXPECT_FALSE(decodeExtraPositions(reader, fine_bits, decoded));
    EXPECT_EQ(decoded, expected);
    EXPECT_TRUE(reader.atEnd());
    const int step = 1 << fine_bits;
    for (std::size_t i = 0; i < target.size(); ++i) {
      for (int a = 0; a < 3; ++a) {
        ASSERT_LE(std::abs(decoded[i][a] - target[i][a]), 0.5 * step);
        ASSERT_EQ(decoded[i][a] % step, 0) << "whole steps";
      }
    }
  }
}

}  // namespace
}  // namespace tsc
