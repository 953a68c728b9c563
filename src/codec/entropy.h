// The entropy coder: a range asymmetric numeral system (rANS, Duda 2013) in one 64-bit state, renormalised by bytes.
//
// Probabilities are multiples of 2^-15, and the state has room for kGroupBits of symbols at their smallest: the three
// components of a vertex are one *group*, after which it is renormalised once (BITSTREAM.md, section 3). rANS decodes
// in the reverse order of encoding: the writer keeps the symbols and codes them last to first when it finishes. Its
// initial state carries the checksum, so the state that remains after decoding must equal it: stream consumed exactly
// and output intact are one test.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace tsc {

inline constexpr int kProbabilityBits = 15;
inline constexpr std::uint32_t kProbabilityOne = 1u << kProbabilityBits;
inline constexpr int kGroupBits = 56;
inline constexpr std::uint64_t kCoderStateMin = std::uint64_t{1} << kGroupBits;

/// The state that is left when a stream with this checksum has been decoded.
inline std::uint64_t finalState(std::uint32_t checksum) { return kCoderStateMin | checksum; }

/// log2 of a positive normal number to 5 digits, the same on every machine, which the C library's is not: the encoder's
/// choices, and so its bytes, hang on it.
double approximateLog2(double value);

class EntropyWriter {
 public:
  /// A symbol that owns [start, start + frequency) of [0, 2^15), 0 < frequency < 2^15, and ends its group.
  void put(std::uint32_t start, std::uint32_t frequency) {
    putGrouped(start, frequency);
    endGroup();
  }

  /// A symbol whose group goes on; kProbabilityBits of the group's room.
  void putGrouped(std::uint32_t start, std::uint32_t frequency) {
    symbols_.push_back(start << kStartShift | frequency << kFrequencyShift);
  }

  /// `count` equiprobable bits, at most 42, which is the room that they take in the group.
  void putRawGrouped(std::uint64_t value, int count) {
    // Low bits last, for what is coded first has the state's low bits.
    for (; count > 0; count -= kRawChunkBits) {
      const int chunk = count < kRawChunkBits ? count : kRawChunkBits;
      const auto part = static_cast<std::uint32_t>(value) & ((1u << chunk) - 1);
      symbols_.push_back(part << kStartShift | static_cast<std::uint32_t>(chunk) << kFrequencyShift | kIsRaw);
      value >>= chunk;
    }
  }

  /// `count` equiprobable bits, at most 42; ends the group.
  void putRaw(std::uint64_t value, int count) {
    putRawGrouped(value, count);
    endGroup();
  }

  void endGroup() {
    if (!symbols_.empty()) symbols_.back() |= kEndsGroup;
  }

  /// Puts all symbols of another writer.
  void append(const EntropyWriter& other) {
    symbols_.insert(symbols_.end(), other.symbols_.begin(), other.symbols_.end());
  }

  /// Where writing stands, for `bitsSince`.
  std::size_t mark() const { return symbols_.size(); }
  /// Cost in bits of what was put since `mark`.
  double bitsSince(std::size_t mark) const;

  /// Appends the payload to `bytes`. The last group has ended.
  void finish(std::uint32_t checksum, std::vector<std::byte>& bytes) const;

 private:
  static constexpr int kRawChunkBits = 15;
  // What is kept of a symbol: its start, or raw bits; its frequency, or their count; two flags.
  static constexpr int kStartShift = 17;
  static constexpr int kFrequencyShift = 2;
  static constexpr std::uint32_t kFieldMask = kProbabilityOne - 1;
  static constexpr std::uint32_t kIsRaw = 2;
  static constexpr std::uint32_t kEndsGroup = 1;

  std::vector<std::uint32_t> symbols_;
};

class EntropyReader {
 public:
  /// Reads the payload, which ends where `payload` ends. May be hostile: past its end the reader supplies zeros and
  /// `overrun` becomes true; the caller checks it at least once in each loop whose length the stream controls.
  explicit EntropyReader(std::span<const std::byte> payload);

  /// The slot in [0, 2^15) that tells the next symbol.
  std::uint32_t peek() const { return static_cast<std::uint32_t>(state_) & (kProbabilityOne - 1); }

  /// Consumes the symbol that owns [start, start + frequency), which must contain `peek()`, and ends its group.
  void advance(std::uint32_t start, std::uint32_t frequency) {
    advanceGrouped(start, frequency);
    endGroup();
  }

  void advanceGrouped(std::uint32_t start, std::uint32_t frequency) {
    state_ = frequency * (state_ >> kProbabilityBits) + peek() - start;
  }

  std::uint64_t getRawGrouped(int count) {
    const std::uint64_t value = state_ & ((std::uint64_t{1} << count) - 1);
    state_ >>= count;
    return value;
  }

  /// Fewer than 32.
  std::uint32_t getFewRawGrouped(int count) {
    const std::uint32_t value = static_cast<std::uint32_t>(state_) & ((1u << count) - 1);
    state_ >>= count;
    return value;
  }

  std::uint32_t getRaw(int count) {
    const std::uint64_t value = getRawGrouped(count);
    endGroup();
    return static_cast<std::uint32_t>(value);
  }

  /// Fills the state up to its least again, by as many bytes as that takes.
  void endGroup() {
    if (end_ - next_ < 8) [[unlikely]]
      return refillAtEnd();
    // Without a branch, which could not be foreseen. A group leaves the state above 0.
    const int bits = std::countl_zero(state_) & 0x38;
    state_ = state_ << bits | (nextBytes() >> 8) >> (kGroupBits - bits);
    next_ += bits >> 3;
  }

  bool overrun() const { return overrun_; }
  /// True when every byte has been read. The state is then that of `finalState`.
  bool atEnd() const { return next_ == end_ && !overrun_; }
  std::uint64_t state() const { return state_; }
  /// Bytes of the payload read so far.
  std::size_t position() const { return static_cast<std::size_t>(next_ - begin_); }
  /// Bytes of the payload not read yet.
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - next_); }

 private:
  /// The next eight bytes, the first one highest; they must be there.
  std::uint64_t nextBytes() const {
    std::uint64_t bytes;
    std::memcpy(&bytes, next_, sizeof bytes);
    return std::endian::native == std::endian::little ? __builtin_bswap64(bytes) : bytes;
  }

  [[gnu::noinline]] void refillAtEnd();

  const std::byte* begin_;
  const std::byte* next_;
  const std::byte* end_;
  std::uint64_t state_ = 0;
  bool overrun_ = false;
};

}  // namespace tsc
