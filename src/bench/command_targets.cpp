// tsc-bench targets: every figure that the codec has a goal for, in one run and one table.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <thread>

#include "build_info.h"
#include "commands.h"
#include "targets.h"

namespace tsc::bench {

namespace {

struct TargetsArguments {
  std::vector<std::string> inputs;
  std::string bits = "10,11,12,14", cache = kDefaultCacheFolder;
  std::size_t every = 1, max_every = 4;
  unsigned threads = std::max(1u, std::thread::hardware_concurrency());
  bool no_speed = false;
};

int runTargets(const TargetsArguments& arguments) {
  MeshSet set{listFiles(arguments.inputs), {}, arguments.threads};
  if (arguments.every > 1) set.files = everyNth(set.files, arguments.every);
  MeshSet patches = set;
  patches.patch_sizes = {200, 500, 1000, 2000, 5000};
  std::filesystem::create_directories(arguments.cache);
  ResultStore store(arguments.cache + "/targets.jsonl", buildKey() + " " + arguments.bits);

  RateOptions rate, small;
  rate.bits = small.bits = parseBits(arguments.bits);
  rate.variants = selectVariants("auto,auto-n2,max,max-n2", Effort::kDefault);
  small.variants = selectVariants("auto,max", Effort::kDefault);
  small.with_metrics = false;
  SpeedOptions speed;
  speed.variants = small.variants;

  EffortResults normal{"auto", "auto-n2", {}, {}, {}}, max{"max", "max-n2", {}, {}, {}};
  std::size_t failed = 0;
  fmt::print("{}\n\n{}", provenance(), rateLinesHeading());
  normal.rates = measureRatesByEffort(set, rate, arguments.max_every, arguments.cache, &store, failed);
  normal.patches = measureRatesByEffort(patches, small, arguments.max_every, arguments.cache, &store, failed);
  max.rates = normal.rates;
  max.patches = normal.patches;
  if (!arguments.no_speed) {
    SpeedsByEffort speeds = measureSpeedsByEffort(set, speed, kSpeedVertices, arguments.max_every, &store, failed);
    normal.speeds = std::move(speeds.normal);
    max.speeds = std::move(speeds.max);
  }
  const std::string max_note = arguments.max_every > 0 ? fmt::format("one file in {}", arguments.max_every) : "no file";
  fmt::print(
      "\n{}\n\n{}\nqp {}; whole streams; Draco 1.5.5. Vertices that no triangle uses are left out for all codecs. "
      "Effort "
      "max is\nmeasured on {}. Speed: medians over meshes of {} vertices and more, one thread.\n",
      provenance(), targetsTable(normal, max), arguments.bits, max_note, kSpeedVertices);
  failed += failedVariants(normal.rates) + failedVariants(normal.patches);
  if (failed > 0) fmt::print("{} measurements FAILED and are not in these figures\n", failed);
  return failed > 0 ? 2 : 0;
}

}  // namespace

void addTargetsCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<TargetsArguments>();
  CLI::App* command = app.add_subcommand(
      "targets", "The figures that the codec has goals for, in one table; run again after an interruption, it goes on");
  command->add_option("FILES", arguments->inputs, "glTF files, and folders of them: organic and cad")->required();
  command->add_option("--bits", arguments->bits, "settings: 10,11,12,14 or 8..16")->capture_default_str();
  command->add_option("--every", arguments->every, "measure every n-th file only")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--max-every", arguments->max_every, "run effort max on every n-th of these, 0: on none")
      ->capture_default_str();
  command->add_option("--threads", arguments->threads, "meshes measured at a time, except where time is measured")
      ->capture_default_str();
  command->add_option("--cache", arguments->cache, "folder for Draco's results and for what was measured already")
      ->capture_default_str();
  command->add_flag("--no-speed", arguments->no_speed, "leave time and memory out");
  command->callback([arguments, &exit_code] { exit_code = runTargets(*arguments); });
}

}  // namespace tsc::bench
