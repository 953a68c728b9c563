#include "positions.h"

#include "adaptive_offset.h"
#include "arc.h"
#include "direction.h"
#include "format.h"
#include "mixed_features.h"
#include "mixed_residuals.h"
#include "order.h"
#include "predict.h"
#include "residual_coder.h"
#include "residual_context.h"
#include "stencil.h"

namespace tsc {
namespace {

/// What a vertex is predicted from. All of it is set before it is read.
struct Prediction {
  int count_class;                                ///< complete parallelograms, up to kCountClasses, less one
  std::array<const VertexState*, 6> around;       ///< left, right and base of the first two parallelograms
  std::array<Integers, kMaxStencils> candidates;  ///< parallelograms
  Integers mean;                                  ///< their average
  Integers point;                                 ///< the chosen predictor's, before the adaptive offset
  Frame frame;
  Integers offset;  ///< adaptive offset, local

  Prediction() {}  // NOLINT: nothing is cleared that is set anyway

  // The gate is the first parallelogram's.
  const VertexState* left() const { return around[0]; }
  const VertexState* right() const { return around[1]; }
  const VertexState* base() const { return around[2]; }
};

/// Coordinates count modulo 2^kCoordinateBits: no valid stream goes that far, and no other leads to an overflow.
Integers wrapped(Integers v) {
  constexpr int kRest = 32 - kCoordinateBits;
  return v << kRest >> kRest;
}
Vec3 clampedToLattice(const WideVec3& v) {
  return Vec3(glm::clamp(v, WideVec3(-kCoordinateLimit), WideVec3(kCoordinateLimit)));
}

/// Of each component, on the fine lattice.
Integers stepsOf(const PositionParameters& p) {
  const std::int32_t fine = 1 << p.fine_bits;
  const bool finer = p.mode == Mode::kTangent;
  return Integers{finer ? std::max(fine / static_cast<std::int32_t>(p.normal_scale), 1) : fine, fine, fine, 1};
}

/// floor(log2) of each step.
std::array<int, 3> bitsOf(Integers steps) {
  const auto bits = [&](int a) { return static_cast<int>(std::bit_width(static_cast<unsigned>(steps[a]))) - 1; };
  return {bits(0), bits(1), bits(2)};
}

template <class Direction>
class PositionCoder {
 public:
  /// `states`: as in CodingStart, of those positions that are to be coded.
  PositionCoder(Direction direction, const CodingOrder& order, std::span<VertexState> states,
                const PositionParameters& parameters)
      : direction_(direction),
        parameters_(parameters),
        tangent_(parameters.mode == Mode::kTangent),
        adaptive_(parameters.predictor == Predictor::kAdaptive),
        order_(order),
        states_(states),
        step_(stepsOf(parameters)),
        normal_bits_(bitsOf(step_)[0]),
        residuals_(direction, parameters.exact_hits, parameters.predictor == Predictor::kParallelogram, bitsOf(step_)) {
    if (parameters.effort == Effort::kMax) {
      mixed_ = std::make_unique<MixedResiduals<Direction>>(
          direction, ResidualSteps({step_[0], step_[1], step_[2]}, parameters.fine_bits, !tangent_), adaptive_);
    }
  }

  /// Returns the sum of squared errors when writing.
  double run(std::span<const glm::dvec3> target) {
    if (parameters_.candidates) return tangent_ ? runAs<true, true>(target) : runAs<false, true>(target);
    return tangent_ ? runAs<true, false>(target) : runAs<false, false>(target);
  }

 private:
  static constexpr std::uint32_t kOverrunInterval = 1024;
  /// Until then the adaptive offset learns from each vertex; then from every other one, which is as good and faster.
  static constexpr std::uint32_t kEagerUntil = 2048;

