// gltf-tsc inspect: what is in an asset, without decoding it.
#include <fmt/core.h>

#include <CLI/App.hpp>
#include <array>
#include <memory>

#include "command.h"
#include "files.h"
#include "options.h"
#include "report.h"

namespace tsc::cli {
namespace {

struct InspectCommand {
  std::string input;
  bool json = false;
  LoadOptions load;
};

double bitsPerVertex(std::uint64_t bytes, std::uint64_t vertices) {
  return vertices == 0 ? 0 : 8.0 * static_cast<double>(bytes) / static_cast<double>(vertices);
}

const char* componentName(ComponentType type) {
  constexpr std::array kNames = {"int8", "uint8", "int16", "uint16", "uint32", "float32"};
  return kNames[static_cast<std::size_t>(type)];
}

Json outputJson(const OutputInfo& output) {
  return {{"kind", output.kind == OutputInfo::Kind::kPositions ? "positions" : "indices"},
          {"type", componentName(output.type)},
          {"count", output.count},
          {"byteLength", output.byte_length}};
}

Json summaryJson(const std::string& input, const AssetSummary& summary) {
  Json json = {{"file", input},
               {"packed", summary.packed},
               {"jsonBytes", summary.json_bytes},
               {"bufferBytes", summary.buffer_bytes},
               {"meshes", summary.meshes},
               {"primitives", summary.primitives},
               {"vertices", summary.vertices},
               {"triangles", summary.triangles},
               {"extensionsUsed", summary.extensions_used}};
  json["streams"] = Json::array();
  for (const StreamSummary& stream : summary.streams) {
    Json entry = {{"label", stream.label},
                  {"meshes", stream.meshes},
                  {"bufferView", stream.buffer_view},
                  {"formatVersion", stream.info.version},
                  {"vertices", stream.vertices},
                  {"triangles", stream.triangles},
                  {"streamBytes", stream.stream_bytes},
                  {"orderBytes", stream.order_bytes},
                  {"decodedBytes", stream.decoded_bytes},
                  {"bitsPerVertex", bitsPerVertex(stream.stream_bytes, stream.vertices)},
                  {"modes", modesJson(stream.info.modes)}};
    entry["outputs"] = Json::array();
    for (const OutputInfo& output : stream.info.outputs) entry["outputs"].push_back(outputJson(output));
    json["streams"].push_back(std::move(entry));
  }
  return json;
}

std::string summaryText(const std::string& input, const AssetSummary& summary) {
  std::string text = fmt::format("{}: {}, JSON {} bytes, buffers {} bytes\n", input,
                                 summary.packed ? "packed" : "not packed", summary.json_bytes, summary.buffer_bytes);
  text += fmt::format("{} meshes, {} primitives, {} vertices, {} triangles\n", summary.meshes, summary.primitives,
                      summary.vertices, summary.triangles);
  if (!summary.extensions_used.empty()) {
    text += "extensions used:";
    for (const std::string& extension : summary.extensions_used) text += " " + extension;
    text += "\n";
  }
  for (const StreamSummary& stream : summary.streams) {
    text += fmt::format("stream in buffer view {}: {}\n", stream.buffer_view, stream.label);
    text += fmt::format("  {} vertices, {} triangles: {} -> {} bytes, {:.2f} bits/vertex\n", stream.vertices,
                        stream.triangles, stream.decoded_bytes, stream.stream_bytes,
                        bitsPerVertex(stream.stream_bytes, stream.vertices));
    text += fmt::format("  {}, step {:.6g}, format version {}\n", describeModes(stream.info.modes),
                        stream.info.modes.step, stream.info.version);
    if (stream.order_bytes > 0) text += fmt::format("  original order kept: {} bytes\n", stream.order_bytes);
    for (std::size_t i = 0; i < stream.info.outputs.size(); ++i) {
      const OutputInfo& output = stream.info.outputs[i];
      text += fmt::format("  output {}: {} {} of {}, {} bytes\n", i, output.count,
                          output.kind == OutputInfo::Kind::kPositions ? "positions" : "indices",
                          componentName(output.type), output.byte_length);
    }
  }
  return text;
}

int runInspect(const InspectCommand& command) {
  auto asset = loadInput(command.input, command.load);
  if (!asset) return fail(asset.failure());
  auto summary = inspectAsset(*asset);
  if (!summary) return fail(summary.failure());
  const std::string text =
      command.json ? writeJson(summaryJson(command.input, *summary), 2) + "\n" : summaryText(command.input, *summary);
  if (Outcome bad = saveText(text, "-", false)) return fail(*bad);
  return 0;
}

}  // namespace

CommandBody addInspectCommand(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("inspect", "Tell what is in an asset");
  auto command = std::make_shared<InspectCommand>();
  verb->add_option("FILE", command->input, "The asset")->required()->type_name("FILE|-");
  verb->add_flag("--json", command->json, "As JSON");
  addLoadOptions(*verb, command->load);
  return [command] { return runInspect(*command); };
}

}  // namespace tsc::cli
