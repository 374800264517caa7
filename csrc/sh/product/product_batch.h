/*
** product_batch.h - LANES products at once, for the unit's element type.
**
** Lanes are products; numbers stand in vectors of LANES. By quadrature, a few nodes of the rule at
** a time:
**
**   c [count] -> x [node][above, below the equator][2 lmax + 1] -> values at the azimuths of one
**   node, multiplied -> x -> sum [count]
**
** Sums of a step share what they read, and there are enough of them to keep multiply-adds busy.
*/
#ifndef YLM_SH_PRODUCT_BATCH_H
#define YLM_SH_PRODUCT_BATCH_H

#include "product_one.h"
#include "ylm_transpose.h"

typedef vreal lane __attribute__((may_alias));

#define E lane
#define GAUNT(name) name##_lanes
#include "../gen/gaunt_low.h"
#undef E
#undef GAUNT

/* x of N nodes from coefficients: sums over degrees, even and odd l - m apart. */
YLM_INLINE void batch_orders(const int N, int lmax, const real *legendre, int row, const real *c,
                             real *x, int ring) {
  for (int m = 0; m <= lmax; m++) {
    vreal cosine[2][BATCH_NODES], sine[2][BATCH_NODES];
    for (int parity = 0; parity < 2; parity++) {
      vreal a[BATCH_NODES], b[BATCH_NODES];
      for (int h = 0; h < N; h++) a[h] = b[h] = vreal_set(0);
      for (int l = m + parity; l <= lmax; l += 2, legendre += row) {
        vreal u = vreal_load(c + (l * (l + 1) + m) * LANES),
              v = vreal_load(c + (l * (l + 1) - m) * LANES);
        for (int h = 0; h < N; h++) {
          vreal p = vreal_set(legendre[h]);
          a[h] += p * u;
          b[h] += p * v;
        }
      }
      for (int h = 0; h < N; h++) cosine[parity][h] = a[h], sine[parity][h] = b[h];
    }
    for (int h = 0; h < N; h++) {
      real *at = x + h * 2 * ring + lmax * LANES;
      vreal_store(at - m * LANES, sine[0][h] + sine[1][h]);
      vreal_store(at - m * LANES + ring, sine[0][h] - sine[1][h]);
      vreal_store(at + m * LANES, cosine[0][h] + cosine[1][h]);
      vreal_store(at + m * LANES + ring, cosine[0][h] - cosine[1][h]);
    }
  }
}

/* Values of a node at N azimuths of the first quadrant and their mirror images; x: order 0
   above. */
YLM_INLINE void batch_points(const int N, int lmax, const real *cosines, const real *sines,
                             const real *x, int ring, real *value, bool multiply) {
  vreal ce[2][BATCH_AZIMUTHS], co[2][BATCH_AZIMUTHS], se[2][BATCH_AZIMUTHS], so[2][BATCH_AZIMUTHS];
  for (int side = 0; side < 2; side++)
    for (int j = 0; j < N; j++) {
      ce[side][j] = vreal_load(x + side * ring);
      co[side][j] = se[side][j] = so[side][j] = vreal_set(0);
    }
  for (int m = 1; m <= lmax; m++) {
    for (int side = 0; side < 2; side++) {
      vreal u = vreal_load(x + side * ring + m * LANES),
            v = vreal_load(x + side * ring - m * LANES);
      for (int j = 0; j < N; j++) {
        co[side][j] += u * vreal_set(cosines[j * (lmax + 1) + m]);
        so[side][j] += v * vreal_set(sines[j * (lmax + 1) + m]);
      }
    }
    if (++m > lmax) break;
    for (int side = 0; side < 2; side++) {
      vreal u = vreal_load(x + side * ring + m * LANES),
            v = vreal_load(x + side * ring - m * LANES);
      for (int j = 0; j < N; j++) {
        ce[side][j] += u * vreal_set(cosines[j * (lmax + 1) + m]);
        se[side][j] += v * vreal_set(sines[j * (lmax + 1) + m]);
      }
    }
  }
  for (int j = 0; j < N; j++)
    for (int side = 0; side < 2; side++, value += 4 * LANES) {
      vreal a = ce[side][j] + co[side][j], b = se[side][j] + so[side][j];
      vreal d = ce[side][j] - co[side][j], g = so[side][j] - se[side][j];
      vreal r[4] = {a + b, a - b, d + g, d - g}; /* phi, -phi, pi - phi, pi + phi */
      for (int q = 0; q < 4; q++)
        vreal_store(value + q * LANES, multiply ? vreal_load(value + q * LANES) * r[q] : r[q]);
    }
}

