// The numbers of the format, each with the section of extension-spec/BITSTREAM.md that defines it. Those that only one
// model needs stand beside it.
#pragma once

#include <cstdint>

namespace tsc {

inline constexpr std::uint32_t kFormatVersion = 0;  ///< section 2

/// Coordinates on the fine lattice stay within +-2^26 (section 6.1), so that a parallelogram and its residual fit 32
/// bits.
inline constexpr int kMaxLatticeBits = 26;
inline constexpr std::int32_t kCoordinateLimit = 1 << kMaxLatticeBits;
inline constexpr int kCoordinateBits = 28;

/// Tangent mode: the fine lattice has 2^6 points to a tangential step (section 6.1), so that a normal step of 1/16
/// still has four.
inline constexpr int kFineBits = 6;
inline constexpr std::uint32_t kMaxNormalScale = 16;

}  // namespace tsc
