/* draw.c - pixels that say what a picture's mean square error is, drawn by its light. */
#include <math.h>

#include "../calibration.h"
#include "../view.h"

/* The mean over channels of x. */
static double grey(const float *x) { return ((double)x[0] + (double)x[1] + (double)x[2]) / 3; }

static size_t count_of(const ylm_shade_drawing *d) { return (size_t)d->width * (size_t)d->height; }

/* The squared light of the brightest pixel around (x, y), in either picture. */
static double bright(const ylm_shade_drawing *d, int x, int y) {
  double most = 0;
  for (int v = y > 0 ? y - 1 : 0; v <= y + 1 && v < d->height; v++)
    for (int u = x > 0 ? x - 1 : 0; u <= x + 1 && u < d->width; u++) {
      size_t i = 3 * ((size_t)v * (size_t)d->width + (size_t)u);
      most = fmax(most, fabs(grey(d->light + i)));
      if (d->again) most = fmax(most, fabs(grey(d->again + i)));
    }
  return most * most;
}

/* The squared difference of the two pictures in pixel i. */
static double apart(const ylm_shade_drawing *d, size_t i) {
  double square = 0;
  for (size_t c = 0; d->again && c < 3; c++) {
    double e = (double)d->light[3 * i + c] - (double)d->again[3 * i + c];
    square += e * e / 3;
  }
  return square;
}

/* Writes p: parts of the mixture, each of which adds up to 1. */
static void mix(const ylm_shade_drawing *d, double *p) {
  size_t n = count_of(d);
  double light = 0, change = 0;
  for (size_t i = 0; i < n; i++) {
    light += bright(d, (int)(i % (size_t)d->width), (int)(i / (size_t)d->width));
    change += apart(d, i);
  }
  double of_change = change > 0 ? DRAW_CHANGE : 0,
         of_light = light > 0 ? DRAW_LIGHT - of_change : 0;
  for (size_t i = 0; i < n; i++) {
    p[i] = (1 - of_light - of_change) / (double)n;
    if (light > 0)
      p[i] +=
          of_light * bright(d, (int)(i % (size_t)d->width), (int)(i / (size_t)d->width)) / light;
    if (change > 0) p[i] += of_change * apart(d, i) / change;
  }
}

/* Turns p into probabilities to be drawn, which add up to `count`. */
static void settle(size_t n, size_t count, double *p) {
  double c = (double)count;
  for (size_t certain = 0, before = n + 1; certain != before;) {
    double rest = 0;
    before = certain, certain = 0;
    for (size_t i = 0; i < n; i++)
      if (c * p[i] >= 1)
        certain++;
      else
        rest += p[i];
    if (rest > 0) c = fmax(c, ((double)count - (double)certain) / rest);
  }
  for (size_t i = 0; i < n; i++) p[i] = fmin(1, c * p[i]);
}

/* Walks through strips of `high` rows, column by column, and takes each pixel at which the sum of q passes the next whole
   number. */
static size_t walk(const ylm_shade_drawing *d, const double *q, size_t most, double at,
                   uint32_t *pixel, double *weight) {
  size_t high = (size_t)fmax(1, sqrt((double)count_of(d) / (double)most)), drawn = 0;
  size_t width = (size_t)d->width, height = (size_t)d->height;
  for (size_t top = 0; top < height; top += high)
    for (size_t k = 0; k < width; k++)
      for (size_t y = top; y < top + high && y < height; y++) {
        size_t i = y * width + (top / high % 2 ? width - 1 - k : k);
        at += q[i];
        if (at < 1 || drawn == most) continue;
        at -= 1;
        pixel[drawn] = (uint32_t)i;
        weight[drawn++] = 1 / q[i];
      }
  return drawn;
}

ylm_status ylm_shade_draw(const ylm_shade_drawing *d, uint32_t *pixel, double *weight,
                          size_t *drawn) {
  if (d->width < 1 || d->height < 1 || d->count < 1) return YLM_ERANGE;
  size_t n = count_of(d);
  ylm_rng rng;
  *drawn = n;
  for (size_t i = 0; i < n && n <= d->count; i++) pixel[i] = (uint32_t)i, weight[i] = 1;
  if (n <= d->count) return YLM_OK;
  double *p = ylm_alloc(n, sizeof *p);
  if (!p) return YLM_ENOMEM;
  ylm_rng_seed(&rng, d->seed, DRAW_STREAM);
  mix(d, p);
  settle(n, d->count, p);
  *drawn = walk(d, p, d->count, ylm_rng_double(&rng), pixel, weight);
  ylm_free(p);
  return YLM_OK;
}
