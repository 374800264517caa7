/* sum_body.h - sum.isa.c for one element type: see there. Lanes are points. */

YLM_INLINE V NAME(larger)(V a, V b) {
  VI m = a > b;
  return (V)(((VI)a & m) | ((VI)b & ~m));
}

YLM_INLINE V NAME(size)(V a) { return NAME(larger)(a, -a); }

YLM_INLINE V NAME(smaller)(V a, V b) { return -NAME(larger)(-a, -b); }

YLM_INLINE V NAME(choose)(VI first, V a, V b) { return (V)(((VI)a & first) | ((VI)b & ~first)); }

#include "gen/compensation.h"
#include "gen/eigenvalue.h"

/* y = A x for the rows first .. first+n-1 of A. */
static void NAME(apply)(const ylm__rows *A, size_t first, size_t n, const V *x, V *y) {
  for (size_t i = 0; i < n; i++) {
    V s = {0};
    for (uint32_t t = A->start[first + i]; t < A->start[first + i + 1]; t++)
      s += A->COEF[t] * x[A->index[t]];
    y[i] = s;
  }
}

/* Scratch of one worker. */
typedef struct NAME(work) {
  V *geometry, *weights, *scaled, *emission, *state;
  V *lum, *rgb, *mixed; /* sums: [n_lum], [3][n_rgb], [n_rgb] */
  V *part, *lost; /* of the block at hand, and what the totals lost: as lum and rgb together */
  V *bend, *out;  /* U, and one channel of results */
} NAME(work);

static ylm_status NAME(work_create)(NAME(work) * k, const ylm__plan *p, void **scratch) {
  int lmax = p->q->lmax;
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1), G = (size_t)ylm__geometry_slots(lmax);
  size_t W = (size_t)ylm__weight_slots(lmax), lum = (size_t)p->n_lum, rgb = (size_t)p->n_rgb;
  size_t sizes[] = {YLM__TILE * G, YLM__TILE * W,
                    YLM__TILE * W, 3 * YLM__TILE,
                    2 * YLM__TILE, lum + 3 * rgb,
                    rgb,           lum + 3 * rgb,
                    lum + 3 * rgb, 3 * (size_t)(lmax + 2) * (size_t)(lmax + 2),
                    6 * count};
  size_t total = 0;
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) total += sizes[i];
  if (!*scratch) *scratch = ylm_alloc_zero(total, sizeof(V));
  V *at = *scratch;
  if (!at) return YLM_ENOMEM;
  V **slots[] = {&k->geometry, &k->weights, &k->scaled, &k->emission, &k->state, &k->lum,
                 &k->mixed,    &k->part,    &k->lost,   &k->bend,     &k->out};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) *slots[i] = at, at += sizes[i];
  k->rgb = k->lum + lum;
  return YLM_OK;
}

/* The weights of `kinds` times each light's luminance. */
static void NAME(scale)(const ylm__plan *p, int kinds, int n, const LAMP *lamps, const V *w,
                        V *out) {
  int lmax = p->q->lmax, W = ylm__weight_slots(lmax);
  int edges[4] = {0, lmax + 1, 2 * lmax + 3, W};
  for (int j = 0; j < n; j++)
    for (int kind = 0; kind < 3; kind++)
      for (int i = edges[kind]; kinds & (1 << kind) && i < edges[kind + 1]; i++)
        out[j * W + i] = lamps[j].luminance * w[j * W + i];
}

