/*
** unwrap.c - fuzzes mesh:unwrap: a mesh of the bytes gets charts, within the picture and over each other nowhere, or is refused.
**
** The first bytes choose the number of vertices, the gutter, the angle, the stretch, and whether places are raw floats or steps
** of a lattice, on which triangles meet, fold and repeat. Triangles follow. Charts are judged pair by pair of triangles, and
** texel by texel.
*/
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "ylm_geom_unwrap.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { VERTICES = 32, TRIANGLES = 48, SMALL_TEXELS = 1024 };

typedef struct input {
  size_t vertices, triangles;
  float position[VERTICES][3];
  uint32_t index[TRIANGLES][3];
} input;

static bool read(const uint8_t *data, size_t size, input *in) {
  bool raw = data[4] & 1;
  size_t each = raw ? 12 : 3, at = 5;
  memset(in, 0, sizeof *in);
  in->vertices = 3 + data[0] % (VERTICES - 3);
  if (size < at + each * in->vertices + 3) return false;
  for (size_t i = 0; i < in->vertices; i++, at += each) {
    if (raw) memcpy(in->position[i], data + at, 12);
    for (size_t a = 0; !raw && a < 3; a++)
      in->position[i][a] = (float)((int)data[at + a] - 128) / (data[4] & 2 ? 1e6f : 16.0f);
  }
  for (; at + 3 <= size && in->triangles < TRIANGLES; at += 3, in->triangles++)
    for (size_t k = 0; k < 3; k++)
      in->index[in->triangles][k] = data[at + k] % (uint32_t)in->vertices;
  return true;
}

/* How deep two triangles are in each other: the least of the overlaps along the normals of their edges. */
static double depth(const double a[3][2], const double b[3][2]) {
  double least = INFINITY;
  for (int e = 0; e < 6; e++) {
    const double *p = (e < 3 ? a : b)[e % 3], *q = (e < 3 ? a : b)[(e + 1) % 3];
    double n[2] = {q[1] - p[1], p[0] - q[0]}, length = hypot(n[0], n[1]);
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    if (!(length > 0)) continue;
    for (int c = 0; c < 6; c++) {
      const double *x = (c < 3 ? a : b)[c % 3];
      double d = (x[0] * n[0] + x[1] * n[1]) / length;
      low[c / 3] = fmin(low[c / 3], d), high[c / 3] = fmax(high[c / 3], d);
    }
    least = fmin(least, fmin(high[0], high[1]) - fmax(low[0], low[1]));
  }
  return least;
}

static void check(const ylm_unwrap *u, const input *in, const ylm_unwrap_stats *s) {
  static double at[TRIANGLES][3][2];
  static uint32_t texel[SMALL_TEXELS * 4];
  for (size_t t = 0; t < in->triangles; t++) {
    ylm_unwrap_corners(u, 0, t, at[t]);
    for (int k = 0; k < 6; k++) {
      double x = at[t][k / 2][k % 2], most = (double)(k % 2 ? s->height : s->width);
      if (!(x >= 0 && x <= most)) __builtin_trap();
    }
    uint32_t chart = ylm_unwrap_chart(u, 0, t);
    if (chart == YLM_UNWRAP_NONE) continue;
    if (chart >= s->charts) __builtin_trap();
    for (size_t o = 0; o < t; o++)
      if (ylm_unwrap_chart(u, 0, o) != YLM_UNWRAP_NONE &&
          depth((const double(*)[2])at[t], (const double(*)[2])at[o]) > 2e-3)
        __builtin_trap();
  }
  if (s->width * s->height > SMALL_TEXELS * 4) return;
  if (ylm_unwrap_texels(u, texel) != YLM_OK) return;
  for (size_t t = 0; t < in->triangles; t++) {
    uint32_t chart = ylm_unwrap_chart(u, 0, t);
    if (chart == YLM_UNWRAP_NONE) continue;
    for (int k = 0; k < 3; k++) { /* the texels that a look-up at a corner reads are its chart's */
      double x = at[t][k][0] - 0.5, y = at[t][k][1] - 0.5;
      for (int c = 0; c < 4; c++) {
        double i = floor(x) + c % 2, j = floor(y) + c / 2;
        if ((1 - fabs(x - i)) * (1 - fabs(y - j)) < 1e-3) continue;
        if (i < 0 || j < 0 || i >= (double)s->width || j >= (double)s->height) continue;
        if (texel[(size_t)j * s->width + (size_t)i] != chart) __builtin_trap();
      }
    }
  }
}

static void split(const ylm_unwrap *u) {
  size_t n;
  uint32_t *from, *index;
  float *uv;
  if (ylm_unwrap_split(u, 0, &n, &from, &uv, &index, NULL) != YLM_OK) return;
  for (size_t i = 0; i < 2 * n; i++)
    if (!(uv[i] >= 0 && uv[i] <= 1)) __builtin_trap();
  ylm_free(from), ylm_free(index), ylm_free(uv);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static input in;
  ylm_unwrap *u;
  ylm_error e = {YLM_OK, ""};
  if (size < 8 || !read(data, size, &in)) return 0;
  const ylm_unwrap_mesh mesh = {in.vertices, in.triangles, in.position[0], in.index[0]};
  const ylm_unwrap_form form = {
      .angle = 1 + data[1] % 80, .stretch = 1.001 + data[2] / 64.0, .threads = 1};
  ylm_status s = ylm_unwrap_create(1, &mesh, &form, &u, &e);
  if (s != YLM_OK) {
    if (!e.text[0]) __builtin_trap(); /* a sentence */
    return 0;
  }
  ylm_unwrap_stats stats;
  ylm_unwrap_look(u, &stats);
  double *density = ylm_alloc(stats.charts, sizeof *density);
  for (size_t i = 0; i < stats.charts; i++) density[i] = 1 + (double)(i % 3);
  s = ylm_unwrap_fit(u, density, data[3] % 5, SMALL_TEXELS, NULL, &e);
  ylm_unwrap_look(u, &stats);
  if (s == YLM_OK && stats.width * stats.height > SMALL_TEXELS) __builtin_trap();
  if (s == YLM_OK) check(u, &in, &stats), split(u);
  ylm_free(density);
  ylm_unwrap_free(u);
  return 0;
}
