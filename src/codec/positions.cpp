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

/// What a vertex is predicted from.
struct Prediction {
  int count_class = 0;                            ///< complete parallelograms, up to kCountClasses, less one
  std::array<const VertexState*, 6> around{};     ///< left, right and base of the first two parallelograms
  std::array<Integers, kMaxStencils> candidates;  ///< parallelograms
  Integers mean;                                  ///< their average
  Integers point;                                 ///< the chosen predictor's, before the adaptive offset
  Integers magnitude;                             ///< sum over six neighbours
  Frame frame;
  LocalSurrounding surrounding;
  Integers offset{};  ///< adaptive offset, local

  // The gate is the first parallelogram's.
  const VertexState* left() const { return around[0]; }
  const VertexState* right() const { return around[1]; }
  const VertexState* base() const { return around[2]; }
};

Integers clampedToLattice(Integers v) { return bounded(v, kCoordinateLimit); }
Vec3 clampedToLattice(const Vec3& v) { return glm::clamp(v, Vec3(-kCoordinateLimit), Vec3(kCoordinateLimit)); }

/// Of each component, on the fine lattice.
std::array<std::int32_t, 3> stepsOf(const PositionParameters& p) {
  const std::int32_t fine = 1 << p.fine_bits;
  const bool finer = p.mode == Mode::kTangent;
  return {finer ? std::max(fine / static_cast<std::int32_t>(p.normal_scale), 1) : fine, fine, fine};
}

