/* rounds.c - noise of a picture around its pixels, and numbers of pixels as numbers of points. */
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

ylm_status ylm_shade_spread(const ylm_shade_view *v, const float *pixels, float factor, float least,
                            float most, float *points) {
  if (v->corner || v->number) return YLM_EINVAL;
  for (size_t p = 0; p < v->stats.pixels; p++)
    for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++)
      points[i] = fminf(most, fmaxf(least, ceilf(factor * pixels[p])));
  return YLM_OK;
}
