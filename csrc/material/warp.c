/*
** warp.c - bilinear functions and the maps by their densities.
**
** Along a row the density is linear between nodes, and so is the integral of rows across them. A map
** solves one quadratic for y, then one for x (Dupuy & Jakob 2018, supplemental material).
*/
#include "warp.h"

#include <math.h>

static float minimum(float a, float b) { return a < b ? a : b; }
static float maximum(float a, float b) { return a > b ? a : b; }

/* The cell of u in 0 .. 1 among n nodes, and the share of the way through it. */
static int cell_of(float u, int n, float *t) {
  float x = minimum(maximum(u, 0), 1) * (float)(n - 1);
  int i = (int)x;
  if (i > n - 2) i = n > 1 ? n - 2 : 0;
  *t = x - (float)i;
  return i;
}

float ylm__raster_at(const raster *r, const float u[2]) {
  float tx, ty;
  int x = cell_of(u[0], r->width, &tx), y = cell_of(u[1], r->height, &ty);
  int right = r->width > 1, below = r->height > 1 ? r->width : 0;
  const float *v = r->value + (size_t)y * (size_t)r->width + (size_t)x;
  return (1 - ty) * ((1 - tx) * v[0] + tx * v[right]) +
         ty * ((1 - tx) * v[below] + tx * v[below + right]);
}

void ylm__colours_at(int width, int height, const float *value, const blend *b, const float u[2],
                     float out[3]) {
  float tx, ty;
  int x = cell_of(u[0], width, &tx), y = cell_of(u[1], height, &ty);
  size_t row = 4 * (size_t)width, slice = row * (size_t)height;
  const float *corner = value + (size_t)y * row + 4 * (size_t)x;
  float w[4] = {(1 - tx) * (1 - ty), tx * (1 - ty), (1 - tx) * ty, tx * ty}, sum[4] = {0};
  for (int k = 0; k < b->n; k++) {
    const float *v = corner + b->slice[k] * slice;
    for (int c = 0; c < 4; c++)
      sum[c] += b->share[k] * (w[0] * v[c] + w[1] * v[4 + c] + w[2] * v[row + (size_t)c] +
                               w[3] * v[row + 4 + (size_t)c]);
  }
  for (int c = 0; c < 3; c++) out[c] = sum[c];
}

/* -- filling ---------------------------------------------------------------- */

bool ylm__warp_fill(warp *w, size_t slice, const float *density) {
  size_t width = (size_t)w->width, height = (size_t)w->height, first = slice * width * height;
  float *marginal = w->marginal + slice * height;
  double total = 0;
  for (size_t y = 0; y < height; y++) {
    const float *from = density + y * width;
    float *d = w->density + first + y * width, *c = w->conditional + first + y * width;
    double sum = 0, before = y ? (double)c[-1] : 0;
    for (size_t x = 0; x < width; x++) {
      d[x] = maximum(from[x], 0);
      if (x) sum += ((double)d[x - 1] + (double)d[x]) / 2;
      c[x] = (float)sum;
    }
    if (y) total += (before + (double)c[width - 1]) / 2;
    marginal[y] = (float)total;
  }
  if (!(total > 1e-30)) return false;
  float scale = (float)(1 / total);
  for (size_t i = first; i < first + width * height; i++) {
    w->density[i] *= scale;
    w->conditional[i] *= scale;
  }
  for (size_t y = 0; y < height; y++) marginal[y] *= scale;
  return true;
}

/* -- looking up ------------------------------------------------------------- */

/* Number i of a slice of size `stride`, blended. */
static inline float blended(const float *table, size_t stride, const blend *b, size_t i) {
  float sum =
      b->share[0] * table[b->slice[0] * stride + i] + b->share[1] * table[b->slice[1] * stride + i];
  if (b->n == 2) return sum;
  return sum + b->share[2] * table[b->slice[2] * stride + i] +
         b->share[3] * table[b->slice[3] * stride + i];
}

/* The t in 0 .. 1 where the integral of a + (b - a) t, from 0, is x. */
static float solve(float x, float a, float b) {
  float root = a + sqrtf(maximum(a * a - 2 * x * (a - b), 0));
  return root > 0 ? minimum(2 * x / root, 1) : 0;
}

/* A list of n numbers that increase, one of a place: (1 - t) times the numbers from `at` on, plus t times
   those `behind` them, where that is not 0. */
typedef struct list {
  size_t at, behind;
  float t;
} list;

static inline float entry(const float *table, size_t stride, const blend *b, const list *l,
                          size_t i) {
  if (!l->behind) return blended(table, stride, b, l->at + i);
  return (1 - l->t) * blended(table, stride, b, l->at + i) +
         l->t * blended(table, stride, b, l->at + l->behind + i);
}

