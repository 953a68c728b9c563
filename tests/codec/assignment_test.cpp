// Tables and primitives over a surface: whatever the corners use, the decoder gets the same, and every vertex and
// face of the input comes back.
#include "assignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>

#include "surface_builders.h"

namespace tsc::test {
namespace {

/// What one test codes. By default one primitive over one table in which every welded vertex has one vertex.
struct Fixture {
  Surface surface;
  std::vector<std::uint32_t> vertex_welded;
  std::uint32_t welded_count = 0;
  AssignmentInput input;
  std::vector<std::uint32_t> primitive_table = {0};

  explicit Fixture(Surface s) : surface(std::move(s)) {
    for (std::uint32_t v = 0; v < surface.vertexCount(); ++v) {
      vertex_welded.push_back(surface.isDummy(v) ? kNone : welded_count++);
    }
    input.table_welded.resize(1);
    for (std::uint32_t w = 0; w < welded_count; ++w) input.table_welded[0].push_back(w);
    for (std::uint32_t f = 0; f < surface.faceCount(); ++f) {
      bool dummy = false;
      for (std::uint32_t c = 3 * f; c < 3 * f + 3; ++c) dummy |= surface.isDummy(surface.corner_vertex[c]);
      input.face_primitive.push_back(dummy ? kNone : 0);
      for (std::uint32_t c = 3 * f; c < 3 * f + 3; ++c) input.corner_vertex.push_back(dummy ? kNone : weldedAt(c));
    }
  }

  std::uint32_t weldedAt(std::uint32_t corner) const { return vertex_welded[surface.corner_vertex[corner]]; }

  /// Gives a corner a vertex of its own.
  std::uint32_t separate(std::uint32_t corner) {
    auto& table = input.table_welded[primitive_table[input.face_primitive[corner / 3]]];
    table.push_back(weldedAt(corner));
    return input.corner_vertex[corner] = static_cast<std::uint32_t>(table.size()) - 1;
  }

  std::uint32_t addVertex(std::uint32_t table, std::uint32_t welded) {
    welded_count = std::max(welded_count, welded + 1);
    input.table_welded[table].push_back(welded);
    return static_cast<std::uint32_t>(input.table_welded[table].size()) - 1;
  }

