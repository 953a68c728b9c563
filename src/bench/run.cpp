// What all commands share.
#include "run.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "build_info.h"

namespace tsc::bench {

namespace {

std::string cpuName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown CPU";
}

std::vector<BenchMesh> meshesOf(const CorpusFile& file, const std::vector<std::size_t>& patch_sizes) {
  std::vector<BenchMesh> meshes = loadMeshes(file.path);
  if (patch_sizes.empty()) return meshes;
  std::vector<BenchMesh> patches;
  for (const BenchMesh& mesh : meshes) {
    for (const std::size_t size : patch_sizes) {
      patches.push_back(cutPatch(mesh, size));
      patches.back().class_name = "patches";
    }
  }
  return patches;
}

}  // namespace

std::size_t forEachMesh(const MeshSet& set, const std::function<void(const BenchMesh&)>& measure) {
  std::vector<CorpusFile> files = set.files;
  std::stable_sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.bytes > b.bytes; });
  // The metrics are parallel within: together they are to use no more threads than were asked for.
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, std::max(1u, set.threads));
  std::atomic<std::size_t> next = 0, done = 0, failed = 0;
  const bool on_terminal = isatty(STDERR_FILENO) != 0;
  const auto start = std::chrono::steady_clock::now();
  const auto report = [&](const std::string& name, const char* error) {
    ++failed;
    fmt::print(stderr, "\n{}: {}\n", name, error);
  };
  const auto work = [&] {
    for (std::size_t i; (i = next++) < files.size();) {
      try {
        for (const BenchMesh& mesh : meshesOf(files[i], set.patch_sizes)) {
          try {
            measure(mesh);
          } catch (const std::runtime_error& error) {
            report(mesh.name, error.what());
          }
        }
      } catch (const std::runtime_error& error) {
        report(files[i].path.string(), error.what());
      }
      const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
      const std::size_t number = ++done;
      // On a terminal one line that is written over; in a log a line now and then.
      if (on_terminal || number % 10 == 0 || number == files.size()) {
        fmt::print(stderr, "{}[{}/{}] {:.0f} s{}", on_terminal ? "\r" : "", number, files.size(), elapsed.count(),
                   on_terminal ? " " : "\n");
      }
    }
  };
  {
    std::vector<std::jthread> others;
    for (unsigned t = 1; t < set.threads; ++t) others.emplace_back(work);
    work();
  }
  if (on_terminal) fmt::print(stderr, "\n");
  return failed;
}

std::string provenance() {
  return fmt::format("tsc-bench, commit {}, {}, {}; Draco 1.5.5 and meshoptimizer 0.18 as packaged by Debian; {}",
                     kCommit, kCompiler, kFlags, cpuName());
}

std::string buildKey() {
  std::ifstream file("/proc/self/exe", std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  return fmt::format("{:016x}", XXH64(bytes.data(), bytes.size(), 0));
}

ResultStore::ResultStore(std::string path, const std::string& key) : path_(std::move(path)) {
  std::ifstream file(path_);
  std::string line;
  if (std::getline(file, line) && line == key) {
    while (std::getline(file, line)) {
      // A line cut short by an interruption does not parse: that mesh is measured again.
      const auto json = nlohmann::json::parse(line, nullptr, false);
      if (json.is_object()) results_[json["name"]] = json["result"];
    }
    file.close();
    std::ofstream(path_, std::ios::app) << '\n';
    return;
  }
  file.close();
  writeFile(path_, key + "\n");
}

nlohmann::json ResultStore::find(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = results_.find(name);
  return found == results_.end() ? nlohmann::json() : found->second;
}

void ResultStore::add(const std::string& name, const nlohmann::json& result) {
  const std::lock_guard lock(mutex_);
  results_[name] = result;
  std::ofstream(path_, std::ios::app) << nlohmann::json{{"name", name}, {"result", result}}.dump() << '\n';
}

void writeFile(const std::string& path, const std::string& content) {
  std::ofstream file(path, std::ios::binary);
  file << content;
  file.close();
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace tsc::bench