  /// One loop for each of the choices that decide what a vertex takes.
  template <bool kTangent, bool kCandidates>
  double runAs(std::span<const glm::dvec3> target) {
    double squared_error = 0;
    const double cells = 1 << parameters_.fine_bits;
    Hot<Direction> coder(direction_);
    const auto count = static_cast<std::uint32_t>(states_.size());
    for (std::uint32_t time = 0; time < count; ++time) {
      if (time % kOverrunInterval == 0) {
        coder.to(direction_);
        if (direction_.overrun()) break;
      }
      const glm::dvec3 wanted = Direction::kWrites ? target[order_.positionAt(time)] * cells : glm::dvec3(0);
      codeVertex<kTangent, kCandidates>(coder, time, wanted);
      if constexpr (Direction::kWrites) {
        const glm::dvec3 error = wanted - glm::dvec3(vectorOf(states_[time].point));
        squared_error += glm::dot(error, error);
      }
    }
    coder.to(direction_);
    return squared_error;
  }

  template <bool kTangent, bool kCandidates>
  TSC_ALWAYS_INLINE void codeVertex(Hot<Direction>& coder, std::uint32_t time, const glm::dvec3& target) {
    VertexState& state = states_[time];
    const Stencils stencils(state, order_.corner_time);
    if (stencils.count == 0 || mixed_) [[unlikely]] {
      coder.to(direction_);
      if (stencils.count == 0) {
        codeFree(time, target);
      } else {
        codeMixed(time, target);
      }
      coder.from(direction_);
      return;
    }
    Prediction p;
    std::array<Parallelogram, kMaxStencils> parallelograms;
    for (std::size_t j = 0; j < kMaxStencils; ++j) {
      parallelograms[j] = stencils[j];
    }
    gather(parallelograms, stencils.count, p);
    place<kTangent>(time, stencils.face(0), stencils.valence, p);
    p.offset = Integers{};
    if (adaptive_) {
      features_ = Features(p.frame, surroundingOf<kTangent>(p), irregularityOf(p, stencils.valence));
      p.offset = offsets_[p.count_class].offset(features_) << kVectorShift<kTangent>;
    }
    codeResiduals<kTangent, kCandidates>(coder, state, stencils.valence, time, p, target);
  }

  /// A vertex without a complete parallelogram, the first triangle of a component above all: exact to the fine lattice.
  [[gnu::noinline]] void codeFree(std::uint32_t time, const glm::dvec3& target) {
    const Stencils stencils(states_[time], order_.corner_time);
    const std::uint32_t origin_time = stencils.hasGate() ? stencils[0].right : time - 1;
    const Vec3 origin = time == 0 ? Vec3(0) : vectorOf(states_[origin_time].point);
    Vec3 difference(0);
    if constexpr (Direction::kWrites) difference = Vec3(glm::floor(target + 0.5)) - origin;
    for (int a = 0; a < 3; ++a) {
      difference[a] = unzigzag(direction_.integer(free_[a], zigzag(difference[a])));
    }
    const Vec3 position = clampedToLattice(WideVec3(origin) + WideVec3(difference));
    states_[time].point = Integers{position.x, position.y, position.z, stencils.valence};
    states_[time].memory = {};
  }

  /// Effort max (section 6.9). The stencils' order becomes that of the arc.
  [[gnu::noinline]] void codeMixed(std::uint32_t time, const glm::dvec3& target) {
    const Stencils stencils(states_[time], order_.corner_time);
    const Arc arc = arcOf(order_, stencils);
    Prediction p;
    std::array<Parallelogram, kMaxStencils> parallelograms;
    for (std::size_t j = 0; j < kMaxStencils; ++j) {
      const ArcStencil& s = arc.list[static_cast<int>(j) < arc.count ? j : 0];
      parallelograms[j] = {s.left, s.right, s.base};
    }
    gather(parallelograms, arc.count, p);
    if (tangent_) {
      place<true>(time, arc.list[0].face, stencils.valence, p);
    } else {
      place<false>(time, arc.list[0].face, stencils.valence, p);
    }
    const ToLocal local(p.frame, tangent_);
    const MixedFeatures features = mixedFeatures({order_, states_, time}, arc, stencils.valence, local, tangent_);
    p.offset = mixed_->offset(features, arc.count, stencils.valence);
    std::array<std::int32_t, 3> residual{};
    if constexpr (Direction::kWrites) residual = wantedResidual(p, target);
    mixed_->code(mixedVertexOf(p, arc.count, stencils.valence, local), residual);
    remember<0>(states_[time], stencils.valence, p, residual, Lanes{});
  }

