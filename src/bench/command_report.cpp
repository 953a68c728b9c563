// tsc-bench report: all experiments over a corpus, as one HTML page and CSV files.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "build_info.h"
#include "commands.h"
#include "report_page.h"

namespace tsc::bench {

namespace {

struct ReportArguments {
  std::vector<std::string> inputs;
  std::string output = "tsc-bench-report", modes, bits = "10,11,12,14", cache = kDefaultCacheFolder;
  std::size_t max_every = 4;
  unsigned threads = std::max(1u, std::thread::hardware_concurrency());
  bool quick = false;
};

/// A variant list without what would take too long on hundreds of small patches, or against a clock, and says nothing
/// there.
std::vector<Variant> mainVariants(const std::vector<Variant>& variants) {
  std::vector<Variant> kept;
  for (const Variant& variant : variants) {
    if (variant.name == "auto" || variant.name == "max") kept.push_back(variant);
  }
  return kept;
}

/// One mesh at rising sizes. Effort max takes part up to kMaxEffortVertices: its lines are straight from there on.
std::vector<MeshSpeed> measureSeries(const BenchMesh& source, const std::vector<Variant>& variants, std::size_t largest,
                                     ResultStore& store) {
  constexpr std::size_t kMaxEffortVertices = 100000;
  std::vector<MeshSpeed> series;
  for (const BenchMesh& mesh : sizeSeries(source, largest)) {
    const std::string id = "series " + mesh.name;
    const nlohmann::json known = store.find(id);
    if (!known.is_null()) {
      series.push_back(known.get<MeshSpeed>());
      continue;
    }
    SpeedOptions options;
    options.variants =
        mesh.vertexCount() > 2 * kMaxEffortVertices ? variantsOfEffort(variants, Effort::kDefault) : variants;
    series.push_back(measureSpeed(mesh, options));
    store.add(id, series.back());
    fmt::print("{}\n", speedLines(series.back()));
    std::fflush(stdout);
  }
  return series;
}

int runReport(ReportArguments arguments) {
  if (arguments.modes.empty()) arguments.modes = arguments.quick ? "figure3,max" : "all";
  std::filesystem::create_directories(arguments.output);
  const std::string folder = arguments.output + "/";
  MeshSet set{listFiles(arguments.inputs), {}, arguments.threads};
  if (arguments.quick) set.files = spreadSelection(set.files, kQuickMeshCount);

  ReportData data;
  data.provenance = provenance();
  data.command = fmt::format("tsc-bench report {} -o {} --modes {} --bits {} --max-every {}{}",
                             fmt::join(arguments.inputs, " "), arguments.output, arguments.modes, arguments.bits,
                             arguments.max_every, arguments.quick ? " --quick" : "");
  ResultStore store(folder + "results.jsonl", buildKey() + " " + arguments.bits);
  std::size_t failed = 0;

  RateOptions rate;
  rate.bits = parseBits(arguments.bits);
  rate.variants = selectVariants(arguments.modes, Effort::kDefault);
  fmt::print("{}\n\n1/4 rate and distortion\n{}", data.provenance, rateLinesHeading());
  data.rates = measureRatesByEffort(set, rate, arguments.max_every, arguments.cache, &store, failed);
  if (data.rates.empty()) return 2;

  RateOptions small = rate;
  small.variants = mainVariants(rate.variants);
  small.with_metrics = false;
  if (!small.variants.empty()) {
    fmt::print("\n2/4 patches of 200 to 5000 vertices\n");
    MeshSet patches = set;
    patches.patch_sizes = {200, 500, 1000, 2000, 5000};
    data.patches = measureRatesByEffort(patches, small, arguments.max_every, arguments.cache, &store, failed);
  }

  fmt::print("\n3/4 speed, one thread\n");
  SpeedOptions speed;
  speed.variants = mainVariants(rate.variants);
  SpeedsByEffort speeds = measureSpeedsByEffort(set, speed, kSpeedVertices, arguments.max_every, &store, failed);
  data.speeds = std::move(speeds.normal);
  data.speeds_max = std::move(speeds.max);
  data.series = measureSeries(largestMesh(set), speed.variants, arguments.quick ? 100000 : 1000000, store);

  fmt::print("\n4/4 plane\n");
  data.plane = measurePlane({});
  fmt::print("{}", planeTable(data.plane));

  writeFile(folder + "index.html", reportPage(data));
  writeFile(folder + "points.csv", pointsCsv(data.rates));
  writeFile(folder + "ratios.csv", ratiosCsv(data.rates));
  writeFile(folder + "patches.csv", ratiosCsv(data.patches));
  std::vector<MeshSpeed> all_speeds = data.speeds;
  for (const auto* part : {&data.speeds_max, &data.series}) {
    all_speeds.insert(all_speeds.end(), part->begin(), part->end());
  }
  writeFile(folder + "speed.csv", speedCsv(all_speeds));
  fmt::print("\n{}\n{}\nwritten: {}index.html\n", summaryTable(summarize(data.rates)),
             data.patches.empty() ? "" : summaryTable(summarize(data.patches)), folder);
  return failed + failedVariants(data.rates) + failedVariants(data.patches) > 0 ? 2 : 0;
}

}  // namespace

void addReportCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command = app.add_subcommand("report",
                                         "All experiments over a corpus, as an HTML page and CSV files; run again "
                                         "after an interruption, it goes on where it stopped");
  command->add_option("DIR", arguments->inputs, "folders of glTF files, or files")->required();
  command->add_option("-o,--output", arguments->output, "folder for the page, the CSV files and intermediate results")
      ->capture_default_str();
  command->add_option("--modes", arguments->modes,
                      "codecs: all, figure3, or names separated by commas; default: all, with "
                      "--quick figure3,max");
  command->add_option("--max-every", arguments->max_every, "run effort max on every n-th file only, 0: on none")
      ->capture_default_str();
  command->add_option("--bits", arguments->bits, "settings: 10,11,12,14 or 8..16")->capture_default_str();
  command->add_option("--threads", arguments->threads, "meshes measured at a time, except where time is measured")
      ->capture_default_str();
  command->add_option("--cache", arguments->cache, "folder for Draco's results")->capture_default_str();
  command->add_flag("--quick", arguments->quick, "six meshes only, spread over the folders");
  command->callback([arguments, &exit_code] { exit_code = runReport(*arguments); });
}

}  // namespace tsc::bench
