// Writes the sample assets: make-samples FOLDER. Each exercises something that real assets have.
#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "asset.h"
#include "shapes.h"

namespace tsc::samples {
namespace {

using glm::dvec2;
using glm::dvec3;
using Path = std::filesystem::path;

Json material(const char* name, double r, double g, double b, double metallic, double roughness) {
  return {{"name", name},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {r, g, b, 1.0}}, {"metallicFactor", metallic}, {"roughnessFactor", roughness}}}};
}

/// One node, one mesh, in one scene.
void addScene(Asset& asset, const char* name, Json primitives) {
  asset.json["scenes"] = Json::array({{{"nodes", {0}}}});
  asset.json["nodes"] = Json::array({{{"name", name}, {"mesh", 0}}});
  asset.json["meshes"] = Json::array({{{"name", name}, {"primitives", std::move(primitives)}}});
}

Json plainPrimitive(Asset& asset, const Surface& surface, int index_bytes) {
  const int positions = asset.addFloats(surface.positionFloats(), "VEC3", Target::kVertices, true);
  const int normals = asset.addFloats(surface.normalFloats(), "VEC3", Target::kVertices);
  const int indices = asset.addIndices(surface.indices, index_bytes);
  return {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}, {"indices", indices}, {"material", 0}};
}

/// Smooth and closed, regular valences but for twelve vertices.
void writeSlug(const Path& folder) {
  Asset asset("Sea slug");
  asset.json["materials"] = Json::array({material("skin", 0.85, 0.35, 0.2, 0, 0.4)});
  addScene(asset, "slug", Json::array({plainPrimitive(asset, slug(), 2)}));
  asset.write(folder / "slug.glb");
}

/// Planar faces, bores, a slot, slivers; 32-bit indices.
void writeFlange(const Path& folder) {
  Asset asset("Flange with boss");
  asset.json["materials"] = Json::array({material("steel", 0.6, 0.62, 0.65, 1, 0.35)});
  addScene(asset, "flange", Json::array({plainPrimitive(asset, flange(), 4)}));
  asset.write(folder / "flange.gltf");
}

