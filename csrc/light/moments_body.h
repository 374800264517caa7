/*
** moments_body.h - the moment kernel of one lmax (LMAX) and one element type; see moments.h.
**
** Included by moments_kernel.h with REAL, V (vector), VI (integer vector), LANES, LAMP, NAME(x),
** and rsqrt and reciprocal defined. The plan of passes (which columns share the registers) is
** generated: gen/moments_*.isa.c.
*/

YLM_INLINE V NAME(set)(REAL x) { return (V){0} + x; }
YLM_INLINE V NAME(keep)(VI mask, V a) { return (V)((VI)a & mask); }
YLM_INLINE V NAME(choose)(VI mask, V a, V b) { return (V)(((VI)a & mask) | ((VI)b & ~mask)); }

/* One light's geometry and weights for LANES points. */
YLM_INLINE void NAME(prepare_one)(const int lmax, const int kinds, const LAMP *lamp, REAL emission,
                                  V x, V y, V z, V *g, V *w, VI *inside) {
  const int K = ylm__degree_of(lmax, kinds);
  x = lamp->at[0] - x, y = lamp->at[1] - y, z = lamp->at[2] - z;
  V r = NAME(set)(lamp->radius), d2 = x * x + y * y + z * z, h2 = SQUARES(d2, r);
  VI out = h2 > 0;
  *inside |= ~out;
  V one = NAME(set)(1);
  h2 = NAME(choose)(out, h2, one);
  d2 = NAME(choose)(out, d2, one);
  V invd = NAME(keep)(out, NAME(rsqrt)(d2)), invh = NAME(rsqrt)(h2);
  V h = h2 * invh, alpha = h * invd, t = r * invd, es = t * t * emission;
  x *= invd, y *= invd, z *= invd;
  g[0] = GROW * z;
  V c = x, s = y;
  UNROLL
  for (int m = 1; m <= K; m++) {
    g[2 * m - 1] = c, g[2 * m] = s;
    V next = c * x - s * y;
    s = s * x + c * y;
    c = next;
  }
  V far = d2 * invd * invh * invh * invh, p[LMAX + 4];
  alpha *= GROW;
  p[0] = es, p[1] = es * alpha;
  UNROLL
  for (int n = 1; n < lmax + 3; n++) p[n + 1] = alpha * p[n] - GAMMA(n) * p[n - 1];
  if (kinds & YLM__M0) {
    V zero = es * NAME(reciprocal)(1 + h * invd);
    w[0] = NAME(choose)(out, zero, NAME(set)(2 * emission));
    UNROLL
    for (int k = 1; k <= lmax; k++) w[k] = p[k - 1];
  }
  if (kinds & YLM__M1) {
    UNROLL
    for (int k = 1; k <= lmax + 1; k++) w[ylm__weight_at(lmax, 1, k)] = p[k - 1] * invh;
  }
  if (kinds & YLM__M2) {
    w[ylm__weight_at(lmax, 2, 0)] = es * far;
    UNROLL
    for (int k = 2; k <= lmax + 2; k++)
      w[ylm__weight_at(lmax, 2, k)] = (p[k] + RHO(k) * p[k - 2]) * far;
  }
}

static void NAME(prepare)(int lmax, int kinds, int n, const void *lamps, bool lum, const void *xyz,
                          void *geometry, void *weights, void *inside) {
  const LAMP *lamp = lamps;
  const V *at = xyz;
  V *g = geometry, *w = weights;
  const int G = ylm__geometry_slots(FIXED(lmax)), W = ylm__weight_slots(FIXED(lmax));
  (void)lmax;
#define X(set)                                                                                     \
  if (kinds == set)                                                                                \
    for (int j = 0; j < n; j++)                                                                    \
      NAME(prepare_one)                                                                            \
      (FIXED(lmax), set, &lamp[j], lum ? lamp[j].luminance : (REAL)1, at[0], at[1], at[2],         \
       g + j * G, w + j * W, inside);
  YLM__KIND_SETS(X)
#undef X
}