/*
** Adds n lights to the sums at `to`, laid out as lum and rgb of the work. Three channels share
** their polynomials; beside them luminance has the third kind as a rule, which nobody else uses and
** which therefore has luminance in its weights.
*/
static void NAME(add_tile)(const ylm__plan *p, NAME(work) * k, int n, const LAMP *lamps,
                           const V *xyz, V *to, VI *inside) {
  const ylm__moment_kernel *kernel = p->kernel;
  int lmax = p->q->lmax, all = p->kinds_lum | p->kinds_rgb;
  int bright = !p->kinds_rgb ? 7 : p->kinds_lum == YLM__M2 ? YLM__M2 : 0;
  if (all == (YLM__M1 | YLM__M2)) all = 7;
  kernel->prepare(lmax, all, n, lamps, bright, xyz, k->geometry, k->weights, inside);
  if (p->kinds_rgb) {
    for (int j = 0; j < n; j++)
      for (int c = 0; c < 3; c++) k->emission[3 * j + c] = (V){0} + lamps[j].rgb[c];
    kernel->sum_rgb(lmax, p->kinds_rgb, n, k->geometry, k->weights, k->emission, k->state,
                    to + p->n_lum, p->n_rgb);
  }
  if (!p->kinds_lum) return;
  if (!bright) NAME(scale)(p, p->kinds_lum, n, lamps, k->weights, k->scaled);
  kernel->sum(lmax, p->kinds_lum, n, k->geometry, bright ? k->weights : k->scaled, k->state, to);
}

/* Sums over all lights at LANES points: blocks of them, added up with compensation (Kahan). */
static void NAME(add_all)(const ylm__plan *p, NAME(work) * k, const V *xyz, VI *inside) {
  const LAMP *lamps =
      sizeof(REAL) == 8 ? (const void *)p->lights->lamp_d : (const void *)p->lights->lamp_f;
  size_t n = p->lights->active, sums = (size_t)(p->n_lum + 3 * p->n_rgb);
  memset(k->lum, 0, sums * sizeof(V));
  memset(k->lost, 0, sums * sizeof(V));
  for (size_t block = 0; block < n; block += YLM__BLOCK) {
    size_t end = n - block < YLM__BLOCK ? n : block + YLM__BLOCK;
    memset(k->part, 0, sums * sizeof(V));
    for (size_t i = block; i < end; i += YLM__TILE) NAME(add_tile)
    (p, k, end - i < YLM__TILE ? (int)(end - i) : YLM__TILE, lamps + i, xyz, k->part, inside);
    for (size_t i = 0; i < sums; i++) NAME(add_part)(k->part[i], &k->lum[i], &k->lost[i]);
  }
}

/* Writes rows of LANES numbers to the `lanes` points of `to`, which have `stride` numbers each. */
static void NAME(put)(const V *rows, size_t n, const size_t *to, int lanes, REAL *out,
                      size_t stride) {
  const REAL *from = (const REAL *)rows;
  for (int lane = 0; lane < lanes; lane++)
    for (size_t i = 0; i < n; i++) out[to[lane] * stride + i] = from[i * LANES + (size_t)lane];
}

/* The sums and the map that kind `kind` of channel c of `channels` follows from. */
static const V *NAME(source)(const ylm__plan *p, const NAME(work) * k, int kind, int channels,
                             int c, const ylm__map **map) {
  if (channels == 3) return *map = &p->rgb, k->rgb + c * p->n_rgb;
  if (p->kinds_lum & kind) return *map = &p->lum, k->lum;
  return *map = &p->mixed, k->mixed;
}

/* Value, gradient and Hessian of the points of `to`. */
static void NAME(results)(const ylm__plan *p, NAME(work) * k, const size_t *to, int lanes,
                          ylm_field_result *r) {
  const ylm_field_query *q = p->q;
  size_t count = (size_t)(q->lmax + 1) * (size_t)(q->lmax + 1), C = (size_t)q->channels;
  for (int c = 0; c < q->channels; c++) {
    const ylm__map *map;
    size_t first = (size_t)c;
    if (q->want & YLM_WANT_VALUE) {
      const V *sums = NAME(source)(p, k, YLM__M0, q->channels, c, &map);
      NAME(apply)(&map->value, 0, count, sums, k->out);
      NAME(put)(k->out, count, to, lanes, (REAL *)r->value + first * count, C * count);
    }
    if (q->want & YLM_WANT_GRADIENT) {
      const V *sums = NAME(source)(p, k, YLM__M1, q->channels, c, &map);
      NAME(apply)(&map->gradient, 0, 3 * count, sums, k->out);
      NAME(put)
      (k->out, 3 * count, to, lanes, (REAL *)r->gradient + first * 3 * count, C * 3 * count);
    }
    if (q->want & YLM_WANT_HESSIAN) {
      const V *sums = NAME(source)(p, k, YLM__M2, q->channels, c, &map);
      NAME(apply)(&map->bend, 0, map->bend.n, sums, k->bend);
      NAME(apply)(&p->hessian, 0, 6 * count, k->bend, k->out);
      NAME(put)
      (k->out, 6 * count, to, lanes, (REAL *)r->hessian + first * 6 * count, C * 6 * count);
    }
  }
}

