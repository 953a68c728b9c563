// What a tip at effort max is predicted from: the degrees and free valences along the front, three nodes to either side
// of the gate, and the degrees that face these edges (BITSTREAM.md, section 5.7).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "front.h"
#include "gate.h"

namespace tsc {

inline constexpr std::size_t kTipContexts = 6;

/// By class: below degree 6, 6, above.
inline constexpr std::array<std::uint32_t, 16> kLevel = {0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2};

/// Numbers below 2^28, to be hashed.
inline std::array<std::uint32_t, kTipContexts> tipContextsOf(const Front& front, const Gate& gate) {
  const std::uint32_t forward = gate.direction;
  const Front::Node& pivot0 = front[gate.pivot];
  const Front::Node& pivot1 = front[gate.beyond_pivot];
  const Front::Node& pivot2 = front[pivot1.link[1 - forward]];
  const Front::Node& other0 = front[gate.other];
  const Front::Node& other1 = front[gate.beyond_other];
  const Front::Node& other2 = front[other1.link[forward]];

  // Classes of the vertices on the front and, without a branch, of those that face its edges.
  const std::uint32_t p0 = pivot0.degree_class, p1 = pivot1.degree_class, p2 = pivot2.degree_class;
  const std::uint32_t q0 = other0.degree_class, q1 = other1.degree_class, q2 = other2.degree_class;
  const Front::Node* const along[] = {&pivot2, &pivot1, &pivot0, &other0, &other1, &other2};
  const Front::Node* const* const edges = along + (1 - forward);
  const std::uint32_t r1 = edges[0]->facing_class, r0 = edges[1]->facing_class, o = edges[2]->facing_class;
  const std::uint32_t s0 = edges[3]->facing_class, s1 = edges[4]->facing_class;
  const std::uint32_t u0 = std::min(pivot0.free_valence, 15u), u1 = std::min(pivot1.free_valence, 15u);
  const std::uint32_t v0 = std::min(other0.free_valence, 15u), v1 = std::min(other1.free_valence, 15u);

  // The tip is a neighbour of the gate's ends, and of those nodes beyond that are reached over free valences of 1.
  const std::uint32_t pivot_reach = u0 == 1 ? 1u + (u1 == 1) : 0u;
  const std::uint32_t other_reach = v0 == 1 ? 1u + (v1 == 1) : 0u;
  const std::uint32_t reach = pivot_reach << 2 | other_reach;
  const auto onlyIf = [](bool holds, std::uint32_t value) { return value & (0 - std::uint32_t{holds}); };
  const std::uint32_t neighbours = p0 + q0 + onlyIf(pivot_reach > 0, p1) + onlyIf(pivot_reach > 1, p2) +
                                   onlyIf(other_reach > 0, q1) + onlyIf(other_reach > 1, q2);
  const std::uint32_t all = p0 + p1 + p2 + q0 + q1 + q2 + o + r0 + r1 + s0 + s1;
  // How far the sum of so many classes is above that of degree 6, from -8 to 8, as 0 to 16. A dummy counts as 16.
  const auto excess = [](std::uint32_t sum, std::uint32_t count) {
    return static_cast<std::uint32_t>(std::clamp(static_cast<int>(sum) - static_cast<int>(5 * count), -8, 8) + 8);
  };
  const std::uint32_t levels = kLevel[p0] | kLevel[q0] << 2 | kLevel[p1] << 4 | kLevel[q1] << 6 | kLevel[o] << 8 |
                               kLevel[r0] << 10 | kLevel[s0] << 12;
  const std::uint32_t few_free =
      std::min(u0, 3u) | std::min(v0, 3u) << 2 | std::min(u1, 3u) << 4 | std::min(v1, 3u) << 6;
  return {
      p0 << 20 | q0 << 16 | p1 << 12 | o << 8 | r0 << 4 | u0,
      p0 << 24 | p1 << 20 | p2 << 16 | r0 << 12 | r1 << 8 | u0 << 4 | u1,
      q0 << 24 | q1 << 20 | q2 << 16 | s0 << 12 | s1 << 8 | v0 << 4 | v1,
      reach << 5 | excess(neighbours, 2 + pivot_reach + other_reach),
      reach << 14 | levels,
      p0 << 17 | q0 << 13 | excess(all, 11) << 8 | few_free,
  };
}

}  // namespace tsc
