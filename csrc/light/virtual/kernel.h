/* kernel.h - sums over virtual lights for the unit's element type: lanes are points. plan.h says what is summed.
   Private to the folder. */
#ifndef YLM_LIGHT_VIRTUAL_KERNEL_H
#define YLM_LIGHT_VIRTUAL_KERNEL_H

#include "distance.h"
#include "emission.h"

#include "../moments/gen/compensation.h"
#include "../moments/gen/recurrences.h"

#ifdef YLM_REAL_IS_FLOAT
#define COEF coef_f
#define ROWS_OF(p) ((p)->lights->seen)
#else
#define COEF coef
#define ROWS_OF(p) ((p)->seen)
#endif

/* eps^2 of a smooth light over sg^2. */
#define SOFT ((real)(YLM__GAUSS_SOFT * YLM__GAUSS_SOFT))

/* Sums of ../gen. */
#define STRAIGHT YLM_REAL_KERNEL(ylm__virtual_straight)
extern const ylm__virtual_straight STRAIGHT;

/* Bytes of a tile that stay in the first cache beside the sums, and of sums that do; fewest lights of a tile; lights of
   a tile of products. Measured on 48 KiB of cache with 512-bit vectors. */
enum { STRAIGHT_BYTES = 12288, SUM_BYTES = 40960, STRAIGHT_LEAST = 4, PRODUCT_TILE = 8 };
enum { ARRAYS = 8, TILE = YLM__VIRTUAL_TILE, TOP = YLM_LIGHT_LMAX + 2 };

/* -- rows ----------------------------------------------------------------------------------- */

/* Weights of rows, by the degree of their harmonic; block 2 beyond 0 and 1. */
typedef struct weights {
  vreal value[TOP + 1], up[TOP + 1], down[TOP + 1], upup[TOP + 1], same[TOP + 1], downdown[TOP + 1];
} weights;

YLM_INLINE void weigh(const int lmax, const int order, const vreal *B, vreal invd, weights *w) {
  vreal inv2 = invd * invd;
  for (int l = 0; l <= lmax; l++) {
    const vreal b0 = B[4 * l], b1 = B[4 * l + 1], b2 = B[4 * l + 2];
    const real n = (real)l;
    w->value[l] = b0;
    if (order < 1) continue;
    w->up[l + 1] = (b1 - n * b0) * invd;
    if (l) w->down[l - 1] = (b1 + (n + 1) * b0) * invd;
    if (order < 2) continue;
    w->upup[l + 2] = (b2 - (2 * n + 2) * b1 + n * (n + 2) * b0) * inv2;
    w->same[l] = (b2 + b1 - n * (n + 1) * b0) * inv2;
    if (l > 1) w->downdown[l - 2] = (b2 + 2 * n * b1 + (n * n - 1) * b0) * inv2;
  }
}

/* The rows that have the harmonic at place `at` of degree k, q. */
YLM_INLINE void put_rows(const int lmax, const int order, const weights *w, const int k,
                         const int at, vreal q, vreal *S) {
  const int n0 = (lmax + 1) * (lmax + 1), n1 = (lmax + 2) * (lmax + 2) - 1;
  const int once = n0, twice = n0 + n1 + lmax * lmax, same = twice + (lmax + 3) * (lmax + 3) - 4;
  if (k <= lmax) S[at] = q * w->value[k];
  if (order < 1) return;
  if (k > 0 && k <= lmax + 1) S[once + at - 1] = q * w->up[k];
  if (k < lmax) S[once + n1 + at] = q * w->down[k];
  if (order < 2) return;
  if (k > 1) S[twice + at - 4] = q * w->upup[k];
  if (k <= lmax) S[same + at] = q * w->same[k];
  if (k < lmax - 1) S[same + n0 + at] = q * w->downdown[k];
}

/* All rows of a light. */
YLM_INLINE void make_rows(const int lmax, const int order, const double *beta, const weights *w,
                          vreal x, vreal y, vreal z, vreal *S) {
  const int top = lmax + order, across = lmax + 3;
  vreal c = vreal_set(1), s = vreal_set(0);
#pragma GCC unroll 8
  for (int m = 0; m <= top; m++) {
    vreal a = c, b = s, a0 = vreal_set(0), b0 = a0;
#pragma GCC unroll 8
    for (int k = m; k <= top; k++) {
      put_rows(lmax, order, w, k, k * (k + 1) + m, a, S);
      if (m) put_rows(lmax, order, w, k, k * (k + 1) - m, b, S);
      if (k == top) break;
      const real t = k == m                         ? 0
                     : lmax <= YLM__VIRTUAL_SPECIAL ? (real)YLM__BETA(k, m)
                                                    : (real)beta[k * across + m];
      vreal next = z * a - t * a0;
      a0 = a, a = next;
      if (!m) continue;
      next = z * b - t * b0;
      b0 = b, b = next;
    }
    vreal next = c * x - s * y;
    s = c * y + s * x;
    c = next;
  }
}

/* -- products ------------------------------------------------------------------------------- */

/* Sums [C][..] of R rows in C channels grow by those of n lights; numbers of a light are this far from the
   next's. */
