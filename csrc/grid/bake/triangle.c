/*
** triangle.c - triangles against boxes of voxels, by separating axes (Akenine-Moeller 2001).
**
** A convex body is apart from another where some axis separates their shadows; of a triangle and a
** box 13 axes decide: the box's own, the triangle's normal, and each edge of the one crossed with
** each of the other. An axis separates only by more than the margin and what rounding may have
** done, so that a box which is met is never missed; a number that overflowed separates nothing.
*/
#include "surface.h"

#include <float.h>

#define ROUNDINGS 32 /* of a shadow, in halves of DBL_EPSILON relative to what was summed */

static void subtract(const double a[3], const double b[3], double out[3]) {
  for (int k = 0; k < 3; k++) out[k] = a[k] - b[k];
}

/* Shadows of the triangle on axis k; `size` bounds what its components are differences of. */
static void set_axis(triangle *t, int k, const double p[3][3], const double size[3],
                     const double margin[3]) {
  double wide = 0, least = 0, most = 0;
  for (int i = 1; i < 3; i++) {
    double shadow = 0;
    for (int a = 0; a < 3; a++) shadow += t->axis[k][a] * (p[i][a] - p[0][a]);
    if (shadow < least) least = shadow;
    if (shadow > most) most = shadow;
    if (isnan(shadow)) least = most = NAN;
  }
  for (int a = 0; a < 3; a++) {
    double span = t->hi[a] - t->lo[a] + 2; /* no centre of a box is further away */
    wide += fabs(t->axis[k][a]) * margin[a] + ROUNDINGS * DBL_EPSILON / 2 * size[a] * span;
  }
  t->least[k] = least - wide;
  t->most[k] = most + wide;
}

void ylm__triangle_set(triangle *t, const double p[3][3], const double margin[3]) {
  double edge[3][3], size[3];
  for (int i = 0; i < 3; i++) subtract(p[(i + 1) % 3], p[i], edge[i]);
  for (int a = 0; a < 3; a++) {
    t->from[a] = p[0][a];
    t->lo[a] = fmin(fmin(p[0][a], p[1][a]), p[2][a]) - margin[a];
    t->hi[a] = fmax(fmax(p[0][a], p[1][a]), p[2][a]) + margin[a];
  }
  for (int a = 0; a < 3; a++) {
    int b = (a + 1) % 3, c = (a + 2) % 3;
    double x = edge[0][b] * edge[1][c], y = edge[0][c] * edge[1][b];
    t->axis[0][a] = x - y;
    size[a] = fabs(x) + fabs(y);
  }
  set_axis(t, 0, p, size, margin);
  for (int i = 0; i < 9; i++) {
    int a = i % 3, b = (a + 1) % 3, c = (a + 2) % 3;
    double *axis = t->axis[1 + i];
    axis[a] = size[a] = 0;
    axis[b] = -edge[i / 3][c];
    axis[c] = edge[i / 3][b];
    size[b] = fabs(axis[b]);
    size[c] = fabs(axis[c]);
    set_axis(t, 1 + i, p, size, margin);
  }
}

bool ylm__triangle_range(const triangle *t, int a, uint32_t voxels, uint32_t *first,
                         uint32_t *last) {
  double lo = ceil(t->lo[a]) - 1, hi = floor(t->hi[a]); /* faces count */
  if (lo > (double)voxels - 1 || hi < 0) return false;
  *first = lo > 0 ? (uint32_t)lo : 0;
  *last = hi < (double)voxels - 1 ? (uint32_t)hi : voxels - 1;
  return true;
}

bool ylm__triangle_meets(const triangle *t, const uint32_t first[3], const uint32_t last[3]) {
  double from[3], half[3]; /* from the triangle's vertex to the centre; half of the edges */
  for (int a = 0; a < 3; a++) {
    half[a] = 0.5 * ((double)last[a] - (double)first[a] + 1);
    from[a] = (double)first[a] + half[a] - t->from[a];
  }
  for (int k = 0; k < TRIANGLE_AXES; k++) {
    const double *m = t->axis[k];
    double at = m[0] * from[0] + m[1] * from[1] + m[2] * from[2];
    double reach = fabs(m[0]) * half[0] + fabs(m[1]) * half[1] + fabs(m[2]) * half[2];
    if (at + reach < t->least[k] || at - reach > t->most[k]) return false;
  }
  return true;
}
