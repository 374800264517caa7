/* product_one.h - kernels of one product at a time, for the unit's element type. */
#ifndef YLM_SH_PRODUCT_ONE_H
#define YLM_SH_PRODUCT_ONE_H

#include "product.h"
#include "ylm_real.h"

/* Numbers in 64 bytes, and the tables of the element type. */
#define FULL (64 / (int)sizeof(real))
#ifdef YLM_REAL_IS_FLOAT
#define TABLES f
#else
#define TABLES d
#endif

/* For numbers. */
#define E real
#define GAUNT(name) name
#include "../gen/gaunt_low.h"
#undef E
#undef GAUNT

/* -- one product by dense tables -------------------------------------------------------------- */

/* The points of N vectors from v: each factor's even and odd part, the product at both points of a
 * pair. */
YLM_INLINE void dense_points(const int N, const ylm_sh_product *p, const ylm__product_tables *t,
                             const real *const *c, int v, real *even, real *odd) {
  int lmax = p->lmax, stride = t->pairs_padded;
  vreal plus[4], minus[4];
  for (int i = 0; i < 4; i++) plus[i] = minus[i] = vreal_set(1);
  for (int k = 0; k < p->factors; k++) {
    const real *y = (const real *)t->values + v;
    vreal e[4], o[4];
    for (int i = 0; i < N; i++) e[i] = o[i] = vreal_set(0);
    for (int l = 0; l <= lmax; l += 2)
      for (int m = 0; m <= 2 * l; m++, y += stride) {
        vreal x = vreal_set(c[k][l * l + m]);
        for (int i = 0; i < N; i++) e[i] += vreal_load(y + i * LANES) * x;
      }
    for (int l = 1; l <= lmax; l += 2)
      for (int m = 0; m <= 2 * l; m++, y += stride) {
        vreal x = vreal_set(c[k][l * l + m]);
        for (int i = 0; i < N; i++) o[i] += vreal_load(y + i * LANES) * x;
      }
    for (int i = 0; i < N; i++) {
      vreal a = e[i] + o[i], b = e[i] - o[i];
      plus[i] *= a;
      minus[i] *= b;
    }
  }
  for (int i = 0; i < N; i++) {
    vreal_store(even + v + i * LANES, plus[i] + minus[i]);
    vreal_store(odd + v + i * LANES, plus[i] - minus[i]);
  }
}

/* N vectors of coefficients from the points: out = sum of weights times x. */
YLM_INLINE void dense_back(const int N, int pairs, int stride, const real *w, const real *x,
                           real *out) {
  vreal first[4], second[4];
  for (int i = 0; i < N; i++) first[i] = second[i] = vreal_set(0);
  int q = 0;
  for (; q + 1 < pairs; q += 2, w += 2 * stride) {
    vreal a = vreal_set(x[q]), b = vreal_set(x[q + 1]);
    for (int i = 0; i < N; i++) {
      first[i] += vreal_load(w + i * LANES) * a;
      second[i] += vreal_load(w + stride + i * LANES) * b;
    }
  }
  if (q < pairs)
    for (int i = 0; i < N; i++) first[i] += vreal_load(w + i * LANES) * vreal_set(x[q]);
  for (int i = 0; i < N; i++) vreal_store(out + i * LANES, first[i] + second[i]);
}

static void dense_back_all(int n, int pairs, int stride, const real *w, const real *x, real *out) {
  int i = 0;
  for (; i + 4 <= n; i += 4) dense_back(4, pairs, stride, w + i * LANES, x, out + i * LANES);
  for (; i + 2 <= n; i += 2) dense_back(2, pairs, stride, w + i * LANES, x, out + i * LANES);
  if (i < n) dense_back(1, pairs, stride, w + i * LANES, x, out + i * LANES);
}