YLM_INLINE void multiply_block(const int R, const int C, int n, const vreal *S, size_t S_step,
                               const vreal *E, size_t E_step, vreal *to, size_t to_step) {
  vreal a[32];
#pragma GCC unroll 8
  for (int c = 0; c < C; c++)
#pragma GCC unroll 16
    for (int r = 0; r < R; r++) a[c * R + r] = to[(size_t)c * to_step + (size_t)r];
  for (int j = 0; j < n; j++, S += S_step, E += E_step) {
    vreal row[16];
#pragma GCC unroll 16
    for (int r = 0; r < R; r++) row[r] = S[r];
#pragma GCC unroll 8
    for (int c = 0; c < C; c++) {
      const vreal e = E[c];
#pragma GCC unroll 16
      for (int r = 0; r < R; r++) a[c * R + r] += row[r] * e;
    }
  }
#pragma GCC unroll 8
  for (int c = 0; c < C; c++)
#pragma GCC unroll 16
    for (int r = 0; r < R; r++) to[(size_t)c * to_step + (size_t)r] = a[c * R + r];
}

/* Rows that fit into registers, of six channels, of three, of one. */
#if defined(__AVX512F__) || defined(__aarch64__)
#define ROWS_6 4
#define ROWS_3 7
#define ROWS_1 12
#else
#define ROWS_6 2
#define ROWS_3 3
#define ROWS_1 7
#endif

YLM_INLINE void multiply_channels(const int R, const int C, size_t rows, int n, const vreal *S,
                                  size_t S_step, const vreal *E, size_t E_step, vreal *to) {
  size_t r = 0;
  for (; r + (size_t)R <= rows; r += (size_t)R)
    multiply_block(R, C, n, S + r, S_step, E, E_step, to + r, rows);
  for (; r < rows; r++) multiply_block(1, C, n, S + r, S_step, E, E_step, to + r, rows);
}

static void multiply(size_t rows, int channels, int n, const vreal *S, size_t S_step,
                     const vreal *E, size_t E_step, vreal *to) {
  int c = 0;
  for (; c + 6 <= channels; c += 6)
    multiply_channels(ROWS_6, 6, rows, n, S, S_step, E + c, E_step, to + (size_t)c * rows);
  for (; c + 3 <= channels; c += 3)
    multiply_channels(ROWS_3, 3, rows, n, S, S_step, E + c, E_step, to + (size_t)c * rows);
  for (; c < channels; c++)
    multiply_channels(ROWS_1, 1, rows, n, S, S_step, E + c, E_step, to + (size_t)c * rows);
}

/* -- lights --------------------------------------------------------------------------------- */

/* A light of the tile at the points: w, the squared distance, 1/d, 1/D, n.u, e^(-sg^2/d^2), and the cosine, 0 where it
   sends nothing. */
typedef struct sight {
  vreal w[3], d2, inv, inverse, along, heat, cosine;
} sight;

typedef struct work {
  vreal *S, *E, *B;         /* [TILE][width], [TILE][numbers], [TILE][4 (lmax+1)] */
  vreal *sum, *part, *lost; /* [sums] */
  vreal *mixed, *out;       /* [sums of three channels], [6 count] */
  double beta[(YLM_LIGHT_VIRTUAL_DEGREE + 1) * (YLM_LIGHT_VIRTUAL_DEGREE + 1)];
  weights weights;
  sight sight[TILE];
  const real *lamp[TILE];
  const ylm__virtual_plan *of; /* of the lights in the tile */
  int tile, held;              /* lights that a tile takes, and has */
} work;

/* Of the recurrences of emissions. */
static void find_beta(double *beta) {
  for (int l = 1; l <= YLM_LIGHT_VIRTUAL_DEGREE; l++)
    for (int m = 0; m <= l; m++) beta[l * (YLM_LIGHT_VIRTUAL_DEGREE + 1) + m] = YLM__BETA(l, m);
}

/* Sizes of a work's arrays. */
static void sizes_of(const ylm__virtual_plan *p, size_t sizes[ARRAYS]) {
  sizes[0] = TILE * p->width, sizes[1] = TILE * (size_t)p->numbers;
  for (int i = 2; i < 6; i++) sizes[i] = p->sums;
  sizes[6] = 6 * (size_t)(p->lmax + 1) * (size_t)(p->lmax + 1);
  sizes[7] = 4 * (size_t)(p->lmax + 1);
}

static size_t room_of(const ylm__virtual_plan *p) {
  size_t sizes[ARRAYS], all = 0;
  sizes_of(p, sizes);
  for (int i = 0; i < ARRAYS; i++) all += sizes[i];
  return all;
}

static int tile_of(const ylm__virtual_plan *p) {
  const size_t width = p->slopes ? p->factors + 6 * ((size_t)p->lmax + 1) : p->width;
  const size_t fit = STRAIGHT_BYTES / (width * sizeof(vreal));
  if (!p->straight) return PRODUCT_TILE;
  if (p->sums * sizeof(vreal) > SUM_BYTES) return TILE;
  return fit < STRAIGHT_LEAST ? STRAIGHT_LEAST : fit < TILE ? (int)fit : TILE;
}