  MixedVertex mixedVertexOf(const Prediction& p, int count, std::int32_t valence, const ToLocal& local) const {
    MixedVertex m;
    m.stencil_count = count;
    m.valence = valence;
    m.predicted =
        local(p.mean - p.point, p.candidates[0] - p.point, p.candidates[1] - p.point, p.candidates[2] - p.point);
    if (!tangent_) {
      m.neighbour = local(p.left()->point - p.point, p.right()->point - p.point, p.base()->point - p.point, Integers{});
    }
    m.around = p.around;
    const Integers gate = magnitudes(p.left()->point - p.right()->point);
    m.gate = std::int64_t{gate[0]} + gate[1] + gate[2];
    return m;
  }

  /// What is known around the vertex; beyond `count`, `parallelograms` repeats the first.
  TSC_ALWAYS_INLINE void gather(const std::array<Parallelogram, kMaxStencils>& parallelograms, int count,
                                Prediction& p) const {
    p.count_class = count - 1;
    const VertexState* const states = states_.data();
    for (std::size_t j = 0; j < kMaxStencils; ++j) {
      const VertexState* const left = states + parallelograms[j].left;
      const VertexState* const right = states + parallelograms[j].right;
      const VertexState* const base = states + parallelograms[j].base;
      p.candidates[j] = parallelogram(left->point, right->point, base->point);
      if (j == 2) break;
      p.around[3 * j] = left;
      p.around[3 * j + 1] = right;
      p.around[3 * j + 2] = base;
    }
    p.mean = average(p.candidates, count);
  }

  /// The predicted point and the frame there.
  template <bool kTangent>
  TSC_ALWAYS_INLINE void place(std::uint32_t time, std::uint32_t face, std::int32_t valence, Prediction& p) const {
    p.point = p.mean;
    if (parameters_.predictor < Predictor::kAverage) [[unlikely]] {
      p.point =
          parameters_.predictor == Predictor::kParallelogram ? p.candidates[0] : weightedPoint(time, face, valence, p);
    }
    p.frame =
        kTangent ? frameAt(parameters_.basis, p.left()->point, p.right()->point, p.base()->point, p.point) : Frame{};
  }

  /// Of the predictors that are not made of candidates' means.
  [[gnu::noinline]] Integers weightedPoint(std::uint32_t time, std::uint32_t face, std::int32_t valence,
                                           const Prediction& p) const {
    const bool use_known_angles = parameters_.predictor == Predictor::kWeighted;
    return lanesOf(clampedToLattice(
        weightedParallelogram(vectorOf(p.left()->point), vectorOf(p.right()->point), vectorOf(p.base()->point),
                              expectedAngles({order_, states_}, time, face, valence, use_known_angles))));
  }

  /// The valence less 6, the difference of the gate's ends', and what the base's leaves of these less 6, in lanes 1
  /// to 3.
  TSC_ALWAYS_INLINE static Integers irregularityOf(const Prediction& p, std::int32_t valence) {
    // Lanes 3 of points are valences, and so are those of their sums.
    const Integers gate = p.left()->point - p.right()->point;
    const Integers last = __builtin_shufflevector(gate, p.candidates[0], 2, 6, 3, 7);
    return __builtin_shufflevector(Integers{0, valence, 0, 0}, last, 0, 1, 6, 7) - Integers{0, 6, 0, 6};
  }

  /// Vectors of the adaptive offset are in eighths of a step in tangent mode, so that few edges exceed 16 bits.
  template <bool kTangent>
  static constexpr int kVectorShift = kTangent ? kFineBits - 3 : 0;

  template <bool kTangent>
  TSC_ALWAYS_INLINE Surrounding surroundingOf(const Prediction& p) const {
    const Integers left = p.left()->point, right = p.right()->point, base = p.base()->point;
    constexpr int shift = kVectorShift<kTangent>;
    const auto surprises = [](const VertexState* a, Lanes b) {
      return (Lanes)__builtin_shufflevector((Halves)loadLanes(a->memory.data()), (Halves)b, 0, 2);
    };
    const Integers first = (p.candidates[0] - p.point) >> shift;
    const Integers height = ((left - base) + (right - base)) >> (shift + 1);
    const Integers gate = (left - right) >> shift;
    return {surprises(p.left(), loadLanes(p.right()->memory.data())), surprises(p.base(), packed(first, first)),
            packed(height, gate)};
  }

