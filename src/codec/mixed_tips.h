// Symbols of tips at effort max: binary decisions, each predicted by what came in several contexts and by the last
// repetition, mixed by weights that learn (BITSTREAM.md, section 5.7).
//
// Degree 6 is decided first, then whether the degree is lower, then degree after degree away from 6. Each context has a
// few chances, one for each decision, that lie together: the first four, which are most of what is used, in a slot of
// one table, the rest in a slot of another, smaller one. Slots are chosen by a hash; two contexts with the same hash
// share one. Tables follow the size of the mesh.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "front.h"
#include "gate.h"
#include "lanes.h"
#include "logistic.h"
#include "tip_contexts.h"
#include "tips.h"

namespace tsc {

/// What followed when the last eight symbols came before.
class Repetition {
 public:
  explicit Repetition(int bits) : shift_(32 - bits), positions_(std::size_t{1} << bits) {}

  /// 0 if nothing is expected; else one more than the number of expectations in a row that came true.
  std::uint32_t length() const { return length_; }
  std::uint32_t expected() const { return symbols_[source_]; }

  void note(std::uint32_t symbol) {
    length_ = length_ > 0 && expected() == symbol ? length_ + 1 : 0;
    ++source_;
    symbols_.push_back(static_cast<std::uint8_t>(symbol));
    last_eight_ = last_eight_ << 4 | symbol;
    std::uint32_t& position = positions_[(last_eight_ * 0x9e3779b1u) >> shift_];
    if (length_ == 0 && position > 0) {
      source_ = position;
      length_ = 1;
    }
    position = static_cast<std::uint32_t>(symbols_.size());
  }

 private:
  int shift_;
  std::vector<std::uint32_t> positions_;  ///< by hash of eight symbols: that of the symbol after them; 0 for none
  std::vector<std::uint8_t> symbols_;
  std::uint32_t last_eight_ = 0;
  std::uint32_t source_ = 0;  ///< position of what is expected
  std::uint32_t length_ = 0;
};

class MixedTips {
 public:
  explicit MixedTips(std::uint32_t vertex_count)
      : bits_(std::clamp(static_cast<int>(std::bit_width(vertex_count)), kMinTableBits, kMaxTableBits)),
        rare_bits_(std::min(bits_, kMaxRareTableBits)),
        slots_(kTipContexts << bits_),
        rare_slots_(kTipContexts << rare_bits_),
        repetition_(bits_) {
    std::fill_n(&by_length_[0][0][0], kDecisions * kLengths * 2, chances::kUnknown);
  }

  /// Codes a symbol, which only a writing direction looks at.
  template <class Direction>
  std::uint32_t code(Direction& direction, const Front& front, const Gate& gate, std::uint32_t symbol) {
    begin(tipContextsOf(front, gate));
    const std::uint32_t coded = decideSymbol(direction, symbol);
    repetition_.note(coded);
    return coded;
  }

 private:
  static constexpr int kMinTableBits = 6;
  static constexpr int kMaxTableBits = 14;
  static constexpr int kMaxRareTableBits = 10;

  static constexpr std::uint32_t kSymbolDegree6 = 6 - kFirstDegree;
  /// Symbols of degrees below 6, and all others; of each the first two are the likeliest.
  static constexpr std::array<std::uint8_t, 4> kBelow = {2, 1, 0, kSymbolDegree2};
  static constexpr std::array<std::uint8_t, 11> kAbove = {4,  5,  kSymbolSplit, 6, 7, 8, 9, kSymbolEscape,
                                                          10, 11, kSymbolDummy};
  // Decisions.
  static constexpr std::size_t kDegree6 = 0;
  static constexpr std::size_t kIsBelow = 1;
  static constexpr std::size_t kFirstBelow = 2;  ///< degree 5 or not
  static constexpr std::size_t kFirstAbove = 3;  ///< degree 7 or not
  static constexpr std::size_t kSlotSize = 4;
  static constexpr std::size_t kLaterBelow = kSlotSize;
  static constexpr std::size_t kLaterAbove = kLaterBelow + kBelow.size() - 2;
  static constexpr std::size_t kDecisions = kLaterAbove + kAbove.size() - 2;
  static constexpr std::uint32_t kLengths = 32;
  static constexpr std::int32_t kBias = 400;  ///< an input that is always the same

  struct alignas(16) Slot {
    std::array<std::int32_t, kSlotSize> chance = filled<kSlotSize>();
  };
  struct RareSlot {
    std::array<std::int32_t, kDecisions - kSlotSize> chance = filled<kDecisions - kSlotSize>();
  };
  using Weights = LaneWeights<8, 5500, 10000, 1500>;