/* A work whose arrays are at x, of room_of vectors. */
static void work_place(work *k, const ylm__virtual_plan *p, vreal *x) {
  size_t sizes[ARRAYS];
  vreal **slots[] = {&k->S, &k->E, &k->sum, &k->part, &k->lost, &k->mixed, &k->out, &k->B};
  sizes_of(p, sizes);
  for (int i = 0; i < ARRAYS; i++) *slots[i] = x, x += sizes[i];
  find_beta(k->beta);
  k->tile = tile_of(p);
  k->held = 0;
  k->of = p;
}

/* -- stages, each made for what it is constant in ------------------------------------------- */

/* Weights [lmax+1][4] of a light. */
typedef void weigh_fn(const ylm__virtual_plan *p, const real *lamp, const sight *s, vreal *B);
typedef void rows_fn(const ylm__virtual_plan *p, const weights *w, const vreal u[3], vreal *S);
typedef void send_fn(const seen *s, int degree, const double *beta, const real *lamp, vreal *E);

YLM_INLINE falloff fall_of(const int profile, const int order, const ylm__virtual_plan *p,
                           const real *lamp, const sight *s) {
  return begin_fall(profile, order, lamp, (real)p->lights->core, (real)p->lights->outer, s->d2,
                    s->inv * s->inv, s->heat);
}

#define WEIGH(profile, order)                                                                      \
  static void weigh_##profile##_##order(const ylm__virtual_plan *p, const real *lamp,              \
                                        const sight *s, vreal *B) {                                \
    if (YLM_LIGHT_VIRTUAL_##profile == YLM_LIGHT_VIRTUAL_CAP)                                      \
      cap(p->lmax, order, 4, lamp, s->d2, s->inv * s->inv, B);                                     \
    else                                                                                           \
      smooth(p->lmax, order, fall_of(YLM_LIGHT_VIRTUAL_##profile, order, p, lamp, s), B);          \
  }
#define PROFILES(X, order)                                                                         \
  X(GAUSS, order) X(CAP, order) X(POINT, order) X(FAR, order) X(NEAR, order)
PROFILES(WEIGH, 0)
PROFILES(WEIGH, 1)
PROFILES(WEIGH, 2)
#define ENTRY(profile, order) weigh_##profile##_##order,
static weigh_fn *const weighers[3][5] = {
    {PROFILES(ENTRY, 0)}, {PROFILES(ENTRY, 1)}, {PROFILES(ENTRY, 2)}};

#define ROWS(lmax, order)                                                                          \
  static void rows_##lmax##_##order(const ylm__virtual_plan *p, const weights *w,                  \
                                    const vreal u[3], vreal *S) {                                  \
    make_rows(lmax, order, p->beta, w, u[0], u[1], u[2], S);                                       \
  }
#define DEGREES(X, order) X(0, order) X(1, order) X(2, order) X(3, order) X(4, order)
DEGREES(ROWS, 0)
DEGREES(ROWS, 1)
DEGREES(ROWS, 2)
#undef ENTRY
#define ENTRY(lmax, order) rows_##lmax##_##order,
#define ROWS_ANY(order)                                                                            \
  static void rows_any_##order(const ylm__virtual_plan *p, const weights *w, const vreal u[3],     \
                               vreal *S) {                                                         \
    make_rows(p->lmax, order, p->beta, w, u[0], u[1], u[2], S);                                    \
  }
ROWS_ANY(0)
ROWS_ANY(1)
ROWS_ANY(2)
static rows_fn *const makers[3][YLM__VIRTUAL_SPECIAL + 2] = {
    {DEGREES(ENTRY, 0) rows_any_0}, {DEGREES(ENTRY, 1) rows_any_1}, {DEGREES(ENTRY, 2) rows_any_2}};

#define SEND(name, order, first, channels)                                                         \
  static void name##_##order(const seen *s, int degree, const double *beta, const real *lamp,      \
                             vreal *E) {                                                           \
    send(s, order, degree, beta, lamp, first, channels, E);                                        \
  }
SEND(rgb, 0, 0, 3)
SEND(rgb, 1, 0, 3)
SEND(rgb, 2, 0, 3)
SEND(lum, 0, 3, 1)
SEND(lum, 1, 3, 1)
SEND(lum, 2, 3, 1)
static send_fn *const senders[2][3] = {{rgb_0, rgb_1, rgb_2}, {lum_0, lum_1, lum_2}};

/* Derivatives of distances, and of emissions. */
static int order_of(int kinds) { return kinds & 12 ? 2 : kinds & 2 ? 1 : 0; }
static int jet_of(int kinds) { return kinds & 4 ? 2 : kinds & 2 ? 1 : 0; }

/* -- straight sums -------------------------------------------------------------------------- */

static bool is_sharp(ylm_light_virtual_profile profile) {
  return profile == YLM_LIGHT_VIRTUAL_POINT || profile == YLM_LIGHT_VIRTUAL_CAP;
}

/* Without a normal. */
YLM_INLINE bool is_round(const real *lamp) {
  const real *n = lamp + YLM__VIRTUAL_NORMAL;
  return n[0] == 0 && n[1] == 0 && n[2] == 0;
}

/* Whether a light's colours differ by a factor, and its distances have a logarithm. */
static bool is_one(const ylm__virtual_plan *p) {
  const ylm_light_virtual_profile profile = p->lights->profile;
  return p->lights->degree == 0 &&
         (profile == YLM_LIGHT_VIRTUAL_GAUSS || profile == YLM_LIGHT_VIRTUAL_POINT ||
          profile == YLM_LIGHT_VIRTUAL_FAR);
}

