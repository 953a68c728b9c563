// gltf-tsc compare: how far two assets or meshes are apart, as a table, as JSON, as pictures.
#include <fmt/core.h>

#include <CLI/App.hpp>
#include <memory>

#include "../gltf/file_io.h"
#include "command.h"
#include "distortion.h"
#include "files.h"
#include "options.h"
#include "tsc/quality.h"

namespace tsc::cli {
namespace {

struct CompareCommand {
  std::string a, b;
  bool json = false;
  bool force = false;
  std::vector<std::string> heatmaps;
  MetroOptions metro;
  LoadOptions load;
};

Expected<std::vector<NamedSurface>> readSurfaces(const std::string& file, const LoadOptions& options) {
  const std::string extension = lowerExtension(file);
  if (extension == ".ply" || extension == ".obj" || extension == ".stl") {
    auto surface = readSurfaceFile(file);
    if (!surface) return toFailure(surface.error());
    return std::vector<NamedSurface>{*std::move(surface)};
  }
  auto asset = loadInput(file, options);
  if (!asset) return asset.failure();
  return surfacesOf(*asset);
}

Outcome checkHeatmap(const std::string& output, bool force) {
  const std::string extension = lowerExtension(output);
  if (extension != ".glb" && extension != ".png") {
    return Failure{FailureKind::kUsage,
                   fmt::format("{}: found the file name extension '{}', expected .glb or .png", output, extension)};
  }
  return checkTextOutput(output, force);
}

Outcome writeHeatmap(const std::string& output, const std::vector<NamedSurface>& a, const std::vector<NamedSurface>& b,
                     const Comparison& comparison) {
  const auto write = lowerExtension(output) == ".png" ? writeHeatmapPng : writeHeatmapGlb;
  if (auto error = write(output, a, b, comparison)) return toFailure(*error);
  return {};
}

int runCompare(const CompareCommand& command) {
  for (const std::string& output : command.heatmaps) {
    if (Outcome bad = checkHeatmap(output, command.force)) return fail(*bad);
  }
  if (command.a == "-" && command.b == "-") {
    return fail({FailureKind::kUsage, "standard input can be one of the files, not both"});
  }
  auto a = readSurfaces(command.a, command.load);
  if (!a) return fail(a.failure());
  auto b = readSurfaces(command.b, command.load);
  if (!b) return fail(b.failure());
  dropEmptyMeshes(*a, *b);
  const auto comparison = compareScenes(*a, *b, command.metro);
  if (!comparison) {
    return fail(toFailure(
        {comparison.error().code, fmt::format("{} and {}: {}", command.a, command.b, comparison.error().message)}));
  }
  for (const MeshComparison& mesh : comparison->meshes) {
    if (mesh.vertices) continue;
    fmt::print(stderr, "gltf-tsc: warning: mesh \"{}\": connectivity differs, so only Metro could be measured\n",
               mesh.name);
  }
  for (const std::string& output : command.heatmaps) {
    if (Outcome bad = writeHeatmap(output, *a, *b, *comparison)) return fail(*bad);
  }
  const std::string text = command.json ? comparisonJson(*comparison) + "\n" : comparisonTable(*comparison);
  if (Outcome bad = saveText(text, "-", false)) return fail(*bad);
  return 0;
}

}  // namespace

CommandBody addCompareCommand(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("compare", "Measure how far two assets or meshes are apart");
  auto command = std::make_shared<CompareCommand>();
  verb->add_option("A", command->a, "The original: .gltf, .glb, .ply, .obj or .stl")->required()->type_name("FILE|-");
  verb->add_option("B", command->b, "What became of it")->required()->type_name("FILE|-");
  verb->add_flag("--json", command->json, "As JSON");
  verb->add_option("--heatmap", command->heatmaps, "Draw the error in colour; may be given once for each kind")
      ->type_name("OUT.glb|OUT.png")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  verb->add_option("--samples", command->metro.samples, "Metro's samples on each surface (0: by its triangles)")
      ->type_name("N")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{100'000'000}));
  verb->add_flag("--force", command->force, "Replace existing pictures");
  addLoadOptions(*verb, command->load);
  verb->footer(
      "MSE, RMS and max: distances between corresponding vertices, found whatever their order. Metro RMS and\n"
      "Hausdorff: distances between the surfaces, sampled. DAME: change of dihedral angles, masked by A's.");
  return [command] { return runCompare(*command); };
}

}  // namespace tsc::cli
