/* texture.c - images that are looked up at texture coordinates. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "ylm_image_texture.h"

struct ylm_texture {
  atomic_size_t holders;
  size_t width, height;
  ylm_texture_wrap wrap[2];
  float mean[3];
  float texel[]; /* [height][width][3] */
};

/* Copies texels as three channels; false where one of them, `where`, is outside of 0 .. 1. */
static bool copy_texels(size_t n, size_t channels, const float *in, float *out, size_t *where) {
  for (*where = 0; *where < n; ++*where, in += channels, out += 3)
    for (size_t c = 0; c < 3; c++) {
      out[c] = in[channels < 3 ? 0 : c];
      if (!(out[c] >= 0 && out[c] <= 1)) return false;
    }
  return true;
}

static ylm_status refuse(const float texel[3], size_t row, size_t column, ylm_error *e) {
  static const char *const names[] = {"red", "green", "blue"};
  int c = 0;
  while (c < 2 && texel[c] >= 0 && texel[c] <= 1) c++;
  return ylm_fail(e, YLM_EDOMAIN, "row %zu, column %zu: %s must be from 0 to 1, got %g", row + 1,
                  column + 1, names[c], (double)texel[c]);
}

static void find_mean(ylm_texture *t) {
  double sum[3] = {0};
  size_t n = t->width * t->height;
  for (size_t i = 0; i < 3 * n; i++) sum[i % 3] += (double)t->texel[i];
  for (int c = 0; c < 3; c++) t->mean[c] = (float)(sum[c] / (double)n);
}

ylm_status ylm_texture_create(size_t width, size_t height, int channels, const float *texel,
                              ylm_texture **texture, ylm_error *e) {
  *texture = NULL;
  if (width < 1 || height < 1 || channels < 1 || channels > 4)
    return ylm_fail(e, YLM_ERANGE, "a texture of %zux%zu texels of %d channels", width, height,
                    channels);
  if (width > YLM_IMAGE_MAX_SIDE || height > YLM_IMAGE_MAX_SIDE ||
      width * height > YLM_IMAGE_MAX_PIXELS)
    return ylm_fail(e, YLM_EOVERFLOW, "a texture of %zux%zu texels is too large", width, height);
  size_t n = width * height, where;
  ylm_texture *t = ylm_alloc(1, sizeof *t + 3 * n * sizeof(float));
  if (!t) return YLM_ENOMEM;
  t->width = width;
  t->height = height;
  t->wrap[0] = t->wrap[1] = YLM_TEXTURE_REPEAT;
  if (!copy_texels(n, (size_t)channels, texel, t->texel, &where)) {
    ylm_status s = refuse(t->texel + 3 * where, where / width, where % width, e);
    ylm_free(t);
    return s;
  }
  atomic_init(&t->holders, 1);
  find_mean(t);
  *texture = t;
  return YLM_OK;
}

/* The count of holders is no part of what a texture is. */
static atomic_size_t *holders(const ylm_texture *t) {
  return &((ylm_texture *)(uintptr_t)t)->holders;
}

const ylm_texture *ylm_texture_keep(const ylm_texture *t) {
  if (t) atomic_fetch_add(holders(t), 1);
  return t;
}

uint64_t ylm_texture_print(const ylm_texture *t) {
  uint64_t form[4] = {t->width, t->height, t->wrap[0], t->wrap[1]};
  return ylm_crc64(ylm_crc64(0, form, sizeof form), t->texel,
                   3 * t->width * t->height * sizeof *t->texel);
}

void ylm_texture_free(const ylm_texture *t) {
  if (t && atomic_fetch_sub(holders(t), 1) == 1) ylm_free((void *)(uintptr_t)t);
}

void ylm_texture_size(const ylm_texture *t, size_t *width, size_t *height) {
  *width = t->width;
  *height = t->height;
}

void ylm_texture_mean(const ylm_texture *t, float mean[3]) {
  memcpy(mean, t->mean, sizeof t->mean);
}

void ylm_texture_set_wrap(ylm_texture *t, ylm_texture_wrap u, ylm_texture_wrap v) {
  t->wrap[0] = u;
  t->wrap[1] = v;
}

static double fold(ylm_texture_wrap wrap, double x) {
  if (wrap == YLM_TEXTURE_REPEAT) return x - floor(x);
  if (wrap == YLM_TEXTURE_CLAMP) return x < 0 ? 0 : x > 1 ? 1 : x;
  double in = x - 2 * floor(x / 2);
  return in > 1 ? 2 - in : in;
}

double ylm_texture_fold(ylm_texture_wrap wrap, double x) { return fold(wrap, x); }

/* The two of n texels in a row beside the place x of 0 .. 1, and the second one's weight. */
static double neighbours(ylm_texture_wrap wrap, double x, size_t n, size_t *a, size_t *b) {
  double at = x * (double)n - 0.5, low = floor(at);
  bool around = wrap == YLM_TEXTURE_REPEAT;
  *a = low >= 0 ? (size_t)low : around ? n - 1 : 0;
  *b = low < 0 ? 0 : *a + 1 < n ? *a + 1 : around ? 0 : *a;
  return at - low;
}

void ylm_texture_at(const ylm_texture *t, float u, float v, float out[3]) {
  size_t left, right, top, bottom;
  double x = fold(t->wrap[0], (double)u), y = fold(t->wrap[1], (double)v);
  float s = (float)neighbours(t->wrap[0], x, t->width, &left, &right);
  float r = (float)neighbours(t->wrap[1], 1 - y, t->height, &top, &bottom);
  const float *first = t->texel + 3 * t->width * top, *second = t->texel + 3 * t->width * bottom;
  for (int c = 0; c < 3; c++) {
    float a = first[3 * left + (size_t)c], b = first[3 * right + (size_t)c];
    float d = second[3 * left + (size_t)c], e = second[3 * right + (size_t)c];
    float above = a + s * (b - a), below = d + s * (e - d);
    out[c] = above + r * (below - above);
  }
}