/* Factors of values: colours [3], [lmax+1]. */
static void put_values(int lmax, const vreal *B, const vreal E[3], vreal *e) {
  for (int c = 0; c < 3; c++) e[c] = E[c];
  for (int l = 0; l <= lmax; l++) e[3 + l] = B[4 * l];
}

YLM_INLINE void fall_values(int lmax, falloff f, const vreal E[3], vreal *e) {
  for (int c = 0; c < 3; c++) e[c] = E[c];
  f.h *= f.a[0];
  for (int l = 0; l <= lmax; l++, go_on(&f)) e[3 + l] = f.h;
}

/* Factors of values and gradients: d, then [lmax+1][12]: colours over d, and the gradient's logarithm, d B1/B0 w -
   l w + d grad E/E; by x and y it is doubled. */
YLM_INLINE void fall_slopes(int lmax, falloff f, const sight *s, const real *n, const vreal E[3],
                            vreal *e) {
  const vreal once = inverse(larger(s->cosine, vreal_set(TINY))), inv = s->inv, *w = s->w;
  const vreal d = s->d2 * inv, part = d * s->inverse, bent = part * part * (s->along * once);
  const vreal back = -part * once, twice = back + back;
  const vreal N[3] = {n[0] * twice, n[1] * twice, n[2] * back}, W[3] = {2 * w[0], 2 * w[1], w[2]};
  const vreal D[3] = {E[0] * inv, E[1] * inv, E[2] * inv};
  *e++ = d;
  f.h *= f.a[0];
  f.steep -= bent;
  for (int l = 0; l <= lmax; l++, e += 12, go_on(&f)) {
    const vreal along = f.q + (f.steep - f.n);
    for (int c = 0; c < 3; c++) e[c] = D[c] * f.h;
    for (int a = 0; a < 3; a++) e[3 + a] = W[a] * along + N[a];
  }
}

/* As that, of lights whose colours differ; E: jets [4][3]. */
static void put_each(int lmax, const vreal *B, const vreal *E, const sight *s, vreal *e) {
  const vreal inv = s->inv, *w = s->w;
  vreal F[9], W[9], D[3];
  for (int c = 0; c < 3; c++) D[c] = E[c] * inv;
  for (int a = 0; a < 3; a++)
    for (int c = 0; c < 3; c++) {
      const vreal f = E[3 + 3 * a + c], g = w[a] * D[c];
      F[3 * a + c] = a < 2 ? f + f : f, W[3 * a + c] = a < 2 ? g + g : g;
    }
  *e++ = s->d2 * inv;
  for (int l = 0; l <= lmax; l++, e += 12) {
    const vreal b = B[4 * l], up = B[4 * l + 1] - (real)l * b;
    for (int c = 0; c < 3; c++) e[c] = D[c] * b;
    for (int i = 0; i < 9; i++) e[3 + i] = W[i] * up + F[i] * b;
  }
}

/* Factors [lmax+3][3] of second derivatives: of degrees l+2, l, l-2. */
YLM_INLINE void bend_factors(const int l, const vreal b0, const vreal b1, const vreal b2,
                             vreal *e) {
  const real n = (real)l;
  e[3 * (l + 2)] = b2 - (2 * n + 2) * b1 + n * (n + 2) * b0;
  e[3 * l + 1] = b2 + b1 - n * (n + 1) * b0;
  if (l > 1) e[3 * (l - 2) + 2] = b2 + 2 * n * b1 + (n * n - 1) * b0;
}

YLM_INLINE vreal bright_of(const vreal E[3], vreal inv) {
  return ((real)YLM_LUMINANCE_R * E[0] + (real)YLM_LUMINANCE_G * E[1] +
          (real)YLM_LUMINANCE_B * E[2]) *
         (inv * inv);
}

static void put_bends(int lmax, const vreal *B, const vreal E[3], vreal inv, vreal *e) {
  const vreal all = bright_of(E, inv);
  for (int l = 0; l <= lmax; l++)
    bend_factors(l, all * B[4 * l], all * B[4 * l + 1], all * B[4 * l + 2], e);
}

YLM_INLINE void fall_bends(int lmax, falloff f, const vreal E[3], vreal inv, vreal *e) {
  f.h *= bright_of(E, inv);
  for (int l = 0; l <= lmax; l++, go_on(&f)) {
    const vreal *a = f.a, q = f.q;
    bend_factors(l, f.h * a[0], f.h * (a[1] + q * a[0]),
                 f.h * (a[2] + q * (2 * a[1] + (q - 2) * a[0])), e);
  }
}

static void seen_of(const sight *s, const real *lamp, seen *to) {
  const vmask front = s->cosine > 0;
  const vreal part = -s->d2 * s->inv * s->inverse;
  to->inverse = s->inverse;
  to->cosine = s->cosine;
  for (int a = 0; a < 3; a++) {
    to->u[a] = s->w[a] * part;
    to->normal[a] = keep_lanes(front, vreal_set(lamp[YLM__VIRTUAL_NORMAL + a]));
  }
}

