/*
** visible.h - mirrors by the visible normals of GGX microfacets, in lanes. For *.isa.c.
**
** A mirrored direction that would lie below the surface is mirrored in it. No sample is lost so, and the density of a
** direction is the sum of two: its own and its image's. The density integrates to 1.
**
** Sources  Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs";
**          Heitz 2018, "Sampling the GGX Distribution of Visible Normals"; spherical caps: Dupuy &
**          Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps"
*/
#ifndef YLM_MATERIAL_VISIBLE_H
#define YLM_MATERIAL_VISIBLE_H

#include "lanes.h"

/* cos (1 + 2 Lambda) of a direction: sqrt(z^2 + ax^2 x^2 + ay^2 y^2). */
YLM_INLINE lane visible_root(float ax, float ay, const lane w[3]) {
  lane x = w[0] * ax, y = w[1] * ay;
  return ylm_vf_sqrt(w[2] * w[2] + x * x + y * y);
}

/* D of the normal along h, and |h|^2. */
YLM_INLINE lane visible_ndf(float ax, float ay, lane hx, lane hy, lane hz, lane *square) {
  lane x2 = hx * hx, y2 = hy * hy, z2 = hz * hz, l2 = x2 + y2 + z2;
  lane e = x2 * (1 / (ax * ax)) + y2 * (1 / (ay * ay)) + z2, q = l2 / lane_max(e, lane_of(1e-30f));
  *square = l2;
  return q * q * (1 / ((float)YLM_PI * ax * ay));
}

/* The density of wi, sr^-1, both directions above the surface; D and |wi + wo|^2 besides. */
YLM_INLINE lane visible_pdf(float ax, float ay, const lane wi[3], const lane wo[3], lane root,
                            lane *ndf, lane *square) {
  lane hx = wi[0] + wo[0], hy = wi[1] + wo[1], gz = wo[2] - wi[2], image;
  *ndf = visible_ndf(ax, ay, hx, hy, wi[2] + wo[2], square);
  lane folded = visible_ndf(ax, ay, hx, hy, gz, &image);
  folded = lane_if((gz > 0) & (image > 1e-7f), folded);
  return (*ndf + folded) / (2 * (wo[2] + root));
}

/* The direction for two numbers. */
YLM_INLINE void visible_sample(float ax, float ay, const lane wo[3], lane u0, lane u1, lane wi[3]) {
  lane v[3] = {wo[0] * ax, wo[1] * ay, wo[2]}, s, c;
  lane scale = 1 / ylm_vf_sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  for (int a = 0; a < 3; a++) v[a] *= scale;
  lane_turn(u0, &s, &c);
  lane h = (1 - u1) * (1 + v[2]), z = h - v[2];
  lane r = ylm_vf_sqrt(lane_max(1 - z * z, lane_of(0)));
  lane m[3] = {(r * c + v[0]) * ax, (r * s + v[1]) * ay, h};
  lane up = m[0] * wo[0] + m[1] * wo[1] + m[2] * wo[2];
  lane d = 2 * up / (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
  for (int a = 0; a < 3; a++) wi[a] = d * m[a] - wo[a];
  wi[2] = lane_max(wi[2], -wi[2]);
}

#endif
