/*
** rotate_each.h - rotation of rows that each have a rotation of their own, for the unit's element type.
**
** Lanes are rows: quarter turns are the same in all of them, cosines and sines are each lane's.
*/
#ifndef YLM_SH_ROTATE_EACH_H
#define YLM_SH_ROTATE_EACH_H

#include "../product/product_shared.h"
#include "rotate_batch.h"

#define NUMBER vreal
#define STRAIGHT(name) each_##name
#define ANGLE(c, m) vreal_load((c) + (m)*TILE)
#include "rotate_straight.h"

#ifdef YLM_REAL_IS_FLOAT
#define EACH_SELECT ylm_vf_select
#else
#define EACH_SELECT ylm_vd_select
#endif

/* Degrees that are turned in one tile; higher ones come one by one. */
#define EACH_LOW ROTATE_TIMES_LMAX
#define EACH_COUNT ((EACH_LOW + 1) * (EACH_LOW + 1))
#define EACH_WIDEST (2 * YLM_SH_ROTATE_LMAX + 1)

/* As to_tile, of rows of n numbers, behind whose first so many can be read. */
static void to_tile_within(const real *const *row, int n, size_t readable, real *tile, int pitch) {
  if (n >= LANES || readable < LANES) {
    to_tile(row, 0, n, tile, pitch);
    return;
  }
  vreal v[LANES];
#pragma GCC unroll 16
  for (int r = 0; r < LANES; r++) v[r] = vreal_load(row[r]);
  transpose(v);
  for (int k = 0; k < n; k++) vreal_store(tile + k * pitch, v[k]);
}

/* The angles of rotations near to orthonormal, r [9][TILE]: R = Rz(a) Ry(b) Rz(c), as rotate.c has them. */
static void each_begin(const real *r, int lmax, each_angles *a) {
  for (int k = 0; k < TILE; k += LANES) {
    vreal one = vreal_set(1), zero = vreal_set(0), tiny = vreal_set((real)1e-30);
#define R(i) vreal_load(r + (i)*TILE + k)
    vreal sb = vreal_sqrt(R(2) * R(2) + R(5) * R(5)), length = vreal_sqrt(sb * sb + R(8) * R(8));
    vmask turned = sb > tiny; /* below: about z alone, or about z and by half a turn */
    vreal inverse = one / EACH_SELECT(turned, sb, one);
    vreal ca = EACH_SELECT(turned, R(2) * inverse, one);
    vreal sa = EACH_SELECT(turned, R(5) * inverse, zero);
    vreal sc = ca * R(3) - sa * R(0), cc = ca * R(4) - sa * R(1);
#undef R
    vreal unit = one / vreal_sqrt(sc * sc + cc * cc);
    const vreal c1[3] = {-ca, -(vreal_load(r + 8 * TILE + k) / length), cc * unit};
    const vreal s1[3] = {-sa, -(sb / length), sc * unit};
    for (int i = 0; i < 3; i++) {
      vreal c = one, s = zero;
      vreal_store(a->c[i][0] + k, c);
      vreal_store(a->s[i][0] + k, s);
      for (int m = 1; m <= lmax; m++) {
        vreal next = c * c1[i] - s * s1[i];
        s = c * s1[i] + s * c1[i];
        c = next;
        vreal_store(a->c[i][m] + k, c);
        vreal_store(a->s[i][m] + k, s);
      }
    }
  }
}

/* x = Z x for degree l. */
YLM_INLINE void each_turn(int l, const real (*c)[TILE], const real (*s)[TILE], real *x) {
  for (int m = 1; m <= l; m++) {
    real *a = x + (l + m) * TILE, *b = x + (l - m) * TILE;
    for (int k = 0; k < TILE; k += LANES) {
      vreal cm = vreal_load(c[m] + k), sm = vreal_load(s[m] + k);
      vreal ak = vreal_load(a + k), bk = vreal_load(b + k);
      vreal_store(a + k, cm * ak - sm * bk);
      vreal_store(b + k, sm * ak + cm * bk);
    }
  }
}

