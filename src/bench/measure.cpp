// Codecs under measurement.
#include "measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "laplacian.h"
#include "peers.h"
#include "tsc/quality.h"

namespace tsc::bench {

namespace {

constexpr const char* kRateFile = "draco-rate.csv";
constexpr const char* kDistortionFile = "draco-distortion-2.csv";  // 2: of the Metro samples that measure.h gives

std::vector<Variant> allVariants() {
  std::vector<Variant> variants;
  const auto add = [&](const char* name, Mode mode, Basis basis, Predictor predictor, Order order, std::uint32_t scale,
                       Effort effort = Effort::kDefault) {
    EncodeOptions options;
    options.mode = mode;
    options.basis = basis;
    options.predictor = predictor;
    options.order = order;
    options.normal_scale = scale;
    options.effort = effort;
    variants.push_back({name, options, false});
  };
  // The paper codes positions as the connectivity's traversal meets them.
  const auto paper = [&](const char* name, Basis basis, std::uint32_t scale) {
    add(name, Mode::kTangent, basis, Predictor::kWeighted, Order::kTraversal, scale);
  };
  add("auto", Mode::kAuto, Basis::kAuto, Predictor::kAuto, Order::kAuto, 1);
  add("auto-n2", Mode::kAuto, Basis::kAuto, Predictor::kAuto, Order::kAuto, 2);
  add("max", Mode::kAuto, Basis::kAuto, Predictor::kAuto, Order::kAuto, 1, Effort::kMax);
  add("max-n2", Mode::kAuto, Basis::kAuto, Predictor::kAuto, Order::kAuto, 2, Effort::kMax);
  add("tangent", Mode::kTangent, Basis::kAuto, Predictor::kAuto, Order::kAuto, 1);
  add("tangent-n2", Mode::kTangent, Basis::kAuto, Predictor::kAuto, Order::kAuto, 2);
  add("lattice", Mode::kLattice, Basis::kAuto, Predictor::kAuto, Order::kAuto, 1);
  paper("paper-eq5", Basis::kGate, 1);
  paper("paper-eq5-n2", Basis::kGate, 2);
  paper("paper-eq7", Basis::kTip, 1);
  paper("paper-eq7-n2", Basis::kTip, 2);
  add("world-wp", Mode::kLattice, Basis::kAuto, Predictor::kWeighted, Order::kTraversal, 1);
  variants.push_back({"laplacian", {}, true});
  return variants;
}

std::runtime_error codecError(const BenchMesh& mesh, const char* what, const Error& error) {
  return std::runtime_error(fmt::format("{}: {}: {}", mesh.name, what, describe(error)));
}

/// Throws unless every decoded triangle is the input triangle it claims to be, and all are there.
void checkTriangles(const BenchMesh& mesh, const EncodeResult& result, const std::vector<std::byte>& decoded) {
  const auto& order = result.triangle_order.at(0);
  std::vector<bool> seen(mesh.faceCount());
  bool good = order.size() == mesh.faceCount() && decoded.size() == 4 * mesh.indices.size();
  for (std::size_t f = 0; good && f < order.size(); ++f) {
    const std::size_t input = order[f] / 3;
    good = input < seen.size() && !seen[input];
    for (std::size_t c = 0; good && c < 3; ++c) {
      std::uint32_t index;
      std::memcpy(&index, decoded.data() + 4 * (3 * f + c), 4);
      good = index < mesh.vertexCount() &&
             result.vertex_order[0][index] == mesh.indices[3 * input + (order[f] % 3 + c) % 3];
    }
    if (good) seen[input] = true;
  }
  if (!good) throw std::runtime_error(mesh.name + ": the decoded triangles are not those of the input");
}

CodecPoint runOurs(const BenchMesh& mesh, EncodeOptions options, double step) {
  options.step = step;
  const Result<EncodeResult> result = encode(codecMesh(mesh), options);
  if (!result) throw codecError(mesh, "encode", result.error());
  const auto decoded = decode(result->bytes);
  if (!decoded) throw codecError(mesh, "decode", decoded.error());

  CodecPoint point;
  point.step = step;
  point.bits = 8.0 * double(result->bytes.size());
  point.parts = result->bits;
  point.modes = result->modes;
  point.positions.resize(mesh.positions.size());
  const auto& order = result->vertex_order.at(0);
  if (order.size() != mesh.vertexCount() || decoded->at(0).size() != 12 * mesh.vertexCount()) {
    throw std::runtime_error(mesh.name + ": the decoded vertices are not as many as the input's");
  }
  for (std::size_t v = 0; v < order.size(); ++v) {
    std::memcpy(&point.positions[3 * std::size_t{order[v]}], decoded->at(0).data() + 12 * v, 12);
  }
  checkTriangles(mesh, *result, decoded->at(1));
  point.mse = meanSquaredError(mesh.positions, point.positions);
  return point;
}

/// Reads lines `key,a,b,c,end`. Lines that an interrupted run left unfinished lack the end, and are passed over.
template <class Add>
void readCache(const std::filesystem::path& path, const Add& add) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    std::string key, end;
    double a, b, c;
    if (fields >> key >> a >> b >> c >> end && end == "end") add(key, a, b, c);
  }
}

