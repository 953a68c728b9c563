// A comparison as text: table and JSON.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tsc/quality.h"

namespace tsc {
namespace {

using nlohmann::ordered_json;

/// A mesh without extent has no relative errors.
ordered_json relative(double value, double diagonal) {
  return diagonal > 0 ? ordered_json(value / diagonal) : ordered_json(nullptr);
}

ordered_json toJson(const MeshComparison& mesh) {
  ordered_json json;
  json["name"] = mesh.name;
  json["vertices"] = {{"a", mesh.vertices_a}, {"b", mesh.vertices_b}};
  json["triangles"] = {{"a", mesh.triangles_a}, {"b", mesh.triangles_b}};
  json["diagonal"] = mesh.diagonal;
  json["connectivity"] = mesh.vertices ? "same" : "differs";
  json["vertexErrors"] = nullptr;
  if (mesh.vertices) {
    const VertexErrors& errors = *mesh.vertices;
    json["vertexErrors"] = {{"count", errors.count},
                            {"mse", errors.mse},
                            {"rms", errors.rms},
                            {"max", errors.max},
                            {"rmsRelative", relative(errors.rms, mesh.diagonal)},
                            {"maxRelative", relative(errors.max, mesh.diagonal)}};
    if (mesh.correspondence) {
      const bool points = mesh.correspondence->level == Correspondence::Level::kPoints;
      json["vertexErrors"]["matched"] = points ? "points" : "vertices";
    }
  }
  const MetroErrors& metro = mesh.metro;
  json["metro"] = {{"rms", metro.rms()},
                   {"hausdorff", metro.hausdorff()},
                   {"rmsRelative", relative(metro.rms(), mesh.diagonal)},
                   {"hausdorffRelative", relative(metro.hausdorff(), mesh.diagonal)},
                   {"aToB", {{"rms", metro.rms_a_to_b}, {"max", metro.max_a_to_b}}},
                   {"bToA", {{"rms", metro.rms_b_to_a}, {"max", metro.max_b_to_a}}},
                   {"samples", metro.samples}};
  json["dame"] = nullptr;
  if (mesh.dame) {
    json["dame"] = {{"value", mesh.dame->edges > 0 ? ordered_json(mesh.dame->value) : ordered_json(nullptr)},
                    {"edges", mesh.dame->edges},
                    {"skippedEdges", mesh.dame->skipped_edges}};
  }
  return json;
}

std::string padded(const std::string& text, std::size_t width, bool left = false) {
  if (text.size() >= width) return text;
  const std::string space(width - text.size(), ' ');
  return left ? text + space : space + text;
}

std::string number(double value, const char* format = "%.4g") {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

constexpr std::size_t kNameWidth = 28, kCountWidth = 10, kFigureWidth = 12;

void addRow(std::string& table, const std::string& name, std::initializer_list<std::string> counts,
            std::initializer_list<std::string> figures) {
  const bool fits = name.size() <= kNameWidth;
  table += padded(fits ? name : name.substr(0, kNameWidth - 3) + "...", kNameWidth, true);
  for (const std::string& count : counts) table += padded(count, kCountWidth);
  for (const std::string& figure : figures) table += padded(figure, kFigureWidth);
  table += '\n';
}

void addMesh(std::string& table, const MeshComparison& mesh) {
  const bool same = mesh.vertices.has_value();
  const auto figure = [&](double value) { return same ? number(value) : std::string("-"); };
  const VertexErrors errors = mesh.vertices.value_or(VertexErrors{});
  addRow(table, mesh.name.empty() ? "(no name)" : mesh.name,
         {std::to_string(same ? errors.count : mesh.vertices_a), std::to_string(mesh.triangles_a)},
         {figure(errors.mse), figure(errors.rms), figure(errors.max), number(mesh.metro.rms()),
          number(mesh.metro.hausdorff()), mesh.dame && mesh.dame->edges > 0 ? number(mesh.dame->value) : "-"});
  if (!(mesh.diagonal > 0)) return;
  const auto share = [&](double value) { return number(100 * value / mesh.diagonal, "%.3g%%"); };
  addRow(table, "  of diagonal " + number(mesh.diagonal), {"", ""},
         {"", same ? share(errors.rms) : "-", same ? share(errors.max) : "-", share(mesh.metro.rms()),
          share(mesh.metro.hausdorff()), ""});
  if (!same) table += "  connectivity differs: no vertex errors, no DAME\n";
  if (mesh.dame && mesh.dame->skipped_edges > 0) {
    table += "  DAME leaves out " + std::to_string(mesh.dame->skipped_edges) + " of " +
             std::to_string(mesh.dame->skipped_edges + mesh.dame->edges) + " edges: a triangle has no area\n";
  }
}

}  // namespace

std::string comparisonTable(const Comparison& comparison) {
  std::string table;
  addRow(table, "mesh", {"vertices", "triangles"}, {"MSE", "RMS", "max", "Metro RMS", "Hausdorff", "DAME"});
  for (const MeshComparison& mesh : comparison.meshes) addMesh(table, mesh);
  if (comparison.meshes.size() > 1) addMesh(table, comparison.total);
  return table;
}

std::string comparisonJson(const Comparison& comparison, int indent) {
  ordered_json json;
  json["meshes"] = ordered_json::array();
  for (const MeshComparison& mesh : comparison.meshes) json["meshes"].push_back(toJson(mesh));
  json["total"] = toJson(comparison.total);
  // Names come from files and need not be UTF-8.
  return json.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace tsc
