#include "positions.h"

#include "adaptive_offset.h"
#include "direction.h"
#include "format.h"
#include "order.h"
#include "predict.h"
#include "residual_coder.h"
#include "residual_context.h"
#include "stencil.h"

namespace tsc {
namespace {

constexpr int kDisplacementBits = 28;
constexpr std::int64_t kMaxDisagreement = std::int64_t{1} << 21;

/// What a vertex is predicted from.
struct Prediction {
  Stencils stencils;
  std::array<Vec3, kMaxStencils> candidates{};  ///< parallelograms
  Vec3 mean{0};                                 ///< their average
  Vec3 point{0};                                ///< the chosen predictor's, before the adaptive offset
  Frame frame;
  std::array<std::int64_t, 3> offset{};  ///< adaptive offset, local
};

int countClass(const Stencils& stencils) { return std::min(stencils.count, kCountClasses) - 1; }

/// Whether all components lie in [-2^bits, 2^bits): the test that spares nearly every vertex its clamps.
template <class Vector>
bool within(const Vector& v, int bits) {
  using Scalar = typename Vector::value_type;
  const Scalar half = Scalar{1} << bits;
  return (((v.x + half) | (v.y + half) | (v.z + half)) >> (bits + 1)) == 0;
}

Vec3 clampedToLattice(const Vec3& v) {
  if (within(v, kMaxLatticeBits)) [[likely]]
    return v;
  return glm::clamp(v, Vec3(-kCoordinateLimit), Vec3(kCoordinateLimit));
}

std::uint32_t magnitudeSum(const std::vector<VertexState>& states, const Stencil& s, int a) {
  return std::uint32_t{states[s.left].magnitude[a]} + states[s.right].magnitude[a] + states[s.base].magnitude[a];
}

template <class Direction>
class PositionCoder {
 public:
  PositionCoder(Direction direction, const Surface& surface, const PositionMap& map,
                const PositionParameters& parameters)
      : direction_(direction),
        surface_(surface),
        map_(map),
        parameters_(parameters),
        states_(surface.vertexCount()),
        known_(surface.vertexCount()),
        residuals_(direction, parameters.exact_hits, parameters.effort) {
    step_ = {1 << parameters.fine_bits, 1 << parameters.fine_bits, 1 << parameters.fine_bits};
    if (parameters.mode == Mode::kTangent)
      step_[0] = std::max<int>(step_[0] / static_cast<int>(parameters.normal_scale), 1);
    for (int a = 0; a < 3; ++a) {
      sixteenths_[a] = (16u << 12) / static_cast<std::uint32_t>(step_[a]);
      half_reciprocals_[a] = (std::uint64_t{1} << 31) / static_cast<std::uint64_t>(step_[a]);
    }
  }

  /// Codes every position once, at the vertex of it that comes first in the order.
  void run(std::span<const glm::dvec3> target, std::vector<Vec3>& decoded) {
    decoded.resize(map_.position_count);
    const bool repeats = map_.position_count < realVertexCount();
    if (repeats) linkRepeats();
    const auto code = [&](std::uint32_t v) {
      if (known_[v]) return !direction_.overrun();
      const std::uint32_t position = map_.vertex_position[v];
      codeVertex(v, Direction::kWrites ? target[position] : glm::dvec3(0));
      decoded[position] = states_[v].position;
      if (repeats) spread(v);
      return !direction_.overrun();
    };
    if (parameters_.order == Order::kTraversal) {
      for (std::uint32_t v = 0; v < surface_.vertexCount(); ++v) {
        if (!surface_.is_dummy[v] && !code(v)) return;
      }
    } else {
      visitByDegree(surface_, code);
    }
  }

 private:
  std::uint32_t realVertexCount() const {
    std::uint32_t count = 0;
    for (const std::uint8_t dummy : surface_.is_dummy) count += !dummy;
    return count;
  }

  /// Rings of the vertices that share a position.
  void linkRepeats() {
    next_repeat_.resize(surface_.vertexCount());
    std::vector<std::uint32_t> last(map_.position_count, kNone);
    for (std::uint32_t v = 0; v < surface_.vertexCount(); ++v) {
      next_repeat_[v] = v;
      if (surface_.is_dummy[v]) continue;
      std::uint32_t& tail = last[map_.vertex_position[v]];
      if (tail != kNone) std::swap(next_repeat_[v], next_repeat_[tail]);
      tail = v;
    }
  }

