// Several assets at a time share nothing but the list of results, so the bytes written do not depend on the number of
// jobs. What was packed from what stands in a record in the output folder, as hashes of contents; a changed input, a
// changed option or a changed output makes an asset be packed again.
#include "pack_many.h"

#include <fmt/core.h>
#include <glob.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for_each.h>
#include <tbb/task_arena.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>
#include <system_error>
#include <thread>

#include "../gltf/container.h"
#include "../gltf/file_io.h"
#include "distortion.h"
#include "files.h"
#include "progress.h"
#include "report.h"

namespace tsc::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRecordName = ".gltf-tsc-record.json";

struct Job {
  fs::path input;
  fs::path output;  ///< relative to the output folder
};

enum class Status { kPacked, kUnchanged, kFailed };

struct JobResult {
  Status status = Status::kFailed;
  Failure failure = {FailureKind::kUnsupported, ""};
  PackReport report;
  Json distortion;          ///< measured where a report is written
  std::string input_hash;   ///< of the input's content and the options; empty if it could not be read
  std::string output_hash;  ///< of the document that was written
};

/// What the last run left in the output folder: output name -> hashes.
using Record = std::map<std::string, std::pair<std::string, std::string>>;

bool isAssetName(const fs::path& path) {
  const std::string extension = lowerExtension(path);
  return extension == ".gltf" || extension == ".glb";
}

/// "1 asset", "2 assets".
std::string counted(std::size_t count, const char* thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

// ---------------------------------------------------------------------------------------------------------- Inputs

void addFolder(const fs::path& folder, const fs::path& out_dir, std::vector<Job>& jobs) {
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied, error), end;
  std::vector<fs::path> found;
  for (; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_directory(ignored) && fs::equivalent(entry->path(), out_dir, ignored)) {
      entry.disable_recursion_pending();  // yesterday's results are no input
    } else if (entry->is_regular_file(ignored) && isAssetName(entry->path())) {
      found.push_back(entry->path());
    }
  }
  std::ranges::sort(found);
  for (const fs::path& path : found) jobs.push_back({path, path.lexically_relative(folder)});
}

bool isPattern(const std::string& input) {
  std::error_code error;
  return input.find_first_of("*?[") != std::string::npos && !fs::exists(input, error);
}

/// The paths that an input stands for; none if it is a pattern that nothing fits.
std::vector<std::string> expandPattern(const std::string& pattern) {
  if (!isPattern(pattern)) return {pattern};
  glob_t matches = {};
  std::vector<std::string> paths;
  if (::glob(pattern.c_str(), 0, nullptr, &matches) == 0) {
    paths.assign(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
  }
  ::globfree(&matches);
  return paths;
}

std::vector<Job> listJobs(const PackManyRequest& request) {
  std::vector<Job> jobs;
  for (const std::string& input : request.inputs) {
    for (const std::string& path : expandPattern(input)) {
      std::error_code error;
      if (fs::is_directory(path, error)) {
        addFolder(path, request.out_dir, jobs);
      } else {
        jobs.push_back({path, fs::path(path).filename()});
      }
    }
  }
  return jobs;
}

// ---------------------------------------------------------------------------------------------------------- Hashes

/// XXH3 of a sequence of byte strings, lengths included.
class Hasher {
 public:
  Hasher() { XXH3_128bits_reset(&state_); }
  void add(std::span<const std::byte> bytes) {
    const std::uint64_t size = bytes.size();
    XXH3_128bits_update(&state_, &size, sizeof size);
    XXH3_128bits_update(&state_, bytes.data(), bytes.size());
  }
  void add(std::string_view text) { add(std::as_bytes(std::span(text))); }
  std::string digest() const {
    const XXH128_hash_t hash = XXH3_128bits_digest(&state_);
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
  }

 private:
  XXH3_state_t state_;
};

std::string hashOfOptions(const PackOptions& options) {
  return fmt::format("{} {} {} {} {} {} {} {} {} {} {}", static_cast<int>(options.precision.kind),
                     options.precision.value, options.normal_scale, name(options.mode), name(options.basis),
                     name(options.predictor), name(options.order), name(options.effort), options.fallback,
                     options.keep_order, options.repack);
}

/// Everything that the packed asset depends on: document, buffers, other chunks, pictures beside it, options, version.
std::string hashOfInput(const Asset& asset, const PackOptions& options) {
  Hasher hasher;
  hasher.add(std::string_view(GLTF_TSC_VERSION));
  hasher.add(hashOfOptions(options));
  hasher.add(writeJson(asset.document));
  for (const Buffer& buffer : asset.buffers) hasher.add(buffer.bytes);
  for (const GlbChunk& chunk : asset.extra_chunks) hasher.add(chunk.bytes);
  const auto images = asset.document.find("images");
  if (images == asset.document.end() || !images->is_array()) return hasher.digest();
  for (const Json& image : *images) {
    if (!image.is_object() || !image.contains("uri") || !image["uri"].is_string()) continue;
    const std::string uri = image["uri"];
    if (uri.starts_with("data:")) continue;  // part of the document
    const auto bytes = readFile(asset.folder / percentDecode(uri), asset.options.limits.max_input_bytes);
    hasher.add(bytes ? std::span<const std::byte>(*bytes) : std::span<const std::byte>());
  }
  return hasher.digest();
}

std::string hashOfFile(const fs::path& path, const LoadOptions& load) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  const auto bytes = readFile(path, load.limits.max_input_bytes);
  if (!bytes) return {};
  Hasher hasher;
  hasher.add(*bytes);
  return hasher.digest();
}

