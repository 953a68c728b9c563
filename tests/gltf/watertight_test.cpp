// Thousands of closed meshes cut at random into primitives, with seams: whatever was at one place before is at one
// place, bit for bit, after.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <random>

#include "assets.h"
#include "compare_assets.h"

namespace tsc::test {
namespace {

using Position = std::array<float, 3>;
using Triangle = std::array<std::uint32_t, 3>;

struct ClosedMesh {
  std::vector<Position> vertices;
  std::vector<Triangle> triangles;
};

/// The same numbers on every platform, which the distributions of <random> do not give.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(engine_() % n); }
  bool chance(std::uint32_t percent) { return below(100) < percent; }
  float unit() { return static_cast<float>(engine_() % 65537) / 65536.0F; }

 private:
  std::mt19937 engine_;
};

/// A torus of n times m quads, cut into triangles; its vertices jittered.
ClosedMesh torus(std::uint32_t n, std::uint32_t m, Random& random) {
  ClosedMesh mesh;
  constexpr float kTurn = 6.2831853F;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < m; ++j) {
      const float u = kTurn * static_cast<float>(i) / static_cast<float>(n);
      const float v = kTurn * static_cast<float>(j) / static_cast<float>(m);
      const float radius = 2 + std::cos(v) + 0.1F * random.unit();
      mesh.vertices.push_back({radius * std::cos(u), radius * std::sin(u), std::sin(v)});
      const std::uint32_t a = i * m + j, b = (i + 1) % n * m + j;
      const std::uint32_t c = i * m + (j + 1) % m, d = (i + 1) % n * m + (j + 1) % m;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({c, b, d});
    }
  }
  return mesh;
}

/// An octahedron, its faces quartered `levels` times and its vertices pushed out to a bumpy sphere.
ClosedMesh sphere(int levels, Random& random) {
  ClosedMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [entry, added] = middles.emplace(std::minmax(a, b), mesh.vertices.size());
      if (added) {
        const float scale = 0.6F + 0.1F * random.unit();
        const Position p = mesh.vertices[a], q = mesh.vertices[b];
        mesh.vertices.push_back({scale * (p[0] + q[0]), scale * (p[1] + q[1]), scale * (p[2] + q[2])});
      }
      return entry->second;
    };
    std::vector<Triangle> quartered;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      quartered.insert(quartered.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(quartered);
  }
  return mesh;
}

ClosedMesh randomMesh(Random& random) {
  ClosedMesh mesh = random.chance(50) ? torus(3 + random.below(5), 3 + random.below(5), random)
                                      : sphere(static_cast<int>(random.below(3)), random);
  const float scale = std::ldexp(1.0F, static_cast<int>(random.below(24)) - 12);
  const float offset = random.chance(30) ? 6378137.0F : random.unit();
  for (Position& position : mesh.vertices) {
    for (float& value : position) value = value * scale + (random.chance(98) ? offset : 0);
  }
  // Non-manifold and worse, now and then: vertices in one place, a pinched vertex, zeros of both signs.
  if (random.chance(30)) mesh.vertices[random.below(4)] = mesh.vertices[5];
  if (random.chance(20)) {
    mesh.vertices[0] = {0.0F, 1.0F, -0.0F};
    mesh.vertices[1] = {-0.0F, 1.0F, 0.0F};
  }
  if (random.chance(20)) mesh.triangles.push_back(mesh.triangles[random.below(4)]);
  return mesh;
}

/// Which primitive each triangle goes to: at random, or by where it lies, so that borders are long or short.
std::vector<std::uint32_t> randomCut(const ClosedMesh& mesh, std::uint32_t parts, Random& random) {
  std::vector<std::uint32_t> part_of(mesh.triangles.size());
  const bool by_place = random.chance(50);
  const std::uint32_t axis = random.below(3);
  for (std::size_t t = 0; t < part_of.size(); ++t) {
    const bool left = mesh.vertices[mesh.triangles[t][0]][axis] < mesh.vertices[mesh.triangles[t][1]][axis];
    part_of[t] = by_place ? (left ? 0 : parts - 1) : random.below(parts);
  }
  return part_of;
}

/// A vertex table under construction: seams give one vertex of the mesh several entries.
class SeamedTable {
 public:
  SeamedTable(const ClosedMesh& mesh, std::uint32_t seam_percent, Random& random)
      : mesh_(mesh), seam_percent_(seam_percent), random_(random) {}

  std::uint32_t entryFor(std::uint32_t vertex) {
    const auto [first, last] = entries_.equal_range(vertex);
    if (first != last && !random_.chance(seam_percent_)) return first->second;
    const Position& position = mesh_.vertices[vertex];
    const auto entry = static_cast<std::uint32_t>(xyz_.size() / 3);
    xyz_.insert(xyz_.end(), position.begin(), position.end());
    entries_.emplace(vertex, entry);
    return entry;
  }

  const std::vector<float>& xyz() const { return xyz_; }

 private:
  const ClosedMesh& mesh_;
  const std::uint32_t seam_percent_;
  Random& random_;
  std::multimap<std::uint32_t, std::uint32_t> entries_;
  std::vector<float> xyz_;
};

