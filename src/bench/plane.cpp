// The paper's Figure 2.
#include "plane.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <stdexcept>

#include "measure.h"
#include "peers.h"
#include "plane_model.h"
#include "tsc/quality.h"

namespace tsc::bench {

namespace {

constexpr double kPi = 3.14159265358979323846;

/// Errors across a plane through the x axis, turned by an angle.
struct PlaneErrors {
  double normal_rms = 0, max_degrees = 0;

  PlaneErrors(const std::vector<float>& positions, const std::vector<std::uint32_t>& indices, double degrees) {
    const double ny = -std::sin(degrees * kPi / 180), nz = std::cos(degrees * kPi / 180);
    double sum = 0;
    for (std::size_t i = 0; i < positions.size(); i += 3) {
      const double height = ny * positions[i + 1] + nz * positions[i + 2];
      sum += height * height;
    }
    normal_rms = std::sqrt(sum / double(positions.size() / 3));
    for (std::size_t f = 0; f < indices.size(); f += 3) {
      double a[3], b[3];
      for (std::size_t c = 0; c < 3; ++c) {
        a[c] = double(positions[3 * indices[f + 1] + c]) - positions[3 * indices[f] + c];
        b[c] = double(positions[3 * indices[f + 2] + c]) - positions[3 * indices[f] + c];
      }
      const double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
      const double across = n[1] * ny + n[2] * nz;
      const double along = std::hypot(n[0], n[1] * nz - n[2] * ny);
      max_degrees = std::max(max_degrees, std::atan2(along, across) * 180 / kPi);
    }
  }
};

/// Vertices of the triangle that decoding starts with, in the numbers of the input.
std::vector<std::uint32_t> firstTriangle(const BenchMesh& mesh, EncodeOptions options, double step) {
  options.step = step;
  const auto result = encode(codecMesh(mesh), options);
  if (!result) throw std::runtime_error(describe(result.error()));
  const std::size_t face = result->triangle_order.at(0).at(0) / 3;
  return {mesh.indices.begin() + static_cast<std::ptrdiff_t>(3 * face),
          mesh.indices.begin() + static_cast<std::ptrdiff_t>(3 * face + 3)};
}

/// The codec on a mesh whose first triangle was rounded to multiples of the step; measured against the true mesh.
StepCodec roundedStartCodec(const BenchMesh& mesh, const Variant& variant) {
  return [&mesh, variant](double step) {
    BenchMesh rounded = mesh;
    for (const std::uint32_t vertex : firstTriangle(mesh, variant.options, step)) {
      for (std::size_t c = 0; c < 3; ++c) {
        float& value = rounded.positions[3 * std::size_t{vertex} + c];
        value = static_cast<float>(std::round(value / step) * step);
      }
    }
    CodecPoint point = makeCodec(rounded, variant)(step);
    point.mse = meanSquaredError(mesh.positions, point.positions);
    return point;
  };
}

class PlaneBench {
 public:
  explicit PlaneBench(const PlaneOptions& options)
      : options_(options),
        mesh_(makePlane(options.side, options.degrees)),
        diagonal_(boundingBoxDiagonal({mesh_.positions, mesh_.indices})) {}

  void addDraco(int level) {
    // The setting whose rate is nearest.
    std::optional<std::pair<int, double>> best;
    for (int bits = 4; bits <= 20; ++bits) {
      const double bpv =
          8.0 * double(encodeDraco(DracoMesh(mesh_), level, bits).bytes.size()) / double(mesh_.vertexCount());
      if (!best || std::abs(bpv - options_.bits_per_vertex) < std::abs(best->second - options_.bits_per_vertex)) {
        best = {bits, bpv};
      }
    }
    fill(rows_.emplace_back(), fmt::format("draco -cl {} -qp {}", level, best->first), best->second,
         dracoGridPositions(mesh_, best->first));
  }