  void spread(std::uint32_t v) {
    for (std::uint32_t other = next_repeat_[v]; other != v; other = next_repeat_[other]) {
      states_[other] = states_[v];
      known_[other] = 1;
    }
  }

  void codeVertex(std::uint32_t v, const glm::dvec3& target) {
    Prediction p;
    p.stencils = stencilsAt(surface_, known_, v);
    VertexState& state = states_[v];
    if (p.stencils.count == 0) {
      codeFree(state, p.stencils.neighbour, target);
    } else {
      predict(p);
      codeResiduals(v, p, target);
    }
    state.valence = p.stencils.valence;
    known_[v] = 1;
    last_ = state.position;
  }

  /// A vertex without a complete parallelogram, the first triangle of a component above all: exact to the fine lattice.
  void codeFree(VertexState& state, std::uint32_t neighbour, const glm::dvec3& target) {
    const Vec3 origin = neighbour == kNone ? last_ : states_[neighbour].position;
    Vec3 difference(0);
    if constexpr (Direction::kWrites) difference = Vec3(glm::floor(target + 0.5)) - origin;
    for (int a = 0; a < 3; ++a) {
      difference[a] = unzigzag(direction_.integer(free_[a], zigzag(difference[a])));
    }
    state.position = clampedToLattice(Vec3(
        glm::clamp(WideVec3(origin) + WideVec3(difference), WideVec3(-kCoordinateLimit), WideVec3(kCoordinateLimit))));
  }

  void predict(Prediction& p) {
    const Stencils& s = p.stencils;
    for (int j = 0; j < s.count; ++j) {
      const Stencil& t = s.list[j];
      p.candidates[j] = parallelogram(states_[t.left].position, states_[t.right].position, states_[t.base].position);
    }
    p.mean = average(p.candidates.data(), s.count);
    const Stencil& gate = s.list[0];
    const Vec3& left = states_[gate.left].position;
    const Vec3& right = states_[gate.right].position;
    const Vec3& base = states_[gate.base].position;
    switch (parameters_.predictor) {
      case Predictor::kParallelogram:
        p.point = p.candidates[0];
        break;
      case Predictor::kWeighted:
      case Predictor::kValence:
        p.point = clampedToLattice(weightedParallelogram(
            left, right, base,
            expectedAngles(surface_, states_, known_, s.valence, gate, parameters_.predictor == Predictor::kWeighted)));
        break;
      default:
        p.point = p.mean;
    }
    if (parameters_.mode == Mode::kTangent) p.frame = frameAt(parameters_.basis, left, right, base, p.point);
    if (parameters_.predictor == Predictor::kAdaptive) {
      features_ = toLocal(p.frame, featuresOf(p));
      p.offset = offsets_[countClass(s)].offset(features_);
    }
  }

  Features featuresOf(const Prediction& p) const {
    const Stencils& s = p.stencils;
    const VertexState& left = states_[s.list[0].left];
    const VertexState& right = states_[s.list[0].right];
    const VertexState& base = states_[s.list[0].base];
    const Vec3 apart = p.candidates[0] - p.mean;
    // From the base vertex to the middle of the gate, alone and by how far valences are from regular; the gate by how
    // far its ends' valences differ.
    const Vec3 height = ((left.position - base.position) + (right.position - base.position)) / 2;
    const Vec3 gate = left.position - right.position;
    const auto bounded = [](int factor) {
      return static_cast<std::int16_t>(std::clamp(factor, -kFactorLimit, kFactorLimit));
    };
    Features f;
    f.x = WideLanes{Integers{left.surprise.x, right.surprise.x, base.surprise.x, apart.x},
                    Integers{height.x, height.x, gate.x, height.x}};
    f.y = WideLanes{Integers{left.surprise.y, right.surprise.y, base.surprise.y, apart.y},
                    Integers{height.y, height.y, gate.y, height.y}};
    f.z = WideLanes{Integers{left.surprise.z, right.surprise.z, base.surprise.z, apart.z},
                    Integers{height.z, height.z, gate.z, height.z}};
    f.factor = Lanes{kFactorOne,
                     kFactorOne,
                     kFactorOne,
                     kFactorOne,
                     kFactorOne,
                     bounded(s.valence - 6),
                     bounded(left.valence - right.valence),
                     bounded(left.valence + right.valence - base.valence - 6)};
    return f;
  }

