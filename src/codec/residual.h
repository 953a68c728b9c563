// One residual component as a mixture of experts (BITSTREAM.md, section 6.6).
//
// A residual is coarsened to bins of 2^shift steps. Each expert owns an adaptive cumulative table over 32 bins centred
// on its own prediction; tables are read at the experts' offsets from the common prediction, so that all give a
// cumulative table over the same window of 16 bins, and are summed with learned weights. The window's outer bins stand
// for all that lies beyond. What is left below a bin's width is sent raw, unless the residual is exactly what a
// candidate predicts.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "direction.h"
#include "lanes.h"

namespace tsc {

inline constexpr int kTableBins = 32;
inline constexpr int kWindowBins = 16;
inline constexpr int kMaxOffset = 8;
/// Bin of a table that a value equal to the expert's prediction falls into.
inline constexpr int kTableCentre = kTableBins / 2;
/// Cumulative total of a table: what is missing to 2^15 gives each bin of the window a frequency of its own.
inline constexpr int kTableTotal = static_cast<int>(kProbabilityOne) - 32;

/// Cumulative frequencies below each bin. Lane 0, which is always 0 as a cumulative frequency and never read as one,
/// holds the number of updates so far, capped.
struct alignas(64) BinTable {
  std::array<std::int16_t, kTableBins> below;

  /// A two-sided geometric distribution, ratio 5/8 a bin, over a floor of 1/256.
  BinTable() : below(kInitial) {}

  void update(int bin) {
    const int count = below[0];
    const int rate = 3 + (count >= 4) + (count >= 12) + (count >= 40);
    const Lanes symbol = splat(static_cast<std::int16_t>(bin));
    for (int i = 0; i < kTableBins; i += 8) {
      const Lanes target = greater(ramp(i), symbol) & static_cast<std::int16_t>(kTableTotal);
      const Lanes lanes = loadLanes(&below[i]);
      storeLanes(&below[i], lanes + ((target - lanes) >> rate));
    }
    below[0] = static_cast<std::int16_t>(count < 63 ? count + 1 : 63);
  }

 private:
  static constexpr std::array<std::int16_t, kTableBins> initial() {
    std::array<int, kTableBins> weight{};
    int sum = 0;
    for (int i = 0; i < kTableBins; ++i) {
      int w = 1 << 14;
      for (int d = i < kTableCentre ? kTableCentre - i : i - kTableCentre; d > 0; --d) w = w * 5 / 8;
      weight[i] = w + (1 << 6);
      sum += weight[i];
    }
    std::array<std::int16_t, kTableBins> below{};
    int total = 0;
    for (int i = 0; i < kTableBins; ++i) {
      below[i] = static_cast<std::int16_t>(std::int64_t{total} * kTableTotal / sum);
      total += weight[i];
    }
    return below;
  }
  static const std::array<std::int16_t, kTableBins> kInitial;
};
inline constexpr std::array<std::int16_t, kTableBins> BinTable::kInitial = BinTable::initial();

inline constexpr int kMaxExperts = 4;

/// Shares of the experts in units of 2^-16; their sum stays at or below 2^16 + 4.
struct alignas(16) MixWeights {
  std::array<std::uint32_t, kMaxExperts> share{};
  std::array<std::uint32_t, kMaxExperts> least{};  ///< what each expert gets at all events

  explicit MixWeights(int expert_count = kMaxExperts) {
    for (int j = 0; j < expert_count; ++j) {
      share[j] = static_cast<std::uint32_t>(65535 / expert_count);
      least[j] = static_cast<std::uint32_t>((1 << 11) / expert_count);
    }
  }

  /// Moves the shares towards each expert's part in the probability that the mixture gave to what came. `frequency` is
  /// what each expert's table gave it, 0 where there is no expert.
  void update(const std::array<std::uint32_t, kMaxExperts>& frequency) {
    const Words shares = loadWords(share.data());
    // At most 2^15 * 2^16, with 8 bits dropped so that part * (2^32 / sum) stays below 2^32.
    const Words part = (loadWords(frequency.data()) * shares) >> 8;
    const std::uint32_t sum = part[0] + part[1] + part[2] + part[3] + 1;
    const Words posterior = (part * (0xffffffffu / sum)) >> 16;
    // A 32nd goes to all alike, so that no share dies out.
    const Words target = posterior - (posterior >> 5) + loadWords(least.data());
    using Signed [[gnu::vector_size(16)]] = std::int32_t;
    storeWords(share.data(), shares + (Words)((Signed)(target - shares) >> 6));
  }
};

/// The experts at work on one residual: tables, and the offsets of their predictions from the common one, in bins.
template <int kCount>
struct Mixture {
  std::array<BinTable*, kCount> table;
  std::array<int, kCount> offset{};  ///< within +-kMaxOffset
};

/// Codes a bin of the window, 0..15, and lets tables and shares learn. Of the experts from `kFirstShared` on, which
/// share one table, only the one that gave the bin most learns.
template <int kFirstShared, int kCount, class Direction>
TSC_ALWAYS_INLINE int codeBin(Direction& direction, const Mixture<kCount>& mixture, MixWeights& weights, int bin) {
  static_assert(kCount <= kMaxExperts);
  std::array<const std::int16_t*, kCount> window;  // below[k] of the window's bin k, k = 1..15
  Lanes low = ramp(0);                             // adding k gives each bin a frequency of at least 1
  Lanes high = ramp(8);
  for (int j = 0; j < kCount; ++j) {
    window[j] = mixture.table[j]->below.data() + (kMaxOffset - mixture.offset[j]);
    const Lanes share = splat(static_cast<std::int16_t>(weights.share[j]));
    low += multiplyHighUnsigned(loadLanes(window[j]), share);
    high += multiplyHighUnsigned(loadLanes(window[j] + 8), share);
  }
  low[0] = 0;  // where a window starts at a table's lane 0, that lane counted updates
  // The sum of the shares and kTableTotal keep below[15] < 2^15 - 1.
  alignas(16) std::array<std::int16_t, kWindowBins + 1> below;
  storeLanes(below.data(), low);
  storeLanes(below.data() + 8, high);

  if constexpr (!Direction::kWrites) {
    bin = countNotAbove(low, high, static_cast<std::int16_t>(direction.reader.peek())) - 1;
  }
  const auto start = static_cast<std::uint32_t>(below[bin]);
  const bool last = bin == kWindowBins - 1;
  const std::uint32_t frequency = (last ? kProbabilityOne : static_cast<std::uint32_t>(below[bin + 1])) - start;
  if constexpr (Direction::kWrites) {
    direction.writer.put(start, frequency);
  } else {
    direction.reader.advance(start, frequency);
  }

  alignas(16) std::array<std::uint32_t, kMaxExperts> given{};
  std::uint32_t most = 0;
  int best = kFirstShared;
  for (int j = 0; j < kCount; ++j) {
    const int lower = bin == 0 ? 0 : window[j][bin];
    given[j] = static_cast<std::uint32_t>((last ? kTableTotal : window[j][bin + 1]) - lower);
    if (j >= kFirstShared && given[j] > most) {
      most = given[j];
      best = j;
    }
  }
  weights.update(given);
  const int table_bin = bin + kTableCentre - kWindowBins / 2;
  for (int j = 0; j < kFirstShared; ++j) {
    mixture.table[j]->update(std::clamp(table_bin - mixture.offset[j], 0, kTableBins - 1));
  }
  if constexpr (kFirstShared < kCount) {
    mixture.table[best]->update(std::clamp(table_bin - mixture.offset[best], 0, kTableBins - 1));
  }
  return bin;
}

}  // namespace tsc