/* x = Z h for degree l of rows that hold m >= 0 alone. */
YLM_INLINE void each_unfold(int l, const real (*c)[TILE], const real (*s)[TILE], const real *h,
                            real *x) {
  for (int k = 0; k < TILE; k += LANES) vreal_store(x + l * TILE + k, vreal_load(h + k));
  for (int m = 1; m <= l; m++)
    for (int k = 0; k < TILE; k += LANES) {
      vreal hm = vreal_load(h + m * TILE + k);
      vreal_store(x + (l + m) * TILE + k, vreal_load(c[m] + k) * hm);
      vreal_store(x + (l - m) * TILE + k, vreal_load(s[m] + k) * hm);
    }
}

/* The rest of the rotation of degree l, x after Z(c); y: room. */
YLM_INLINE void each_degree(const ylm_sh_rotator *p, int l, const each_angles *a, real *x,
                            real *y) {
  const real *j = (const real *)p->PANELS + p->panel_at[l];
  quarter_tile(l, j, x, y);
  each_turn(l, a->c[1], a->s[1], y);
  quarter_tile(l, j, y, x);
  each_turn(l, a->c[0], a->s[0], x);
}

/* Degree l, a constant, by straight-line code: x [2l+1][TILE] is turned in place, or made of h [l+1][TILE] whose m are >= 0. */
YLM_INLINE void each_low(const int l, const bool halves, const each_angles *a, const real *h,
                         real *x) {
  for (int k = 0; k < TILE; k += LANES) {
    const real *cc = a->c[2][0] + k, *sc = a->s[2][0] + k;
    vreal f[ROTATE_WIDEST], g[ROTATE_WIDEST];
    if (halves) {
      f[l] = vreal_load(h + k);
#pragma GCC unroll 16
      for (int m = 1; m <= l; m++) {
        const vreal hm = vreal_load(h + m * TILE + k);
        f[l + m] = vreal_load(cc + m * TILE) * hm, f[l - m] = vreal_load(sc + m * TILE) * hm;
      }
    } else {
#pragma GCC unroll 16
      for (int i = 0; i <= 2 * l; i++) g[i] = vreal_load(x + i * TILE + k);
      each_about(l, cc, sc, g, f);
    }
    each_rest(l, a->c[0][0] + k, a->s[0][0] + k, a->c[1][0] + k, a->s[1][0] + k, f, g);
#pragma GCC unroll 16
    for (int i = 0; i <= 2 * l; i++) vreal_store(x + i * TILE + k, g[i]);
  }
}

#define EACH_LOW_OF(l)                                                                             \
  static void each_low_##l(const each_angles *a, const real *h, real *x) {                         \
    each_low(l, false, a, h, x);                                                                   \
  }                                                                                                \
  static void each_half_##l(const each_angles *a, const real *h, real *x) {                        \
    each_low(l, true, a, h, x);                                                                    \
  }
EACH_LOW_OF(1)
EACH_LOW_OF(2)
EACH_LOW_OF(3)
EACH_LOW_OF(4)
EACH_LOW_OF(5)
EACH_LOW_OF(6)
static void (*const each_lows[2][ROTATE_LOW + 1])(const each_angles *, const real *, real *) = {
    {NULL, each_low_1, each_low_2, each_low_3, each_low_4, each_low_5, each_low_6},
    {NULL, each_half_1, each_half_2, each_half_3, each_half_4, each_half_5, each_half_6}};

/* Where degree l stands in a row. */
static size_t each_at(bool halves, int l) {
  return halves ? (size_t)(l * (l + 1) / 2) : (size_t)l * (size_t)l;
}

