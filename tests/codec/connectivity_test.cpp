#include "connectivity.h"

#include <gtest/gtest.h>

#include <random>

#include "meshes.h"
#include "surface_checks.h"

namespace tsc {
namespace {

constexpr std::uint32_t kChecksum = 0x12345678;

bool equal(const Surface& a, const Surface& b) {
  return a.corner_vertex == b.corner_vertex && a.opposite == b.opposite && a.vertex_corner == b.vertex_corner &&
         a.counts() == b.counts();
}

/// Compares the stencils that decoding collects with those that the surface has.
void expectStencilsOf(const Surface& surface, std::span<const std::byte> bytes) {
  Surface without_edges;
  Buffer<VertexState> states, expected(surface.real_count);
  EntropyReader reader(bytes);
  ASSERT_FALSE(decodeConnectivity(reader, surface.counts(), without_edges, states));
  ASSERT_EQ(without_edges.corner_vertex, surface.corner_vertex);
  ASSERT_EQ(without_edges.counts(), surface.counts());
  EXPECT_TRUE(without_edges.opposite.empty() && without_edges.vertex_corner.empty());
  const PositionMap map{{}, surface.real_count};
  const CodingOrder order = codingOrder(surface, map, Order::kTraversal);
  collectStencils(order, expected);
  ASSERT_EQ(states.size(), expected.size());
  for (std::uint32_t v = 0; v < states.size(); ++v) {
    const UncodedState &found = states[v].uncoded, &wanted = expected[v].uncoded;
    ASSERT_EQ(found.valence(), wanted.valence()) << v;
    ASSERT_EQ(found.count(), wanted.count()) << v;
    // Without a stencil there may be a gate, whose base nothing looks at.
    if (wanted.count() == 0) {
      ASSERT_EQ(found[0].face, wanted[0].face) << v;
    }
    for (std::size_t j = 0; static_cast<int>(j) < wanted.count(); ++j) {
      ASSERT_EQ(found[j].face, wanted[j].face) << v;
      ASSERT_EQ(found[j].base, wanted[j].base) << v;
    }
  }
}

struct Coded {
  std::vector<std::byte> bytes;
  double bits = 0;
  Surface surface;
};

/// Encodes, decodes and compares.
Coded roundTrip(const Surface& input, Effort effort) {
  Coded coded;
  EntropyWriter writer;
  const ConnectivityOrder order = encodeConnectivity(input, effort, writer, coded.surface);
  coded.bits = writer.bitsSince(0);
  writer.finish(kChecksum, coded.bytes);

  Surface decoded;
  EntropyReader reader(coded.bytes);
  const Status status = decodeConnectivity(reader, effort, input.counts(), decoded);
  EXPECT_FALSE(status);
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.state(), finalState(kChecksum));
  EXPECT_TRUE(equal(decoded, coded.surface));
  expectClosedManifold(decoded);
  if (effort == Effort::kDefault) expectStencilsOf(decoded, coded.bytes);