/*
** Adds the products of one light for degrees k0 .. k1-1 of the column (m, side), side 0 the real
** and 1 the imaginary part, to the sums at a. A column that ends early is resumed from `state`.
*/
YLM_INLINE void NAME(segment)(const int lmax, const int kinds, const int m, const int side,
                              const int k0, const int k1, const V *g, const V *w, V *state, V *a) {
  const int K = ylm__degree_of(lmax, kinds);
  V z = g[0], q, before = {0};
  if (k0 > m)
    q = state[0], before = state[1];
  else
    q = m == 0 ? NAME(set)(1) : g[2 * m - 1 + side];
  UNROLL
  for (int k = k0; k < k1; k++) {
    UNROLL
    for (int kind = 0; kind < 3; kind++)
      if (ylm__has(lmax, kinds, kind, k)) {
        V weight = w[ylm__weight_at(lmax, kind, k)];
        *a = k == 0 ? *a + weight : *a + q * weight;
        a++;
      }
    if (k == K) break;
    V next = k == 0 ? z : k == m ? z * q : z * q - BETA(k, m) * before;
    before = q, q = next;
  }
  if (k1 <= K) state[0] = q, state[1] = before;
}

#ifndef ANY_LMAX

#define PASS(first, count)                                                                         \
  {                                                                                                \
    V *total = sums + (first), a[count];                                                           \
    UNROLL                                                                                         \
    for (int i = 0; i < (count); i++) a[i] = total[i];                                             \
    for (int j = 0; j < n; j++) {                                                                  \
      const V *g = geometry + j * ylm__geometry_slots(LMAX);                                       \
      const V *w = weights + j * ylm__weight_slots(LMAX);                                          \
      V *saved = state + 2 * j;                                                                    \
      (void)saved;
#define SEGMENT(m, side, k0, k1, offset)                                                           \
  NAME(segment)(LMAX, KINDS, m, side, k0, k1, g, w, saved, a + (offset));
#define END(count)                                                                                 \
  }                                                                                                \
  UNROLL                                                                                           \
  for (int i = 0; i < (count); i++) total[i] = a[i];                                               \
  }

#define SUM(set)                                                                                   \
  static void NAME(sum_##set)(int n, const V *geometry, const V *weights, V *state, V *sums) {     \
    enum { KINDS = set };                                                                          \
    PLAN_##set                                                                                     \
  }
YLM__KIND_SETS(SUM)
#undef SUM
#undef PASS
#undef SEGMENT
#undef END

static void NAME(sum)(int lmax, int kinds, int n, const void *geometry, const void *weights,
                      void *state, void *sums) {
  (void)lmax;
#define X(set)                                                                                     \
  if (kinds == set) NAME(sum_##set)(n, geometry, weights, state, sums);
  YLM__KIND_SETS(X)
#undef X
}

#else

/* One column for all lights of a tile: q is kept per light in `state`. */
static void NAME(sum)(int lmax, int kinds, int n, const void *geometry, const void *weights,
                      void *state, void *sums) {
  const V *geo = geometry, *wts = weights;
  const int G = ylm__geometry_slots(lmax), W = ylm__weight_slots(lmax);
  const int K = ylm__degree_of(lmax, kinds);
  V *q = state, *before = q + YLM__TILE, *a = sums;
  for (int m = 0; m <= K; m++)
    for (int side = 0; side < (m ? 2 : 1); side++) {
      for (int j = 0; j < n; j++) {
        q[j] = m == 0 ? NAME(set)(1) : geo[j * G + 2 * m - 1 + side];
        before[j] = NAME(set)(0);
      }
      for (int k = m; k <= K; k++) {
        for (int kind = 0; kind < 3; kind++) {
          if (!ylm__has(lmax, kinds, kind, k)) continue;
          const V *w = wts + ylm__weight_at(lmax, kind, k);
          V s = *a;
          for (int j = 0; j < n; j++) s += q[j] * w[j * W];
          *a++ = s;
        }
        REAL beta = k ? BETA(k, m) : 0;
        for (int j = 0; j < n; j++) {
          V next = geo[j * G] * q[j] - beta * before[j];
          before[j] = q[j], q[j] = next;
        }
      }
    }
}

#endif
