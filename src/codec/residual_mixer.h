// One residual as binary decisions, each predicted in many ways that a logistic mixer weighs (BITSTREAM.md,
// section 6.9.5).
//
// First the sign, then how many doublings of a unit the magnitude reaches, then its bits below. Each decision asks on
// which side of a boundary the residual lies, and there are two kinds of inputs: predicted residuals, each with a
// chance chosen by its distance from the boundary; and contexts, each with a chance for the decision as such.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "direction.h"
#include "logistic.h"

namespace tsc {

inline constexpr int kMixedPredictions = 7;
inline constexpr int kVoters = 3;  ///< predictions 1..3 vote, and 4..6
inline constexpr int kMixedContexts = 4;
inline constexpr int kPredictionContexts = 20;
inline constexpr int kContextValues = 352;
inline constexpr std::int32_t kPredictionLimit = 1 << 28;

/// What is known of a residual before it is coded.
struct ResidualEvidence {
  int unit_shift = 0;  ///< the unit is 2^unit_shift steps, 0..19
  /// Predicted residuals in sixteenths of a step, within +-kPredictionLimit; unused ones have `present` false.
  std::array<std::int32_t, kMixedPredictions> prediction{};
  std::array<std::uint8_t, kMixedPredictions> prediction_context{};  ///< below kPredictionContexts
  std::array<bool, kMixedPredictions> present{};
  int voters = 0;                                       ///< of predictions 1, 2, 3, those that vote: the first 0..3
  std::array<std::uint16_t, kMixedContexts> context{};  ///< below kContextValues
  std::array<std::uint8_t, 2> weight_set{};             ///< below 14; below 36
};

template <class Direction>
class ResidualMixer {
 public:
  /// `prediction_count`: only so many of the predictions are ever present.
  ResidualMixer(Direction direction, int prediction_count)
      : direction_(direction),
        prediction_count_(static_cast<std::size_t>(prediction_count)),
        by_distance_(std::size_t{kPredictionTables} * kNodes * kDistances),
        by_context_(std::size_t{kMixedContexts} * kContextValues * kNodes * 2),
        by_votes_(std::size_t{kVoteClasses} * kNodes) {
    std::fill(by_distance_.end() - kNodes * kDistances, by_distance_.end(), Chance{0, Chance::kInert});
  }

  /// Codes a residual in steps; only writing looks at `residual`, which lies within +-2^29.
  std::int32_t code(const ResidualEvidence& evidence, std::int32_t residual) {
    begin(evidence);
    const bool negative = !decide(kSignNode, 0, evidence.unit_shift, residual >= 0);
    std::int32_t magnitude = residual;
    if (negative) {
      // The negative side is the positive one seen in a mirror that takes -1 to 0.
      magnitude = -1 - residual;
      for (std::int32_t& p : prediction_) p = -16 - p;
      side_ = 1;
    }
    int doublings = 0;
    int bits = evidence.unit_shift;  // the magnitude is below 2^bits unless the next decision says otherwise
    for (; bits < kMostBits; ++bits, ++doublings) {
      const int node = kFirstDoubling + std::min(doublings, kDoublingNodes - 1);
      if (!decide(node, 1 << bits, evidence.unit_shift + std::max(doublings - 1, 0), magnitude >= 1 << bits)) break;
    }
    const std::int32_t coded = bits == kMostBits ? codeHuge(magnitude) : codeBelow(doublings, bits, magnitude);
    return negative ? -1 - coded : coded;
  }

