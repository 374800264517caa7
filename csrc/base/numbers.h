/* numbers.h - numbers of any element type, one at a time. Private to csrc/base. */
#ifndef YLM_BASE_NUMBERS_H
#define YLM_BASE_NUMBERS_H

#include "ylm_numbers.h"

/* A float16 (IEEE 754 binary16) as a float. */
static inline float ylm__half_get(uint16_t h) {
  uint32_t sign = (uint32_t)(h & 0x8000) << 16, exponent = (h >> 10) & 31, bits = h & 0x3ff;
  float x = (float)bits * 0x1p-24f; /* what a zero exponent means */
  uint32_t small;
  memcpy(&small, &x, 4);
  bits = exponent == 0    ? small
         : exponent == 31 ? 0x7f800000u | bits << 13
                          : (exponent + 112) << 23 | bits << 13;
  bits |= sign;
  memcpy(&x, &bits, 4);
  return x;
}

/* The nearest float16; infinite from 65520 on. */
static inline uint16_t ylm__half_put(float x) {
  uint32_t bits;
  memcpy(&bits, &x, 4);
  uint16_t sign = (uint16_t)(bits >> 16 & 0x8000);
  bits &= 0x7fffffff;
  if (bits > 0x7f800000) return (uint16_t)(sign | 0x7e00 | (bits >> 13 & 0x3ff));
  if (bits >= 0x477ff000) return sign | 0x7c00;
  if (bits < 0x38800000) { /* below 2^-14: a multiple of 2^-24, which the sum rounds to */
    float y = 0;
    memcpy(&y, &bits, 4);
    y += 0.5f;
    memcpy(&bits, &y, 4);
    return (uint16_t)(sign | (bits - 0x3f000000));
  }
  bits += 0xfff + (bits >> 13 & 1);
  return (uint16_t)(sign | ((bits - 0x38000000) >> 13));
}

/* A float whose rounding to fewer bits is that of x: what x loses is kept in the last bit. */
static inline float ylm__half_sticky(double x) {
  float y = (float)x;
  if ((double)y == x || x != x || y - y != 0) return y;
  uint32_t bits;
  memcpy(&bits, &y, 4);
  bits -= __builtin_fabs((double)y) > __builtin_fabs(x);
  bits |= 1;
  memcpy(&y, &bits, 4);
  return y;
}

#endif
