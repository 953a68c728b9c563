// gltf-tsc unpack: a packed asset back to plain glTF 2.0.
#include <fmt/core.h>

#include <CLI/App.hpp>
#include <cstdio>
#include <memory>

#include "command.h"
#include "files.h"
#include "options.h"
#include "progress.h"

namespace tsc::cli {
namespace {

struct UnpackCommand {
  std::string input, output;
  bool force = false;
  bool quiet = false;
  LoadOptions load;
};

int runUnpack(const UnpackCommand& command) {
  if (Outcome bad = checkOutput(command.output, command.force)) return fail(*bad);
  auto asset = loadInput(command.input, command.load);
  if (!asset) return fail(asset.failure());
  const bool packed = isPacked(*asset);
  if (Outcome bad = unpackAsset(*asset)) return fail(*bad);
  if (Outcome bad = saveOutput(*asset, command.output, command.force)) return fail(*bad);
  if (!command.quiet) {
    fmt::print(stderr, "{} -> {}: {}\n", command.input, command.output, packed ? "unpacked" : "was not packed, copied");
  }
  return 0;
}

}  // namespace

CommandBody addUnpackCommand(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("unpack", "Turn a packed asset into plain glTF");
  auto command = std::make_shared<UnpackCommand>();
  verb->add_option("IN", command->input, "The packed asset")->required()->type_name("FILE|-");
  verb->add_option("-o,--output", command->output, "Where the plain asset goes")->required()->type_name("FILE|-");
  verb->add_flag("--force", command->force, "Replace existing files");
  verb->add_flag("--quiet", command->quiet, "Say nothing unless something fails");
  addLoadOptions(*verb, command->load);
  return [command] { return runUnpack(*command); };
}

}  // namespace tsc::cli