static void dense(const ylm_sh_product *p, const real *const *c, real *out, real *scratch) {
  const ylm__product_tables *t = &p->TABLES;
  real *even = scratch, *odd = even + t->pairs_padded, *result = odd + t->pairs_padded;
  int n = t->pairs_padded / LANES, i = 0, stride = t->evens_padded + t->odds_padded;
  for (; i + 4 <= n; i += 4) dense_points(4, p, t, c, i * LANES, even, odd);
  for (; i + 2 <= n; i += 2) dense_points(2, p, t, c, i * LANES, even, odd);
  if (i < n) dense_points(1, p, t, c, i * LANES, even, odd);
  dense_back_all(t->evens_padded / LANES, t->pairs, stride, t->weights, even, result);
  dense_back_all(t->odds_padded / LANES, t->pairs, stride,
                 (const real *)t->weights + t->evens_padded, odd, result + t->evens_padded);
  const real *e = result, *o = result + t->evens_padded;
  for (int l = 0; l <= p->lmax; l++)
    for (int m = 0; m <= 2 * l; m++) out[l * l + m] = l & 1 ? *o++ : *e++;
}

/* -- azimuth: from orders to quadrants and back, for one vector of lanes
 * ----------------------------- */

/* x: [2][2L+1] vectors at distance `step` (z above and below; order m at L+m); the eight values at
   +-z, phi, -phi, pi-phi, pi+phi for quadrant angles j: value[j][8], multiplied in if k > 0. */
YLM_INLINE void to_points(int lmax, int quadrants, const real *cosines, const real *sines,
                          const real *x, int step, int hemisphere, real *value, int value_step,
                          int k) {
  for (int j = 0; j < quadrants; j++) {
    const real *c = cosines + j * (lmax + 1), *s = sines + j * (lmax + 1);
    for (int side = 0; side < 2; side++) {
      const real *f = x + side * hemisphere + lmax * step;
      vreal ce = vreal_load(f), co = vreal_set(0), se = vreal_set(0), so = vreal_set(0);
      for (int m = 1; m <= lmax; m += 2) {
        co += vreal_load(f + m * step) * vreal_set(c[m]);
        so += vreal_load(f - m * step) * vreal_set(s[m]);
        if (m == lmax) break;
        ce += vreal_load(f + (m + 1) * step) * vreal_set(c[m + 1]);
        se += vreal_load(f - (m + 1) * step) * vreal_set(s[m + 1]);
      }
      vreal a = ce + co, b = se + so, d = ce - co, g = so - se;
      vreal r[4] = {a + b, a - b, d + g, d - g};
      real *at = value + (j * 8 + side * 4) * value_step;
      for (int q = 0; q < 4; q++)
        vreal_store(at + q * value_step, k ? vreal_load(at + q * value_step) * r[q] : r[q]);
    }
  }
}

/* The reverse: sums over the azimuths times cosine and sine of each order, into x. */
YLM_INLINE void from_points(int lmax, int quadrants, const real *cosines, const real *sines,
                            real *value, int value_step, real *x, int step, int hemisphere) {
  /* to even and odd parts once */
  for (int j = 0; j < quadrants * 2; j++) {
    real *at = value + j * 4 * value_step;
    vreal v0 = vreal_load(at), v1 = vreal_load(at + value_step),
          v2 = vreal_load(at + 2 * value_step), v3 = vreal_load(at + 3 * value_step);
    vreal a = v0 + v1, b = v0 - v1, d = v2 + v3, g = v2 - v3;
    vreal_store(at, a + d);                  /* even cosines */
    vreal_store(at + value_step, a - d);     /* odd cosines */
    vreal_store(at + 2 * value_step, b - g); /* even sines */
    vreal_store(at + 3 * value_step, b + g); /* odd sines */
  }
  for (int m = 0; m <= lmax; m++) {
    int even = 1 - (m & 1);
    for (int side = 0; side < 2; side++) {
      const real *at = value + side * 4 * value_step + (even ? 0 : value_step);
      vreal c = vreal_set(0), s = vreal_set(0);
      for (int j = 0; j < quadrants; j++, at += 8 * value_step) {
        c += vreal_load(at) * vreal_set(cosines[j * (lmax + 1) + m]);
        s += vreal_load(at + 2 * value_step) * vreal_set(sines[j * (lmax + 1) + m]);
      }
      real *f = x + side * hemisphere + lmax * step;
      if (m) vreal_store(f - m * step, s);
      vreal_store(f + m * step, c);
    }
  }
}

