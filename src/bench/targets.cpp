// The figures that the codec's goals are set in.
#include "targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

namespace tsc::bench {

namespace {

using Cell = std::function<std::string(const EffortResults&)>;

struct Row {
  std::string figure;
  std::string goal, goal_max;
  Cell cell;
};

std::string percent(double fraction) { return fmt::format("{:+.1f}%", 100 * fraction); }
std::string factor(double value) { return fmt::format("{:.3f}", value); }

/// `show` of the summary of a group ("" for all meshes) and a variant.
std::string summarized(const std::vector<MeshRate>& rates, const std::string& group, const std::string& variant,
                       const std::function<std::string(const RateSummary&)>& show) {
  const std::vector<RateSummary> summaries = summarize(rates);
  // With several classes, the last summaries are those of all together.
  for (auto summary = summaries.rbegin(); summary != summaries.rend(); ++summary) {
    if (summary->variant == variant && (group.empty() || summary->group == group)) return show(*summary);
  }
  return "-";
}

std::string medianAndWorst(const Spread& spread, std::string (*show)(double)) {
  if (spread.count == 0) return "-";
  return fmt::format("{} / {} ({})", show(spread.median), show(spread.worst), spread.count);
}

Cell bd10(const std::string& group) {
  return [group](const EffortResults& results) {
    return summarized(results.rates, group, results.codec,
                      [](const RateSummary& s) { return medianAndWorst(s.bd10, percent); });
  };
}

Cell mse7(const std::string& group) {
  return [group](const EffortResults& results) {
    return summarized(results.rates, group, results.codec,
                      [](const RateSummary& s) { return medianAndWorst(s.mse7, factor); });
  };
}

Cell ratio10(const std::string& group, bool normal2, Spread RateSummary::*measure) {
  return [=](const EffortResults& results) {
    return summarized(results.rates, group, normal2 ? results.codec_normal2 : results.codec,
                      [measure](const RateSummary& s) { return medianAndWorst(s.*measure, factor); });
  };
}

Cell connectivity(const std::string& group) {
  return [group](const EffortResults& results) {
    return summarized(results.rates, group, results.codec, [](const RateSummary& s) {
      return fmt::format("{:.3f}, with all else {:.3f}", s.connectivity_ratio, s.connectivity_all_ratio);
    });
  };
}

Cell speed(double SpeedMedians::*measure, const char* unit) {
  return [=](const EffortResults& results) -> std::string {
    const auto medians = speedMedians(results.speeds, results.codec);
    return medians ? fmt::format("{:.2f}{} ({})", (*medians).*measure, unit, medians->meshes) : "-";
  };
}

/// The names behind the worst BD-rates.
std::string worstMeshes(const EffortResults& results) {
  std::string text;
  for (const auto* rates : {&results.rates, &results.patches}) {
    for (const RateSummary& s : summarize(*rates)) {
      if (s.variant != results.codec || s.group == "all" || s.worst_bd10_mesh.empty()) continue;
      text += fmt::format("{} {} {} ({})", text.empty() ? "" : ",", s.group, s.worst_bd10_mesh, percent(s.bd10.worst));
    }
  }
  return text.empty() ? "" : fmt::format("worst BD-rates of {}:{}\n", results.codec, text);
}

std::vector<Row> rows() {
  return {
      {"BD-rate vs cl10, organic: median / worst", "-12% / 0%", "-20% / -8%", bd10("organic")},
      {"BD-rate vs cl10, cad: median / worst", "-12% / 0%", "-24% / -5%", bd10("cad")},
      {"MSE at cl7's rate at qp 11, all: median / worst", "0.35 / 0.9", "0.15 / 0.5", mse7("")},
      {"  the same, organic", "", "", mse7("organic")},
      {"  the same, cad", "", "", mse7("cad")},
      {"DAME at cl10's rate, organic, normal scale 2", "0.50", "0.40", ratio10("organic", true, &RateSummary::dame10)},
      {"  the same, normal scale 1", "", "", ratio10("organic", false, &RateSummary::dame10)},
      {"Metro RMS at cl10's rate, organic, normal scale 2", "0.60", "0.50",
       ratio10("organic", true, &RateSummary::metro10)},
      {"  the same, normal scale 1", "", "", ratio10("organic", false, &RateSummary::metro10)},
      {"connectivity bits over Draco's, organic, totals", "0.88", "0.84", connectivity("organic")},
      {"connectivity bits over Draco's, cad, totals", "0.65", "0.60", connectivity("cad")},
      {"200-5000 vertices, BD-rate vs cl10: median / worst", "-12%", "-20%",
       [](const EffortResults& results) {
         return summarized(results.patches, "", results.codec,
                           [](const RateSummary& s) { return medianAndWorst(s.bd10, percent); });
       }},
      {"decoding speed over cl10's, one thread", "2x", "0.25x", speed(&SpeedMedians::decode_speed, "x")},
      {"encoding time over cl10's", "1x", "15x", speed(&SpeedMedians::encode_time, "x")},
      {"decoder's peak heap, bytes a vertex", "80", "150", speed(&SpeedMedians::decode_peak_bytes_a_vertex, "")},
  };
}

}  // namespace

std::string targetsTable(const EffortResults& normal, const EffortResults& max) {
  std::string text = fmt::format("{:<52} | {:<28} {:>11} | {:<28} {:>11}\n", "medians (of so many meshes)", "default",
                                 "goal", "--effort max", "goal");
  for (const Row& row : rows()) {
    text += fmt::format("{:<52} | {:<28} {:>11} | {:<28} {:>11}\n", row.figure, row.cell(normal), row.goal,
                        row.cell(max), row.goal_max);
  }
  return text + worstMeshes(normal) + worstMeshes(max);
}

}  // namespace tsc::bench
