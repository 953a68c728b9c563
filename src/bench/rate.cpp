// Rate and distortion of one mesh, and what is said of a set of them.
#include "rate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tsc::bench {

namespace {

std::vector<RatePoint> ratePoints(const std::vector<DracoCache::Entry>& entries) {
  std::vector<RatePoint> points;
  for (const auto& entry : entries) points.push_back({entry.bits, entry.mse});
  return points;
}

std::vector<RatePoint> ratePoints(const std::vector<CodecPoint>& curve) {
  std::vector<RatePoint> points;
  for (const auto& point : curve) points.push_back(point.rate());
  return points;
}

std::optional<double> ratio(double value, double reference) {
  return reference > 0 ? std::optional(value / reference) : std::nullopt;
}

/// Ratios to Draco's distortion at its rate. The search for it starts from `runs`, and adds its own.
RatiosAtRate ratiosAt(const BenchMesh& mesh, const StepCodec& codec, std::vector<CodecPoint>& runs,
                      const DracoCache::Entry& draco, const std::optional<Distortion>& draco_distortion) {
  RatiosAtRate ratios;
  if (!draco_distortion) {
    if (const auto mse = mseAtRate(ratePoints(runs), draco.bits)) ratios.mse = ratio(*mse, draco.mse);
    if (ratios.mse) return ratios;
  }
  const CodecPoint& point = pointAtRate(codec, runs, draco.bits);
  if (!draco_distortion) {
    ratios.mse = ratio(point.mse, draco.mse);
    return ratios;
  }
  const Distortion distortion = measureDistortion(mesh, point.positions);
  ratios.mse = ratio(distortion.mse, draco_distortion->mse);
  ratios.metro = ratio(distortion.metro, draco_distortion->metro);
  ratios.dame = ratio(distortion.dame, draco_distortion->dame);
  return ratios;
}

void measureVariant(const BenchMesh& mesh, const Variant& variant, const MeshRate& draco,
                    const std::optional<Distortion>& draco_distortion, VariantRate& result) {
  const StepCodec codec = makeCodec(mesh, variant);
  std::vector<CodecPoint> runs;
  for (const int bits : draco.bits) runs.push_back(codec(stepForBits(codecMesh(mesh), bits)));
  result.curve = runs;
  for (CodecPoint& point : result.curve) point.positions = {};
  result.bd7 = bdRate(ratePoints(draco.draco7), ratePoints(result.curve));
  result.bd10 = bdRate(ratePoints(draco.draco10), ratePoints(result.curve));
  result.at7 = ratiosAt(mesh, codec, runs, draco.reference7, draco_distortion);
  result.at10 = ratiosAt(mesh, codec, runs, draco.reference10, draco_distortion);
}

std::string percent(const std::optional<double>& fraction) {
  return fraction ? fmt::format("{:+.1f}%", 100 * *fraction) : "-";
}
std::string factor(const std::optional<double>& value) { return value ? fmt::format("{:.3f}", *value) : "-"; }

const char* modeName(Mode mode) { return mode == Mode::kTangent ? "tangent" : "lattice"; }
const char* basisName(Basis basis) { return basis == Basis::kTip ? "tip" : "gate"; }
const char* predictorName(Predictor predictor) {
  static constexpr const char* kNames[] = {"auto", "parallelogram", "weighted", "valence", "average", "adaptive"};
  const auto i = static_cast<std::size_t>(predictor);
  return i < std::size(kNames) ? kNames[i] : "?";
}

std::string modesName(const StreamModes& modes) {
  std::string name = modeName(modes.mode);
  if (modes.mode == Mode::kTangent) name += fmt::format("/{}", basisName(modes.basis));
  return fmt::format("{}/{}{}", name, predictorName(modes.predictor), modes.order == Order::kDegree ? "/degree" : "");
}

double otherConnectivity(const StreamBits& parts) {
  return parts.header + parts.references + parts.corners + parts.side_faces;
}

RateSummary summarizeGroup(const std::vector<const MeshRate*>& meshes, const std::string& group,
                           const std::string& variant) {
  RateSummary summary;
  summary.group = group;
  summary.variant = variant;
  std::vector<double> bd7, bd10, bpv, draco7, draco10, mse7, mse10, metro7, metro10, dame7, dame10;
  double connectivity = 0, other = 0, draco_connectivity = 0, worst_bd = -1, worst_mse = 0;
  const auto add = [](std::vector<double>& values, const std::optional<double>& value) {
    if (value) values.push_back(*value);
  };
  for (const MeshRate* mesh : meshes) {
    const auto found = std::find_if(mesh->variants.begin(), mesh->variants.end(),
                                    [&](const VariantRate& rate) { return rate.name == variant; });
    if (found == mesh->variants.end()) continue;
    const VariantRate& rate = *found;
    ++summary.meshes;
    if (!rate.error.empty()) {
      ++summary.failed;
      continue;
    }
    const std::size_t shown = mesh->shownPoint();
    const double vertices = double(mesh->vertices);
    add(bd7, rate.bd7);
    add(bd10, rate.bd10);
    add(mse7, rate.at7.mse);
    add(mse10, rate.at10.mse);
    add(metro7, rate.at7.metro);
    add(metro10, rate.at10.metro);
    add(dame7, rate.at7.dame);
    add(dame10, rate.at10.dame);
    bpv.push_back(rate.curve[shown].bits / vertices);
    draco7.push_back(mesh->draco7[shown].bits / vertices);
    draco10.push_back(mesh->draco10[shown].bits / vertices);
    connectivity += rate.curve[shown].parts.connectivity;
    other += otherConnectivity(rate.curve[shown].parts);
    draco_connectivity += mesh->draco10[shown].connectivity_bits;
    if (rate.bd10 && *rate.bd10 > worst_bd) {
      worst_bd = *rate.bd10;
      summary.worst_bd10_mesh = mesh->name;
    }
    if (rate.at7.mse && *rate.at7.mse > worst_mse) {
      worst_mse = *rate.at7.mse;
      summary.worst_mse7_mesh = mesh->name;
    }
  }
  summary.bd7 = spreadOf(bd7);
  summary.bd10 = spreadOf(bd10);
  summary.mse7 = ratioSpreadOf(mse7);
  summary.mse10 = ratioSpreadOf(mse10);
  summary.metro7 = ratioSpreadOf(metro7);
  summary.metro10 = ratioSpreadOf(metro10);
  summary.dame7 = ratioSpreadOf(dame7);
  summary.dame10 = ratioSpreadOf(dame10);
  summary.bits_per_vertex = spreadOf(bpv);
  summary.draco7_bits_per_vertex = spreadOf(draco7);
  summary.draco10_bits_per_vertex = spreadOf(draco10);
  if (draco_connectivity > 0) {
    summary.connectivity_ratio = connectivity / draco_connectivity;
    summary.connectivity_all_ratio = (connectivity + other) / draco_connectivity;
  }
  return summary;
}

}  // namespace