  /// The first candidates' displacements from the predicted point, local.
  std::array<std::array<std::int64_t, 3>, kCandidates> candidatesOf(const Prediction& p) const {
    WideVec3 local[kCandidates] = {WideVec3(0), WideVec3(0)};
    const bool several = p.stencils.count > 1;
    const Vec3 first = p.candidates[0] - p.point;
    const Vec3 second = several ? p.candidates[1] - p.point : Vec3(0);
    if (parameters_.mode == Mode::kLattice) {
      local[0] = WideVec3(first);
      local[1] = WideVec3(second);
    } else if (several || p.point != p.mean) {
      local[0] = toLocal(p.frame, first);
      // Two candidates lie on opposite sides of their mean.
      local[1] = p.stencils.count == 2 && p.point == p.mean ? -local[0] : toLocal(p.frame, second);
    }
    return {{{local[0].x, local[0].y, local[0].z}, {local[1].x, local[1].y, local[1].z}}};
  }

  Surroundings surroundingsOf(const Prediction& p,
                              const std::array<std::array<std::int64_t, 3>, kCandidates>& local) const {
    const Stencils& s = p.stencils;
    Surroundings around;
    around.stencil_count = s.count;
    for (int a = 0; a < 3; ++a) {
      const std::uint32_t sum = magnitudeSum(states_, s.list[0], a);
      around.residual[a] =
          s.count > 1 ? ((sum + magnitudeSum(states_, s.list[1], a)) * 2731u) >> 10 : (sum * 5461u) >> 10;
    }
    if (s.count == 1) {
      const Vec3 gate = glm::abs(states_[s.list[0].left].position - states_[s.list[0].right].position);
      around.gate = static_cast<std::uint32_t>(
          (((std::int64_t{gate.x} + gate.y + gate.z) * 16 >> parameters_.fine_bits) * 5461) >> 14);
    } else {
      for (int a = 0; a < 3; ++a) {
        const std::int64_t spread = ((std::abs(local[0][a]) + std::abs(local[1][a])) * sixteenths_[a]) >> 13;
        around.disagreement[a] = static_cast<std::uint32_t>(std::min(spread, kMaxDisagreement));
      }
    }
    return around;
  }

  void codeResiduals(std::uint32_t v, const Prediction& p, const glm::dvec3& target) {
    VertexState& state = states_[v];
    std::array<std::int32_t, 3> residual{};
    if constexpr (Direction::kWrites) {
      const Vec3 nearest = nearestResidual(p, target);
      residual = {nearest.x, nearest.y, nearest.z};
    }
    const auto local = candidatesOf(p);
    const Surroundings around = surroundingsOf(p, local);
    const Stencil& gate = p.stencils.list[0];
    Component component;
    component.count_class = countClass(p.stencils);
    component.candidate_count = std::min(p.stencils.count, kCandidates);
    for (int a = 0; a < 3; ++a) {
      component.axis = a;
      component.hits_around = (states_[gate.left].hits >> a & 1) + (states_[gate.right].hits >> a & 1);
      for (int j = 0; j < kCandidates; ++j) {
        component.candidates[j] = inSteps(local[j][a] - p.offset[a], a);
      }
      residual[a] = residuals_.code(component, residualContext(around, a), residual[a]);
      if (parameters_.predictor == Predictor::kAdaptive) {
        offsets_[component.count_class].learn(a, features_, residual[a]);
      }
      state.magnitude[a] = static_cast<std::uint16_t>(std::min<std::int32_t>(std::abs(residual[a]), kMaxMagnitude));
    }
    state.hits = component.hits;
    state.position = reconstruct(p, {residual[0], residual[1], residual[2]});
    state.surprise = state.position - p.mean;
  }

  /// A local coordinate in steps of its axis, rounded; |local| < 2^30.
  std::int32_t inSteps(std::int64_t local, int a) const {
    const std::uint64_t doubled =
        2 * static_cast<std::uint64_t>(std::abs(local)) + static_cast<std::uint64_t>(step_[a]);
    const auto magnitude = static_cast<std::int32_t>((doubled * half_reciprocals_[a]) >> 32);
    return local < 0 ? -magnitude : magnitude;
  }

  static WideVec3 offsetOf(const Prediction& p) { return {p.offset[0], p.offset[1], p.offset[2]}; }

  Vec3 reconstruct(const Prediction& p, const Vec3& residual) const {
    WideVec3 local = offsetOf(p) + WideVec3(residual) * WideVec3(step_[0], step_[1], step_[2]);
    if (!within(local, kDisplacementBits)) [[unlikely]] {
      constexpr std::int64_t kLimit = std::int64_t{1} << kDisplacementBits;
      local = glm::clamp(local, WideVec3(-kLimit), WideVec3(kLimit));
    }
    if (parameters_.mode == Mode::kLattice) return clampedToLattice(p.point + Vec3(local));
    return clampedToLattice(p.point + toLattice(p.frame, local));
  }