/* Values at four mirror images to even and odd cosines, even and odd sines. */
YLM_INLINE void batch_unfold(int n, real *value) {
  for (int i = 0; i < n; i++, value += 4 * LANES) {
    vreal v0 = vreal_load(value), v1 = vreal_load(value + LANES),
          v2 = vreal_load(value + 2 * LANES), v3 = vreal_load(value + 3 * LANES);
    vreal a = v0 + v1, b = v0 - v1, d = v2 + v3, g = v2 - v3;
    vreal_store(value, a + d);
    vreal_store(value + LANES, a - d);
    vreal_store(value + 2 * LANES, b - g);
    vreal_store(value + 3 * LANES, b + g);
  }
}

/* Orders m, m+2 .. (N of them) of a node from unfolded values, as sum and difference of its two
 * sides. */
YLM_INLINE void batch_back(const int N, int lmax, int quadrants, int m, const real *cosines,
                           const real *sines, const real *value, real weight, real *x, int ring) {
  vreal c[2][BATCH_ORDERS], s[2][BATCH_ORDERS];
  for (int i = 0; i < N; i++) c[0][i] = c[1][i] = s[0][i] = s[1][i] = vreal_set(0);
  value += m & 1 ? LANES : 0;
  for (int j = 0; j < quadrants; j++, value += 8 * LANES, cosines += lmax + 1, sines += lmax + 1) {
    vreal u0 = vreal_load(value), v0 = vreal_load(value + 2 * LANES),
          u1 = vreal_load(value + 4 * LANES), v1 = vreal_load(value + 6 * LANES);
    for (int i = 0; i < N; i++) {
      vreal cosine = vreal_set(cosines[m + 2 * i]), sine = vreal_set(sines[m + 2 * i]);
      c[0][i] += u0 * cosine;
      s[0][i] += v0 * sine;
      c[1][i] += u1 * cosine;
      s[1][i] += v1 * sine;
    }
  }
  vreal w = vreal_set(weight);
  for (int i = 0; i < N; i++) {
    real *at = x - (m + 2 * i) * LANES;
    vreal_store(at, (s[0][i] + s[1][i]) * w);
    vreal_store(at + ring, (s[0][i] - s[1][i]) * w);
    at = x + (m + 2 * i) * LANES;
    vreal_store(at, (c[0][i] + c[1][i]) * w);
    vreal_store(at + ring, (c[0][i] - c[1][i]) * w);
  }
}

/* Adds what N nodes give to the coefficients. */
YLM_INLINE void batch_sum(const int N, int lmax, const real *legendre, int row, const real *x,
                          int ring, real *sum) {
  for (int m = 0; m <= lmax; m++)
    for (int parity = 0; parity < 2; parity++) {
      vreal u[BATCH_NODES], v[BATCH_NODES];
      for (int h = 0; h < N; h++) {
        const real *at = x + (2 * h + parity) * ring + lmax * LANES;
        u[h] = vreal_load(at + m * LANES);
        v[h] = vreal_load(at - m * LANES);
      }
      for (int l = m + parity; l <= lmax; l += 2, legendre += row) {
        real *a = sum + (l * (l + 1) + m) * LANES, *b = sum + (l * (l + 1) - m) * LANES;
        vreal cosine = vreal_load(a), sine = vreal_load(b);
        for (int h = 0; h < N; h++) {
          vreal p = vreal_set(legendre[h]);
          cosine += p * u[h];
          sine += p * v[h];
        }
        vreal_store(b, sine);
        vreal_store(a, cosine); /* the same place where m = 0 */
      }
    }
}