  // The order is a bijection that carries the decoded surface onto the input.
  EXPECT_EQ(order.vertex.size(), input.vertexCount());
  EXPECT_EQ(order.corner.size(), input.faceCount());
  if (order.vertex.size() != input.vertexCount() || order.corner.size() != input.faceCount()) return coded;
  std::vector<std::uint8_t> is_met(input.vertexCount(), 0);
  for (std::uint32_t v = 0; v < input.vertexCount(); ++v) {
    EXPECT_EQ(is_met[order.vertex[v]]++, 0);
    EXPECT_EQ(decoded.isDummy(v), input.isDummy(order.vertex[v]));
  }
  std::vector<std::uint32_t> input_corner;
  for (const std::uint32_t first : order.corner) {
    input_corner.insert(input_corner.end(), {first, nextCorner(first), previousCorner(first)});
  }
  for (std::uint32_t c = 0; c < input_corner.size(); ++c) {
    EXPECT_EQ(order.vertex[decoded.corner_vertex[c]], input.corner_vertex[input_corner[c]]);
    EXPECT_EQ(input_corner[decoded.opposite[c]], input.opposite[input_corner[c]]);
  }
  return coded;
}

Coded roundTrip(const meshes::Triangles& mesh, Effort effort) {
  return roundTrip(cutToManifold(mesh.positions, mesh.indices).surface, effort);
}

class Connectivity : public testing::TestWithParam<Effort> {};
INSTANTIATE_TEST_SUITE_P(Efforts, Connectivity, testing::Values(Effort::kDefault, Effort::kMax),
                         [](const auto& info) { return info.param == Effort::kMax ? "Max" : "Default"; });

TEST_P(Connectivity, Samples) {
  for (const auto& [name, mesh] : meshes::samples()) {
    SCOPED_TRACE(name);
    roundTrip(mesh, GetParam());
  }
}

TEST_P(Connectivity, RandomSoups) {
  for (std::uint32_t seed = 0; seed < 3000 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    roundTrip(meshes::soup(3 + seed % 50, 1 + seed * 11 % 300, seed), GetParam());
  }
}

TEST_P(Connectivity, RandomSurfaces) {
  for (std::uint32_t seed = 0; seed < 300 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const meshes::Triangles torus = meshes::torus(3 + seed % 20, 3 + seed * 5 % 17);
    roundTrip(meshes::perforated(meshes::shuffledDegrees(torus, seed * 10, seed), 0.001 * seed, seed), GetParam());
  }
}

TEST_P(Connectivity, RegularTorusIsNearlyFree) {
  const meshes::Triangles mesh = meshes::torus(100, 100);
  EXPECT_LT(roundTrip(mesh, GetParam()).bits, 0.05 * mesh.vertexCount());
}

TEST_P(Connectivity, LooseTrianglesCostFewBits) {
  EXPECT_LT(roundTrip(meshes::repeated(meshes::triangle(), 5000), GetParam()).bits, 0.5 * 5000);
}

TEST_P(Connectivity, NewVerticesHaveTheirGateAtCornerZero) {
  const Surface surface = roundTrip(meshes::perforated(meshes::torus(20, 20), 0.1, 1), GetParam()).surface;
  std::uint32_t starts = 0;
  for (std::uint32_t v = 0; v < surface.real_count; ++v) {
    const std::uint32_t corner = surface.vertex_corner[v];
    if (corner % 3 != 0) {
      ++starts;
      continue;
    }
    for (const std::uint32_t other : {nextCorner(corner), previousCorner(corner)}) {
      const std::uint32_t neighbour = surface.corner_vertex[other];
      // A start's first vertex has its companions after it.
      EXPECT_TRUE(neighbour < v || neighbour <= v + 2 || surface.isDummy(neighbour));
    }
  }
  EXPECT_LT(starts, 20u);
}

TEST_P(Connectivity, RefusesOtherCounts) {
  const Coded coded = roundTrip(meshes::perforated(meshes::sphere(9, 14), 0.1, 1), GetParam());
  const auto [faces, vertices, dummies] = coded.surface.counts();
  ASSERT_GT(dummies, 0u);
  for (const SurfaceCounts& counts : {SurfaceCounts{faces - 1, vertices, dummies},
                                      {faces + 1, vertices, dummies},
                                      {faces, vertices - 1, dummies},
                                      {faces, vertices + 1, dummies},
                                      {faces, vertices, dummies - 1},
                                      {faces, vertices, dummies + 1},
                                      {faces, vertices + 1, dummies - 1},
                                      {0u, vertices, dummies},
                                      {faces, 0u, dummies},
                                      {0xffffffffu, vertices, dummies}}) {
    Surface surface;
    EntropyReader reader(coded.bytes);
    const Status status = decodeConnectivity(reader, GetParam(), counts, surface);
    EXPECT_TRUE(status) << counts.faces << " faces, " << counts.real_vertices << " and " << counts.dummies;
  }
}

TEST_P(Connectivity, DamagedStreamsNeverCrash) {
  const Coded coded =
      roundTrip(meshes::perforated(meshes::shuffledDegrees(meshes::torus(12, 9), 200, 3), 0.2, 4), GetParam());
  for (std::size_t bit = 0; bit < 8 * coded.bytes.size(); ++bit) {
    std::vector<std::byte> damaged = coded.bytes;
    damaged[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    Surface surface;
    EntropyReader reader(damaged);
    const Status status = decodeConnectivity(reader, GetParam(), coded.surface.counts(), surface);
    if (!status) {
      EXPECT_EQ(surface.faceCount(), coded.surface.faceCount());
      if (GetParam() == Effort::kDefault) expectStencilsOf(surface, damaged);
    }
  }
  for (std::size_t length = 0; length < coded.bytes.size(); ++length) {
    Surface surface;
    EntropyReader reader(std::span(coded.bytes).first(length));
    const Status status = decodeConnectivity(reader, GetParam(), coded.surface.counts(), surface);
    EXPECT_TRUE(status || !reader.atEnd() || reader.state() != finalState(kChecksum));
  }
}

TEST_P(Connectivity, RandomBytesNeverCrash) {
  std::mt19937 random(7);
  for (int run = 0; run < 6000; ++run) {
    std::vector<std::byte> bytes(8 + random() % 200);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(run % 3 == 0 ? random() % 16 : random());
    const std::uint32_t faces = run % 16 == 0 ? random() : random() % 300;
    const std::uint32_t vertices = run % 16 == 0 ? random() : random() % 200, dummies = random() % 4;
    Surface surface;
    EntropyReader reader(bytes);
    const Status status = decodeConnectivity(reader, GetParam(), {faces, vertices, dummies}, surface);
    if (status || faces == 0) continue;
    if (GetParam() == Effort::kDefault) expectStencilsOf(surface, bytes);
    for (const std::uint32_t corner : surface.opposite) ASSERT_LT(corner, 3 * faces);
    for (const std::uint32_t vertex : surface.corner_vertex) ASSERT_LT(vertex, vertices + dummies);
  }
}

}  // namespace
}  // namespace tsc
