// Prints one line per mesh and option set: a name, the hash of the packed bytes and the hash of the decoded bits.
// cross_compilers.sh builds it with several compilers for several processors and compares the lines with hashes.txt.
//
// Meshes are made with integer arithmetic alone, so that no difference can come from here.
#include <array>
#include <cinttypes>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "tsc/codec.h"

namespace {

/// FNV-1a.
std::uint64_t hash(std::span<const std::byte> bytes, std::uint64_t state = 0xCBF29CE484222325u) {
  for (const std::byte byte : bytes) state = (state ^ static_cast<std::uint64_t>(byte)) * 0x100000001B3u;
  return state;
}

/// A linear congruential generator; the upper bits only.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::int32_t below(std::int32_t limit) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::int32_t>((state_ >> 33) % static_cast<std::uint64_t>(limit));
  }

 private:
  std::uint64_t state_;
};

struct Shape {
  const char* name;
  std::vector<float> positions;
  std::vector<std::vector<std::uint32_t>> primitives;
};

/// Integer to position: exact in float, whatever the rounding.
void addPoint(Shape& shape, std::int64_t x, std::int64_t y, std::int64_t z) {
  for (const std::int64_t value : {x, y, z}) shape.positions.push_back(static_cast<float>(value) / 4096);
}

/// A parabolic wave over a grid, in two primitives that meet along a line; `roughness` in units of 1/4096.
Shape terrain(const char* name, int side, int roughness) {
  Shape shape = {name, {}, {{}, {}}};
  Random random(7);
  for (int i = 0; i <= side; ++i) {
    for (int j = 0; j <= side; ++j) {
      const std::int64_t x = i * 300 + random.below(60), y = j * 300 + random.below(60);
      const std::int64_t a = x % 4000 - 2000, b = y % 6000 - 3000;
      addPoint(shape, x, y, a * a / 4000 + b * b / 9000 + random.below(roughness + 1));
    }
  }
  const auto row = static_cast<std::uint32_t>(side + 1);
  for (std::uint32_t i = 0; i + 1 < row; ++i) {
    for (std::uint32_t j = 0; j + 1 < row; ++j) {
      const std::uint32_t a = i * row + j, b = a + 1, c = a + row, d = c + 1;
      auto& indices = shape.primitives[i * 3 < row ? 0 : 1];
      if (random.below(2) == 0) {
        indices.insert(indices.end(), {a, c, b, b, c, d});
      } else {
        indices.insert(indices.end(), {a, c, d, a, d, b});
      }
    }
  }
  return shape;
}

/// An octahedron split again and again, pushed towards a ball by integer square roots: closed and smooth.
Shape ball(int levels) {
  using Point = std::array<std::int64_t, 3>;
  constexpr std::int64_t kRadius = 1 << 20;
  Shape shape = {"ball", {}, {{}}};
  std::vector<Point> points = {{kRadius, 0, 0},  {-kRadius, 0, 0}, {0, kRadius, 0},
                               {0, -kRadius, 0}, {0, 0, kRadius},  {0, 0, -kRadius}};
  std::vector<std::uint32_t> indices = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
  const auto push = [&](Point p) {
    const std::int64_t square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    std::int64_t length = kRadius;
    for (int i = 0; i < 40; ++i) length = (length + square / length) / 2;
    for (std::int64_t& coordinate : p) coordinate = coordinate * kRadius / length;
    return p;
  };
  // Corners are not shared between triangles: the codec welds equal positions.
  for (int level = 0; level < levels; ++level) {
    std::vector<std::uint32_t> finer;
    for (std::size_t t = 0; t < indices.size(); t += 3) {
      std::array<std::uint32_t, 6> corner = {indices[t], indices[t + 1], indices[t + 2], 0, 0, 0};
      for (int k = 0; k < 3; ++k) {
        const Point &a = points[corner[k]], &b = points[corner[(k + 1) % 3]];
        corner[3 + k] = static_cast<std::uint32_t>(points.size());
        points.push_back(push({a[0] + b[0], a[1] + b[1], a[2] + b[2]}));
      }
      for (const int i : {0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5}) finer.push_back(corner[i]);
    }
    indices = std::move(finer);
  }
  for (const Point& p : points) addPoint(shape, p[0] / 64, p[1] / 48, p[2] / 80);
  shape.primitives[0] = std::move(indices);
  return shape;
}