YLM_INLINE void colours_of(const ylm__virtual_plan *p, const work *k, int j, send_fn *sender,
                           vreal *E) {
  const real *lamp = k->lamp[j];
  if (sender) {
    seen of;
    seen_of(&k->sight[j], lamp, &of);
    sender(&of, p->lights->degree, k->beta, lamp, E);
  } else
    for (int c = 0; c < 3; c++) E[c] = k->sight[j].cosine * lamp[YLM__VIRTUAL_EMISSION + c];
}

/* Factors of the tile's lights; `one`: of slopes too, `bend`: and of second derivatives. */
typedef void fall_fn(const ylm__virtual_plan *p, work *k, send_fn *sender);
#define FALL(profile, one, bend)                                                                   \
  static void fall_##profile##_##one##bend(const ylm__virtual_plan *p, work *k, send_fn *sender) { \
    for (int j = 0; j < k->held; j++) {                                                            \
      const sight *s = &k->sight[j];                                                               \
      const real *lamp = k->lamp[j];                                                               \
      vreal E[3], *t = k->S + (size_t)j * p->width, *e = t + p->factors;                           \
      colours_of(p, k, j, sender, E);                                                              \
      const falloff f = fall_of(YLM_LIGHT_VIRTUAL_##profile, bend ? 2 : one, p, lamp, s);          \
      if (one)                                                                                     \
        fall_slopes(p->lmax, f, s, lamp + YLM__VIRTUAL_NORMAL, E, e);                              \
      else                                                                                         \
        fall_values(p->lmax, f, E, e);                                                             \
      if (bend) fall_bends(p->lmax, f, E, s->inv, t + p->bent);                                    \
    }                                                                                              \
  }
#define SMOOTH(profile)                                                                            \
  FALL(profile, 0, 0) FALL(profile, 1, 0) FALL(profile, 0, 1) FALL(profile, 1, 1)
SMOOTH(GAUSS)
SMOOTH(POINT)
SMOOTH(FAR)
FALL(NEAR, 0, 0)
FALL(NEAR, 0, 1)
static void fall_CAP_00(const ylm__virtual_plan *p, work *k, send_fn *sender) {
  for (int j = 0; j < k->held; j++) {
    const sight *s = &k->sight[j];
    vreal *e = k->S + (size_t)j * p->width + p->factors, E[3];
    colours_of(p, k, j, sender, E);
    for (int c = 0; c < 3; c++) e[c] = E[c];
    cap(p->lmax, 0, 1, k->lamp[j], s->d2, s->inv * s->inv, e + 3);
  }
}
static fall_fn *const falls[2][2][5] = {
    {{fall_GAUSS_00, fall_CAP_00, fall_POINT_00, fall_FAR_00, fall_NEAR_00},
     {fall_GAUSS_01, NULL, fall_POINT_01, fall_FAR_01, fall_NEAR_01}},
    {{fall_GAUSS_10, NULL, fall_POINT_10, fall_FAR_10, NULL},
     {fall_GAUSS_11, NULL, fall_POINT_11, fall_FAR_11, NULL}}};

/* Factors of the tile's lights by weights. */
static void put_factors(const ylm__virtual_plan *p, work *k, send_fn *sender) {
  weigh_fn *weigh_light = weighers[order_of(p->kinds)][p->lights->profile];
  for (int j = 0; j < k->held; j++) {
    const sight *s = &k->sight[j];
    const real *lamp = k->lamp[j];
    vreal *t = k->S + (size_t)j * p->width, *e = t + p->factors, E[3 * 4];
    weigh_light(p, lamp, s, k->B);
    colours_of(p, k, j, sender, E);
    if (!p->slopes)
      put_values(p->lmax, k->B, E, e);
    else
      put_each(p->lmax, k->B, E, s, e);
    if (p->bends) put_bends(p->lmax, k->B, E, s->inv, t + p->bent);
  }
}

static void sum_straight(const ylm__virtual_plan *p, work *k) {
  ylm__virtual_sum *sum = !p->slopes ? STRAIGHT.value : is_one(p) ? STRAIGHT.one : STRAIGHT.each;
  STRAIGHT.harmonics(p->bends ? p->lmax + 2 : p->lmax, k->held, k->sight[0].w,
                     sizeof *k->sight / sizeof(vreal), k->S, p->width);
  const bool slopes = p->slopes && is_one(p);
  send_fn *sender = p->lights->degree || (p->slopes && !slopes) ? senders[0][p->slopes] : NULL;
  fall_fn *put = p->slopes == slopes ? falls[slopes][p->bends][p->lights->profile] : NULL;
  if (put)
    put(p, k, sender);
  else
    put_factors(p, k, sender);
  sum(p->lmax, k->held, k->S, p->width, p->factors, k->part);
  if (p->bends) STRAIGHT.bend(p->lmax, k->held, k->S, p->width, p->bent, k->part + p->bend_sums);
}

/* -- lights to tiles, tiles to sums --------------------------------------------------------- */

