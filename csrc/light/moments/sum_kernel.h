/*
** sum_kernel.h - the loop over points and lights around the moment kernels, for the unit's element
** type. Lanes are points.
*/
#ifndef YLM_LIGHT_SUM_KERNEL_H
#define YLM_LIGHT_SUM_KERNEL_H

#include "gen/compensation.h"
#include "lanes.h"
#include "plan.h"
#include "ylm_transpose.h"

#ifdef YLM_REAL_IS_FLOAT
typedef ylm__lamp_f real_lamp;
#define COEF coef_f
#define LAMPS lamp_f
#else
typedef ylm__lamp_d real_lamp;
#define COEF coef
#define LAMPS lamp_d
#endif

/* y = A x for the rows first .. first+n-1 of A. */
static void apply(const ylm__rows *A, size_t first, size_t n, const vreal *x, vreal *y) {
  for (size_t i = 0; i < n; i++) {
    vreal s = {0};
    for (uint32_t t = A->start[first + i]; t < A->start[first + i + 1]; t++)
      s += A->COEF[t] * x[A->index[t]];
    y[i] = s;
  }
}

/* Scratch of one worker. */
typedef struct work {
  vreal *geometry, *weights, *scaled, *emission, *state;
  vreal *lum, *rgb, *mixed; /* sums: [n_lum], [3][n_rgb], [n_rgb] */
  vreal *part, *lost; /* of the block at hand, and what the totals lost: as lum and rgb together */
  vreal *u, *out;     /* U, and one channel of results */
} work;

static ylm_status work_create(work *k, const ylm__plan *p, void **scratch) {
  int lmax = p->q->lmax;
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1), G = (size_t)ylm__geometry_slots(lmax);
  size_t W = (size_t)ylm__weight_slots(lmax), lum = (size_t)p->n_lum, rgb = (size_t)p->n_rgb;
  size_t tile = (size_t)ylm__tile(lmax, p->kinds_lum, p->kinds_rgb);
  size_t sizes[] = {tile * G,      tile * W,
                    tile * W,      3 * tile,
                    2 * tile,      lum + 3 * rgb,
                    rgb,           lum + 3 * rgb,
                    lum + 3 * rgb, 3 * (size_t)(lmax + 2) * (size_t)(lmax + 2),
                    6 * count};
  size_t total = 0;
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) total += sizes[i];
  if (!*scratch) *scratch = ylm_alloc_zero(total, sizeof(vreal));
  vreal *at = *scratch;
  if (!at) return YLM_ENOMEM;
  vreal **slots[] = {&k->geometry, &k->weights, &k->scaled, &k->emission, &k->state, &k->lum,
                     &k->mixed,    &k->part,    &k->lost,   &k->u,        &k->out};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) *slots[i] = at, at += sizes[i];
  k->rgb = k->lum + lum;
  return YLM_OK;
}

/* The weights of `kinds` times each light's luminance. */
static void scale(const ylm__plan *p, int kinds, int n, const real_lamp *lamps, const vreal *w,
                  vreal *out) {
  int lmax = p->q->lmax, W = ylm__weight_slots(lmax);
  int edges[4] = {0, lmax + 1, 2 * lmax + 3, W};
  for (int j = 0; j < n; j++)
    for (int kind = 0; kind < 3; kind++)
      for (int i = edges[kind]; kinds & (1 << kind) && i < edges[kind + 1]; i++)
        out[j * W + i] = lamps[j].luminance * w[j * W + i];
}