// ---------------------------------------------------------------------------------------------------------- Record

/// A record that cannot be read is no record: all is packed again.
Record readRecord(const fs::path& out_dir) {
  Record record;
  std::error_code error;
  if (!fs::is_regular_file(out_dir / kRecordName, error)) return record;
  const auto bytes = readFile(out_dir / kRecordName, std::uint64_t{1} << 28);
  if (!bytes) return record;
  const auto* text = reinterpret_cast<const char*>(bytes->data());
  const Json json = Json::parse(text, text + bytes->size(), nullptr, false);
  if (!json.is_object()) return record;
  for (const auto& [output, entry] : json.items()) {
    if (!entry.is_object()) continue;
    const auto input = entry.find("input"), written = entry.find("output");
    if (input == entry.end() || written == entry.end() || !input->is_string() || !written->is_string()) continue;
    record[output] = {input->get<std::string>(), written->get<std::string>()};
  }
  return record;
}

Outcome writeRecord(const fs::path& out_dir, const Record& record) {
  Json json = Json::object();
  for (const auto& [output, hashes] : record) json[output] = {{"input", hashes.first}, {"output", hashes.second}};
  return saveText(json.dump(2) + "\n", (out_dir / kRecordName).string(), true);
}

// --------------------------------------------------------------------------------------------------------- Packing

JobResult failed(const Failure& failure) {
  JobResult result;
  result.failure = failure;
  return result;
}

JobResult packJob(const PackManyRequest& request, const Job& job, const Record& record) {
  const fs::path output = fs::path(request.out_dir) / job.output;
  auto asset = loadAsset(job.input, request.load);
  if (!asset) return failed(asset.failure());
  JobResult result;
  result.input_hash = hashOfInput(*asset, request.pack);
  const auto known = record.find(job.output.generic_string());
  if (known != record.end() && known->second.first == result.input_hash) {
    result.output_hash = hashOfFile(output, request.load);
    if (!result.output_hash.empty() && result.output_hash == known->second.second) {
      result.status = Status::kUnchanged;
      return result;
    }
  }
  std::error_code error;
  fs::create_directories(output.parent_path(), error);
  if (auto bad = checkOutput(output.string(), request.force)) return failed(*bad);
  const bool measure = !request.report.empty();
  const Asset original = measure ? *asset : Asset();
  auto report = packAsset(*asset, request.pack);
  if (!report) return failed(report.failure());
  if (auto bad = saveAsset(*asset, output, {.force = request.force})) return failed(*bad);
  result.status = Status::kPacked;
  result.report = std::move(*report);
  if (measure) {
    result.distortion = reportDistortion(original, *asset, job.input.string(), request.verbosity.quiet);
  }
  result.output_hash = hashOfFile(output, request.load);
  return result;
}

JobResult packJobSafely(const PackManyRequest& request, const Job& job, const Record& record) {
  try {
    return packJob(request, job, record);
  } catch (const std::exception& error) {  // out of memory, mostly; the other assets may still fit
    return failed({FailureKind::kUnsupported, fmt::format("{}: {}", job.input.string(), error.what())});
  }
}

// ---------------------------------------------------------------------------------------------------------- Lines

const char* statusName(Status status) {
  return status == Status::kPacked ? "packed" : status == Status::kUnchanged ? "unchanged" : "failed";
}

std::string reportLine(const Job& job, const fs::path& output, const JobResult& result) {
  Json json;
  if (result.status == Status::kPacked) {
    json = packReportJson(job.input.string(), output.string(), result.report);
    json["distortion"] = result.distortion;
  } else {
    json = {{"input", job.input.string()}, {"output", output.string()}};
  }
  json["status"] = statusName(result.status);
  if (result.status == Status::kFailed) {
    json["exitCode"] = static_cast<int>(result.failure.kind);
    json["message"] = result.failure.message;
  }
  return writeJson(json) + "\n";
}

