#include "order.h"

#include <gtest/gtest.h>

#include "meshes.h"
#include "surface_builders.h"

namespace tsc {
namespace {

std::vector<std::uint32_t> orderOf(const Surface& surface) {
  std::vector<std::uint32_t> order;
  visitByDegree(surface, [&](std::uint32_t v) {
    order.push_back(v);
    return true;
  });
  return order;
}

TEST(Order, VisitsEveryRealVertexOnce) {
  for (const auto& [name, mesh] : meshes::samples()) {
    const Surface surface = cutToManifold(mesh.positions, mesh.indices).surface;
    std::vector<int> visits(surface.vertexCount(), 0);
    for (const std::uint32_t v : orderOf(surface)) ++visits[v];
    for (std::uint32_t v = 0; v < surface.vertexCount(); ++v) {
      ASSERT_EQ(visits[v], surface.isDummy(v) ? 0 : 1) << name;
    }
  }
}

/// Complete parallelograms at a vertex, three or more counting alike.
int parallelogramsAt(const Surface& surface, const std::vector<std::uint8_t>& known, std::uint32_t v) {
  int count = 0;
  for (std::uint32_t c = 0; c < surface.corner_vertex.size(); ++c) {
    count += surface.corner_vertex[c] == v && known[surface.corner_vertex[nextCorner(c)]] &&
             known[surface.corner_vertex[previousCorner(c)]] && known[surface.corner_vertex[surface.opposite[c]]];
  }
  return std::min(count, 3);
}

TEST(Order, TakesAVertexWithTheMostParallelograms) {
  for (const Surface& surface : {test::torus(8, 7), test::grid(7, 9)}) {
    std::vector<std::uint8_t> known(surface.vertexCount(), 0);
    std::uint32_t count = 0;
    for (const std::uint32_t v : orderOf(surface)) {
      if (count >= 3) {
        int most = 0;
        for (std::uint32_t other = 0; other < surface.vertexCount(); ++other) {
          if (!known[other] && !surface.isDummy(other)) most = std::max(most, parallelogramsAt(surface, known, other));
        }
        EXPECT_EQ(parallelogramsAt(surface, known, v), most) << "vertex number " << count;
      }
      known[v] = 1;
      ++count;
    }
  }
}

TEST(Order, StopsWhenAsked) {
  int visits = 0;
  visitByDegree(test::torus(5, 5), [&](std::uint32_t) { return ++visits < 7; });
  EXPECT_EQ(visits, 7);
}

/// Two copies of every third vertex's position.
PositionMap repeatingMap(const Surface& surface) {
  PositionMap map;
  for (std::uint32_t v = 0; v < surface.vertexCount(); ++v) {
    const bool repeats = v % 3 == 2 && v > 8;
    map.vertex_position.push_back(surface.isDummy(v) ? kNone
                                  : repeats          ? map.vertex_position[v - 6]
                                                     : map.position_count++);
  }
  return map;
}

TEST(Order, TimesAreThoseOfPositions) {
  for (const Surface& surface : {test::torus(8, 7), test::grid(7, 9), test::tetrahedron()}) {
    for (const PositionMap& map : {PositionMap{{}, surface.real_count}, repeatingMap(surface)}) {
      for (const Order order : {Order::kTraversal, Order::kDegree}) {
        const CodingOrder coding = codingOrder(surface, map, order);
        ASSERT_EQ(coding.corner_time.size(), surface.corner_vertex.size());
        for (std::uint32_t f = 0; f < surface.faceCount(); ++f) {
          const std::uint32_t* const times = &coding.corner_time[3 * f];
          std::uint32_t corner = coding.firstCorner(3 * f);
          ASSERT_EQ(corner / 3, f);
          for (std::uint32_t k = 0; k < 3; ++k, corner = nextCorner(corner)) ASSERT_EQ(times[k], coding.timeAt(corner));
          if (coding.vertex_time.empty()) continue;
          ASSERT_GE(times[0], std::max(times[1], times[2])) << "the last first";
        }
        std::vector<int> taken(map.position_count, 0);
        for (std::uint32_t time = 0; time < map.position_count; ++time) {
          ++taken[coding.position.empty() ? time : coding.position[time]];
        }
        EXPECT_EQ(taken, std::vector<int>(map.position_count, 1)) << "each position once";
        for (std::uint32_t c = 0; c < surface.corner_vertex.size(); ++c) {
          const std::uint32_t v = surface.corner_vertex[c], time = coding.timeAt(c);
          ASSERT_EQ(time >= map.position_count, surface.isDummy(v));
          if (surface.isDummy(v)) continue;
          ASSERT_EQ(coding.position.empty() ? time : coding.position[time], map.positionOf(v));
        }
      }
    }
  }
}

}  // namespace
}  // namespace tsc
