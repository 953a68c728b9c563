// A Laplacian baseline.
#include "laplacian.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <deque>
#include <stdexcept>

#include "entropy.h"
#include "models.h"

namespace tsc::bench {

namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

constexpr std::size_t kVerticesPerAnchor = 200;

/// Neighbours of each vertex, each once.
std::vector<std::vector<std::uint32_t>> neighbours(const BenchMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> lists(mesh.vertexCount());
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = mesh.indices[i + c], b = mesh.indices[i + (c + 1) % 3];
      if (a == b) continue;
      lists[a].push_back(b);
      lists[b].push_back(a);
    }
  }
  for (auto& list : lists) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return lists;
}

/// Vertices breadth first, component by component. An anchor is every 200th, and the first of each component: both
/// sides know them from the connectivity.
struct Traversal {
  std::vector<std::uint32_t> order, anchors;

  explicit Traversal(const std::vector<std::vector<std::uint32_t>>& lists) {
    std::vector<bool> seen(lists.size());
    for (std::uint32_t seed = 0; seed < lists.size(); ++seed) {
      if (seen[seed]) continue;
      seen[seed] = true;
      std::deque<std::uint32_t> queue{seed};
      for (std::size_t count = 0; !queue.empty(); ++count) {
        const std::uint32_t vertex = queue.front();
        queue.pop_front();
        order.push_back(vertex);
        if (count % kVerticesPerAnchor == 0) anchors.push_back(vertex);
        for (const std::uint32_t next : lists[vertex]) {
          if (seen[next]) continue;
          seen[next] = true;
          queue.push_back(next);
        }
      }
    }
  }
};

}  // namespace

struct LaplacianCodec::System {
  explicit System(const BenchMesh& source) : mesh(source), lists(neighbours(source)), traversal(lists) {}

  const BenchMesh& mesh;
  std::vector<std::vector<std::uint32_t>> lists;
  Traversal traversal;
  SparseMatrix laplacian;
  Eigen::SimplicialLDLT<SparseMatrix> solver;
  double connectivity_bits = 0;
};

LaplacianCodec::LaplacianCodec(const BenchMesh& mesh) : system_(std::make_unique<System>(mesh)) {
  const auto n = static_cast<Eigen::Index>(mesh.vertexCount());
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    const auto row = static_cast<int>(v);
    if (!system_->lists[v].empty()) entries.emplace_back(row, row, 1.0);
    for (const std::uint32_t other : system_->lists[v]) {
      entries.emplace_back(row, static_cast<int>(other), -1.0 / double(system_->lists[v].size()));
    }
  }
  system_->laplacian.resize(n, n);
  system_->laplacian.setFromTriplets(entries.begin(), entries.end());
  entries.clear();
  for (const std::uint32_t anchor : system_->traversal.anchors) {
    entries.emplace_back(static_cast<int>(anchor), static_cast<int>(anchor), 1.0);
  }
  SparseMatrix normal(n, n);
  normal.setFromTriplets(entries.begin(), entries.end());
  normal += SparseMatrix(system_->laplacian.transpose()) * system_->laplacian;
  system_->solver.compute(normal);
  if (system_->solver.info() != Eigen::Success) throw std::runtime_error(mesh.name + ": Laplacian system is singular");

  EncodeOptions options;
  options.mode = Mode::kLattice;
  options.step = stepForBits(codecMesh(mesh), 8);
  const auto result = encode(codecMesh(mesh), options);
  if (!result) throw std::runtime_error(mesh.name + ": " + describe(result.error()));
  system_->connectivity_bits = 8.0 * double(result->bytes.size()) - result->bits.positions;
}

LaplacianCodec::~LaplacianCodec() = default;

CodecPoint LaplacianCodec::run(double step) const {
  const BenchMesh& mesh = system_->mesh;
  const auto n = static_cast<Eigen::Index>(mesh.vertexCount());
  Columns positions(n, 3);
  for (Eigen::Index v = 0; v < n; ++v) {
    for (Eigen::Index c = 0; c < 3; ++c) positions(v, c) = mesh.positions[static_cast<std::size_t>(3 * v + c)];
  }
  Columns offsets = system_->laplacian * positions;
  Columns right_side;

  EntropyWriter writer;
  IntegerModel offset_models[3], anchor_models[3];
  const auto code = [&](double value, IntegerModel& model, std::int64_t prediction = 0) {
    const std::int64_t quantized = std::llround(value / step);
    const std::int64_t residual = std::clamp<std::int64_t>(quantized - prediction, -(1 << 28), 1 << 28);
    model.put(writer, zigzag(static_cast<std::int32_t>(residual)));
    return quantized;
  };
  for (const std::uint32_t v : system_->traversal.order) {
    for (int c = 0; c < 3; ++c) offsets(v, c) = double(code(offsets(v, c), offset_models[c])) * step;
  }
  right_side = system_->laplacian.transpose() * offsets;
  std::int64_t previous[3] = {};
  for (const std::uint32_t v : system_->traversal.anchors) {
    for (int c = 0; c < 3; ++c) {
      previous[c] = code(positions(v, c), anchor_models[c], previous[c]);
      right_side(v, c) += double(previous[c]) * step;
    }
  }
  const Columns solution = system_->solver.solve(right_side);

  CodecPoint point;
  point.step = step;
  point.parts.connectivity = system_->connectivity_bits;
  point.parts.positions = writer.bitsSince(0);
  point.bits = point.parts.connectivity + point.parts.positions;
  point.positions.resize(mesh.positions.size());
  for (Eigen::Index v = 0; v < n; ++v) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      point.positions[static_cast<std::size_t>(3 * v + c)] = static_cast<float>(solution(v, c));
    }
  }
  point.mse = meanSquaredError(mesh.positions, point.positions);
  return point;
}

}  // namespace tsc::bench