/* Turns degrees first .. last of TILE rows: x [..][TILE], from h where rows hold m >= 0 alone; y: room. */
static void each_turns(const ylm_sh_rotator *p, int first, int last, bool halves,
                       const each_angles *a, real *x, real *y, const real *h) {
  for (int l = first; l <= last; l++) {
    real *xl = x + (l * l - first * first) * TILE;
    const real *hl = h + (each_at(true, l) - each_at(true, first)) * TILE;
    if (l == 0) {
      if (halves) memcpy(xl, hl, TILE * sizeof *xl);
    } else if (l <= ROTATE_LOW) {
      each_lows[halves][l](a, hl, xl);
    } else {
      if (halves)
        each_unfold(l, a->c[2], a->s[2], hl, xl);
      else
        each_turn(l, a->c[2], a->s[2], xl);
      each_degree(p, l, a, xl, y);
    }
  }
}

/* Degrees first .. last of TILE rows, of which so many numbers can be read behind the last one's first; room for what
   they are. */
static void each_degrees(const ylm_sh_rotator *p, int first, int last, bool halves,
                         const each_angles *a, const real *const *in, size_t readable,
                         real *const *out, real *x, real *y, real *h) {
  size_t from = each_at(halves, first), to = (size_t)first * (size_t)first;
  int n_in = (int)(each_at(halves, last + 1) - from), n = (last + 1) * (last + 1) - first * first;
  for (int k = 0; k < TILE; k += LANES)
    if (first == 0)
      to_tile_within(in + k, n_in, readable, (halves ? h : x) + k, TILE);
    else
      to_tile(in + k, from, n_in, (halves ? h : x) + k, TILE);
  each_turns(p, first, last, halves, a, x, y, h);
  for (int k = 0; k < TILE; k += LANES) from_tile(x + k, TILE, n, to, out + k);
}

static void each(const ylm_sh_rotator *p, int lmax, size_t n, const real *r, int rows, bool halves,
                 const real *in, real *out) {
  size_t width = each_at(halves, lmax + 1), count = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  size_t total = n * (size_t)rows;
  each_angles a;
  real x[(EACH_COUNT > EACH_WIDEST ? EACH_COUNT : EACH_WIDEST) * TILE] __attribute__((aligned(64)));
  real h[EACH_COUNT * TILE] __attribute__((aligned(64)));
  real y[EACH_WIDEST * TILE] __attribute__((aligned(64)));
  real turns[9 * TILE] __attribute__((aligned(64)));
  int low = lmax < EACH_LOW ? lmax : EACH_LOW;
  const real *turn = r;
  int row = 0; /* of the rotation `turn` */
  for (size_t at = 0; at < total; at += TILE) {
    const real *from[TILE], *by[TILE];
    real *to[TILE];
    size_t last = at + TILE < total ? at + TILE - 1 : total - 1;
    for (size_t i = 0; i < TILE; i++) { /* what is missing repeats the last row */
      size_t k = at + i < last ? at + i : last;
      by[i] = turn;
      if (k < last || i + 1 == TILE) {
        turn += row + 1 == rows ? 9 : 0;
        row = row + 1 == rows ? 0 : row + 1;
      }
      from[i] = in + k * width;
      to[i] = out + k * count;
    }
    size_t left = (size_t)(r + 9 * n - by[TILE - 1]), readable = (total - last) * width;
    for (int k = 0; k < TILE; k += LANES) to_tile_within(by + k, 9, left, turns + k, TILE);
    each_begin(turns, lmax, &a);
    each_degrees(p, 0, low, halves, &a, from, readable, to, x, y, h);
    for (int l = low + 1; l <= lmax; l++)
      each_degrees(p, l, l, halves, &a, from, readable, to, x, y, h);
  }
}

/* Rows of points whose numbers are point[at ..], TILE of n, each by the point's rotation. */
typedef struct each_turned {
  const ylm_sh_rotator *p;
  int lmax, rows;
  bool halves;
  size_t n;
  const size_t *point;
  const real *r, *in;
  real *turned, *h; /* [rows][count][TILE]; [count][TILE] */
} each_turned;

