// tsc-bench speed: encoding and decoding times and heap beside Draco, meshoptimizer and memcpy.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "commands.h"
#include "speed.h"

namespace tsc::bench {

namespace {

struct SpeedArguments {
  std::vector<std::string> inputs;
  std::string modes = "auto", effort = "default", csv;
  std::size_t min_vertices = kSpeedVertices, largest = 1000000, max_every = 1;
  int runs = 7, bits = SpeedOptions::kSpeedBits;
  bool quick = false, no_scaling = false, decode_only = false;
};

int runSpeed(const SpeedArguments& arguments) {
  SpeedOptions options;
  options.variants = selectVariants(arguments.modes, arguments.effort == "max" ? Effort::kMax : Effort::kDefault);
  options.bits = arguments.bits;
  options.runs = std::max(arguments.runs, 7);
  options.encoding = !arguments.decode_only;
  MeshSet set{listFiles(arguments.inputs), {}, 1};
  if (arguments.quick) set.files = spreadSelection(set.files, kQuickMeshCount);

  fmt::print("{}\n{} runs of each codec, alternating, one thread; medians of CPU time; qp {} (meshopt: 16 bits)\n\n",
             provenance(), options.runs, options.bits);
  std::size_t failed = 0;
  const SpeedsByEffort speeds =
      measureSpeedsByEffort(set, options, arguments.min_vertices, arguments.max_every, nullptr, failed);
  std::vector<MeshSpeed> meshes = speeds.normal;
  meshes.insert(meshes.end(), speeds.max.begin(), speeds.max.end());
  if (meshes.empty()) return 2;
  for (const auto* part : {&speeds.normal, &speeds.max}) fmt::print("{}\n", speedSummary(*part));

  if (!arguments.no_scaling) {
    const BenchMesh largest_mesh = largestMesh(set);
    fmt::print("scaling: {} cut to patches, and subdivided\n", largest_mesh.name);
    for (const BenchMesh& mesh : sizeSeries(largest_mesh, arguments.largest)) {
      meshes.push_back(measureSpeed(mesh, options));
      fmt::print("{}\n", speedLines(meshes.back()));
      std::fflush(stdout);
    }
  }
  if (!arguments.csv.empty()) writeFile(arguments.csv, speedCsv(meshes));
  for (const MeshSpeed& mesh : meshes) {
    for (const CodecSpeed& codec : mesh.codecs) failed += codec.error.empty() ? 0 : 1;
  }
  return failed > 0 ? 2 : 0;
}

}  // namespace

std::vector<MeshSpeed> measureSpeeds(const MeshSet& set, const SpeedOptions& options, std::size_t min_vertices,
                                     ResultStore* store, std::size_t& failed) {
  MeshSet one_thread = set;
  one_thread.threads = 1;
  std::string prefix = fmt::format("speed {} runs", options.runs);
  for (const Variant& variant : options.variants) prefix += " " + variant.name;
  std::vector<MeshSpeed> speeds;
  failed += forEachMesh(one_thread, [&](const BenchMesh& mesh) {
    if (mesh.vertexCount() < min_vertices) return;
    const std::string id = fmt::format("{} {}/{} {}", prefix, mesh.class_name, mesh.name, mesh.contentKey());
    const nlohmann::json known = store != nullptr ? store->find(id) : nlohmann::json();
    if (!known.is_null()) {
      speeds.push_back(known.get<MeshSpeed>());
      return;
    }
    speeds.push_back(measureSpeed(mesh, options));
    if (store != nullptr) store->add(id, speeds.back());
    fmt::print("{}\n", speedLines(speeds.back()));
    std::fflush(stdout);
  });
  if (speeds.empty() && min_vertices > 0) return measureSpeeds(set, options, 0, store, failed);
  return speeds;
}

SpeedsByEffort measureSpeedsByEffort(const MeshSet& set, const SpeedOptions& options, std::size_t min_vertices,
                                     std::size_t max_every, ResultStore* store, std::size_t& failed) {
  SpeedsByEffort speeds;
  SpeedOptions pass = options;
  pass.variants = variantsOfEffort(options.variants, Effort::kDefault);
  if (!pass.variants.empty()) speeds.normal = measureSpeeds(set, pass, min_vertices, store, failed);
  pass.variants = variantsOfEffort(options.variants, Effort::kMax);
  if (pass.variants.empty() || max_every == 0) return speeds;
  MeshSet part = set;
  part.files = everyNth(set.files, max_every);
  speeds.max = measureSpeeds(part, pass, min_vertices, store, failed);
  return speeds;
}

BenchMesh largestMesh(const MeshSet& set) {
  BenchMesh largest;
  for (const CorpusFile& file : set.files) {
    try {
      for (BenchMesh& mesh : loadMeshes(file.path)) {
        if (mesh.vertexCount() > largest.vertexCount()) largest = std::move(mesh);
      }
    } catch (const std::runtime_error&) {
      continue;  // reported where it is measured
    }
  }
  return largest;
}

void addSpeedCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SpeedArguments>();
  CLI::App* command = app.add_subcommand("speed", "Times and heap beside Draco, meshoptimizer and memcpy");
  command->add_option("FILES", arguments->inputs, "glTF files, and folders of them")->required();
  command->add_option("--modes", arguments->modes, "codecs of ours, separated by commas")->capture_default_str();
  command->add_option("--effort", arguments->effort, "effort of our modes")
      ->check(CLI::IsMember({"default", "max"}))
      ->capture_default_str();
  command->add_option("--bits", arguments->bits, "Draco's setting, and our step")->capture_default_str();
  command->add_option("--runs", arguments->runs, "runs of each codec, at least 7")->capture_default_str();
  command->add_option("--min-vertices", arguments->min_vertices, "smallest mesh that is measured")
      ->capture_default_str();
  command->add_option("--max-every", arguments->max_every, "run effort max on every n-th file only, 0: on none")
      ->capture_default_str();
  command->add_option("--largest", arguments->largest, "largest size of the scaling series")->capture_default_str();
  command->add_option("--csv", arguments->csv, "write FILE.csv");
  command->add_flag("--quick", arguments->quick, "six meshes only, spread over the folders");
  command->add_flag("--no-scaling", arguments->no_scaling, "no series of sizes");
  command->add_flag("--decode-only", arguments->decode_only, "time decoding alone");
  command->callback([arguments, &exit_code] { exit_code = runSpeed(*arguments); });
}

}  // namespace tsc::bench