/* lambda and norm. */
static void NAME(metric)(const ylm__plan *p, NAME(work) * k, const size_t *to, int lanes,
                         ylm_field_result *r) {
  const ylm_field_query *q = p->q;
  size_t count = (size_t)(q->lmax + 1) * (size_t)(q->lmax + 1);
  V lambda = {0}, norm = {0};
  for (int c = 0; c < q->metric_channels; c++) {
    const ylm__map *map;
    const V *sums = NAME(source)(p, k, YLM__M2, q->metric_channels, c, &map);
    NAME(apply)(&map->bend, 0, map->bend.n, sums, k->bend);
    for (size_t i = 0; i < count; i++) {
      V h[6];
      NAME(apply)(&p->hessian, 6 * i, 6, k->bend, h);
      V e = NAME(largest_eigenvalue)(h);
      lambda += e * e;
    }
    sums = NAME(source)(p, k, YLM__M0, q->metric_channels, c, &map);
    NAME(apply)(&map->value, 0, count, sums, k->out);
    for (size_t i = 0; i < count; i++) norm += k->out[i] * k->out[i];
  }
  lambda = SQRT(lambda);
  norm = SQRT(norm);
  if (r->lambda) NAME(put)(&lambda, 1, to, lanes, r->lambda, 1);
  if (r->norm) NAME(put)(&norm, 1, to, lanes, r->norm, 1);
}

/* Luminance of rgb sums, where results need it and it is not summed by itself. */
static void NAME(mix)(const ylm__plan *p, NAME(work) * k) {
  if (!(p->need_lum & ~p->kinds_lum)) return;
  for (int i = 0; i < p->n_rgb; i++)
    k->mixed[i] = (REAL)YLM_LUMINANCE_R * k->rgb[i] + (REAL)YLM_LUMINANCE_G * k->rgb[p->n_rgb + i] +
                  (REAL)YLM_LUMINANCE_B * k->rgb[2 * p->n_rgb + i];
}

ylm__sum_range RANGE;

ylm_status RANGE(const ylm__plan *p, void **scratch, size_t begin, size_t end, const void *points,
                 ylm_field_result *r) {
  NAME(work) k;
  const REAL *at = points;
  if (NAME(work_create)(&k, p, scratch) != YLM_OK) return YLM_ENOMEM;
  for (size_t point = begin; point < end; point += LANES) {
    int lanes = end - point < LANES ? (int)(end - point) : LANES;
    V xyz[3];
    VI inside = {0};
    size_t to[LANES];
    for (size_t i = 0; i < LANES; i++) to[i] = point + i;
    for (int i = 0; i < LANES; i++)
      for (int a = 0; a < 3; a++)
        xyz[a][i] = at[3 * (point + (size_t)(i < lanes ? i : 0)) + (size_t)a];
    NAME(add_all)(p, &k, xyz, &inside);
    NAME(mix)(p, &k);
    NAME(results)(p, &k, to, lanes, r);
    if (p->q->want & YLM_WANT_METRIC) NAME(metric)(p, &k, to, lanes, r);
    for (int i = 0; r->inside && i < lanes; i++) r->inside[point + (size_t)i] = inside[i] != 0;
  }
  return YLM_OK;
}
