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

inline constexpr int kCandidates = 2;  // single parallelograms that are experts of their own
inline constexpr int kHitShifts = 8;
inline constexpr std::int64_t kResidualLimit = std::int64_t{1} << 28;  // on the fine lattice

/// What the residual of one axis is coded by.
struct Component {
  int scale;  ///< these three as in ResidualContexts
  int shift;
  int ratio;
  int count_class;                                   ///< 0..kCountClasses - 1
  int first_offset, second_offset;                   ///< of the candidates, in bins, at most kMaxOffset
  std::array<std::int32_t, kCandidates> candidates;  ///< the residuals at which they lie; these two for exact hits only
  int hits_around;                                   ///< how many of the gate's ends had a hit on this axis
  bool candidates_learn;
};

template <class Direction>
class ResidualCoder {
 public:
  /// `exact_hits` and `centred_only` as in PositionParameters. `step_bits`: floor(log2(step)) of each axis.
  ResidualCoder(Direction direction, bool exact_hits, bool centred_only, const std::array<int, 3>& step_bits)
      : direction_(direction),
        exact_hits_(exact_hits),
        centred_only_(centred_only),
        step_bits_(step_bits),
        models_(std::make_unique<Models>()) {}

  /// Whether candidates play a part where there are two or more.
  bool usesCandidates() const { return !centred_only_ || exact_hits_; }

  /// Codes a residual in steps but for what lies below its bin's width; only writing looks at `residual`. Returns the
  /// lowest residual of the bin, or, where it is a hit, the residual itself; `hits` holds the axes of this vertex that
  /// were hits, a bit each, and is updated. Without `kCandidates`, where usesCandidates() is false or the vertex has
  /// one stencil and no hits are coded, nothing of them is looked at.
  template <int kAxis, bool kWithCandidates>
  TSC_ALWAYS_INLINE std::int32_t code(Hot<Direction>& coder, const Component& c, std::uint32_t& hits,
                                      std::int32_t residual) {
    Models& m = *models_;
    const std::int32_t half = (1 << c.shift) >> 1;
    std::int32_t wide_bin = 0;
    int bin = 0;
    if constexpr (Direction::kWrites) {
      wide_bin = (residual + half) >> c.shift;
      bin = std::clamp(wide_bin + kWindowCentre, 0, kWindowBins - 1);
    }
    CentredTable& centred = m.centred[kAxis][c.scale][c.ratio];
    if (!kWithCandidates || c.count_class == 0 || centred_only_) {
      bin = codeBin<kAxis>(coder, centred, bin);
    } else {
      bin = codeBin<kAxis>(coder, centred, m.shifted[kAxis][c.scale], c.first_offset, c.second_offset,
                           m.weights[c.count_class - 1][kAxis], c.candidates_learn, bin);
    }
    std::int32_t value = bin - kWindowCentre;
    if (bin == 0 || bin == kWindowBins - 1) [[unlikely]] {
      coder.to(direction_);
      value = codeBeyond(kAxis, c.shift, value, wide_bin);
      coder.from(direction_);
    }
    if (kWithCandidates && exact_hits_ && c.shift > 0) {
      const int hit = codeHit(coder, kAxis, c, hits, value, residual);
      if (hit >= 0) return c.candidates[static_cast<std::size_t>(hit)];
    }
    return value * (1 << c.shift) - half;
  }

 private:
  struct Models {
    CentredTable centred[3][kScaleClasses][kRatioClasses];
    ShiftedTable shifted[3][kScaleClasses];
    MixWeights weights[kCountClasses - 1][3];
    BitModel hit[kHitShifts][kCandidates][3][kCountClasses][2];
    IntegerModel beyond[kShiftClasses];  ///< how far outside the window a bin lies

    Models() {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t scale = 0; scale < kScaleClasses; ++scale) {
          const std::size_t first = std::min(scale, kFirstTables.size() - 1);
          std::fill_n(centred[axis][scale], kRatioClasses, kFirstTables[first]);
          shifted[axis][scale] = kFirstShiftedTables[first];
        }
      }
    }
  };

  /// Tables before anything is known, by scale: from nearly always 0 up to where bins begin to grow with the scale.
  static constexpr std::array<int, 10> kDecays = {6, 8, 11, 15, 19, 25, 31, 38, 44, 42};
  template <class Table>
  static constexpr std::array<Table, kDecays.size()> firstTables() {
    std::array<Table, kDecays.size()> tables;
    for (std::size_t i = 0; i < kDecays.size(); ++i) tables[i] = Table(kDecays[i]);
    return tables;
  }
  static constexpr auto kFirstTables = firstTables<CentredTable>();
  static constexpr auto kFirstShiftedTables = firstTables<ShiftedTable>();

  [[gnu::noinline]] std::int32_t codeBeyond(int axis, int shift, std::int32_t value, std::int32_t wide_bin) {
    IntegerModel& model = models_->beyond[shift];
    const std::int64_t excess = direction_.integer(model, static_cast<std::uint32_t>(std::abs(wide_bin - value)));
    const std::int64_t limit = kResidualLimit >> (step_bits_[static_cast<std::size_t>(axis)] + shift);
    return static_cast<std::int32_t>(std::clamp(value < 0 ? value - excess : value + excess, -limit, limit));
  }

  /// Which of the candidates that lie in the bin the residual equals; -1 for none.
  TSC_ALWAYS_INLINE int codeHit(Hot<Direction>& coder, int axis, const Component& c, std::uint32_t& hits,
                                std::int32_t bin, std::int32_t residual) {
    const std::int32_t half = 1 << (c.shift - 1);
    const std::uint32_t previous = axis > 0 ? hits >> (axis - 1) & 1 : 0;
    const int count = std::min(c.count_class + 1, kCandidates);
    for (int j = 0; j < count; ++j) {
      const std::int32_t candidate = c.candidates[static_cast<std::size_t>(j)];
      if ((candidate + half) >> c.shift != bin || (j > 0 && candidate == c.candidates[0])) continue;
      BitModel& model = models_->hit[std::min(c.shift, kHitShifts) - 1][j][c.hits_around][c.count_class][previous];
      if (coder.bit(model, residual == candidate)) {
        hits |= 1u << axis;
        return j;
      }
    }
    return -1;
  }

  Direction direction_;
  bool exact_hits_;
  bool centred_only_;
  std::array<int, 3> step_bits_;
  std::unique_ptr<Models> models_;
};

}  // namespace tsc
