// MeshRate as JSON: how an interrupted report remembers what it has measured.
#include <nlohmann/json.hpp>

#include "rate.h"

namespace tsc::bench {

namespace {

using Json = nlohmann::json;

Json optionalJson(const std::optional<double>& value) { return value ? Json(*value) : Json(); }
std::optional<double> optionalFrom(const Json& json) {
  return json.is_null() ? std::nullopt : std::optional(json.get<double>());
}

Json entryJson(const DracoCache::Entry& entry) { return {entry.bits, entry.connectivity_bits, entry.mse}; }
DracoCache::Entry entryFrom(const Json& json) { return {json[0], json[1], json[2]}; }

Json ratiosJson(const RatiosAtRate& ratios) {
  return {optionalJson(ratios.mse), optionalJson(ratios.metro), optionalJson(ratios.dame)};
}
RatiosAtRate ratiosFrom(const Json& json) {
  return {optionalFrom(json[0]), optionalFrom(json[1]), optionalFrom(json[2])};
}

Json pointJson(const CodecPoint& point) {
  const StreamBits& p = point.parts;
  const StreamModes& m = point.modes;
  return {{"step", point.step},
          {"bits", point.bits},
          {"mse", point.mse},
          {"parts", {p.header, p.connectivity, p.positions, p.references, p.corners, p.side_faces}},
          {"modes", {m.mode, m.basis, m.predictor, m.order, m.effort, m.normal_scale}}};
}
CodecPoint pointFrom(const Json& json) {
  CodecPoint point;
  point.step = json["step"];
  point.bits = json["bits"];
  point.mse = json["mse"];
  const Json& parts = json["parts"];
  point.parts = {parts[0], parts[1], parts[2], parts[3], parts[4], parts[5]};
  const Json& modes = json["modes"];
  point.modes = {modes[0], modes[1], modes[2], modes[3], modes[4], modes[5], point.step};
  return point;
}

}  // namespace

void to_json(Json& json, const MeshRate& mesh) {
  json = {{"name", mesh.name},
          {"class", mesh.class_name},
          {"vertices", mesh.vertices},
          {"faces", mesh.faces},
          {"dropped", mesh.dropped_vertices},
          {"bits", mesh.bits},
          {"draco7", Json::array()},
          {"draco10", Json::array()},
          {"variants", Json::array()},
          {"reference7", entryJson(mesh.reference7)},
          {"reference10", entryJson(mesh.reference10)}};
  for (const auto& entry : mesh.draco7) json["draco7"].push_back(entryJson(entry));
  for (const auto& entry : mesh.draco10) json["draco10"].push_back(entryJson(entry));
  for (const VariantRate& rate : mesh.variants) {
    Json variant = {{"name", rate.name},
                    {"error", rate.error},
                    {"bd7", optionalJson(rate.bd7)},
                    {"bd10", optionalJson(rate.bd10)},
                    {"at7", ratiosJson(rate.at7)},
                    {"at10", ratiosJson(rate.at10)},
                    {"curve", Json::array()}};
    for (const CodecPoint& point : rate.curve) variant["curve"].push_back(pointJson(point));
    json["variants"].push_back(variant);
  }
}

void from_json(const Json& json, MeshRate& mesh) {
  mesh.name = json["name"];
  mesh.class_name = json["class"];
  mesh.vertices = json["vertices"];
  mesh.faces = json["faces"];
  mesh.dropped_vertices = json["dropped"];
  mesh.bits = json["bits"].get<std::vector<int>>();
  for (const Json& entry : json["draco7"]) mesh.draco7.push_back(entryFrom(entry));
  for (const Json& entry : json["draco10"]) mesh.draco10.push_back(entryFrom(entry));
  mesh.reference7 = entryFrom(json["reference7"]);
  mesh.reference10 = entryFrom(json["reference10"]);
  for (const Json& variant : json["variants"]) {
    VariantRate& rate = mesh.variants.emplace_back();
    rate.name = variant["name"];
    rate.error = variant["error"];
    rate.bd7 = optionalFrom(variant["bd7"]);
    rate.bd10 = optionalFrom(variant["bd10"]);
    rate.at7 = ratiosFrom(variant["at7"]);
    rate.at10 = ratiosFrom(variant["at10"]);
    for (const Json& point : variant["curve"]) rate.curve.push_back(pointFrom(point));
  }
}

}  // namespace tsc::bench
