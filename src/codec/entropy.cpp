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
  for (std::size_t i = mark; i < symbols_.size(); ++i) bits += kProbabilityBits - approximateLog2(symbols_[i] & 0x7fff);
  return bits;
}

void EntropyWriter::finish(std::uint32_t checksum, std::vector<std::byte>& bytes) const {
  std::vector<std::uint16_t> words;  // in the order of writing, which is the reverse of the stream's
  std::array<std::uint32_t, kCoderLanes> states = finalStates(checksum);
  for (std::size_t i = symbols_.size(); i-- > 0;) {
    const std::uint32_t start = symbols_[i] >> 17;
    const std::uint32_t frequency = symbols_[i] & 0x7fff;
    std::uint32_t& state = states[symbols_[i] >> 15 & 3];
    // frequency < 2^15, so the bound stays below 2^32.
    if (state >= frequency << (32 - kProbabilityBits)) {
      words.push_back(static_cast<std::uint16_t>(state));
      state >>= 16;
    }
    state = ((state / frequency) << kProbabilityBits) + state % frequency + start;
  }
  for (int lane = kCoderLanes; lane-- > 0;) {
    words.push_back(static_cast<std::uint16_t>(states[lane]));
    words.push_back(static_cast<std::uint16_t>(states[lane] >> 16));
  }
  std::reverse(words.begin(), words.end());
  for (const std::uint16_t word : words) {
    bytes.push_back(static_cast<std::byte>(word & 0xff));
    bytes.push_back(static_cast<std::byte>(word >> 8));
  }
}

EntropyReader::EntropyReader(std::span<const std::byte> payload)
    : begin_(payload.data()), next_(begin_), end_(begin_ + payload.size()) {
  for (std::uint32_t& state : state_) {
    for (int half = 0; half < 2; ++half) {
      if (end_ - next_ < 2) {
        overrun_ = true;
        return;
      }
      state = state << 16 | word();
      next_ += 2;
    }
    // No writer leaves less; what it would stand for, a longer stream could stand for, too.
    overrun_ |= state < kCoderStateMin;
  }
}

}  // namespace tsc
