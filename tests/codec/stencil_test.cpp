#include "stencil.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "meshes.h"
#include "surface_builders.h"

namespace tsc {
namespace {

/// What a position should find, by looking at every corner there is.
struct Found {
  std::vector<std::uint32_t> corners;  ///< as in Stencils
  std::uint32_t last_gate = kNone;     ///< the last with a known gate
  std::int32_t valence = 0;
};

Found searched(const Surface& surface, const std::vector<std::uint32_t>& time, std::uint32_t own) {
  Found found;
  for (std::uint32_t c = 0; c < time.size(); ++c) {
    if (time[c] != own) continue;
    ++found.valence;
    if (time[nextCorner(c)] >= own || time[previousCorner(c)] >= own) continue;
    const std::uint32_t corner = (c / 3) << 2 | c % 3;
    found.last_gate = corner;
    if (time[surface.opposite[c]] < own) found.corners.push_back(corner);
  }
  return found;
}

void expectAsSearched(const Surface& surface, const std::vector<std::uint32_t>& time, std::uint32_t count) {
  std::vector<VertexState> states(count);
  collectStencils(surface, time, states);
  for (std::uint32_t t = 0; t < count; ++t) {
    const Stencils s = stencilsOf(states[t]);
    const Found found = searched(surface, time, t);
    ASSERT_EQ(s.valence, found.valence) << t;
    ASSERT_EQ(s.count, std::min<int>(static_cast<int>(found.corners.size()), kMaxStencils)) << t;
    for (int j = 0; j < s.count; ++j) {
      const std::uint32_t corner = s.corner[static_cast<std::size_t>(j)];
      ASSERT_EQ(corner, found.corners[static_cast<std::size_t>(j)]) << t;
      const Parallelogram p = parallelogramAt(surface, time, corner);
      const std::uint32_t c = 3 * (corner >> 2) + (corner & 3);
      ASSERT_EQ(p.left, time[nextCorner(c)]);
      ASSERT_EQ(p.right, time[previousCorner(c)]);
      ASSERT_EQ(p.base, time[surface.opposite[c]]);
    }
    for (int j = s.count; s.count > 0 && j < kMaxStencils; ++j) {
      ASSERT_EQ(s.corner[static_cast<std::size_t>(j)], s.corner[0]) << "beyond, the first again";
    }
    if (s.count == 0) {
      ASSERT_EQ(s.corner[0], found.last_gate) << t;
    }
  }
}

/// Times of corners where vertices have these, dummies none.
std::vector<std::uint32_t> cornerTimes(const Surface& surface, const std::vector<std::uint32_t>& vertex_time) {
  std::vector<std::uint32_t> time;
  for (const std::uint32_t v : surface.corner_vertex) time.push_back(surface.isDummy(v) ? kNone : vertex_time[v]);
  return time;
}

TEST(Stencil, AsALookAtAllCornersTellsInAnyOrder) {
  std::mt19937 random(1);
  std::vector<Surface> surfaces = {test::tetrahedron(), test::sheet(), test::cube(), test::torus(6, 5),
                                   test::grid(6, 7)};
  for (const auto& [name, mesh] : meshes::samples()) {
    Surface surface = cutToManifold(mesh.positions, mesh.indices).surface;
    if (surface.vertexCount() < 400) surfaces.push_back(std::move(surface));
  }
  for (const Surface& surface : surfaces) {
    std::vector<std::uint32_t> vertex_time(surface.vertexCount());
    for (int run = 0; run < 4; ++run) {
      std::iota(vertex_time.begin(), vertex_time.end(), 0);
      if (run > 0) std::shuffle(vertex_time.begin(), vertex_time.end(), random);
      std::uint32_t count = surface.vertexCount();
      // Equal positions, even of vertices in one face, as a hostile stream may have them.
      if (run == 3) {
        count = count / 3 + 1;
        for (std::uint32_t& time : vertex_time) time %= count;
      }
      expectAsSearched(surface, cornerTimes(surface, vertex_time), count);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

// The grid's vertices are y * 4 + x; quads are split along (x, y) - (x + 1, y + 1).
TEST(Stencil, OnAGrid) {
  const Surface surface = test::grid(4, 4);
  std::vector<std::uint32_t> vertex_time(surface.vertexCount());
  std::iota(vertex_time.begin(), vertex_time.end(), 0);
  const std::vector<std::uint32_t> time = cornerTimes(surface, vertex_time);
  std::vector<VertexState> states(16);
  collectStencils(surface, time, states);
  // In reading order vertex 5 has the gates 0-1 and 4-0; beyond both lies the border.
  const Stencils five = stencilsOf(states[5]);
  EXPECT_EQ(five.count, 0);
  EXPECT_NE(five.corner[0], kNone) << "a gate without a base vertex";
  EXPECT_EQ(five.valence, 6);
  // Vertex 10 = (2, 2): gates 5-6 with base 1, and 9-5 with base 4.
  const Stencils ten = stencilsOf(states[10]);
  ASSERT_EQ(ten.count, 2);
  const Parallelogram p = parallelogramAt(surface, time, ten.corner[0]);
  EXPECT_EQ((std::array{p.left, p.right, p.base}), (std::array{5u, 6u, 1u}));
  const Stencils first = stencilsOf(states[0]);
  EXPECT_EQ(first.count, 0);
  EXPECT_EQ(first.corner[0], kNone);
}

TEST(Stencil, KeepsTheFirst) {
  // Vertex 0 in the middle of a ring of 9, closed by a second ring and a dummy.
  std::vector<std::uint32_t> corners;
  constexpr std::uint32_t kRing = 9;
  const auto inner = [](std::uint32_t i) { return 1 + i % kRing; };
  const auto outer = [](std::uint32_t i) { return 1 + kRing + i % kRing; };
  const std::uint32_t dummy = 1 + 2 * kRing;
  for (std::uint32_t i = 0; i < kRing; ++i) {
    corners.insert(corners.end(), {0, inner(i), inner(i + 1)});
    corners.insert(corners.end(), {inner(i), outer(i), inner(i + 1)});
    corners.insert(corners.end(), {outer(i), outer(i + 1), inner(i + 1)});
    corners.insert(corners.end(), {outer(i + 1), outer(i), dummy});
  }
  const Surface surface = test::closedSurface(dummy + 1, 1, corners);
  std::vector<std::uint32_t> vertex_time(surface.vertexCount());
  std::iota(vertex_time.begin(), vertex_time.end(), 0);
  vertex_time[0] = dummy;
  for (std::uint32_t v = 1; v < dummy; ++v) vertex_time[v] = v - 1;
  std::vector<VertexState> states(dummy + 1);
  collectStencils(surface, cornerTimes(surface, vertex_time), states);
  const Stencils stencils = stencilsOf(states[dummy]);
  EXPECT_EQ(stencils.count, kMaxStencils);
  EXPECT_EQ(stencils.valence, static_cast<std::int32_t>(kRing));
  for (std::uint32_t j = 0; j < kMaxStencils; ++j) EXPECT_EQ(stencils.corner[j] >> 2, 4 * j) << "faces in their order";
}

TEST(Stencil, StatesSaturate) {
  VertexState state;
  storeLanes(state.memory.data(), packed(Integers{70000, -70000, 5, 0}, Integers{8191, 3, 0, 7}));
  EXPECT_EQ(state.surprise()[0], 32767);
  EXPECT_EQ(state.surprise()[1], -32768);
  EXPECT_EQ(state.magnitude()[0], 8191);
  EXPECT_EQ(state.hits(), 7);
  EXPECT_EQ(sizeof(VertexState), 32u);
}

}  // namespace
}  // namespace tsc
