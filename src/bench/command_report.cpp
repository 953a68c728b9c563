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
  unsigned threads = std::max(1u, std::thread::hardware_concurrency());
  bool quick = false;
};

/// A variant list without what would take too long on hundreds of small patches and says nothing there.
std::vector<Variant> patchVariants(const std::vector<Variant>& variants) {
  std::vector<Variant> kept;
  for (const Variant& variant : variants) {
    if (variant.name == "auto" || variant.name == "max") kept.push_back(variant);
  }
  return kept;
}

int runReport(ReportArguments arguments) {
  if (arguments.modes.empty()) arguments.modes = arguments.quick ? "figure3,max" : "all";
  std::filesystem::create_directories(arguments.output);
  const std::string folder = arguments.output + "/";
  MeshSet set{listFiles(arguments.inputs), {}, arguments.threads};
  if (arguments.quick) set.files = spreadSelection(set.files, kQuickMeshCount);

  ReportData data;
  data.provenance = provenance();
  data.command = fmt::format("tsc-bench report {} -o {} --modes {} --bits {}{}", fmt::join(arguments.inputs, " "),
                             arguments.output, arguments.modes, arguments.bits, arguments.quick ? " --quick" : "");
  ResultStore store(folder + "results.jsonl", fmt::format("{} {} {}", buildKey(), arguments.modes, arguments.bits));
  std::size_t failed = 0;

  RateOptions rate;
  rate.bits = parseBits(arguments.bits);
  rate.variants = selectVariants(arguments.modes, Effort::kDefault);
  fmt::print("{}\n\n1/4 rate and distortion\n{}", data.provenance, rateLinesHeading());
  data.rates = measureRates(set, rate, arguments.cache, &store, failed);
  if (data.rates.empty()) return 2;

  RateOptions small = rate;
  small.variants = patchVariants(rate.variants);
  small.with_metrics = false;
  if (!small.variants.empty()) {
    fmt::print("\n2/4 patches of 200 to 5000 vertices\n");
    MeshSet patches = set;
    patches.patch_sizes = {200, 500, 1000, 2000, 5000};
    data.patches = measureRates(patches, small, arguments.cache, &store, failed);
  }

  fmt::print("\n3/4 speed, one thread\n");
  SpeedOptions speed;
  speed.variants = patchVariants(rate.variants);
  BenchMesh largest;
  MeshSet one_thread{set.files, {}, 1};
  failed += measureSpeeds(one_thread, speed, &store, data.speeds, largest);
  for (const BenchMesh& mesh : sizeSeries(largest, arguments.quick ? 100000 : 1000000)) {
    const nlohmann::json known = store.find("series/" + mesh.name);
    if (known.is_null()) {
      data.series.push_back(measureSpeed(mesh, speed));
      store.add("series/" + mesh.name, data.series.back());
    } else {
      data.series.push_back(known.get<MeshSpeed>());
    }
    fmt::print("{}\n", speedLines(data.series.back()));
    std::fflush(stdout);
  }

  fmt::print("\n4/4 plane\n");
  data.plane = measurePlane({});
  fmt::print("{}", planeTable(data.plane));

  writeFile(folder + "index.html", reportPage(data));
  writeFile(folder + "points.csv", pointsCsv(data.rates));
  writeFile(folder + "ratios.csv", ratiosCsv(data.rates));
  writeFile(folder + "patches.csv", ratiosCsv(data.patches));
  std::vector<MeshSpeed> speeds = data.speeds;
  speeds.insert(speeds.end(), data.series.begin(), data.series.end());
  writeFile(folder + "speed.csv", speedCsv(speeds));
  fmt::print("\n{}\n{}\nwritten: {}index.html\n", summaryTable(summarize(data.rates)),
             data.patches.empty() ? "" : summaryTable(summarize(data.patches)), folder);
  return failed > 0 ? 2 : 0;
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
  command->add_option("--bits", arguments->bits, "settings: 10,11,12,14 or 8..16")->capture_default_str();
  command->add_option("--threads", arguments->threads, "meshes measured at a time, except where time is measured")
      ->capture_default_str();
  command->add_option("--cache", arguments->cache, "folder for Draco's results")->capture_default_str();
  command->add_flag("--quick", arguments->quick, "six meshes only, spread over the folders");
  command->callback([arguments, &exit_code] { exit_code = runReport(*arguments); });
}

}  // namespace tsc::bench
