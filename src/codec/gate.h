// The gate: the edge of the front on which the next face is grown, and what lies around it (BITSTREAM.md, section 5.2).
#pragma once

#include <cstdint>

#include "front.h"

namespace tsc {

/// The edge to grow from and the nodes around it, seen from the pivot: `other` is the gate's other end.
struct Gate {
  std::uint32_t direction;  ///< from the pivot to `other` along the loop: 1 forward, 0 backward
  std::uint32_t pivot, other, beyond_pivot, beyond_other;

  /// The node whose edge is the gate, and the one where that edge ends. Without a branch, which could not be predicted.
  std::uint32_t start() const { return other ^ ((other ^ pivot) & (0 - direction)); }
  std::uint32_t end() const { return pivot ^ other ^ start(); }
};

/// Of the pivot's two edges the one to the vertex of smaller degree, which costs fewer bits; the one that leaves it
/// when they are equal. A dummy counts as the largest: over the edge of a hole there is no parallelogram.
inline Gate gateAt(const Front& front, std::uint32_t pivot) {
  const Front::Node& node = front[pivot];
  const std::uint32_t direction = front[node.previous()].degree_class >= front[node.next()].degree_class;
  const std::uint32_t other = node.link[direction];
  return {direction, pivot, other, node.link[1 - direction], front[other].link[direction]};
}

/// The node `distance` steps along the loop from the gate, away from it on the pivot's side or on the other end's.
inline std::uint32_t nodeNear(const Front& front, const Gate& gate, std::uint32_t distance, bool on_pivot_side) {
  const std::uint32_t direction = on_pivot_side ? 1 - gate.direction : gate.direction;
  std::uint32_t node = on_pivot_side ? gate.pivot : gate.other;
  while (distance-- > 0) node = front[node].link[direction];
  return node;
}

}  // namespace tsc
