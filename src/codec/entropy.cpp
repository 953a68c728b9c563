#include "entropy.h"

#include <algorithm>
#include <bit>

namespace tsc {

double approximateLog2(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const int exponent = static_cast<int>(bits >> 52) - 1023;
  const double mantissa = std::bit_cast<double>((bits & ((std::uint64_t{1} << 52) - 1)) | std::uint64_t{1023} << 52);
  const double t = (mantissa - 1) / (mantissa + 1);  // log2 m = 2 / ln 2 * artanh t, t in [0, 1/3]
  const double square = t * t;
  const double series = 1 + square * (1.0 / 3 + square * (1.0 / 5 + square * (1.0 / 7 + square / 9)));
  return exponent + 2.8853900817779268 * t * series;
}

double EntropyWriter::bitsSince(std::size_t mark) const {
  double bits = 0;
  for (std::size_t i = mark; i < symbols_.size(); ++i) {
    const std::uint32_t field = symbols_[i] >> kFrequencyShift & kFieldMask;
    bits += symbols_[i] & kIsRaw ? field : kProbabilityBits - approximateLog2(field);
  }
  return bits;
}

void EntropyWriter::finish(std::uint32_t checksum, std::vector<std::byte>& bytes) const {
  const std::size_t first = bytes.size();
  std::uint64_t state = finalState(checksum);
  for (std::size_t end = symbols_.size(); end > 0;) {
    // What the group leaves of the state's range: product of its frequencies, and of 2^-bits.
    std::uint64_t product = 1;
    int bits = 0;
    std::size_t begin = end;
    do {
      const std::uint32_t symbol = symbols_[--begin];
      const std::uint32_t field = symbol >> kFrequencyShift & kFieldMask;
      product *= symbol & kIsRaw ? 1 : field;
      bits += symbol & kIsRaw ? static_cast<int>(field) : kProbabilityBits;
    } while (begin > 0 && (symbols_[begin - 1] & kEndsGroup) == 0);
    // product < 2^bits, so this stays below 2^64.
    const std::uint64_t bound = product << (64 - bits);
    for (; state >= bound; state >>= 8) bytes.push_back(static_cast<std::byte>(state & 0xff));
    while (end > begin) {
      const std::uint32_t symbol = symbols_[--end];
      const std::uint32_t start = symbol >> kStartShift;
      const std::uint32_t field = symbol >> kFrequencyShift & kFieldMask;
      state = symbol & kIsRaw ? state << field | start : ((state / field) << kProbabilityBits) + state % field + start;
    }
  }
  for (int i = 0; i < 8; ++i, state >>= 8) bytes.push_back(static_cast<std::byte>(state & 0xff));
  std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(first), bytes.end());
}

EntropyReader::EntropyReader(std::span<const std::byte> payload)
    : begin_(payload.data()), next_(begin_), end_(begin_ + payload.size()) {
  refillAtEnd();
  // No writer leaves less; what it would stand for, a longer stream could stand for, too.
  if (state_ < kCoderStateMin) overrun_ = true;
  if (overrun_) state_ = kCoderStateMin;
}

void EntropyReader::refillAtEnd() {
  const int bytes = state_ == 0 ? 8 : std::countl_zero(state_) >> 3;
  for (int i = 0; i < bytes; ++i) {
    overrun_ |= next_ == end_;
    state_ = state_ << 8 | (next_ == end_ ? 0 : static_cast<std::uint64_t>(*next_++));
  }
}

}  // namespace tsc
