// The HTML page of `tsc-bench report`.
#include "report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "svg.h"

namespace tsc::bench {

namespace {

constexpr const char* kStyle =
    "body{font:14px/1.45 sans-serif;margin:2em auto;max-width:1200px;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;margin:1em 0;font-size:12px}td,th{border:1px solid #ccc;padding:2px 7px;"
    "text-align:right}td:first-child,th:first-child{text-align:left}.bad{color:#b00}.good{color:#060}"
    "pre{background:#f5f5f5;padding:.7em;overflow-x:auto;font-size:12px}svg{max-width:100%;margin:.5em}"
    "details{margin:1em 0}";

/// Rows of cells; the first row is the heading. Cells are HTML already.
std::string table(const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<table>";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    html += "<tr>";
    for (const std::string& cell : rows[i]) html += fmt::format("<{0}>{1}</{0}>", i == 0 ? "th" : "td", cell);
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string percentCell(double fraction) {
  return fmt::format("<span class='{}'>{:+.1f}%</span>", fraction > 0 ? "bad" : "good", 100 * fraction);
}
std::string ratioCell(double ratio, bool present = true) {
  return present ? fmt::format("<span class='{}'>{:.3f}</span>", ratio > 1 ? "bad" : "good", ratio) : "-";
}
std::string cell(const std::optional<double>& value, std::string (*format)(double)) {
  return value ? format(*value) : "-";
}

std::string summarySection(const std::vector<RateSummary>& summaries) {
  std::vector<std::vector<std::string>> rows = {
      {"class / codec", "meshes", "BD cl7 median", "mean", "worst", "BD cl10 median", "mean", "worst",
       "MSE at cl7 median", "geometric mean", "worst", "Metro at cl10 median", "DAME at cl10 median",
       "connectivity / Draco's", "with references, corners, header", "bpv at qp 11", "cl7", "cl10"}};
  for (const RateSummary& s : summaries) {
    rows.push_back({escapeHtml(s.group + " / " + s.variant),
                    fmt::format("{}{}", s.meshes - s.failed,
                                s.failed > 0 ? fmt::format(" <span class='bad'>({} failed)</span>", s.failed) : ""),
                    percentCell(s.bd7.median), percentCell(s.bd7.mean), percentCell(s.bd7.worst),
                    percentCell(s.bd10.median), percentCell(s.bd10.mean), percentCell(s.bd10.worst),
                    ratioCell(s.mse7.median, s.mse7.count > 0), ratioCell(s.mse7.mean, s.mse7.count > 0),
                    ratioCell(s.mse7.worst, s.mse7.count > 0), ratioCell(s.metro10.median, s.metro10.count > 0),
                    ratioCell(s.dame10.median, s.dame10.count > 0), ratioCell(s.connectivity_ratio),
                    ratioCell(s.connectivity_all_ratio), fmt::format("{:.2f}", s.bits_per_vertex.median),
                    fmt::format("{:.2f}", s.draco7_bits_per_vertex.median),
                    fmt::format("{:.2f}", s.draco10_bits_per_vertex.median)});
  }
  return table(rows);
}

std::string boxPlots(const std::vector<RateSummary>& summaries) {
  std::string html;
  const std::pair<const char*, Spread RateSummary::*> measures[] = {
      {"MSE", &RateSummary::mse7}, {"Metro RMS", &RateSummary::metro7}, {"DAME", &RateSummary::dame7}};
  std::vector<std::string> groups;
  for (const RateSummary& s : summaries) {
    if (groups.empty() || groups.back() != s.group) groups.push_back(s.group);
  }
  for (const std::string& group : groups) {
    for (const auto& [name, member] : measures) {
      BoxPlot plot{fmt::format("{}: {} over Draco's (-cl 7 -qp 11) at its rate", group, name), {}};
      for (const RateSummary& s : summaries) {
        if (s.group == group) plot.boxes.push_back({s.variant, s.*member});
      }
      html += svg(plot);
    }
  }
  return html;
}

std::string curvePlot(const MeshRate& mesh) {
  LinePlot plot;
  plot.title = fmt::format("{}/{} ({} vertices)", mesh.class_name, mesh.name, mesh.vertices);
  plot.x_label = "bits per vertex";
  plot.y_label = "RMS vertex error (units of the mesh)";
  const auto add = [&](const std::string& label, const auto& points) {
    LinePlot::Line line{label, {}, {}};
    for (const auto& point : points) {
      line.x.push_back(point.bits / double(mesh.vertices));
      line.y.push_back(std::sqrt(point.mse));
    }
    plot.lines.push_back(line);
  };
  add("Draco -cl 7", mesh.draco7);
  add("Draco -cl 10", mesh.draco10);
  for (const VariantRate& rate : mesh.variants) add(rate.name, rate.curve);
  return svg(plot);
}

/// Curves of the best, the median and the worst mesh of each class by BD-rate of the first variant.
std::string curvesSection(const std::vector<MeshRate>& rates) {
  std::map<std::string, std::vector<const MeshRate*>> classes;
  for (const MeshRate& mesh : rates) {
    if (mesh.variants.empty() || !mesh.variants.front().bd10) continue;
    classes[mesh.class_name].push_back(&mesh);
  }
  std::string html;
  for (auto& [name, meshes] : classes) {
    std::sort(meshes.begin(), meshes.end(),
              [](const auto* a, const auto* b) { return a->variants.front().bd10 < b->variants.front().bd10; });
    std::vector<std::size_t> chosen = {0, meshes.size() / 2, meshes.size() - 1};
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    for (const std::size_t i : chosen) html += curvePlot(*meshes[i]);
  }
  return html;
}

std::string meshesSection(const std::vector<MeshRate>& rates) {
  std::vector<std::vector<std::string>> rows = {{"mesh", "vertices", "codec", "bpv at qp 11", "connectivity",
                                                 "positions", "cl7", "cl10", "BD cl7", "BD cl10", "MSE at cl7",
                                                 "Metro at cl10", "DAME at cl10"}};
  for (const MeshRate& mesh : rates) {
    const std::size_t shown = mesh.shownPoint();
    const double n = double(mesh.vertices);
    const auto bpv = [n](double bits) { return fmt::format("{:.2f}", bits / n); };
    for (const VariantRate& r : mesh.variants) {
      const std::string name = escapeHtml(mesh.class_name + "/" + mesh.name);
      if (!r.error.empty()) {
        rows.push_back(
            {name, std::to_string(mesh.vertices), r.name, "<span class='bad'>" + escapeHtml(r.error) + "</span>"});
        continue;
      }
      const auto ratio = [](double value) { return ratioCell(value); };
      rows.push_back({name, std::to_string(mesh.vertices), r.name, bpv(r.curve[shown].bits),
                      bpv(r.curve[shown].parts.connectivity), bpv(r.curve[shown].parts.positions),
                      bpv(mesh.draco7[shown].bits), bpv(mesh.draco10[shown].bits), cell(r.bd7, percentCell),
                      cell(r.bd10, percentCell), cell(r.at7.mse, +ratio), cell(r.at10.metro, +ratio),
                      cell(r.at10.dame, +ratio)});
    }
  }
  return "<details><summary>All meshes</summary>" + table(rows) + "</details>\n";
}

/// What was done to the input before any codec saw it.
std::string inputsSection(const std::vector<MeshRate>& rates) {
  std::string list;
  for (const MeshRate& mesh : rates) {
    if (mesh.dropped_vertices == 0) continue;
    list += fmt::format("{}{}/{} ({} of {})", list.empty() ? "" : ", ", escapeHtml(mesh.class_name),
                        escapeHtml(mesh.name), mesh.dropped_vertices, mesh.vertices + mesh.dropped_vertices);
  }
  return fmt::format(
      "<p>Input: vertices of bit-equal position welded, positions and triangles alone. Vertices that no triangle uses "
      "are "
      "left out for all codecs alike, because Draco drops them: {}. Metro: one sample a triangle, at least {} and at "
      "most "
      "{} on each surface.</p>\n",
      list.empty() ? "there are none" : list, kMinMetroSamples, kMaxMetroSamples);
}

std::string scalingPlots(const std::vector<MeshSpeed>& series) {
  std::string html;
  const std::pair<const char*, double CodecSpeed::*> directions[] = {{"Encoding", &CodecSpeed::encode_ns},
                                                                     {"Decoding", &CodecSpeed::decode_ns}};
  for (const auto& [title, member] : directions) {
    LinePlot plot;
    plot.title = fmt::format("{} time, one thread", title);
    plot.x_label = "vertices";
    plot.y_label = "ns per vertex";
    plot.log_x = true;
    for (const MeshSpeed& mesh : series) {
      for (const CodecSpeed& codec : mesh.codecs) {
        auto line = std::find_if(plot.lines.begin(), plot.lines.end(),
                                 [&](const LinePlot::Line& drawn) { return drawn.label == codec.codec; });
        if (line == plot.lines.end()) line = plot.lines.insert(line, {codec.codec, {}, {}});
        line->x.push_back(double(mesh.vertices));
        line->y.push_back(codec.*member / double(mesh.vertices));
      }
    }
    html += svg(plot);
  }
  return html;
}

}  // namespace

std::string reportPage(const ReportData& data) {
  const std::vector<RateSummary> summaries = summarize(data.rates);
  std::string html = fmt::format(
      "<!doctype html><html lang='en'><head><meta charset='utf-8'><title>tsc-bench "
      "report</title><style>{}</style></head>"
      "<body><h1>Tangent-space mesh codec beside its peers</h1>\n<p>{}</p><pre>{}</pre>\n",
      kStyle, escapeHtml(data.provenance), escapeHtml(data.command));
  html +=
      "<h2>Rate-distortion</h2>\n<p>BD-rate: mean change in bits at equal MSE (Bjontegaard; PCHIP through log bits "
      "over "
      "log MSE at the settings measured; whole streams), minus is better. MSE, Metro and DAME: ours over Draco's at "
      "the bits that Draco needs at 11 bits, below 1 is better; Draco's default is -cl 7. Metro is the RMS of the "
      "worse "
      "direction. <i>laplacian</i> is our own re-implementation of high-pass quantisation with anchors, in the spirit "
      "of "
      "EPC, not EPC itself. Effort max is measured on fewer meshes: see the column.</p>\n";
  html += inputsSection(data.rates);
  html += summarySection(summaries) +
          "<h2>At Draco's rate (the paper's Figure 3)</h2>\n<p>Box: quartiles and median; "
          "whiskers: best and worst mesh; dot: geometric mean.</p>\n" +
          boxPlots(summaries);
  html += "<h2>Curves</h2>\n<p>Of each class the best, median and worst mesh.</p>\n" + curvesSection(data.rates);
  html += meshesSection(data.rates);
  if (!data.patches.empty()) {
    html += "<h2>Small meshes</h2>\n<p>Patches of 200 to 5000 vertices, cut from the same meshes.</p>\n" +
            summarySection(summarize(data.patches));
  }
  if (!data.speeds.empty() || !data.speeds_max.empty()) {
    const std::string text = speedSummary(data.speeds) + "\n" + speedSummary(data.speeds_max);
    html +=
        "<h2>Speed and memory</h2>\n<p>One thread, all codecs in turn on the same arrays, medians of the CPU time of "
        "at least 7 runs. "
        "Heap: the peak of what encoding or decoding allocates, the decoded arrays included. Our encoder's time "
        "includes decoding and comparing its result.</p>\n<pre>" +
        escapeHtml(text) + "</pre>\n";
  }
  if (!data.series.empty()) {
    html +=
        "<p>Growing sizes (the paper's Figures 5 and 6): patches of one mesh, then patches of its subdivisions.</p>\n" +
        scalingPlots(data.series);
  }
  html += "<h2>A plane askew to the axes (the paper's Figure 2)</h2>\n<pre>" +
          escapeHtml(planeTable(data.plane) + "\n" + planeNote()) + "</pre>\n";
  return html + "</body></html>\n";
}

}  // namespace tsc::bench
