// What the parts of the assignment stage share: the table vertices known so far and how they are chosen among those at
// one position. Internal to assignment.cpp, corners.cpp and side_faces.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "assignment.h"
#include "direction.h"

namespace tsc {

/// How to choose among the vertices of a position: 0 a new vertex, 1.. the candidate before that many, 15 the escape.
struct VertexChoiceModel {
  std::array<SymbolModel, 4> choice;  ///< by number of candidates
  IntegerModel back;                  ///< escape: how many vertices ago the table got it
};

/// The vertices of one table at one position. With a *complete* list nothing else can be meant.
struct VertexCandidates {
  static constexpr std::uint32_t kMax = 14;
  static constexpr std::uint32_t kMaxWalk = 32;  ///< keeps time linear where a stream piles vertices on one position
  std::array<std::uint32_t, kMax> id;
  std::uint32_t count = 0;
  bool complete = true;
};

template <class Direction>
struct AssignmentState {
  /// A table vertex. Its number over all tables, in order of creation, is its *id*.
  struct Vertex {
    std::uint32_t table;
    std::uint32_t index;  ///< in the table
    std::uint32_t older;  ///< id of the vertex created before it at the same position, in any table
  };

  std::conditional_t<Direction::kWrites, const Surface, Surface>& surface;  ///< reading uses it up
  const PositionMap& map;
  std::span<const glm::ivec3> positions;  ///< by position number, or empty
  const Assignment::Counts& counts;
  Direction direction;
  Assignment& out;
  const AssignmentInput* input;  ///< null when reading
  AssignmentOrder* order;        ///< null when reading

  std::vector<std::uint32_t> face_primitive = {};  ///< per surface face; kNone for dummy faces
  std::vector<std::uint32_t> unused_faces = {};    ///< per primitive: faces it still needs
  std::uint32_t real_face_count = 0;
  // Not kept with one vertex per position: table vertex, id and position are then the same number.
  std::vector<std::uint32_t> corner_id = {};         ///< per surface corner: id of its vertex, kNone while unknown
  std::vector<Vertex> vertices = {};                 ///< by id
  std::vector<std::uint32_t> newest = {};            ///< per position: id of the last vertex created there
  std::vector<std::vector<std::uint32_t>> ids = {};  ///< per table, by index
  std::vector<std::vector<std::uint32_t>> decoded_index = {};  ///< writing: per table and input vertex, or kNone
  std::vector<std::uint32_t> welded_position = {};             ///< writing: the input's, and extra positions

  Status error(ErrorCode code, const char* where, std::int64_t found, std::int64_t expected) const {
    return Error{code, where, direction.position(), found, expected};
  }
  Status truncated(const char* where) const { return error(ErrorCode::kTruncated, where, 0, 0); }

  std::uint32_t tableSize(std::uint32_t table) const {
    return counts.one_vertex_per_position ? out.position_count
                                          : static_cast<std::uint32_t>(out.table_position[table].size());
  }

  /// Table vertex of a real surface corner.
  std::uint32_t cornerIndex(std::uint32_t corner) const {
    return counts.one_vertex_per_position ? map.positionOf(surface.corner_vertex[corner])
                                          : vertices[corner_id[corner]].index;
  }

  /// Creates the table's next vertex, which is vertex `input_vertex` of the encoder's table.
  Status createVertex(std::uint32_t table, std::uint32_t position, std::uint32_t input_vertex) {
    const std::uint32_t index = tableSize(table);
    if (index == counts.table_vertex_count[table]) {
      return error(ErrorCode::kInvalidCount, "assignment: table vertices", std::int64_t{index} + 1, index);
    }
    if (!counts.one_vertex_per_position) {
      out.table_position[table].push_back(position);
      const auto id = static_cast<std::uint32_t>(vertices.size());
      vertices.push_back({table, index, newest[position]});
      newest[position] = id;
      ids[table].push_back(id);
    }
    if constexpr (Direction::kWrites) {
      decoded_index[table][input_vertex] = index;
      order->vertex[table].push_back(input_vertex);
    }
    return {};
  }

