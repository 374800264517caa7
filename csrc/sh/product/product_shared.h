/*
** product_shared.h - products of several rows with one factor, by quadrature, for the unit's element type.
**
** Lanes are factors. The transform of a factor is made once for all its rows. A function is four
** parts, by cosine or sine and by the parity of the order. At an azimuth of the first quadrant and
** its mirror images it is
**
**   CE + CO + SE + SO at phi, CE + CO - SE - SO at -phi, CE - CO - SE + SO at pi - phi, CE - CO + SE - SO at
**   pi + phi
**
** and parts of a product are sums of products of parts, so that values at the images are never made.
*/
#ifndef YLM_SH_PRODUCT_SHARED_H
#define YLM_SH_PRODUCT_SHARED_H

#include "product.h"
#include "ylm_real.h"
#include "ylm_transpose.h"

/* The tables of the element type. */
#ifdef YLM_REAL_IS_FLOAT
#define SHARED_TABLES f
#else
#define SHARED_TABLES d
#endif

#define SHARED_CHUNK PRODUCT_CHUNK

/* The sizes of a plan. */
typedef struct shared_plan {
  int lmax, quadrants, half, row; /* row: of legendre */
  const real *legendre, *cosines, *sines, *weights;
} shared_plan;

/* Rings are [side][2 lmax + 1][SHARED_CHUNK]: above and below the equator, orders from -lmax on, nodes. */
#define SHARED_STEP (SHARED_CHUNK * LANES)
#define SHARED_SIDE ((2 * lmax + 1) * SHARED_STEP)

/* Sums over degrees l, l + 2 .. of order m, at N nodes; advances the table. */
YLM_INLINE const real *shared_degrees(const int N, const bool sine, int l, int m, int lmax,
                                      const real *legendre, int row, const real *c, int pitch,
                                      vreal *a, vreal *b) {
  for (int h = 0; h < N; h++) a[h] = b[h] = vreal_set(0);
  for (; l <= lmax; l += 2, legendre += row) {
    vreal u = vreal_load(c + (l * (l + 1) + m) * pitch), v;
    if (sine) v = vreal_load(c + (l * (l + 1) - m) * pitch);
    for (int h = 0; h < N; h++) {
      vreal p = vreal_set(legendre[h]);
      a[h] += p * u;
      if (sine) b[h] += p * v;
    }
  }
  return legendre;
}

/* Rings of N nodes from coefficients, c [count] vectors `pitch` apart. */
YLM_INLINE void shared_orders(const int N, int lmax, const real *legendre, int row, const real *c,
                              int pitch, real *x) {
  vreal a[SHARED_NODES], b[SHARED_NODES], d[SHARED_NODES], e[SHARED_NODES];
  x += lmax * SHARED_STEP;
  legendre = shared_degrees(N, false, 0, 0, lmax, legendre, row, c, pitch, a, b);
  legendre = shared_degrees(N, false, 1, 0, lmax, legendre, row, c, pitch, d, e);
  for (int h = 0; h < N; h++) {
    vreal_store(x + h * LANES, a[h] + d[h]);
    vreal_store(x + SHARED_SIDE + h * LANES, a[h] - d[h]);
  }
  for (int m = 1; m <= lmax; m++) {
    legendre = shared_degrees(N, true, m, m, lmax, legendre, row, c, pitch, a, b);
    legendre = shared_degrees(N, true, m + 1, m, lmax, legendre, row, c, pitch, d, e);
    real *up = x + m * SHARED_STEP, *down = x - m * SHARED_STEP;
    for (int h = 0; h < N; h++) {
      vreal_store(up + h * LANES, a[h] + d[h]);
      vreal_store(up + SHARED_SIDE + h * LANES, a[h] - d[h]);
      vreal_store(down + h * LANES, b[h] + e[h]);
      vreal_store(down + SHARED_SIDE + h * LANES, b[h] - e[h]);
    }
  }
}

