// The paper's codec as a model in double precision.
#include "plane_model.h"

#include <cmath>
#include <deque>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <stdexcept>
#include <unordered_map>

namespace tsc::bench {

namespace {

/// Zero-order entropy of a sequence, in bits for all of it.
class Histogram {
 public:
  void add(double value) {
    ++counts_[value];
    ++total_;
  }
  double bits() const {
    double sum = 0;
    for (const auto& [value, count] : counts_) sum -= double(count) * std::log2(double(count) / double(total_));
    return sum;
  }

 private:
  std::map<double, std::size_t> counts_;
  std::size_t total_ = 0;
};

class Run {
 public:
  Run(const BenchMesh& mesh, const PaperModel& model, double step)
      : mesh_(mesh), model_(model), step_(step), decoded_(mesh.vertexCount()), known_(mesh.vertexCount()) {
    for (std::uint32_t i = 0; i < mesh.indices.size(); ++i) corner_of_edge_[edgeKey(i)] = i;
  }

  /// Bits of all residuals.
  double code() {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t vertex = mesh_.indices[c];
      decoded_[vertex] = original(vertex);
      if (!model_.exact_start) decoded_[vertex] = glm::round(decoded_[vertex] / step_) * step_;
      decoded_[vertex] = onLattice(decoded_[vertex]);
      known_[vertex] = true;
    }
    std::vector<bool> face_done(mesh_.faceCount());
    face_done[0] = true;
    std::deque<std::uint32_t> gates = {0, 1, 2};  // corners whose edge to the next corner is open
    std::size_t coded = 3;
    while (!gates.empty()) {
      const std::uint32_t gate = gates.front();
      gates.pop_front();
      const auto across = corner_of_edge_.find(edgeKey(gate, true));
      if (across == corner_of_edge_.end() || face_done[across->second / 3]) continue;
      face_done[across->second / 3] = true;
      const std::uint32_t after = next(across->second), tip = mesh_.indices[next(after)];
      if (!known_[tip]) {
        codeVertex(tip, mesh_.indices[gate], mesh_.indices[next(gate)], mesh_.indices[next(next(gate))]);
        ++coded;
      }
      gates.push_back(after);
      gates.push_back(next(after));
    }
    if (coded != mesh_.vertexCount()) throw std::runtime_error(mesh_.name + ": not one edge-connected part");
    constexpr double kStartBits = 3 * 96;
    return kStartBits + residuals_[0].bits() + residuals_[1].bits() + residuals_[2].bits();
  }

  std::vector<float> positions() const {
    std::vector<float> positions;
    for (const glm::dvec3& p : decoded_) {
      for (int c = 0; c < 3; ++c) positions.push_back(static_cast<float>(p[c]));
    }
    return positions;
  }

 private:
  static std::uint32_t next(std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
  std::uint64_t edgeKey(std::uint32_t corner, bool reversed = false) const {
    const std::uint64_t from = mesh_.indices[corner], to = mesh_.indices[next(corner)];
    return reversed ? to << 32 | from : from << 32 | to;
  }
  glm::dvec3 original(std::uint32_t vertex) const {
    const float* p = &mesh_.positions[3 * std::size_t{vertex}];
    return {p[0], p[1], p[2]};
  }
  glm::dvec3 onLattice(const glm::dvec3& p) const {
    const double cell = std::ldexp(step_, -model_.lattice_bits);
    return model_.lattice_bits > 0 ? glm::round(p / cell) * cell : p;
  }

  void codeVertex(std::uint32_t tip, std::uint32_t left, std::uint32_t right, std::uint32_t base) {
    const glm::dvec3 &l = decoded_[left], &r = decoded_[right], &b = decoded_[base];
    const glm::dvec3 prediction = l + r - b;
    const glm::dvec3 normal = glm::normalize(glm::cross(l - r, b - r));
    const glm::dvec3 second = glm::normalize(glm::cross(normal, prediction - b));
    const glm::dvec3 axes[3] = {normal, glm::cross(second, normal), second};
    const double steps[3] = {step_ / model_.normal_scale, step_, step_};
    glm::dvec3 position = prediction;
    for (int k = 0; k < 3; ++k) {
      const double residual = std::round(glm::dot(original(tip) - prediction, axes[k]) / steps[k]) + 0.0;
      residuals_[k].add(residual);
      position += residual * steps[k] * axes[k];
    }
    decoded_[tip] = onLattice(position);
    known_[tip] = true;
  }

  const BenchMesh& mesh_;
  const PaperModel model_;
  const double step_;
  std::vector<glm::dvec3> decoded_;
  std::vector<bool> known_;
  std::unordered_map<std::uint64_t, std::uint32_t> corner_of_edge_;  // directed edge -> the corner that it starts at
  Histogram residuals_[3];                                           // normal, tangential, tangential
};

}  // namespace

StepCodec makePaperModel(const BenchMesh& mesh, const PaperModel& model) {
  EncodeOptions options;
  options.mode = Mode::kLattice;
  options.step = stepForBits(codecMesh(mesh), 8);
  const auto result = encode(codecMesh(mesh), options);
  if (!result) throw std::runtime_error(mesh.name + ": " + describe(result.error()));
  const double other_bits = 8.0 * double(result->bytes.size()) - result->bits.positions;
  return [&mesh, model, other_bits](double step) {
    Run run(mesh, model, step);
    CodecPoint point;
    point.step = step;
    point.parts.connectivity = other_bits;
    point.parts.positions = run.code();
    point.bits = other_bits + point.parts.positions;
    point.positions = run.positions();
    point.mse = meanSquaredError(mesh.positions, point.positions);
    return point;
  };
}

}  // namespace tsc::bench
