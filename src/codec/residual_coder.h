// One residual component: its bin by a mixture of experts, what lies beyond the window, and what lies within the bin
// (BITSTREAM.md, section 6.6).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>

#include "direction.h"
#include "residual.h"
#include "residual_context.h"

namespace tsc {

inline constexpr int kCandidates = 2;    // single parallelograms that are experts of their own
inline constexpr int kCountClasses = 3;  // 1, 2, 3 or more complete parallelograms
inline constexpr int kHitShifts = 8;
inline constexpr std::int64_t kResidualLimit = std::int64_t{1} << 28;

/// What the residual of one axis is coded by, beside its context.
struct Component {
  int axis = 0;
  int count_class = 0;                                   ///< 0..kCountClasses - 1
  int candidate_count = 0;                               ///< 1..kCandidates
  std::array<std::int32_t, kCandidates> candidates{};  ///< the residuals at which the candidates lie
  int hits_around = 0;                                   ///< how many of the gate's ends had a hit on this axis
  std::uint8_t hits = 0;  ///< axes of this vertex that were hits, a bit each; updated by coding
};

template <class Direction>
class ResidualCoder {
 public:
  /// `exact_hits`: whether residuals may be signalled as exactly a candidate's (header).
  ResidualCoder(Direction direction, bool exact_hits)
      : direction_(direction), exact_hits_(exact_hits), models_(std::make_unique<Models>()) {}

  /// Codes a residual in steps; only writing looks at `residual`.
  std::int32_t code(Component& c, const ResidualContext& context, std::int32_t residual) {
    Models& m = *models_;
    const int shift = context.shift;
    const std::int32_t half = (1 << shift) >> 1;
    BinTable& base = m.base[c.axis][shift][context.ratio];
    MixWeights& weights = m.weights[c.count_class][c.axis];
    const std::int32_t wide_bin = (residual + half) >> shift;
    int bin = std::clamp(wide_bin + kWindowBins / 2, 0, kWindowBins - 1);
    if (c.count_class == 0) {
      bin = codeBin<1>(direction_, Mixture<1>{{&base}}, weights, bin);
    } else {
      BinTable& single = m.single[c.axis][context.scale];
      const auto offset = [&](int j) { return std::clamp((c.candidates[j] + half) >> shift, -kMaxOffset, kMaxOffset); };
      bin = codeBin<1>(direction_, Mixture<3>{{&base, &single, &single}, {0, offset(0), offset(1)}}, weights, bin);
    }
    std::int64_t value = bin - kWindowBins / 2;
    if (bin == 0) {
      value -= direction_.integer(m.beyond[shift], static_cast<std::uint32_t>(value - wide_bin));
    } else if (bin == kWindowBins - 1) {
      value += direction_.integer(m.beyond[shift], static_cast<std::uint32_t>(wide_bin - value));
    }
    if (shift == 0) return static_cast<std::int32_t>(std::clamp(value, -kResidualLimit, kResidualLimit));
    if (exact_hits_) {
      const int hit = codeHit(c, shift, value, residual);
      if (hit >= 0) return c.candidates[hit];
    }
    const std::uint32_t low = direction_.raw(static_cast<std::uint32_t>(residual + half) & ((1u << shift) - 1), shift);
    return static_cast<std::int32_t>(std::clamp(value * (1 << shift) + low - half, -kResidualLimit, kResidualLimit));
  }

 private:
  struct Models {
    BinTable base[3][kShiftClasses][kRatioClasses];
    BinTable single[3][kScaleClasses];  ///< shared by the candidates
    MixWeights weights[kCountClasses][3];
    BitModel hit[kHitShifts][kCandidates][3][kCountClasses][2];
    IntegerModel beyond[kShiftClasses];  ///< how far outside the window a bin lies

    Models() {
      for (int c = 0; c < kCountClasses; ++c) {
        for (MixWeights& w : weights[c]) w = MixWeights(c == 0 ? 1 : 1 + kCandidates);
      }
    }
  };

  /// Which of the candidates that lie in the bin the residual equals; -1 for none.
  int codeHit(Component& c, int shift, std::int64_t bin, std::int32_t residual) {
    const std::int32_t half = 1 << (shift - 1);
    const int previous = c.axis > 0 ? c.hits >> (c.axis - 1) & 1 : 0;
    for (int j = 0; j < c.candidate_count; ++j) {
      if ((c.candidates[j] + half) >> shift != bin || (j > 0 && c.candidates[j] == c.candidates[0])) continue;
      BitModel& model = models_->hit[std::min(shift, kHitShifts) - 1][j][c.hits_around][c.count_class][previous];
      if (direction_.bit(model, residual == c.candidates[j])) {
        c.hits |= static_cast<std::uint8_t>(1 << c.axis);
        return j;
      }
    }
    return -1;
  }

  Direction direction_;
  bool exact_hits_;
  std::unique_ptr<Models> models_;
};

}  // namespace tsc
