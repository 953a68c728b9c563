// What pack did, for people and as JSON.
#pragma once

#include <string>

#include "options.h"
#include "tsc/gltf.h"

namespace tsc::cli {

/// The report of one file. No times in it: equal input gives equal reports.
Json packReportJson(const std::string& input, const std::string& output, const PackReport& report);

/// Streams, modes and sizes as lines on standard error.
void printPackReport(const std::string& input, const std::string& output, const PackReport& report,
                     const Verbosity& verbosity);

/// "tangent tip, adaptive, degree order, normal x2": how a stream is built.
std::string describeModes(const StreamModes& modes);

Json modesJson(const StreamModes& modes);

/// "369720 bytes -> 41234 bytes (11.2%)"
std::string describeSizes(std::uint64_t before, std::uint64_t after);

}  // namespace tsc::cli