/// The step at which the codec should need `bits`, judging by its runs: log step over bits, as a smooth curve through
/// all runs inside their range.
double stepTowards(const std::vector<CodecPoint>& runs, double bits) {
  constexpr double kMaxExtension = 4;
  // Bits fall as the step grows: `fine` needs more than the target, `coarse` less.
  const CodecPoint *fine = nullptr, *coarse = nullptr;
  std::map<double, double> log_step_of_bits;
  for (const CodecPoint& point : runs) {
    if (point.bits >= bits && (fine == nullptr || point.bits < fine->bits)) fine = &point;
    if (point.bits < bits && (coarse == nullptr || point.bits > coarse->bits)) coarse = &point;
    log_step_of_bits[point.bits] = std::log(point.step);
  }
  // Beyond what was run: from the end of the steps, for a finer step does not always need more bits.
  const auto by_step = [](const CodecPoint& a, const CodecPoint& b) { return a.step < b.step; };
  if (fine == nullptr) return std::min_element(runs.begin(), runs.end(), by_step)->step / kMaxExtension;
  if (coarse == nullptr) return std::max_element(runs.begin(), runs.end(), by_step)->step * kMaxExtension;
  std::vector<double> x, y;
  for (const auto& [run_bits, log_step] : log_step_of_bits) x.push_back(run_bits), y.push_back(log_step);
  // Kept off the ends of the bracket, so that it shrinks even on a kinked curve.
  const double low = std::log(fine->step), span = std::log(coarse->step) - low;
  const double t = span != 0 ? (Pchip(x, y)(bits) - low) / span : 0.5;
  return std::exp(low + span * std::clamp(t, 0.02, 0.98));
}

template <class T>
T requireMeasured(const BenchMesh& mesh, Measured<T> measured) {
  if (!measured) throw std::runtime_error(mesh.name + ": " + measured.error().message);
  return *std::move(measured);
}

}  // namespace

std::vector<Variant> selectVariants(const std::string& names, Effort effort) {
  const std::vector<Variant> all = allVariants();
  std::vector<Variant> selection;
  std::string expanded = names;
  if (const auto at = expanded.find("figure3"); at != std::string::npos) {
    expanded.replace(at, std::string("figure3").size(), "auto,auto-n2,paper-eq7,paper-eq7-n2,world-wp,laplacian");
  }
  std::stringstream list(expanded);
  for (std::string name; std::getline(list, name, ',');) {
    bool found = false;
    for (const Variant& variant : all) {
      if (name != "all" && name != variant.name) continue;
      selection.push_back(variant);
      if (effort == Effort::kMax) selection.back().options.effort = effort;
      found = true;
    }
    if (found) continue;
    std::string known;
    for (const Variant& variant : all) known += " " + variant.name;
    throw std::runtime_error("unknown mode " + name + "; known are all, figure3," + known);
  }
  return selection;
}

std::vector<Variant> variantsOfEffort(const std::vector<Variant>& variants, Effort effort) {
  std::vector<Variant> selection;
  std::copy_if(variants.begin(), variants.end(), std::back_inserter(selection),
               [effort](const Variant& variant) { return variant.options.effort == effort; });
  return selection;
}

Mesh codecMesh(const BenchMesh& mesh) {
  Mesh result;
  result.tables.push_back({mesh.positions});
  result.primitives.push_back({0, mesh.indices, ComponentType::kUint32});
  return result;
}

StepCodec makeCodec(const BenchMesh& mesh, const Variant& variant) {
  if (!variant.is_laplacian) {
    return [&mesh, options = variant.options](double step) { return runOurs(mesh, options, step); };
  }
  return [codec = std::make_shared<LaplacianCodec>(mesh)](double step) { return codec->run(step); };
}

