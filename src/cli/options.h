// What the verbs' command lines have in common.
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "tsc/gltf.h"

namespace tsc::cli {

/// How loud the program is.
struct Verbosity {
  bool quiet = false;    ///< failures only
  bool verbose = false;  ///< more about each stream
};

/// Adds `--allow-external` and `--max-output-bytes`.
void addLoadOptions(CLI::App& verb, LoadOptions& options);

/// Where the pack options of the command line go. Strings, as typed, until `packOptions` reads them.
struct PackArguments {
  int position_bits = 14;
  double step = 0, max_error = 0, relative_error = 0, target_bpv = 0;
  std::uint32_t normal_scale = 1;
  std::string mode = "auto", basis = "auto", predictor = "auto", order = "auto", effort = "default";
  bool fallback = false, keep_order = false, repack = false;
};

/// Adds the options that shape the packed asset.
void addPackOptions(CLI::App& verb, PackArguments& arguments);

/// The options as the library wants them.
PackOptions packOptions(const PackArguments& arguments);

/// The options' names, as typed and as printed.
const char* name(Mode mode);
const char* name(Basis basis);
const char* name(Predictor predictor);
const char* name(Order order);
const char* name(Effort effort);

/// Prints a failure; returns the exit code.
int fail(const Failure& failure);

}  // namespace tsc::cli
