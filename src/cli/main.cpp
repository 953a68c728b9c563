// gltf-tsc: packs, unpacks, inspects and compares glTF assets with tangent-space compressed meshes.
//
// Exit codes: 0 done, 1 usage, 2 invalid input, 3 needs something unsupported, 4 input or output failed, 5 error bound
// not met. Messages go to standard error, data to standard output.
#include <fmt/core.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <vector>

#include "command.h"
#include "tsc/gltf.h"

namespace {

using tsc::cli::CommandBody;

constexpr std::array kCommands = {tsc::cli::addPackCommand, tsc::cli::addUnpackCommand, tsc::cli::addInspectCommand,
                                  tsc::cli::addCompareCommand};

constexpr int kUsage = static_cast<int>(tsc::FailureKind::kUsage);
constexpr int kUnsupported = static_cast<int>(tsc::FailureKind::kUnsupported);

int run(int argc, char** argv) {
  CLI::App app("Compresses the meshes of glTF assets in their tangent space, and expands them again.", "gltf-tsc");
  app.set_version_flag("--version", "gltf-tsc " GLTF_TSC_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Files are .gltf or .glb; - stands for standard input or output (GLB).\n"
      "Exit codes: 0 done, 1 usage, 2 invalid input, 3 unsupported, 4 I/O, 5 error bound not met.");
  std::vector<CommandBody> bodies;
  for (const auto add : kCommands) bodies.push_back(add(app));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    const auto chosen = app.get_subcommands();
    if (chosen.empty() && argc > 1 && argv[1][0] != '-') {
      fmt::print(stderr, "gltf-tsc: found '{}', expected pack, unpack, inspect or compare\n", argv[1]);
      return kUsage;
    }
    fmt::print(stderr, "gltf-tsc: {}\nTry 'gltf-tsc {}--help'.\n", error.what(),
               chosen.empty() ? "" : chosen[0]->get_name() + " ");
    return kUsage;
  }
  const auto verbs = app.get_subcommands([](const CLI::App*) { return true; });
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (verbs[i]->parsed()) return bodies[i]();
  }
  return kUsage;
}

}  // namespace

int main(int argc, char** argv) {
  // A reader that goes away is a failed write with a message, not a silent death.
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("gltf-tsc: not enough memory for this asset\n", stderr);
    return kUnsupported;
  } catch (const std::exception& error) {
    fmt::print(stderr, "gltf-tsc: {}\n", error.what());
    return kUnsupported;
  }
}
