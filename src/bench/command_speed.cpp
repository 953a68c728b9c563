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
  std::size_t min_vertices = 20000, largest = 1000000;
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
  std::vector<MeshSpeed> meshes;
  BenchMesh largest_mesh;
  std::size_t failed = measureSpeeds(set, options, nullptr, meshes, largest_mesh);
  if (meshes.empty()) return 2;
  const std::string summary = speedSummary(meshes, arguments.min_vertices);
  fmt::print("{}\n", summary.empty() ? speedSummary(meshes, 0) : summary);

  if (!arguments.no_scaling) {
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

std::size_t measureSpeeds(const MeshSet& set, const SpeedOptions& options, ResultStore* store,
                          std::vector<MeshSpeed>& meshes, BenchMesh& largest) {
  return forEachMesh(set, [&](const BenchMesh& mesh) {
    if (mesh.vertexCount() > largest.vertexCount()) largest = mesh;
    const std::string id = "speed/" + mesh.class_name + "/" + mesh.name;
    const nlohmann::json known = store != nullptr ? store->find(id) : nlohmann::json();
    if (!known.is_null()) {
      meshes.push_back(known.get<MeshSpeed>());
      return;
    }
    meshes.push_back(measureSpeed(mesh, options));
    if (store != nullptr) store->add(id, meshes.back());
    fmt::print("{}\n", speedLines(meshes.back()));
    std::fflush(stdout);
  });
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
  command->add_option("--min-vertices", arguments->min_vertices, "smallest mesh that enters the summary")
      ->capture_default_str();
  command->add_option("--largest", arguments->largest, "largest size of the scaling series")->capture_default_str();
  command->add_option("--csv", arguments->csv, "write FILE.csv");
  command->add_flag("--quick", arguments->quick, "six meshes only, spread over the folders");
  command->add_flag("--no-scaling", arguments->no_scaling, "no series of sizes");
  command->add_flag("--decode-only", arguments->decode_only, "time decoding alone");
  command->callback([arguments, &exit_code] { exit_code = runSpeed(*arguments); });
}

}  // namespace tsc::bench
