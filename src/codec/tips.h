// The tip of a new face, its third vertex: what the decoder has to be told about it (BITSTREAM.md, sections 5.3, 5.4).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "direction.h"
#include "front.h"
#include "gate.h"
#include "models.h"

namespace tsc {

// The symbols of a tip. 0..kSymbolEscape - 1: a new vertex of degree symbol + 3.
inline constexpr std::uint32_t kFirstDegree = 3;
inline constexpr std::uint32_t kEscapeDegree = 15;
inline constexpr std::uint32_t kSymbolEscape = 12;  ///< a new vertex of degree 15 or more; the excess follows
inline constexpr std::uint32_t kSymbolDegree2 = 13;
inline constexpr std::uint32_t kSymbolSplit = 14;
inline constexpr std::uint32_t kSymbolDummy = 15;  ///< a new dummy vertex; its degree follows

struct Tip {
  bool is_split = false;
  // New vertex:
  std::uint32_t degree = 0;
  std::uint32_t degree_class = 0;
  // Split:
  std::uint32_t node = 0;           ///< of the front
  std::uint32_t right_valence = 0;  ///< free edges between the gate's start and the node's edge
};

inline std::uint32_t degreeClass(std::uint32_t degree) { return std::min(degree, kEscapeDegree) - 1; }
inline Tip newVertex(std::uint32_t degree) { return {.degree = degree, .degree_class = degreeClass(degree)}; }
inline Tip newDummy(std::uint32_t degree) { return {.degree = degree, .degree_class = Front::kDummyClass}; }

inline std::uint32_t symbolOf(const Tip& tip) {
  if (tip.is_split) return kSymbolSplit;
  if (tip.degree_class == Front::kDummyClass) return kSymbolDummy;
  if (tip.degree >= kEscapeDegree) return kSymbolEscape;
  return tip.degree == 2 ? kSymbolDegree2 : tip.degree - kFirstDegree;
}

/// All models of this stage. `Symbols` gives the symbols their probabilities: `AveragedTips` or `MixedTips`.
template <class Direction, class Symbols>
class TipCoder {
 public:
  TipCoder(Direction direction, std::uint32_t vertex_count) : direction_(direction), symbols_(vertex_count) {}

  /// Degree of one of a component's first three vertices.
  std::uint32_t codeStart(std::uint32_t degree) {
    const std::uint32_t symbol = direction_.symbol(start_degree_, std::min(degree, kEscapeDegree));
    return symbol < kEscapeDegree ? symbol : kEscapeDegree + direction_.integer(large_degree_, degree - kEscapeDegree);
  }

  Tip code(const Front& front, const Gate& gate, const Tip& tip) {
    const std::uint32_t symbol = symbols_.code(direction_, front, gate, Direction::kWrites ? symbolOf(tip) : 0);
    if (symbol < kSymbolEscape) [[likely]] {
      return {.degree = symbol + kFirstDegree, .degree_class = symbol + kFirstDegree - 1};
    }
    return codeRare(front, gate.pivot, symbol, tip);
  }

 private:
  /// A split within so many steps of the gate is coded by distance; 0 stands for a node number. The bound keeps a
  /// hostile stream linear.
  static constexpr std::uint32_t kMaxDistance = 15;

  /// Given the pivot and not the gate, so that the gate can stay in registers.
  [[gnu::noinline]] Tip codeRare(const Front& front, std::uint32_t pivot, std::uint32_t symbol, const Tip& tip) {
    if (symbol == kSymbolSplit) return codeSplit(front, gateAt(front, pivot), tip);
    if (symbol == kSymbolDegree2) return newVertex(2);
    if (symbol == kSymbolEscape) {
      return newVertex(kEscapeDegree + direction_.integer(large_degree_, tip.degree - kEscapeDegree));
    }
    return newDummy(2 + direction_.integer(dummy_degree_, tip.degree - 2));
  }

  /// Whether the node can be split at all, and so, is the caller's to check.
  Tip codeSplit(const Front& front, const Gate& gate, const Tip& tip) {
    const Place place = Direction::kWrites ? placeOf(front, gate, tip.node) : Place{};
    Tip coded{.is_split = true};
    if (const std::uint32_t distance = direction_.symbol(split_distance_, place.distance); distance > 0) {
      coded.node = nodeNear(front, gate, distance, direction_.bit(split_side_, place.on_pivot_side));
    } else {
      const int bits = static_cast<int>(std::bit_width(front.nodeCount() - 1));
      const std::uint32_t node = direction_.raw(tip.node, bits);
      coded.node = node < front.nodeCount() ? node : gate.start();  // which no split may take
    }
    if (const std::uint32_t free_valence = front[coded.node].free_valence; free_valence > 2) {
      coded.right_valence = direction_.integer(right_valence_[std::min(free_valence - 2, 15u)], tip.right_valence);
    }
    return coded;
  }

  struct Place {
    std::uint32_t distance = 0;  ///< 0: not near
    bool on_pivot_side = false;
  };
  static Place placeOf(const Front& front, const Gate& gate, std::uint32_t node) {
    for (std::uint32_t distance = 1; distance <= kMaxDistance; ++distance) {
      for (const bool on_pivot_side : {false, true}) {
        if (nodeNear(front, gate, distance, on_pivot_side) == node) return {distance, on_pivot_side};
      }
    }
    return {};
  }

  Direction direction_;
  Symbols symbols_;
  SymbolModel start_degree_, split_distance_;
  BitModel split_side_;
  IntegerModel dummy_degree_, large_degree_;
  std::array<IntegerModel, 16> right_valence_;
};

}  // namespace tsc
