/* product_kernel.h - the kernels of product.isa.c for one element type; included twice. */

#define E T
#define GAUNT(name) FN(name)
#include "../gen/gaunt_low.h"
#undef E
#undef GAUNT

/* -- one product by dense tables -------------------------------------------------------------- */

/* The points of N vectors from v: each factor's even and odd part, the product at both points of a
 * pair. */
YLM_INLINE void FN(dense_points)(const int N, const ylm_sh_product *p, const ylm__product_tables *t,
                                 const T *const *c, int v, T *even, T *odd) {
  int lmax = p->lmax, stride = t->pairs_padded;
  V plus[4], minus[4];
  for (int i = 0; i < 4; i++) plus[i] = minus[i] = SET(1);
  for (int k = 0; k < p->factors; k++) {
    const T *y = (const T *)t->values + v;
    V e[4], o[4];
    for (int i = 0; i < N; i++) e[i] = o[i] = SET(0);
    for (int l = 0; l <= lmax; l += 2)
      for (int m = 0; m <= 2 * l; m++, y += stride) {
        V x = SET(c[k][l * l + m]);
        for (int i = 0; i < N; i++) e[i] += LOAD(y + i * LANES) * x;
      }
    for (int l = 1; l <= lmax; l += 2)
      for (int m = 0; m <= 2 * l; m++, y += stride) {
        V x = SET(c[k][l * l + m]);
        for (int i = 0; i < N; i++) o[i] += LOAD(y + i * LANES) * x;
      }
    for (int i = 0; i < N; i++) {
      V a = e[i] + o[i], b = e[i] - o[i];
      plus[i] *= a;
      minus[i] *= b;
    }
  }
  for (int i = 0; i < N; i++) {
    STORE(even + v + i * LANES, plus[i] + minus[i]);
    STORE(odd + v + i * LANES, plus[i] - minus[i]);
  }
}

/* N vectors of coefficients from the points: out = sum of weights times x. */
YLM_INLINE void FN(dense_back)(const int N, int pairs, int stride, const T *w, const T *x, T *out) {
  V first[4], second[4];
  for (int i = 0; i < N; i++) first[i] = second[i] = SET(0);
  int q = 0;
  for (; q + 1 < pairs; q += 2, w += 2 * stride) {
    V a = SET(x[q]), b = SET(x[q + 1]);
    for (int i = 0; i < N; i++) {
      first[i] += LOAD(w + i * LANES) * a;
      second[i] += LOAD(w + stride + i * LANES) * b;
    }
  }
  if (q < pairs)
    for (int i = 0; i < N; i++) first[i] += LOAD(w + i * LANES) * SET(x[q]);
  for (int i = 0; i < N; i++) STORE(out + i * LANES, first[i] + second[i]);
}

static void FN(dense_back_all)(int n, int pairs, int stride, const T *w, const T *x, T *out) {
  int i = 0;
  for (; i + 4 <= n; i += 4) FN(dense_back)(4, pairs, stride, w + i * LANES, x, out + i * LANES);
  for (; i + 2 <= n; i += 2) FN(dense_back)(2, pairs, stride, w + i * LANES, x, out + i * LANES);
  if (i < n) FN(dense_back)(1, pairs, stride, w + i * LANES, x, out + i * LANES);
}

static void FN(dense)(const ylm_sh_product *p, const T *const *c, T *out, T *scratch) {
  const ylm__product_tables *t = &p->TABLES;
  T *even = scratch, *odd = even + t->pairs_padded, *result = odd + t->pairs_padded;
  int n = t->pairs_padded / LANES, i = 0, stride = t->evens_padded + t->odds_padded;
  for (; i + 4 <= n; i += 4) FN(dense_points)(4, p, t, c, i * LANES, even, odd);
  for (; i + 2 <= n; i += 2) FN(dense_points)(2, p, t, c, i * LANES, even, odd);
  if (i < n) FN(dense_points)(1, p, t, c, i * LANES, even, odd);
  FN(dense_back_all)(t->evens_padded / LANES, t->pairs, stride, t->weights, even, result);
  FN(dense_back_all)
  (t->odds_padded / LANES, t->pairs, stride, (const T *)t->weights + t->evens_padded, odd,
   result + t->evens_padded);
  const T *e = result, *o = result + t->evens_padded;
  for (int l = 0; l <= p->lmax; l++)
    for (int m = 0; m <= 2 * l; m++) out[l * l + m] = l & 1 ? *o++ : *e++;
}

/* -- azimuth: from orders to quadrants and back, for one vector of lanes
 * ----------------------------- */

/* x: [2][2L+1] vectors at distance `step` (z above and below; order m at L+m); the eight values at
   +-z, phi, -phi, pi-phi, pi+phi for quadrant angles j: value[j][8], multiplied in if k > 0. */
YLM_INLINE void FN(to_points)(int lmax, int quadrants, const T *cosines, const T *sines, const T *x,
                              int step, int hemisphere, T *value, int value_step, int k) {
  for (int j = 0; j < quadrants; j++) {
    const T *c = cosines + j * (lmax + 1), *s = sines + j * (lmax + 1);
    for (int side = 0; side < 2; side++) {
      const T *f = x + side * hemisphere + lmax * step;
      V ce = LOAD(f), co = SET(0), se = SET(0), so = SET(0);
      for (int m = 1; m <= lmax; m += 2) {
        co += LOAD(f + m * step) * SET(c[m]);
        so += LOAD(f - m * step) * SET(s[m]);
        if (m == lmax) break;
        ce += LOAD(f + (m + 1) * step) * SET(c[m + 1]);
        se += LOAD(f - (m + 1) * step) * SET(s[m + 1]);
      }
      V a = ce + co, b = se + so, d = ce - co, g = so - se;
      V r[4] = {a + b, a - b, d + g, d - g};
      T *at = value + (j * 8 + side * 4) * value_step;
      for (int q = 0; q < 4; q++)
        STORE(at + q * value_step, k ? LOAD(at + q * value_step) * r[q] : r[q]);
    }
  }
}

