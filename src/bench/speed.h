// Time and memory of all codecs, side by side.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "measure.h"

namespace tsc::bench {

/// How one codec did on one mesh.
struct CodecSpeed {
  std::string codec;
  std::string error;                                    ///< why there are no figures; empty if there are
  double bytes = 0;                                     ///< of the stream
  double encode_ns = 0, decode_ns = 0;                  ///< CPU time, medians, for the whole mesh
  double encode_peak_bytes = 0, decode_peak_bytes = 0;  ///< of heap; decoding includes the decoded arrays
};

struct MeshSpeed {
  std::string name, class_name;
  std::size_t vertices = 0, faces = 0;
  std::vector<CodecSpeed> codecs;  ///< in the order of `speedCodecNames`
  const CodecSpeed& codec(const std::string& name) const;
};

struct SpeedOptions {
  std::vector<Variant> variants;  ///< of our codec
  static constexpr int kSpeedBits = 11;
  int bits = kSpeedBits;  ///< Draco's setting, and our step
  int runs = 7;           ///< of each codec; the medians are kept
  bool encoding = true;   ///< without it only decoding is timed
};

/// Times Draco -cl 7 and -cl 10, meshoptimizer, memcpy and our variants on the same arrays, one run of each in turn.
/// In the calling thread. Time is the thread's CPU time; still, a machine that does nothing else measures best.
MeshSpeed measureSpeed(const BenchMesh& mesh, const SpeedOptions& options);

/// A table of one mesh: ns a vertex, Mtriangles/s, heap, and ratios to Draco.
std::string speedLines(const MeshSpeed& mesh);

/// Ratios over a set of meshes: ours to Draco's, medians of the meshes. Empty for none.
std::string speedSummary(const std::vector<MeshSpeed>& meshes);

/// What our codec's goals are set in, medians over a set of meshes. Absent when the codec was not measured.
struct SpeedMedians {
  std::size_t meshes = 0;
  double decode_speed = 0;                ///< Draco's -cl 10 decoding time over ours
  double encode_time = 0;                 ///< our encoding time over Draco's -cl 10
  double decode_peak_bytes_a_vertex = 0;  ///< of heap
};
std::optional<SpeedMedians> speedMedians(const std::vector<MeshSpeed>& meshes, const std::string& codec);

std::string speedCsv(const std::vector<MeshSpeed>& meshes);

/// The mesh at about 1k, 3k, 10k, ... up to `largest` vertices: patches of it, then subdivisions and patches of those.
std::vector<BenchMesh> sizeSeries(const BenchMesh& mesh, std::size_t largest);

void to_json(nlohmann::json& json, const MeshSpeed& mesh);
void from_json(const nlohmann::json& json, MeshSpeed& mesh);

}  // namespace tsc::bench