  /// Sums over the neighbours' residuals.
  TSC_ALWAYS_INLINE static Integers magnitudeOf(const Prediction& p) {
    UnsignedLanes memory{};  // the lanes of magnitudes stay within 15 bits, the others wrap
    for (const VertexState* state : p.around) memory += (UnsignedLanes)loadLanes(state->memory.data());
    return widenedHigh((Lanes)memory);
  }

  /// The residuals at which the first candidates lie: in steps and rounded, in 16 bits, the second's in the upper half.
  template <bool kTangent>
  TSC_ALWAYS_INLINE Lanes candidatesOf(const Prediction& p) const {
    const Integers first = p.candidates[0] - p.point, second = p.candidates[1] - p.point;
    if (!kTangent) return packed(first - p.offset, second - p.offset);
    auto [local_first, local_second] = toLocal(p.frame, packed(first, second));
    local_first = local_first - p.offset + (step_ >> 1);
    local_second = local_second - p.offset + (step_ >> 1);
    Integers steps_first = local_first >> kFineBits, steps_second = local_second >> kFineBits;
    if (parameters_.normal_scale > 1) {
      steps_first[0] = local_first[0] >> normal_bits_;
      steps_second[0] = local_second[0] >> normal_bits_;
    }
    return packed(steps_first, steps_second);
  }

  template <bool kTangent>
  TSC_ALWAYS_INLINE Neighbourhood neighbourhoodOf(const Prediction& p) const {
    Neighbourhood around;
    around.magnitude = magnitudeOf(p);
    around.count_class = p.count_class;
    // How far the first two candidates lie apart; of one alone, a part of the gate.
    constexpr std::array<Integers, kCountClasses> kAlone = {Integers{-1, -1, -1, 0}};
    const Integers alone = kAlone[static_cast<std::size_t>(p.count_class)];
    const Integers apart = (p.candidates[0] - p.candidates[1]) + (((p.left()->point - p.right()->point) >> 1) & alone);
    constexpr float bound = kMaxSpread >> (kFineBits + 1), scale = kTangent ? 1 : 1 << kFineBits;
    const Integers spread = truncated(smaller(magnitudes(floatsOf(apart)), Floats{} + bound) * scale);
    around.spread = spread;
    if (kTangent) {
      around.spread = (spread + __builtin_shufflevector(spread, spread, 1, 2, 0, 3) +
                       __builtin_shufflevector(spread, spread, 2, 0, 1, 3)) >>
                      1;
    }
    return around;
  }

  template <bool kTangent, bool kCandidates>
  TSC_ALWAYS_INLINE void codeResiduals(Hot<Direction>& coder, VertexState& state, std::int32_t valence,
                                       std::uint32_t time, const Prediction& p, const glm::dvec3& target) {
    std::array<std::int32_t, 3> wanted{};
    if constexpr (Direction::kWrites) wanted = wantedResidual(p, target);
    const ResidualContexts contexts = residualContexts(neighbourhoodOf<kTangent>(p));
    std::array<std::int32_t, 3> residual;
    std::uint32_t whole = 0;  // components that are known to the last step, a bit each
    Lanes candidates{};
    if constexpr (kCandidates) {
      candidates = candidatesOf<kTangent>(p);
      alignas(16) std::array<std::int16_t, 8> candidate;
      storeLanes(candidate.data(), candidates);
      const std::uint32_t hits_around = p.left()->hits() + p.right()->hits();
      const auto context = [&](std::size_t a) {
        return CandidateContext{{candidate[a], candidate[a + 4]}, p.count_class, hits_around >> (2 * a) & 3};
      };
      const auto& c = contexts;
      typename ResidualCoder<Direction>::Progress progress;
      residual[0] = residuals_.template code<0>(coder, c.table(0), c.shift(0), context(0), progress, wanted[0]);
      residual[1] = residuals_.template code<1>(coder, c.table(1), c.shift(1), context(1), progress, wanted[1]);
      residual[2] = residuals_.template code<2>(coder, c.table(2), c.shift(2), context(2), progress, wanted[2]);
      whole = progress.hits;
    } else {
      residual[0] = residuals_.template code<0>(coder, contexts.table(0), contexts.shift(0), wanted[0]);
      residual[1] = residuals_.template code<1>(coder, contexts.table(1), contexts.shift(1), wanted[1]);
      residual[2] = residuals_.template code<2>(coder, contexts.table(2), contexts.shift(2), wanted[2]);
    }
    codeLowBits(coder, contexts, whole, wanted, residual);
    remember<kVectorShift<kTangent>>(state, valence, p, residual, candidates);
    if (adaptive_ && (time < kEagerUntil || time % 2 == 1)) {
      offsets_[p.count_class].learn(features_, Integers{residual[0], residual[1], residual[2], 0});
    }
  }

