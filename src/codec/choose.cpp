#include "choose.h"

#include <cmath>
#include <optional>

#include "format.h"

namespace tsc {
namespace {

/// Runs trials on the same positions.
class Trials {
 public:
  Trials(const PositionInput& input, Header header) : input_(input) {
    header.positions.fine_bits = 0;
    targets_ = targetsOf(input.welded_positions, input.position_welded, header);
  }

  /// Codes the first `count` positions; `keeps_result` where they are all.
  Trial run(const PositionParameters& parameters, std::uint32_t count, bool keeps_result) {
    Trial trial;
    trial.parameters = parameters;
    trial.position_count = std::min(count, input_.map.position_count);
    const double squares = encodePositions(startFor(parameters.order), parameters, targets_, trial.writer,
                                           keeps_result ? &trial.decoded : nullptr, count);
    trial.bits = trial.writer.bitsSince(0);
    trial.squared_error = std::ldexp(squares, -2 * parameters.fine_bits);
    return trial;
  }

 private:
  const CodingStart& startFor(Order order) {
    if (!start_ || start_order_ != order) start_ = codingStart(input_.surface, input_.map, order);
    start_order_ = order;
    return *start_;
  }

  const PositionInput& input_;
  std::vector<glm::dvec3> targets_;
  std::optional<CodingStart> start_;
  Order start_order_ = Order::kAuto;
};

/// So many positions tell which way is the cheapest.
std::uint32_t sampleSize(std::uint32_t position_count) {
  constexpr std::uint32_t kLeast = 4096;
  return std::max(kLeast, position_count / 6);
}

/// What bits are weighed by: where time to decode counts, a slower way must be worth it. Candidates take a tenth of the
/// time, and another in tangent mode, where they have to be turned into the frame.
double timeWeight(const PositionParameters& p, std::uint32_t position_count) {
  constexpr std::uint32_t kLarge = 1 << 13;
  if (position_count < kLarge || !p.candidates) return 1;
  return p.mode == Mode::kTangent ? 1.08 : 1.06;
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
    p.candidates = options.effort == Effort::kDefault;
    p.exact_hits = hits;
    p.normal_scale = mode == Mode::kTangent ? options.normal_scale : 1;
    p.fine_bits = mode == Mode::kTangent ? kFineBits : 0;
    const auto same = [&](const PositionParameters& q) {
      return q.mode == p.mode && q.basis == p.basis && q.predictor == p.predictor && q.order == p.order &&
             q.exact_hits == p.exact_hits;
    };
    if (std::none_of(candidates.begin(), candidates.end(), same)) candidates.push_back(p);
  };
  if (options.effort == Effort::kMax) {
    // Hits are among what is mixed, and need no flag.
    add(Mode::kLattice, Basis::kGate, Predictor::kAverage, Order::kTraversal, false);
    add(Mode::kTangent, Basis::kGate, Predictor::kAdaptive, Order::kTraversal, false);
    add(Mode::kLattice, Basis::kGate, Predictor::kAdaptive, Order::kTraversal, false);
    add(Mode::kLattice, Basis::kGate, Predictor::kAverage, Order::kDegree, false);
    add(Mode::kTangent, Basis::kGate, Predictor::kAdaptive, Order::kDegree, false);
    if (options.predictor != Predictor::kAuto) {
      add(Mode::kTangent, Basis::kTip, options.predictor, Order::kTraversal, false);
    }
    return candidates;
  }
  add(Mode::kLattice, Basis::kGate, Predictor::kAverage, Order::kTraversal, true);
  add(Mode::kTangent, Basis::kGate, Predictor::kAdaptive, Order::kTraversal, false);
  add(Mode::kTangent, Basis::kGate, Predictor::kAverage, Order::kTraversal, true);
  add(Mode::kLattice, Basis::kGate, Predictor::kAdaptive, Order::kTraversal, false);
  add(Mode::kTangent, Basis::kGate, Predictor::kParallelogram, Order::kTraversal, true);
  if (options.predictor != Predictor::kAuto) {
    // With a predictor given, the basis is what is left to choose, as in the paper.
    add(Mode::kTangent, Basis::kTip, options.predictor, Order::kTraversal, false);
    add(Mode::kTangent, Basis::kTip, options.predictor, Order::kTraversal, true);
  }
  return candidates;
}

}  // namespace

Trial bestPositions(const PositionInput& input, const Header& header, const EncodeOptions& options, const Box& box) {
  const std::vector<PositionParameters> candidates = candidatesFor(header, options, box);
  Trials trials(input, header);
  if (candidates.size() == 1) return trials.run(candidates[0], kNone, true);

  const std::uint32_t sample = sampleSize(input.map.position_count);
  const auto cost = [&](const Trial& trial) {
    return trial.cost() * timeWeight(trial.parameters, input.map.position_count);
  };
  Trial best = trials.run(candidates[0], sample, false);
  const auto attempt = [&](const PositionParameters& parameters) {
    Trial trial = trials.run(parameters, sample, false);
    if (cost(trial) < cost(best)) best = std::move(trial);
  };
  for (std::size_t i = 1; i < candidates.size(); ++i) attempt(candidates[i]);
  if (best.parameters.candidates) {
    PositionParameters faster = best.parameters;
    faster.candidates = faster.exact_hits = false;
    attempt(faster);
  }
  return trials.run(best.parameters, kNone, true);
}

}  // namespace tsc
