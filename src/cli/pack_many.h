// gltf-tsc pack with many inputs: folders, patterns and files into one folder, several at a time.
#pragma once

#include <string>
#include <vector>

#include "options.h"
#include "tsc/gltf.h"

namespace tsc::cli {

struct PackManyRequest {
  std::vector<std::string> inputs;  ///< files, folders (searched to any depth), patterns with * ? [
  std::string out_dir;              ///< made if absent; a folder's own structure is kept inside
  std::string report;               ///< NDJSON, a line per asset, in the order of the inputs; "-": standard output
  unsigned jobs = 0;                ///< assets at a time; 0: one a processor. No effect on what is written
  bool force = false;
  Verbosity verbosity;
  LoadOptions load;
  PackOptions pack;
};

/// Packs all that can be packed; an asset that fails does not stop the others. Assets whose content and options have
/// not changed since the last run into the same folder are skipped. Returns the exit code: that of the first failure.
int packMany(const PackManyRequest& request);

}  // namespace tsc::cli