/* Of each place the last i of 0 .. length-2 that is 0, or whose entry is not larger than x; *before:
   that entry. The places take their steps together, since one step waits for the one before. */
static void intervals(const float *table, size_t stride, int length, size_t n, const blend *b,
                      const list *lists, const float *x, size_t *found, float *before) {
  for (size_t k = 0; k < n; k++) found[k] = 0;
  for (size_t left = (size_t)length - 1; left > 1; left -= left / 2)
    for (size_t k = 0; k < n; k++) {
      size_t half = left / 2;
      float here = entry(table, stride, b + k, lists + k, found[k] + half);
      found[k] += half * (size_t)(here <= x[k]);
    }
  for (size_t k = 0; k < n; k++) before[k] = entry(table, stride, b + k, lists + k, found[k]);
}

/* The cell's densities at the left and at the right border, t of the way through it. */
static void borders(const warp *w, size_t stride, const blend *b, size_t i, float t, float c[2]) {
  size_t below = i + (size_t)w->width;
  c[0] = (1 - t) * blended(w->density, stride, b, i) + t * blended(w->density, stride, b, below);
  c[1] = (1 - t) * blended(w->density, stride, b, i + 1) +
         t * blended(w->density, stride, b, below + 1);
}

/* Density per square of what is per cell. */
static float per_square(const warp *w, float t, const float c[2]) {
  return ((1 - t) * c[0] + t * c[1]) * (float)(w->width - 1) * (float)(w->height - 1);
}

float ylm__warp_density(const warp *w, const blend *b, const float at[2]) {
  float tx, ty, c[2];
  int x = cell_of(at[0], w->width, &tx), y = cell_of(at[1], w->height, &ty);
  size_t width = (size_t)w->width;
  borders(w, width * (size_t)w->height, b, (size_t)y * width + (size_t)x, ty, c);
  return per_square(w, tx, c);
}

void ylm__warp_sample(const warp *w, size_t n, const blend *b, const float (*u)[2], float (*out)[2],
                      float *density) {
  size_t width = (size_t)w->width, stride = width * (size_t)w->height;
  list lists[WARP_BLOCK] = {0};
  size_t x[WARP_BLOCK], y[WARP_BLOCK];
  float wanted[WARP_BLOCK] = {0}, before[WARP_BLOCK];
  for (size_t k = 0; k < n; k++) wanted[k] = u[k][1];
  intervals(w->marginal, (size_t)w->height, w->height, n, b, lists, wanted, y, before);
  for (size_t k = 0; k < n; k++) {
    size_t row = y[k] * width;
    float r0 = blended(w->conditional, stride, b + k, row + width - 1);
    float r1 = blended(w->conditional, stride, b + k, row + 2 * width - 1);
    float t = solve(wanted[k] - before[k], r0, r1);
    lists[k] = (list){row, width, t};
    wanted[k] = u[k][0] * ((1 - t) * r0 + t * r1);
  }
  intervals(w->conditional, stride, w->width, n, b, lists, wanted, x, before);
  for (size_t k = 0; k < n; k++) {
    float c[2];
    borders(w, stride, b + k, lists[k].at + x[k], lists[k].t, c);
    float t = solve(wanted[k] - before[k], c[0], c[1]);
    out[k][0] = ((float)x[k] + t) / (float)(w->width - 1);
    out[k][1] = ((float)y[k] + lists[k].t) / (float)(w->height - 1);
    density[k] = per_square(w, t, c);
  }
}

float ylm__warp_invert(const warp *w, const blend *b, const float at[2], float u[2]) {
  size_t width = (size_t)w->width, stride = width * (size_t)w->height;
  float tx, ty, c[2];
  int x = cell_of(at[0], w->width, &tx), y = cell_of(at[1], w->height, &ty);
  size_t row = (size_t)y * width, i = row + (size_t)x;
  borders(w, stride, b, i, ty, c);
  float r0 = blended(w->conditional, stride, b, row + width - 1);
  float r1 = blended(w->conditional, stride, b, row + 2 * width - 1);
  float sum = (1 - ty) * r0 + ty * r1;
  float along = (1 - ty) * blended(w->conditional, stride, b, i) +
                ty * blended(w->conditional, stride, b, i + width) +
                tx * (c[0] + tx / 2 * (c[1] - c[0]));
  u[0] = sum > 0 ? minimum(along / sum, 1) : 0;
  u[1] = minimum(
      blended(w->marginal, (size_t)w->height, b, (size_t)y) + ty * (r0 + ty / 2 * (r1 - r0)), 1);
  return per_square(w, tx, c);
}
