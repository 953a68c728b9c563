#include "choose.h"

#include <cmath>

#include "format.h"

namespace tsc {
namespace {

Trial tryPositions(const PositionInput& input, Header header, const PositionParameters& parameters) {
  Trial trial;
  trial.parameters = parameters;
  header.positions = parameters;
  const std::vector<glm::dvec3> targets = targetsOf(input.welded_positions, input.position_welded, header);
  encodePositions(input.surface, input.map, parameters, targets, trial.writer, trial.decoded);
  trial.bits = trial.writer.bitsSince(0);
  const double scale = std::ldexp(1.0, -parameters.fine_bits);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const glm::dvec3 error = (targets[i] - glm::dvec3(trial.decoded[i])) * scale;
    trial.squared_error += glm::dot(error, error);
  }
  return trial;
}

/// What is worth trying when the caller leaves a choice open.
std::vector<PositionParameters> candidatesFor(const Header& header, const EncodeOptions& options, const Box& box) {
  std::vector<PositionParameters> candidates;
  const bool integer = header.position_type != ComponentType::kFloat32;
  const bool fits = fitsTangentMode(box, header.step);
  const auto add = [&](Mode mode, Basis basis, Predictor predictor, Order order, bool hits) {
    const auto allows = [](auto wish, auto choice) { return wish == decltype(wish)::kAuto || wish == choice; };
    if (mode == Mode::kTangent && (integer || !fits)) return;
    if (!allows(options.mode, mode) && !(mode == Mode::kLattice && (integer || !fits))) return;
    // A finer normal exists in tangent mode only, so asking for it asks for that mode.
    if (mode == Mode::kLattice && options.mode == Mode::kAuto && options.normal_scale > 1 && fits && !integer) return;
    PositionParameters p;
    p.mode = mode;
    p.basis = mode == Mode::kLattice ? Basis::kGate : options.basis != Basis::kAuto ? options.basis : basis;
    p.predictor = options.predictor != Predictor::kAuto ? options.predictor : predictor;
    p.order = options.order != Order::kAuto ? options.order : order;
    p.effort = options.effort;
    p.exact_hits = hits;
    p.normal_scale = mode == Mode::kTangent ? options.normal_scale : 1;
    p.fine_bits = mode == Mode::kTangent ? kFineBits : 0;
    const auto same = [&](const PositionParameters& q) {
      return q.mode == p.mode && q.basis == p.basis && q.predictor == p.predictor && q.order == p.order &&
             q.exact_hits == p.exact_hits;
    };
    if (std::none_of(candidates.begin(), candidates.end(), same)) candidates.push_back(p);
  };
  add(Mode::kLattice, Basis::kGate, Predictor::kAverage, Order::kTraversal, true);
  add(Mode::kTangent, Basis::kGate, Predictor::kAdaptive, Order::kTraversal, false);
  add(Mode::kTangent, Basis::kGate, Predictor::kAverage, Order::kTraversal, true);
  add(Mode::kLattice, Basis::kGate, Predictor::kAdaptive, Order::kTraversal, false);
  if (options.predictor != Predictor::kAuto) {
    // With a predictor given, the basis is what is left to choose, as in the paper.
    add(Mode::kTangent, Basis::kTip, options.predictor, Order::kTraversal, false);
    add(Mode::kTangent, Basis::kTip, options.predictor, Order::kTraversal, true);
  }
  if (options.effort == Effort::kMax) {
    for (const Order order : {Order::kTraversal, Order::kDegree}) {
      for (const Predictor predictor : {Predictor::kAverage, Predictor::kAdaptive}) {
        for (const bool hits : {false, true}) {
          add(Mode::kLattice, Basis::kGate, predictor, order, hits);
          add(Mode::kTangent, Basis::kGate, predictor, order, hits);
          add(Mode::kTangent, Basis::kTip, predictor, order, hits);
        }
      }
    }
  }
  return candidates;
}

}  // namespace

Trial bestPositions(const PositionInput& input, const Header& header, const EncodeOptions& options, const Box& box) {
  Trial best;
  bool first = true;
  for (const PositionParameters& candidate : candidatesFor(header, options, box)) {
    Trial trial = tryPositions(input, header, candidate);
    if (first || trial.cost() < best.cost()) best = std::move(trial);
    first = false;
  }
  return best;
}

}  // namespace tsc