  void addTable() {
    input.table_welded.emplace_back();
    for (std::uint32_t w = 0; w < welded_count; ++w) input.table_welded.back().push_back(w);
  }
};

struct Coded {
  double bits = 0;
  std::size_t symbols = 0;
  Assignment::Counts counts;
  Assignment assignment;
  AssignmentOrder order;
};

/// Position number of each vertex of a table that has `count` of them.
std::vector<std::uint32_t> positionsOf(const Assignment& assignment, std::size_t table, std::size_t count) {
  std::vector<std::uint32_t> positions = assignment.table_position[table];
  if (positions.empty()) {
    positions.resize(count);
    std::iota(positions.begin(), positions.end(), 0);
  }
  return positions;
}

/// Every vertex comes back once, at the position of its welded vertex.
void checkVertices(const Fixture& fixture, const Coded& coded, std::uint32_t surface_positions) {
  std::vector<std::uint32_t> position_welded(coded.assignment.position_count, kNone);
  for (std::uint32_t w = 0; w < fixture.welded_count; ++w) {
    if (fixture.input.welded_position[w] != kNone) position_welded[fixture.input.welded_position[w]] = w;
  }
  ASSERT_EQ(surface_positions + coded.order.extra_positions.size(), coded.assignment.position_count);
  std::copy(coded.order.extra_positions.begin(), coded.order.extra_positions.end(),
            position_welded.begin() + surface_positions);
  for (std::size_t t = 0; t < fixture.input.table_welded.size(); ++t) {
    const auto& welded = fixture.input.table_welded[t];
    const auto& order = coded.order.vertex[t];
    ASSERT_EQ(order.size(), welded.size());
    const std::vector<std::uint32_t> positions = positionsOf(coded.assignment, t, welded.size());
    ASSERT_EQ(positions.size(), welded.size());
    std::vector<std::uint32_t> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (std::uint32_t i = 0; i < sorted.size(); ++i) {
      ASSERT_EQ(sorted[i], i);
      ASSERT_EQ(position_welded[positions[i]], welded[order[i]]);
    }
  }
}

/// Every face comes back once, in its primitive, with its vertices.
void checkFaces(const Fixture& fixture, const Coded& coded) {
  const std::uint32_t surface_faces = fixture.surface.faceCount();
  std::size_t total = 0;
  std::vector<std::uint8_t> met(surface_faces + fixture.input.side_faces.size(), 0);
  for (std::uint32_t p = 0; p < fixture.primitive_table.size(); ++p) {
    const auto& indices = coded.assignment.primitive_indices[p];
    const auto& order = coded.order.triangle[p];
    ASSERT_EQ(indices.size(), 3 * order.size());
    ASSERT_EQ(order.size(), coded.counts.primitive_face_count[p]);
    total += order.size();
    for (std::size_t i = 0; i < order.size(); ++i) {
      const std::uint32_t face = order[i] / 3;
      ASSERT_EQ(met[face]++, 0);
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t corner = (order[i] % 3 + k) % 3;
        const bool side = face >= surface_faces;
        const std::uint32_t expected = side ? fixture.input.side_faces[face - surface_faces].table_vertex[corner]
                                            : fixture.input.corner_vertex[3 * face + corner];
        ASSERT_EQ(coded.order.vertex[fixture.primitive_table[p]][indices[3 * i + k]], expected);
        ASSERT_EQ(p,
                  side ? fixture.input.side_faces[face - surface_faces].primitive : fixture.input.face_primitive[face]);
      }
    }
  }
  const auto& faces = fixture.input.face_primitive;
  ASSERT_EQ(total, met.size() - std::count(faces.begin(), faces.end(), kNone));
}

/// `positions` by position number, or empty.
Coded roundTrip(Fixture fixture, const std::vector<glm::ivec3>& positions = {}) {
  Coded coded;
  const PositionMap map = numberPositions(fixture.vertex_welded, fixture.welded_count, fixture.input.welded_position);
  coded.counts = countAssignment(fixture.input, fixture.primitive_table);
  EntropyWriter writer;
  coded.order =
      encodeAssignment(fixture.surface, map, positions, fixture.input, coded.counts, writer, coded.assignment);
  coded.bits = writer.bitsSince(0);
  coded.symbols = writer.mark();
  checkVertices(fixture, coded, map.position_count);
  checkFaces(fixture, coded);

  std::vector<std::byte> bytes;
  writer.finish(5, bytes);
  EntropyReader reader(bytes);
  Assignment decoded;
  const Status status = decodeAssignment(Surface(fixture.surface), map, positions, coded.counts, reader, decoded);
  EXPECT_FALSE(status) << status->where << " " << status->found << " " << status->expected;
  EXPECT_EQ(decoded.table_position, coded.assignment.table_position);
  EXPECT_EQ(decoded.primitive_indices, coded.assignment.primitive_indices);
  EXPECT_EQ(decoded.position_count, coded.assignment.position_count);
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.state(), finalState(5));
  return coded;
}

TEST(Assignment, OneVertexPerPositionNeedsNoSymbols) {
  for (const Surface& surface : {tetrahedron(), sheet(), cube(), torus(9, 7), grid(8, 6)}) {
    const Coded coded = roundTrip(Fixture(surface));
    EXPECT_TRUE(coded.counts.one_vertex_per_position);
    EXPECT_EQ(coded.symbols, 0u);
  }
}

TEST(Assignment, WithoutSeamsCornersCostNearlyNothing) {
  Fixture fixture(torus(60, 50));
  fixture.separate(100);
  const Coded coded = roundTrip(fixture);
  EXPECT_FALSE(coded.counts.one_vertex_per_position);
  EXPECT_LT(coded.bits, 100);
}

TEST(Assignment, CubeWithAVertexPerSideAndCorner) {
  Fixture fixture(cube());
  fixture.input.table_welded[0].clear();
  for (std::uint32_t f = 0; f < 12; f += 2) {
    // Side s0 s1 s2, s0 s2 s3: corners 0 and 2 of the first face are 0 and 1 of the second.
    for (std::uint32_t k = 0; k < 3; ++k) fixture.separate(3 * f + k);
    fixture.input.corner_vertex[3 * f + 3] = fixture.input.corner_vertex[3 * f];
    fixture.input.corner_vertex[3 * f + 4] = fixture.input.corner_vertex[3 * f + 2];
    fixture.separate(3 * f + 5);
  }
  ASSERT_EQ(fixture.input.table_welded[0].size(), 24u);
  EXPECT_LT(roundTrip(fixture).bits, 80);
}

