#include "order.h"

#include <gtest/gtest.h>

#include "meshes.h"
#include "stencil.h"
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
      ASSERT_EQ(visits[v], surface.is_dummy[v] ? 0 : 1) << name;
    }
  }
}

TEST(Order, TakesAVertexWithTheMostParallelograms) {
  for (const Surface& surface : {test::torus(8, 7), test::grid(7, 9)}) {
    std::vector<std::uint8_t> known(surface.vertexCount(), 0);
    std::uint32_t count = 0;
    for (const std::uint32_t v : orderOf(surface)) {
      if (count >= 3) {
        int most = 0;
        for (std::uint32_t other = 0; other < surface.vertexCount(); ++other) {
          if (known[other] || surface.is_dummy[other]) continue;
          most = std::max(most, std::min(stencilsAt(surface, known, other).count, 3));
        }
        EXPECT_EQ(std::min(stencilsAt(surface, known, v).count, 3), most) << "vertex number " << count;
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

}  // namespace
}  // namespace tsc
