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

  /// A local coordinate in sixteenths of a step, rounded, within +-kPredictionLimit.
  std::int32_t sixteenths(std::int64_t local, int axis) const {
    constexpr std::int64_t kLimit = std::int64_t{1} << 26;
    const auto a = static_cast<std::size_t>(axis);
    const std::uint64_t doubled = 32 * static_cast<std::uint64_t>(std::min(std::abs(local), kLimit)) +
                                  static_cast<std::uint64_t>(step[a]);  // below 2^32
    const auto wide = static_cast<std::int64_t>((doubled * reciprocal[a]) >> 32);
    const auto magnitude = static_cast<std::int32_t>(std::min<std::int64_t>(wide, kPredictionLimit));
    return local < 0 ? -magnitude : magnitude;
  }
};

/// What is known of a vertex, local vectors from the predicted point.
struct MixedVertex {
  int stencil_count = 0;  ///< 1..kMaxStencils
  int valence = 0;
  std::array<WideVec3, 3> candidate{};         ///< parallelograms, of the first three stencils
  std::array<const VertexState*, 6> around{};  ///< left, right, base of the first two stencils
  std::array<WideVec3, 3> neighbour{};         ///< left, right, base of the first stencil
  std::array<WideVec3, 3> surprise{};          ///< theirs
  WideVec3 mean{0};                            ///< average of all candidates
  std::int64_t gate = 0;                       ///< sum of the gate's components' magnitudes on the fine lattice
};

/// How large the residual of a component is expected to be.
struct MixedScale {
  std::uint32_t around = 0;  ///< mean magnitude of residuals of this component around, in sixteenths of a step
  std::uint32_t spread = 0;  ///< how far the candidates lie apart, or with one of them the gate's size
  int unit_shift = 0;
  int fine = 0;    ///< half octaves below a unit's least, then their parity: 0..13
  int coarse = 0;  ///< 0..4
};

template <class Direction>
class MixedResiduals {
 public:
  /// `centred`: residuals count from what least squares predict; otherwise from the predicted point.
  MixedResiduals(Direction direction, const ResidualSteps& steps, bool centred)
      : steps_(steps), centred_(centred), mixer_(direction, steps.lattice ? kMixedPredictions : 1 + kVoters) {}

  /// Where residuals count from, local, from the predicted point.
  Integers offset(const MixedFeatures& features, int stencil_count, int valence) {
    feature_count_ = features.count;
    shape_class_ = (std::min(stencil_count, 3) - 1) * 3 + (valence < 6 ? 0 : valence == 6 ? 1 : 2);
    for (std::size_t a = 0; a < 3; ++a) {
      fitted_[a] = least_squares_[shape_class_][a].predict(features.component[a], feature_count_);
      offset_[a] = centred_ ? fitted_[a] : 0;
    }
    return Integers{static_cast<std::int32_t>(offset_[0]), static_cast<std::int32_t>(offset_[1]),
                    static_cast<std::int32_t>(offset_[2]), 0};
  }

