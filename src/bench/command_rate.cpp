// tsc-bench rate: rate-distortion against Draco.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "build_info.h"
#include "commands.h"

namespace tsc::bench {

namespace {

struct RateArguments {
  std::vector<std::string> inputs;
  std::string bits = "10,11,12,14", modes = "auto", effort = "default", csv, cache = kDefaultCacheFolder;
  std::vector<std::size_t> patches;
  unsigned threads = std::max(1u, std::thread::hardware_concurrency());
  std::size_t max_every = 1;
  bool quick = false, fast = false;
};

std::string variantNames(const std::vector<Variant>& variants) {
  std::string names;
  for (const Variant& variant : variants) names += (names.empty() ? "" : ",") + variant.name;
  return names;
}

int runRate(const RateArguments& arguments) {
  RateOptions options;
  options.bits = parseBits(arguments.bits);
  options.variants = selectVariants(arguments.modes, arguments.effort == "max" ? Effort::kMax : Effort::kDefault);
  options.with_metrics = !arguments.fast;
  MeshSet set{listFiles(arguments.inputs), arguments.patches, arguments.threads};
  if (arguments.quick) set.files = spreadSelection(set.files, kQuickMeshCount);

  fmt::print("{}\n\n{}", provenance(), rateLinesHeading());
  std::size_t failed = 0;
  const std::vector<MeshRate> meshes =
      measureRatesByEffort(set, options, arguments.max_every, arguments.cache, nullptr, failed);
  if (meshes.empty()) return 2;
  fmt::print("\n{}", summaryTable(summarize(meshes)));
  fmt::print(
      "\nBD-rate: piecewise-cubic (PCHIP) log bits over log MSE through qp {}; whole streams; Draco 1.5.5.\n"
      "MSE, DAME and Metro (RMS): ours over Draco's at Draco's rate at qp {}.\n",
      arguments.bits, kReferenceBits);
  if (!arguments.csv.empty()) {
    writeFile(arguments.csv, pointsCsv(meshes));
    const std::string::size_type dot = arguments.csv.rfind(".csv");
    writeFile(arguments.csv.substr(0, dot) + "-ratios.csv", ratiosCsv(meshes));
  }
  return failed + failedVariants(meshes) > 0 ? 2 : 0;
}

}  // namespace

std::vector<int> parseBits(const std::string& text) {
  std::vector<int> bits;
  const auto number = [&](const std::string& part) {
    int value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc() || end != part.data() + part.size() || value < 4 || value > 24) {
      throw std::runtime_error("--bits: expected a list like 10,11,12,14 or a range like 8..16 within 4..24, found " +
                               text);
    }
    return value;
  };
  if (const auto dots = text.find(".."); dots != std::string::npos) {
    const int last = number(text.substr(dots + 2));
    for (int value = number(text.substr(0, dots)); value <= last; ++value) bits.push_back(value);
  } else {
    std::stringstream list(text);
    for (std::string part; std::getline(list, part, ',');) bits.push_back(number(part));
  }
  std::sort(bits.begin(), bits.end());
  bits.erase(std::unique(bits.begin(), bits.end()), bits.end());
  if (bits.size() < 2) throw std::runtime_error("--bits: a curve needs at least two settings, found " + text);
  return bits;
}

std::vector<MeshRate> measureRates(const MeshSet& set, const RateOptions& options, const std::string& cache_folder,
                                   ResultStore* store, std::size_t& failed) {
  DracoCache cache(cache_folder);
  std::mutex mutex;
  std::vector<MeshRate> meshes;
  failed += forEachMesh(set, [&](const BenchMesh& mesh) {
    const std::string id = fmt::format("{} {} {}/{} {}", options.with_metrics ? "rate" : "fast rate",
                                       variantNames(options.variants), mesh.class_name, mesh.name, mesh.contentKey());
    MeshRate rate;
    const nlohmann::json known = store != nullptr ? store->find(id) : nlohmann::json();
    if (known.is_null()) {
      rate = measureRate(mesh, options, cache);
      if (store != nullptr) store->add(id, rate);
    } else {
      rate = known.get<MeshRate>();
    }
    const std::lock_guard lock(mutex);
    fmt::print("{}", rateLines(rate));
    std::fflush(stdout);
    meshes.push_back(std::move(rate));
  });
  std::sort(meshes.begin(), meshes.end(), [](const MeshRate& a, const MeshRate& b) {
    return std::tie(a.class_name, a.name) < std::tie(b.class_name, b.name);
  });
  return meshes;
}

std::vector<MeshRate> measureRatesByEffort(const MeshSet& set, const RateOptions& options, std::size_t max_every,
                                           const std::string& cache_folder, ResultStore* store, std::size_t& failed) {
  RateOptions pass = options;
  std::vector<MeshRate> meshes;
  pass.variants = variantsOfEffort(options.variants, Effort::kDefault);
  if (!pass.variants.empty()) meshes = measureRates(set, pass, cache_folder, store, failed);
  pass.variants = variantsOfEffort(options.variants, Effort::kMax);
  if (pass.variants.empty() || max_every == 0) return meshes;
  MeshSet part = set;
  part.files = everyNth(set.files, max_every);
  mergeRates(meshes, measureRates(part, pass, cache_folder, store, failed));
  return meshes;
}

void addRateCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RateArguments>();
  CLI::App* command = app.add_subcommand("rate", "Rate-distortion against Draco -cl 7 and -cl 10");
  command->add_option("FILES", arguments->inputs, "glTF files, and folders of them")->required();
  command->add_option("--bits", arguments->bits, "settings: 10,11,12,14 or 8..16")->capture_default_str();
  command->add_option("--modes", arguments->modes, "codecs: all, figure3, or names separated by commas")
      ->capture_default_str();
  command->add_option("--effort", arguments->effort, "effort of our modes")
      ->check(CLI::IsMember({"default", "max"}))
      ->capture_default_str();
  command->add_option("--max-every", arguments->max_every, "run effort max on every n-th file only, 0: on none")
      ->capture_default_str();
  command
      ->add_option("--patches", arguments->patches, "measure patches of so many vertices instead of the whole meshes")
      ->delimiter(',');
  command->add_option("--csv", arguments->csv, "write FILE.csv and FILE-ratios.csv");
  command->add_option("--threads", arguments->threads, "meshes measured at a time")->capture_default_str();
  command->add_option("--cache", arguments->cache, "folder for Draco's results")->capture_default_str();
  command->add_flag("--quick", arguments->quick, "six meshes only, spread over the folders");
  command->add_flag("--fast", arguments->fast, "no search for Draco's rate, no Metro, no DAME");
  command->callback([arguments, &exit_code] { exit_code = runRate(*arguments); });
}

}  // namespace tsc::bench