/// A glazed vase on a wooden foot: two materials that share a ring of positions, a UV seam, hard edges, interleaved
/// attributes in one table for both primitives, an embedded picture, an unknown property that must survive.
void writeVase(const Path& folder) {
  std::vector<dvec2> foot = {{0, 0}, {0.5, 0}, {0.5, 0}, {0.52, 0.03}, {0.5, 0.06}, {0.5, 0.06}, {0.3, 0.08}};
  std::vector<dvec2> profile = {foot.back()};
  for (int i = 1; i <= 40; ++i) {
    const double t = i / 40.0;
    profile.push_back({0.3 + 0.35 * sine(kPi * t * 0.85) - 0.12 * t, 0.08 + 1.5 * t});
  }
  const dvec2 rim = profile.back();
  profile.push_back({rim.x - 0.01, rim.y + 0.015});
  profile.push_back({rim.x - 0.03, rim.y});
  for (int i = 38; i >= 2; i -= 4) profile.push_back({profile[i].x - 0.04, profile[i].y});
  profile.push_back({0, profile.back().y - 0.02});

  const Surface lower = turned(foot, 64), upper = turned(profile, 64);
  std::vector<float> positions, normals, uvs;
  for (const Surface* part : {&lower, &upper}) {
    const auto append = [](std::vector<float>& to, const std::vector<float>& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(positions, part->positionFloats());
    append(normals, part->normalFloats());
    append(uvs, part->uvFloats());
  }
  std::vector<std::uint32_t> upper_indices = upper.indices;
  for (std::uint32_t& index : upper_indices) index += static_cast<std::uint32_t>(lower.positions.size());

  Asset asset("Vase on a foot");
  const std::array<FloatColumn, 3> columns = {{{.values = positions, .components = 3, .bounds = true},
                                               {.values = normals, .components = 3},
                                               {.values = uvs, .components = 2}}};
  const std::vector<int> table = asset.addInterleaved(columns);
  const Json attributes = {{"POSITION", table[0]}, {"NORMAL", table[1]}, {"TEXCOORD_0", table[2]}};
  Json primitives = Json::array();
  primitives.push_back({{"attributes", attributes}, {"indices", asset.addIndices(lower.indices, 2)}, {"material", 0}});
  primitives.push_back({{"attributes", attributes}, {"indices", asset.addIndices(upper_indices, 2)}, {"material", 1}});
  addScene(asset, "vase", std::move(primitives));

  // A 2x2 picture, eight bits a channel: signature, IHDR, IDAT (stored deflate block), IEND.
  constexpr std::array<unsigned char, 82> kPng = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
      0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x08, 0x02, 0x00, 0x00, 0x00, 0xfd, 0xd4, 0x9a, 0x73, 0x00,
      0x00, 0x00, 0x19, 0x49, 0x44, 0x41, 0x54, 0x78, 0x01, 0x01, 0x0e, 0x00, 0xf1, 0xff, 0x00, 0x20, 0x60,
      0xa0, 0xf0, 0xf0, 0xe0, 0x00, 0xf0, 0xf0, 0xe0, 0x20, 0x60, 0xa0, 0x35, 0x6e, 0x07, 0xc1, 0xe3, 0x67,
      0x2d, 0x09, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  asset.addImage(std::as_bytes(std::span(kPng)));
  asset.json["samplers"] = Json::array({{{"magFilter", 9728}, {"wrapS", 10497}, {"wrapT", 10497}}});
  asset.json["textures"] = Json::array({{{"sampler", 0}, {"source", 0}}});
  Json glaze = material("glaze", 1, 1, 1, 0, 0.15);
  glaze["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  glaze["doubleSided"] = true;
  asset.json["materials"] = Json::array({material("wood", 0.35, 0.2, 0.1, 0, 0.8), glaze});
  asset.json["nodes"][0]["extras"] = {{"catalogue", "A-17"}, {"empty", Json::object()}, {"big", 9007199254740991}};
  asset.write(folder / "vase.glb");
}

/// A tentacle over six joints that sways.
void writeTentacle(const Path& folder) {
  constexpr int kJoints = 6, kRings = 72, kSegments = 24;
  constexpr double kLength = 3;
  std::vector<dvec2> profile = {{0, 0}};
  for (int i = 0; i <= kRings; ++i) {
    const double t = static_cast<double>(i) / kRings;
    profile.push_back({0.35 * (1 - 0.85 * t) * (1 + 0.06 * sine(40 * t)), kLength * t});
  }
  profile.push_back({0, kLength + 0.04});
  const Surface skin = turned(profile, kSegments);
  std::vector<std::uint8_t> joints;
  std::vector<float> weights;
  for (const dvec3& p : skin.positions) {
    const double at = std::clamp(p.y / kLength * (kJoints - 1), 0.0, kJoints - 1.0);
    const int lower = std::min(static_cast<int>(at), kJoints - 2);
    // Multiples of 1/256, so that both weights are exact and add up to 1. An unused joint is 0, as glTF asks.
    const double upper = static_cast<int>((at - lower) * 256) / 256.0;
    const bool one = upper == 0 || upper == 1;
    const int only = upper == 1 ? lower + 1 : lower;
    joints.insert(joints.end(), {static_cast<std::uint8_t>(one ? only : lower),
                                 static_cast<std::uint8_t>(one ? 0 : lower + 1), 0, 0});
    weights.insert(weights.end(), {static_cast<float>(one ? 1 : 1 - upper), static_cast<float>(one ? 0 : upper), 0, 0});
  }

  Asset asset("Swaying tentacle");
  Json primitive = plainPrimitive(asset, skin, 2);
  primitive["attributes"]["TEXCOORD_0"] = asset.addFloats(skin.uvFloats(), "VEC2", Target::kVertices);
  primitive["attributes"]["JOINTS_0"] = asset.addBytes4(joints);
  primitive["attributes"]["WEIGHTS_0"] = asset.addFloats(weights, "VEC4", Target::kVertices);
  addScene(asset, "tentacle", Json::array({primitive}));
  asset.json["materials"] = Json::array({material("tentacle", 0.4, 0.1, 0.45, 0, 0.5)});
  asset.json["scenes"][0]["nodes"] = {0, 1};
  asset.json["nodes"][0]["skin"] = 0;

  std::vector<float> inverse_bind, times, rotations;
  Json joint_nodes = Json::array();
  for (int joint = 0; joint < kJoints; ++joint) {
    Json node = {{"name", "joint" + std::to_string(joint)}};
    if (joint > 0) node["translation"] = {0.0, kLength / (kJoints - 1), 0.0};
    if (joint + 1 < kJoints) node["children"] = {joint + 2};
    asset.json["nodes"].push_back(node);
    joint_nodes.push_back(joint + 1);
    const auto height = static_cast<float>(-kLength / (kJoints - 1) * joint);
    inverse_bind.insert(inverse_bind.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, height, 0, 1});
  }
  for (int key = 0; key <= 8; ++key) {
    const double half_angle = 0.12 * sine(2 * kPi * key / 8);
    times.push_back(static_cast<float>(key) / 4);
    rotations.insert(rotations.end(),
                     {0, 0, static_cast<float>(sine(half_angle)), static_cast<float>(cosine(half_angle))});
  }
  asset.json["skins"] = Json::array({{{"inverseBindMatrices", asset.addFloats(inverse_bind, "MAT4", Target::kNone)},
                                      {"skeleton", 1},
                                      {"joints", joint_nodes}}});
  const int input = asset.addFloats(times, "SCALAR", Target::kNone, true);
  const int output = asset.addFloats(rotations, "VEC4", Target::kNone);
  Json channels = Json::array();
  for (int joint = 1; joint < kJoints; ++joint) {
    channels.push_back({{"sampler", 0}, {"target", {{"node", joint + 1}, {"path", "rotation"}}}});
  }
  asset.json["animations"] = Json::array({{{"name", "sway"},
                                           {"channels", channels},
                                           {"samplers", Json::array({{{"input", input}, {"output", output}}})}}});
  asset.write(folder / "tentacle.glb");
}

/// A ball with two morph targets, one of them sparse, and an animation of their weights.
void writeMorph(const Path& folder) {
  const Surface ball = icosphere(4);
  Surface stretched = ball;
  for (dvec3& p : stretched.positions) p *= dvec3(1 - 0.3 * p.y * p.y, 1.5, 1 - 0.3 * p.y * p.y);
  computeNormals(stretched);
  std::vector<float> moves, turns, nose;
  std::vector<std::uint16_t> nose_vertices;
  for (std::size_t i = 0; i < ball.positions.size(); ++i) {
    const dvec3 move = stretched.positions[i] - ball.positions[i], turn = stretched.normals[i] - ball.normals[i];
    const double near = ball.positions[i].z - 0.85;
    for (int k = 0; k < 3; ++k) {
      moves.push_back(static_cast<float>(move[k]));
      turns.push_back(static_cast<float>(turn[k]));
    }
    if (near <= 0) continue;
    nose_vertices.push_back(static_cast<std::uint16_t>(i));
    nose.insert(nose.end(), {0, 0, static_cast<float>(20 * near * near)});
  }
  Asset asset("Ball with two expressions");
  asset.json["materials"] = Json::array({material("rubber", 0.9, 0.75, 0.1, 0, 0.6)});
  Json primitive = plainPrimitive(asset, ball, 2);
  Json targets = Json::array();
  targets.push_back({{"POSITION", asset.addFloats(moves, "VEC3", Target::kVertices, true)},
                     {"NORMAL", asset.addFloats(turns, "VEC3", Target::kVertices)}});
  targets.push_back({{"POSITION", asset.addSparseVec3(ball.positions.size(), nose_vertices, nose, true)},
                     {"NORMAL", asset.addSparseVec3(ball.positions.size(), std::array<std::uint16_t, 1>{0},
                                                    std::array<float, 3>{0, 0, 0}, false)}});
  primitive["targets"] = targets;
  addScene(asset, "ball", Json::array({primitive}));
  asset.json["meshes"][0]["weights"] = {0.0, 0.5};
  asset.json["meshes"][0]["extras"] = {{"targetNames", {"stretch", "nose"}}};
  const std::array<float, 3> times = {0, 1, 2};
  const std::array<float, 6> weights = {0, 0, 1, 0.5, 0, 0};
  const int input = asset.addFloats(times, "SCALAR", Target::kNone, true);
  const int output = asset.addFloats(weights, "SCALAR", Target::kNone);
  asset.json["animations"] =
      Json::array({{{"name", "express"},
                    {"channels", Json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}})},
                    {"samplers", Json::array({{{"input", input}, {"output", output}}})}}});
  asset.write(folder / "ball.gltf");
}