  /// Codes the three residuals, in steps; `offset` has been called for the vertex. Returns the axes on which any
  /// prediction came true, a bit each.
  std::uint32_t code(const MixedVertex& vertex, std::array<std::int32_t, 3>& residual) {
    scales_ = scalesOf(vertex);
    matches_ = {};
    hits_ = 0;
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<std::size_t>(a);
      const ResidualEvidence evidence = evidenceOf(vertex, a, residual);
      const std::int32_t limit = kMixedResidualLimit >> (std::bit_width(static_cast<unsigned>(steps_.step[axis])) - 1);
      residual[axis] = std::clamp(mixer_.code(evidence, residual[axis]), -limit, limit);
      const std::int64_t value = std::int64_t{residual[axis]} * steps_.step[axis] + offset_[axis];
      least_squares_[shape_class_][axis].learn(
          std::clamp<std::int64_t>(value, -kMixedResidualLimit, kMixedResidualLimit), feature_count_);
      noteMatches(vertex, evidence, a, residual[axis]);
    }
    return hits_;
  }

 private:
  static constexpr std::int32_t kMixedResidualLimit = 1 << 28;

  std::array<MixedScale, 3> scalesOf(const MixedVertex& v) const {
    std::array<MixedScale, 3> scales;
    const bool several = v.stencil_count > 1;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<int>(a);
      std::uint32_t sum = 0;
      for (std::size_t i = 0; i < (several ? 6 : 3); ++i)
        sum += static_cast<std::uint32_t>(v.around[i]->magnitude()[axis]);
      scales[a].around = (sum * (several ? 2731u : 5461u)) >> 10;
      const std::int64_t apart = std::abs(v.candidate[0][axis]) + std::abs(v.candidate[1][axis]);
      const std::int64_t spread = several ? (apart * static_cast<std::int64_t>(steps_.reciprocal[a] >> 15)) >> 13
                                          : (((v.gate * 16) >> steps_.fine_bits) * 5461) >> 16;
      scales[a].spread = static_cast<std::uint32_t>(std::min<std::int64_t>(spread, 1 << 21));
    }
    const std::uint32_t all = ((scales[0].around + scales[1].around + scales[2].around) * 5461u) >> 14;
    for (MixedScale& s : scales) {
      // 1.8 * (0.8 around + 0.2 all) + 0.4 spread, and a third of a step against zero.
      const std::uint32_t expected = 5 + ((s.around * 369 + all * 92 + (several ? s.spread * 102 : 0)) >> 8);
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
  /// How far a prediction has held for this vertex: nothing known, on no axis, on all, on some.
  static int matchClass(int axis, int matches) { return axis == 0 ? 0 : matches == 0 ? 1 : matches == axis ? 2 : 3; }

  ResidualEvidence evidenceOf(const MixedVertex& v, int a, const std::array<std::int32_t, 3>& residual) const {
    const auto axis = static_cast<std::size_t>(a);
    const MixedScale& scale = scales_[axis];
    const int count_class = std::min(v.stencil_count, 3) - 1;
    const int scale_and_count = scale.coarse * 3 + count_class;
    ResidualEvidence e;
    e.unit_shift = scale.unit_shift;
    const auto predict = [&](std::size_t k, std::int64_t local, int context, bool present) {
      e.prediction[k] = steps_.sixteenths(local - offset_[axis], a);
      e.prediction_context[k] = static_cast<std::uint8_t>(context);
      e.present[k] = present;
    };
    predict(0, centred_ ? v.mean[a] : fitted_[axis], scale_and_count, true);
    e.voters = std::min(v.stencil_count, 3);
    for (int j = 0; j < e.voters; ++j) {
      const auto k = static_cast<std::size_t>(j);
      predict(1 + k, v.candidate[k][a], scale.coarse * 4 + matchClass(a, matches_[k]), v.stencil_count > 1);
    }
    if (steps_.lattice) {
      for (std::size_t k = 0; k < 3; ++k) {
        predict(4 + k, v.neighbour[k][a], scale.coarse * 4 + matchClass(a, matches_[3 + k]), true);
      }
    }
    setContexts(v, a, residual, e);
    e.weight_set = {static_cast<std::uint8_t>(scale.fine),
                    static_cast<std::uint8_t>((a * 3 + count_class) * 4 + hits_)};
    return e;
  }

  void setContexts(const MixedVertex& v, int a, const std::array<std::int32_t, 3>& residual,
                   ResidualEvidence& e) const {
    const auto axis = static_cast<std::size_t>(a);
    const MixedScale& scale = scales_[axis];
    const std::uint32_t size = scale.around + 8;
    const auto coded = [&](int b) {
      const auto other = static_cast<std::size_t>(b);
      return b < a ? signedClass(16 * std::int64_t{residual[other]}, scales_[other].around + 4) : 0;
    };
    const auto surprise = [&](std::size_t k) { return signedClass(steps_.sixteenths(v.surprise[k][a], a), size); };
    const int spread_width = static_cast<int>(std::bit_width(scale.spread));
    const int spread =
        2 * spread_width + (spread_width > 1 ? static_cast<int>(scale.spread >> (spread_width - 2) & 1) : 0);
    const int contexts[kMixedContexts] = {
        (a * 7 + coded(0)) * 7 + coded(1),
        (surprise(0) * 7 + surprise(1)) * 7 + surprise(2),
        std::min(spread, 24) * 14 + scale.fine,
        std::min(v.valence, 12) * 14 + scale.fine,
    };
    for (std::size_t k = 0; k < kMixedContexts; ++k) e.context[k] = static_cast<std::uint16_t>(contexts[k]);
  }

  /// Which of the predictions came true on this axis, to half a step.
  void noteMatches(const MixedVertex& v, const ResidualEvidence& e, int a, std::int32_t residual) {
    bool any = false;
    const auto note = [&](std::size_t k) {
      const bool match = std::abs(e.prediction[1 + k] - 16 * std::int64_t{residual}) <= 8;
      matches_[k] += match;
      any |= match;
    };
    for (int j = 0; j < std::min(v.stencil_count, 3); ++j) note(static_cast<std::size_t>(j));
    if (steps_.lattice) {
      for (std::size_t k = 3; k < 6; ++k) note(k);
    }
    hits_ |= static_cast<std::uint32_t>(any) << a;
  }

  ResidualSteps steps_;
  bool centred_;
  ResidualMixer<Direction> mixer_;
  LeastSquares least_squares_[9][3];  ///< by count of stencils and valence; by component
  // Of the vertex at work:
  int feature_count_ = 0;
  int shape_class_ = 0;
  std::array<std::int64_t, 3> fitted_{};  ///< what least squares predict, local, from the predicted point
  std::array<std::int64_t, 3> offset_{};
  std::array<MixedScale, 3> scales_{};
  std::array<int, 6> matches_{};  ///< axes on which each of the candidates and neighbours' coordinates came true
  std::uint32_t hits_ = 0;        ///< axes on which any did, a bit each
};

}  // namespace tsc
