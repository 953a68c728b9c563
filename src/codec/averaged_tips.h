// Symbols of tips at effort default: the average of two adaptive tables, chosen by the degrees and free valences around
// the gate (BITSTREAM.md, section 5.3).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "context_tables.h"
#include "front.h"
#include "gate.h"

namespace tsc {

/// Contexts for a tip. Degrees: a, b of the gate's ends, c, z of their neighbours on the loop, o of the vertex that
/// faces the gate, p of the one that faces the pivot's other edge. Free valences of the gate's ends.
inline AveragedModel::Context contextOf(const Front& front, const Gate& gate) {
  const Front::Node& pivot = front[gate.pivot];
  const Front::Node& other = front[gate.other];
  const Front::Node& beyond_pivot = front[gate.beyond_pivot];
  const std::uint32_t ab = std::uint32_t{pivot.degree_class} << 4 | other.degree_class;
  const std::uint32_t c = front[gate.beyond_other].degree_class;
  const std::uint32_t z = beyond_pivot.degree_class;
  const std::uint32_t o = front[gate.start()].facing_class;
  const std::uint32_t p = front[gate.direction != 0 ? gate.beyond_pivot : gate.pivot].facing_class;
  const std::uint32_t pivot_free = std::min(pivot.free_valence, 15u);
  const std::uint32_t other_free = std::min(other.free_valence, 15u);
  return {ab, ab << 12 | c << 8 | z << 4 | o, ab << 16 | p << 12 | z << 8 | pivot_free << 4 | other_free};
}

/// Distribution of tips before anything is known: cumulative frequencies below each symbol.
constexpr std::array<std::int16_t, 16> kTipPrior = {0,     1200,  4200,  11200, 20800, 26000, 28200, 29300,
                                                    29900, 30300, 30600, 30800, 31000, 31300, 31400, 32200};

/// Symbols of tips at effort default.
class AveragedTips {
 public:
  explicit AveragedTips(std::uint32_t vertex_count) : tables_(kTipPrior, vertex_count) {}

  template <class Direction>
  std::uint32_t code(Direction& direction, const Front& front, const Gate& gate, std::uint32_t symbol) {
    const AveragedModel::Context context = contextOf(front, gate);
    if constexpr (Direction::kWrites) {
      tables_.put(direction.writer, context, symbol);
      return symbol;
    } else {
      return tables_.get(direction.reader, context);
    }
  }

 private:
  AveragedModel tables_;
};

}  // namespace tsc