/*
** Adds n lights to the sums at `to`, laid out as lum and rgb of the work. The three colour
** channels share one evaluation of the polynomials. Luminance is mostly needed for second derivatives alone (the third
** kind), which no colour channel uses: those weights contain the luminance.
*/
static void add_tile(const ylm__plan *p, work *k, int n, const real_lamp *lamps, const vreal *xyz,
                     vreal *to, vmask *inside) {
  const ylm__moment_kernel *kernel = p->kernel;
  int lmax = p->q->lmax, all = p->kinds_lum | p->kinds_rgb;
  int bright = !p->kinds_rgb ? 7 : p->kinds_lum == YLM__M2 ? YLM__M2 : 0;
  if (all == (YLM__M1 | YLM__M2)) all = 7;
  kernel->prepare(lmax, all, n, lamps, bright, xyz, k->geometry, k->weights, inside);
  if (p->kinds_rgb) {
    for (int j = 0; j < n; j++)
      for (int c = 0; c < 3; c++) k->emission[3 * j + c] = (vreal){0} + lamps[j].rgb[c];
    kernel->sum_rgb(lmax, p->kinds_rgb, n, k->geometry, k->weights, k->emission, k->state,
                    to + p->n_lum, p->n_rgb);
  }
  if (!p->kinds_lum) return;
  if (!bright) scale(p, p->kinds_lum, n, lamps, k->weights, k->scaled);
  kernel->sum(lmax, p->kinds_lum, n, k->geometry, bright ? k->weights : k->scaled, k->state, to);
}

/* Sums over all lights at LANES points: blocks of them, added up with compensation (Kahan). */
static void add_all(const ylm__plan *p, work *k, const vreal *xyz, vmask *inside) {
  const real_lamp *lamps = p->lights->LAMPS;
  size_t n = p->lights->active, sums = (size_t)(p->n_lum + 3 * p->n_rgb);
  size_t tile = (size_t)ylm__tile(p->q->lmax, p->kinds_lum, p->kinds_rgb);
  memset(k->lum, 0, sums * sizeof(vreal));
  memset(k->lost, 0, sums * sizeof(vreal));
  for (size_t block = 0; block < n; block += YLM__BLOCK) {
    size_t end = n - block < YLM__BLOCK ? n : block + YLM__BLOCK;
    memset(k->part, 0, sums * sizeof(vreal));
    for (size_t i = block; i < end; i += tile)
      add_tile(p, k, (int)(end - i < tile ? end - i : tile), lamps + i, xyz, k->part, inside);
    for (size_t i = 0; i < sums; i++) add_part(k->part[i], &k->lum[i], &k->lost[i]);
  }
}

/* Writes rows of LANES numbers to the `lanes` points of `to`, which have `stride` numbers each. */
static void put(const vreal *rows, size_t n, const size_t *to, int lanes, real *out,
                size_t stride) {
  const real *from = (const real *)rows;
  if (lanes == LANES && n >= LANES) {
    real *row[LANES];
    for (int lane = 0; lane < LANES; lane++) row[lane] = out + to[lane] * stride;
    from_tile(from, LANES, (int)n, 0, row);
    return;
  }
  for (int lane = 0; lane < lanes; lane++)
    for (size_t i = 0; i < n; i++) out[to[lane] * stride + i] = from[i * LANES + (size_t)lane];
}

/* The sums and the map that kind `kind` of channel c of `channels` follows from. */
static const vreal *source(const ylm__plan *p, const work *k, int kind, int channels, int c,
                           const ylm__map **map) {
  if (channels == 3) return *map = &p->rgb, k->rgb + c * p->n_rgb;
  if (p->kinds_lum & kind) return *map = &p->lum, k->lum;
  return *map = &p->mixed, k->mixed;
}