/* N nodes from h on: in [factors][count], sum [count]. */
YLM_INLINE void batch_nodes(const int N, const ylm_sh_product *p, int h, const real *in, real *sum,
                            real *scratch) {
  const ylm__product_tables *t = &p->TABLES;
  const real *legendre = (const real *)t->legendre + h, *cosines = t->cosines, *sines = t->sines;
  int lmax = p->lmax, row = t->half_padded, ring = (2 * lmax + 1) * LANES,
      quadrants = p->azimuths / 4;
  size_t count = ylm_sh_count(lmax), rings = (size_t)(2 * BATCH_NODES * ring);
  real *value = scratch + (size_t)p->factors * rings;
  for (int k = 0; k < p->factors; k++)
    batch_orders(N, lmax, legendre, row, in + (size_t)k * count * LANES,
                 scratch + (size_t)k * rings, ring);
  for (int i = 0; i < N; i++) {
    real *x = scratch + i * 2 * ring + lmax * LANES;
    for (int k = 0; k < p->factors; k++) {
      const real *from = x + (size_t)k * rings;
      int j = 0;
      for (; j + BATCH_AZIMUTHS <= quadrants; j += BATCH_AZIMUTHS)
        batch_points(BATCH_AZIMUTHS, lmax, cosines + j * (lmax + 1), sines + j * (lmax + 1), from,
                     ring, value + j * 8 * LANES, k > 0);
      for (; j < quadrants; j++)
        batch_points(1, lmax, cosines + j * (lmax + 1), sines + j * (lmax + 1), from, ring,
                     value + j * 8 * LANES, k > 0);
    }
    batch_unfold(2 * quadrants, value);
    real weight = ((const real *)t->node_weights)[h + i];
    for (int parity = 0; parity < 2; parity++) {
      int m = parity;
      for (; m + 2 * (BATCH_ORDERS - 1) <= lmax; m += 2 * BATCH_ORDERS)
        batch_back(BATCH_ORDERS, lmax, quadrants, m, cosines, sines, value, weight, x, ring);
      for (; m <= lmax; m += 2)
        batch_back(1, lmax, quadrants, m, cosines, sines, value, weight, x, ring);
    }
  }
  batch_sum(N, lmax, legendre, row, scratch, ring, sum);
}

/* LANES products; rows: [factors][LANES] rows, out: [LANES], which may repeat. */
static void batch(const ylm_sh_product *p, const real *const *rows, real *const *out,
                  real *scratch) {
  size_t count = ylm_sh_count(p->lmax);
  real *in = scratch, *sum = in + (size_t)p->factors * count * LANES, *rest = sum + count * LANES;
  for (int k = 0; k < p->factors; k++)
    to_tile(rows + k * LANES, 0, (int)count, in + (size_t)k * count * LANES, LANES);
  if (p->method == YLM_SH_PRODUCT_gaunt) {
    gaunt_low_lanes(p->lmax, (const lane *)in, (const lane *)(in + count * LANES), (lane *)sum);
  } else {
    memset(sum, 0, count * LANES * sizeof(real));
    int h = 0;
    for (; h + BATCH_NODES <= p->half; h += BATCH_NODES)
      batch_nodes(BATCH_NODES, p, h, in, sum, rest);
    switch (p->half - h) {
    case 3: batch_nodes(3, p, h, in, sum, rest); break;
    case 2: batch_nodes(2, p, h, in, sum, rest); break;
    case 1: batch_nodes(1, p, h, in, sum, rest); break;
    }
  }
  from_tile(sum, LANES, (int)count, 0, out);
}

#endif