std::size_t MeshRate::shownPoint() const {
  const auto found = std::find(bits.begin(), bits.end(), kReferenceBits);
  return found == bits.end() ? 0 : static_cast<std::size_t>(found - bits.begin());
}

MeshRate measureRate(const BenchMesh& mesh, const RateOptions& options, DracoCache& cache) {
  const std::string key = mesh.contentKey();
  MeshRate result;
  result.name = mesh.name;
  result.class_name = mesh.class_name;
  result.vertices = mesh.vertexCount();
  result.faces = mesh.faceCount();
  result.dropped_vertices = mesh.dropped_vertices;
  result.bits = options.bits;
  for (const int bits : options.bits) {
    result.draco7.push_back(cache.rate(mesh, key, 7, bits));
    result.draco10.push_back(cache.rate(mesh, key, 10, bits));
  }
  result.reference7 = cache.rate(mesh, key, 7, kReferenceBits);
  result.reference10 = cache.rate(mesh, key, 10, kReferenceBits);
  std::optional<Distortion> draco_distortion;
  if (options.with_metrics) draco_distortion = cache.distortion(mesh, key, kReferenceBits);

  for (const Variant& variant : options.variants) {
    VariantRate& rate = result.variants.emplace_back();
    rate.name = variant.name;
    try {
      measureVariant(mesh, variant, result, draco_distortion, rate);
    } catch (const std::runtime_error& error) {
      rate = {};
      rate.name = variant.name;
      rate.error = error.what();
    }
  }
  return result;
}

