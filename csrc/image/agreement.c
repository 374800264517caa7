/* agreement.c - whether two noisy images agree: their squared difference over what their noise lets
   expect. */
#include "ylm_image.h"

#include <math.h>
#include <string.h>

#define BLOCK_WIDTH 16
#define BLOCK_HEIGHT 9

typedef struct pair {
  const ylm_layer *value[2], *variance[2]; /* of both images; a variance may be NULL */
  const float *mask;
  size_t width, height, channels;
} pair;

/* Adds pixel i; false: a number that counts is not finite, or a variance negative. */
static bool add(const pair *p, size_t i, double *square, double *expected) {
  for (size_t k = i * p->channels; k < (i + 1) * p->channels; k++) {
    double d = (double)p->value[0]->data[k] - (double)p->value[1]->data[k], v = 0;
    for (int side = 0; side < 2; side++)
      if (p->variance[side]) {
        if (!(p->variance[side]->data[k] >= 0)) return false;
        v += (double)p->variance[side]->data[k];
      }
    if (!isfinite(d) || !isfinite(v)) return false;
    *square += d * d;
    *expected += v;
  }
  return true;
}

static double ratio(double square, double expected) {
  return expected > 0 ? square / expected : square > 0 ? INFINITY : 0;
}

/* Sums over one block. */
static ylm_status add_block(const pair *p, size_t x0, size_t y0, ylm_agreement *out,
                            double total[2], ylm_error *e) {
  double square = 0, expected = 0;
  for (size_t y = y0; y < y0 + BLOCK_HEIGHT && y < p->height; y++)
    for (size_t x = x0; x < x0 + BLOCK_WIDTH && x < p->width; x++) {
      size_t i = y * p->width + x;
      if (p->mask && p->mask[i] == 0) continue;
      out->pixels++;
      if (!add(p, i, &square, &expected))
        return ylm_fail(e, YLM_EDOMAIN,
                        "pixel (%zu, %zu) or its variance is not finite or negative: give a mask "
                        "that leaves it out",
                        x + 1, y + 1);
    }
  total[0] += square;
  total[1] += expected;
  if (ratio(square, expected) > out->z2_block) {
    out->z2_block = ratio(square, expected);
    out->block[0] = (int)x0;
    out->block[1] = (int)y0;
  }
  return YLM_OK;
}

/* The layer of values and that of variances of one image; a missing variance is NULL. */
static ylm_status find(const ylm_image *image, const char *name, const ylm_layer **value,
                       const ylm_layer **variance, ylm_error *e) {
  *value = ylm_image_find(image, name);
  if (!*value)
    return ylm_fail(e, YLM_EINVAL, "no layer '%s' in both images", name ? name : "(first)");
  *variance = ylm_image_find(image, "variance");
  if (*variance && (*variance)->channels != (*value)->channels)
    return ylm_fail(e, YLM_ESHAPE, "layer '%s' has %d channels, the layer variance %d",
                    (*value)->name, (*value)->channels, (*variance)->channels);
  return YLM_OK;
}

ylm_status ylm_image_agree(const ylm_image *a, const ylm_image *b, const char *name,
                           const float *mask, ylm_agreement *out, ylm_error *e) {
  pair p = {.mask = mask, .width = (size_t)a->width, .height = (size_t)a->height};
  double total[2] = {0, 0};
  *out = (ylm_agreement){0};
  if (a->width != b->width || a->height != b->height)
    return ylm_fail(e, YLM_ESHAPE, "sizes differ: %d x %d and %d x %d", a->width, a->height,
                    b->width, b->height);
  ylm_status s = find(a, name, &p.value[0], &p.variance[0], e);
  if (s == YLM_OK) s = find(b, name, &p.value[1], &p.variance[1], e);
  if (s != YLM_OK) return s;
  p.channels = (size_t)p.value[0]->channels;
  if (p.value[0]->channels != p.value[1]->channels)
    return ylm_fail(e, YLM_ESHAPE, "layer '%s' has %d channels, the other one %d", p.value[0]->name,
                    p.value[0]->channels, p.value[1]->channels);
  if (!p.variance[0] && !p.variance[1])
    return ylm_fail(e, YLM_EINVAL,
                    "neither image has a layer variance, as those of pathtrace and raycast have");
  for (size_t y = 0; s == YLM_OK && y < p.height; y += BLOCK_HEIGHT)
    for (size_t x = 0; s == YLM_OK && x < p.width; x += BLOCK_WIDTH)
      s = add_block(&p, x, y, out, total, e);
  if (s == YLM_OK && out->pixels == 0) return ylm_fail(e, YLM_EINVAL, "the mask leaves no pixel");
  out->z2 = ratio(total[0], total[1]);
  return s;
}