/* -- one product, lanes are nodes
 * -------------------------------------------------------------------- */

/* Orders at the nodes: x[side][L+m] = sum over l of P_lm(+-z) c_lm, for vector v of nodes. */
YLM_INLINE void to_orders(int lmax, const real *legendre, int row, const real *c, real *x, int step,
                          int hemisphere) {
  for (int m = 0; m <= lmax; m++) {
    vreal part[2][2]; /* [parity][cosine, sine] */
    for (int parity = 0; parity < 2; parity++) {
      vreal a = vreal_set(0), b = vreal_set(0);
      for (int l = m + parity; l <= lmax; l += 2, legendre += row) {
        vreal p = vreal_load(legendre);
        a += p * vreal_set(c[l * (l + 1) + m]);
        b += p * vreal_set(c[l * (l + 1) - m]);
      }
      part[parity][0] = a;
      part[parity][1] = b;
    }
    for (int s = m ? 1 : 0; s >= 0; s--) {
      real *at = x + (lmax + (s ? -m : m)) * step;
      vreal_store(at, part[0][s] + part[1][s]);
      vreal_store(at + hemisphere, part[0][s] - part[1][s]);
    }
  }
}

static void separable(const ylm_sh_product *p, const real *const *c, real *out, real *scratch,
                      double *stage) {
  const ylm__product_tables *t = &p->TABLES;
  int lmax = p->lmax, row = t->half_padded, quadrants = p->azimuths / 4,
      hemisphere = (2 * lmax + 1) * row;
  real *x = scratch, *value = x + 2 * hemisphere, *result = value + 8 * quadrants * row;
  double time = stage ? ylm_seconds() : 0;
  for (int k = 0; k < p->factors; k++) {
    for (int v = 0; v < row; v += LANES)
      to_orders(lmax, (const real *)t->legendre + v, row, c[k], x + v, row, hemisphere);
    for (int v = 0; v < row; v += LANES)
      to_points(lmax, quadrants, t->cosines, t->sines, x + v, row, hemisphere, value + v, row, k);
  }
  if (stage) {
    double now = ylm_seconds();
    stage[0] += now - time;
    time = now;
  }
  for (int v = 0; v < row; v += LANES)
    from_points(lmax, quadrants, t->cosines, t->sines, value + v, row, x + v, row, hemisphere);
  for (int i = 0; i < hemisphere; i += LANES) {
    vreal a = vreal_load(x + i), b = vreal_load(x + hemisphere + i);
    vreal_store(x + i, a + b);
    vreal_store(x + hemisphere + i, a - b);
  }
  /* lanes are degrees from here: broadcast each node */
  for (int m = -lmax; m <= lmax; m++) {
    int am = m < 0 ? -m : m;
    for (int parity = 0; parity < 2; parity++) {
      int n = product_degrees(lmax, am, parity), padded = product_padded(n, FULL);
      const real *w = (const real *)t->back + t->back_at[2 * am + parity];
      const real *g = x + parity * hemisphere + (lmax + m) * row;
      for (int v = 0; v < padded; v += LANES) {
        vreal a = vreal_set(0), b = vreal_set(0);
        int h = 0;
        for (; h + 1 < p->half; h += 2) {
          a += vreal_load(w + h * padded + v) * vreal_set(g[h]);
          b += vreal_load(w + (h + 1) * padded + v) * vreal_set(g[h + 1]);
        }
        if (h < p->half) a += vreal_load(w + h * padded + v) * vreal_set(g[h]);
        vreal_store(result + v, a + b);
      }
      for (int i = 0, l = am + parity; i < n; i++, l += 2) out[l * (l + 1) + m] = result[i];
    }
  }
  if (stage) stage[2] += ylm_seconds() - time;
}

#endif