static void sum_products(const ylm__virtual_plan *p, work *k) {
  const size_t first[3] = {0, p->rows[0], p->rows[0] + p->rows[1]};
  const int order = order_of(p->kinds);
  rows_fn *make =
      makers[order][p->lmax <= YLM__VIRTUAL_SPECIAL ? p->lmax : YLM__VIRTUAL_SPECIAL + 1];
  for (int j = 0; j < k->held; j++) {
    const sight *s = &k->sight[j];
    seen of;
    seen_of(s, k->lamp[j], &of);
    weighers[order][p->lights->profile](p, k->lamp[j], s, k->B);
    weigh(p->lmax, order, k->B, s->inv, &k->weights);
    make(p, &k->weights, s->w, k->S + (size_t)j * p->width);
    for (int i = 0; i < 2; i++)
      if (p->of[i].kinds)
        senders[i][jet_of(p->of[i].kinds)](&of, p->lights->degree, k->beta, k->lamp[j],
                                           k->E + j * p->numbers + p->of[i].from);
  }
  for (int i = 0; i < p->products; i++) {
    const ylm__virtual_product *x = &p->product[i];
    multiply(p->rows[x->block], x->channels, k->held, k->S + first[x->block], p->width,
             k->E + x->from, (size_t)p->numbers, k->part + x->to);
  }
}

/* Adds the tile's lights to the sums. */
static void flush(const ylm__virtual_plan *q, work *k) {
  const ylm__virtual_plan *p = k->of;
  (void)q;
  if (!k->held) return;
  if (p->straight)
    sum_straight(p, k);
  else
    sum_products(p, k);
  k->held = 0;
}

/*
** Takes a light into the tile, unless it sends nothing to any lane; nor farther than the root of reach2, where that
** is above 0. The row must stay where it is until the tile is flushed, which happens where it is full. Plans of
** other lights may take turns, for one query.
*/
YLM_INLINE void add_light(const ylm__virtual_plan *p, work *k, const real *lamp, const vreal xyz[3],
                          const real reach2) {
  if (k->of != p &&
      (k->of->lights->degree != p->lights->degree || k->of->lights->profile != p->lights->profile))
    flush(p, k);
  k->of = p;
  const bool sharp = is_sharp(p->lights->profile), round = is_round(lamp);
  const real *n = lamp + YLM__VIRTUAL_NORMAL, shift = lamp[YLM__VIRTUAL_SHIFT];
  const real width2 = width2_of(lamp);
  vreal v[3];
  for (int a = 0; a < 3; a++) v[a] = lamp[a] - xyz[a];
  vreal d2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], D2 = d2;
  const vreal along = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
  vmask lit = along < 0;
  if (shift > 0 || round) lit = d2 >= 0;
  if (sharp) lit &= d2 > 0;
  if (reach2 > 0) lit &= d2 < reach2;
  if (!any(lit)) return;
  if (sharp)
    D2 = d2 = choose(d2 > 0, d2, vreal_set(1));
  else
    D2 += width2 * SOFT, d2 = larger(d2, vreal_set(NEAREST * width2));
  sight *s = &k->sight[k->held];
  s->d2 = d2;
  s->inverse = inverse_root(D2);
  const vreal inv = s->inv = inverse_root(d2);
  s->along = -along * s->inverse;
  const vreal c = round ? vreal_set(1) : shift + s->along;
  s->cosine = keep_lanes(lit & (c > 0), c);
  for (int a = 0; a < 3; a++) s->w[a] = v[a] * inv;
  if (!sharp) s->heat = decay(inv * inv * width2);
  k->lamp[k->held] = lamp;
  if (++k->held == k->tile) flush(p, k);
}

static void add_all(const ylm__virtual_plan *p, work *k, const vreal xyz[3]) {
  const size_t n = p->lights->n, stride = p->lights->stride;
  memset(k->sum, 0, p->sums * sizeof *k->sum);
  memset(k->lost, 0, p->sums * sizeof *k->lost);
  for (size_t first = 0; first < n; first += YLM__VIRTUAL_BLOCK) {
    size_t end = n - first < YLM__VIRTUAL_BLOCK ? n : first + YLM__VIRTUAL_BLOCK;
    memset(k->part, 0, p->sums * sizeof *k->part);
    for (size_t i = first; i < end; i++) add_light(p, k, ROWS_OF(p) + i * stride, xyz, 0);
    flush(p, k);
    for (size_t s = 0; s < p->sums; s++) add_part(k->part[s], &k->sum[s], &k->lost[s]);
  }
}

/* -- results -------------------------------------------------------------------------------- */

YLM_INLINE vreal row_times(const ylm__rows *A, size_t i, const vreal *x) {
  vreal s = vreal_set(0);
  for (uint32_t t = A->start[i]; t < A->start[i + 1]; t++) s += A->COEF[t] * x[A->index[t]];
  return s;
}

/* Where sums of a kind for a channel of `channels` lie: x are those of its first channel. */
static const ylm__virtual_sums *sums_of(const ylm__virtual_plan *p, const work *k, int kind,
                                        int channels, int c, const vreal **x, int *own) {
  bool mixed = channels == 1 && !(p->of[1].kinds & kind);
  *x = mixed ? k->mixed : k->sum;
  *own = channels == 3 ? c : 0;
  return &p->of[channels == 3 || mixed ? 0 : 1];
}

