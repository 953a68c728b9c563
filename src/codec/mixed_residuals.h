// Positions at effort max: a vertex is predicted by least squares, its residual coded by a mixture of all predictions
// and contexts (BITSTREAM.md, section 6.9).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "mixed_features.h"
#include "residual_mixer.h"
#include "stencil.h"

namespace tsc {

/// The lattice in which residuals count.
struct ResidualSteps {
  std::array<int, 3> step;  ///< of each component, in fine units
  int fine_bits;
  bool lattice;  ///< components are the lattice's own, so that neighbours' coordinates repeat
  std::array<std::uint64_t, 3> reciprocal;  ///< 2^31 / step

  ResidualSteps(const std::array<std::int32_t, 3>& steps, int bits, bool is_lattice)
      : step(steps), fine_bits(bits), lattice(is_lattice) {
    for (std::size_t a = 0; a < 3; ++a) reciprocal[a] = (std::uint64_t{1} << 31) / static_cast<std::uint64_t>(step[a]);
  }

  /// Local coordinates of one component in sixteenths of a step, rounded, within +-kPredictionLimit.
  Integers sixteenths(Integers local, std::size_t a) const {
    const Integers sign = local >> 31;
    const Words magnitude = (Words)smaller((local ^ sign) - sign, splatInteger(1 << 26));
    const Words doubled = (magnitude << 5) + static_cast<std::uint32_t>(step[a]);  // below 2^32
    const Integers wide = wordProductsHigh((Integers)doubled, static_cast<std::uint32_t>(reciprocal[a]));
    return (smaller(wide, splatInteger(kPredictionLimit)) ^ sign) - sign;
  }
};

/// What is known of a vertex, local vectors from the predicted point.
struct MixedVertex {
  int stencil_count = 0;  ///< 1..kMaxStencils
  int valence = 0;
  LocalVectors predicted;                      ///< average of all candidates, then these: parallelograms
  LocalVectors neighbour;                      ///< left, right, base of the first stencil
  std::array<const VertexState*, 6> around{};  ///< left, right, base of the first two stencils
  std::int64_t gate = 0;                       ///< sum of the gate's components' magnitudes on the fine lattice
};

/// How large the residual of a component is expected to be.
struct MixedScale {
  std::int32_t around = 0;  ///< mean magnitude of residuals of this component around, in sixteenths of a step
  std::int32_t spread = 0;  ///< how far the candidates lie apart, or with one of them the gate's size
  int unit_shift = 0;
  int fine = 0;    ///< half octaves below a unit's least, then their parity: 0..13
  int coarse = 0;  ///< 0..4
};

template <class Direction>
class MixedResiduals {
 public:
  /// `centred`: residuals count from what least squares predict; otherwise from the predicted point.
  MixedResiduals(Direction direction, const ResidualSteps& steps, bool centred)
      : steps_(steps), centred_(centred), mixer_(direction, steps.lattice) {}

  /// Where residuals count from, local, from the predicted point. `features` must stay until `code`.
  Integers offset(const MixedFeatures& features, int stencil_count, int valence) {
    features_ = &features;
    predictor_ = &least_squares_[(stencil_count - 1) * 3 + (valence < 6 ? 0 : valence == 6 ? 1 : 2)];
    fitted_ = predictor_->predict(features.scaled);
    offset_ = centred_ ? fitted_ : Integers{};
    return offset_;
  }

