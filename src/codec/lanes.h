// Eight 16-bit integers side by side. Lane by lane these are plain integers, so results are the same on every machine;
// GCC and Clang turn the vector type into SSE2, NEON or WebAssembly SIMD, and into scalar code where there is none.
// What the vector extensions cannot say stands below, once for x86 and once for the rest.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/// For the three steps of coding a vertex that compilers find too large to inline, though each is called in one place.
#define TSC_ALWAYS_INLINE [[gnu::always_inline]] inline

namespace tsc {

using Lanes [[gnu::vector_size(16)]] = std::int16_t;
using UnsignedLanes [[gnu::vector_size(16)]] = std::uint16_t;
using Words [[gnu::vector_size(16)]] = std::uint32_t;

inline Lanes splat(std::int16_t value) { return Lanes{} + value; }

/// Lane i is `first` + i.
inline Lanes ramp(int first) {
  constexpr Lanes kSteps = {0, 1, 2, 3, 4, 5, 6, 7};
  return kSteps + static_cast<std::int16_t>(first);
}

inline Words loadWords(const std::uint32_t* from) {
  Words words;
  std::memcpy(&words, from, sizeof words);
  return words;
}
inline void storeWords(std::uint32_t* to, Words words) { std::memcpy(to, &words, sizeof words); }

inline Lanes loadLanes(const std::int16_t* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}
inline void storeLanes(std::int16_t* to, Lanes lanes) { std::memcpy(to, &lanes, sizeof lanes); }

/// Eight 32-bit integers.
using Integers [[gnu::vector_size(16)]] = std::int32_t;
struct WideLanes {
  Integers low;
  Integers high;
};

/// The bits that magnitudes use: those of all lanes, negative ones complemented, or-ed.
inline std::uint32_t magnitudeBits(const WideLanes& x, const WideLanes& y, const WideLanes& z) {
  const auto fold = [](Integers v) { return v ^ (v >> 31); };
  const Integers bits = fold(x.low) | fold(x.high) | fold(y.low) | fold(y.high) | fold(z.low) | fold(z.high);
  return static_cast<std::uint32_t>(bits[0] | bits[1] | bits[2] | bits[3]);
}

/// Eight integers times 2^scale, rounded down; the result must fit 16 bits.
inline Lanes narrowed(const WideLanes& from, int scale) {
  // One of the two shifts is by nothing, which is cheaper than to foresee which.
  const int left = scale > 0 ? scale : 0;
  const int right = scale < 0 ? -scale : 0;
  const Integers low = (from.low << left) >> right;
  const Integers high = (from.high << left) >> right;
#if defined(__SSE2__)
  return (Lanes)_mm_packs_epi32((__m128i)low, (__m128i)high);
#else
  Lanes lanes;
  for (int i = 0; i < 4; ++i) {
    lanes[i] = static_cast<std::int16_t>(low[i]);
    lanes[i + 4] = static_cast<std::int16_t>(high[i]);
  }
  return lanes;
#endif
}

/// All bits of a lane where it is larger.
inline Lanes greater(Lanes a, Lanes b) { return (Lanes)(a > b); }

/// (a * b) >> 16 in each lane.
inline Lanes multiplyHigh(Lanes a, Lanes b) {
#if defined(__SSE2__)
  return (Lanes)_mm_mulhi_epi16((__m128i)a, (__m128i)b);
#else
  Lanes product;
  for (int i = 0; i < 8; ++i) product[i] = static_cast<std::int16_t>((a[i] * b[i]) >> 16);
  return product;
#endif
}

/// The same with lanes read as unsigned.
inline Lanes multiplyHighUnsigned(Lanes a, Lanes b) {
#if defined(__SSE2__)
  return (Lanes)_mm_mulhi_epu16((__m128i)a, (__m128i)b);
#else
  const UnsignedLanes ua = (UnsignedLanes)a;
  const UnsignedLanes ub = (UnsignedLanes)b;
  UnsignedLanes product;
  for (int i = 0; i < 8; ++i) product[i] = static_cast<std::uint16_t>((std::uint32_t{ua[i]} * ub[i]) >> 16);
  return (Lanes)product;
#endif
}

/// Sum of the products of all lanes; the caller knows that it fits 32 bits.
inline std::int32_t dotProduct(Lanes a, Lanes b) {
#if defined(__SSE2__)
  __m128i sum = _mm_madd_epi16((__m128i)a, (__m128i)b);
  sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0x4e));
  sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0xb1));
  return _mm_cvtsi128_si32(sum);
#else
  std::int32_t sum = 0;
  for (int i = 0; i < 8; ++i) sum += a[i] * b[i];
  return sum;
#endif
}

/// How many of 16 ascending lanes are at most `value`.
inline int countNotAbove(Lanes low, Lanes high, std::int16_t value) {
  const Lanes bound = splat(value);
#if defined(__SSE2__)
  const __m128i above = _mm_packs_epi16((__m128i)greater(low, bound), (__m128i)greater(high, bound));
  return std::countr_zero(static_cast<unsigned>(_mm_movemask_epi8(above)) | 0x10000u);
#else
  const Lanes above = greater(low, bound) + greater(high, bound);
  int count = 16;
  for (int i = 0; i < 8; ++i) count += above[i];
  return count;
#endif
}

}  // namespace tsc
