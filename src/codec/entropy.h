// The entropy coder: range asymmetric numeral systems (rANS, Duda 2013), three interleaved in one sequence of words
// (Giesen 2014), so that three symbols whose models are known can be decoded at a time.
//
// States are 32 bits, renormalised by 16-bit words, and probabilities are multiples of 2^-15 (BITSTREAM.md, section 3).
// Every symbol names the lane whose state codes it. rANS decodes in the reverse order of encoding: the writer keeps the
// symbols and codes them last to first when it finishes. Its initial states carry the checksum, so the states that
// remain after decoding must equal them: stream consumed exactly and output intact are one test.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace tsc {

inline constexpr int kProbabilityBits = 15;
inline constexpr std::uint32_t kProbabilityOne = 1u << kProbabilityBits;
inline constexpr std::uint32_t kCoderStateMin = 1u << 16;
inline constexpr int kCoderLanes = 3;

/// The states that are left when a stream with this checksum has been decoded.
inline std::array<std::uint32_t, kCoderLanes> finalStates(std::uint32_t checksum) {
  return {kCoderStateMin + (checksum & 0xffff), kCoderStateMin + (checksum >> 16), kCoderStateMin};
}

/// log2 of a positive normal number to 5 digits, the same on every machine, which the C library's is not: the encoder's
/// choices, and so its bytes, hang on it.
double approximateLog2(double value);

class EntropyWriter {
 public:
  /// A symbol that owns [start, start + frequency) of [0, 2^15). 0 < frequency < 2^15.
  template <int kLane = 0>
  void put(std::uint32_t start, std::uint32_t frequency) {
    symbols_.push_back(start << 17 | std::uint32_t{kLane} << 15 | frequency);
  }

  /// `count` equiprobable bits, at most 32, low bits last.
  void putRaw(std::uint32_t value, int count) {
    for (; count > 0; count -= kRawChunkBits) {
      const int chunk = count < kRawChunkBits ? count : kRawChunkBits;
      const std::uint32_t part = value & ((1u << chunk) - 1);
      put(part << (kProbabilityBits - chunk), 1u << (kProbabilityBits - chunk));
      value >>= chunk % 32;
    }
  }

  /// `count` equiprobable bits, at most 42, high bits first where they do not fit one symbol.
  void putLongRaw(std::uint64_t value, int count) {
    while (count > kRawChunkBits) {
      count -= kRawChunkBits;
      putRaw(static_cast<std::uint32_t>(value >> count) & ((1u << kRawChunkBits) - 1), kRawChunkBits);
    }
    if (count > 0) putRaw(static_cast<std::uint32_t>(value) & ((1u << count) - 1), count);
  }

  /// Puts all symbols of another writer.
  void append(const EntropyWriter& other) {
    symbols_.insert(symbols_.end(), other.symbols_.begin(), other.symbols_.end());
  }

  /// Where writing stands, for `bitsSince`.
  std::size_t mark() const { return symbols_.size(); }
  /// Cost in bits of what was put since `mark`.
  double bitsSince(std::size_t mark) const;

  /// Appends the payload to `bytes`.
  void finish(std::uint32_t checksum, std::vector<std::byte>& bytes) const;

  static constexpr int kRawChunkBits = 14;

 private:
  std::vector<std::uint32_t> symbols_;
};

class EntropyReader {
 public:
  /// Reads the payload, which ends where `payload` ends. May be hostile: past its end the reader supplies zeros and
  /// `overrun` becomes true; the caller checks it at least once in each loop whose length the stream controls.
  explicit EntropyReader(std::span<const std::byte> payload);

  /// The slot in [0, 2^15) that tells the next symbol.
  template <int kLane = 0>
  std::uint32_t peek() const {
    return state_[kLane] & (kProbabilityOne - 1);
  }

  /// Consumes the symbol that owns [start, start + frequency), which must contain `peek()`.
  template <int kLane = 0>
  void advance(std::uint32_t start, std::uint32_t frequency) {
    const std::uint32_t state = frequency * (state_[kLane] >> kProbabilityBits) + peek<kLane>() - start;
    const bool short_of_bits = state < kCoderStateMin;
    if (end_ - next_ < 2) [[unlikely]] {
      state_[kLane] = short_of_bits ? refilledAtEnd(state) : state;
      return;
    }
    // Without a branch, which could not be foreseen.
    const std::uint32_t mask = 0 - static_cast<std::uint32_t>(short_of_bits);
    state_[kLane] = state ^ ((state ^ (state << 16 | word())) & mask);
    next_ += mask & 2;
  }

  std::uint32_t getRaw(int count) {
    if (count <= EntropyWriter::kRawChunkBits) [[likely]] {
      // No bits: the slot range is all of it, and advancing changes nothing.
      const std::uint32_t value = peek() >> (kProbabilityBits - count);
      advance(value << (kProbabilityBits - count), 1u << (kProbabilityBits - count));
      return value;
    }
    std::uint32_t value = 0;
    for (int done = 0; done < count; done += EntropyWriter::kRawChunkBits) {
      const int chunk = count - done < EntropyWriter::kRawChunkBits ? count - done : EntropyWriter::kRawChunkBits;
      const std::uint32_t part = peek() >> (kProbabilityBits - chunk);
      advance(part << (kProbabilityBits - chunk), 1u << (kProbabilityBits - chunk));
      value |= part << done;
    }
    return value;
  }

  std::uint64_t getLongRaw(int count) {
    std::uint64_t value = 0;
    for (; count > EntropyWriter::kRawChunkBits; count -= EntropyWriter::kRawChunkBits) [[unlikely]] {
        value = value << EntropyWriter::kRawChunkBits | getRaw(EntropyWriter::kRawChunkBits);
      }
    return value << count | getRaw(count);
  }

  bool overrun() const { return overrun_; }
  /// True when every word has been read. The states are then those of `finalStates`.
  bool atEnd() const { return next_ == end_ && !overrun_; }
  const std::array<std::uint32_t, kCoderLanes>& states() const { return state_; }
  /// Bytes of the payload read so far.
  std::size_t position() const { return static_cast<std::size_t>(next_ - begin_); }
  /// Bytes of the payload not read yet.
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - next_); }

 private:
  /// The next word; two bytes must be there.
  std::uint32_t word() const {
    return static_cast<std::uint32_t>(next_[0]) | static_cast<std::uint32_t>(next_[1]) << 8;
  }

  std::uint32_t refilledAtEnd(std::uint32_t state) {
    overrun_ = true;
    return state << 16;
  }

  const std::byte* begin_;
  const std::byte* next_;
  const std::byte* end_;
  std::array<std::uint32_t, kCoderLanes> state_{};
  bool overrun_ = false;
};

}  // namespace tsc
