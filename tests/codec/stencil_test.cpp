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
  std::vector<std::uint32_t> corners;  ///< of stencils
  std::uint32_t last_gate = kNone;     ///< the last with a known gate, while there is no stencil
  std::int32_t valence = 0;
};

Found searched(const CodingOrder& order, std::uint32_t own) {
  Found found;
  const Surface& surface = *order.surface;
  for (std::uint32_t c = 0; c < surface.corner_vertex.size(); ++c) {
    if (order.timeAt(c) != own) continue;
    ++found.valence;
    if (order.timeAt(nextCorner(c)) >= own || order.timeAt(previousCorner(c)) >= own) continue;
    if (order.vertex_time.empty() && c % 3 != 0) continue;
    if (found.corners.empty()) found.last_gate = c;
    if (order.timeAt(surface.opposite[c]) < own) found.corners.push_back(c);
  }
  return found;
}

void expectAsSearched(const CodingOrder& order, std::uint32_t count) {
  const Surface& surface = *order.surface;
  Buffer<VertexState> states(count);
  collectStencils(order, states);
  for (std::uint32_t t = 0; t < count; ++t) {
    const Stencils s(states[t], order.corner_time);
    const Found found = searched(order, t);
    ASSERT_EQ(s.valence, found.valence) << t;
    ASSERT_EQ(s.count, std::min<int>(static_cast<int>(found.corners.size()), kMaxStencils)) << t;
    for (std::size_t j = 0; j < kMaxStencils && s.count > 0; ++j) {
      const std::uint32_t c = found.corners[static_cast<int>(j) < s.count ? j : 0];
      ASSERT_EQ(s[j].left, order.timeAt(nextCorner(c)));
      ASSERT_EQ(s[j].right, order.timeAt(previousCorner(c)));
      ASSERT_EQ(s[j].base, order.timeAt(surface.opposite[c]));
      if (static_cast<int>(j) < s.count) {
        ASSERT_EQ(order.firstCorner(s.face(j)), c) << t;
      }
    }
    if (s.count == 0) {
      ASSERT_EQ(s.hasGate(), found.last_gate != kNone) << t;
      if (s.hasGate()) {
        ASSERT_EQ(order.firstCorner(s.face(0)), found.last_gate) << t;
      }
    }
  }
}

/// The map that gives vertices these times in traversal order.
PositionMap mapOf(const Surface& surface, std::vector<std::uint32_t> vertex_time, std::uint32_t count) {
  for (std::uint32_t v = surface.real_count; v < vertex_time.size(); ++v) vertex_time[v] = kNone;
  return {std::move(vertex_time), count};
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
    expectAsSearched(codingOrder(surface, {{}, surface.real_count}, Order::kTraversal), surface.real_count);
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
      const PositionMap map = mapOf(surface, vertex_time, count);
      expectAsSearched(codingOrder(surface, map, Order::kTraversal), count);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

// The grid's vertices are y * 4 + x; quads are split along (x, y) - (x + 1, y + 1).
TEST(Stencil, OnAGrid) {
  const Surface surface = test::grid(4, 4);
  std::vector<std::uint32_t> vertex_time(surface.vertexCount());
  std::iota(vertex_time.begin(), vertex_time.end(), 0);
  const PositionMap map = mapOf(surface, vertex_time, 16);
  const CodingOrder order = codingOrder(surface, map, Order::kTraversal);
  Buffer<VertexState> states(16);
  collectStencils(order, states);
  // In reading order vertex 5 has the gates 0-1 and 4-0; beyond both lies the border.
  const Stencils five(states[5], order.corner_time);
  EXPECT_EQ(five.count, 0);
  EXPECT_TRUE(five.hasGate()) << "a gate without a base vertex";
  EXPECT_EQ(five.valence, 6);
  // Vertex 10 = (2, 2): gates 5-6 with base 1, and 9-5 with base 4.
  const Stencils ten(states[10], order.corner_time);
  ASSERT_EQ(ten.count, 2);
  const Parallelogram p = ten[0];
  EXPECT_EQ((std::array{p.left, p.right, p.base}), (std::array{5u, 6u, 1u}));
  const Stencils first(states[0], order.corner_time);
  EXPECT_EQ(first.count, 0);
  EXPECT_FALSE(first.hasGate());
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
  vertex_time[0] = dummy - 1;
  for (std::uint32_t v = 1; v < dummy; ++v) vertex_time[v] = v - 1;
  Buffer<VertexState> states(dummy);
  const PositionMap map = mapOf(surface, vertex_time, dummy);
  const CodingOrder order = codingOrder(surface, map, Order::kTraversal);
  collectStencils(order, states);
  const Stencils stencils(states[dummy - 1], order.corner_time);
  EXPECT_EQ(stencils.count, kMaxStencils);
  EXPECT_EQ(stencils.valence, static_cast<std::int32_t>(kRing));
  for (std::uint32_t j = 0; j < kMaxStencils; ++j) EXPECT_EQ(stencils.face(j), 3 * 4 * j) << "faces in their order";
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
