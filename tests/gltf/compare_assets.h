// Comparing an asset with its packed-and-unpacked self, exactly: every vertex gets an id as an attribute of its own, so
// that it is recognised wherever it ends up.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tsc/gltf.h"

namespace tsc::test {

/// Adds the attribute `_TEST_ID`, the vertex number, to every primitive with positions.
void addVertexIds(Asset& asset);

/// What one primitive shows.
struct PrimitiveContent {
  std::uint32_t mode = 0;                               ///< 4 for strips and fans
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< by id, each beginning with its smallest, sorted
  std::vector<std::uint32_t> elements;                  ///< ids of points and lines, in order
  std::map<std::uint32_t, std::string> attributes;      ///< by id: the bytes of all attributes but POSITION
  std::map<std::uint32_t, std::array<float, 3>> positions;
};

/// All primitives with positions, in the order of the document. The asset must not be packed.
std::vector<PrimitiveContent> contentOf(const Asset& asset);

/// Adds GoogleTest failures where `after` shows anything else than `before`, or a position is off by more than `bound`.
void expectSame(const Asset& before, const Asset& after, double bound);

/// Checks that positions equal before are equal after, within each mesh.
void expectWatertight(const Asset& before, const Asset& after);

}  // namespace tsc::test