  /// `candidates` as candidatesOf gives them.
  template <int kSurpriseBits>
  TSC_ALWAYS_INLINE void remember(VertexState& state, std::int32_t valence, const Prediction& p,
                                  const std::array<std::int32_t, 3>& residual, Lanes candidates) const {
    const Integers steps = {residual[0], residual[1], residual[2], 0};
    const Integers point = reconstruct(p, steps);
    const Integers surprise = (point - p.mean) >> kSurpriseBits;
    constexpr Lanes kMost = {32767, 32767, 32767, 0, kMaxMagnitude, kMaxMagnitude, kMaxMagnitude, 0};
    Lanes memory = atMost(packed(surprise, magnitudes(steps)), kMost);
    if (parameters_.candidates) memory[7] = static_cast<std::int16_t>(pairsOfEqual(packed(steps, steps), candidates));
    storeLanes(state.memory.data(), memory);
    state.point = withLast(point, valence);
  }

  /// The bits below the bins' widths of all components that are not `whole`, the first component's lowest.
  TSC_ALWAYS_INLINE void codeLowBits(Hot<Direction>& coder, const ResidualContexts& contexts, std::uint32_t whole,
                                     const std::array<std::int32_t, 3>& wanted, std::array<std::int32_t, 3>& residual) {
    const int first = whole & 1 ? 0 : contexts.shift(0);
    const int second = whole & 2 ? 0 : contexts.shift(1);
    const int third = whole & 4 ? 0 : contexts.shift(2);
    if (first + second + third > kGroupRawBits) [[unlikely]]
      coder.endGroup();
    const auto code = [&](std::size_t a, int count) {
      residual[a] += static_cast<std::int32_t>(coder.raw(static_cast<std::uint32_t>(wanted[a] - residual[a]), count));
    };
    code(0, first);
    code(1, second);
    code(2, third);
    coder.endGroup();
  }

  TSC_ALWAYS_INLINE Integers reconstruct(const Prediction& p, Integers residual) const {
    if (!tangent_) return wrapped(p.point + p.offset + residual);
    Integers displacement = residual << kFineBits;
    if (parameters_.normal_scale > 1) displacement[0] = residual[0] * step_[0];
    return wrapped(p.point + toLattice(p.frame, p.offset + displacement));
  }

  static glm::dvec3 axisOf(Lanes axis) { return {axis[0], axis[1], axis[2]}; }

  /// The residual whose reconstruction is nearest to the target: the frame is orthonormal only up to 2^-7, so that
  /// large residuals are corrected by what they leave over.
  Vec3 nearestResidual(const Prediction& p, const glm::dvec3& target) const {
    if (!tangent_) return Vec3(glm::floor(target + 0.5)) - vectorOf(p.point + p.offset);
    const glm::dvec3 axes[3] = {axisOf(p.frame.normal), axisOf(p.frame.first), axisOf(p.frame.second)};
    const auto steps = [&](const glm::dvec3& displacement, const glm::dvec3& from) {
      Vec3 result;
      for (int a = 0; a < 3; ++a) {
        const double along = glm::dot(axes[a], displacement) / (1 << kFrameBits) - from[a];
        result[a] = static_cast<int>(std::floor(along / step_[a] + 0.5));
      }
      return result;
    };
    Vec3 residual = steps(target - glm::dvec3(vectorOf(p.point)), glm::dvec3(vectorOf(p.offset)));
    for (int pass = 0; pass < 3; ++pass) {
      const Vec3 correction = steps(target - glm::dvec3(vectorOf(reconstruct(p, lanesOf(residual)))), glm::dvec3(0));
      if (correction == Vec3(0)) break;
      residual += correction;
    }
    return residual;
  }