  /// Writing: position number of a vertex of the input, kNone while it has none.
  std::uint32_t knownPosition(std::uint32_t table, std::uint32_t input_vertex) const {
    return welded_position[input->table_welded[table][input_vertex]];
  }

  /// Creates the table's next vertex at a position beyond the surface's, which it creates too.
  Status createVertexAndPosition(std::uint32_t table, std::uint32_t input_vertex) {
    const std::uint32_t position = out.position_count;
    if (!counts.one_vertex_per_position) newest.push_back(kNone);
    if constexpr (Direction::kWrites) {
      const std::uint32_t welded = input->table_welded[table][input_vertex];
      welded_position[welded] = position;
      order->extra_positions.push_back(welded);
    }
    if (Status status = createVertex(table, position, input_vertex)) return status;
    ++out.position_count;
    return {};
  }

  /// Lists the table's vertices at a position: `first` (if it is one of the table, else ignored), then newest first,
  /// without `excluded`.
  VertexCandidates candidatesAt(std::uint32_t position, std::uint32_t table, std::uint32_t first,
                                std::uint32_t excluded) const {
    VertexCandidates candidates;
    if (first != kNone && first != excluded && vertices[first].table == table) {
      candidates.id[candidates.count++] = first;
    }
    std::uint32_t id = newest[position];
    for (std::uint32_t step = 0; id != kNone; ++step, id = vertices[id].older) {
      if (step == VertexCandidates::kMaxWalk || candidates.count == VertexCandidates::kMax) {
        candidates.complete = false;
        break;
      }
      if (vertices[id].table == table && id != first && id != excluded) candidates.id[candidates.count++] = id;
    }
    return candidates;
  }

  /// Codes which vertex of the table a corner at this position uses, given as `input_vertex` when writing; creates it
  /// if it is new. Not for one vertex per position.
  Status chooseVertex(std::uint32_t position, std::uint32_t table, std::uint32_t first, std::uint32_t excluded,
                      std::uint32_t input_vertex, VertexChoiceModel& model, std::uint32_t& id) {
    const VertexCandidates candidates = candidatesAt(position, table, first, excluded);
    id = static_cast<std::uint32_t>(vertices.size());
    if (candidates.count == 0 && candidates.complete) return createVertex(table, position, input_vertex);

    constexpr std::uint32_t kEscape = 15;
    std::uint32_t symbol = 0, back = 0;
    if constexpr (Direction::kWrites) {
      const std::uint32_t index = decoded_index[table][input_vertex];
      if (index != kNone) {
        while (symbol < candidates.count && candidates.id[symbol] != ids[table][index]) ++symbol;
        symbol = symbol < candidates.count ? symbol + 1 : kEscape;
        back = tableSize(table) - 1 - index;
      }
    }
    symbol = direction.symbol(model.choice[candidates.count < 3 ? candidates.count : 3], symbol);
    if (symbol == 0) return createVertex(table, position, input_vertex);
    if (symbol <= candidates.count) {
      id = candidates.id[symbol - 1];
      return {};
    }
    if (symbol != kEscape) {
      return error(ErrorCode::kInvalidSymbol, "corners: vertex at a position", symbol, candidates.count);
    }
    back = direction.integer(model.back, back);
    const std::uint32_t size = tableSize(table);
    if (back >= size || out.table_position[table][size - 1 - back] != position) {
      return error(ErrorCode::kInvalidSymbol, "corners: earlier vertex", back, size);
    }
    id = ids[table][size - 1 - back];
    return {};
  }
};

/// corners.cpp: creates the surface's table vertices and fills `corner_id`. Not for one vertex per position.
template <class Direction>
Status codeCorners(AssignmentState<Direction>& state);

/// side_faces.cpp: the faces that the primitives still need, then the vertices that the tables still need.
template <class Direction>
Status codeSideFaces(AssignmentState<Direction>& state);
template <class Direction>
Status codeUnusedVertices(AssignmentState<Direction>& state);

}  // namespace tsc
