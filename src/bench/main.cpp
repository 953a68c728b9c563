// tsc-bench: this codec beside its peers, on the same input, in one run.
//
// Exit codes: 0 done, 1 usage, 2 something could not be measured (it is said what).
#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "commands.h"

int main(int argc, char** argv) {
  CLI::App app("Measures the tangent-space mesh codec beside Draco, meshoptimizer and a Laplacian baseline");
  app.require_subcommand(1);
  int exit_code = 0;
  tsc::bench::addRateCommand(app, exit_code);
  tsc::bench::addSpeedCommand(app, exit_code);
  tsc::bench::addPlaneCommand(app, exit_code);
  tsc::bench::addTargetsCommand(app, exit_code);
  tsc::bench::addReportCommand(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "tsc-bench: {}\n", error.what());
    return 2;
  }
  return exit_code;
}
