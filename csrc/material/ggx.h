/*
** ggx.h - surfaces of GGX microfacets, as their kernels want them. Private to csrc/material.
**
**   f = F D / (4 wi.z wo.z (1 + L(wi) + L(wo)))                               Heitz 2014
**     + m (1 - E(wi)) (1 - E(wo))                          what is lost between microfacets
**     + b (1 - Es(wi)) (1 - Es(wo))                                              the base
**
** E = A + B is the albedo of one reflection with F = 1, Es = f0 A + B + K (1 - E) that of all above
** the base; m = K / (pi (1 - Eavg)), b = base / (pi (1 - Esavg)), K = Favg^2 Eavg / (1 - Favg (1 -
** Eavg)), Favg = f0 + (1 - f0) / 21. Averages are over the cosine.
**
** Sources  Kulla & Conty 2017, "Revisiting Physically Based Shading at Imageworks"; K with Favg^2:
**          Hill 2018, "A Multi-Faceted Exploration (Part 3)"
*/
#ifndef YLM_MATERIAL_GGX_H
#define YLM_MATERIAL_GGX_H

#include <stdbool.h>
#include <stdint.h>

#include "calibration.h"

/* gen/albedo.c: { A, B } over sqrt(alpha), from sqrt(YLM__ALBEDO_LEAST) to 1, and sqrt(cosine), from
   0 to 1; both even. */
#define YLM__ALBEDO_KNOTS 64
#define YLM__ALBEDO_LEAST 1e-3
extern const float ylm__material_albedo[YLM__ALBEDO_KNOTS][YLM__ALBEDO_KNOTS][2];

typedef struct ggx {
  float ax, ay, f0[3];
  bool plain;                    /* nothing but the first term: the curve is not asked */
  float lost[3];                 /* m */
  float base[3];                 /* b */
  float K[3], colour[3];         /* K; base as it was given */
  uint32_t curve[GGX_CURVE + 2]; /* A + 65536 B, in 65535ths; one more repeats the last */
} ggx;

#endif
