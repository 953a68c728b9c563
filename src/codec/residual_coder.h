// The residual components: their bins by adaptive tables, what lies beyond the window, and what lies within the bin
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

inline constexpr int kCandidates = 2;  // single parallelograms that bins are told by
inline constexpr int kHitShifts = 4;
inline constexpr int kPlaceLimit = 7;
inline constexpr std::int64_t kResidualLimit = std::int64_t{1} << 28;  // on the fine lattice

/// What the candidates say of a component's residual.
struct CandidateContext {
  std::array<std::int32_t, kCandidates> residual;  ///< at which they lie, in steps
  int count_class;                                 ///< 0..kCountClasses - 1
  std::uint32_t hits_around;                       ///< for how many of the gate's ends one came true on this axis
};

template <class Direction>
class ResidualCoder {
 public:
  /// `exact_hits` as in PositionParameters. `second_tells`: the first candidate is the prediction, so that only the
  /// place of the second tells anything. `step_bits`: floor(log2(step)) of each axis.
  ResidualCoder(Direction direction, bool exact_hits, bool second_tells, const std::array<int, 3>& step_bits)
      : direction_(direction),
        exact_hits_(exact_hits),
        second_tells_(second_tells),
        step_bits_(step_bits),
        models_(std::make_unique<Models>()) {}

  /// What the components of one vertex have told so far.
  struct Progress {
    std::uint32_t came_true =
        0;                   ///< of the component before: 0 nothing, 1 and 2 which candidate's bin it had, 3 neither
    std::uint32_t hits = 0;  ///< components that were exactly a candidate's and said so, a bit each
  };

  /// Codes a residual in steps but for what lies below its bin's width; only writing looks at `residual`. Returns the
  /// lowest residual of the bin. `table` and `shift` as in ResidualContexts.
  template <int kAxis>
  TSC_ALWAYS_INLINE std::int32_t code(Hot<Direction>& coder, int table, int shift, std::int32_t residual) {
    const std::int32_t half = (1 << shift) >> 1;
    CumulativeTable& centred = models_->centred[kAxis][table];
    std::uint32_t bin = Direction::kWrites ? binOf(residual, shift) : centred.find(coder.peek());
    std::int32_t value = static_cast<std::int32_t>(bin) - kWindowCentre;
    if (isOuter(bin)) [[unlikely]] {
      coder.symbol(centred, bin);
      value = codeBeyond(coder, kAxis, shift, value, residual);
    } else {
      coder.innerSymbol(centred, bin);
    }
    centred.update(bin, kResidualRates);
    return value * (1 << shift) - half;
  }

  /// The same by the candidates as well. Where the residual is a hit, returns it whole.
  template <int kAxis>
  TSC_ALWAYS_INLINE std::int32_t code(Hot<Direction>& coder, int table, int shift, const CandidateContext& candidates,
                                      Progress& progress, std::int32_t residual) {
    const std::int32_t half = (1 << shift) >> 1;
    const std::int32_t first = (candidates.residual[0] + half) >> shift;
    const std::int32_t second = (candidates.residual[1] + half) >> shift;
    const std::int32_t telling = second_tells_ ? second : first;
    const int place = candidates.count_class == 0 ? 2 * kPlaceLimit + 1
                                                  : std::clamp(telling, -kPlaceLimit, kPlaceLimit) + kPlaceLimit;
    CumulativeTable& centred = models_->centred[kAxis][table];
    CumulativeTable& placed =
        models_->placed[kAxis][shift > 0][progress.came_true][candidates.hits_around][static_cast<std::size_t>(place)];
    const AveragedTables average(centred, placed);
    std::uint32_t bin = Direction::kWrites ? binOf(residual, shift) : average.find(coder.peek());
    std::int32_t value = static_cast<std::int32_t>(bin) - kWindowCentre;
    if (isOuter(bin)) [[unlikely]] {
      coder.symbol(average, bin);
      value = codeBeyond(coder, kAxis, shift, value, residual);
    } else {
      coder.innerSymbol(average, bin);
    }
    if (kAxis == 1 && exact_hits_) coder.endGroup();  // three bins and three flags do not fit one group
    centred.update(bin, kResidualRates);
    placed.update(bin, kResidualRates);
    progress.came_true = value == first ? 1 : value == second ? 2 : 3;
    const std::int32_t residual_of_bin = value * (1 << shift) - half;
    if (!exact_hits_) return residual_of_bin;
    HitModel& model = models_->hit[kAxis][std::min(shift, kHitShifts - 1)][progress.came_true][candidates.hits_around]
                                  [progress.hits << 1 >> kAxis & 1];
    const bool possible = shift > 0 && progress.came_true < 3;
    const std::int32_t candidate = candidates.residual[progress.came_true == 2];
    const bool hit = coder.hit(model, possible, residual == candidate);
    progress.hits |= std::uint32_t{hit} << kAxis;
    return hit ? candidate : residual_of_bin;
  }