/* Parts at N azimuths of a node, of either side. */
YLM_INLINE void shared_parts(const int N, int lmax, const real *cosines, const real *sines,
                             const real *x, vreal ce[2][SHARED_AZIMUTHS],
                             vreal co[2][SHARED_AZIMUTHS], vreal se[2][SHARED_AZIMUTHS],
                             vreal so[2][SHARED_AZIMUTHS]) {
  const int ring = SHARED_SIDE, table = lmax + 1;
  x += lmax * SHARED_STEP;
  for (int side = 0; side < 2; side++)
    for (int j = 0; j < N; j++) {
      ce[side][j] = vreal_load(x + side * ring);
      co[side][j] = se[side][j] = so[side][j] = vreal_set(0);
    }
  int m = 1;
  for (; m < lmax; m += 2)
    for (int odd = 1; odd >= 0; odd--) {
      int q = odd ? m : m + 1;
      vreal u0 = vreal_load(x + q * SHARED_STEP), v0 = vreal_load(x - q * SHARED_STEP);
      vreal u1 = vreal_load(x + ring + q * SHARED_STEP),
            v1 = vreal_load(x + ring - q * SHARED_STEP);
      for (int j = 0; j < N; j++) {
        vreal c = vreal_set(cosines[j * table + q]), s = vreal_set(sines[j * table + q]);
        if (odd) {
          co[0][j] += u0 * c, co[1][j] += u1 * c;
          so[0][j] += v0 * s, so[1][j] += v1 * s;
        } else {
          ce[0][j] += u0 * c, ce[1][j] += u1 * c;
          se[0][j] += v0 * s, se[1][j] += v1 * s;
        }
      }
    }
  if (m == lmax)
    for (int j = 0; j < N; j++)
      for (int side = 0; side < 2; side++) {
        co[side][j] +=
            vreal_load(x + side * ring + m * SHARED_STEP) * vreal_set(cosines[j * table + m]);
        so[side][j] +=
            vreal_load(x + side * ring - m * SHARED_STEP) * vreal_set(sines[j * table + m]);
      }
}

/* Parts at N azimuths of a node: to[azimuth][side][CE CO SE SO], times those of `by` where it is given. */
YLM_INLINE void shared_points(const int N, int lmax, const real *cosines, const real *sines,
                              const real *x, real weight, const real *by, real *to) {
  vreal ce[2][SHARED_AZIMUTHS], co[2][SHARED_AZIMUTHS], se[2][SHARED_AZIMUTHS],
      so[2][SHARED_AZIMUTHS];
  shared_parts(N, lmax, cosines, sines, x, ce, co, se, so);
  for (int j = 0; j < N; j++)
    for (int side = 0; side < 2; side++, to += 4 * LANES) {
      vreal a = ce[side][j], b = co[side][j], c = se[side][j], d = so[side][j];
      if (by) {
        vreal e = vreal_load(by), f = vreal_load(by + LANES), g = vreal_load(by + 2 * LANES),
              h = vreal_load(by + 3 * LANES);
        by += 4 * LANES;
        vreal_store(to, e * a + f * b + g * c + h * d);
        vreal_store(to + LANES, e * b + f * a + g * d + h * c);
        vreal_store(to + 2 * LANES, e * c + g * a + f * d + h * b);
        vreal_store(to + 3 * LANES, e * d + h * a + f * c + g * b);
      } else {
        vreal w = vreal_set(weight);
        vreal_store(to, w * a);
        vreal_store(to + LANES, w * b);
        vreal_store(to + 2 * LANES, w * c);
        vreal_store(to + 3 * LANES, w * d);
      }
    }
}

/* Adds sums over N azimuths of a node of a row times `by` times three functions that all lanes have, light
   [azimuth][side][4][3], to sum [2][3]. */
