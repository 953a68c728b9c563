// gltf-tsc pack: one file, or many into a folder.
#include <fmt/core.h>

#include <CLI/App.hpp>
#include <filesystem>
#include <memory>
#include <system_error>

#include "command.h"
#include "distortion.h"
#include "files.h"
#include "options.h"
#include "pack_many.h"
#include "progress.h"
#include "report.h"

namespace tsc::cli {
namespace {

struct PackCommand {
  std::vector<std::string> inputs;
  std::string output, out_dir, report;
  unsigned jobs = 0;
  bool force = false;
  Verbosity verbosity;
  LoadOptions load;
  PackArguments arguments;
};

Failure usage(const std::string& message) { return {FailureKind::kUsage, message}; }

bool samePlace(const std::filesystem::path& a, const std::filesystem::path& b) {
  return std::filesystem::absolute(a).lexically_normal() == std::filesystem::absolute(b).lexically_normal();
}

int packOne(const PackCommand& command) {
  const std::string& input = command.inputs[0];
  std::error_code error;
  if (std::filesystem::is_directory(input, error)) {
    return fail(
        usage(input + ": found a folder, expected the name of a file; --out-dir FOLDER packs all assets in it"));
  }
  if (command.report == "-" && command.output == "-") {
    return fail(usage("standard output cannot take both the asset (-o -) and the report (--report -)"));
  }
  if (!command.report.empty() && samePlace(command.report, command.output)) {
    return fail(usage(command.output + ": cannot take both the asset (-o) and the report (--report)"));
  }
  if (Outcome bad = checkOutput(command.output, command.force)) return fail(*bad);
  if (!command.report.empty()) {
    if (Outcome bad = checkTextOutput(command.report, command.force)) return fail(*bad);
  }
  auto asset = loadInput(input, command.load);
  if (!asset) return fail(asset.failure());

  const bool measure = !command.report.empty();
  const Asset original = measure ? *asset : Asset();
  PackOptions options = packOptions(command.arguments);
  auto report = [&] {
    Progress progress("packing", !command.verbosity.quiet);
    options.progress = [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); };
    return packAsset(*asset, options);
  }();
  if (!report) return fail(report.failure());
  if (Outcome bad = saveOutput(*asset, command.output, command.force)) return fail(*bad);
  printPackReport(input, command.output, *report, command.verbosity);
  if (measure) {
    Json json = packReportJson(input, command.output, *report);
    const Progress progress("measuring", !command.verbosity.quiet);
    json["distortion"] = reportDistortion(original, *asset, input, command.verbosity.quiet);
    const std::string text = writeJson(json, 2) + "\n";
    if (Outcome bad = saveText(text, command.report, command.force)) return fail(*bad);
  }
  return 0;
}

int runPack(const PackCommand& command) {
  const bool many = !command.out_dir.empty();
  for (const std::string& input : command.inputs) {
    if (input.empty()) return fail(usage("found an empty name, expected that of an asset"));
  }
  if (many == !command.output.empty()) return fail(usage("one of -o FILE and --out-dir FOLDER is needed"));
  if (!many && command.inputs.size() > 1) {
    return fail(usage(command.inputs[1] + ": found a second input, expected one; --out-dir FOLDER packs many"));
  }
  if (!many) return packOne(command);
  return packMany({.inputs = command.inputs,
                   .out_dir = command.out_dir,
                   .report = command.report,
                   .jobs = command.jobs,
                   .force = command.force,
                   .verbosity = command.verbosity,
                   .load = command.load,
                   .pack = packOptions(command.arguments)});
}

}  // namespace

CommandBody addPackCommand(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("pack", "Compress the meshes of an asset");
  auto command = std::make_shared<PackCommand>();
  verb->add_option("IN", command->inputs, "The asset; with --out-dir also folders, patterns and several")
      ->required()
      ->type_name("FILE|-");
  verb->add_option("-o,--output", command->output, "Where the packed asset goes")->type_name("FILE|-");
  verb->add_option("--out-dir", command->out_dir, "Pack many assets into this folder")->type_name("FOLDER");
  verb->add_option("-j,--jobs", command->jobs, "With --out-dir: assets at a time; 0 is one a processor")
      ->type_name("N")
      ->check(CLI::Range(0u, 1024u))
      ->capture_default_str();
  addPackOptions(*verb, command->arguments);
  verb->add_option("--report", command->report, "Write what was done as JSON")->type_name("FILE|-");
  verb->add_flag("--force", command->force, "Replace existing files");
  addLoadOptions(*verb, command->load);
  CLI::Option* quiet = verb->add_flag("--quiet", command->verbosity.quiet, "Say nothing unless something fails");
  verb->add_flag("--verbose", command->verbosity.verbose, "Say more about each stream")->excludes(quiet);
  return [command] { return runPack(*command); };
}

}  // namespace tsc::cli
