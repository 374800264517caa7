/*
** lobe.h - directions as the cosine, mixed with mirrors by the visible normals of GGX: a density for
** materials that are tables. visible.h has the same mirrors in lanes. Private to csrc/material.
**
** Source  Heitz 2018, "Sampling the GGX Distribution of Visible Normals"; spherical caps: Dupuy &
**         Benyoub 2023
*/
#ifndef YLM_MATERIAL_LOBE_H
#define YLM_MATERIAL_LOBE_H

#include <math.h>

#include "ylm_base.h"

typedef struct lobe {
  float alpha; /* roughness of the mirrors */
  float share; /* of directions that they get */
} lobe;

/* D of GGX along a vector. */
static inline float ylm__lobe_ndf(float alpha, float x, float y, float z) {
  float a2 = alpha * alpha, flat = x * x + y * y, s = (flat + z * z) / (flat / a2 + z * z);
  return s * s / ((float)YLM_PI * a2);
}

/* The density of directions, sr^-1, of pairs above the surface. Mirrored directions below the surface
   are mirrored in it (visible.h), so that a direction has its own density and its image's. */
static inline float ylm__lobe_pdf(lobe l, const float wi[3], const float wo[3]) {
  float x = wi[0] + wo[0], y = wi[1] + wo[1], image = wo[2] - wi[2], a2 = l.alpha * l.alpha;
  float d = ylm__lobe_ndf(l.alpha, x, y, wi[2] + wo[2]);
  if (image > 0 && x * x + y * y + image * image > 1e-7f) d += ylm__lobe_ndf(l.alpha, x, y, image);
  /* 4 cos (1 + Lambda) = 2 (cos + sqrt(cos^2 + alpha^2 sin^2)) */
  float root = sqrtf(wo[2] * wo[2] + a2 * (wo[0] * wo[0] + wo[1] * wo[1]));
  return l.share * d / (2 * (wo[2] + root)) + (1 - l.share) * wi[2] * (1 / (float)YLM_PI);
}

/* A direction of that density for numbers u in 0 .. 1. */
static inline void ylm__lobe_sample(lobe l, const float wo[3], const float u[3], float wi[3]) {
  float c = cosf(2 * (float)YLM_PI * u[1]), s = sinf(2 * (float)YLM_PI * u[1]);
  if (u[2] >= l.share) {
    float r = sqrtf(u[0]);
    wi[0] = r * c;
    wi[1] = r * s;
    wi[2] = sqrtf(1 - u[0]);
    return;
  }
  float w[3] = {l.alpha * wo[0], l.alpha * wo[1], wo[2]}, h[3];
  float length = sqrtf(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  for (int a = 0; a < 3; a++) w[a] /= length;
  float z = (1 - u[0]) * (1 + w[2]) - w[2], r = sqrtf(1 - z * z > 0 ? 1 - z * z : 0);
  h[0] = l.alpha * (r * c + w[0]);
  h[1] = l.alpha * (r * s + w[1]);
  h[2] = z + w[2] > 0 ? z + w[2] : 0;
  float dot = h[0] * wo[0] + h[1] * wo[1] + h[2] * wo[2];
  float scale = 2 * dot / (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
  for (int a = 0; a < 3; a++) wi[a] = scale * h[a] - wo[a];
  wi[2] = fabsf(wi[2]);
}

#endif