 private:
  static constexpr int kMostBits = 24;
  static constexpr int kHugeBits = 29;
  static constexpr int kDoublingNodes = 10;
  static constexpr int kHalvingNodes = 8;  ///< classes of doublings that the first two bits below distinguish
  static constexpr int kLaterNodes = 13;
  static constexpr int kSignNode = 0;
  static constexpr int kFirstDoubling = 1;
  static constexpr int kFirstBit = kFirstDoubling + kDoublingNodes;
  static constexpr int kSecondBit = kFirstBit + kHalvingNodes;
  static constexpr int kLaterBits = kSecondBit + 2 * kHalvingNodes;
  static constexpr int kNodes = kLaterBits + kLaterNodes;
  static constexpr int kModelledBits = 1;  ///< bits below that are modelled even where no prediction lies near
  static constexpr int kDistances = 24;
  static constexpr int kVoteClasses = 10 * 8;
  static constexpr int kWeightNodes = 21;
  static constexpr int kPredictionTables = kMixedPredictions * kPredictionContexts + 1;

  void begin(const ResidualEvidence& e) {
    evidence_ = &e;
    std::copy(e.prediction.begin(), e.prediction.end(), prediction_.begin());
    side_ = 0;
    for (std::size_t k = 0; k < prediction_count_; ++k) {
      // A prediction that is not there has the last table, which is inert.
      const std::size_t table =
          e.present[k] ? k * kPredictionContexts + e.prediction_context[k] : kPredictionTables - 1;
      distance_chances_[k] = &by_distance_[table * kNodes * kDistances];
      present_[k] = e.present[k];
    }
    for (std::size_t k = 0; k < kMixedContexts; ++k) {
      context_chances_[k] = &by_context_[(k * kContextValues + e.context[k]) * kNodes * 2];
    }
  }

  /// Magnitudes of 2^24 steps and more, which no real mesh has.
  std::int32_t codeHuge(std::int32_t magnitude) {
    const auto beyond = static_cast<std::uint32_t>(magnitude - (1 << (kMostBits - 1)));
    return static_cast<std::int32_t>(direction_.raw(beyond, kHugeBits)) + (1 << (kMostBits - 1));
  }

  /// The bits below the highest one, or below the unit.
  std::int32_t codeBelow(int doublings, int bits, std::int32_t magnitude) {
    std::int32_t low = doublings == 0 ? 0 : 1 << (bits - 1);
    int width = doublings == 0 ? bits : bits - 1;  // the magnitude lies in [low, low + 2^width)
    int first = 0;
    for (int depth = 0; width > 0; ++depth) {
      if (depth >= kModelledBits && !holdsPrediction(low, width)) {
        const auto rest = static_cast<std::uint32_t>(magnitude - low) & ((1u << width) - 1);
        return low + static_cast<std::int32_t>(direction_.raw(rest, width));
      }
      --width;
      const int doubling = std::min(doublings, kHalvingNodes - 1);
      const int node = depth == 0   ? kFirstBit + doubling
                       : depth == 1 ? kSecondBit + 2 * doubling + first
                                    : kLaterBits + std::min(width, kLaterNodes - 1);
      const std::int32_t middle = low + (1 << width);
      const bool upper = decide(node, middle, width, magnitude >= middle);
      if (upper) low = middle;
      if (depth == 0) first = upper;
    }
    return low;
  }

  bool holdsPrediction(std::int32_t low, int width) const {
    for (std::size_t k = 0; k < kMixedPredictions; ++k) {
      if (evidence_->present[k] && (((prediction_[k] + 8) >> 4) - low) >> width == 0) return true;
    }
    return false;
  }

  /// For four predictions: half octaves of their distances in sixteenths from an edge, against a scale of 2^shift
  /// steps, with the side that each lies on.
  static Integers distanceClasses(Integers prediction, std::int32_t edge, int shift) {
    constexpr int kSides = kDistances / 2;
    const Integers distance = prediction - edge;
    const Integers sign = distance >> 31;
    Integers classes = halfOctaves(((distance ^ sign) - sign) >> (shift + 1));
    const Integers excess = classes - (kSides - 1);
    classes -= excess & ~(excess >> 31);
    return classes + (~sign & kSides);
  }