/* Value, gradient and Hessian of the points of `to`. */
static void results(const ylm__plan *p, work *k, const size_t *to, int lanes, ylm_field_result *r) {
  const ylm_field_query *q = p->q;
  size_t count = (size_t)(q->lmax + 1) * (size_t)(q->lmax + 1), C = (size_t)q->channels;
  for (int c = 0; c < q->channels; c++) {
    const ylm__map *map;
    size_t first = (size_t)c;
    if (q->want & YLM_WANT_VALUE) {
      const vreal *sums = source(p, k, YLM__M0, q->channels, c, &map);
      apply(&map->value, 0, count, sums, k->out);
      put(k->out, count, to, lanes, (real *)r->value + first * count, C * count);
    }
    if (q->want & YLM_WANT_GRADIENT) {
      const vreal *sums = source(p, k, YLM__M1, q->channels, c, &map);
      apply(&map->gradient, 0, 3 * count, sums, k->out);
      put(k->out, 3 * count, to, lanes, (real *)r->gradient + first * 3 * count, C * 3 * count);
    }
    if (q->want & YLM_WANT_HESSIAN) {
      const vreal *sums = source(p, k, YLM__M2, q->channels, c, &map);
      apply(&map->to_u, 0, map->to_u.n, sums, k->u);
      apply(&p->hessian, 0, 6 * count, k->u, k->out);
      put(k->out, 6 * count, to, lanes, (real *)r->hessian + first * 6 * count, C * 6 * count);
    }
  }
}

/* lambda and norm. */
static void metric(const ylm__plan *p, work *k, const size_t *to, int lanes, ylm_field_result *r) {
  const ylm_field_query *q = p->q;
  size_t count = (size_t)(q->lmax + 1) * (size_t)(q->lmax + 1);
  vreal lambda = {0}, norm = {0};
  for (int c = 0; c < q->metric_channels; c++) {
    const ylm__map *map;
    const vreal *sums = source(p, k, YLM__M2, q->metric_channels, c, &map);
    apply(&map->to_u, 0, map->to_u.n, sums, k->u);
    for (size_t i = 0; i < count; i++) {
      vreal h[6];
      apply(&p->hessian, 6 * i, 6, k->u, h);
      vreal e = largest_eigenvalue(h);
      lambda += e * e;
    }
    sums = source(p, k, YLM__M0, q->metric_channels, c, &map);
    apply(&map->value, 0, count, sums, k->out);
    for (size_t i = 0; i < count; i++) norm += k->out[i] * k->out[i];
  }
  lambda = vreal_sqrt(lambda);
  norm = vreal_sqrt(norm);
  if (r->lambda) put(&lambda, 1, to, lanes, r->lambda, 1);
  if (r->norm) put(&norm, 1, to, lanes, r->norm, 1);
}

/* Luminance of rgb sums, where results need it and it is not summed by itself. */
static void mix(const ylm__plan *p, work *k) {
  if (!(p->need_lum & ~p->kinds_lum)) return;
  for (int i = 0; i < p->n_rgb; i++)
    k->mixed[i] = (real)YLM_LUMINANCE_R * k->rgb[i] + (real)YLM_LUMINANCE_G * k->rgb[p->n_rgb + i] +
                  (real)YLM_LUMINANCE_B * k->rgb[2 * p->n_rgb + i];
}

ylm__sum_range YLM_REAL_KERNEL(ylm__sum_range);

ylm_status YLM_REAL_KERNEL(ylm__sum_range)(const ylm__plan *p, void **scratch, size_t begin,
                                           size_t end, const void *points, ylm_field_result *r) {
  work k;
  const real *at = points;
  if (work_create(&k, p, scratch) != YLM_OK) return YLM_ENOMEM;
  for (size_t point = begin; point < end; point += LANES) {
    int lanes = end - point < LANES ? (int)(end - point) : LANES;
    vreal xyz[3];
    vmask inside = {0};
    size_t to[LANES];
    for (size_t i = 0; i < LANES; i++) to[i] = point + i;
    for (int i = 0; i < LANES; i++)
      for (int a = 0; a < 3; a++)
        xyz[a][i] = at[3 * (point + (size_t)(i < lanes ? i : 0)) + (size_t)a];
    add_all(p, &k, xyz, &inside);
    mix(p, &k);
    results(p, &k, to, lanes, r);
    if (p->q->want & YLM_WANT_METRIC) metric(p, &k, to, lanes, r);
    for (int i = 0; r->inside && i < lanes; i++) r->inside[point + (size_t)i] = inside[i] != 0;
  }
  return YLM_OK;
}

#endif