/* The reverse: sums over the azimuths times cosine and sine of each order, into x. */
YLM_INLINE void FN(from_points)(int lmax, int quadrants, const T *cosines, const T *sines, T *value,
                                int value_step, T *x, int step, int hemisphere) {
  /* to even and odd parts once */
  for (int j = 0; j < quadrants * 2; j++) {
    T *at = value + j * 4 * value_step;
    V v0 = LOAD(at), v1 = LOAD(at + value_step), v2 = LOAD(at + 2 * value_step),
      v3 = LOAD(at + 3 * value_step);
    V a = v0 + v1, b = v0 - v1, d = v2 + v3, g = v2 - v3;
    STORE(at, a + d);                  /* even cosines */
    STORE(at + value_step, a - d);     /* odd cosines */
    STORE(at + 2 * value_step, b - g); /* even sines */
    STORE(at + 3 * value_step, b + g); /* odd sines */
  }
  for (int m = 0; m <= lmax; m++) {
    int even = 1 - (m & 1);
    for (int side = 0; side < 2; side++) {
      const T *at = value + side * 4 * value_step + (even ? 0 : value_step);
      V c = SET(0), s = SET(0);
      for (int j = 0; j < quadrants; j++, at += 8 * value_step) {
        c += LOAD(at) * SET(cosines[j * (lmax + 1) + m]);
        s += LOAD(at + 2 * value_step) * SET(sines[j * (lmax + 1) + m]);
      }
      T *f = x + side * hemisphere + lmax * step;
      if (m) STORE(f - m * step, s);
      STORE(f + m * step, c);
    }
  }
}

/* -- one product, lanes are nodes
 * -------------------------------------------------------------------- */

/* Orders at the nodes: x[side][L+m] = sum over l of P_lm(+-z) c_lm, for vector v of nodes. */
YLM_INLINE void FN(to_orders)(int lmax, const T *legendre, int row, const T *c, T *x, int step,
                              int hemisphere) {
  for (int m = 0; m <= lmax; m++) {
    V part[2][2]; /* [parity][cosine, sine] */
    for (int parity = 0; parity < 2; parity++) {
      V a = SET(0), b = SET(0);
      for (int l = m + parity; l <= lmax; l += 2, legendre += row) {
        V p = LOAD(legendre);
        a += p * SET(c[l * (l + 1) + m]);
        b += p * SET(c[l * (l + 1) - m]);
      }
      part[parity][0] = a;
      part[parity][1] = b;
    }
    for (int s = m ? 1 : 0; s >= 0; s--) {
      T *at = x + (lmax + (s ? -m : m)) * step;
      STORE(at, part[0][s] + part[1][s]);
      STORE(at + hemisphere, part[0][s] - part[1][s]);
    }
  }
}

static void FN(separable)(const ylm_sh_product *p, const T *const *c, T *out, T *scratch,
                          double *stage) {
  const ylm__product_tables *t = &p->TABLES;
  int lmax = p->lmax, row = t->half_padded, quadrants = p->azimuths / 4,
      hemisphere = (2 * lmax + 1) * row;
  T *x = scratch, *value = x + 2 * hemisphere, *result = value + 8 * quadrants * row;
  double time = stage ? ylm_seconds() : 0;
  for (int k = 0; k < p->factors; k++) {
    for (int v = 0; v < row; v += LANES)
      FN(to_orders)(lmax, (const T *)t->legendre + v, row, c[k], x + v, row, hemisphere);
    for (int v = 0; v < row; v += LANES) FN(to_points)
    (lmax, quadrants, t->cosines, t->sines, x + v, row, hemisphere, value + v, row, k);
  }
  if (stage) {
    double now = ylm_seconds();
    stage[0] += now - time;
    time = now;
  }
  for (int v = 0; v < row; v += LANES)
    FN(from_points)(lmax, quadrants, t->cosines, t->sines, value + v, row, x + v, row, hemisphere);
  for (int i = 0; i < hemisphere; i += LANES) {
    V a = LOAD(x + i), b = LOAD(x + hemisphere + i);
    STORE(x + i, a + b);
    STORE(x + hemisphere + i, a - b);
  }
  /* lanes are degrees from here: broadcast each node */
  for (int m = -lmax; m <= lmax; m++) {
    int am = m < 0 ? -m : m;
    for (int parity = 0; parity < 2; parity++) {
      int n = product_degrees(lmax, am, parity), padded = product_padded(n, FULL);
      const T *w = (const T *)t->back + t->back_at[2 * am + parity];
      const T *g = x + parity * hemisphere + (lmax + m) * row;
      for (int v = 0; v < padded; v += LANES) {
        V a = SET(0), b = SET(0);
        int h = 0;
        for (; h + 1 < p->half; h += 2) {
          a += LOAD(w + h * padded + v) * SET(g[h]);
          b += LOAD(w + (h + 1) * padded + v) * SET(g[h + 1]);
        }
        if (h < p->half) a += LOAD(w + h * padded + v) * SET(g[h]);
        STORE(result + v, a + b);
      }
      for (int i = 0, l = am + parity; i < n; i++, l += 2) out[l * (l + 1) + m] = result[i];
    }
  }
  if (stage) stage[2] += ylm_seconds() - time;
}