/* Numbers of the points: i_of [TILE]. Places behind n repeat the last point. */
static void turn_points(const each_turned *j, size_t at, size_t *i_of) {
  size_t n = j->n, rows = (size_t)j->rows, width = each_at(j->halves, j->lmax + 1);
  size_t count = (size_t)(j->lmax + 1) * (size_t)(j->lmax + 1);
  size_t left = j->point[n - 1] + 1 - j->point[at + TILE < n ? at + TILE - 1 : n - 1];
  real turns[9 * TILE] __attribute__((aligned(64)));
  real y[(2 * EACH_LOW + 1) * TILE] __attribute__((aligned(64)));
  const real *frame[TILE];
  each_angles a;
  for (size_t i = 0; i < TILE; i++) {
    i_of[i] = j->point[at + i < n ? at + i : n - 1];
    frame[i] = j->r + 9 * i_of[i];
  }
  for (int k = 0; k < TILE; k += LANES) to_tile_within(frame + k, 9, 9 * left, turns + k, TILE);
  each_begin(turns, j->lmax, &a);
  for (size_t row = 0; row < rows; row++) {
    const real *from[TILE];
    real *x = j->turned + row * count * TILE;
    for (size_t i = 0; i < TILE; i++) from[i] = j->in + (i_of[i] * rows + row) * width;
    for (int k = 0; k < TILE; k += LANES)
      to_tile_within(from + k, (int)width, left * width, (j->halves ? j->h : x) + k, TILE);
    each_turns(j->p, 0, j->lmax, j->halves, &a, x, y, j->h);
  }
}

/* `rows` rows of n points, whose numbers are `point`, each by the point's rotation, then times its factor;
   stage: seconds of either are added. */
static void times(const ylm_sh_rotator *p, const ylm_sh_product *q, size_t n, const size_t *point,
                  const real *r, int rows, bool halves, const real *in, const real *const *factor,
                  real *out, real *scratch, double *stage) {
  shared_plan plan;
  real weights[ROTATE_TIMES_LMAX + 1];
  shared_begin(q, weights, &plan);
  int lmax = plan.lmax;
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  real *turned = scratch, *h = turned + (size_t)rows * count * TILE, *f = h + count * TILE,
       *product = f + count * LANES, *room = product + count * LANES;
  const each_turned turn = {p, lmax, rows, halves, n, point, r, in, turned, h};
  double time = ylm_seconds();
  for (size_t at = 0; at < n; at += TILE) {
    size_t i_of[TILE];
    turn_points(&turn, at, i_of);
    double now = ylm_seconds();
    stage[0] += now - time;
    for (size_t k = 0; k < TILE && at + k < n; k += LANES) {
      const real *by[LANES];
      real *to[LANES];
      for (size_t i = 0; i < LANES; i++) by[i] = factor[i_of[k + i]];
      to_tile(by, 0, (int)count, f, LANES);
      shared_factor(&plan, f, LANES, room);
      for (int row = 0; row < rows; row++) {
        shared_times(&plan, turned + (size_t)row * count * TILE + k, TILE, room, product, LANES);
        for (size_t i = 0; i < LANES; i++)
          to[i] = out + (i_of[k + i] * (size_t)rows + (size_t)row) * count;
        from_tile(product, LANES, (int)count, 0, to);
      }
    }
    time = ylm_seconds();
    stage[1] += time - now;
  }
}

/* Integrals of rows, c [count] vectors, times light [3] rows that all lanes have. */
static void each_dots(size_t count, const real *c, int pitch, const real *const *light,
                      vreal *out) {
  vreal even[3], odd[3];
  for (int k = 0; k < 3; k++) even[k] = odd[k] = vreal_set(0);
  size_t i = 0;
  for (; i + 2 <= count; i += 2) {
    vreal a = vreal_load(c + (int)i * pitch), b = vreal_load(c + (int)(i + 1) * pitch);
    for (int k = 0; k < 3; k++) {
      even[k] += a * vreal_set(light[k][i]);
      odd[k] += b * vreal_set(light[k][i + 1]);
    }
  }
  for (int k = 0; k < 3; k++) {
    if (i < count) even[k] += vreal_load(c + (int)i * pitch) * vreal_set(light[k][i]);
    out[k] = even[k] + odd[k];
  }
}

/* As times, then times light [3], mixed: sums over rows of mix[k][row] times the integral by light k. factor: NULL,
   none of the points has one. */
