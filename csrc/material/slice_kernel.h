/*
** slice_kernel.h - the inner loops of slices, for the unit that includes it: SLICE_WIDE half planes at a time, which
** stand behind one another in lanes of doubles.
**
** slice.c has them for processors without vectors, slice.isa.c once per instruction set.
*/
#ifndef YLM_MATERIAL_SLICE_KERNEL_H
#define YLM_MATERIAL_SLICE_KERNEL_H

#include <string.h>

#include "slice.h"

/* A number of each half plane. */
typedef double wide __attribute__((vector_size(8 * SLICE_WIDE), aligned(8), may_alias));

#define AT(p, i) (*(const wide *)((p) + (i)*SLICE_WIDE))
#define TO(p, i) (*(wide *)((p) + (i)*SLICE_WIDE))

/* The nodes of half planes: directions, and their places and weights in the mirror direction's frame. */
static void slice_places(const slice_planes *p, slice_nodes *out) {
  const wide end = AT(p->end, 0), cp = AT(p->cos_phi, 0), sp = AT(p->sin_phi, 0);
  for (int i = 0; i < p->nodes; i++) {
    /* sine and cosine of an eighth of the angle, which is below pi, by their series; doubled thrice */
    wide t = end * (p->part[i] / 8), q = t * t;
    wide s = t * (1 - q / 6 * (1 - q / 20 * (1 - q / 42 * (1 - q / 72 * (1 - q / 110)))));
    wide c = 1 - q / 2 * (1 - q / 12 * (1 - q / 30 * (1 - q / 56 * (1 - q / 90 * (1 - q / 132)))));
    for (int k = 0; k < 3; k++) {
      wide twice = 2 * s * c;
      c = 1 - 2 * s * s;
      s = twice;
    }
    wide along = s * cp, side = s * sp;
    wide x = along * p->cosine - c * p->sine, z = along * p->sine + c * p->cosine;
    wide wx = p->turn[0] * x - p->turn[1] * side, wy = p->turn[1] * x + p->turn[0] * side;
    TO(out->x, i) = c;
    TO(out->s, i) = s;
    TO(out->z, i) = z;
    TO(out->measure, i) = s * end * p->weight[i];
    for (int k = 0; k < SLICE_WIDE; k++) {
      float *wi = out->wi[i * SLICE_WIDE + k];
      wi[0] = (float)wx[k], wi[1] = (float)wy[k], wi[2] = (float)z[k];
    }
  }
}

/* Adds to sum [3][(lmax+1)(lmax+2)/2][SLICE_WIDE], by order, then degree, what values at n nodes give:
   f [3][n][SLICE_WIDE]. */
static void slice_sums(const slice_recurrence *r, int n, const double *x, const double *s,
                       const double *f, double *sum) {
  const int lmax = r->lmax, entries = (lmax + 1) * (lmax + 2) / 2;
  for (int i = 0; i < n; i++) {
    const wide xi = AT(x, i), si = AT(s, i);
    const wide f0 = AT(f, i), f1 = AT(f, n + i), f2 = AT(f, 2 * n + i);
    wide power = xi * 0 + 1;
    for (int m = 0, k = 0; m <= lmax; m++) {
      wide before = xi * 0, p = power * r->first[m];
      for (int l = m;; l++, k++) {
        TO(sum, k) += f0 * p;
        TO(sum, entries + k) += f1 * p;
        TO(sum, 2 * entries + k) += f2 * p;
        if (l == lmax) break;
        wide next = r->a[k] * xi * p - r->b[k] * before;
        before = p;
        p = next;
      }
      k++;
      power *= si;
    }
  }
}

#undef AT
#undef TO

#endif
