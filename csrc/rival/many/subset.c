/* subset.c - the mean over pixels beside each other, whose points ask interleaved lights. */
#include <math.h>

#include "many.h"
#include "ylm_vector.h"

#define GRAIN 1024
#define ALIKE 0.93969262f /* the cosine of 20 degrees */

typedef struct job {
  const ylm_many_host *host;
  int tile;
  const float *from; /* [points][3] */
  float *out;
} job;

/* Where a tile around x begins, within n pixels. */
static size_t begin_of(size_t x, size_t n, size_t tile) {
  size_t half = (tile - 1) / 2, begin = x > half ? x - half : 0;
  return n <= tile ? 0 : begin + tile > n ? n - tile : begin;
}

/* Adds the mean of a pixel's points that count for point p; false: there are none. */
static bool add_pixel(const job *j, size_t p, size_t pixel, double sum[3]) {
  const ylm_many_host *v = j->host;
  double own[3] = {0, 0, 0};
  size_t n = 0;
  for (size_t q = v->first(v->view, pixel), end = v->first(v->view, pixel + 1); q < end; q++) {
    if (v->mesh[q] != v->mesh[p] || ylm_dot3(v->normal[q], v->normal[p]) < ALIKE) continue;
    if (v->gloss && v->glosses(v->gloss, v->view, q)) continue;
    for (size_t c = 0; c < 3; c++) own[c] += (double)j->from[3 * q + c];
    n++;
  }
  for (int c = 0; n > 0 && c < 3; c++) sum[c] += own[c] / (double)n;
  return n > 0;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  const ylm_many_host *v = j->host;
  size_t width = v->size[0], height = v->size[1], tile = (size_t)j->tile;
  for (size_t pixel = begin; pixel < end; pixel++) {
    size_t left = begin_of(pixel % width, width, tile), low = begin_of(pixel / width, height, tile);
    for (size_t p = v->first(v->view, pixel), behind = v->first(v->view, pixel + 1); p < behind;
         p++) {
      double sum[3] = {0, 0, 0};
      size_t n = 0;
      if (v->gloss && v->glosses(v->gloss, v->view, p)) continue;
      for (size_t y = low; y < low + tile && y < height; y++)
        for (size_t x = left; x < left + tile && x < width; x++)
          n += add_pixel(j, p, y * width + x, sum);
      for (size_t c = 0; c < 3; c++) j->out[3 * p + c] = (float)(sum[c] / (double)n);
    }
  }
  return YLM_OK;
}

ylm_status ylm__many_filter(const ylm_many_host *host, int tile, int threads, float *out) {
  float *from = ylm_alloc_copy(out, host->points, 3 * sizeof *out);
  job j = {host, tile, from, out};
  if (!from) return YLM_ENOMEM;
  ylm_status s = ylm_parallel(host->size[0] * host->size[1], GRAIN, threads, run, &j, NULL, NULL);
  ylm_free(from);
  return s;
}