/// What modellers leave behind: a Moebius band, an edge of three faces, cubes that touch in a corner, duplicate,
/// flipped and degenerate triangles, a vertex that no triangle uses; byte indices; beside it a primitive of lines.
void writeNonManifold(const Path& folder) {
  Surface soup;
  constexpr int kBand = 30;
  for (int i = 0; i < kBand; ++i) {
    const double angle = 2 * kPi * i / kBand, c = cosine(angle), s = sine(angle);
    for (const double side : {-0.3, 0.3}) {
      const double r = 1 + side * cosine(angle / 2);
      soup.positions.push_back({r * c, side * sine(angle / 2), r * s});
    }
    const std::uint32_t a = 2 * i, b = a + 1;
    const bool last = i + 1 == kBand;  // the band closes with its sides exchanged
    const std::uint32_t c2 = last ? 1 : a + 2, d2 = last ? 0 : a + 3;
    soup.indices.insert(soup.indices.end(), {a, c2, b, b, c2, d2});
  }
  const auto fan = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), {{2, 0, 0}, {2, 1, 0}, {3, 0.5, 0}, {1.6, 0.5, 0.8}, {1.6, 0.5, -0.8}});
  for (std::uint32_t blade = 2; blade < 5; ++blade)
    soup.indices.insert(soup.indices.end(), {fan, fan + 1, fan + blade});
  for (const double corner : {0.0, 0.5}) {
    const auto base = static_cast<std::uint32_t>(soup.positions.size());
    for (int i = 0; i < 8; ++i) {
      const dvec3 unit(i & 1, (i >> 1) & 1, i >> 2);
      soup.positions.push_back(dvec3(-3, 0, 0) + corner + 0.5 * unit);
    }
    for (const std::uint32_t i :
         {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5}) {
      soup.indices.push_back(base + i);
    }
  }
  soup.indices.insert(soup.indices.end(), {fan, fan + 1, fan + 2});  // twice the same
  soup.indices.insert(soup.indices.end(), {fan + 1, fan, fan + 3});  // and one turned over
  soup.indices.insert(soup.indices.end(), {fan, fan + 1, fan + 1});  // no area
  soup.positions.push_back({0, 2, 0});                               // used by nothing
  computeNormals(soup);

  Asset asset("Geometry that is no manifold");
  asset.json["materials"] = Json::array({material("paper", 0.9, 0.9, 0.85, 0, 0.9)});
  asset.json["materials"][0]["doubleSided"] = true;
  Json triangles = plainPrimitive(asset, soup, 1);
  const std::array<float, 6> axis = {0, -1, 0, 0, 2, 0};
  Json lines = {{"attributes", {{"POSITION", asset.addFloats(axis, "VEC3", Target::kVertices, true)}}}, {"mode", 1}};
  addScene(asset, "soup", Json::array({triangles, lines}));
  asset.write(folder / "soup.gltf");
}

/// Figure 2 of the paper: a plane of irregular triangles, turned by 17.5 degrees about the x axis.
void writePlane(const Path& folder) {
  Asset asset("Plane rotated by 17.5 degrees about x");
  asset.json["materials"] = Json::array({material("blue", 0.2, 0.3, 0.9, 0, 0.7)});
  addScene(asset, "plane", Json::array({plainPrimitive(asset, rotatedPlane(17.5), 2)}));
  asset.write(folder / "plane-17.5.glb");
}

}  // namespace
}  // namespace tsc::samples

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: make-samples FOLDER\n", stderr);
    return 1;
  }
  try {
    using namespace tsc::samples;
    const std::filesystem::path folder = argv[1];
    for (const auto write :
         {writeSlug, writeFlange, writeVase, writeTentacle, writeMorph, writeNonManifold, writePlane}) {
      write(folder);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make-samples: %s\n", error.what());
    return 4;
  }
  return 0;
}