void mergeRates(std::vector<MeshRate>& meshes, const std::vector<MeshRate>& others) {
  for (const MeshRate& other : others) {
    const auto same = std::find_if(meshes.begin(), meshes.end(), [&](const MeshRate& mesh) {
      return mesh.name == other.name && mesh.class_name == other.class_name;
    });
    if (same == meshes.end()) {
      meshes.push_back(other);
    } else {
      same->variants.insert(same->variants.end(), other.variants.begin(), other.variants.end());
    }
  }
}

std::size_t failedVariants(const std::vector<MeshRate>& meshes) {
  std::size_t failed = 0;
  for (const MeshRate& mesh : meshes) {
    for (const VariantRate& rate : mesh.variants) failed += rate.error.empty() ? 0 : 1;
  }
  return failed;
}

std::string rateLinesHeading() {
  return fmt::format(
      "{:<26}{:>8} {:<13}{:>7} = {:>5}{:>6}{:>7}{:>6}{:>7} | {:>6}{:>6}{:>6} | {:>7}{:>8} | {:>6}{:>7}{:>6} | {}\n",
      "mesh (bits per vertex)", "vertices", "codec", "all", "head", "conn", "pos", "ref", "other", "cl7", "cl10",
      "conn", "BD cl7", "BD cl10", "MSE@7", "Metro@10", "DAME@10", "chosen");
}

std::string rateLines(const MeshRate& mesh) {
  std::string lines;
  const std::size_t shown = mesh.shownPoint();
  const double n = double(mesh.vertices);
  if (mesh.dropped_vertices > 0) {
    lines += fmt::format("{:<26}{:>8} {} more vertices, which no triangle uses, were left out for all codecs\n",
                         mesh.name, mesh.vertices, mesh.dropped_vertices);
  }
  for (const VariantRate& rate : mesh.variants) {
    if (!rate.error.empty()) {
      lines += fmt::format("{:<26}{:>8} {:<13}error: {}\n", mesh.name, mesh.vertices, rate.name, rate.error);
      continue;
    }
    const CodecPoint& point = rate.curve[shown];
    lines += fmt::format(
        "{:<26}{:>8} {:<13}{:>7.2f} = {:>5.2f}{:>6.2f}{:>7.2f}{:>6.2f}{:>7.2f} | {:>6.2f}{:>6.2f}{:>6.2f} | "
        "{:>7}{:>8} | {:>6}{:>7}{:>7} | {}\n",
        mesh.name, mesh.vertices, rate.name, point.bits / n, point.parts.header / n, point.parts.connectivity / n,
        point.parts.positions / n, point.parts.references / n, (point.parts.corners + point.parts.side_faces) / n,
        mesh.draco7[shown].bits / n, mesh.draco10[shown].bits / n, mesh.draco10[shown].connectivity_bits / n,
        percent(rate.bd7), percent(rate.bd10), factor(rate.at7.mse), factor(rate.at10.metro), factor(rate.at10.dame),
        modesName(point.modes));
  }
  return lines;
}

std::vector<RateSummary> summarize(const std::vector<MeshRate>& meshes) {
  std::vector<std::string> groups;
  for (const MeshRate& mesh : meshes) {
    if (std::find(groups.begin(), groups.end(), mesh.class_name) == groups.end()) groups.push_back(mesh.class_name);
  }
  std::sort(groups.begin(), groups.end());
  if (groups.size() > 1) groups.push_back("all");
  std::vector<RateSummary> summaries;
  for (const std::string& group : groups) {
    std::vector<const MeshRate*> members;
    for (const MeshRate& mesh : meshes) {
      if (group == "all" || mesh.class_name == group) members.push_back(&mesh);
    }
    std::vector<std::string> variants;
    for (const MeshRate* mesh : members) {
      for (const VariantRate& rate : mesh->variants) {
        if (std::find(variants.begin(), variants.end(), rate.name) == variants.end()) variants.push_back(rate.name);
      }
    }
    for (const std::string& variant : variants) summaries.push_back(summarizeGroup(members, group, variant));
  }
  return summaries;
}

