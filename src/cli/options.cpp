#include "options.h"

#include <fmt/core.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace tsc::cli {
namespace {

template <class Value, std::size_t kCount>
using Names = std::array<std::pair<const char*, Value>, kCount>;

constexpr Names<Mode, 3> kModes = {{{"auto", Mode::kAuto}, {"tangent", Mode::kTangent}, {"lattice", Mode::kLattice}}};
constexpr Names<Basis, 3> kBases = {{{"auto", Basis::kAuto}, {"gate", Basis::kGate}, {"tip", Basis::kTip}}};
constexpr Names<Predictor, 6> kPredictors = {{{"auto", Predictor::kAuto},
                                              {"parallelogram", Predictor::kParallelogram},
                                              {"weighted", Predictor::kWeighted},
                                              {"valence", Predictor::kValence},
                                              {"average", Predictor::kAverage},
                                              {"adaptive", Predictor::kAdaptive}}};
constexpr Names<Order, 3> kOrders = {
    {{"auto", Order::kAuto}, {"traversal", Order::kTraversal}, {"degree", Order::kDegree}}};
constexpr Names<Effort, 2> kEfforts = {{{"default", Effort::kDefault}, {"max", Effort::kMax}}};

template <class Table, class Value>
const char* nameIn(const Table& table, Value value) {
  for (const auto& [text, known] : table) {
    if (known == value) return text;
  }
  return "?";
}

template <class Table>
auto valueIn(const Table& table, const std::string& text) {
  for (const auto& [known, value] : table) {
    if (text == known) return value;
  }
  return table[0].second;  // not reached: the parser has checked the name
}

template <class Table>
void addChoice(CLI::App& verb, const std::string& flag, std::string& target, const Table& table,
               const std::string& help) {
  std::string choices;
  for (const auto& entry : table) choices += (choices.empty() ? "" : "|") + std::string(entry.first);
  verb.add_option(flag, target, help)
      ->type_name(choices)
      ->capture_default_str()
      ->check([&table, choices](const std::string& text) {
        for (const auto& entry : table) {
          if (text == entry.first) return std::string();
        }
        return fmt::format("found '{}', expected {}", text, choices);
      });
}

/// A finite number above zero.
std::string checkPositive(const std::string& text) {
  double value = 0;
  if (CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value > 0) return {};
  return fmt::format("found '{}', expected a finite number above 0", text);
}

}  // namespace

void addLoadOptions(CLI::App& verb, LoadOptions& options) {
  verb.add_flag("--allow-external", options.allow_external, "Follow URIs that lead out of the asset's folder");
  verb.add_option("--max-output-bytes", options.limits.max_output_bytes, "Refuse assets that expand to more bytes")
      ->type_name("N")
      ->capture_default_str();
}

void addPackOptions(CLI::App& verb, PackArguments& arguments) {
  constexpr const char* kGroup = "Precision (one of)";
  const std::array<CLI::Option*, 5> precisions = {
      verb.add_option("--position-bits", arguments.position_bits, "Step = largest extent / (2^N - 1)")
          ->type_name("N")
          ->capture_default_str()
          ->check(CLI::Range(1, 24)),
      verb.add_option("--step", arguments.step, "The step itself, in units of the asset")->type_name("S"),
      verb.add_option("--max-error", arguments.max_error, "No position moves farther, in units of the asset")
          ->type_name("D"),
      verb.add_option("--relative-error", arguments.relative_error, "The same, relative to each mesh's diagonal")
          ->type_name("R"),
      verb.add_option("--target-bpv", arguments.target_bpv, "Bits per vertex, found by search")->type_name("B")};
  for (CLI::Option* option : precisions) {
    option->group(kGroup);
    if (option != precisions[0]) option->check(checkPositive);
    for (CLI::Option* other : precisions) {
      if (other != option) option->excludes(other);
    }
  }
  verb.add_option("--normal-scale", arguments.normal_scale, "Steps are this much finer along the normal")
      ->type_name("S")
      ->capture_default_str()
      ->check(CLI::Range(1, 16));
  addChoice(verb, "--mode", arguments.mode, kModes, "Where residuals live");
  addChoice(verb, "--basis", arguments.basis, kBases, "Orientation of the tangent basis");
  addChoice(verb, "--predictor", arguments.predictor, kPredictors, "What positions are predicted by");
  addChoice(verb, "--order", arguments.order, kOrders, "Order in which positions are coded");
  addChoice(verb, "--effort", arguments.effort, kEfforts, "Bits against time, when packing and when unpacking");
  verb.add_flag("--fallback", arguments.fallback, "Also store plain data for readers without the extension");
  verb.add_flag("--keep-order", arguments.keep_order, "Vertices and triangles come back in their original order");
  verb.add_flag("--repack", arguments.repack, "Unpack first what is packed already");
}

PackOptions packOptions(const PackArguments& arguments) {
  PackOptions options;
  using Kind = Precision::Kind;
  options.precision = arguments.step > 0             ? Precision{Kind::kStep, arguments.step}
                      : arguments.max_error > 0      ? Precision{Kind::kMaxError, arguments.max_error}
                      : arguments.relative_error > 0 ? Precision{Kind::kRelativeError, arguments.relative_error}
                      : arguments.target_bpv > 0
                          ? Precision{Kind::kTargetBpv, arguments.target_bpv}
                          : Precision{Kind::kPositionBits, static_cast<double>(arguments.position_bits)};
  options.normal_scale = arguments.normal_scale;
  options.mode = valueIn(kModes, arguments.mode);
  options.basis = valueIn(kBases, arguments.basis);
  options.predictor = valueIn(kPredictors, arguments.predictor);
  options.order = valueIn(kOrders, arguments.order);
  options.effort = valueIn(kEfforts, arguments.effort);
  options.fallback = arguments.fallback;
  options.keep_order = arguments.keep_order;
  options.repack = arguments.repack;
  return options;
}

const char* name(Mode mode) { return nameIn(kModes, mode); }
const char* name(Basis basis) { return nameIn(kBases, basis); }
const char* name(Predictor predictor) { return nameIn(kPredictors, predictor); }
const char* name(Order order) { return nameIn(kOrders, order); }
const char* name(Effort effort) { return nameIn(kEfforts, effort); }

int fail(const Failure& failure) {
  fmt::print(stderr, "gltf-tsc: {}\n", failure.message);
  return static_cast<int>(failure.kind);
}

}  // namespace tsc::cli
