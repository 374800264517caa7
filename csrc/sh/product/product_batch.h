/*
** product_batch.h - LANES products at once, for one element type; included twice by product.isa.c.
**
** Lanes are products; numbers stand in vectors of LANES. By quadrature, a few nodes of the rule at
** a time:
**
**   c [count] -> x [node][above, below the equator][2 lmax + 1] -> values at the azimuths of one
**   node, multiplied -> x -> sum [count]
**
** Sums of a step share what they read, and there are enough of them to keep multiply-adds busy.
*/

#include "../eval/transpose.h"

typedef V FN(lane) __attribute__((may_alias));

#define E FN(lane)
#define GAUNT(name) FN(name##_lanes)
#include "../gen/gaunt_low.h"
#undef E
#undef GAUNT

/* Nodes, azimuths and orders at a time. */
#define NODES 4
#if YLM_VECTOR_BYTES == 64
#define AZIMUTHS 3
#define ORDERS 4
#else
#define AZIMUTHS 1
#define ORDERS 2
#endif

/* x of N nodes from coefficients: sums over degrees, even and odd l - m apart. */
YLM_INLINE void FN(batch_orders)(const int N, int lmax, const T *legendre, int row, const T *c,
                                 T *x, int ring) {
  for (int m = 0; m <= lmax; m++) {
    V cosine[2][NODES], sine[2][NODES];
    for (int parity = 0; parity < 2; parity++) {
      V a[NODES], b[NODES];
      for (int h = 0; h < N; h++) a[h] = b[h] = SET(0);
      for (int l = m + parity; l <= lmax; l += 2, legendre += row) {
        V u = LOAD(c + (l * (l + 1) + m) * LANES), v = LOAD(c + (l * (l + 1) - m) * LANES);
        for (int h = 0; h < N; h++) {
          V p = SET(legendre[h]);
          a[h] += p * u;
          b[h] += p * v;
        }
      }
      for (int h = 0; h < N; h++) cosine[parity][h] = a[h], sine[parity][h] = b[h];
    }
    for (int h = 0; h < N; h++) {
      T *at = x + h * 2 * ring + lmax * LANES;
      STORE(at - m * LANES, sine[0][h] + sine[1][h]);
      STORE(at - m * LANES + ring, sine[0][h] - sine[1][h]);
      STORE(at + m * LANES, cosine[0][h] + cosine[1][h]);
      STORE(at + m * LANES + ring, cosine[0][h] - cosine[1][h]);
    }
  }
}

/* Values of a node at N azimuths of the first quadrant and their mirror images; x: order 0
   above. */
YLM_INLINE void FN(batch_points)(const int N, int lmax, const T *cosines, const T *sines,
                                 const T *x, int ring, T *value, bool multiply) {
  V ce[2][AZIMUTHS], co[2][AZIMUTHS], se[2][AZIMUTHS], so[2][AZIMUTHS];
  for (int side = 0; side < 2; side++)
    for (int j = 0; j < N; j++) {
      ce[side][j] = LOAD(x + side * ring);
      co[side][j] = se[side][j] = so[side][j] = SET(0);
    }
  for (int m = 1; m <= lmax; m++) {
    for (int side = 0; side < 2; side++) {
      V u = LOAD(x + side * ring + m * LANES), v = LOAD(x + side * ring - m * LANES);
      for (int j = 0; j < N; j++) {
        co[side][j] += u * SET(cosines[j * (lmax + 1) + m]);
        so[side][j] += v * SET(sines[j * (lmax + 1) + m]);
      }
    }
    if (++m > lmax) break;
    for (int side = 0; side < 2; side++) {
      V u = LOAD(x + side * ring + m * LANES), v = LOAD(x + side * ring - m * LANES);
      for (int j = 0; j < N; j++) {
        ce[side][j] += u * SET(cosines[j * (lmax + 1) + m]);
        se[side][j] += v * SET(sines[j * (lmax + 1) + m]);
      }
    }
  }
  for (int j = 0; j < N; j++)
    for (int side = 0; side < 2; side++, value += 4 * LANES) {
      V a = ce[side][j] + co[side][j], b = se[side][j] + so[side][j];
      V d = ce[side][j] - co[side][j], g = so[side][j] - se[side][j];
      V r[4] = {a + b, a - b, d + g, d - g}; /* phi, -phi, pi - phi, pi + phi */
      for (int q = 0; q < 4; q++)
        STORE(value + q * LANES, multiply ? LOAD(value + q * LANES) * r[q] : r[q]);
    }
}

/* Values at four mirror images to even and odd cosines, even and odd sines. */
YLM_INLINE void FN(batch_unfold)(int n, T *value) {
  for (int i = 0; i < n; i++, value += 4 * LANES) {
    V v0 = LOAD(value), v1 = LOAD(value + LANES), v2 = LOAD(value + 2 * LANES),
      v3 = LOAD(value + 3 * LANES);
    V a = v0 + v1, b = v0 - v1, d = v2 + v3, g = v2 - v3;
    STORE(value, a + d);
    STORE(value + LANES, a - d);
    STORE(value + 2 * LANES, b - g);
    STORE(value + 3 * LANES, b + g);
  }
}

/* Orders m, m+2 .. (N of them) of a node from unfolded values, as sum and difference of its two
 * sides. */
