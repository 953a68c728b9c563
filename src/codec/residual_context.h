// How large a residual is expected to be: bin width and choice of tables (BITSTREAM.md, section 6.6).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "frame.h"
#include "stencil.h"

namespace tsc {

inline constexpr int kScaleClasses = 44;
inline constexpr int kShiftClasses = 20;
inline constexpr int kRatioClasses = 15;
inline constexpr int kMaxMagnitude = 16383;  // stored magnitudes saturate here

/// What the context of each component is made of, in sixteenths of its step.
struct Surroundings {
  std::array<std::uint32_t, 3> residual{};      ///< mean magnitude of the neighbours' residuals
  std::array<std::uint32_t, 3> disagreement{};  ///< mean distance of the candidates from their average
  std::uint32_t gate = 0;                       ///< mean magnitude of the gate's components, tangential steps
  int stencil_count = 0;
};

struct ResidualContext {
  int shift = 0;  ///< a bin spans 2^shift steps
  int scale = 0;  ///< half octaves of the expected magnitude, 0..kScaleClasses - 1
  int ratio = 0;  ///< disagreement against the neighbours' residuals, and how many candidates there are
};

inline ResidualContext residualContext(const Surroundings& around, int component) {
  const std::uint32_t all = ((around.residual[0] + around.residual[1] + around.residual[2]) * 5461u) >> 14;
  const std::uint32_t own = around.residual[component];
  const bool several = around.stencil_count > 1;
  // 1.8 * (0.8 own + 0.2 all) + 0.4 disagreement, and a third of a step against zero.
  const std::uint32_t expected =
      5 + ((own * 369 + all * 92 + (several ? around.disagreement[component] * 102 : 0)) >> 8);
  ResidualContext context;
  const int width = static_cast<int>(std::bit_width(expected));
  context.scale = std::min(2 * width + static_cast<int>((expected >> (width - 2)) & 1) - 6, kScaleClasses - 1);
  context.shift = std::min<int>(std::bit_width(expected / 96 * 2 + 1) - 1, kShiftClasses - 1);
  const std::uint32_t spread = several ? around.disagreement[component] : around.gate / 4;
  const std::uint32_t mean = (own * 4 + all) / 5 + 2;
  const int ratio = (4 * spread >= mean) + (2 * spread >= mean) + (spread >= mean) + (spread >= 2 * mean);
  context.ratio = ratio + 5 * (std::min(around.stencil_count, 3) - 1);
  return context;
}

}  // namespace tsc
