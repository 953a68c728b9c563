#include "arc.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <list>
#include <numeric>
#include <random>

#include "surface_builders.h"

namespace tsc {
namespace {

/// A surface whose positions are coded in some order.
struct Timed {
  Surface surface;
  PositionMap map;
  CodingOrder order;
  std::vector<VertexState> states;

  /// `count` positions, which vertices share if there are fewer of them.
  Timed(Surface s, std::uint32_t count, std::uint32_t seed) : surface(std::move(s)), states(count) {
    std::vector<std::uint32_t> time(surface.vertexCount());
    std::iota(time.begin(), time.end(), 0);
    std::mt19937 random(seed);
    std::shuffle(time.begin(), time.end(), random);
    map.position_count = count;
    for (std::uint32_t v = 0; v < time.size(); ++v) {
      map.vertex_position.push_back(surface.isDummy(v) ? kNone : time[v] % count);
    }
    order = codingOrder(surface, map, Order::kTraversal);
    collectStencils(order, states);
  }
  Timed(const Timed&) = delete;  // the order refers to the surface
  Stencils stencilsAt(std::uint32_t time) const { return {states[time], order.corner_time}; }
  Arc arcAt(std::uint32_t time) const { return arcOf(order, stencilsAt(time)); }
};

std::list<Timed> timedSurfaces() {
  std::list<Timed> all;
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    all.emplace_back(test::grid(7, 6), 43, seed);
    all.emplace_back(test::torus(6, 5), 30, seed);
    all.emplace_back(test::torus(6, 5), 11, seed);
  }
  return all;
}

TEST(Arc, HasTheStencilsOfThePosition) {
  for (const Timed& timed : timedSurfaces()) {
    for (std::uint32_t time = 0; time < timed.states.size(); ++time) {
      const Stencils stencils = timed.stencilsAt(time);
      const Arc arc = timed.arcAt(time);
      ASSERT_EQ(arc.count, stencils.count);
      for (int j = 0; j < arc.count; ++j) {
        const ArcStencil& s = arc.list[static_cast<std::size_t>(j)];
        int found = 0;
        for (std::size_t i = 0; static_cast<int>(i) < stencils.count; ++i) {
          if (stencils.face(i) != s.face) continue;
          ++found;
          const Parallelogram p = stencils[i];
          ASSERT_EQ((std::array{s.left, s.right, s.base}), (std::array{p.left, p.right, p.base}));
        }
        ASSERT_EQ(found, 1);
        ASSERT_EQ(timed.order.timeAt(s.base_corner), s.base);
      }
    }
  }
}

TEST(Arc, FollowsTheUmbrella) {
  int longest = 0;
  for (const Timed& timed : timedSurfaces()) {
    for (std::uint32_t time = 0; time < timed.states.size(); ++time) {
      const Arc arc = timed.arcAt(time);
      const auto at = [&](int j) { return arc.list[static_cast<std::size_t>(j)]; };
      bool one_follows_none = false;
      for (int j = 0; j < arc.count; ++j) {
        bool follows = false, is_followed = false;
        for (int k = 0; k < arc.count; ++k) follows |= k != j && at(k).right == at(j).left;
        for (int k = j + 1; k < arc.count; ++k) is_followed |= at(k).left == at(j).right;
        one_follows_none |= !follows;
        if (is_followed) {
          ASSERT_EQ(at(j + 1).left, at(j).right) << "the next one follows, if any does";
        }
        if (j == 2) longest += at(0).right == at(1).left && at(1).right == at(2).left;
      }
      if (one_follows_none) {
        for (int k = 1; k < arc.count; ++k) ASSERT_NE(at(k).right, at(0).left) << "the first follows none";
      }
    }
  }
  EXPECT_GT(longest, 20);
}

TEST(Arc, WingsLieBeyondTheBaseTriangle) {
  const Timed timed(test::torus(6, 5), 30, 1);
  for (std::uint32_t time = 0; time < 30; ++time) {
    const Arc arc = timed.arcAt(time);
    for (int j = 0; j < arc.count; ++j) {
      const ArcStencil& s = arc.list[static_cast<std::size_t>(j)];
      const Wings wings = wingsOf(timed.order, s);
      // The faces beyond base-left and right-base have these two and the wing.
      const auto expectBeyond = [&](std::uint32_t corner, std::uint32_t wing, std::uint32_t end) {
        const std::uint32_t beyond = timed.surface.opposite[corner];
        EXPECT_EQ(timed.order.timeAt(beyond), wing);
        const std::uint32_t a = timed.order.timeAt(nextCorner(beyond));
        const std::uint32_t b = timed.order.timeAt(previousCorner(beyond));
        EXPECT_TRUE((a == end && b == s.base) || (a == s.base && b == end));
      };
      expectBeyond(nextCorner(s.base_corner), wings.left, s.left);
      expectBeyond(previousCorner(s.base_corner), wings.right, s.right);
    }
  }
}

}  // namespace
}  // namespace tsc