TEST(Assignment, CornersThatAreNotAdjacentShareAVertex) {
  Fixture fixture(torus(5, 5));
  const std::uint32_t first = fixture.surface.vertex_corner[12];
  std::uint32_t shared = kNone, c = first;
  for (int i = 0; i < 6; ++i, c = nextAroundVertex(fixture.surface, c)) {
    if (i % 2 == 0) continue;
    if (shared == kNone) {
      shared = fixture.separate(c);
    } else {
      fixture.input.corner_vertex[c] = shared;
    }
  }
  ASSERT_EQ(c, first);
  roundTrip(fixture);
}

TEST(Assignment, SeamLineCostsLittle) {
  // A torus cut open along two loops, as by a texture.
  const std::uint32_t width = 64, height = 48;
  Fixture fixture(torus(width, height));
  auto& welded = fixture.input.table_welded[0];
  welded.clear();
  std::map<std::uint32_t, std::uint32_t> vertex_at;
  for (std::uint32_t f = 0; f < fixture.surface.faceCount(); ++f) {
    const std::uint32_t quad = f / 2;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t x = quad % width + (k == 1 || (k == 2 && f % 2 == 0));
      const std::uint32_t y = quad / width + (k == 2 || (k == 1 && f % 2 == 1));
      const auto [entry, is_new] = vertex_at.try_emplace(y * (width + 1) + x, welded.size());
      if (is_new) welded.push_back(fixture.weldedAt(3 * f + k));
      fixture.input.corner_vertex[3 * f + k] = entry->second;
    }
  }
  ASSERT_EQ(welded.size(), (width + 1) * (height + 1));
  EXPECT_LT(roundTrip(fixture).bits / (width * height), 0.3);
}

