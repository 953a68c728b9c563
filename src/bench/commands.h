// The commands of tsc-bench. Each adds itself to the command line; the callback it sets returns through `exit_code`.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "rate.h"
#include "run.h"
#include "speed.h"

namespace tsc::bench {

void addRateCommand(CLI::App& app, int& exit_code);
void addSpeedCommand(CLI::App& app, int& exit_code);
void addPlaneCommand(CLI::App& app, int& exit_code);
void addTargetsCommand(CLI::App& app, int& exit_code);
void addReportCommand(CLI::App& app, int& exit_code);

/// How many meshes --quick takes.
inline constexpr std::size_t kQuickMeshCount = 6;

/// "10,11,12,14" or "8..16" as a rising list. Throws std::runtime_error when it is neither, or leaves 4..24.
std::vector<int> parseBits(const std::string& text);

/// Rates of all meshes of a set, in the order of class and name. With a store, results that it holds are not measured
/// again. Prints each mesh's lines on standard output as it is done. Adds the number of failures to `failed`.
std::vector<MeshRate> measureRates(const MeshSet& set, const RateOptions& options, const std::string& cache_folder,
                                   ResultStore* store, std::size_t& failed);

/// The same in two passes: effort max, which is slow, on every `max_every`-th file alone (on none if 0).
std::vector<MeshRate> measureRatesByEffort(const MeshSet& set, const RateOptions& options, std::size_t max_every,
                                           const std::string& cache_folder, ResultStore* store, std::size_t& failed);

/// Meshes that speed is summarised over have at least so many vertices.
inline constexpr std::size_t kSpeedVertices = 20000;

/// Speeds of the meshes of a set that have `min_vertices`, or of all if none has, one after the other in this thread.
/// With a store as above. Prints each mesh's table. Adds the number of failures to `failed`.
std::vector<MeshSpeed> measureSpeeds(const MeshSet& set, const SpeedOptions& options, std::size_t min_vertices,
                                     ResultStore* store, std::size_t& failed);

struct SpeedsByEffort {
  std::vector<MeshSpeed> normal, max;
};
/// The same in two passes, as `measureRatesByEffort`.
SpeedsByEffort measureSpeedsByEffort(const MeshSet& set, const SpeedOptions& options, std::size_t min_vertices,
                                     std::size_t max_every, ResultStore* store, std::size_t& failed);

/// The mesh of most vertices in a set.
BenchMesh largestMesh(const MeshSet& set);

}  // namespace tsc::bench
