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
  int count_class = 0;                                 ///< 0..kCountClasses - 1
  int candidate_count = 0;                             ///< 1..kCandidates
  std::array<std::int32_t, kCandidates> candidates{};  ///< the residuals at which the candidates lie
  int hits_around = 0;                                 ///< how many of the gate's ends had a hit on this axis
  std::uint8_t hits = 0;  ///< axes of this vertex that were hits, a bit each; updated by coding
};

template <class Direction>
class ResidualCoder {
 public:
  /// `exact_hits`: whether residuals may be signalled as exactly a candidate's. `effort`: how many experts there are.
  /// Both stand in the header.
  ResidualCoder(Direction direction, bool exact_hits, Effort effort)
      : direction_(direction), exact_hits_(exact_hits), effort_(effort), models_(std::make_unique<Models>(effort)) {}

  /// Codes a residual in steps; only writing looks at `residual`.
  std::int32_t code(Component& c, const ResidualContext& context, std::int32_t residual) {
    Models& m = *models_;
    const int shift = context.shift;
    const std::int32_t half = (1 << shift) >> 1;
    const std::int32_t wide_bin = (residual + half) >> shift;
    int bin = std::clamp(wide_bin + kWindowBins / 2, 0, kWindowBins - 1);
    bin = effort_ == Effort::kDefault
              ? codeByExperts(c, context, m.base[c.axis][shift][context.ratio], bin)
              : codeByExperts(c, context, m.base[c.axis][shift][context.ratio], bin, m.scale[c.axis][context.scale]);
    std::int64_t value = bin - kWindowBins / 2;
    if (bin == 0) {
      value -= direction_.integer(m.beyond[shift], static_cast<std::uint32_t>(value - wide_bin));
    } else if (bin == kWindowBins - 1) {
      value += direction_.integer(m.beyond[shift], static_cast<std::uint32_t>(wide_bin - value));
    }
    if (exact_hits_ && shift > 0) {
      const int hit = codeHit(c, shift, value, residual);
      if (hit >= 0) return c.candidates[hit];
    }
    const std::uint32_t low = direction_.raw(static_cast<std::uint32_t>(residual + half) & ((1u << shift) - 1), shift);
    return limited(value * (1 << shift) + low - half);
  }

 private:
  static std::int32_t limited(std::int64_t residual) {
    if (residual >= -kResidualLimit && residual <= kResidualLimit) [[likely]]
      return static_cast<std::int32_t>(residual);
    return static_cast<std::int32_t>(residual < 0 ? -kResidualLimit : kResidualLimit);
  }

  struct Models {
    BinTable base[3][kShiftClasses][kRatioClasses];
    BinTable scale[3][kScaleClasses];   ///< at effort max
    BinTable single[3][kScaleClasses];  ///< shared by the candidates
    MixWeights weights[kCountClasses][3];
    BitModel hit[kHitShifts][kCandidates][3][kCountClasses][2];
    IntegerModel beyond[kShiftClasses];  ///< how far outside the window a bin lies

    explicit Models(Effort effort) {
      const int centred = effort == Effort::kDefault ? 1 : 2;
      for (int c = 0; c < kCountClasses; ++c) {
        for (MixWeights& w : weights[c]) w = MixWeights(c == 0 ? centred : centred + kCandidates);
      }
    }
  };

  /// The experts centred on the common prediction, and the candidates where there are several.
  template <class... Centred>
  int codeByExperts(const Component& c, const ResidualContext& context, BinTable& base, int bin, Centred&... centred) {
    constexpr int kCentred = 1 + sizeof...(centred);
    MixWeights& weights = models_->weights[c.count_class][c.axis];
    if (c.count_class == 0) {
      return codeBin<kCentred>(direction_, Mixture<kCentred>{{&base, &centred...}}, weights, bin);
    }
    BinTable& single = models_->single[c.axis][context.scale];
    Mixture<kCentred + kCandidates> mixture{{&base, &centred..., &single, &single}};
    for (int j = 0; j < kCandidates; ++j) {
      const std::int32_t bins = (c.candidates[j] + (1 << context.shift >> 1)) >> context.shift;
      mixture.offset[kCentred + j] = std::clamp(bins, -kMaxOffset, kMaxOffset);
    }
    return codeBin<kCentred>(direction_, mixture, weights, bin);
  }

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
  Effort effort_;
  std::unique_ptr<Models> models_;
};

}  // namespace tsc