/* Luminance of sums of three channels, where the first channel's are. */
static void mix(const ylm__virtual_plan *p, work *k) {
  const ylm__virtual_sums *of = &p->of[0];
  if (p->straight || !(p->need & of->kinds)) return;
  for (int block = 0; block < 3; block++)
    for (int part = 0; part < PARTS; part++) {
      static const int needs[3][PARTS] = {{1, 2, 2, 2, 4, 4, 4, 4, 4, 4},
                                          {2, 4, 4, 4},
                                          {12}}; /* a kind of sums that has the part */
      if (!(of->kinds & needs[block][part])) continue;
      const size_t n = p->rows[block], at = of->at[block][part];
      const vreal *x = k->sum + at;
      for (size_t i = 0; i < n; i++)
        k->mixed[at + i] = (real)YLM_LUMINANCE_R * x[i] + (real)YLM_LUMINANCE_G * x[n + i] +
                           (real)YLM_LUMINANCE_B * x[2 * n + i];
    }
}

static void straight_value(const ylm__virtual_plan *p, const work *k, int channels, int c,
                           vreal *out) {
  const size_t wide = p->slopes ? 12 : 3;
  for (size_t i = 0; i < p->rows[0]; i++) {
    const vreal *x = k->sum + wide * i;
    out[i] = (real)p->scale[i] *
             (channels == 3 ? x[c]
                            : (real)YLM_LUMINANCE_R * x[0] + (real)YLM_LUMINANCE_G * x[1] +
                                  (real)YLM_LUMINANCE_B * x[2]);
  }
}

static void value_of(const ylm__virtual_plan *p, const work *k, int channels, int c, vreal *out) {
  const vreal *x;
  int own;
  if (p->straight) {
    straight_value(p, k, channels, c, out);
    return;
  }
  const ylm__virtual_sums *s = sums_of(p, k, 1, channels, c, &x, &own);
  x += s->at[0][0] + (size_t)own * p->rows[0];
  for (size_t i = 0; i < p->rows[0]; i++) out[i] = p->value.COEF[i] * x[i];
}

/* By x: minus those by v. */
static void gradient_of(const ylm__virtual_plan *p, const work *k, int channels, int c,
                        vreal *out) {
  const vreal *x;
  int own;
  for (size_t i = 0; p->straight && i < p->rows[0]; i++)
    for (size_t a = 0; a < 3; a++)
      out[3 * i + a] =
          (real)(a < 2 ? -0.5 : -1) * (real)p->scale[i] * k->sum[12 * i + 3 + 3 * a + (size_t)c];
  if (p->straight) return;
  const ylm__virtual_sums *s = sums_of(p, k, 2, channels, c, &x, &own);
  const size_t n0 = p->rows[0], n1 = p->rows[1], at = (size_t)own;
  for (size_t i = 0; i < n0; i++)
    for (size_t a = 0; a < 3; a++)
      out[3 * i + a] = -row_times(&p->once, 3 * i + a, x + s->at[1][0] + at * n1) -
                       p->value.COEF[i] * x[s->at[0][1 + a] + at * n0 + i];
}

YLM_INLINE void bend(const ylm__virtual_plan *p, const ylm__virtual_sums *s, const vreal *x,
                     size_t own, size_t i, vreal out[6]) {
  static const size_t row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
  const size_t n0 = p->rows[0], n1 = p->rows[1], n2 = p->rows[2];
  for (size_t q = 0; q < 6; q++)
    out[q] = row_times(&p->twice, 6 * i + q, x + s->at[2][0] + own * n2) +
             row_times(&p->once, 3 * i + row[q], x + s->at[1][1 + column[q]] + own * n1) +
             row_times(&p->once, 3 * i + column[q], x + s->at[1][1 + row[q]] + own * n1) +
             p->value.COEF[i] * x[s->at[0][4 + q] + own * n0 + i];
}

static void hessian_of(const ylm__virtual_plan *p, const work *k, int channels, int c, vreal *out) {
  const vreal *x;
  int own;
  const ylm__virtual_sums *s = sums_of(p, k, 4, channels, c, &x, &own);
  for (size_t i = 0; i < p->rows[0]; i++) bend(p, s, x, (size_t)own, i, out + 6 * i);
}

/* Writes rows of LANES numbers to points from `point` on, which have `stride` numbers each. */
static void put(const ylm__virtual_plan *p, const vreal *rows, size_t n, size_t point, int lanes,
                void *out, size_t first, size_t stride) {
  const real *from = (const real *)rows;
  for (int lane = 0; lane < lanes; lane++) {
    size_t at = (point + (size_t)lane) * stride + first;
    if (p->q->dtype == YLM_FLOAT)
      for (size_t i = 0; i < n; i++) ((float *)out)[at + i] = (float)from[i * LANES + (size_t)lane];
    else
      for (size_t i = 0; i < n; i++)
        ((double *)out)[at + i] = (double)from[i * LANES + (size_t)lane];
  }
}

static void results(const ylm__virtual_plan *p, work *k, size_t point, int lanes,
                    ylm_field_result *r) {
  const ylm_field_query *q = p->q;
  size_t n = p->rows[0], C = (size_t)q->channels;
  for (int c = 0; c < q->channels; c++) {
    if (q->want & YLM_WANT_VALUE) {
      value_of(p, k, q->channels, c, k->out);
      put(p, k->out, n, point, lanes, r->value, (size_t)c * n, C * n);
    }
    if (q->want & YLM_WANT_GRADIENT) {
      gradient_of(p, k, q->channels, c, k->out);
      put(p, k->out, 3 * n, point, lanes, r->gradient, (size_t)c * 3 * n, C * 3 * n);
    }
    if (q->want & YLM_WANT_HESSIAN) {
      hessian_of(p, k, q->channels, c, k->out);
      put(p, k->out, 6 * n, point, lanes, r->hessian, (size_t)c * 6 * n, C * 6 * n);
    }
  }
}