YLM_INLINE void shared_dots(const int N, int lmax, const real *cosines, const real *sines,
                            const real *x, const real *by, const real *light, vreal sum[2][3]) {
  vreal ce[2][SHARED_AZIMUTHS], co[2][SHARED_AZIMUTHS], se[2][SHARED_AZIMUTHS],
      so[2][SHARED_AZIMUTHS];
  shared_parts(N, lmax, cosines, sines, x, ce, co, se, so);
  for (int j = 0; j < N; j++)
    for (int side = 0; side < 2; side++, by += 4 * LANES, light += 12) {
      vreal a = ce[side][j], b = co[side][j], c = se[side][j], d = so[side][j];
      vreal e = vreal_load(by), f = vreal_load(by + LANES), g = vreal_load(by + 2 * LANES),
            h = vreal_load(by + 3 * LANES);
      vreal p = e * a + f * b + g * c + h * d, q = e * b + f * a + g * d + h * c;
      vreal r = e * c + g * a + f * d + h * b, t = e * d + h * a + f * c + g * b;
      for (int k = 0; k < 3; k++) {
        sum[0][k] += p * vreal_set(light[k]);
        sum[1][k] += q * vreal_set(light[3 + k]);
        sum[0][k] += r * vreal_set(light[6 + k]);
        sum[1][k] += t * vreal_set(light[9 + k]);
      }
    }
}

/* Orders m, m+2 .. (N of them) of a node from parts, as sum and difference of its two sides. */
YLM_INLINE void shared_back(const int N, int lmax, int quadrants, int m, const real *cosines,
                            const real *sines, const real *value, real *x) {
  const int ring = SHARED_SIDE;
  vreal c[2][SHARED_ORDERS], s[2][SHARED_ORDERS];
  for (int i = 0; i < N; i++) c[0][i] = c[1][i] = s[0][i] = s[1][i] = vreal_set(0);
  value += m & 1 ? LANES : 0;
  cosines += m, sines += m;
  for (int j = 0; j < quadrants; j++, value += 8 * LANES, cosines += lmax + 1, sines += lmax + 1) {
    vreal u0 = vreal_load(value), v0 = vreal_load(value + 2 * LANES),
          u1 = vreal_load(value + 4 * LANES), v1 = vreal_load(value + 6 * LANES);
    for (int i = 0; i < N; i++) {
      vreal cosine = vreal_set(cosines[2 * i]), sine = vreal_set(sines[2 * i]);
      c[0][i] += u0 * cosine;
      c[1][i] += u1 * cosine;
      s[0][i] += v0 * sine;
      s[1][i] += v1 * sine;
    }
  }
  x += lmax * SHARED_STEP;
  for (int i = 0; i < N; i++) {
    real *at = x - (m + 2 * i) * SHARED_STEP;
    vreal_store(at, s[0][i] + s[1][i]);
    vreal_store(at + ring, s[0][i] - s[1][i]);
    at = x + (m + 2 * i) * SHARED_STEP;
    vreal_store(at, c[0][i] + c[1][i]);
    vreal_store(at + ring, c[0][i] - c[1][i]);
  }
}

