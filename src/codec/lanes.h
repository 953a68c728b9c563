// Eight 16-bit integers side by side. Lane by lane these are plain integers, so results are the same on every machine;
// GCC and Clang turn the vector type into SSE2, NEON or WebAssembly SIMD, and into scalar code where there is none.
// What the vector extensions cannot say stands below, once for x86 and once for the rest.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
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

using Halves [[gnu::vector_size(16)]] = std::int64_t;

inline Lanes splat(std::int16_t value) { return Lanes{} + value; }

/// Lane i is `first` + i.
inline Lanes ramp(int first) {
  constexpr Lanes kSteps = {0, 1, 2, 3, 4, 5, 6, 7};
  return kSteps + static_cast<std::int16_t>(first);
}

inline Lanes loadLanes(const std::int16_t* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}
inline void storeLanes(std::int16_t* to, Lanes lanes) { std::memcpy(to, &lanes, sizeof lanes); }

/// Four 32-bit integers, of which three are most often a vector x y z.
using Integers [[gnu::vector_size(16)]] = std::int32_t;
using Floats [[gnu::vector_size(16)]] = float;

inline Integers splatInteger(std::int32_t value) { return Integers{} + value; }
/// `v` with another lane 3.
inline Integers withLast(Integers v, std::int32_t last) {
  return (v & Integers{-1, -1, -1, 0}) | Integers{0, 0, 0, last};
}
inline Integers magnitudes(Integers v) { return (v ^ (v >> 31)) - (v >> 31); }
inline Integers smaller(Integers a, Integers b) {
  const Integers less = (Integers)(a < b);
  return (a & less) | (b & ~less);
}

inline Integers bounded(Integers v, std::int32_t limit) {
  const Integers bound = splatInteger(limit);
  return -smaller(-smaller(v, bound), bound);
}

inline Floats floatsOf(Integers v) { return __builtin_convertvector(v, Floats); }
/// Rounded towards zero; within 32 bits.
inline Integers truncated(Floats v) { return __builtin_convertvector(v, Integers); }
inline Floats magnitudes(Floats v) { return (Floats)((Integers)v & 0x7fffffff); }
inline Floats smaller(Floats a, Floats b) {
#if defined(__SSE2__)
  return (Floats)_mm_min_ps((__m128)a, (__m128)b);
#else
  return a < b ? a : b;
#endif
}
inline Floats larger(Floats a, Floats b) {
#if defined(__SSE2__)
  return (Floats)_mm_max_ps((__m128)a, (__m128)b);
#else
  return a > b ? a : b;
#endif
}

/// The sums of the lanes of each, modulo 2^32.
inline Integers laneSums(Integers a, Integers b, Integers c) {
  const Words wa = (Words)a, wb = (Words)b, wc = (Words)c;
  const Words ab = __builtin_shufflevector(wa, wb, 0, 4, 1, 5) + __builtin_shufflevector(wa, wb, 2, 6, 3, 7);
  const Words c0 = __builtin_shufflevector(wc, Words{}, 0, 4, 1, 5) + __builtin_shufflevector(wc, Words{}, 2, 6, 3, 7);
  return (Integers)(__builtin_shufflevector(ab, c0, 0, 1, 4, 5) + __builtin_shufflevector(ab, c0, 2, 3, 6, 7));
}

/// Four 16-bit integers, widened.
inline Integers widened(const std::int16_t* from) {
#if defined(__SSE2__)
  const __m128i lanes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from));
  return (Integers)_mm_srai_epi32(_mm_unpacklo_epi16(lanes, lanes), 16);
#else
  return Integers{from[0], from[1], from[2], from[3]};
#endif
}

/// The last four of eight 16-bit integers, widened.
inline Integers widenedHigh(Lanes v) {
  return (Integers)__builtin_shufflevector(v, v, 4, 12, 5, 13, 6, 14, 7, 15) >> 16;
}

/// Eight integers as 16-bit ones, saturated: those of `low`, then those of `high`.
inline Lanes packed(Integers low, Integers high) {
#if defined(__SSE2__)
  return (Lanes)_mm_packs_epi32((__m128i)low, (__m128i)high);
#else
  Lanes lanes;
  const auto saturated = [](std::int32_t v) { return static_cast<std::int16_t>(std::clamp(v, -32768, 32767)); };
  for (int i = 0; i < 4; ++i) {
    lanes[i] = saturated(low[i]);
    lanes[i + 4] = saturated(high[i]);
  }
  return lanes;
#endif
}

/// Each lane times 2^scale, rounded down.
inline Integers scaled(Integers v, int scale) {
  // One of the two shifts is by nothing, which is cheaper than to foresee which.
  const int down = scale >> 31;
  return (v << (scale & ~down)) >> (-scale & down);
}

inline Lanes atMost(Lanes a, Lanes b) {
#if defined(__SSE2__)
  return (Lanes)_mm_min_epi16((__m128i)a, (__m128i)b);
#else
  const Lanes less = (Lanes)(a < b);
  return (a & less) | (b & ~less);
#endif
}
inline Lanes atLeast(Lanes a, Lanes b) {
#if defined(__SSE2__)
  return (Lanes)_mm_max_epi16((__m128i)a, (__m128i)b);
#else
  const Lanes less = (Lanes)(a < b);
  return (b & less) | (a & ~less);
#endif
}