  /// The residual whose reconstruction is nearest to the target: the frame is orthonormal only up to 2^-13, so that
  /// large residuals are corrected by what they leave over.
  Vec3 nearestResidual(const Prediction& p, const glm::dvec3& target) const {
    if (parameters_.mode == Mode::kLattice) return Vec3(glm::floor(target + 0.5)) - p.point - Vec3(offsetOf(p));
    const glm::dvec3 axes[3] = {glm::dvec3(p.frame.normal), glm::dvec3(p.frame.first), glm::dvec3(p.frame.second)};
    const auto steps = [&](const glm::dvec3& displacement, const glm::dvec3& from) {
      Vec3 result;
      for (int a = 0; a < 3; ++a) {
        const double along = glm::dot(axes[a], displacement) / (1 << kFrameBits) - from[a];
        result[a] = static_cast<int>(std::floor(along / step_[a] + 0.5));
      }
      return result;
    };
    Vec3 residual = steps(target - glm::dvec3(p.point), glm::dvec3(offsetOf(p)));
    for (int pass = 0; pass < 3; ++pass) {
      const Vec3 correction = steps(target - glm::dvec3(reconstruct(p, residual)), glm::dvec3(0));
      if (correction == Vec3(0)) break;
      residual += correction;
    }
    return residual;
  }

  Direction direction_;
  const Surface& surface_;
  const PositionMap& map_;
  const PositionParameters& parameters_;
  std::vector<VertexState> states_;
  std::vector<std::uint8_t> known_;  ///< beside the states, so that the walk around a vertex stays in the cache
  std::vector<std::uint32_t> next_repeat_;
  ResidualCoder<Direction> residuals_;
  IntegerModel free_[3];  ///< components of vertices without a stencil
  AdaptiveOffset offsets_[kCountClasses];
  std::array<int, 3> step_;
  std::array<std::int64_t, 3> sixteenths_;
  std::array<std::uint64_t, 3> half_reciprocals_;
  LocalFeatures features_;
  Vec3 last_{0};
};

}  // namespace

namespace {

/// Positions that the surface does not have: differences on the fine lattice, one after another.
template <class Direction>
void codeExtraPositions(Direction direction, std::span<const glm::dvec3> target, std::span<Vec3> decoded) {
  IntegerModel models[3];
  Vec3 last(0);
  for (std::size_t i = 0; i < decoded.size() && !direction.overrun(); ++i) {
    WideVec3 difference(0);
    if constexpr (Direction::kWrites) difference = WideVec3(glm::floor(target[i] + 0.5)) - WideVec3(last);
    for (int a = 0; a < 3; ++a) {
      difference[a] = unzigzag(direction.integer(models[a], zigzag(static_cast<std::int32_t>(difference[a]))));
    }
    last = Vec3(glm::clamp(WideVec3(last) + difference, WideVec3(-kCoordinateLimit), WideVec3(kCoordinateLimit)));
    decoded[i] = last;
  }
}

}  // namespace

void encodeExtraPositions(std::span<const glm::dvec3> target, EntropyWriter& writer, std::span<Vec3> decoded) {
  codeExtraPositions(Writing{writer}, target, decoded);
}

Status decodeExtraPositions(EntropyReader& reader, std::span<Vec3> decoded) {
  codeExtraPositions(Reading{reader}, {}, decoded);
  if (reader.overrun()) return Error{ErrorCode::kTruncated, "extra positions", reader.position()};
  return {};
}

void encodePositions(const Surface& surface, const PositionMap& map, const PositionParameters& parameters,
                     std::span<const glm::dvec3> target, EntropyWriter& writer, std::vector<Vec3>& decoded) {
  PositionCoder<Writing>(Writing{writer}, surface, map, parameters).run(target, decoded);
}

Status decodePositions(const Surface& surface, const PositionMap& map, const PositionParameters& parameters,
                       EntropyReader& reader, std::vector<Vec3>& decoded) {
  PositionCoder<Reading>(Reading{reader}, surface, map, parameters).run({}, decoded);
  if (reader.overrun()) return Error{ErrorCode::kTruncated, "positions", reader.position()};
  return {};
}

}  // namespace tsc