  template <std::size_t kCount>
  static constexpr std::array<std::int32_t, kCount> filled() {
    std::array<std::int32_t, kCount> chances{};
    chances.fill(chances::kUnknown);
    return chances;
  }

  void begin(const std::array<std::uint32_t, kTipContexts>& contexts) {
    for (std::size_t k = 0; k < kTipContexts; ++k) {
      const std::uint32_t hash = contexts[k] * 0x9e3779b1u;
      slot_[k] = slots_[(k << bits_) + (hash >> (32 - bits_))].chance.data();
      rare_slot_[k] = rare_slots_[(k << rare_bits_) + (hash >> (32 - rare_bits_))].chance.data();
    }
    repeats_ = repetition_.length() > 0;
    expected_ = repeats_ ? repetition_.expected() : 0;
    length_ = std::min(repetition_.length(), kLengths);
  }

  template <class Direction>
  std::uint32_t decideSymbol(Direction& direction, std::uint32_t symbol) {
    if (decide(direction, kDegree6, expected_ == kSymbolDegree6, symbol == kSymbolDegree6)) return kSymbolDegree6;
    if (decide(direction, kIsBelow, isBelow(expected_), isBelow(symbol))) {
      return decideAmong(direction, kBelow, kFirstBelow, kLaterBelow, symbol);
    }
    return decideAmong(direction, kAbove, kFirstAbove, kLaterAbove, symbol);
  }

  /// One symbol after the other, each or those that follow.
  template <class Direction, std::size_t kCount>
  std::uint32_t decideAmong(Direction& direction, const std::array<std::uint8_t, kCount>& symbols, std::size_t first,
                            std::size_t later, std::uint32_t symbol) {
    if (decide(direction, first, expected_ == symbols[0], symbol == symbols[0])) return symbols[0];
    for (std::size_t i = 1; i + 1 < kCount; ++i) {
      if (decide(direction, later + i - 1, expected_ == symbols[i], symbol == symbols[i])) return symbols[i];
    }
    return symbols.back();
  }

  static bool isBelow(std::uint32_t symbol) { return symbol < kSymbolDegree6 || symbol == kSymbolDegree2; }

  /// `expected`: what the repetition says of this decision.
  template <class Direction>
  TSC_ALWAYS_INLINE bool decide(Direction& direction, std::size_t node, bool expected, bool value) {
    // Seven chances, and a lane that nobody reads.
    std::array<std::int32_t*, kTipContexts + 1> place;
    for (std::size_t k = 0; k < kTipContexts; ++k) {
      place[k] = node < kSlotSize ? slot_[k] + node : rare_slot_[k] + (node - kSlotSize);
    }
    place[kTipContexts] = repeats_ ? &by_length_[node][length_ - 1][expected] : &unread_;
    const Integers first = {*place[0], *place[1], *place[2], *place[3]};
    const Integers second = {*place[4], *place[5], *place[6], 0};
    const Integers known = {-1, -1, -static_cast<std::int32_t>(repeats_), 0};
    const Lanes inputs =
        packed(chances::stretched(first), (chances::stretched(second) & known) | Integers{0, 0, 0, kBias});

    Weights& weights = weights_[node];
    const int probability = mixedProbability(dotProduct(weights.part(0), inputs));  // 8 products below 2^12 * 2^15
    value = direction.chance(static_cast<std::uint32_t>(std::clamp(probability >> 1, 1, 32767)), value);

    const int came = -static_cast<int>(value) & 65535;
    weights.learn(0, inputs, weights.step(came - probability));
    const Integers first_updated = chances::updated(first, splatInteger(came));
    const Integers second_updated = chances::updated(second, splatInteger(came));
    for (int k = 0; k < 4; ++k) *place[k] = first_updated[k];
    for (int k = 0; k < 3; ++k) *place[4 + k] = second_updated[k];
    repeats_ &= expected == value;
    return value;
  }

  int bits_;
  int rare_bits_;
  std::vector<Slot> slots_;           ///< [context][hash]
  std::vector<RareSlot> rare_slots_;  ///< [context][hash]
  Repetition repetition_;
  std::int32_t by_length_[kDecisions][kLengths][2];
  std::int32_t unread_ = chances::kUnknown;  ///< stands for the repetition's chance where nothing is expected
  Weights weights_[kDecisions];
  // Of the symbol at work:
  std::array<std::int32_t*, kTipContexts> slot_{};
  std::array<std::int32_t*, kTipContexts> rare_slot_{};
  bool repeats_ = false;  ///< something is expected, and no decision has shown that it is not what comes
  std::uint32_t expected_ = 0;
  std::uint32_t length_ = 0;
};

}  // namespace tsc