/// The mesh as glTF: one or more primitives, over one table or over one each, indexed or not.
Asset cutAsset(const ClosedMesh& mesh, Random& random) {
  const std::uint32_t parts = 1 + random.below(4);
  const std::vector<std::uint32_t> part_of = randomCut(mesh, parts, random);
  const bool shared_table = random.chance(40);
  const bool indexed = shared_table || random.chance(80);
  const std::uint32_t seam_percent = indexed ? std::array{0U, 10U, 50U}[random.below(3)] : 100;
  AssetBuilder builder;
  Json primitives = Json::array();
  SeamedTable shared(mesh, seam_percent, random);
  std::vector<std::vector<std::uint32_t>> shared_indices;
  for (std::uint32_t part = 0; part < parts; ++part) {
    SeamedTable own(mesh, seam_percent, random);
    SeamedTable& table = shared_table ? shared : own;
    std::vector<std::uint32_t> indices;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (part_of[t] != part) continue;
      for (const std::uint32_t vertex : mesh.triangles[t]) indices.push_back(table.entryFor(vertex));
    }
    if (indices.empty()) continue;
    if (shared_table) {
      shared_indices.push_back(std::move(indices));
      continue;
    }
    Json primitive = {{"attributes", {{"POSITION", builder.addPositions(own.xyz())}}}};
    if (indexed) primitive["indices"] = builder.addIndices16(indices);
    primitives.push_back(std::move(primitive));
  }
  if (shared_table) {
    const std::size_t position = builder.addPositions(shared.xyz());
    for (const std::vector<std::uint32_t>& indices : shared_indices) {
      primitives.push_back({{"attributes", {{"POSITION", position}}}, {"indices", builder.addIndices16(indices)}});
    }
  }
  builder.addMesh(primitives);
  return builder.build();
}

PackOptions randomOptions(Random& random) {
  PackOptions options;
  // As coarse as it gets too: where a whole mesh falls onto few lattice points, what is equal must stay so.
  options.precision = {Precision::Kind::kPositionBits, static_cast<double>(2 + random.below(14))};
  options.mode = std::array{Mode::kAuto, Mode::kLattice, Mode::kTangent, Mode::kTangent}[random.below(4)];
  options.basis = std::array{Basis::kAuto, Basis::kGate, Basis::kTip}[random.below(3)];
  options.predictor = std::array{Predictor::kAuto,    Predictor::kParallelogram, Predictor::kWeighted,
                                 Predictor::kValence, Predictor::kAverage,       Predictor::kAdaptive}[random.below(6)];
  options.order = std::array{Order::kAuto, Order::kTraversal, Order::kDegree}[random.below(3)];
  options.normal_scale = 1 + random.below(3);
  options.keep_order = random.chance(20);
  return options;
}

using Bits = std::array<std::uint32_t, 3>;
Bits bitsOf(const Position& position) {
  return {std::bit_cast<std::uint32_t>(position[0]), std::bit_cast<std::uint32_t>(position[1]),
          std::bit_cast<std::uint32_t>(position[2])};
}

/// Packs and unpacks: vertices at equal places before must be at equal places, bit for bit, after. `pairs` counts them.
void expectNothingCracked(const Asset& asset, const PackOptions& options, std::uint64_t& pairs) {
  // The vertices' numbers, carried along as an attribute, tell afterwards which is which.
  Asset numbered = asset;
  addVertexIds(numbered);
  Asset back = numbered;
  const Expected<PackReport> report = packAsset(back, options);
  ASSERT_TRUE(report) << report.failure().message;
  ASSERT_EQ(report->streams.size(), 1U);
  ASSERT_TRUE(report->kept.empty());
  const Outcome outcome = unpackAsset(back);
  ASSERT_FALSE(outcome) << outcome->message;
  const std::vector<PrimitiveContent> before = contentOf(numbered), after = contentOf(back);
  ASSERT_EQ(before.size(), after.size());
  std::map<Position, Bits> places;
  for (std::size_t p = 0; p < before.size(); ++p) {
    ASSERT_EQ(before[p].triangles, after[p].triangles);
    for (const auto& [id, position] : before[p].positions) {
      const Bits bits = bitsOf(after[p].positions.at(id));
      // Zeros of both signs are equal, and so one key.
      const auto [place, added] = places.emplace(position, bits);
      if (!added) ++pairs;
      ASSERT_EQ(place->second, bits) << "vertex " << id << " of primitive " << p;
    }
  }
}

void expectNothingCracksInRounds(std::uint32_t first, std::uint32_t last) {
  std::uint64_t pairs = 0;
  for (std::uint32_t round = first; round < last; ++round) {
    Random random(round);
    const ClosedMesh mesh = randomMesh(random);
    const Asset asset = cutAsset(mesh, random);
    expectNothingCracked(asset, randomOptions(random), pairs);
    if (testing::Test::HasFatalFailure()) FAIL() << "round " << round;
  }
  EXPECT_GT(pairs, 10 * (last - first));  // there was something to crack
}

TEST(Watertight, RandomCutsOfClosedMeshes) { expectNothingCracksInRounds(0, 5000); }

TEST(WatertightLong, RandomCutsOfClosedMeshes) { expectNothingCracksInRounds(5000, 60000); }

}  // namespace
}  // namespace tsc::test
