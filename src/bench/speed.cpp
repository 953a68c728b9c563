// Time and memory of all codecs, side by side.
//
// Each codec takes the mesh as it likes it (Draco its Mesh, ours spans over the arrays), made before the clock starts,
// and decodes into memory that it allocates itself.
#include "speed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "heap.h"
#include "peers.h"

namespace tsc::bench {

namespace {

struct Contestant {
  std::string name;
  std::function<double()> encode;  ///< returns the stream's bytes
  std::function<void()> decode;    ///< of the stream that `encode` left
};

/// CPU time of this thread: every codec here runs in one, and what else the machine does is not to be measured.
double nanoseconds(const std::function<void()>& work) {
  const auto now = [] {
    timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1e9 * double(time.tv_sec) + double(time.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

Contestant dracoContestant(const std::shared_ptr<DracoMesh>& mesh, int level, int bits) {
  auto stream = std::make_shared<std::vector<char>>();
  return {fmt::format("draco-cl{}", level),
          [=] {
            *stream = encodeDraco(*mesh, level, bits).bytes;
            return double(stream->size());
          },
          [=] { decodeDracoOnly(*stream); }};
}

Contestant meshoptContestant(const BenchMesh& mesh) {
  auto stream = std::make_shared<MeshoptCodec::Stream>();
  return {"meshopt",
          [stream, &mesh] {
            *stream = MeshoptCodec::encode(mesh);
            return double(stream->bytes());
          },
          [stream] { MeshoptCodec::decode(*stream); }};
}

/// What no decoder can beat: the arrays copied into new memory.
Contestant memcpyContestant(const BenchMesh& mesh) {
  const auto copy = [&mesh] {
    const std::size_t position_bytes = mesh.positions.size() * sizeof(float);
    const std::size_t index_bytes = mesh.indices.size() * sizeof(std::uint32_t);
    const std::unique_ptr<std::byte[]> target(new std::byte[position_bytes + index_bytes]);
    std::memcpy(target.get(), mesh.positions.data(), position_bytes);
    std::memcpy(target.get() + position_bytes, mesh.indices.data(), index_bytes);
    // Keeps the compiler from dropping copies that nobody reads.
    asm volatile("" : : "r"(target.get()) : "memory");
    return double(position_bytes + index_bytes);
  };
  return {"memcpy", copy, [copy] { copy(); }};
}

Contestant ourContestant(const BenchMesh& mesh, const Variant& variant, int bits) {
  auto stream = std::make_shared<std::vector<std::byte>>();
  EncodeOptions options = variant.options;
  options.step = stepForBits(codecMesh(mesh), bits);
  return {variant.name,
          [stream, options, &mesh] {
            auto result = encode(codecMesh(mesh), options);
            if (!result) throw std::runtime_error(describe(result.error()));
            *stream = std::move(result->bytes);
            return double(stream->size());
          },
          [stream] {
            const auto decoded = decode(*stream);
            if (!decoded) throw std::runtime_error(describe(decoded.error()));
          }};
}

/// Ratio of medians as text; "-" where one is missing.
std::string ratioText(double value, double reference) {
  return value > 0 && reference > 0 ? fmt::format("{:.2f}", reference / value) : "-";
}

}  // namespace

const CodecSpeed& MeshSpeed::codec(const std::string& wanted) const {
  for (const CodecSpeed& speed : codecs) {
    if (speed.codec == wanted) return speed;
  }
  throw std::runtime_error("no codec named " + wanted);
}

MeshSpeed measureSpeed(const BenchMesh& mesh, const SpeedOptions& options) {
  const auto draco = std::make_shared<DracoMesh>(mesh);
  std::vector<Contestant> contestants = {dracoContestant(draco, 7, options.bits),
                                         dracoContestant(draco, 10, options.bits), meshoptContestant(mesh),
                                         memcpyContestant(mesh)};
  for (const Variant& variant : options.variants) {
    if (!variant.is_laplacian) contestants.push_back(ourContestant(mesh, variant, options.bits));
  }
  MeshSpeed result{mesh.name, mesh.class_name, mesh.vertexCount(), mesh.faceCount(), {}};
  for (const Contestant& contestant : contestants) result.codecs.push_back({.codec = contestant.name, .error = {}});

  const auto attempt = [&](std::size_t i, const std::function<void()>& work) {
    if (!result.codecs[i].error.empty()) return;
    try {
      work();
    } catch (const std::runtime_error& error) {
      result.codecs[i].error = error.what();
    }
  };
  // The first round warms caches up, leaves the streams for decoding, and measures the heap.
  for (std::size_t i = 0; i < contestants.size(); ++i) {
    attempt(i, [&] {
      CodecSpeed& speed = result.codecs[i];
      speed.encode_peak_bytes = double(peakHeapBytes([&] { speed.bytes = contestants[i].encode(); }));
      speed.decode_peak_bytes = double(peakHeapBytes(contestants[i].decode));
    });
  }
  std::vector<std::vector<double>> encode_times(contestants.size()), decode_times(contestants.size());
  for (int run = 0; run < options.runs; ++run) {
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      attempt(i, [&] {
        if (options.encoding) encode_times[i].push_back(nanoseconds([&] { contestants[i].encode(); }));
        decode_times[i].push_back(nanoseconds(contestants[i].decode));
      });
    }
  }
  for (std::size_t i = 0; i < contestants.size(); ++i) {
    result.codecs[i].encode_ns = medianOf(encode_times[i]);
    result.codecs[i].decode_ns = medianOf(decode_times[i]);
  }
  return result;
}

std::string speedLines(const MeshSpeed& mesh) {
  std::string text = fmt::format(
      "{} ({} vertices, {} triangles)\n{:<14}{:>7} | {:>9}{:>9}{:>8}{:>8} | {:>9}{:>9}{:>8}{:>8} | {:>8}{:>8}\n",
      mesh.name, mesh.vertices, mesh.faces, "", "bpv", "enc ns/v", "Mtri/s", "x cl7", "x cl10", "dec ns/v", "Mtri/s",
      "x cl7", "x cl10", "enc B/v", "dec B/v");
  const double n = double(mesh.vertices), t = double(mesh.faces);
  const CodecSpeed& cl7 = mesh.codec("draco-cl7");
  const CodecSpeed& cl10 = mesh.codec("draco-cl10");
  for (const CodecSpeed& speed : mesh.codecs) {
    if (!speed.error.empty()) {
      text += fmt::format("{:<14}error: {}\n", speed.codec, speed.error);
      continue;
    }
    text += fmt::format("{:<14}{:>7.2f} | {:>9.1f}{:>9.2f}{:>8}{:>8} | {:>9.1f}{:>9.2f}{:>8}{:>8} | {:>8.1f}{:>8.1f}\n",
                        speed.codec, 8 * speed.bytes / n, speed.encode_ns / n,
                        speed.encode_ns > 0 ? 1000 * t / speed.encode_ns : 0, ratioText(speed.encode_ns, cl7.encode_ns),
                        ratioText(speed.encode_ns, cl10.encode_ns), speed.decode_ns / n, 1000 * t / speed.decode_ns,
                        ratioText(speed.decode_ns, cl7.decode_ns), ratioText(speed.decode_ns, cl10.decode_ns),
                        speed.encode_peak_bytes / n, speed.decode_peak_bytes / n);
  }
  return text;
}

std::string speedSummary(const std::vector<MeshSpeed>& meshes) {
  if (meshes.empty()) return {};
  std::size_t smallest = meshes.front().vertices;
  for (const MeshSpeed& mesh : meshes) smallest = std::min(smallest, mesh.vertices);
  std::string text = fmt::format(
      "medians over {} meshes of {} vertices and more; speed ratios above 1: faster than Draco\n"
      "{:<14} | {:>9}{:>9}{:>7}{:>8} | {:>9}{:>9}{:>7}{:>8} | {:>7} | {:>8}{:>8}\n",
      meshes.size(), smallest, "", "enc ns/v", "Mtri/s", "x cl7", "x cl10", "dec ns/v", "Mtri/s", "x cl7", "x cl10",
      "x memcpy", "enc B/v", "dec B/v");
  for (const CodecSpeed& first : meshes.front().codecs) {
    std::vector<double> encode, encode_mtri, encode7, encode10, decode, decode_mtri, decode7, decode10, copy, ep, dp;
    for (const MeshSpeed& mesh : meshes) {
      const CodecSpeed& speed = mesh.codec(first.codec);
      if (!speed.error.empty()) continue;
      const double n = double(mesh.vertices);
      decode.push_back(speed.decode_ns / n);
      decode_mtri.push_back(1000 * double(mesh.faces) / speed.decode_ns);
      decode7.push_back(mesh.codec("draco-cl7").decode_ns / speed.decode_ns);
      decode10.push_back(mesh.codec("draco-cl10").decode_ns / speed.decode_ns);
      copy.push_back(mesh.codec("memcpy").decode_ns / speed.decode_ns);
      ep.push_back(speed.encode_peak_bytes / n);
      dp.push_back(speed.decode_peak_bytes / n);
      if (speed.encode_ns <= 0) continue;
      encode.push_back(speed.encode_ns / n);
      encode_mtri.push_back(1000 * double(mesh.faces) / speed.encode_ns);
      encode7.push_back(mesh.codec("draco-cl7").encode_ns / speed.encode_ns);
      encode10.push_back(mesh.codec("draco-cl10").encode_ns / speed.encode_ns);
    }
    text += fmt::format(
        "{:<14} | {:>9.1f}{:>9.2f}{:>7.2f}{:>8.2f} | {:>9.1f}{:>9.2f}{:>7.2f}{:>8.2f} | {:>8.3f} | {:>8.1f}{:>8.1f}\n",
        first.codec, medianOf(encode), medianOf(encode_mtri), medianOf(encode7), medianOf(encode10), medianOf(decode),
        medianOf(decode_mtri), medianOf(decode7), medianOf(decode10), medianOf(copy), medianOf(ep), medianOf(dp));
  }
  return text;
}

std::optional<SpeedMedians> speedMedians(const std::vector<MeshSpeed>& meshes, const std::string& codec) {
  std::vector<double> decode, encode, heap;
  for (const MeshSpeed& mesh : meshes) {
    const auto ours = std::find_if(mesh.codecs.begin(), mesh.codecs.end(),
                                   [&](const CodecSpeed& speed) { return speed.codec == codec; });
    if (ours == mesh.codecs.end() || !ours->error.empty()) continue;
    const CodecSpeed& draco = mesh.codec("draco-cl10");
    decode.push_back(draco.decode_ns / ours->decode_ns);
    encode.push_back(ours->encode_ns / draco.encode_ns);
    heap.push_back(ours->decode_peak_bytes / double(mesh.vertices));
  }
  if (decode.empty()) return std::nullopt;
  return SpeedMedians{decode.size(), medianOf(decode), medianOf(encode), medianOf(heap)};
}

std::string speedCsv(const std::vector<MeshSpeed>& meshes) {
  std::string csv =
      "mesh,class,vertices,faces,codec,bytes,encode_ns,decode_ns,encode_peak_bytes,decode_peak_bytes,error\n";
  for (const MeshSpeed& mesh : meshes) {
    for (const CodecSpeed& s : mesh.codecs) {
      csv +=
          fmt::format("{},{},{},{},{},{},{},{},{},{},\"{}\"\n", mesh.name, mesh.class_name, mesh.vertices, mesh.faces,
                      s.codec, s.bytes, s.encode_ns, s.decode_ns, s.encode_peak_bytes, s.decode_peak_bytes, s.error);
    }
  }
  return csv;
}

std::vector<BenchMesh> sizeSeries(const BenchMesh& mesh, std::size_t largest) {
  std::vector<BenchMesh> series;
  BenchMesh source = mesh;
  for (const std::size_t size : {1000u, 3000u, 10000u, 30000u, 100000u, 300000u, 1000000u}) {
    if (size > largest) break;
    while (source.vertexCount() < size) source = subdivide(source);
    series.push_back(cutPatch(source, size));
    series.back().class_name = "series";
  }
  return series;
}

void to_json(nlohmann::json& json, const MeshSpeed& mesh) {
  json = {{"name", mesh.name},
          {"class", mesh.class_name},
          {"vertices", mesh.vertices},
          {"faces", mesh.faces},
          {"codecs", nlohmann::json::array()}};
  for (const CodecSpeed& s : mesh.codecs) {
    json["codecs"].push_back({{"codec", s.codec},
                              {"error", s.error},
                              {"bytes", s.bytes},
                              {"encode", s.encode_ns},
                              {"decode", s.decode_ns},
                              {"encode_peak", s.encode_peak_bytes},
                              {"decode_peak", s.decode_peak_bytes}});
  }
}

void from_json(const nlohmann::json& json, MeshSpeed& mesh) {
  mesh.name = json["name"];
  mesh.class_name = json["class"];
  mesh.vertices = json["vertices"];
  mesh.faces = json["faces"];
  for (const auto& s : json["codecs"]) {
    mesh.codecs.push_back(
        {s["codec"], s["error"], s["bytes"], s["encode"], s["decode"], s["encode_peak"], s["decode_peak"]});
  }
}

}  // namespace tsc::bench