TEST(Assignment, SeamsAtCreasesCostLessWhenPositionsShowThem) {
  // Terraces: four rows of quads up, four rows level; faces on the two sides of a crease have vertices of their own.
  const std::uint32_t width = 40, height = 40;
  Fixture fixture(grid(width, height));
  auto& welded = fixture.input.table_welded[0];
  welded.clear();
  std::vector<glm::ivec3> positions;
  for (std::uint32_t v = 0; v < width * height; ++v) {
    const auto x = static_cast<std::int32_t>(v % width), y = static_cast<std::int32_t>(v / width);
    positions.push_back(100 * glm::ivec3(x, y / 8 * 4 + std::min(y % 8, 4), y / 8 * 4 + std::max(y % 8 - 4, 0)));
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> vertex_at;
  for (std::uint32_t c = 0; c < fixture.surface.corner_vertex.size(); ++c) {
    if (fixture.input.face_primitive[c / 3] == kNone) continue;
    const std::uint32_t terrace = c / 6 / (width - 1) / 4;
    const auto [entry, is_new] = vertex_at.try_emplace({terrace, fixture.weldedAt(c)}, welded.size());
    if (is_new) welded.push_back(fixture.weldedAt(c));
    fixture.input.corner_vertex[c] = entry->second;
  }
  EXPECT_LT(roundTrip(fixture, positions).bits, 0.9 * roundTrip(fixture).bits);
}

TEST(Assignment, TablesOverTheSamePositions) {
  Fixture fixture(grid(12, 10));
  fixture.primitive_table = {0, 1, 2};
  fixture.addTable();
  fixture.addTable();
  for (std::uint32_t f = 0; f < fixture.surface.faceCount(); ++f) {
    if (fixture.input.face_primitive[f] != kNone) fixture.input.face_primitive[f] = f / 20 % 3;
  }
  roundTrip(fixture);
}

TEST(Assignment, PrimitivesThatShareATable) {
  Fixture fixture(torus(20, 20));
  fixture.primitive_table = {0, 0};
  for (std::uint32_t f = 0; f < fixture.surface.faceCount(); ++f) fixture.input.face_primitive[f] = f >= 400;
  const Coded coded = roundTrip(fixture);
  EXPECT_TRUE(coded.counts.one_vertex_per_position);
  EXPECT_LT(coded.bits / 800, 0.4);
}

TEST(Assignment, ManyPrimitives) {
  Fixture fixture(torus(20, 20));
  fixture.primitive_table.assign(400, 0);
  for (std::uint32_t f = 0; f < fixture.surface.faceCount(); ++f) fixture.input.face_primitive[f] = f * 7 % 400;
  roundTrip(fixture);
}

TEST(Assignment, SideFaces) {
  for (const bool seams : {false, true}) {
    Fixture fixture(sheet());
    fixture.primitive_table = {0, 0};
    if (seams) fixture.separate(3);
    auto& faces = fixture.input.side_faces;
    faces.push_back({0, {1, 2, 0}});  // a duplicate
    faces.push_back({1, {0, 0, 1}});  // degenerate ones
    faces.push_back({1, {3, 3, 3}});
    const std::uint32_t a = fixture.addVertex(0, 4), b = fixture.addVertex(0, 5);
    faces.push_back({0, {a, b, a}});
    if (seams) faces.push_back({1, {fixture.addVertex(0, 4), fixture.addVertex(0, 1), fixture.addVertex(0, 0)}});
    if (seams) faces.push_back({1, {fixture.addVertex(0, 0), fixture.addVertex(0, 1), fixture.addVertex(0, 2)}});
    const Coded coded = roundTrip(fixture);
    EXPECT_EQ(coded.counts.one_vertex_per_position, !seams);
    EXPECT_EQ(coded.order.extra_positions.size(), 2u);
  }
}

TEST(Assignment, DuplicatesOfAWholeMeshAreCheap) {
  Fixture fixture(torus(30, 30));
  fixture.primitive_table = {0, 0};
  for (std::uint32_t f = 0; f < fixture.surface.faceCount(); ++f) {
    const std::uint32_t* v = &fixture.surface.corner_vertex[3 * f];
    fixture.input.side_faces.push_back({1, {v[f % 3], v[(f + 1) % 3], v[(f + 2) % 3]}});
  }
  EXPECT_LT(roundTrip(fixture).bits / 1800, 0.2);
}

TEST(Assignment, UnusedVertices) {
  for (const bool repeated : {false, true}) {
    Fixture fixture(tetrahedron());
    for (std::uint32_t w = 4; w < 9; ++w) fixture.addVertex(0, w);
    if (repeated) {
      for (std::uint32_t w = 2; w < 9; ++w) fixture.addVertex(0, w);
      fixture.addTable();
      fixture.addVertex(1, 9);
    }
    const Coded coded = roundTrip(fixture);
    EXPECT_EQ(coded.counts.one_vertex_per_position, !repeated);
    EXPECT_EQ(coded.order.extra_positions.size(), repeated ? 6u : 5u);
  }
}

TEST(Assignment, NoSurfaceAtAll) {
  Fixture fixture((Surface()));
  roundTrip(fixture);
  fixture.primitive_table = {0, 1};
  fixture.addTable();
  const std::uint32_t a = fixture.addVertex(0, 0), b = fixture.addVertex(1, 0);
  fixture.input.side_faces = {{1, {b, b, b}}, {0, {a, a, a}}};
  roundTrip(fixture);
}

/// Random in every respect.
Fixture randomFixture(std::mt19937& random) {
  const std::uint32_t width = 3 + random() % 6, height = 3 + random() % 6;
  Fixture fixture(random() % 2 ? torus(width, height) : grid(width, height));
  if (random() % 3 == 0) {
    for (auto& w : fixture.vertex_welded) {
      if (w != kNone && random() % 4 == 0) w = random() % (w + 1);
    }
  }
  const std::uint32_t table_count = 1 + random() % 3, primitive_count = table_count + random() % 4;
  fixture.primitive_table.clear();
  for (std::uint32_t p = 0; p < primitive_count; ++p) fixture.primitive_table.push_back(random() % table_count);
  fixture.input.table_welded.assign(table_count, {});
  std::vector<std::vector<std::vector<std::uint32_t>>> at(
      table_count, std::vector<std::vector<std::uint32_t>>(fixture.welded_count));
  const auto pick = [&](std::uint32_t table, std::uint32_t welded, std::uint32_t new_one_in) {
    auto& list = at[table][welded];
    if (list.empty() || random() % new_one_in == 0) list.push_back(fixture.addVertex(table, welded));
    return list[random() % list.size()];
  };
  const std::uint32_t new_one_in = 1 + random() % 10, change_one_in = 1 + random() % 30;
  std::uint32_t primitive = 0;
  for (std::uint32_t f = 0; f < fixture.surface.faceCount(); ++f) {
    if (fixture.input.face_primitive[f] == kNone) continue;
    if (random() % change_one_in == 0) primitive = random() % primitive_count;
    fixture.input.face_primitive[f] = primitive;
    for (std::uint32_t c = 3 * f; c < 3 * f + 3; ++c) {
      fixture.input.corner_vertex[c] = pick(fixture.primitive_table[primitive], fixture.weldedAt(c), new_one_in);
    }
  }
  for (std::uint32_t i = random() % 12; i > 0; --i) {
    AssignmentInput::SideFace face;
    face.primitive = random() % primitive_count;
    for (auto& v : face.table_vertex) {
      v = pick(fixture.primitive_table[face.primitive], random() % fixture.welded_count, new_one_in);
    }
    fixture.input.side_faces.push_back(face);
  }
  for (std::uint32_t i = random() % 12; i > 0; --i) {
    fixture.addVertex(random() % table_count, random() % (fixture.welded_count + 2));
  }
  return fixture;
}

TEST(Assignment, RandomInputsComeBack) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 500; ++trial) {
    SCOPED_TRACE(trial);
    const Fixture fixture = randomFixture(random);
    roundTrip(fixture);
    // Any positions do, degenerate and extreme ones too.
    std::vector<glm::ivec3> positions(fixture.surface.vertexCount());
    const std::int32_t range = 1 << (trial % 29);
    for (auto& p : positions) {
      for (int k = 0; k < 3; ++k) p[k] = static_cast<std::int32_t>(random() % (2 * range + 1)) - range;
    }
    roundTrip(fixture, positions);
    ASSERT_FALSE(HasFailure());
  }
}