/// Each lane times 2^-count, rounded down; 0 <= count < 16.
inline Lanes shiftedDown(Lanes v, std::int32_t count) {
#if defined(__SSE2__)
  return (Lanes)_mm_sra_epi16((__m128i)v, _mm_cvtsi32_si128(count));
#else
  return v >> static_cast<std::int16_t>(count);
#endif
}

/// a + b, saturated.
inline Lanes saturatedSum(Lanes a, Lanes b) {
#if defined(__SSE2__)
  return (Lanes)_mm_adds_epi16((__m128i)a, (__m128i)b);
#else
  Lanes sum;
  for (int i = 0; i < 8; ++i) sum[i] = static_cast<std::int16_t>(std::clamp(a[i] + b[i], -32768, 32767));
  return sum;
#endif
}

/// Each lane times 2^-shift, rounded to nearest, halves up, and bounded by +-limit <= 8. 0 <= shift <= 18.
inline Integers scaledDown(Integers v, Integers shift, int limit) {
  const Floats scale = (Floats)((127 << 23) - (shift << 23));
  const Floats bound = Floats{} + static_cast<float>(limit);
  // Halves of a lane's last place are told apart by a quarter more. Exact wherever the bound does not rule.
  const Floats scaled = __builtin_convertvector(v, Floats) * scale + scale * 0.25f;
#if defined(__SSE2__)
  return (Integers)_mm_cvtps_epi32(_mm_max_ps(_mm_min_ps((__m128)scaled, (__m128)bound), (__m128)-bound));
#else
  Integers result;
  for (int i = 0; i < 4; ++i) {
    const float x = std::clamp(scaled[i], -bound[i], bound[i]);
    constexpr float kRound = 0x1.8p23f;  // too large for a fraction
    volatile float whole = x + kRound;
    result[i] = static_cast<std::int32_t>(whole - kRound);
  }
  return result;
#endif
}

/// 2^23 log2 of each lane, 0 < lane < 2^24, linear between powers of two: a float's bits are just that.
inline Integers logarithms(Integers v) { return (Integers) __builtin_convertvector(v, Floats) - (127 << 23); }

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

/// Products of lanes, summed by pairs; the caller knows that the sums fit 32 bits.
inline Integers pairProducts(Lanes a, Lanes b) {
#if defined(__SSE2__)
  return (Integers)_mm_madd_epi16((__m128i)a, (__m128i)b);
#else
  Integers sums;
  for (int i = 0; i < 4; ++i) sums[i] = a[2 * i] * b[2 * i] + a[2 * i + 1] * b[2 * i + 1];
  return sums;
#endif
}

/// Bits of the largest magnitude of all lanes; of a negative lane, those of its complement.
inline int magnitudeBits(Integers v) {
  v ^= v >> 31;
  v |= __builtin_shufflevector(v, v, 2, 3, 0, 1);
  v |= __builtin_shufflevector(v, v, 1, 0, 3, 2);
  return std::bit_width(static_cast<std::uint32_t>(v[0]));
}

/// Bit 2 a is set where lane a of `values` equals lane a or a + 4 of `others`; a = 0..2.
inline std::uint32_t pairsOfEqual(Lanes values, Lanes others) {
#if defined(__SSE2__)
  const auto equal = static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_cmpeq_epi16((__m128i)values, (__m128i)others)));
  return (equal | equal >> 8) & 0x15;
#else
  std::uint32_t bits = 0;
  for (int a = 0; a < 3; ++a) {
    if (values[a] == others[a] || values[a] == others[a + 4]) bits |= 1u << (2 * a);
  }
  return bits;
#endif
}

/// Whether all lanes are 0.
inline bool isZero(Integers v) {
#if defined(__SSE2__)
  return _mm_movemask_epi8(_mm_cmpeq_epi32((__m128i)v, __m128i{})) == 0xffff;
#else
  return (v[0] | v[1] | v[2] | v[3]) == 0;
#endif
}

/// a * b of each lane, both within 16 bits.
inline Integers shortProducts(Integers a, Integers b) { return pairProducts((Lanes)(a & 0xffff), (Lanes)b); }

/// a * b + c * d of each lane, all within 16 bits; the caller knows that it fits 32 bits.
inline Integers shortProducts(Integers a, Integers b, Integers c, Integers d) {
  return pairProducts((Lanes)((a & 0xffff) | (c << 16)), (Lanes)((b & 0xffff) | (d << 16)));
}