std::string summaryTable(const std::vector<RateSummary>& summaries) {
  std::string text = fmt::format(
      "{:<10}{:<14}{:>4} | {:^24} | {:^24} | {:^14} | {:^14} | {:>6} | {:>10} | {:^27}\n"
      "{:<10}{:<14}{:>4} | {:>8}{:>8}{:>8} | {:>8}{:>8}{:>8} | {:>7}{:>7} | {:>7}{:>7} | {:>6} | {:>4}{:>6} | "
      "{:>6}{:>7}{:>7}{:>7}\n",
      "", "", "", "BD-rate vs cl7", "BD-rate vs cl10", "MSE at cl7", "DAME at cl10", "Metro", "conn/Draco",
      "bpv at qp 11: ours, Draco", "class", "codec", "n", "median", "mean", "worst", "median", "mean", "worst",
      "median", "worst", "median", "worst", "@cl10", "conn", "+all", "median", "mean", "cl7", "cl10");
  const auto p = [](double fraction) { return fmt::format("{:+.1f}%", 100 * fraction); };
  const auto f = [](double value, const Spread& spread) {
    return spread.count > 0 ? fmt::format("{:.3f}", value) : std::string("-");
  };
  for (const RateSummary& s : summaries) {
    text += fmt::format(
        "{:<10}{:<14}{:>4} | {:>8}{:>8}{:>8} | {:>8}{:>8}{:>8} | {:>7}{:>7} | {:>7}{:>7} | {:>6} | {:>4.2f}{:>6.2f} | "
        "{:>6.2f}{:>7.2f}{:>7.2f}{:>7.2f}",
        s.group, s.variant, s.meshes - s.failed, p(s.bd7.median), p(s.bd7.mean), p(s.bd7.worst), p(s.bd10.median),
        p(s.bd10.mean), p(s.bd10.worst), f(s.mse7.median, s.mse7), f(s.mse7.worst, s.mse7),
        f(s.dame10.median, s.dame10), f(s.dame10.worst, s.dame10), f(s.metro10.median, s.metro10), s.connectivity_ratio,
        s.connectivity_all_ratio, s.bits_per_vertex.median, s.bits_per_vertex.mean, s.draco7_bits_per_vertex.median,
        s.draco10_bits_per_vertex.median);
    if (!s.worst_bd10_mesh.empty()) text += "  worst: " + s.worst_bd10_mesh;
    if (s.failed > 0) text += fmt::format("  ({} FAILED)", s.failed);
    text += '\n';
  }
  return text;
}

std::string pointsCsv(const std::vector<MeshRate>& meshes) {
  std::string csv =
      "mesh,class,vertices,faces,codec,qp,step,bits,mse,header,connectivity,positions,references,corners,"
      "side_faces,chosen\n";
  for (const MeshRate& mesh : meshes) {
    const std::string head = fmt::format("{},{},{},{}", mesh.name, mesh.class_name, mesh.vertices, mesh.faces);
    for (std::size_t i = 0; i < mesh.bits.size(); ++i) {
      const auto draco = [&](const char* name, const DracoCache::Entry& entry) {
        csv += fmt::format("{},{},{},,{},{},,{},{},,,,\n", head, name, mesh.bits[i], entry.bits, entry.mse,
                           entry.connectivity_bits, entry.bits - entry.connectivity_bits);
      };
      draco("draco-cl7", mesh.draco7[i]);
      draco("draco-cl10", mesh.draco10[i]);
      for (const VariantRate& rate : mesh.variants) {
        if (i >= rate.curve.size()) continue;
        const CodecPoint& p = rate.curve[i];
        csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", head, rate.name, mesh.bits[i], p.step, p.bits,
                           p.mse, p.parts.header, p.parts.connectivity, p.parts.positions, p.parts.references,
                           p.parts.corners, p.parts.side_faces, modesName(p.modes));
      }
    }
  }
  return csv;
}

std::string ratiosCsv(const std::vector<MeshRate>& meshes) {
  std::string csv =
      "mesh,class,vertices,faces,codec,bd_cl7,bd_cl10,mse_at_cl7,metro_at_cl7,dame_at_cl7,mse_at_cl10,"
      "metro_at_cl10,dame_at_cl10,error\n";
  const auto cell = [](const std::optional<double>& value) { return value ? fmt::format("{}", *value) : ""; };
  for (const MeshRate& mesh : meshes) {
    for (const VariantRate& r : mesh.variants) {
      csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},\"{}\"\n", mesh.name, mesh.class_name, mesh.vertices,
                         mesh.faces, r.name, cell(r.bd7), cell(r.bd10), cell(r.at7.mse), cell(r.at7.metro),
                         cell(r.at7.dame), cell(r.at10.mse), cell(r.at10.metro), cell(r.at10.dame), r.error);
    }
  }
  return csv;
}

}  // namespace tsc::bench