static void integrate(const ylm_sh_rotator *p, const ylm_sh_product *q, size_t n,
                      const size_t *point, const real *r, int rows, bool halves, const real *in,
                      const real *const *factor, const real *const *light, const real (*mix)[3],
                      real *out, real *scratch, double *stage) {
  shared_plan plan, plain;
  real weights[ROTATE_TIMES_LMAX + 1], ones[ROTATE_TIMES_LMAX + 1];
  double time = ylm_seconds();
  shared_begin(q, weights, &plan);
  size_t count = (size_t)(plan.lmax + 1) * (size_t)(plan.lmax + 1);
  real *turned = scratch, *h = turned + (size_t)rows * count * TILE, *f = h + count * TILE,
       *room = f + count * LANES, *nodes = room + product_shared_scratch(q, LANES);
  const each_turned turn = {p, plan.lmax, rows, halves, n, point, r, in, turned, h};
  for (int i = 0; i < plan.half; i++) ones[i] = 1;
  plain = plan;
  plain.weights = ones;
  if (factor) shared_lights(&plain, light, room, f, nodes);
  for (size_t at = 0; at < n; at += TILE) {
    size_t i_of[TILE];
    double now = ylm_seconds();
    stage[1] += now - time;
    turn_points(&turn, at, i_of);
    time = ylm_seconds();
    stage[0] += time - now;
    for (size_t k = 0; k < TILE && at + k < n; k += LANES) {
      const real *by[LANES];
      real to[3 * LANES] __attribute__((aligned(64)));
      vreal sum[3] = {vreal_set(0), vreal_set(0), vreal_set(0)}, one[3];
      if (factor) {
        for (size_t i = 0; i < LANES; i++) by[i] = factor[i_of[k + i]];
        to_tile(by, 0, (int)count, f, LANES);
        shared_factor(&plan, f, LANES, room);
      }
      for (int row = 0; row < rows; row++) {
        const real *c = turned + (size_t)row * count * TILE + k;
        if (factor)
          shared_integrals(&plan, c, TILE, room, nodes, one);
        else
          each_dots(count, c, TILE, light, one);
        for (int l = 0; l < 3; l++) sum[l] += one[l] * vreal_set(mix[l][row]);
      }
      for (int l = 0; l < 3; l++) vreal_store(to + l * LANES, sum[l]);
      for (size_t i = 0; i < LANES; i++)
        for (size_t l = 0; l < 3; l++) out[3 * i_of[k + i] + l] = to[l * LANES + i];
    }
  }
  stage[1] += ylm_seconds() - time;
}

/* The first of n matrices [9] that is no rotation, nearly; n: there is none. */
static size_t not_rotation(size_t n, const real *r) {
  for (size_t at = 0; at < n; at += LANES) {
    real t[9 * LANES] __attribute__((aligned(64)));
    const real *by[LANES];
    size_t last = at + LANES < n ? at + LANES - 1 : n - 1;
    for (size_t i = 0; i < LANES; i++) by[i] = r + 9 * (at + i < last ? at + i : last);
    to_tile_within(by, 9, 9 * (n - last), t, LANES);
    vreal v[9], off = vreal_set(0);
    for (int q = 0; q < 9; q++) v[q] = vreal_load(t + q * LANES);
    for (int i = 0; i < 3; i++)
      for (int j = i; j < 3; j++) {
        vreal d = v[i] * v[j] + v[3 + i] * v[3 + j] + v[6 + i] * v[6 + j] - (real)(i == j);
        off += d * d;
      }
    vreal volume = v[0] * (v[4] * v[8] - v[5] * v[7]) - v[1] * (v[3] * v[8] - v[5] * v[6]) +
                   v[2] * (v[3] * v[7] - v[4] * v[6]);
    vmask good = (off <= (real)(ROTATE_NEAR * ROTATE_NEAR)) & (volume > 0); /* not of NaN */
    for (size_t i = 0; i < LANES; i++)
      if (!good[i] && at + i < n) return at + i;
  }
  return n;
}

#endif
