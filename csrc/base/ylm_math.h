/*
** ylm_math.h - numbers that stand once: pi, the weights of luminance, a mixer of bits.
*/
#ifndef YLM_MATH_H
#define YLM_MATH_H

#include <math.h>
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

#endif