  /// Tangent mode: rounds components that lie near the middle between two steps to the smaller one, where that saves
  /// more bits than the error is worth. A Laplace distribution of mean magnitude m saves 1.44 / m bits a step, which at
  /// high rates weigh 0.17 / m squared steps; a little less is best. Stays within the bound of rounding each component.
  Vec3 cheaperResidual(const Prediction& p, const glm::dvec3& target, Vec3 residual) const {
    const Integers around = magnitudeOf(p);
    constexpr double kWorth = 0.055, kMostSlack = 0.15, kSquareBound = 0.7;
    if (!tangent_ || step_[0] != step_[1]) return residual;
    const glm::dvec3 displacement = target - glm::dvec3(vectorOf(reconstruct(p, lanesOf(residual))));
    const auto along = [&](Lanes axis) { return glm::dot(axisOf(axis), displacement); };
    glm::dvec3 left_over = glm::dvec3(along(p.frame.normal), along(p.frame.first), along(p.frame.second)) /
                           (static_cast<double>(step_[0]) * (1 << kFrameBits));
    for (int a = 0; a < 3; ++a) {
      const int sign = (residual[a] > 0) - (residual[a] < 0);
      const double magnitude = around[a] / 6.0 + 0.5;
      if (sign == 0 || left_over[a] * sign > std::min(kWorth / magnitude, kMostSlack) - 0.5) continue;
      glm::dvec3 moved = left_over;
      moved[a] += sign;
      if (glm::dot(moved, moved) > kSquareBound) continue;
      left_over = moved;
      residual[a] -= sign;
    }
    return residual;
  }

  std::array<std::int32_t, 3> wantedResidual(const Prediction& p, const glm::dvec3& target) const {
    const Vec3 residual = cheaperResidual(p, target, nearestResidual(p, target));
    return {residual.x, residual.y, residual.z};
  }

  Direction direction_;
  const PositionParameters& parameters_;
  const bool tangent_;
  const bool adaptive_;
  const CodingOrder& order_;
  const std::span<VertexState> states_;  ///< by time
  const Integers step_;                  ///< of each component on the fine lattice
  const int normal_bits_;                ///< floor(log2(step)) of the normal
  ResidualCoder<Direction> residuals_;
  std::unique_ptr<MixedResiduals<Direction>> mixed_;  ///< at effort max
  IntegerModel free_[3];                              ///< components of vertices without a stencil
  AdaptiveOffset offsets_[kCountClasses];
  Features features_{Frame{}, Surrounding{}, Integers{}};
};

}  // namespace

CodingStart codingStart(const Surface& surface, const PositionMap& map, Order order) {
  CodingStart start{codingOrder(surface, map, order), Buffer<VertexState>(map.position_count)};
  collectStencils(start.order, start.states);
  return start;
}

double encodePositions(const CodingStart& start, const PositionParameters& parameters,
                       std::span<const glm::dvec3> target, EntropyWriter& writer, std::vector<Vec3>* decoded,
                       std::uint32_t count) {
  const auto first = start.states.begin();
  Buffer<VertexState> states(first, first + std::min<std::ptrdiff_t>(count, std::ssize(start.states)));
  const double squared_error = PositionCoder<Writing>(Writing{writer}, start.order, states, parameters).run(target);
  if (decoded != nullptr) *decoded = pointsOf(start.order, states);
  return squared_error;
}

Status decodePositions(const CodingOrder& order, const PositionParameters& parameters, EntropyReader& reader,
                       std::span<VertexState> states) {
  PositionCoder<Reading>(Reading{reader}, order, states, parameters).run({});
  if (reader.overrun()) return Error{ErrorCode::kTruncated, "positions", reader.position()};
  return {};
}

std::vector<Vec3> pointsOf(const CodingOrder& order, std::span<const VertexState> states) {
  std::vector<Vec3> points(states.size());
  for (std::uint32_t time = 0; time < states.size(); ++time) {
    points[order.positionAt(time)] = vectorOf(states[time].point);
  }
  return points;
}

}  // namespace tsc