/// Random triangles over few points: edges of many faces, degenerate and duplicate triangles, unused vertices.
Shape soup() {
  Shape shape = {"soup", {}, {{}, {}}};
  Random random(11);
  for (int i = 0; i < 200; ++i) {
    // One statement each: the order in which arguments are evaluated is the compiler's choice.
    const std::int32_t x = random.below(40) * 64;
    const std::int32_t y = random.below(40) * 64;
    const std::int32_t z = random.below(40) * 64;
    addPoint(shape, x, y, z);
  }
  for (int i = 0; i < 2400; ++i) {
    shape.primitives[i < 1500 ? 0 : 1].push_back(static_cast<std::uint32_t>(random.below(190)));
  }
  return shape;
}

/// Long thin strips between flat and steep faces, as machine parts have.
Shape part() {
  Shape shape = {"part", {}, {{}}};
  for (int i = 0; i < 200; ++i) {
    const std::int64_t x = i * 37 + (i % 7) * 3, high = (i / 20) % 2 * 5000;
    addPoint(shape, x, 0, high);
    addPoint(shape, x, 40000, high);
  }
  for (std::uint32_t i = 0; i + 2 < 400; i += 2) {
    auto& indices = shape.primitives[0];
    indices.insert(indices.end(), {i, i + 2, i + 1, i + 1, i + 2, i + 3});
  }
  return shape;
}

struct Variant {
  const char* name;
  int bits;
  tsc::EncodeOptions options;
};

std::vector<Variant> variants() {
  using namespace tsc;
  std::vector<Variant> result = {{"auto-10", 10, {}}, {"auto-14", 14, {}}};
  EncodeOptions paper;
  paper.mode = Mode::kTangent;
  paper.predictor = Predictor::kWeighted;
  paper.basis = Basis::kTip;
  paper.order = Order::kTraversal;
  paper.normal_scale = 2;
  result.push_back({"paper-12", 12, paper});
  EncodeOptions gate = paper;
  gate.basis = Basis::kGate;
  gate.predictor = Predictor::kValence;
  gate.order = Order::kDegree;
  gate.normal_scale = 1;
  result.push_back({"gate-valence-degree-14", 14, gate});
  EncodeOptions lattice;
  lattice.mode = Mode::kLattice;
  for (const auto& [name, predictor] : {std::pair{"lattice-parallelogram-11", Predictor::kParallelogram},
                                        {"lattice-average-11", Predictor::kAverage},
                                        {"lattice-adaptive-11", Predictor::kAdaptive}}) {
    lattice.predictor = predictor;
    result.push_back({name, 11, lattice});
  }
  EncodeOptions anchored;
  anchored.anchored = true;
  result.push_back({"anchored-13", 13, anchored});
  EncodeOptions most;
  most.effort = Effort::kMax;
  result.push_back({"effort-max-12", 12, most});
  return result;
}

/// Empty if all is well, else what failed.
std::string run(const Shape& shape, const Variant& variant) {
  tsc::Mesh mesh;
  mesh.tables.push_back({shape.positions});
  for (const auto& indices : shape.primitives) mesh.primitives.push_back({.table = 0, .indices = indices});
  tsc::EncodeOptions options = variant.options;
  options.step = tsc::stepForBits(mesh, variant.bits);
  const auto encoded = tsc::encode(mesh, options);
  if (!encoded) return tsc::describe(encoded.error());
  const auto decoded = tsc::decode(encoded->bytes);
  if (!decoded) return tsc::describe(decoded.error());
  std::uint64_t bits = hash({});
  for (const auto& output : *decoded) bits = hash(output, bits);
  std::printf("%s %s %zu %016" PRIx64 " %016" PRIx64 "\n", shape.name, variant.name, encoded->bytes.size(),
              hash(encoded->bytes), bits);
  return {};
}

}  // namespace

int main() {
  for (const Shape& shape : {terrain("smooth", 60, 0), terrain("rough", 40, 900), ball(5), soup(), part()}) {
    for (const Variant& variant : variants()) {
      const std::string fault = run(shape, variant);
      if (fault.empty()) continue;
      std::fprintf(stderr, "%s %s: %s\n", shape.name, variant.name, fault.c_str());
      return 1;
    }
  }
  return 0;
}
