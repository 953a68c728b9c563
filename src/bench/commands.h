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
void addReportCommand(CLI::App& app, int& exit_code);

/// How many meshes --quick takes.
inline constexpr std::size_t kQuickMeshCount = 6;

/// "10,11,12,14" or "8..16" as a rising list. Throws std::runtime_error when it is neither, or leaves 4..24.
std::vector<int> parseBits(const std::string& text);

/// Rates of all meshes of a set, in the order of class and name. With a store, results that it holds are not measured
/// again. Prints each mesh's lines on standard output as it is done. Adds the number of failures to `failed`.
std::vector<MeshRate> measureRates(const MeshSet& set, const RateOptions& options, const std::string& cache_folder,
                                   ResultStore* store, std::size_t& failed);

/// Speeds of all meshes of a set, added to `meshes`, with a store as above; `largest` becomes the one of most vertices.
/// Returns how many meshes failed.
std::size_t measureSpeeds(const MeshSet& set, const SpeedOptions& options, ResultStore* store,
                          std::vector<MeshSpeed>& meshes, BenchMesh& largest);

}  // namespace tsc::bench