  void add(const std::string& name, const StepCodec& codec) {
    PlaneRow& row = rows_.emplace_back();
    row.codec = name;
    try {
      std::vector<CodecPoint> runs = {codec(stepForBits(codecMesh(mesh_), 11))};
      const CodecPoint& point = pointAtRate(codec, runs, options_.bits_per_vertex * double(mesh_.vertexCount()));
      fill(row, name, point.bits / double(mesh_.vertexCount()), point.positions);
      if (common_step_ == 0) common_step_ = point.step;
      row.bits_per_vertex_at_equal_step = codec(common_step_).bits / double(mesh_.vertexCount());
    } catch (const std::runtime_error& error) {
      row.error = error.what();
    }
  }

  const BenchMesh& mesh() const { return mesh_; }
  const std::vector<PlaneRow>& rows() const { return rows_; }

 private:
  void fill(PlaneRow& row, const std::string& name, double bits_per_vertex, const std::vector<float>& positions) {
    const PlaneErrors errors(positions, mesh_.indices, options_.degrees);
    const Distortion distortion = measureDistortion(mesh_, positions);
    row.codec = name;
    row.bits_per_vertex = bits_per_vertex;
    row.rms = std::sqrt(distortion.mse) / diagonal_;
    row.normal_rms = errors.normal_rms / diagonal_;
    row.dame = distortion.dame;
    row.max_degrees = errors.max_degrees;
  }

  PlaneOptions options_;
  BenchMesh mesh_;
  double diagonal_;
  double common_step_ = 0;
  std::vector<PlaneRow> rows_;
};

}  // namespace

std::vector<PlaneRow> measurePlane(const PlaneOptions& options) {
  PlaneBench bench(options);
  bench.addDraco(7);
  bench.addDraco(10);
  const auto variant = [](const char* name) { return selectVariants(name, Effort::kDefault).front(); };
  bench.add("world space, WP", makeCodec(bench.mesh(), variant("world-wp")));
  bench.add("tangent, first triangle rounded", roundedStartCodec(bench.mesh(), variant("paper-eq7")));
  bench.add("tangent, normal x2, rounded", roundedStartCodec(bench.mesh(), variant("paper-eq7-n2")));
  bench.add("tangent, first triangle exact", makeCodec(bench.mesh(), variant("paper-eq7")));
  bench.add("tangent, normal x2, exact", makeCodec(bench.mesh(), variant("paper-eq7-n2")));
  for (const int lattice_bits : {0, 6, 12}) {
    for (const bool exact : {false, true}) {
      bench.add(
          fmt::format("model in {}, {}", lattice_bits > 0 ? fmt::format("step / {}", 1 << lattice_bits) : "doubles",
                      exact ? "exact" : "rounded"),
          makePaperModel(bench.mesh(), {exact, 1, lattice_bits}));
    }
  }
  bench.add("auto", makeCodec(bench.mesh(), variant("auto")));
  return bench.rows();
}

const char* planeNote() {
  return "Length in units of the diagonal. Last column: the rate at the step that the world-space codec has at the "
         "wanted\n"
         "rate. \"model\": the paper's codec with plain parallelograms in double precision, its decoded positions as\n"
         "they are or rounded to a part of the step; bits are entropies. An exact first triangle makes all normals\n"
         "constant (the paper's panel f) only while positions stay unrounded: each rounding to step / 64, the lattice\n"
         "of our tangent mode, tilts the next triangle a little, and tilts add up across the plane.\n";
}

std::string planeTable(const std::vector<PlaneRow>& rows) {
  std::string text = fmt::format("{:<34}{:>8}{:>14}{:>14}{:>11}{:>12}{:>16}\n", "codec", "bpv", "RMS / diag",
                                 "normal RMS", "DAME", "max tilt", "bpv equal step");
  for (const PlaneRow& row : rows) {
    if (!row.error.empty()) {
      text += fmt::format("{:<34}error: {}\n", row.codec, row.error);
      continue;
    }
    text += fmt::format(
        "{:<34}{:>8.2f}{:>14.3e}{:>14.3e}{:>11.5f}{:>8.3f} deg{:>16}\n", row.codec, row.bits_per_vertex, row.rms,
        row.normal_rms, row.dame, row.max_degrees,
        row.bits_per_vertex_at_equal_step > 0 ? fmt::format("{:.2f}", row.bits_per_vertex_at_equal_step) : "-");
  }
  return text;
}

}  // namespace tsc::bench