/// floor(log2) of each step.
std::array<int, 3> bitsOf(const std::array<std::int32_t, 3>& steps) {
  const auto bits = [&](std::size_t a) {
    return static_cast<int>(std::bit_width(static_cast<unsigned>(steps[a]))) - 1;
  };
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
        exact_hits_(parameters.exact_hits),
        order_(order),
        states_(states),
        step_(stepsOf(parameters)),
        residuals_(direction, parameters.exact_hits, parameters.centred_only, bitsOf(step_)) {
    const std::array<int, 3> bits = bitsOf(step_);
    step_bits_ = Integers{bits[0], bits[1], bits[2], 0};
    if (parameters.effort == Effort::kMax) {
      mixed_ = std::make_unique<MixedResiduals<Direction>>(
          direction, ResidualSteps(step_, parameters.fine_bits, !tangent_), adaptive_);
    }
  }

  /// Returns the sum of squared errors when writing.
  double run(std::span<const glm::dvec3> target) {
    double squared_error = 0;
    const double cells = 1 << parameters_.fine_bits;
    Hot<Direction> coder(direction_);
    for (std::uint32_t time = 0; time < states_.size(); ++time) {
      if (time % kOverrunInterval == 0) {
        coder.to(direction_);
        if (direction_.overrun()) break;
      }
      const glm::dvec3 wanted = Direction::kWrites ? target[order_.positionAt(time)] * cells : glm::dvec3(0);
      codeVertex(coder, time, wanted);
      if constexpr (Direction::kWrites) {
        const glm::dvec3 error = wanted - glm::dvec3(vectorOf(states_[time].point));
        squared_error += glm::dot(error, error);
      }
    }
    coder.to(direction_);
    return squared_error;
  }

 private:
  static constexpr std::uint32_t kOverrunInterval = 1024;
  /// Until then all components learn all they can from each vertex; then in turns, which is as good and faster.
  static constexpr std::uint32_t kEagerUntil = 2048;

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
    } else {
      Prediction p;
      predict(time, stencils, p);
      codeResiduals(coder, state, stencils.valence, time, p, target);
    }
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
    const Vec3 position(
        glm::clamp(WideVec3(origin) + WideVec3(difference), WideVec3(-kCoordinateLimit), WideVec3(kCoordinateLimit)));
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
    place(time, arc.list[0].face, stencils.valence, p);
    const ToLocal local(p.frame, tangent_);
    const MixedFeatures features = mixedFeatures({order_, states_, time}, arc, stencils.valence, local, tangent_);
    p.offset = mixed_->offset(features, arc.count, stencils.valence);
    std::array<std::int32_t, 3> residual{};
    if constexpr (Direction::kWrites) residual = wantedResidual(p, target);
    const std::uint32_t hits = mixed_->code(mixedVertexOf(p, arc.count, stencils.valence, local), residual);
    remember(states_[time], stencils.valence, p, residual, hits);
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

  TSC_ALWAYS_INLINE void predict(std::uint32_t time, const Stencils& stencils, Prediction& p) {
    std::array<Parallelogram, kMaxStencils> parallelograms;
    for (std::size_t j = 0; j < kMaxStencils; ++j) {
      parallelograms[j] = stencils[j];
    }
    gather(parallelograms, stencils.count, p);
    place(time, stencils.face(0), stencils.valence, p);
    if (tangent_ || adaptive_) p.surrounding = toLocal(p.frame, tangent_, surroundingOf(p));
    if (adaptive_) {
      const int left = p.left()->valence(), right = p.right()->valence(), base = p.base()->valence();
      features_ = Features(p.surrounding, stencils.valence - 6, left - right, left + right - base - 6);
      p.offset = offsets_[p.count_class].offset(features_);
    }
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
    UnsignedLanes memory{};  // the lanes of magnitudes stay within 15 bits, the others wrap
    for (const VertexState* state : p.around) memory += (UnsignedLanes)loadLanes(state->memory.data());
    p.magnitude = widenedHigh((Lanes)memory);
    p.mean = average(p.candidates[0], p.candidates[1] + p.candidates[2] - p.candidates[0] - p.candidates[0], count);
  }

  /// The predicted point and the frame there.
  TSC_ALWAYS_INLINE void place(std::uint32_t time, std::uint32_t face, std::int32_t valence, Prediction& p) const {
    p.point = p.mean;
    if (parameters_.predictor < Predictor::kAverage) [[unlikely]] {
      p.point =
          parameters_.predictor == Predictor::kParallelogram ? p.candidates[0] : weightedPoint(time, face, valence, p);
    }
    if (tangent_) {
      p.frame = frameAt(parameters_.basis, p.left()->point, p.right()->point, p.base()->point, p.point);
    }
  }

  /// Of the predictors that are not made of candidates' means.
  [[gnu::noinline]] Integers weightedPoint(std::uint32_t time, std::uint32_t face, std::int32_t valence,
                                           const Prediction& p) const {
    const bool use_known_angles = parameters_.predictor == Predictor::kWeighted;
    return lanesOf(clampedToLattice(
        weightedParallelogram(vectorOf(p.left()->point), vectorOf(p.right()->point), vectorOf(p.base()->point),
                              expectedAngles({order_, states_}, time, face, valence, use_known_angles))));
  }

  TSC_ALWAYS_INLINE static Surrounding surroundingOf(const Prediction& p) {
    const Integers left = p.left()->point, right = p.right()->point, base = p.base()->point;
    Surrounding s;
    s.left_surprise = p.left()->surprise();
    s.right_surprise = p.right()->surprise();
    s.base_surprise = p.base()->surprise();
    s.first = p.candidates[0] - p.point;
    s.second = p.candidates[1] - p.point;
    s.height = ((left - base) + (right - base)) >> 1;
    s.gate = left - right;
    return s;
  }

  /// The first candidates' displacements from the predicted point, local.
  TSC_ALWAYS_INLINE std::array<Integers, kCandidates> candidatesOf(const Prediction& p) const {
    if (!tangent_) return {p.candidates[0] - p.point, p.candidates[1] - p.point};
    return p.surrounding.candidates();
  }

  TSC_ALWAYS_INLINE Neighbourhood neighbourhoodOf(const Prediction& p,
                                                  const std::array<Integers, kCandidates>& local) const {
    Neighbourhood around;
    around.magnitude = p.magnitude;
    around.count_class = p.count_class;
    const Integers gate = magnitudes(p.left()->point - p.right()->point) >> 2;
    const Integers extents = splatInteger(gate[0] + gate[1] + gate[2]);
    const Integers spread = p.count_class == 0 ? extents : magnitudes(local[0]) + magnitudes(local[1]);
    const int shift = kFineBits - parameters_.fine_bits;
    around.spread = smaller(spread, splatInteger(kMaxSpread >> (kFineBits + 2))) << shift;
    return around;
  }

  TSC_ALWAYS_INLINE void codeResiduals(Hot<Direction>& coder, VertexState& state, std::int32_t valence,
                                       std::uint32_t time, const Prediction& p, const glm::dvec3& target) {
    std::array<std::int32_t, 3> wanted{};
    if constexpr (Direction::kWrites) wanted = wantedResidual(p, target);
    std::array<Integers, kCandidates> candidates = candidatesOf(p);
    const ResidualContexts contexts = residualContexts(neighbourhoodOf(p, candidates));
    std::array<std::int32_t, 3> residual;
    std::uint32_t hits = 0;
    const bool eager = time < kEagerUntil;
    const std::uint32_t learning = eager ? 7 : 1u << time % 4;
    if (exact_hits_ || (p.count_class > 0 && residuals_.usesCandidates())) {
      codeComponents<true>(coder, p, contexts, candidates, learning, wanted, hits, residual);
    } else {
      codeComponents<false>(coder, p, contexts, candidates, learning, wanted, hits, residual);
    }
    codeLowBits(coder, contexts, hits, wanted, residual);
    remember(state, valence, p, residual, hits);
    if (adaptive_ && (eager || time % 2 == 1)) {
      offsets_[p.count_class].learn(features_, Integers{residual[0], residual[1], residual[2], 0});
    }
  }

  /// `candidates`: their displacements from the predicted point, local. `learning`: bits of the components whose
  /// candidates learn from this vertex.
  template <bool kWithCandidates>
  TSC_ALWAYS_INLINE void codeComponents(Hot<Direction>& coder, const Prediction& p, const ResidualContexts& contexts,
                                        std::array<Integers, kCandidates> candidates, std::uint32_t learning,
                                        const std::array<std::int32_t, 3>& wanted, std::uint32_t& hits,
                                        std::array<std::int32_t, 3>& residual) {
    std::array<Integers, kCandidates> offsets;
    if constexpr (kWithCandidates) {
      for (std::size_t j = 0; j < kCandidates; ++j) {
        candidates[j] -= p.offset;
        offsets[j] = scaledDown(candidates[j], contexts.shifts + step_bits_, kMaxOffset);
      }
    }
    const auto component = [&](int a) {
      Component c;
      c.scale = contexts.scale(a);
      c.shift = contexts.shift(a);
      c.ratio = contexts.ratio(a);
      if constexpr (kWithCandidates) {
        c.count_class = p.count_class;
        c.first_offset = offsets[0][a];
        c.second_offset = offsets[1][a];
        c.candidates_learn = (learning >> a & 1) != 0;
        if (exact_hits_) {
          const std::int32_t half_step = (1 << step_bits_[a]) >> 1;
          c.candidates = {(candidates[0][a] + half_step) >> step_bits_[a],
                          (candidates[1][a] + half_step) >> step_bits_[a]};
          c.hits_around = (p.left()->hits() >> a & 1) + (p.right()->hits() >> a & 1);
        }
      }
      return c;
    };
    residual[0] = residuals_.template code<0, kWithCandidates>(coder, component(0), hits, wanted[0]);
    residual[1] = residuals_.template code<1, kWithCandidates>(coder, component(1), hits, wanted[1]);
    residual[2] = residuals_.template code<2, kWithCandidates>(coder, component(2), hits, wanted[2]);
  }

  TSC_ALWAYS_INLINE void remember(VertexState& state, std::int32_t valence, const Prediction& p,
                                  const std::array<std::int32_t, 3>& residual, std::uint32_t hits) const {
    const Integers steps = {residual[0], residual[1], residual[2], 0};
    const Integers point = reconstruct(p, residual);
    const Integers magnitude = smaller(magnitudes(steps), splatInteger(kMaxMagnitude));
    storeLanes(state.memory.data(), packed(point - p.mean, withLast(magnitude, static_cast<std::int32_t>(hits))));
    state.point = withLast(point, valence);
  }

  /// The bits below the bins' widths of all components that are no hits, the first component's highest.
  TSC_ALWAYS_INLINE void codeLowBits(Hot<Direction>& coder, const ResidualContexts& contexts, std::uint32_t hits,
                                     const std::array<std::int32_t, 3>& wanted, std::array<std::int32_t, 3>& residual) {
    const int third = hits & 4 ? 0 : contexts.shift(2);
    const int second = hits & 2 ? 0 : contexts.shift(1);
    const int first = hits & 1 ? 0 : contexts.shift(0);
    std::uint64_t bits = 0;
    if constexpr (Direction::kWrites) {
      bits = static_cast<std::uint64_t>(wanted[0] - residual[0]) << (second + third) |
             static_cast<std::uint64_t>(wanted[1] - residual[1]) << third |
             static_cast<std::uint64_t>(wanted[2] - residual[2]);
    }
    bits = coder.longRaw(bits, first + second + third);
    residual[0] += static_cast<std::int32_t>(bits >> (second + third));
    residual[1] += static_cast<std::int32_t>(bits >> third & ((1u << second) - 1));
    residual[2] += static_cast<std::int32_t>(bits & ((1u << third) - 1));
  }

  TSC_ALWAYS_INLINE Integers reconstruct(const Prediction& p, const std::array<std::int32_t, 3>& residual) const {
    const Integers local =
        p.offset + Integers{residual[0] * step_[0], residual[1] * step_[1], residual[2] * step_[2], 0};
    return clampedToLattice(p.point + (tangent_ ? toLattice(p.frame, local) : local));
  }

  /// The residual whose reconstruction is nearest to the target: the frame is orthonormal only up to 2^-7, so that
  /// large residuals are corrected by what they leave over.
  Vec3 nearestResidual(const Prediction& p, const glm::dvec3& target) const {
    if (!tangent_) return Vec3(glm::floor(target + 0.5)) - vectorOf(p.point + p.offset);
    const glm::dvec3 axes[3] = {glm::dvec3(vectorOf(p.frame.normal)), glm::dvec3(vectorOf(p.frame.first)),
                                glm::dvec3(vectorOf(p.frame.second))};
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
      const Vec3 correction =
          steps(target - glm::dvec3(vectorOf(reconstruct(p, {residual.x, residual.y, residual.z}))), glm::dvec3(0));
      if (correction == Vec3(0)) break;
      residual += correction;
    }
    return residual;
  }

  /// Tangent mode: rounds components that lie near the middle between two steps to the smaller one, where that saves
  /// more bits than the error is worth. A Laplace distribution of mean magnitude m saves 1.44 / m bits a step, which at
  /// high rates weigh 0.17 / m squared steps; a little less is best. Stays within the bound of rounding each component.
  Vec3 cheaperResidual(const Prediction& p, const glm::dvec3& target, Vec3 residual) const {
    constexpr double kWorth = 0.055, kMostSlack = 0.15, kSquareBound = 0.7;
    if (!tangent_ || step_[0] != step_[1]) return residual;
    const glm::dvec3 displacement = target - glm::dvec3(vectorOf(reconstruct(p, {residual.x, residual.y, residual.z})));
    const auto along = [&](Integers axis) { return glm::dot(glm::dvec3(vectorOf(axis)), displacement); };
    glm::dvec3 left_over = glm::dvec3(along(p.frame.normal), along(p.frame.first), along(p.frame.second)) /
                           (static_cast<double>(step_[0]) * (1 << kFrameBits));
    for (int a = 0; a < 3; ++a) {
      const int sign = (residual[a] > 0) - (residual[a] < 0);
      const double magnitude = p.magnitude[a] / 6.0 + 0.5;
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
  const bool exact_hits_;
  const CodingOrder& order_;
  const std::span<VertexState> states_;     ///< by time
  const std::array<std::int32_t, 3> step_;  ///< of each component on the fine lattice
  Integers step_bits_;                      ///< floor(log2(step))
  ResidualCoder<Direction> residuals_;
  std::unique_ptr<MixedResiduals<Direction>> mixed_;  ///< at effort max
  IntegerModel free_[3];                              ///< components of vertices without a stencil
  AdaptiveOffset offsets_[kCountClasses];
  Features features_{{}, 0, 0, 0};
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
