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
#include <vector>

#include "direction.h"
#include "logistic.h"

namespace tsc {

inline constexpr int kMixedPredictions = 7;
inline constexpr int kMixedContexts = 4;
inline constexpr int kPredictionContexts = 20;
inline constexpr int kContextValues = 352;
inline constexpr std::int32_t kPredictionLimit = 1 << 28;

/// What is known of a residual before it is coded. Lanes 0..3 of the first and 0..2 of the second part are predictions
/// 0..6.
struct ResidualEvidence {
  int unit_shift = 0;                            ///< the unit is 2^unit_shift steps, 0..19
  std::array<Integers, 2> prediction{};          ///< residuals in sixteenths of a step, within +-kPredictionLimit
  std::array<Integers, 2> prediction_context{};  ///< below kPredictionContexts
  Integers present{};                            ///< of predictions 0..3, all bits where there is one
  int voters = 0;                                ///< of predictions 1, 2, 3, those that vote: the first 1..3
  Integers context{};                            ///< below kContextValues
  std::array<std::uint8_t, 2> weight_set{};      ///< below 14; below 36
};

template <class Direction>
class ResidualMixer {
 public:
  /// `lattice`: whether there are predictions 4..6 in all evidence, or in none.
  ResidualMixer(Direction direction, bool lattice)
      : direction_(direction), lattice_(lattice), chances_(kChances, chances::kUnknown) {}

  /// Codes a residual in steps; only writing looks at `residual`, which lies within +-2^29.
  std::int32_t code(const ResidualEvidence& evidence, std::int32_t residual) {
    return lattice_ ? code<true>(evidence, residual) : code<false>(evidence, residual);
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
  using Weights = LaneWeights<16, 2000, 3000, 1500>;
  // Chances stand in one table: [prediction][its context][node][distance], [votes][node], [context][value][node][side],
  // and last those of predictions that are not there.
  static constexpr int kVoteChances = kMixedPredictions * kPredictionContexts * kNodes * kDistances;
  static constexpr int kContextChances = kVoteChances + kVoteClasses * kNodes;
  static constexpr int kUnusedChances = kContextChances + kMixedContexts * kContextValues * kNodes * 2;
  static constexpr std::size_t kChances = kUnusedChances + kNodes * kDistances;

  template <bool kLattice>
  std::int32_t code(const ResidualEvidence& evidence, std::int32_t residual) {
    begin(evidence);
    const bool negative = !decide<kLattice>(kSignNode, 0, evidence.unit_shift, residual >= 0);
    // The negative side is the positive one seen in a mirror that takes -1 to 0.
    std::int32_t magnitude = negative ? -1 - residual : residual;
    const Integers mirror = splatInteger(-static_cast<std::int32_t>(negative));
    for (Integers& p : prediction_) p = (p ^ mirror) - (mirror & 15);
    side_ = negative;
    int doublings = 0;
    int bits = evidence.unit_shift;  // the magnitude is below 2^bits unless the next decision says otherwise
    for (; bits < kMostBits; ++bits, ++doublings) {
      const int node = kFirstDoubling + std::min(doublings, kDoublingNodes - 1);
      const int shift = evidence.unit_shift + std::max(doublings - 1, 0);
      if (!decide<kLattice>(node, 1 << bits, shift, magnitude >= 1 << bits)) break;
    }
    const std::int32_t coded =
        bits == kMostBits ? codeHuge(magnitude) : codeBelow<kLattice>(doublings, bits, magnitude);
    return negative ? -1 - coded : coded;
  }

  void begin(const ResidualEvidence& e) {
    constexpr int kOfPrediction = kNodes * kDistances, kOfContext = kNodes * 2;
    weight_set_ = e.weight_set;
    prediction_ = e.prediction;
    present_ = e.present;
    side_ = 0;
    const Integers first = (e.prediction_context[0] + Integers{0, 1, 2, 3} * kPredictionContexts) * kOfPrediction;
    chance_[0] = (first & present_) | (splatInteger(kUnusedChances) & ~present_);
    chance_[1] = (e.prediction_context[1] + Integers{4, 5, 6, 0} * kPredictionContexts) * kOfPrediction;
    chance_[1][3] = kVoteChances + e.voters * (e.voters + 1) / 2 * 8 * kNodes;
    chance_[2] = (e.context + Integers{0, 1, 2, 3} * kContextValues) * kOfContext + kContextChances;
  }

  /// Magnitudes of 2^24 steps and more, which no real mesh has.
  std::int32_t codeHuge(std::int32_t magnitude) {
    const auto beyond = static_cast<std::uint32_t>(magnitude - (1 << (kMostBits - 1)));
    return static_cast<std::int32_t>(direction_.raw(beyond, kHugeBits)) + (1 << (kMostBits - 1));
  }

  /// The bits below the highest one, or below the unit.
  template <bool kLattice>
  std::int32_t codeBelow(int doublings, int bits, std::int32_t magnitude) {
    std::int32_t low = doublings == 0 ? 0 : 1 << (bits - 1);
    int width = doublings == 0 ? bits : bits - 1;  // the magnitude lies in [low, low + 2^width)
    int first = 0;
    for (int depth = 0; width > 0; ++depth) {
      if (depth >= kModelledBits && !holdsPrediction<kLattice>(low, width)) {
        const auto rest = static_cast<std::uint32_t>(magnitude - low) & ((1u << width) - 1);
        return low + static_cast<std::int32_t>(direction_.raw(rest, width));
      }
      --width;
      const int doubling = std::min(doublings, kHalvingNodes - 1);
      const int node = depth == 0   ? kFirstBit + doubling
                       : depth == 1 ? kSecondBit + 2 * doubling + first
                                    : kLaterBits + std::min(width, kLaterNodes - 1);
      const std::int32_t middle = low + (1 << width);
      const bool upper = decide<kLattice>(node, middle, width, magnitude >= middle);
      if (upper) low = middle;
      if (depth == 0) first = upper;
    }
    return low;
  }

  template <bool kLattice>
  bool holdsPrediction(std::int32_t low, int width) const {
    const auto held = [&](Integers p) { return (Integers)(((((p + 8) >> 4) - low) >> width) == 0); };
    Integers any = held(prediction_[0]) & present_;
    if constexpr (kLattice) any |= held(prediction_[1]) & kThree;
    return !isZero(any);
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

  /// Whether the magnitude is at least `boundary`.
  template <bool kLattice>
  [[gnu::noinline]] bool decide(int node, std::int32_t boundary, int shift, bool value) {
    constexpr int kParts = kLattice ? 3 : 2;
    const std::array<std::int32_t, 4 * kParts> at = placesOf<kLattice>(node, boundary * 16 - 8, shift);
    std::array<Integers, kParts> chance;
    for (std::size_t i = 0; i < kParts; ++i) {
      chance[i] = Integers{chances_[place(at[4 * i])], chances_[place(at[4 * i + 1])], chances_[place(at[4 * i + 2])],
                           chances_[place(at[4 * i + 3])]};
    }
    std::array<Lanes, kParts - 1> inputs;
    inputs[0] = packed(chances::stretched(chance[0]) & present_, chances::stretched(chance[1]));
    if constexpr (kLattice) inputs[1] = packed(chances::stretched(chance[2]), Integers{kBias, 0, 0, 0});

    const int weight_node = std::min(node, kWeightNodes - 1);
    Weights& first = by_scale_[weight_node][weight_set_[0]];
    Weights& second = by_hits_[weight_node][weight_set_[1]];
    std::int32_t sum = 0;  // 16 products below 2^12 * 2^15
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      sum += dotProduct(saturatedSum(first.part(i), second.part(i)), inputs[i]);
    }
    const int probability = mixedProbability(sum);
    value = direction_.chance(static_cast<std::uint32_t>(std::clamp(probability >> 1, 1, 32767)), value);

    const int came = -static_cast<int>(value) & 65535;
    const Lanes first_step = first.step(came - probability), second_step = second.step(came - probability);
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      first.learn(i, inputs[i], first_step);
      second.learn(i, inputs[i], second_step);
    }
    for (std::size_t i = 0; i < kParts; ++i) {
      const Integers updated = chances::updated(chance[i], splatInteger(came));
      for (std::size_t k = 0; k < 4; ++k) chances_[place(at[4 * i + k])] = updated[static_cast<int>(k)];
    }
    return value;
  }

