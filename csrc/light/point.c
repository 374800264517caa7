/* point.c - lights of no size as rays meet them. */
#include "point.h"

#include <math.h>
#include <string.h>

#include "ylm_math.h"

#define SOLID 1e-12 /* sr */
#define MOST 1e36   /* of a radiance, whose sums are floats */

/* The way to the light, of length 1, its length, and the part that comes along it, over its square. */
static double look(const double *x, const double at[3], ylm__point_along *along,
                   const double from[3], double v[3], double *distance) {
  double d2 = 0, away[3];
  for (int a = 0; a < 3; a++) {
    v[a] = at[a] - from[a];
    d2 += v[a] * v[a];
  }
  *distance = sqrt(d2);
  if (!(d2 > 0)) return 0;
  for (int a = 0; a < 3; a++) v[a] /= *distance, away[a] = -v[a];
  return along(x, away) / d2;
}

double ylm__point_weight(const double *x, const double at[3], ylm__point_along *along,
                         const double from[3], const float *n) {
  double v[3], d, part = look(x, at, along, from, v, &d);
  double facing = n ? fmax(0, v[0] * (double)n[0] + v[1] * (double)n[1] + v[2] * (double)n[2]) : 1;
  return fmin(part * facing * ylm_luminance_size(x), MOST);
}

bool ylm__point_toward(const double *x, const double at[3], ylm__point_along *along,
                       const double from[3], ylm_light_way *out) {
  double part = look(x, at, along, from, out->to, &out->distance);
  out->solid = SOLID;
  memcpy(out->at, at, sizeof out->at);
  for (int c = 0; c < 3; c++) out->radiance[c] = fmin(fmax(x[c] * part / SOLID, -MOST), MOST);
  return part > 0;
}
