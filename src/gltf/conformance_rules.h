// The rules behind conformance.h, one file for each part of the document that they are about, and what these share.
// Numbers in comments are those of the rules.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "conformance.h"
#include "fault.h"
#include "json_document.h"

namespace tsc {

inline constexpr std::array kMeshoptNames = {std::string_view("EXT_meshopt_compression"),
                                             std::string_view("KHR_meshopt_compression")};

inline std::string viewPlace(std::size_t view) { return "/bufferViews/" + number(view); }

inline bool isPositions(const OutputInfo& output) { return output.kind == OutputInfo::Kind::kPositions; }

/// Whether a buffer is a placeholder.
bool hasNoBytes(const Asset& asset, std::uint64_t buffer);

/// Raises a failure if member `key` of `holder` is there and not `expected`.
void expectIfDefined(const JsonView& holder, const char* key, std::uint64_t expected, const std::string& why);

/// The same if it is there at all.
void expectUndefined(const JsonView& holder, const char* key, const std::string& why);

/// 1: the extension stands in `list`. `cause`: what makes that necessary.
void expectListed(const Json& document, const char* list, const std::string& cause);

/// 10 and 1: where compressed views lie.
void checkPlaces(const Asset& asset, const std::vector<PackedStream>& streams);

/// 11: what else lies there.
void checkMarkedBuffers(const Json& document);

/// 7, 9 and the exclusions: accessors and primitives. POSITION accessors on compressed views are noted in their
/// streams.
void checkUses(const Json& document, std::vector<PackedStream>& streams);

}  // namespace tsc
