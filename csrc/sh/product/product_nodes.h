/*
** product_nodes.h - the two halves of a batch, for the unit's element type: LANES rows to their values at all nodes of
** a rule, and back.
**
**   value   [half][azimuths / 4][above, below the equator][phi, -phi, pi - phi, pi + phi][LANES]
*/
#ifndef YLM_SH_PRODUCT_NODES_H
#define YLM_SH_PRODUCT_NODES_H

#include "product_batch.h"

/* N nodes from h on. */
YLM_INLINE void nodes_forward(const int N, const ylm_sh_product *p, int h, const real *in,
                              bool multiply, real *value, real *x) {
  const ylm__product_tables *t = &p->TABLES;
  const real *legendre = (const real *)t->legendre + h, *cosines = t->cosines, *sines = t->sines;
  int lmax = p->lmax, ring = (2 * lmax + 1) * LANES, quadrants = p->azimuths / 4;
  batch_orders(N, lmax, legendre, t->half_padded, in, x, ring);
  for (int i = 0; i < N; i++) {
    const real *from = x + i * 2 * ring + lmax * LANES;
    real *to = value + (size_t)(h + i) * 8 * (size_t)quadrants * LANES;
    int j = 0;
    for (; j + BATCH_AZIMUTHS <= quadrants; j += BATCH_AZIMUTHS)
      batch_points(BATCH_AZIMUTHS, lmax, cosines + j * (lmax + 1), sines + j * (lmax + 1), from,
                   ring, to + j * 8 * LANES, multiply);
    for (; j < quadrants; j++)
      batch_points(1, lmax, cosines + j * (lmax + 1), sines + j * (lmax + 1), from, ring,
                   to + j * 8 * LANES, multiply);
  }
}

static void synthesise(const ylm_sh_product *p, const real *const *rows, bool multiply, real *value,
                       real *scratch) {
  int count = (int)ylm_sh_count(p->lmax), h = 0;
  real *in = scratch, *x = in + (size_t)count * LANES;
  to_tile(rows, 0, count, in, LANES);
  for (; h + BATCH_NODES <= p->half; h += BATCH_NODES)
    nodes_forward(BATCH_NODES, p, h, in, multiply, value, x);
  switch (p->half - h) {
  case 3: nodes_forward(3, p, h, in, multiply, value, x); break;
  case 2: nodes_forward(2, p, h, in, multiply, value, x); break;
  case 1: nodes_forward(1, p, h, in, multiply, value, x); break;
  }
}

/* Values at n times four mirror images, times `by` where it is not NULL, to even and odd cosines, even and odd sines. */
YLM_INLINE void nodes_unfold(int n, const real *value, const real *by, real *to) {
  for (int i = 0; i < n; i++, value += 4 * LANES, to += 4 * LANES) {
    vreal v[4];
    for (int q = 0; q < 4; q++) v[q] = vreal_load(value + q * LANES);
    for (int q = 0; by && q < 4; q++) v[q] *= vreal_set(by[4 * i + q]);
    vreal a = v[0] + v[1], b = v[0] - v[1], d = v[2] + v[3], g = v[2] - v[3];
    vreal_store(to, a + d);
    vreal_store(to + LANES, a - d);
    vreal_store(to + 2 * LANES, b - g);
    vreal_store(to + 3 * LANES, b + g);
  }
}

/* Adds what N nodes from h on give; `parts` is room for the values of one. */
YLM_INLINE void nodes_back(const int N, const ylm_sh_product *p, int h, const real *value,
                           const real *by, real *sum, real *rings, real *parts) {
  const ylm__product_tables *t = &p->TABLES;
  const real *legendre = (const real *)t->legendre + h, *cosines = t->cosines, *sines = t->sines;
  int lmax = p->lmax, ring = (2 * lmax + 1) * LANES, quadrants = p->azimuths / 4;
  for (int i = 0; i < N; i++) {
    real *x = rings + i * 2 * ring + lmax * LANES;
    size_t first = (size_t)(h + i) * 8 * (size_t)quadrants;
    nodes_unfold(2 * quadrants, value + first * LANES, by ? by + first : NULL, parts);
    real weight = ((const real *)t->node_weights)[h + i];
    for (int parity = 0; parity < 2; parity++) {
      int m = parity;
      for (; m + 2 * (BATCH_ORDERS - 1) <= lmax; m += 2 * BATCH_ORDERS)
        batch_back(BATCH_ORDERS, lmax, quadrants, m, cosines, sines, parts, weight, x, ring);
      for (; m <= lmax; m += 2)
        batch_back(1, lmax, quadrants, m, cosines, sines, parts, weight, x, ring);
    }
  }
  batch_sum(N, lmax, legendre, t->half_padded, rings, ring, sum);
}

static void analyse(const ylm_sh_product *p, const real *value, const real *by, real *const *out,
                    real *scratch) {
  size_t count = ylm_sh_count(p->lmax);
  int h = 0;
  real *sum = scratch, *x = sum + count * LANES, *parts = x + 8 * (2 * (size_t)p->lmax + 1) * LANES;
  memset(sum, 0, count * LANES * sizeof(real));
  for (; h + BATCH_NODES <= p->half; h += BATCH_NODES)
    nodes_back(BATCH_NODES, p, h, value, by, sum, x, parts);
  switch (p->half - h) {
  case 3: nodes_back(3, p, h, value, by, sum, x, parts); break;
  case 2: nodes_back(2, p, h, value, by, sum, x, parts); break;
  case 1: nodes_back(1, p, h, value, by, sum, x, parts); break;
  }
  from_tile(sum, LANES, (int)count, 0, out);
}

#endif
