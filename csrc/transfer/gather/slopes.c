/*
** slopes.c - derivatives of spherical harmonics by the harmonics of neighbouring degrees.
**
** s_b Y_l = P + M, P of degree l + 1 and M of degree l - 1. The gradient of Y along the sphere is
** -l P + (l + 1) M. The reason: the gradient of r^l Y_l has no part of degree l + 1, that of Y_l /
** r^(l+1) none of degree l - 1. Hence
**
**   (grad Y - 3 s Y)_b = -(l + 3) P_b + (l - 2) M_b
**
** and sums over Y up to lmax + 1 give those of the gradients too.
*/
#include <stdlib.h>

#include "gather.h"

/* The integral of Y_kp s_a Y_(k+1)m over the sphere: docs/math.md, "Many sphere lights". */
static double coupling(int a, int k, int p, int m) {
  int p0 = abs(p), m0 = abs(m);
  double d = (2.0 * k + 1) * (2.0 * k + 3), c;
  bool same = (p < 0) == (m < 0);
  if (a == 2) return p == m ? sqrt(((k + 1.0) * (k + 1.0) - (double)m * m) / d) : 0;
  if (same != (a == 0)) return 0;
  if (m0 == p0 + 1)
    c = -0.5 * sqrt((k + p0 + 1.0) * (k + p0 + 2.0) / d) * (p0 == 0 ? sqrt(2) : 1);
  else if (m0 == p0 - 1)
    c = 0.5 * sqrt((k - p0 + 1.0) * (k - p0 + 2.0) / d) * (m0 == 0 ? sqrt(2) : 1);
  else
    return 0;
  if (a == 1 && (m0 > p0) == (p < 0)) c = -c;
  return c;
}

static void add(gather_slopes *s, int axis, size_t of, size_t from, double factor) {
  if (factor == 0) return;
  s->term[s->n++] = (gather_term){(uint32_t)of, (uint32_t)from, factor, axis};
}

ylm_status ylm__gather_slopes_create(int lmax, gather_slopes *s) {
  s->n = 0;
  s->term = ylm_alloc(12 * ylm_sh_count(lmax), sizeof *s->term);
  if (!s->term) return YLM_ENOMEM;
  for (int axis = 0; axis < 3; axis++)
    for (int l = 0; l <= lmax; l++)
      for (int m = -l; m <= l; m++) {
        size_t of = ylm_sh_index(l, m);
        for (int q = -l - 1; q <= l + 1; q++)
          add(s, axis, of, ylm_sh_index(l + 1, q), -(l + 3) * coupling(axis, l, m, q));
        for (int q = 1 - l; q <= l - 1; q++)
          add(s, axis, of, ylm_sh_index(l - 1, q), (l - 2) * coupling(axis, l - 1, q, m));
      }
  return YLM_OK;
}

void ylm__gather_slopes_free(gather_slopes *s) { ylm_free(s->term); }