  /// Codes the three residuals, in steps; `offset` has been called for the vertex. Returns the axes on which any
  /// prediction came true, a bit each.
  std::uint32_t code(const MixedVertex& vertex, std::array<std::int32_t, 3>& residual) {
    const std::array<MixedScale, 3> scales = scalesOf(vertex);
    Progress progress;
    std::array<std::int32_t, 3> value;
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<std::size_t>(a);
      const ResidualEvidence evidence = evidenceOf(vertex, axis, scales[axis], progress);
      const std::int32_t limit = kMixedResidualLimit >> (std::bit_width(static_cast<unsigned>(steps_.step[axis])) - 1);
      residual[axis] = std::clamp(mixer_.code(evidence, residual[axis]), -limit, limit);
      value[axis] =
          std::clamp(residual[axis] * steps_.step[axis] + offset_[a], -kMixedResidualLimit, kMixedResidualLimit);
      if (a < 2) progress.coded[axis] = signedClass(std::int64_t{residual[axis]} * 16, scales[axis].around + 4);
      noteMatches(evidence, vertex.stencil_count, a, residual[axis], progress);
    }
    predictor_->learn(features_->scaled, value);
    return progress.hits;
  }

 private:
  static constexpr std::int32_t kMixedResidualLimit = 1 << 28;

  /// What the axes that are coded have told.
  struct Progress {
    std::array<int, 2> coded{};  ///< classes of their residuals
    /// Of each prediction, axes on which it came true; lanes as in ResidualEvidence.
    std::array<Integers, 2> matches{};
    std::uint32_t hits = 0;  ///< axes on which any did, a bit each
  };

  std::array<MixedScale, 3> scalesOf(const MixedVertex& v) const {
    std::array<MixedScale, 3> scales;
    const bool several = v.stencil_count > 1;
    Integers sum = v.around[0]->magnitude() + v.around[1]->magnitude() + v.around[2]->magnitude();
    if (several) sum += v.around[3]->magnitude() + v.around[4]->magnitude() + v.around[5]->magnitude();
    for (std::size_t a = 0; a < 3; ++a) {
      scales[a].around =
          static_cast<std::int32_t>((static_cast<std::uint32_t>(sum[a]) * (several ? 2731u : 5461u)) >> 10);
      const Integers apart = magnitudes(v.predicted[a]);
      const std::int64_t spread =
          several ? ((std::int64_t{apart[1]} + apart[2]) * static_cast<std::int64_t>(steps_.reciprocal[a] >> 15)) >> 13
                  : (((v.gate * 16) >> steps_.fine_bits) * 5461) >> 16;
      scales[a].spread = static_cast<std::int32_t>(std::min<std::int64_t>(spread, 1 << 21));
    }
    const std::int32_t all = ((scales[0].around + scales[1].around + scales[2].around) * 5461) >> 14;
    for (MixedScale& s : scales) {
      // 1.8 * (0.8 around + 0.2 all) + 0.4 spread, and a third of a step against zero.
      const auto expected =
          static_cast<std::uint32_t>(5 + ((s.around * 369 + all * 92 + (several ? s.spread * 102 : 0)) >> 8));
      const int width = static_cast<int>(std::bit_width(expected));
      const int half_octave = static_cast<int>((expected >> (width - 2)) & 1);
      s.unit_shift = std::min<int>(static_cast<int>(std::bit_width(expected / 96)), 19);
      s.fine = s.unit_shift == 0 ? std::min(2 * width + half_octave - 6, 11) : 12 + half_octave;
      s.coarse = s.fine / 3;
    }
    return scales;
  }

  /// Of a signed value against a scale: 0..6, 3 for the smallest.
  static int signedClass(std::int64_t value, std::int64_t scale) {
    const std::int64_t m = std::abs(value);
    const int c = (8 * m >= scale) + (2 * m >= scale) + (4 * m >= 5 * scale);
    return value < 0 ? 3 - c : 3 + c;
  }
  /// The same for several, of local coordinates within +-2^17 against a scale in sixteenths of a step.
  Integers signedClasses(Integers local, std::int32_t scale, std::size_t a) const {
    const Integers sign = local >> 31;
    const Integers m = ((local ^ sign) - sign) << 5;  // 16 times as much is 8 times as many sixteenths of a step
    const std::int32_t bound = scale * steps_.step[a];
    const Integers c = -(Integers)(m << 2 >= bound) - (Integers)(m >= bound) - (Integers)(m << 1 >= 5 * bound);
    return ((c ^ sign) - sign) + 3;
  }

