// What all commands share: reading a set of meshes with progress, remembering results, saying what was measured.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "corpus.h"

namespace tsc::bench {

/// A set of meshes, as the command line names it.
struct MeshSet {
  std::vector<CorpusFile> files;
  std::vector<std::size_t> patch_sizes;  ///< if any: patches of so many vertices are cut from each mesh and replace it
  unsigned threads = 1;
};

/// Calls `measure` for each mesh, largest file first, from `threads` threads. Progress goes to standard error. A file
/// that cannot be read, and a mesh that `measure` throws std::runtime_error for, are reported there and counted.
/// Returns how many failed.
std::size_t forEachMesh(const MeshSet& set, const std::function<void(const BenchMesh&)>& measure);

/// "tsc-bench, commit ..., compiler ..., flags ..., CPU ...".
std::string provenance();

/// Hash of this executable: results of another build are not reused.
std::string buildKey();

/// Results that survive an interruption: a file of JSON lines, appended to as they come. Safe from several threads.
class ResultStore {
 public:
  /// Keeps what an earlier run with the same `key` left in the file; else starts it anew.
  ResultStore(std::string path, const std::string& key);
  /// Null when there is no result of that name.
  nlohmann::json find(const std::string& name) const;
  void add(const std::string& name, const nlohmann::json& result);

 private:
  std::string path_;
  mutable std::mutex mutex_;
  std::map<std::string, nlohmann::json> results_;
};

/// Writes a whole file. Throws std::runtime_error.
void writeFile(const std::string& path, const std::string& content);

}  // namespace tsc::bench