TEST(Assignment, ManyVerticesAtOnePosition) {
  // More than the list of candidates holds, so that the escape is needed.
  Fixture fixture(torus(20, 20));
  std::fill(fixture.vertex_welded.begin(), fixture.vertex_welded.end(), 0);
  std::mt19937 random(4);
  fixture.input.table_welded[0].assign(100, 0);
  for (auto& v : fixture.input.corner_vertex) v = random() % 100;
  roundTrip(fixture);
}

bool isStreamError(const Error& error) {
  return error.code == ErrorCode::kTruncated || error.code == ErrorCode::kInvalidSymbol ||
         error.code == ErrorCode::kInvalidCount;
}

void checkConsistent(const Assignment::Counts& counts, const Assignment& assignment) {
  for (std::size_t t = 0; t < counts.table_vertex_count.size(); ++t) {
    const std::vector<std::uint32_t> positions = positionsOf(assignment, t, counts.table_vertex_count[t]);
    ASSERT_EQ(positions.size(), counts.table_vertex_count[t]);
    for (const std::uint32_t position : positions) ASSERT_LT(position, assignment.position_count);
  }
  for (std::size_t p = 0; p < counts.primitive_table.size(); ++p) {
    ASSERT_EQ(assignment.primitive_indices[p].size(), 3 * std::size_t{counts.primitive_face_count[p]});
    for (const std::uint32_t v : assignment.primitive_indices[p]) {
      ASSERT_LT(v, counts.table_vertex_count[counts.primitive_table[p]]);
    }
  }
}

TEST(Assignment, HostileBytesEndInAnErrorOrInAConsistentResult) {
  std::mt19937 random(5);
  int errors = 0;
  for (int trial = 0; trial < 400; ++trial) {
    Fixture fixture = randomFixture(random);
    const PositionMap map = numberPositions(fixture.vertex_welded, fixture.welded_count, fixture.input.welded_position);
    Assignment::Counts counts = countAssignment(fixture.input, fixture.primitive_table);
    EntropyWriter writer;
    Assignment assignment;
    encodeAssignment(fixture.surface, map, {}, fixture.input, counts, writer, assignment);
    std::vector<std::byte> good;
    writer.finish(0, good);
    for (int attack = 0; attack < 20; ++attack) {
      std::vector<std::byte> bytes = good;
      Assignment::Counts claimed = counts;
      if (attack % 4 == 0) bytes.resize(random() % bytes.size());
      if (attack % 4 == 1) bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 << random() % 8);
      if (attack % 4 == 2) std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<std::byte>(random()); });
      if (attack % 4 == 3) {
        claimed.table_vertex_count[random() % claimed.table_vertex_count.size()] = random() % 300;
        claimed.primitive_face_count[random() % claimed.primitive_face_count.size()] += random() % 40 - 20;
        claimed.one_vertex_per_position = random() % 4 == 0;
      }
      for (auto& count : claimed.primitive_face_count) count = std::min(count, 1000u);
      EntropyReader reader(bytes);
      Assignment decoded;
      const Status status = decodeAssignment(Surface(fixture.surface), map, {}, claimed, reader, decoded);
      if (status) {
        ++errors;
        EXPECT_TRUE(isStreamError(*status)) << status->where;
      } else {
        checkConsistent(claimed, decoded);
      }
    }
  }
  EXPECT_GT(errors, 0);
}

}  // namespace
}  // namespace tsc::test
