// Rate and distortion of one mesh, and what is said of a set of them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "measure.h"

namespace tsc::bench {

/// Draco's setting at which MSE, Metro and DAME are compared: its default, as in the paper's Figure 3.
inline constexpr int kReferenceBits = 11;

struct RateOptions {
  std::vector<int> bits = {10, 11, 12, 14};  ///< at least two, rising
  std::vector<Variant> variants;
  /// Search for the steps that hit Draco's rates, and measure Metro and DAME there. Otherwise the MSE ratios alone,
  /// from the interpolated curve.
  bool with_metrics = true;
};

/// Error measures of a codec over Draco's at Draco's rate; below 1 is better than Draco.
struct RatiosAtRate {
  std::optional<double> mse, metro, dame;
};

struct VariantRate {
  std::string name;
  std::string error;              ///< why there are no figures; empty if there are
  std::vector<CodecPoint> curve;  ///< one a setting, without positions
  std::optional<double> bd7, bd10;
  RatiosAtRate at7, at10;
};

struct MeshRate {
  std::string name, class_name;
  std::size_t vertices = 0, faces = 0;
  std::size_t dropped_vertices = 0;  ///< as in BenchMesh
  std::vector<int> bits;
  std::vector<DracoCache::Entry> draco7, draco10;  ///< one a setting
  DracoCache::Entry reference7, reference10;       ///< at kReferenceBits
  std::vector<VariantRate> variants;

  /// The setting that tables show: kReferenceBits, or the first one where that is not measured.
  std::size_t shownPoint() const;
};

/// Measures one mesh. Errors of our codec end up in `VariantRate::error`; others are thrown as std::runtime_error.
MeshRate measureRate(const BenchMesh& mesh, const RateOptions& options, DracoCache& cache);

/// Adds the variants of `others` to the meshes of the same class and name.
void mergeRates(std::vector<MeshRate>& meshes, const std::vector<MeshRate>& others);

/// How many measurements ended in `VariantRate::error`.
std::size_t failedVariants(const std::vector<MeshRate>& meshes);

/// One line a variant: bits per vertex in their parts, and the ratios.
std::string rateLines(const MeshRate& mesh);
std::string rateLinesHeading();

/// Figures of one variant over a set.
struct RateSummary {
  std::string group, variant;
  std::size_t meshes = 0, failed = 0;
  Spread bd7, bd10;                                    ///< fractions: -0.1 is 10% fewer bits
  Spread mse7, mse10, metro7, metro10, dame7, dame10;  ///< `mean` is the geometric one
  Spread bits_per_vertex;                              ///< at the shown setting
  Spread draco7_bits_per_vertex, draco10_bits_per_vertex;
  double connectivity_ratio = 0;      ///< our connectivity bits over Draco's, totals
  double connectivity_all_ratio = 0;  ///< the same with our references, corners, side faces and header
  std::string worst_bd10_mesh, worst_mse7_mesh;
};

/// Summaries of each class and, if there are several, of all together; variants in the order of their first mesh.
std::vector<RateSummary> summarize(const std::vector<MeshRate>& meshes);

std::string summaryTable(const std::vector<RateSummary>& summaries);

/// One CSV line a mesh, codec and setting; one a mesh and variant for the ratios.
std::string pointsCsv(const std::vector<MeshRate>& meshes);
std::string ratiosCsv(const std::vector<MeshRate>& meshes);

void to_json(nlohmann::json& json, const MeshRate& mesh);
void from_json(const nlohmann::json& json, MeshRate& mesh);

}  // namespace tsc::bench
