// One residual component as a mixture of experts (BITSTREAM.md, section 6.6).
//
// A residual is coarsened to bins of 2^shift steps. Each expert owns an adaptive cumulative table of bins centred on
// its own prediction; tables are read at the experts' offsets from the common prediction, so that all give a
// cumulative table over the same window of 16 bins, and are summed with learned weights. The window's outer bins stand
// for all that lies beyond.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

#include "direction.h"
#include "lanes.h"

namespace tsc {

inline constexpr int kWindowBins = 16;
inline constexpr int kWindowCentre = kWindowBins / 2;
inline constexpr int kMaxOffset = 8;
/// Cumulative total of a table: what is missing to 2^15 gives each bin of the window a frequency of its own.
inline constexpr int kTableTotal = static_cast<int>(kProbabilityOne) - 32;

/// Updates go 2^-rate of the way; the rate by the table's age / 2^8. After 4, 12 and 40 updates it grows.
inline constexpr std::array<std::uint8_t, 128> kAdaptationRates = [] {
  std::array<std::uint8_t, 128> rates{};
  for (std::size_t age = 0; age < 128; ++age) {
    rates[age] = static_cast<std::uint8_t>(3 + (age >= 52) + (age >= 83) + (age >= 109));
  }
  return rates;
}();

/// Cumulative frequencies below each of kBins bins. Lane 0, which is always 0 as a cumulative frequency and never read
/// as one, holds the table's age: it grows with each update from 0 towards 2^15 - 1.
template <int kBins>
struct alignas(2 * kBins) BinTable {
  std::array<std::int16_t, kBins> below;

  BinTable() = default;
  /// A two-sided geometric distribution around bin kBins / 2, ratio `decay` / 64 a bin, over a floor of 1/256.
  explicit constexpr BinTable(int decay) : below{} {
    std::array<int, kBins> weight{};
    int sum = 0;
    for (int i = 0; i < kBins; ++i) {
      int w = 1 << 14;
      for (int d = i < kBins / 2 ? kBins / 2 - i : i - kBins / 2; d > 0; --d) w = w * decay / 64;
      weight[static_cast<std::size_t>(i)] = w + (1 << 6);
      sum += w + (1 << 6);
    }
    int total = 0;
    for (int i = 0; i < kBins; ++i) {
      below[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(std::int64_t{total} * kTableTotal / sum);
      total += weight[static_cast<std::size_t>(i)];
    }
  }

  TSC_ALWAYS_INLINE void update(int bin) {
    const auto rate = static_cast<std::int16_t>(kAdaptationRates[static_cast<std::size_t>(below[0] >> 8)]);
    const std::int16_t* const target = kTargets[static_cast<std::size_t>(bin)].data();
    for (std::size_t i = 0; i < kBins; i += 8) {
      const Lanes lanes = loadLanes(&below[i]);
      storeLanes(&below[i], lanes + ((loadLanes(target + i) - lanes) >> rate));
    }
  }

 private:
  /// Where a table moves when a bin is coded: 0 up to it and kTableTotal beyond.
  static constexpr std::array<std::array<std::int16_t, kBins>, kBins> kTargets = [] {
    std::array<std::array<std::int16_t, kBins>, kBins> targets{};
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      targets[bin][0] = 32767;
      for (std::size_t i = bin + 1; i < kBins; ++i) targets[bin][i] = static_cast<std::int16_t>(kTableTotal);
    }
    return targets;
  }();
};

/// The window's own table, and one that is read at an offset.
using CentredTable = BinTable<kWindowBins>;
using ShiftedTable = BinTable<kWindowBins + 2 * kMaxOffset>;

/// Experts where candidates are at work: the table centred on the common prediction, and one table that two candidates
/// share.
inline constexpr int kExperts = 3;

/// Shares of the experts in units of 2^-16; their sum stays at or below 2^16 + 3.
struct MixWeights {
  std::array<std::uint32_t, kExperts> share = {21845, 21845, 21845};