void printLine(const Job& job, const JobResult& result) {
  if (result.status != Status::kPacked) {
    fmt::print(stderr, "{}: {}\n", job.input.string(), statusName(result.status));
    return;
  }
  double max_relative = 0;
  for (const StreamReport& stream : result.report.streams) {
    if (stream.diagonal > 0) max_relative = std::max(max_relative, stream.max_error / stream.diagonal);
  }
  fmt::print(stderr, "{}: {}, {}, max error {:.2g} of the diagonal", job.input.string(),
             describeSizes(result.report.input_bytes, result.report.output_bytes),
             counted(result.report.streams.size(), "stream"), max_relative);
  if (!result.report.kept.empty()) {
    fmt::print(stderr, ", {} kept as they were ({}: {})", result.report.kept.size(), result.report.kept[0].label,
               result.report.kept[0].reason);
  }
  fmt::print(stderr, "\n");
}

/// Two inputs for one output: all but the first fail.
std::vector<bool> findClashes(const std::vector<Job>& jobs) {
  std::map<fs::path, std::size_t> first;
  std::vector<bool> clashes(jobs.size());
  for (std::size_t i = 0; i < jobs.size(); ++i) clashes[i] = !first.try_emplace(jobs[i].output, i).second;
  return clashes;
}

std::vector<JobResult> packAll(const PackManyRequest& request, const std::vector<Job>& jobs, const Record& record) {
  const std::vector<bool> clashes = findClashes(jobs);
  std::vector<JobResult> results(jobs.size());
  std::vector<std::size_t> numbers(jobs.size());
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  Progress progress("packing " + counted(jobs.size(), "asset"), !request.verbosity.quiet);
  std::atomic<std::uint64_t> done = 0;
  // More jobs than processors are the user's wish; without this TBB would refuse them, with a warning.
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism,
                                    std::max<std::size_t>(request.jobs, std::thread::hardware_concurrency()));
  tbb::task_arena arena(request.jobs == 0 ? tbb::task_arena::automatic : static_cast<int>(request.jobs));
  arena.execute([&] {
    tbb::parallel_for_each(numbers, [&](std::size_t i) {
      results[i] = clashes[i]
                       ? failed({FailureKind::kUsage, fmt::format("{}: another input goes to {} already",
                                                                  jobs[i].input.string(), jobs[i].output.string())})
                       : packJobSafely(request, jobs[i], record);
      progress.update(++done, jobs.size());
    });
  });
  return results;
}

}  // namespace

int packMany(const PackManyRequest& request) {
  std::error_code error;
  fs::create_directories(request.out_dir, error);
  if (!fs::is_directory(request.out_dir, error)) {
    return fail({FailureKind::kIo, fmt::format("{}: cannot be made a folder", request.out_dir)});
  }
  if (!request.report.empty()) {
    if (auto bad = checkTextOutput(request.report, request.force)) return fail(*bad);
  }
  for (const std::string& input : request.inputs) {
    if (expandPattern(input).empty()) return fail({FailureKind::kUsage, fmt::format("{}: fits no file", input)});
  }
  const std::vector<Job> jobs = listJobs(request);
  if (jobs.empty()) {
    return fail({FailureKind::kUsage, fmt::format("{}: found no .gltf and no .glb in it", request.inputs[0])});
  }
  Record record = readRecord(request.out_dir);
  const std::vector<JobResult> results = packAll(request, jobs, record);

  std::string lines;
  std::vector<const Failure*> failures;
  std::size_t packed = 0, unchanged = 0;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const JobResult& result = results[i];
    lines += reportLine(jobs[i], fs::path(request.out_dir) / jobs[i].output, result);
    if (!request.verbosity.quiet) printLine(jobs[i], result);
    packed += result.status == Status::kPacked;
    unchanged += result.status == Status::kUnchanged;
    if (result.status == Status::kFailed) {
      failures.push_back(&result.failure);
    } else {
      record[jobs[i].output.generic_string()] = {result.input_hash, result.output_hash};
    }
  }
  if (!request.verbosity.quiet) {
    fmt::print(stderr, "{}: {} packed, {} unchanged, {} failed\n", counted(jobs.size(), "asset"), packed, unchanged,
               failures.size());
  }
  for (const Failure* failure : failures) (void)fail(*failure);
  if (auto bad = writeRecord(request.out_dir, record)) return fail(*bad);
  if (!request.report.empty()) {
    if (auto bad = saveText(lines, request.report, request.force)) return fail(*bad);
  }
  return failures.empty() ? 0 : static_cast<int>(failures[0]->kind);
}

}  // namespace tsc::cli