  /// How far predictions have held for this vertex: nothing known, on no axis, on all, on some.
  static Integers matchClasses(int axis, Integers matches) {
    if (axis == 0) return Integers{};
    return 3 + ((Integers)(matches == 0) << 1) + (Integers)(matches == axis);
  }

  ResidualEvidence evidenceOf(const MixedVertex& v, std::size_t axis, const MixedScale& scale,
                              const Progress& progress) const {
    const int a = static_cast<int>(axis);
    const int count_class = v.stencil_count - 1;
    ResidualEvidence e;
    e.unit_shift = scale.unit_shift;
    e.voters = v.stencil_count;
    Integers predicted = v.predicted[axis];
    if (!centred_) predicted[0] = fitted_[a];
    e.prediction[0] = steps_.sixteenths(predicted - offset_[a], axis);
    e.prediction_context[0] = matchClasses(a, progress.matches[0]) + 4 * scale.coarse;
    e.prediction_context[0][0] = 3 * scale.coarse + count_class;
    constexpr Integers kVoting[3] = {{-1, 0, 0, 0}, {-1, -1, -1, 0}, {-1, -1, -1, -1}};
    e.present = kVoting[count_class];
    if (steps_.lattice) {
      e.prediction[1] = steps_.sixteenths(v.neighbour[axis] - offset_[a], axis);
      e.prediction_context[1] = matchClasses(a, progress.matches[1]) + 4 * scale.coarse;
    }
    const Integers surprises = signedClasses(features_->surprise[axis], scale.around + 8, axis);
    const auto spread = static_cast<std::uint32_t>(scale.spread);
    const int width = static_cast<int>(std::bit_width(spread));
    const int octaves = 2 * width + (width > 1 ? static_cast<int>(spread >> (width - 2) & 1) : 0);
    e.context = Integers{(a * 7 + (a > 0 ? progress.coded[0] : 0)) * 7 + (a > 1 ? progress.coded[1] : 0),
                         (surprises[0] * 7 + surprises[1]) * 7 + surprises[2], std::min(octaves, 24) * 14 + scale.fine,
                         std::min(v.valence, 12) * 14 + scale.fine};
    e.weight_set = {static_cast<std::uint8_t>(scale.fine),
                    static_cast<std::uint8_t>((a * 3 + count_class) * 4 + static_cast<int>(progress.hits))};
    return e;
  }

  /// Which of the predictions came true on this axis, to half a step.
  void noteMatches(const ResidualEvidence& e, int stencil_count, int axis, std::int32_t residual,
                   Progress& progress) const {
    constexpr Integers kCandidates[3] = {{0, -1, 0, 0}, {0, -1, -1, 0}, {0, -1, -1, -1}};
    const std::int32_t value =
        16 * std::clamp(residual, -kPredictionLimit / 8, kPredictionLimit / 8);  // no matter how far
    const auto matching = [&](Integers prediction) { return (Integers)(magnitudes(prediction - value) <= 8); };
    Integers any = matching(e.prediction[0]) & kCandidates[stencil_count - 1];
    progress.matches[0] -= any;
    if (steps_.lattice) {
      const Integers neighbours = matching(e.prediction[1]) & Integers{-1, -1, -1, 0};
      progress.matches[1] -= neighbours;
      any |= neighbours;
    }
    progress.hits |= static_cast<std::uint32_t>(!isZero(any)) << axis;
  }

  ResidualSteps steps_;
  bool centred_;
  ResidualMixer<Direction> mixer_;
  LeastSquares least_squares_[9];  ///< by count of stencils and valence
  // Of the vertex at work:
  const MixedFeatures* features_ = nullptr;
  LeastSquares* predictor_ = nullptr;
  Integers fitted_{};  ///< what least squares predict, local, from the predicted point
  Integers offset_{};
};

}  // namespace tsc
