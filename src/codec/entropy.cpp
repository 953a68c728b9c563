#include "entropy.h"

#include <algorithm>
#include <cmath>

namespace tsc {

double approximateLog2(double value) {
  int exponent = 0;
  const double mantissa = 2 * std::frexp(value, &exponent);  // in [1, 2)
  const double t = (mantissa - 1) / (mantissa + 1);          // log2 m = 2 / ln 2 * artanh t, t in [0, 1/3]
  const double square = t * t;
  const double series = 1 + square * (1.0 / 3 + square * (1.0 / 5 + square * (1.0 / 7 + square / 9)));
  return exponent - 1 + 2.8853900817779268 * t * series;
}

double EntropyWriter::bitsSince(std::size_t mark) const {
  double bits = 0;
  for (std::size_t i = mark; i < symbols_.size(); ++i) bits += kProbabilityBits - approximateLog2(symbols_[i] & 0xffff);
  return bits;
}

void EntropyWriter::finish(std::uint32_t checksum, std::vector<std::byte>& bytes) const {
  std::vector<std::uint32_t> words;  // in the order of writing, which is the reverse of the stream's
  std::uint64_t state = kCoderStateMin + checksum;
  for (std::size_t i = symbols_.size(); i-- > 0;) {
    const std::uint32_t start = symbols_[i] >> 16;
    const std::uint64_t frequency = symbols_[i] & 0xffff;
    // frequency < 2^15, so the bound stays below 2^64.
    if (state >= frequency << (64 - kProbabilityBits)) {
      words.push_back(static_cast<std::uint32_t>(state));
      state >>= 32;
    }
    state = ((state / frequency) << kProbabilityBits) + state % frequency + start;
  }
  words.push_back(static_cast<std::uint32_t>(state));
  words.push_back(static_cast<std::uint32_t>(state >> 32));
  std::reverse(words.begin(), words.end());
  for (const std::uint32_t word : words) {
    for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::byte>(word >> shift));
  }
}

EntropyReader::EntropyReader(std::span<const std::byte> payload)
    : begin_(payload.data()), next_(begin_), end_(begin_ + payload.size()) {
  refill();
  refill();
}

}  // namespace tsc
