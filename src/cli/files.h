// Files as the command line names them: a path, or - for standard input and output.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "tsc/gltf.h"

namespace tsc::cli {

/// Loads an asset from a path or, for "-", from standard input.
Expected<Asset> loadInput(const std::string& input, const LoadOptions& options);

/// Fails early, before any work: a name that says neither .gltf nor .glb, a missing folder, an existing file without
/// `force`.
Outcome checkOutput(const std::string& output, bool force);

/// Saves to a path; "-", and anything that exists and is no regular file (a pipe, a device), gets a GLB written to it.
Outcome saveOutput(const Asset& asset, const std::string& output, bool force);

/// Like `checkOutput` for a text file, whatever its name.
Outcome checkTextOutput(const std::string& output, bool force);

/// Writes text to a path or, for "-", to standard output.
Outcome saveText(const std::string& text, const std::string& output, bool force);

}  // namespace tsc::cli