/* Adds what N nodes give to the coefficients; `first`: they are the first that do. */
YLM_INLINE void shared_sum(const int N, int lmax, const real *legendre, int row, const real *x,
                           bool first, real *sum, int pitch) {
  x += lmax * SHARED_STEP;
  for (int m = 0; m <= lmax; m++)
    for (int parity = 0; parity < 2; parity++) {
      vreal u[SHARED_SUMS], v[SHARED_SUMS];
      const real *up = x + m * SHARED_STEP + parity * SHARED_SIDE, *down = up - 2 * m * SHARED_STEP;
      for (int h = 0; h < N; h++) {
        u[h] = vreal_load(up + h * LANES);
        v[h] = vreal_load(down + h * LANES);
      }
      for (int l = m + parity; l <= lmax; l += 2, legendre += row) {
        real *a = sum + (l * (l + 1) + m) * pitch, *b = sum + (l * (l + 1) - m) * pitch;
        vreal cosine = first ? vreal_set(0) : vreal_load(a),
              sine = first ? vreal_set(0) : vreal_load(b);
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

/* Azimuths that come next, of so many that are left: steps of about the same width. */
static int shared_next(int left) {
  int parts = (left + SHARED_AZIMUTHS - 1) / SHARED_AZIMUTHS;
  return (left + parts - 1) / parts;
}

static void shared_ring_points(const shared_plan *p, const real *x, real weight, const real *by,
                               real *to) {
  const real *cosines = p->cosines, *sines = p->sines;
  for (int left = p->quadrants, n; left > 0; left -= n) {
    n = shared_next(left);
#define POINTS(N) shared_points(N, p->lmax, cosines, sines, x, weight, by, to)
    switch (n) {
    case 1: POINTS(1); break;
#if SHARED_AZIMUTHS > 1
    case 2: POINTS(2); break;
    case 3: POINTS(3); break;
#endif
    }
#undef POINTS
    cosines += n * (p->lmax + 1), sines += n * (p->lmax + 1);
    by = by ? by + n * 8 * LANES : NULL;
    to += n * 8 * LANES;
  }
}

static void shared_ring_back(const shared_plan *p, const real *value, real *x) {
  for (int parity = 0; parity < 2; parity++)
    for (int m = parity, left = p->lmax < parity ? 0 : (p->lmax - parity) / 2 + 1; left > 0;) {
      int parts = (left + SHARED_ORDERS - 1) / SHARED_ORDERS, n = (left + parts - 1) / parts;
#define BACK(N) shared_back(N, p->lmax, p->quadrants, m, p->cosines, p->sines, value, x)
      switch (n) {
      case 1: BACK(1); break;
      case 2: BACK(2); break;
      case 3: BACK(3); break;
#if SHARED_ORDERS > 3
      case 4: BACK(4); break;
      case 5: BACK(5); break;
#endif
      }
#undef BACK
      m += 2 * n, left -= n;
    }
}

/* Rings of nodes h .. h+n-1. */
static void shared_rings(const shared_plan *p, int h, int n, const real *c, int pitch, real *x) {
  while (n > 0) {
    int parts = (n + SHARED_NODES - 1) / SHARED_NODES, some = (n + parts - 1) / parts;
#define ORDERS_OF(N) shared_orders(N, p->lmax, p->legendre + h, p->row, c, pitch, x)
    switch (some) {
    case 1: ORDERS_OF(1); break;
    case 2: ORDERS_OF(2); break;
    case 3: ORDERS_OF(3); break;
#if SHARED_NODES > 3
    case 4: ORDERS_OF(4); break;
#endif
    }
#undef ORDERS_OF
    h += some, n -= some, x += some * LANES;
  }
}

static void shared_sums(const shared_plan *p, int h, int n, const real *x, real *sum, int pitch) {
  while (n > 0) {
    int parts = (n + SHARED_SUMS - 1) / SHARED_SUMS, some = (n + parts - 1) / parts;
#define SUM_OF(N) shared_sum(N, p->lmax, p->legendre + h, p->row, x, h == 0, sum, pitch)
    switch (some) {
    case 1: SUM_OF(1); break;
    case 2: SUM_OF(2); break;
    case 3: SUM_OF(3); break;
    case 4: SUM_OF(4); break;
#if SHARED_SUMS > 4
    case 5: SUM_OF(5); break;
    case 6: SUM_OF(6); break;
    case 7: SUM_OF(7); break;
    case 8: SUM_OF(8); break;
#endif
    }
#undef SUM_OF
    h += some, n -= some, x += some * LANES;
  }
}

/* The nodes of a chunk. */
static int shared_chunk(const shared_plan *p) {
  int chunks = (p->half + SHARED_CHUNK - 1) / SHARED_CHUNK;
  return (p->half + chunks - 1) / chunks;
}

/* The plan of a product of two factors by quadrature; weights: [half], of a node and its images. */
static void shared_begin(const ylm_sh_product *q, real *weights, shared_plan *p) {
  const ylm__product_tables *t = &q->SHARED_TABLES;
  for (int h = 0; h < q->half; h++) weights[h] = 4 * ((const real *)t->node_weights)[h];
  *p = (shared_plan){.lmax = q->lmax,
                     .quadrants = q->azimuths / 4,
                     .half = q->half,
                     .row = t->half_padded,
                     .legendre = t->legendre,
                     .cosines = t->cosines,
                     .sines = t->sines,
                     .weights = weights};
}

/* Room: parts of the factor at all nodes, [half][quadrants][2][4], those of a product at one node, rings. */
static void shared_room(const shared_plan *p, real *room, real **parts, real **value, real **x) {
  *parts = room;
  *value = *parts + p->half * p->quadrants * 8 * LANES;
  *x = *value + p->quadrants * 8 * LANES;
}

/* Transforms LANES factors, c [count] vectors `pitch` apart, in product_shared_scratch numbers of room. */
static void shared_factor(const shared_plan *p, const real *c, int pitch, real *room) {
  int most = shared_chunk(p);
  real *parts, *value, *x;
  shared_room(p, room, &parts, &value, &x);
  for (int h = 0; h < p->half; h += most) {
    int n = p->half - h < most ? p->half - h : most;
    shared_rings(p, h, n, c, pitch, x);
    for (int i = 0; i < n; i++, parts += p->quadrants * 8 * LANES)
      shared_ring_points(p, x + i * LANES, p->weights[h + i], NULL, parts);
  }
}

/* Rows times the factors that stand in the room; out is not c. */
static void shared_times(const shared_plan *p, const real *c, int c_pitch, real *room, real *out,
                         int out_pitch) {
  int most = shared_chunk(p);
  real *parts, *value, *x;
  shared_room(p, room, &parts, &value, &x);
  for (int h = 0; h < p->half; h += most) {
    int n = p->half - h < most ? p->half - h : most;
    shared_rings(p, h, n, c, c_pitch, x);
    for (int i = 0; i < n; i++, parts += p->quadrants * 8 * LANES) {
      shared_ring_points(p, x + i * LANES, 0, parts, value);
      shared_ring_back(p, value, x + i * LANES);
    }
    shared_sums(p, h, n, x, out, out_pitch);
  }
}

/* Three functions, rows [3], by a plan whose weights are 1, as shared_integrals takes them: out
   [half][quadrants][2][4][3]. Room: shared_factor's; c: [count] vectors. */
static void shared_lights(const shared_plan *p, const real *const *rows, real *room, real *c,
                          real *out) {
  const real *by[LANES];
  int count = (p->lmax + 1) * (p->lmax + 1), parts = p->half * p->quadrants * 8;
  for (int k = 0; k < 3; k += LANES) {
    for (int i = 0; i < LANES; i++) by[i] = rows[k + i < 3 ? k + i : 2];
    to_tile(by, 0, count, c, LANES);
    shared_factor(p, c, LANES, room);
    for (int at = 0; at < parts; at++)
      for (int i = 0; i < LANES && k + i < 3; i++) out[3 * at + k + i] = room[at * LANES + i];
  }
}

/* Adds a node's part of the integrals to sum. */
static void shared_ring_dots(const shared_plan *p, const real *x, const real *by, const real *light,
                             vreal sum[2][3]) {
  const real *cosines = p->cosines, *sines = p->sines;
  for (int left = p->quadrants, n; left > 0; left -= n) {
    n = shared_next(left);
#define DOTS(N) shared_dots(N, p->lmax, cosines, sines, x, by, light, sum)
    switch (n) {
    case 1: DOTS(1); break;
#if SHARED_AZIMUTHS > 1
    case 2: DOTS(2); break;
    case 3: DOTS(3); break;
#endif
    }
#undef DOTS
    cosines += n * (p->lmax + 1), sines += n * (p->lmax + 1);
    by += n * 8 * LANES;
    light += n * 24;
  }
}

/* Integrals of rows times the factors that stand in the room times three functions, out [3]. */
static void shared_integrals(const shared_plan *p, const real *c, int c_pitch, real *room,
                             const real *light, vreal *out) {
  int most = shared_chunk(p);
  real *parts, *value, *x;
  vreal sum[2][3];
  shared_room(p, room, &parts, &value, &x);
  for (int k = 0; k < 3; k++) sum[0][k] = sum[1][k] = vreal_set(0);
  for (int h = 0; h < p->half; h += most) {
    int n = p->half - h < most ? p->half - h : most;
    shared_rings(p, h, n, c, c_pitch, x);
    for (int i = 0; i < n; i++, parts += p->quadrants * 8 * LANES, light += p->quadrants * 24)
      shared_ring_dots(p, x + i * LANES, parts, light, sum);
  }
  for (int k = 0; k < 3; k++) out[k] = sum[0][k] + sum[1][k];
}

#endif
