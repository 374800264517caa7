/*
** ylm_math.h - numbers and functions that stand once: pi, the weights of luminance, a mixer of bits, Morton codes, a search.
*/
#ifndef YLM_MATH_H
#define YLM_MATH_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#define YLM_PI 3.14159265358979323846

/* Weights of linear Rec. 709 red, green and blue in luminance. In Lua: core.luminance; in the page's sources:
   LUMINANCE_R, _G, _B, which lua/ylm/page/viewer.lua fills in. */
#define YLM_LUMINANCE_R 0.2126
#define YLM_LUMINANCE_G 0.7152
#define YLM_LUMINANCE_B 0.0722

static inline double ylm_luminance(const double rgb[3]) {
  return YLM_LUMINANCE_R * rgb[0] + YLM_LUMINANCE_G * rgb[1] + YLM_LUMINANCE_B * rgb[2];
}
/* Of absolute values: how much a light counts whose radiance may be negative. */
static inline double ylm_luminance_size(const double rgb[3]) {
  return YLM_LUMINANCE_R * fabs(rgb[0]) + YLM_LUMINANCE_G * fabs(rgb[1]) +
         YLM_LUMINANCE_B * fabs(rgb[2]);
}

/* All bits of x in each bit: the finaliser of SplitMix64.
   Source: Steele, Lea & Flood 2014, "Fast Splittable Pseudorandom Number Generators". */
static inline uint64_t ylm_mix64(uint64_t x) {
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

/* The low 21 bits of x, two places apart. */
static inline uint64_t ylm_spread3(uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

/* The Morton code of 21 bits of each coordinate, interleaved, those of x lowest. */
static inline uint64_t ylm_morton(uint64_t x, uint64_t y, uint64_t z) {
  return ylm_spread3(x) | ylm_spread3(y) << 1 | ylm_spread3(z) << 2;
}

/* How many of n increasing numbers are not above `at`. */
static inline size_t ylm_count_upto(size_t n, const double *x, double at) {
  size_t low = 0, high = n;
  while (low < high) {
    size_t middle = low + (high - low) / 2;
    if (x[middle] > at)
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

/* The interval that `at` of 0 .. upto[n-1] chooses, of n sums: the first sum above it, or the last. */
static inline size_t ylm_interval_at(size_t n, const double *upto, double at) {
  return ylm_count_upto(n - 1, upto, at);
}

#endif
