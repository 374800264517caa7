/* rounds.c - noise of a picture around its pixels, and rays where it is. */
#include <math.h>

#include "../calibration.h"
#include "../view.h"

/* Sums over pixels that show surfaces alone: the squared noise of the mean of two estimates, and light. */
typedef struct noise_sum {
  double square, light;
} noise_sum;

typedef struct noise_job {
  const ylm_shade_view *v;
  const float *a, *b, *all;
  noise_sum *row; /* [height][width] of pixels to the left and right */
  float *out;
} noise_job;

static double luminance(const float *rgb) {
  return ylm_luminance((double[]){(double)rgb[0], (double)rgb[1], (double)rgb[2]});
}

static noise_sum noise_at(const noise_job *j, size_t p) {
  if (!(j->v->pixel[p].coverage > 0) || j->v->pixel[p].emitter > 0) return (noise_sum){0, 0};
  double apart = (luminance(j->a + 3 * p) - luminance(j->b + 3 * p)) / 2;
  return (noise_sum){apart * apart, luminance(j->all + 3 * p)};
}

/* The sum of numbers around `at` of `n`, which are `step` apart. */
static noise_sum sum_around(const noise_sum *x, int at, int n, size_t step) {
  int first = at > NOISE_REACH ? at - NOISE_REACH : 0;
  int end = n - at > NOISE_REACH ? at + NOISE_REACH + 1 : n;
  noise_sum sum = {0, 0};
  for (int i = first; i < end; i++) {
    sum.square += x[(size_t)i * step].square;
    sum.light += x[(size_t)i * step].light;
  }
  return sum;
}

static ylm_status run_rows(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const noise_job *j = context;
  int w = j->v->o.width;
  noise_sum *one = ylm_alloc((size_t)w, sizeof *one);
  if (!one) return YLM_ENOMEM;
  for (size_t y = begin; y < end; y++) {
    size_t first = y * (size_t)w;
    for (int x = 0; x < w; x++) one[x] = noise_at(j, first + (size_t)x);
    for (int x = 0; x < w; x++) j->row[first + (size_t)x] = sum_around(one, x, w, 1);
  }
  ylm_free(one);
  return YLM_OK;
}

static ylm_status run_columns(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const noise_job *j = context;
  int w = j->v->o.width, h = j->v->o.height;
  double n = (2 * NOISE_REACH + 1) * (2 * NOISE_REACH + 1);
  for (size_t y = begin; y < end; y++)
    for (int x = 0; x < w; x++) {
      noise_sum s = sum_around(j->row + x, (int)y, h, (size_t)w);
      j->out[y * (size_t)w + (size_t)x] = s.light > 0 ? (float)(sqrt(s.square * n) / s.light) : 0;
    }
  return YLM_OK;
}

ylm_status ylm_shade_noise_around(const ylm_shade_view *v, const float *a, const float *b,
                                  const float *all, int threads, float *out) {
  if (v->number) return YLM_EINVAL;
  size_t h = (size_t)v->o.height;
  noise_job j = {v, a, b, all, ylm_alloc(h, (size_t)v->o.width * sizeof *j.row), out};
  ylm_status s = j.row ? ylm_parallel(h, 1, threads, run_rows, &j, NULL, NULL) : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_parallel(h, 1, threads, run_columns, &j, NULL, NULL);
  ylm_free(j.row);
  return s;
}

/* -- rays behind a pilot ----------------------------------------------------------------- */

/* A tile: the counts that its noise asks for behind the pilot, 0: none, and the weight of the pilot. */
typedef struct plan_tile {
  double count, weight;
} plan_tile;

static plan_tile tile_of(const ylm_shade_plan *p, double noise) {
  double count = p->factor * noise - 1, least = p->least / p->unit, most = p->most / p->unit;
  if (!(count >= PLAN_WORTH * least)) return (plan_tile){0, 1};
  count = fmin(most, fmax(least, count));
  return (plan_tile){count, 1 / (1 + count)};
}

/* Rays of a pixel's points in a tile that has some. */
static double rays_of(const ylm_shade_plan *p, double noise) {
  return fmin(p->most, fmax(p->least, ceil(p->unit * (p->factor * noise - 1))));
}

/* The root mean square noise of a tile's pixels that have some. */
static double noise_of_tile(const ylm_shade_view *v, const float *noise, const int lo[2],
                            const int hi[2]) {
  double square = 0, n = 0;
  for (int y = lo[1]; y < hi[1]; y++)
    for (int x = lo[0]; x < hi[0]; x++) {
      double each = (double)noise[(size_t)y * (size_t)v->o.width + (size_t)x];
      square += each * each;
      n += each > 0;
    }
  return n > 0 ? sqrt(square / n) : 0;
}

/* Plans the pixel p of a tile; adds to sums. */
static void plan_pixel(const ylm_shade_view *v, const ylm_shade_plan *p, plan_tile t, size_t pixel,
                       float *rays, float *weight, double sum[2]) {
  double noise = (double)p->noise[pixel], own = t.count > 0 ? rays_of(p, noise) : 0;
  double rest = own > 0 ? (1 - t.weight) * (1 - t.weight) * p->unit / own : 0;
  sum[0] += noise * noise * (t.weight * t.weight + rest);
  for (size_t i = v->pixel[pixel].first; i < v->pixel[pixel + 1].first; i++) {
    if (rays) rays[i] = (float)own;
    if (weight) weight[i] = (float)t.weight;
    sum[1] += own;
  }
}

ylm_status ylm_shade_plan_rays(const ylm_shade_view *v, const ylm_shade_plan *p, float *rays,
                               float *weight, double sum[2]) {
  if (v->corner || v->number) return YLM_EINVAL;
  sum[0] = sum[1] = 0;
  int w = v->o.width, h = v->o.height;
  for (int y = 0; y < h; y += PLAN_TILE)
    for (int x = 0; x < w; x += PLAN_TILE) {
      int lo[2] = {x, y},
          hi[2] = {w - x < PLAN_TILE ? w : x + PLAN_TILE, h - y < PLAN_TILE ? h : y + PLAN_TILE};
      plan_tile t = tile_of(p, noise_of_tile(v, p->noise, lo, hi));
      for (int b = lo[1]; b < hi[1]; b++)
        for (int a = lo[0]; a < hi[0]; a++)
          plan_pixel(v, p, t, (size_t)b * (size_t)w + (size_t)a, rays, weight, sum);
    }
  sum[1] /= fmax(1, (double)v->points);
  return YLM_OK;
}
