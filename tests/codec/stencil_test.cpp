#include "stencil.h"

#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "surface_builders.h"

namespace tsc {
namespace {

std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> triplesOf(const Stencils& stencils) {
  std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> triples;
  for (int i = 0; i < stencils.count; ++i) {
    const Stencil& s = stencils.list[static_cast<std::size_t>(i)];
    triples.insert({s.left, s.right, s.base});
  }
  return triples;
}

// The grid's vertices are y * 4 + x; quads are split along (x, y) - (x + 1, y + 1).
TEST(Stencil, OnAGrid) {
  const Surface surface = test::grid(4, 4);
  std::vector<std::uint8_t> known(surface.vertexCount(), 0);
  EXPECT_EQ(stencilsAt(surface, known, 5).count, 0);
  EXPECT_EQ(stencilsAt(surface, known, 5).neighbour, kNone);
  EXPECT_EQ(stencilsAt(surface, known, 5).valence, 6);

  known[0] = known[1] = 1;
  EXPECT_EQ(stencilsAt(surface, known, 5).count, 0) << "a gate without a base vertex";
  EXPECT_NE(stencilsAt(surface, known, 5).neighbour, kNone);
  known[4] = 1;
  EXPECT_EQ(stencilsAt(surface, known, 5).count, 0) << "the dummies behind the border are never known";

  std::fill(known.begin(), known.end(), 1);
  known[surface.vertexCount() - 1] = 0;  // the dummy
  known[5] = 0;
  const Stencils all = stencilsAt(surface, known, 5);
  // Of the six faces around 5 those at the corner 0 have the dummy behind their gates.
  const std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> expected = {
      {1, 6, 2}, {6, 10, 11}, {10, 9, 14}, {9, 4, 8}};
  EXPECT_EQ(triplesOf(all), expected);
  EXPECT_EQ(all.valence, 6);
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
  std::vector<std::uint8_t> known(surface.vertexCount(), 1);
  known[0] = known[dummy] = 0;
  const Stencils stencils = stencilsAt(surface, known, 0);
  EXPECT_EQ(stencils.count, kMaxStencils);
  EXPECT_EQ(stencils.valence, kRing);
  std::set<std::uint32_t> bases;
  for (int i = 0; i < stencils.count; ++i) bases.insert(stencils.list[static_cast<std::size_t>(i)].base);
  EXPECT_EQ(bases.size(), std::size_t{kMaxStencils});
}

}  // namespace
}  // namespace tsc
