/* rotate_reference.c - blocks of rotations by the recurrence of Ivanic & Ruedenberg. */
#include "ylm_sh.h"

#include <math.h>

typedef long double real;

/* P of Ivanic & Ruedenberg for element (a, b); r1: degree 1 [3][3]; before: degree l-1. */
static real combine(int i, int a, int b, int l, const real *r1, const real *before) {
  const real *row = before + (size_t)(a + l - 1) * (size_t)(2 * l - 1) + (l - 1);
  const real *r = r1 + (i + 1) * 3 + 1;
  if (b == l) return r[1] * row[l - 1] - r[-1] * row[-l + 1];
  if (b == -l) return r[1] * row[-l + 1] + r[-1] * row[l - 1];
  return r[0] * row[b];
}

/* Element (m, n) of degree l from degrees 1 and l-1. */
static real element(int l, int m, int n, const real *r1, const real *before) {
  int am = m < 0 ? -m : m;
  real d = n == l || n == -l ? (real)(2 * l) * (2 * l - 1) : (real)(l + n) * (l - n), sum = 0;
  real u = sqrtl((real)(l + m) * (l - m) / d);
  real v = 0.5L * sqrtl((m == 0 ? 2 : 1) * (real)(l + am - 1) * (l + am) / d) * (m == 0 ? -1 : 1);
  real w = m == 0 ? 0 : -0.5L * sqrtl((real)(l - am - 1) * (l - am) / d);
  if (u != 0) sum += u * combine(0, m, n, l, r1, before);
  if (m == 0)
    sum += v * (combine(1, 1, n, l, r1, before) + combine(-1, -1, n, l, r1, before));
  else if (m == 1)
    sum += v * combine(1, 0, n, l, r1, before) * sqrtl(2);
  else if (m == -1)
    sum += v * combine(-1, 0, n, l, r1, before) * sqrtl(2);
  else if (m > 0)
    sum += v * (combine(1, m - 1, n, l, r1, before) - combine(-1, -m + 1, n, l, r1, before));
  else
    sum += v * (combine(1, m + 1, n, l, r1, before) + combine(-1, -m - 1, n, l, r1, before));
  if (w != 0) {
    if (m > 0)
      sum += w * (combine(1, m + 1, n, l, r1, before) + combine(-1, -m - 1, n, l, r1, before));
    else
      sum += w * (combine(1, m - 1, n, l, r1, before) - combine(-1, -m + 1, n, l, r1, before));
  }
  return sum;
}

ylm_status ylm_sh_rotation_reference(const double r[9], int lmax, double *blocks) {
  if (lmax < 0 || lmax > YLM_SH_ROTATE_LMAX) return YLM_ERANGE;
  size_t widest = (size_t)(2 * lmax + 1) * (size_t)(2 * lmax + 1);
  real *now = ylm_alloc(2 * widest, sizeof *now), *before = now ? now + widest : NULL, r1[9];
  if (!now) return YLM_ENOMEM;
  real *memory = now;
  /* y z x, with the signs of the Condon-Shortley phase */
  static const int axis[3] = {1, 2, 0}, sign[3] = {-1, 1, -1};
  for (int m = 0; m < 3; m++)
    for (int n = 0; n < 3; n++) r1[m * 3 + n] = sign[m] * sign[n] * (real)r[axis[m] * 3 + axis[n]];
  *blocks++ = 1;
  for (int l = 1; l <= lmax; l++) {
    int n = 2 * l + 1;
    for (int i = 0; i < n * n; i++) {
      now[i] = l == 1 ? r1[i] : element(l, i / n - l, i % n - l, r1, before);
      *blocks++ = (double)now[i];
    }
    real *swap = before;
    before = now;
    now = swap;
  }
  ylm_free(memory);
  return YLM_OK;
}
