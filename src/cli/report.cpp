#include "report.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>

namespace tsc::cli {
namespace {

double perVertex(double bits, std::uint64_t vertices) {
  return vertices == 0 ? 0 : bits / static_cast<double>(vertices);
}

double streamBpv(const StreamReport& stream) {
  return perVertex(8.0 * static_cast<double>(stream.stream_bytes), stream.vertices);
}

Json streamJson(const StreamReport& stream) {
  const auto bpv = [&](double bits) { return perVertex(bits, stream.vertices); };
  Json json;
  json["label"] = stream.label;
  json["meshes"] = stream.meshes;
  json["vertices"] = stream.vertices;
  json["uniquePositions"] = stream.unique_positions;
  json["triangles"] = stream.triangles;
  json["inputPositionBytes"] = stream.input_position_bytes;
  json["inputIndexBytes"] = stream.input_index_bytes;
  json["streamBytes"] = stream.stream_bytes;
  if (stream.order_bytes > 0) json["orderBytes"] = stream.order_bytes;
  json["bitsPerVertex"] = {{"total", streamBpv(stream)},
                           {"header", bpv(stream.bits.header)},
                           {"connectivity", bpv(stream.bits.connectivity)},
                           {"positions", bpv(stream.bits.positions)},
                           {"references", bpv(stream.bits.references)},
                           {"corners", bpv(stream.bits.corners)},
                           {"sideFaces", bpv(stream.bits.side_faces)}};
  json["modes"] = modesJson(stream.modes);
  json["maxError"] = stream.max_error;
  json["rmsError"] = stream.rms_error;
  json["guaranteedError"] = stream.guaranteed_error;
  json["diagonal"] = stream.diagonal;
  return json;
}

void printStream(const StreamReport& stream, bool verbose) {
  const StreamBits& bits = stream.bits;
  const auto bpv = [&](double part) { return perVertex(part, stream.vertices); };
  fmt::print(stderr, "  {}: {} vertices, {} triangles: {} -> {} bytes, {:.2f} bits/vertex; {}\n", stream.label,
             stream.vertices, stream.triangles, stream.input_position_bytes + stream.input_index_bytes,
             stream.stream_bytes, streamBpv(stream), describeModes(stream.modes));
  fmt::print(stderr, "    error: max {:.4g}, RMS {:.4g}, bound {:.4g}", stream.max_error, stream.rms_error,
             stream.guaranteed_error);
  if (stream.diagonal > 0) fmt::print(stderr, " (max {:.2g} of the diagonal)", stream.max_error / stream.diagonal);
  fmt::print(stderr, "\n");
  if (stream.order_bytes > 0) fmt::print(stderr, "    original order: {} bytes\n", stream.order_bytes);
  if (!verbose) return;
  fmt::print(
      stderr,
      "    bits/vertex: header {:.2f}, connectivity {:.2f}, positions {:.2f}, references {:.2f}, corners {:.2f}, "
      "side faces {:.2f}; step {:.6g}; {} distinct positions\n",
      bpv(bits.header), bpv(bits.connectivity), bpv(bits.positions), bpv(bits.references), bpv(bits.corners),
      bpv(bits.side_faces), stream.modes.step, stream.unique_positions);
}

}  // namespace

std::string describeModes(const StreamModes& modes) {
  std::string text = name(modes.mode);
  if (modes.mode == Mode::kTangent) text += fmt::format(" {} basis", name(modes.basis));
  text += fmt::format(", {} predictor, {} order", name(modes.predictor), name(modes.order));
  if (modes.mode == Mode::kTangent && modes.normal_scale != 1) text += fmt::format(", normal x{}", modes.normal_scale);
  if (modes.effort != Effort::kDefault) text += fmt::format(", effort {}", name(modes.effort));
  return text;
}

Json modesJson(const StreamModes& modes) {
  return {{"mode", name(modes.mode)},   {"basis", name(modes.basis)},   {"predictor", name(modes.predictor)},
          {"order", name(modes.order)}, {"effort", name(modes.effort)}, {"normalScale", modes.normal_scale},
          {"step", modes.step}};
}

std::string describeSizes(std::uint64_t before, std::uint64_t after) {
  const double share = before == 0 ? 0 : 100.0 * static_cast<double>(after) / static_cast<double>(before);
  return fmt::format("{} -> {} bytes ({:.1f}%)", before, after, share);
}

Json packReportJson(const std::string& input, const std::string& output, const PackReport& report) {
  Json json;
  json["input"] = input;
  json["output"] = output;
  json["inputBytes"] = report.input_bytes;
  json["outputBytes"] = report.output_bytes;
  json["attributeBytes"] = report.attribute_bytes;
  json["streams"] = Json::array();
  for (const StreamReport& stream : report.streams) json["streams"].push_back(streamJson(stream));
  json["kept"] = Json::array();
  for (const KeptReport& kept : report.kept) {
    Json entry = {{"mesh", kept.mesh}};
    if (kept.primitive) entry["primitive"] = *kept.primitive;
    entry["label"] = kept.label;
    entry["reason"] = kept.reason;
    json["kept"].push_back(std::move(entry));
  }
  json["warnings"] = report.warnings;
  return json;
}

void printPackReport(const std::string& input, const std::string& output, const PackReport& report,
                     const Verbosity& verbosity) {
  if (verbosity.quiet) return;
  constexpr std::size_t kShownStreams = 12;
  fmt::print(stderr, "{} -> {}: {}\n", input, output, describeSizes(report.input_bytes, report.output_bytes));
  const std::size_t shown = verbosity.verbose ? report.streams.size() : std::min(report.streams.size(), kShownStreams);
  for (std::size_t i = 0; i < shown; ++i) printStream(report.streams[i], verbosity.verbose);
  if (shown < report.streams.size()) {
    fmt::print(stderr, "  … and {} more streams (--verbose shows all)\n", report.streams.size() - shown);
  }
  for (const KeptReport& kept : report.kept) {
    fmt::print(stderr, "  kept as it was: {}: {}\n", kept.label, kept.reason);
  }
  for (const std::string& warning : report.warnings) fmt::print(stderr, "gltf-tsc: warning: {}\n", warning);
}

}  // namespace tsc::cli