YLM_INLINE void FN(batch_back)(const int N, int lmax, int quadrants, int m, const T *cosines,
                               const T *sines, const T *value, T weight, T *x, int ring) {
  V c[2][ORDERS], s[2][ORDERS];
  for (int i = 0; i < N; i++) c[0][i] = c[1][i] = s[0][i] = s[1][i] = SET(0);
  value += m & 1 ? LANES : 0;
  for (int j = 0; j < quadrants; j++, value += 8 * LANES, cosines += lmax + 1, sines += lmax + 1) {
    V u0 = LOAD(value), v0 = LOAD(value + 2 * LANES), u1 = LOAD(value + 4 * LANES),
      v1 = LOAD(value + 6 * LANES);
    for (int i = 0; i < N; i++) {
      V cosine = SET(cosines[m + 2 * i]), sine = SET(sines[m + 2 * i]);
      c[0][i] += u0 * cosine;
      s[0][i] += v0 * sine;
      c[1][i] += u1 * cosine;
      s[1][i] += v1 * sine;
    }
  }
  V w = SET(weight);
  for (int i = 0; i < N; i++) {
    T *at = x - (m + 2 * i) * LANES;
    STORE(at, (s[0][i] + s[1][i]) * w);
    STORE(at + ring, (s[0][i] - s[1][i]) * w);
    at = x + (m + 2 * i) * LANES;
    STORE(at, (c[0][i] + c[1][i]) * w);
    STORE(at + ring, (c[0][i] - c[1][i]) * w);
  }
}

/* Adds what N nodes give to the coefficients. */
YLM_INLINE void FN(batch_sum)(const int N, int lmax, const T *legendre, int row, const T *x,
                              int ring, T *sum) {
  for (int m = 0; m <= lmax; m++)
    for (int parity = 0; parity < 2; parity++) {
      V u[NODES], v[NODES];
      for (int h = 0; h < N; h++) {
        const T *at = x + (2 * h + parity) * ring + lmax * LANES;
        u[h] = LOAD(at + m * LANES);
        v[h] = LOAD(at - m * LANES);
      }
      for (int l = m + parity; l <= lmax; l += 2, legendre += row) {
        T *a = sum + (l * (l + 1) + m) * LANES, *b = sum + (l * (l + 1) - m) * LANES;
        V cosine = LOAD(a), sine = LOAD(b);
        for (int h = 0; h < N; h++) {
          V p = SET(legendre[h]);
          cosine += p * u[h];
          sine += p * v[h];
        }
        STORE(b, sine);
        STORE(a, cosine); /* the same place where m = 0 */
      }
    }
}

/* N nodes from h on: in [factors][count], sum [count]. */
YLM_INLINE void FN(batch_nodes)(const int N, const ylm_sh_product *p, int h, const T *in, T *sum,
                                T *scratch) {
  const ylm__product_tables *t = &p->TABLES;
  const T *legendre = (const T *)t->legendre + h, *cosines = t->cosines, *sines = t->sines;
  int lmax = p->lmax, row = t->half_padded, ring = (2 * lmax + 1) * LANES,
      quadrants = p->azimuths / 4;
  size_t count = ylm_sh_count(lmax), rings = (size_t)(2 * NODES * ring);
  T *value = scratch + (size_t)p->factors * rings;
  for (int k = 0; k < p->factors; k++) FN(batch_orders)
  (N, lmax, legendre, row, in + (size_t)k * count * LANES, scratch + (size_t)k * rings, ring);
  for (int i = 0; i < N; i++) {
    T *x = scratch + i * 2 * ring + lmax * LANES;
    for (int k = 0; k < p->factors; k++) {
      const T *from = x + (size_t)k * rings;
      int j = 0;
      for (; j + AZIMUTHS <= quadrants; j += AZIMUTHS) FN(batch_points)
      (AZIMUTHS, lmax, cosines + j * (lmax + 1), sines + j * (lmax + 1), from, ring,
       value + j * 8 * LANES, k > 0);
      for (; j < quadrants; j++) FN(batch_points)
      (1, lmax, cosines + j * (lmax + 1), sines + j * (lmax + 1), from, ring, value + j * 8 * LANES,
       k > 0);
    }
    FN(batch_unfold)(2 * quadrants, value);
    T weight = ((const T *)t->node_weights)[h + i];
    for (int parity = 0; parity < 2; parity++) {
      int m = parity;
      for (; m + 2 * (ORDERS - 1) <= lmax; m += 2 * ORDERS)
        FN(batch_back)(ORDERS, lmax, quadrants, m, cosines, sines, value, weight, x, ring);
      for (; m <= lmax; m += 2)
        FN(batch_back)(1, lmax, quadrants, m, cosines, sines, value, weight, x, ring);
    }
  }
  FN(batch_sum)(N, lmax, legendre, row, scratch, ring, sum);
}

/* LANES products; rows: [factors][LANES] rows, out: [LANES], which may repeat. */
static void FN(batch)(const ylm_sh_product *p, const T *const *rows, T *const *out, T *scratch) {
  size_t count = ylm_sh_count(p->lmax);
  T *in = scratch, *sum = in + (size_t)p->factors * count * LANES, *rest = sum + count * LANES;
  for (int k = 0; k < p->factors; k++)
    FN(to_tile)(rows + k * LANES, 0, (int)count, in + (size_t)k * count * LANES, LANES);
  if (p->method == YLM_SH_PRODUCT_gaunt) {
    FN(gaunt_low_lanes)
    (p->lmax, (const FN(lane) *)in, (const FN(lane) *)(in + count * LANES), (FN(lane) *)sum);
  } else {
    memset(sum, 0, count * LANES * sizeof(T));
    int h = 0;
    for (; h + NODES <= p->half; h += NODES) FN(batch_nodes)(NODES, p, h, in, sum, rest);
    switch (p->half - h) {
    case 3: FN(batch_nodes)(3, p, h, in, sum, rest); break;
    case 2: FN(batch_nodes)(2, p, h, in, sum, rest); break;
    case 1: FN(batch_nodes)(1, p, h, in, sum, rest); break;
    }
  }
  FN(from_tile)(sum, LANES, (int)count, 0, out);
}
#undef NODES
#undef AZIMUTHS
#undef ORDERS
