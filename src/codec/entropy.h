// The entropy coder: one range asymmetric numeral system (rANS, Duda 2013) for the whole stream.
//
// The state is 64 bits, renormalised by 32-bit words, and probabilities are multiples of 2^-15 (BITSTREAM.md,
// section 3). rANS decodes in the reverse order of encoding: the writer keeps the symbols and codes them last to first
// when it finishes. Its initial state carries the checksum, so the state that remains after decoding must equal it:
// stream consumed exactly and output intact are one test.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace tsc {

inline constexpr int kProbabilityBits = 15;
inline constexpr std::uint32_t kProbabilityOne = 1u << kProbabilityBits;
inline constexpr std::uint64_t kCoderStateMin = std::uint64_t{1} << 32;

/// log2 of a positive number to 5 digits, the same on every machine, which the C library's is not: the encoder's
/// choices, and so its bytes, hang on it.
double approximateLog2(double value);

class EntropyWriter {
 public:
  /// A symbol that owns [start, start + frequency) of [0, 2^15). 0 < frequency < 2^15.
  void put(std::uint32_t start, std::uint32_t frequency) { symbols_.push_back(start << 16 | frequency); }

  /// `count` equiprobable bits, at most 32, low bits last.
  void putRaw(std::uint32_t value, int count) {
    for (; count > 0; count -= kRawChunkBits) {
      const int chunk = count < kRawChunkBits ? count : kRawChunkBits;
      const std::uint32_t part = value & ((1u << chunk) - 1);
      put(part << (kProbabilityBits - chunk), 1u << (kProbabilityBits - chunk));
      value >>= chunk % 32;
    }
  }

  /// Puts all symbols of another writer.
  void append(const EntropyWriter& other) {
    symbols_.insert(symbols_.end(), other.symbols_.begin(), other.symbols_.end());
  }

  /// Where writing stands, for `bitsSince`.
  std::size_t mark() const { return symbols_.size(); }
  /// Cost in bits of what was put since `mark`.
  double bitsSince(std::size_t mark) const;

  /// Appends the payload to `bytes`. `checksum` becomes the decoder's final state.
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
  std::uint32_t peek() const { return static_cast<std::uint32_t>(state_) & (kProbabilityOne - 1); }

  /// Consumes the symbol that owns [start, start + frequency), which must contain `peek()`.
  void advance(std::uint32_t start, std::uint32_t frequency) {
    state_ = frequency * (state_ >> kProbabilityBits) + peek() - start;
    if (state_ < kCoderStateMin) [[unlikely]]
      refill();
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

  bool overrun() const { return overrun_; }
  /// True when every word has been read. The final state is then kCoderStateMin + checksum.
  bool atEnd() const { return next_ == end_ && !overrun_; }
  std::uint64_t state() const { return state_; }
  /// Bytes of the payload read so far.
  std::size_t position() const { return static_cast<std::size_t>(next_ - begin_); }
  /// Bytes of the payload not read yet.
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - next_); }

 private:
  void refill() {
    std::uint32_t word = 0;
    if (end_ - next_ >= 4) {
      word = static_cast<std::uint32_t>(next_[0]) | static_cast<std::uint32_t>(next_[1]) << 8 |
             static_cast<std::uint32_t>(next_[2]) << 16 | static_cast<std::uint32_t>(next_[3]) << 24;
      next_ += 4;
    } else {
      overrun_ = true;
    }
    state_ = state_ << 32 | word;
  }

  const std::byte* begin_;
  const std::byte* next_;
  const std::byte* end_;
  std::uint64_t state_ = 0;
  bool overrun_ = false;
};

}  // namespace tsc