/// One lane everywhere, of 16-bit ones; its value fits them.
template <int kLane>
Lanes splatLane(Integers v) {
  const Integers lane = __builtin_shufflevector(v, v, kLane, kLane, kLane, kLane);
  return packed(lane, lane);
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

/// Half octaves of the magnitude of 2^28 at most: 0, 1, 2, 3, 4 (for 4 and 5), 5 (6 and 7), 6 (8 to 11), ...
inline Integers halfOctaves(Integers magnitude) {
  // The exponent and the first bit of the fraction of 2x + 1. Where that is rounded, the result is 46 or more.
  const Floats odd = __builtin_convertvector(2 * magnitude + 1, Floats);
  const Integers bits = ((Integers)odd >> 22) - 256;
  return bits & ~(bits >> 31);
}

/// Products of all lanes, in full.
struct WideLanes {
  Integers low;
  Integers high;
};
inline WideLanes multiplyWide(Lanes a, Lanes b) {
#if defined(__SSE2__)
  const __m128i low = _mm_mullo_epi16((__m128i)a, (__m128i)b);
  const __m128i high = _mm_mulhi_epi16((__m128i)a, (__m128i)b);
  return {(Integers)_mm_unpacklo_epi16(low, high), (Integers)_mm_unpackhi_epi16(low, high)};
#else
  WideLanes product;
  for (int i = 0; i < 4; ++i) {
    product.low[i] = a[i] * b[i];
    product.high[i] = a[i + 4] * b[i + 4];
  }
  return product;
#endif
}

inline Integers loadIntegers(const std::int32_t* from) {
  Integers integers;
  std::memcpy(&integers, from, sizeof integers);
  return integers;
}
inline void storeIntegers(std::int32_t* to, Integers integers) { std::memcpy(to, &integers, sizeof integers); }

/// Two doubles, for integers below 2^53, which they carry exactly.
using Doubles [[gnu::vector_size(16)]] = double;

/// The first two of four integers.
inline Doubles firstTwo(Integers v) {
#if defined(__SSE2__)
  return (Doubles)_mm_cvtepi32_pd((__m128i)v);
#else
  return Doubles{static_cast<double>(v[0]), static_cast<double>(v[1])};
#endif
}
inline Doubles lastTwo(Integers v) { return firstTwo(__builtin_shufflevector(v, v, 2, 3, 2, 3)); }

inline Doubles loadDoubles(const double* from) {
  Doubles doubles;
  std::memcpy(&doubles, from, sizeof doubles);
  return doubles;
}

inline void storeDoubles(double* to, Doubles doubles) { std::memcpy(to, &doubles, sizeof doubles); }

/// Of 16 lanes, ascending from lane 1 on, the first one after lane 0 that is above `value`; 16 if there is none.
inline std::uint32_t firstAbove(Lanes low, Lanes high, std::int16_t value) {
  const Lanes bound = splat(value);
#if defined(__SSE2__)
  const __m128i above = _mm_packs_epi16((__m128i)greater(low, bound), (__m128i)greater(high, bound));
  return static_cast<std::uint32_t>(
      std::countr_zero((static_cast<unsigned>(_mm_movemask_epi8(above)) | 0x10000u) & ~1u));
#else
  low[0] = value;
  const Lanes above = greater(low, bound) + greater(high, bound);
  int first = 16;
  for (int i = 0; i < 8; ++i) first += above[i];
  return static_cast<std::uint32_t>(first);
#endif
}

/// Four vectors as lanes x, y, z: lane j is of vector j.
struct Transposed {
  Integers x, y, z;
};
inline Transposed transposed(Integers a, Integers b, Integers c, Integers d) {
  const Integers ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const Integers ab_z = __builtin_shufflevector(a, b, 2, 6, 3, 7), cd_z = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  return {__builtin_shufflevector(ab, cd, 0, 1, 4, 5), __builtin_shufflevector(ab, cd, 2, 3, 6, 7),
          __builtin_shufflevector(ab_z, cd_z, 0, 1, 4, 5)};
}

/// (a * b) >> 32 of each lane, read as unsigned.
inline Integers wordProductsHigh(Integers a, std::uint32_t b) {
#if defined(__SSE2__)
  const __m128i factor = _mm_set1_epi32(static_cast<int>(b));
  const __m128i even = _mm_srli_epi64(_mm_mul_epu32((__m128i)a, factor), 32);
  const __m128i odd = _mm_mul_epu32(_mm_srli_epi64((__m128i)a, 32), factor);
  return (Integers)even | ((Integers)odd & Integers{0, -1, 0, -1});
#else
  Integers high;
  for (int i = 0; i < 4; ++i)
    high[i] = static_cast<std::int32_t>(std::uint64_t{static_cast<std::uint32_t>(a[i])} * b >> 32);
  return high;
#endif
}

/// Bit i is the sign of lane i.
inline unsigned signBits(Integers v) {
#if defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_ps((__m128)v));
#else
  unsigned bits = 0;
  for (int i = 0; i < 4; ++i) bits |= (static_cast<std::uint32_t>(v[i]) >> 31) << i;
  return bits;
#endif
}

/// Square roots.
inline Doubles roots(Doubles v) {
#if defined(__SSE2__)
  return (Doubles)_mm_sqrt_pd((__m128d)v);
#else
  return Doubles{std::sqrt(v[0]), std::sqrt(v[1])};
#endif
}

}  // namespace tsc