  /// Chances for whether the magnitude is at least `boundary`, and their stretched values.
  TSC_ALWAYS_INLINE void gather(int node, std::int32_t boundary, int shift) {
    const std::int32_t edge = boundary * 16 - 8;
    alignas(16) std::array<std::int32_t, 8> distance;
    storeIntegers(&distance[0], distanceClasses(loadIntegers(&prediction_[0]), edge, shift));
    storeIntegers(&distance[4], distanceClasses(loadIntegers(&prediction_[4]), edge, shift));
    int votes[3] = {0, 0, 0};  // of prediction 0, of 1 to 3, of 4 to 6
    for (std::size_t k = 0; k < prediction_count_; ++k) {
      take(k, distance_chances_[k] + node * kDistances + distance[k]);
      votes[(k + 2) / 3] += (distance[k] >= kDistances / 2) & present_[k];
    }
    const int voters = evidence_->voters;
    const int vote = (voters * (voters + 1) / 2 + votes[1]) * 8 + votes[2] * 2 + votes[0];
    take(kVoteInput, &by_votes_[static_cast<std::size_t>(vote * kNodes + node)]);
#pragma GCC unroll 4
    for (std::size_t k = 0; k < kMixedContexts; ++k) {
      take(kVoteInput + 1 + k, context_chances_[k] + node * 2 + side_);
    }
  }
  void take(std::size_t input, Chance* chance) {
    chance_[input] = chance;
    inputs_[input] = static_cast<std::int16_t>(chance->stretched());
  }

  bool decide(int node, std::int32_t boundary, int shift, bool value) {
    gather(node, boundary, shift);
    const int weight_node = std::min(node, kWeightNodes - 1);
    MixerWeights& first = by_scale_[weight_node][evidence_->weight_set[0]];
    MixerWeights& second = by_hits_[weight_node][evidence_->weight_set[1]];
    FinalWeights& last = final_[node];
    const int first_stretched = first.mix(inputs_);
    const int second_stretched = second.mix(inputs_);
    const int probability = squash(last.mix(first_stretched, second_stretched));
    value = direction_.chance(static_cast<std::uint32_t>(std::clamp(probability >> 1, 1, 32767)), value);
    const int target = value ? 65535 : 0;
    last.learn(first_stretched, second_stretched, target - probability);
    first.learn(inputs_, target - squash(first_stretched));
    second.learn(inputs_, target - squash(second_stretched));
    for (std::size_t i = 0; i < prediction_count_; ++i) chance_[i]->update(value);
#pragma GCC unroll 5
    for (std::size_t i = kVoteInput; i < kChances; ++i) chance_[i]->update(value);
    return value;
  }

  static constexpr std::size_t kVoteInput = kMixedPredictions;
  static constexpr std::size_t kChances = kVoteInput + 1 + kMixedContexts;
  static_assert(kChances < kMixerInputs);

  Direction direction_;
  std::size_t prediction_count_;
  std::vector<Chance> by_distance_;  ///< [prediction][its context][node][distance]
  std::vector<Chance> by_context_;   ///< [context][its value][node][side]
  std::vector<Chance> by_votes_;     ///< [votes][node]
  MixerWeights by_scale_[kWeightNodes][14];
  MixerWeights by_hits_[kWeightNodes][36];
  FinalWeights final_[kNodes];
  // Of the residual and the decision at work:
  const ResidualEvidence* evidence_ = nullptr;
  alignas(16) std::array<std::int32_t, 8> prediction_{};  ///< mirrored on the negative side
  int side_ = 0;
  std::array<int, kMixedPredictions> present_{};
  std::array<Chance*, kMixedPredictions> distance_chances_{};
  std::array<Chance*, kMixedContexts> context_chances_{};
  std::array<Chance*, kChances> chance_{};
  /// 0 where there is none.
  alignas(16) MixerInputs inputs_ = [] {
    MixerInputs inputs{};
    inputs.back() = 256;  // always the same, for what all others leave out
    return inputs;
  }();
};

}  // namespace tsc
