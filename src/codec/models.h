// Adaptive models: what turns symbols into probabilities (BITSTREAM.md, section 4).
//
// A model is a cumulative table that moves towards each symbol it codes. Both sides do the same integer arithmetic;
// the vectors below are GCC/Clang vector extensions, which every target of these compilers has, and lane by lane they
// are plain 16-bit integers.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "entropy.h"

namespace tsc {

/// Adaptive distribution over 16 symbols.
///
/// Lane s > 0 is the cumulative frequency below symbol s. Lane 0, which would always be 0, holds the number of updates
/// so far, capped: the adaptation starts fast and slows down with it. Every frequency stays at least 1: see `update`.
class SymbolModel {
 public:
  using Lanes [[gnu::vector_size(32)]] = std::int16_t;

  SymbolModel() {
    for (int s = 0; s < 16; ++s) lanes_[s] = static_cast<std::int16_t>(s * (kProbabilityOne / 16));
  }

  void put(EntropyWriter& writer, std::uint32_t symbol) {
    const std::uint32_t start = below(symbol);
    writer.put(start, below(symbol + 1) - start);
    update(symbol);
  }

  std::uint32_t get(EntropyReader& reader) {
    const std::uint32_t symbol = find(reader.peek());
    const std::uint32_t start = below(symbol);
    reader.advance(start, below(symbol + 1) - start);
    update(symbol);
    return symbol;
  }

  /// Cumulative frequency below `symbol`, 0..16.
  std::uint32_t below(std::uint32_t symbol) const {
    if (symbol == 0) return 0;
    return symbol == 16 ? kProbabilityOne : static_cast<std::uint32_t>(static_cast<std::uint16_t>(lanes_[symbol]));
  }

  /// The symbol that owns `slot`.
  std::uint32_t find(std::uint32_t slot) const {
    std::uint32_t symbol = 0;
    for (int s = 1; s < 16; ++s) symbol += static_cast<std::uint16_t>(lanes_[s]) <= slot;
    return symbol;
  }

  /// Moves each lane by 2^-rate of the way to the target of `symbol`, a cumulative table in which every symbol has
  /// frequency 1 and `symbol` the rest. Two neighbouring lanes at distance d >= 1, targets at distance e >= 1, end at
  /// distance >= d + floor((e - d) / 2^rate) >= 1, so no frequency reaches 0.
  void update(std::uint32_t symbol) {
    const int count = lanes_[0];
    const int rate = kFirstRate + (count >= 4) + (count >= 12) + (count >= 32);
    for (int s = 1; s < 16; ++s) {
      const int target = s + (static_cast<std::uint32_t>(s) > symbol ? static_cast<int>(kProbabilityOne) - 16 : 0);
      lanes_[s] = static_cast<std::int16_t>(lanes_[s] + ((target - lanes_[s]) >> rate));
    }
    lanes_[0] = static_cast<std::int16_t>(count < kCountCap ? count + 1 : count);
  }

  static constexpr int kFirstRate = 3;
  static constexpr int kCountCap = 32;

 private:
  Lanes lanes_ = {};
};

/// Adaptive probability of a bit.
class BitModel {
 public:
  void put(EntropyWriter& writer, bool bit) {
    writer.put(bit ? 0 : probability_, bit ? probability_ : kProbabilityOne - probability_);
    update(bit);
  }

  bool get(EntropyReader& reader) {
    const bool bit = reader.peek() < probability_;
    reader.advance(bit ? 0 : probability_, bit ? probability_ : kProbabilityOne - probability_);
    update(bit);
    return bit;
  }

 private:
  // The probability stays within [31, 2^15 - 31]: a step of 2^-5 vanishes below a distance of 32 from either end.
  void update(bool bit) {
    const int rate = count_ < 4 ? 2 + count_ / 2 : count_ < 16 ? 4 : 5;
    if (count_ < 16) ++count_;
    const int target = bit ? static_cast<int>(kProbabilityOne) - 31 : 31;
    probability_ = static_cast<std::uint16_t>(probability_ + ((target - probability_) >> rate));
  }

  std::uint16_t probability_ = kProbabilityOne / 2;  ///< of bit 1
  std::uint8_t count_ = 0;
};

/// Adaptive probability of a bit that may be impossible, coded without a branch on what cannot be foreseen.
class HitModel {
 public:
  /// Times 2^-15; 0 where a 1 is not possible. A 0 then owns all of the range, and coding it changes no state.
  std::uint32_t one(bool possible) const { return probability_ & mask(possible); }

  /// Learns only where a 1 was possible. The probability stays within [31, 2^15 - 31]: a step of 2^-5 vanishes below a
  /// distance of 32 from either end.
  void update(bool bit, bool possible) {
    const std::int32_t target =
        31 + (static_cast<std::int32_t>(kProbabilityOne - 62) & -static_cast<std::int32_t>(bit));
    const std::int32_t step = (target - probability_) >> 5;
    probability_ = static_cast<std::uint16_t>(probability_ + (step & static_cast<std::int32_t>(mask(possible))));
  }

 private:
  static std::uint32_t mask(bool possible) { return 0 - static_cast<std::uint32_t>(possible); }

  std::uint16_t probability_ = kProbabilityOne / 2;
};

/// Adaptive unsigned integer below 2^30: its bit length by model, its bits below the leading one raw but for the first.
class IntegerModel {
 public:
  void put(EntropyWriter& writer, std::uint32_t value) {
    const auto length = static_cast<std::uint32_t>(std::bit_width(value));
    length_.put(writer, length < 15 ? length : 15);
    if (length >= 15) long_length_.put(writer, length - 15);
    if (length < 2) return;
    const int rest = static_cast<int>(length) - 2;
    second_bit_[length].put(writer, (value >> rest & 1) != 0);
    writer.putRaw(value & ((1u << rest) - 1), rest);
  }

  std::uint32_t get(EntropyReader& reader) {
    std::uint32_t length = length_.get(reader);
    if (length == 15) length += long_length_.get(reader);
    if (length < 2) return length;
    const int rest = static_cast<int>(length) - 2;
    const std::uint32_t second = second_bit_[length].get(reader) ? 1 : 0;
    return (2u + second) << rest | reader.getRaw(rest);
  }

 private:
  SymbolModel length_;
  SymbolModel long_length_;
  std::array<BitModel, 31> second_bit_;
};

/// Signed integers as unsigned ones: 0, -1, 1, -2, ...
inline std::uint32_t zigzag(std::int32_t value) {
  return (static_cast<std::uint32_t>(value) << 1) ^ static_cast<std::uint32_t>(value >> 31);
}
inline std::int32_t unzigzag(std::uint32_t value) {
  return static_cast<std::int32_t>(value >> 1) ^ -static_cast<std::int32_t>(value & 1);
}

}  // namespace tsc
