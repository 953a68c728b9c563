// Codecs under measurement as functions from a quantisation step to rate and distortion, and the cached Draco curves.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "corpus.h"
#include "curve.h"
#include "tsc/codec.h"

namespace tsc::bench {

/// A way to run our codec, under the name that tables give it.
struct Variant {
  std::string name;
  EncodeOptions options;      ///< all but the step
  bool is_laplacian = false;  ///< not our codec at all, but the baseline of laplacian.h
};

/// Variants by name, comma-separated; "all" for every one, "figure3" for those that stand beside the paper's Figure 3.
/// `effort` is applied to all of them. Throws std::runtime_error on an unknown name, listing the known ones.
std::vector<Variant> selectVariants(const std::string& names, Effort effort);

/// Those of `variants` that run at an effort.
std::vector<Variant> variantsOfEffort(const std::vector<Variant>& variants, Effort effort);

/// The codec's view of a mesh: one table, one primitive. Borrows from `mesh`.
Mesh codecMesh(const BenchMesh& mesh);

/// One run of a codec.
struct CodecPoint {
  double step = 0;
  double bits = 0;  ///< of the whole stream
  double mse = 0;
  StreamBits parts;
  StreamModes modes;
  std::vector<float> positions;  ///< decoded, in the order of the input
  RatePoint rate() const { return {bits, mse}; }
};

/// Runs one codec on one mesh at a step. Throws std::runtime_error when the codec refuses.
using StepCodec = std::function<CodecPoint(double step)>;

/// Our codec, or the Laplacian baseline. Decodes what it encodes, and checks that every triangle came back.
/// Borrows `mesh`.
StepCodec makeCodec(const BenchMesh& mesh, const Variant& variant);

/// The run whose bits come closest to `bits`, by interpolation of the step: usually within kRateTolerance. `runs` are
/// those that exist already, at least one; new ones are added. Throws as the codec does.
const CodecPoint& pointAtRate(const StepCodec& codec, std::vector<CodecPoint>& runs, double bits);
inline constexpr double kRateTolerance = 0.002;

/// Mean squared distance between vertices with the same number.
double meanSquaredError(const std::vector<float>& a, const std::vector<float>& b);

struct Distortion {
  double mse = 0;
  double metro = 0;  ///< RMS of the worse direction
  double dame = 0;
};
/// Metro samples a surface: one a triangle, within these bounds. The figures here are ratios of errors on the same
/// surface, sampled alike; ten times the samples move them by less than 1%.
inline constexpr std::uint64_t kMinMetroSamples = 15'000, kMaxMetroSamples = 100'000;

/// MSE, Metro and DAME of `positions` against the mesh. Throws std::runtime_error when a metric refuses.
Distortion measureDistortion(const BenchMesh& mesh, const std::vector<float>& positions);

/// Draco's results: the same for every run, so they are kept in CSV files. Safe to use from several threads.
class DracoCache {
 public:
  struct Entry {
    double bits = 0;
    double connectivity_bits = 0;  ///< the stream up to the attributes: header and connectivity
    double mse = 0;
  };

  /// Reads what `folder` holds; new results are appended there at once.
  explicit DracoCache(std::filesystem::path folder);

  /// `draco_encoder -cl level -qp bits`. A new result is decoded, and its MSE checked against the grid's to 1%.
  Entry rate(const BenchMesh& mesh, const std::string& key, int level, int bits);

  /// Distortion at `bits`, which is the same at every level.
  Distortion distortion(const BenchMesh& mesh, const std::string& key, int bits);

 private:
  void append(const char* file, const std::string& key, double a, double b, double c);

  std::filesystem::path folder_;
  std::mutex mutex_;
  std::map<std::string, Entry> entries_;
  std::map<std::string, Distortion> distortions_;
};

}  // namespace tsc::bench