 private:
  struct Models {
    CumulativeTable centred[3][kScaleClasses * kRatioClasses];
    CumulativeTable placed[3][2][4][4][2 * kPlaceLimit + 2];  ///< by where the first candidate lies
    HitModel hit[3][kHitShifts][4][4][2];
    IntegerModel beyond[kShiftClasses];  ///< how far outside the window a bin lies

    Models() {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t scale = 0; scale < kScaleClasses; ++scale) {
          std::fill_n(centred[axis] + kRatioClasses * scale, kRatioClasses,
                      kFirstWindows[std::min(scale, kDecays.size() - 1)]);
        }
        for (std::size_t wide = 0; wide < 2; ++wide) {
          std::fill_n(&placed[axis][wide][0][0][0], sizeof placed[axis][wide] / sizeof(CumulativeTable),
                      kFirstWindows[wide == 0 ? kDecays.size() / 2 : kDecays.size() - 1]);
        }
      }
    }
  };

  /// Windows before anything is known, by scale: from nearly always 0 up to where bins begin to grow with the scale.
  static constexpr std::array<int, 10> kDecays = {6, 8, 11, 15, 19, 25, 31, 38, 44, 42};
  static constexpr auto kFirstWindows = [] {
    std::array<CumulativeTable, kDecays.size()> tables;
    for (std::size_t i = 0; i < kDecays.size(); ++i) tables[i] = firstWindow(kDecays[i]);
    return tables;
  }();

  static std::int32_t wideBinOf(std::int32_t residual, int shift) { return (residual + ((1 << shift) >> 1)) >> shift; }
  static std::uint32_t binOf(std::int32_t residual, int shift) {
    return static_cast<std::uint32_t>(std::clamp(wideBinOf(residual, shift) + kWindowCentre, 0, kWindowBins - 1));
  }
  static bool isOuter(std::uint32_t bin) { return bin - 1 >= kWindowBins - 2; }

  /// `value` is the outer bin's; returns that of the bin beyond.
  TSC_ALWAYS_INLINE std::int32_t codeBeyond(Hot<Direction>& coder, int axis, int shift, std::int32_t value,
                                            std::int32_t residual) {
    coder.endGroup();
    coder.to(direction_);
    value = codeBeyond(axis, shift, value, residual);
    coder.from(direction_);
    return value;
  }
  [[gnu::noinline]] std::int32_t codeBeyond(int axis, int shift, std::int32_t value, std::int32_t residual) {
    IntegerModel& model = models_->beyond[shift];
    const auto distance = static_cast<std::uint32_t>(std::abs(wideBinOf(residual, shift) - value));
    const std::int64_t excess = direction_.integer(model, Direction::kWrites ? distance : 0);
    const std::int64_t limit = kResidualLimit >> (step_bits_[static_cast<std::size_t>(axis)] + shift);
    return static_cast<std::int32_t>(std::clamp(value < 0 ? value - excess : value + excess, -limit, limit));
  }

  Direction direction_;
  bool exact_hits_;
  bool second_tells_;
  std::array<int, 3> step_bits_;
  std::unique_ptr<Models> models_;
};

}  // namespace tsc
