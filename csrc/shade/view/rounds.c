/* rounds.c - noise of a picture around its pixels, and numbers of pixels as numbers of points. */
#include <math.h>

#include "../calibration.h"
#include "../view.h"

typedef struct noise_job {
  const ylm_shade_view *v;
  const float *a, *b, *all;
  float *out;
} noise_job;

static double luminance(const float *rgb) {
  return ylm_luminance((double[]){(double)rgb[0], (double)rgb[1], (double)rgb[2]});
}

/* Sums over the pixels around pixel (x, y) that show surfaces alone. */
static float noise_at(const noise_job *j, int x, int y) {
  int w = j->v->o.width, h = j->v->o.height;
  double square = 0, mean = 0;
  for (int v = y > NOISE_REACH ? y - NOISE_REACH : 0; v <= y + NOISE_REACH && v < h; v++)
    for (int u = x > NOISE_REACH ? x - NOISE_REACH : 0; u <= x + NOISE_REACH && u < w; u++) {
      size_t p = (size_t)v * (size_t)w + (size_t)u;
      if (!(j->v->pixel[p].coverage > 0) || j->v->pixel[p].emitter > 0) continue;
      double apart = (luminance(j->a + 3 * p) - luminance(j->b + 3 * p)) / 2;
      square += apart * apart;
      mean += luminance(j->all + 3 * p);
    }
  double n = (2 * NOISE_REACH + 1) * (2 * NOISE_REACH + 1);
  return mean > 0 ? (float)(sqrt(square * n) / mean) : 0;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const noise_job *j = context;
  int w = j->v->o.width;
  for (size_t y = begin; y < end; y++)
    for (int x = 0; x < w; x++) j->out[y * (size_t)w + (size_t)x] = noise_at(j, x, (int)y);
  return YLM_OK;
}

ylm_status ylm_shade_noise_around(const ylm_shade_view *v, const float *a, const float *b,
                                  const float *all, int threads, float *out) {
  noise_job j = {v, a, b, all, out};
  if (v->number) return YLM_EINVAL;
  return ylm_parallel((size_t)v->o.height, 1, threads, run, &j, NULL, NULL);
}

ylm_status ylm_shade_spread(const ylm_shade_view *v, const float *pixels, float factor, float least,
                            float most, float *points) {
  if (v->corner || v->number) return YLM_EINVAL;
  for (size_t p = 0; p < v->stats.pixels; p++)
    for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++)
      points[i] = fminf(most, fmaxf(least, ceilf(factor * pixels[p])));
  return YLM_OK;
}
