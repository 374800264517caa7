/* angle.h - the angle of a vector in the plane, without a call. Private to csrc/material. */
#ifndef YLM_MATERIAL_ANGLE_H
#define YLM_MATERIAL_ANGLE_H

#include "ylm_math.h"

/* The angle of (x, y), -pi .. pi, to 2e-7; 0 where both are 0. Abramowitz & Stegun 1964, 4.4.49. */
static inline float ylm__angle(float y, float x) {
  float ax = fabsf(x), ay = fabsf(y), large = ax > ay ? ax : ay, small = ax > ay ? ay : ax;
  float t = small / (large > 1e-37f ? large : 1e-37f), q = t * t, p = 0.0028662257f;
  p = p * q - 0.0161657367f;
  p = p * q + 0.0429096138f;
  p = p * q - 0.0752896400f;
  p = p * q + 0.1065626393f;
  p = p * q - 0.1420889944f;
  p = p * q + 0.1999355085f;
  p = p * q - 0.3333314528f;
  p = p * q * t + t;
  p = ay > ax ? (float)YLM_PI / 2 - p : p;
  p = x < 0 ? (float)YLM_PI - p : p;
  return y < 0 ? -p : p;
}

#endif