const CodecPoint& pointAtRate(const StepCodec& codec, std::vector<CodecPoint>& runs, double bits) {
  constexpr int kMaxRuns = 7;
  constexpr int kMaxFinerBits = 8;
  const auto error = [bits](const CodecPoint& point) { return std::abs(point.bits / bits - 1); };
  const auto closest = [&]() -> const CodecPoint& {
    return *std::min_element(runs.begin(), runs.end(), [&](auto& a, auto& b) { return error(a) < error(b); });
  };
  // Where a codec is far better, the rate may lie beyond any lattice that it has: the finest step tried is the answer.
  const auto by_step = [](const CodecPoint& a, const CodecPoint& b) { return a.step < b.step; };
  const double finest = std::ldexp(std::min_element(runs.begin(), runs.end(), by_step)->step, -kMaxFinerBits);
  for (int run = 0; run < kMaxRuns && error(closest()) >= kRateTolerance; ++run) {
    const double step = std::max(stepTowards(runs, bits), finest);
    const auto tried = [step](const CodecPoint& point) { return point.step == step; };
    if (std::any_of(runs.begin(), runs.end(), tried)) break;
    runs.push_back(codec(step));
  }
  return closest();
}

double meanSquaredError(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
  return a.empty() ? 0 : sum / double(a.size() / 3);
}

Distortion measureDistortion(const BenchMesh& mesh, const std::vector<float>& positions) {
  const SurfaceView original{mesh.positions, mesh.indices};
  Distortion distortion;
  distortion.mse = meanSquaredError(mesh.positions, positions);
  MetroOptions options;
  options.samples = std::clamp<std::uint64_t>(mesh.faceCount(), kMinMetroSamples, kMaxMetroSamples);
  options.at_vertices = false;
  distortion.metro = requireMeasured(mesh, metro(original, {positions, mesh.indices}, options)).rms();
  distortion.dame = requireMeasured(mesh, dame(original, positions)).value;
  return distortion;
}

DracoCache::DracoCache(std::filesystem::path folder) : folder_(std::move(folder)) {
  std::filesystem::create_directories(folder_);
  readCache(folder_ / kRateFile, [&](const std::string& key, double a, double b, double c) {
    entries_[key] = {a, b, c};
  });
  readCache(folder_ / kDistortionFile, [&](const std::string& key, double a, double b, double c) {
    distortions_[key] = {a, b, c};
  });
}

void DracoCache::append(const char* file, const std::string& key, double a, double b, double c) {
  std::ofstream(folder_ / file, std::ios::app) << fmt::format("\n{},{},{},{},end", key, a, b, c);
}

DracoCache::Entry DracoCache::rate(const BenchMesh& mesh, const std::string& key, int level, int bits) {
  const std::string full_key = fmt::format("{}-cl{}-qp{}", key, level, bits);
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = entries_.find(full_key); found != entries_.end()) return found->second;
  }
  const DracoStream stream = encodeDracoInParts(DracoMesh(mesh), level, bits);
  const DracoDistortion distortion = dracoDistortion(mesh, decodeDraco(stream.bytes), bits);
  if (distortion.dropped_vertices == 0 &&
      std::abs(distortion.mse_by_decoder - distortion.mse_by_grid) > 0.01 * distortion.mse_by_grid) {
    throw std::runtime_error(mesh.name + ": Draco's distortion by its decoder is not that of its grid");
  }
  const Entry entry{8.0 * double(stream.bytes.size()), 8.0 * double(stream.connectivity_bytes), distortion.mse_by_grid};
  const std::lock_guard lock(mutex_);
  entries_[full_key] = entry;
  append(kRateFile, full_key, entry.bits, entry.connectivity_bits, entry.mse);
  return entry;
}

Distortion DracoCache::distortion(const BenchMesh& mesh, const std::string& key, int bits) {
  const std::string full_key = fmt::format("{}-qp{}", key, bits);
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = distortions_.find(full_key); found != distortions_.end()) return found->second;
  }
  const Distortion distortion = measureDistortion(mesh, dracoGridPositions(mesh, bits));
  const std::lock_guard lock(mutex_);
  distortions_[full_key] = distortion;
  append(kDistortionFile, full_key, distortion.mse, distortion.metro, distortion.dame);
  return distortion;
}

}  // namespace tsc::bench