  static std::size_t place(std::int32_t at) { return static_cast<std::size_t>(static_cast<std::uint32_t>(at)); }

  /// Where the chances of a decision stand: those of predictions 0..3; in lattice mode 4..6 and the votes'; contexts'.
  template <bool kLattice>
  TSC_ALWAYS_INLINE auto placesOf(int node, std::int32_t edge, int shift) const {
    constexpr int kParts = kLattice ? 3 : 2;
    std::array<std::int32_t, 4 * kParts> at;
    const Integers distance = distanceClasses(prediction_[0], edge, shift);
    storeIntegers(&at[0], chance_[0] + distance + node * kDistances);
    if constexpr (kLattice) {
      const Integers others = distanceClasses(prediction_[1], edge, shift);
      const auto beyond = [](Integers d) { return (Integers)(d >= kDistances / 2); };
      const unsigned votes = signBits(beyond(distance) & present_) | signBits(beyond(others) & kThree) << 4;
      Integers places = chance_[1] + others + node * kDistances;
      storeIntegers(&at[4], places);
      at[7] = chance_[1][3] + kVotes[votes] * kNodes + node;
    }
    storeIntegers(&at[4 * (kParts - 1)], chance_[2] + (node * 2 + side_));
    return at;
  }

  /// By the predictions that lie beyond the boundary, a bit each: how many of 1..3, of 4..6, and whether 0 does.
  static constexpr std::array<std::uint8_t, 128> kVotes = [] {
    std::array<std::uint8_t, 128> votes{};
    for (unsigned i = 0; i < 128; ++i) {
      votes[i] = static_cast<std::uint8_t>(std::popcount(i >> 1 & 7) * 8 + std::popcount(i >> 4) * 2 + (i & 1));
    }
    return votes;
  }();
  static constexpr Integers kThree = {-1, -1, -1, 0};
  static constexpr std::int32_t kBias = 256;  ///< an input that is always the same, for what all others leave out

  Direction direction_;
  bool lattice_;
  std::vector<std::int32_t> chances_;
  Weights by_scale_[kWeightNodes][14];
  Weights by_hits_[kWeightNodes][36];
  // Of the residual at work:
  std::array<std::uint8_t, 2> weight_set_{};
  std::array<Integers, 2> prediction_{};  ///< mirrored on the negative side
  Integers present_{};
  std::array<Integers, 3> chance_{};  ///< where the chances of node 0 begin
  int side_ = 0;
};

}  // namespace tsc
