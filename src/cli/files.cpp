#include "files.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

#include "../gltf/file_io.h"

namespace tsc::cli {
namespace {

namespace fs = std::filesystem;

Failure ioFailure(const std::string& what) {
  return {FailureKind::kIo, fmt::format("{}: {}", what, std::strerror(errno))};
}

Expected<std::vector<std::byte>> readStandardInput(std::uint64_t max_bytes) {
  std::vector<std::byte> bytes;
  std::array<std::byte, 1 << 16> block;
  while (true) {
    const ssize_t count = ::read(STDIN_FILENO, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return ioFailure("standard input: cannot be read");
    if (count == 0) return bytes;
    bytes.insert(bytes.end(), block.begin(), block.begin() + count);
    if (bytes.size() > max_bytes) {
      return Failure{FailureKind::kInvalidInput,
                     fmt::format("standard input: more than {} bytes, the limit for one file", max_bytes)};
    }
  }
}

Outcome writeAll(int descriptor, std::span<const std::byte> bytes, const std::string& where) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return ioFailure(where + ": cannot be written");
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

/// Something to write into rather than to replace: a pipe, a terminal, /dev/null.
bool isStream(const std::string& output) {
  std::error_code error;
  const fs::file_status status = fs::status(output, error);
  return fs::is_character_file(status) || fs::is_fifo(status) || fs::is_socket(status) || fs::is_block_file(status);
}

Outcome writeStream(const std::string& output, std::span<const std::byte> bytes) {
  if (output == "-") return writeAll(STDOUT_FILENO, bytes, "standard output");
  const int descriptor = ::open(output.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return ioFailure(output + ": cannot be opened for writing");
  Outcome outcome = writeAll(descriptor, bytes, output);
  if (::close(descriptor) != 0 && !outcome) outcome = ioFailure(output + ": cannot be written");
  return outcome;
}

}  // namespace

Expected<Asset> loadInput(const std::string& input, const LoadOptions& options) {
  std::error_code error;
  if (fs::is_directory(input, error)) {
    return Failure{FailureKind::kUsage, fmt::format("{}: found a folder, expected the name of a file", input)};
  }
  if (input != "-") return loadAsset(fs::path(input), options);
  auto bytes = readStandardInput(options.limits.max_input_bytes);
  if (!bytes) return bytes.failure();
  return loadAsset(*bytes, "standard input", {}, options);
}

Outcome checkTextOutput(const std::string& output, bool force) {
  if (output == "-" || isStream(output)) return {};
  std::error_code error;
  const fs::path path = output;
  if (fs::is_directory(path, error)) {
    return Failure{FailureKind::kUsage, fmt::format("{}: found a folder, expected the name of a file", output)};
  }
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error)) {
    return Failure{FailureKind::kIo, fmt::format("{}: there is no folder {}", output, folder.string())};
  }
  if (!force && fs::exists(fs::symlink_status(path, error))) {
    return Failure{FailureKind::kUsage, fmt::format("{}: exists already; --force replaces it", output)};
  }
  return {};
}

Outcome checkOutput(const std::string& output, bool force) {
  const std::string extension = lowerExtension(output);
  if (output != "-" && !isStream(output) && extension != ".gltf" && extension != ".glb") {
    return Failure{FailureKind::kUsage,
                   fmt::format("{}: found the file name extension '{}', expected .gltf, .glb, or - for standard output",
                               output, fs::path(output).extension().string())};
  }
  return checkTextOutput(output, force);
}

Outcome saveOutput(const Asset& asset, const std::string& output, bool force) {
  if (output != "-" && !isStream(output)) return saveAsset(asset, output, {.force = force});
  auto bytes = writeGlb(asset);
  if (!bytes) return bytes.failure();
  return writeStream(output, *bytes);
}

Outcome saveText(const std::string& text, const std::string& output, bool force) {
  const auto bytes = std::as_bytes(std::span(text));
  if (output == "-" || isStream(output)) return writeStream(output, bytes);
  return writeFile(output, bytes, force);
}

}  // namespace tsc::cli
