// tsc-bench plane: the paper's Figure 2.
#include <fmt/format.h>

#include <algorithm>

#include "commands.h"
#include "plane.h"

namespace tsc::bench {

void addPlaneCommand(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<PlaneOptions>();
  CLI::App* command =
      app.add_subcommand("plane", "A rotated plane at equal rate, in world and tangent space (Figure 2)");
  command->add_option("--side", options->side, "vertices along an edge of the plane")
      ->check(CLI::Range(4, 2000))
      ->capture_default_str();
  command->add_option("--degrees", options->degrees, "turn around the x axis")->capture_default_str();
  command->add_option("--bpv", options->bits_per_vertex, "bits per vertex that all codecs are brought to")
      ->check(CLI::Range(1.0, 90.0))
      ->capture_default_str();
  command->callback([options, &exit_code] {
    const std::vector<PlaneRow> rows = measurePlane(*options);
    fmt::print("{}\nplane of {} x {} vertices, jittered within itself, turned {} degrees around x\n\n{}\n{}",
               provenance(), options->side, options->side, options->degrees, planeTable(rows), planeNote());
    exit_code = std::any_of(rows.begin(), rows.end(), [](const auto& row) { return !row.error.empty(); }) ? 2 : 0;
  });
}

}  // namespace tsc::bench