static void metric(const ylm__virtual_plan *p, work *k, size_t point, int lanes,
                   ylm_field_result *r) {
  const bool rough = p->q->want & YLM_WANT_ROUGH;
  int channels = p->q->metric_channels;
  vreal lambda = vreal_set(0), norm = lambda, h[6];
  for (int c = 0; c < channels; c++) {
    const vreal *x;
    int own;
    const ylm__virtual_sums *s = sums_of(p, k, rough ? 8 : 4, channels, c, &x, &own);
    const vreal *alike =
        p->straight ? k->sum + p->bend_sums : x + s->at[2][0] + (size_t)own * p->rows[2];
    for (size_t i = 0; i < p->rows[0]; i++) {
      if (rough)
        for (size_t j = 0; j < 6; j++) h[j] = row_times(&p->twice, 6 * i + j, alike);
      else
        bend(p, s, x, (size_t)own, i, h);
      vreal e = largest_eigenvalue(h);
      lambda += e * e;
    }
    value_of(p, k, channels, c, k->out);
    for (size_t i = 0; i < p->rows[0]; i++) norm += k->out[i] * k->out[i];
  }
  lambda = vreal_sqrt(lambda);
  norm = vreal_sqrt(norm);
  if (r->lambda) put(p, &lambda, 1, point, lanes, r->lambda, 0, 1);
  if (r->norm) put(p, &norm, 1, point, lanes, r->norm, 0, 1);
}

#ifdef YLM_REAL_IS_FLOAT
/* -- lights nearby -------------------------------------------------------------------------- */

/* Points relative to the origin of lights. */
static void load(const float (*from)[3], const double origin[3], int lanes, vreal to[3]) {
  for (size_t a = 0; a < 3; a++)
    for (int i = 0; i < LANES; i++)
      to[a][i] = (float)((double)from[i < lanes ? i : 0][a] - origin[a]);
}

ylm__virtual_near_fn YLM_KERNEL(ylm__virtual_near);

ylm_status YLM_KERNEL(ylm__virtual_near)(const ylm__virtual_plan *p, const ylm__virtual_near *near,
                                         void **scratch) {
  const size_t stride = p->lights->stride;
  const float *lamps = p->lights->seen, reach2 = near->reach * near->reach;
  vreal xyz[3] = {vreal_set(0), vreal_set(0), vreal_set(0)};
  load(near->points, p->lights->origin, near->lanes, xyz);
  if (!*scratch) *scratch = ylm_alloc_zero(room_of(p), sizeof(vreal));
  if (!*scratch) return YLM_ENOMEM;
  work own, *k = &own;
  work_place(k, p, *scratch);
  memset(k->part, 0, p->sums * sizeof *k->part);
  for (size_t i = 0; i < near->n; i++) add_light(p, k, lamps + near->list[i] * stride, xyz, reach2);
  flush(p, k);
  ylm_copy(k->sum, k->part, p->sums * sizeof *k->part);
  for (size_t c = 0; c < 3; c++) {
    const size_t n = p->rows[0];
    value_of(p, k, 3, (int)c, k->out);
    for (int i = 0; i < near->lanes; i++)
      for (size_t j = 0; j < n; j++) near->out[i][c * n + j] += k->out[j][i];
    if (!p->slopes) continue;
    gradient_of(p, k, 3, (int)c, k->out);
    for (int i = 0; i < near->lanes; i++)
      for (size_t j = 0; j < n; j++)
        for (size_t a = 0; a < 3; a++)
          near->out[i][(a + 1) * near->row + c * n + j] += k->out[3 * j + a][i];
  }
  return YLM_OK;
}
#endif

ylm__virtual_range YLM_REAL_KERNEL(ylm__virtual_range);

ylm_status YLM_REAL_KERNEL(ylm__virtual_range)(const ylm__virtual_plan *p, size_t begin, size_t end,
                                               const void *points, ylm_field_result *r) {
  work k;
  vreal *room = ylm_alloc_zero(room_of(p), sizeof *room);
  if (!room) return YLM_ENOMEM;
  work_place(&k, p, room);
  for (size_t point = begin; point < end; point += LANES) {
    int lanes = end - point < LANES ? (int)(end - point) : LANES;
    vreal xyz[3] = {vreal_set(0), vreal_set(0), vreal_set(0)};
    for (int i = 0; i < LANES; i++)
      for (size_t a = 0; a < 3; a++)
        xyz[a][i] =
            (real)ylm_get(p->q->dtype, points, 3 * (point + (size_t)(i < lanes ? i : 0)) + a);
    add_all(p, &k, xyz);
    mix(p, &k);
    results(p, &k, point, lanes, r);
    if (p->q->want & YLM_WANT_METRIC) metric(p, &k, point, lanes, r);
    for (int i = 0; r->inside && i < lanes; i++) r->inside[point + (size_t)i] = 0;
  }
  ylm_free(room);
  return YLM_OK;
}

#endif