  /// Moves the shares towards each expert's part in the probability that the mixture gave to what came. `frequency` is
  /// what each expert's table gave it.
  TSC_ALWAYS_INLINE void update(const std::array<std::uint32_t, kExperts>& frequency) {
    constexpr std::uint32_t kLeast = (1 << 11) / kExperts;  // what each gets at all events: a 32nd, so that none dies
    std::array<std::uint32_t, kExperts> part;
    std::uint32_t sum = 1;
    for (std::size_t j = 0; j < kExperts; ++j) {
      part[j] = (frequency[j] * share[j]) >> 16;
      sum += part[j];
    }
    const std::uint32_t reciprocal = (1u << 31) / sum;
    for (std::size_t j = 0; j < kExperts; ++j) {
      const std::uint32_t posterior = (part[j] * reciprocal) >> 15;
      const std::uint32_t target = posterior - (posterior >> 5) + kLeast;
      share[j] += static_cast<std::uint32_t>(static_cast<std::int32_t>(target - share[j]) >> 6);
    }
  }
};

/// A cumulative table over the window, ready for one symbol.
class Window {
 public:
  Window(Lanes low, Lanes high) : low_(low), high_(high) {
    low_[0] = 0;
    storeLanes(below_.data(), low_);
    storeLanes(below_.data() + 8, high_);
    below_[kWindowBins] = static_cast<std::int16_t>(-static_cast<int>(kProbabilityOne));
  }

  /// Codes a bin, 0..15, in a lane of the coder.
  template <int kLane, class Coder>
  TSC_ALWAYS_INLINE int code(Coder& coder, int bin) const {
    if constexpr (!Coder::kWrites) {
      bin = countNotAbove(low_, high_, static_cast<std::int16_t>(coder.reader.template peek<kLane>())) - 1;
    }
    const auto start = static_cast<std::uint32_t>(static_cast<std::uint16_t>(below_[static_cast<std::size_t>(bin)]));
    const auto end = static_cast<std::uint32_t>(static_cast<std::uint16_t>(below_[static_cast<std::size_t>(bin) + 1]));
    if constexpr (Coder::kWrites) {
      coder.writer.template put<kLane>(start, end - start);
    } else {
      coder.reader.template advance<kLane>(start, end - start);
    }
    return bin;
  }

 private:
  Lanes low_;
  Lanes high_;
  alignas(16) std::array<std::int16_t, kWindowBins + 8> below_;
};

/// Codes a bin by one table alone, which learns.
template <int kLane, class Coder>
TSC_ALWAYS_INLINE int codeBin(Coder& coder, CentredTable& table, int bin) {
  bin = Window(loadLanes(&table.below[0]) + ramp(0), loadLanes(&table.below[8]) + ramp(8)).code<kLane>(coder, bin);
  table.update(bin);
  return bin;
}

/// Codes a bin by all experts. `offsets`, in bins within +-kMaxOffset, are where the candidates lie. The centred table
/// learns; if `candidates_learn`, so do the shares, and the candidates' table by the candidate nearest to the bin.
template <int kLane, class Coder>
TSC_ALWAYS_INLINE int codeBin(Coder& coder, CentredTable& centred, ShiftedTable& shifted, int first_offset,
                              int second_offset, MixWeights& weights, bool candidates_learn, int bin) {
  // Of the window's bin k, k = 1..15.
  const std::array<const std::int16_t*, kExperts> below = {centred.below.data(),
                                                           shifted.below.data() + (kMaxOffset - first_offset),
                                                           shifted.below.data() + (kMaxOffset - second_offset)};
  Lanes low = ramp(0);  // adding k gives each bin a frequency of at least 1
  Lanes high = ramp(8);
  for (std::size_t j = 0; j < kExperts; ++j) {
    const Lanes share = splat(static_cast<std::int16_t>(weights.share[j]));
    low += multiplyHighUnsigned(loadLanes(below[j]), share);
    high += multiplyHighUnsigned(loadLanes(below[j] + 8), share);
  }
  // The sum of the shares and kTableTotal keep the last lane below 2^15 - 1.
  bin = Window(low, high).code<kLane>(coder, bin);

  if (candidates_learn) {
    std::array<std::uint32_t, kExperts> given;
    const bool last = bin == kWindowBins - 1;
    for (std::size_t j = 0; j < kExperts; ++j) {
      const int lower = bin == 0 ? 0 : below[j][bin];
      const int upper = last ? kTableTotal : below[j][bin + 1];
      given[j] = static_cast<std::uint32_t>(upper - lower);
    }
    weights.update(given);
    const int from_first = std::abs(bin - kWindowCentre - first_offset);
    const int from_second = std::abs(bin - kWindowCentre - second_offset);
    shifted.update(bin + kMaxOffset - (from_second < from_first ? second_offset : first_offset));
  }
  centred.update(bin);
  return bin;
}

}  // namespace tsc
