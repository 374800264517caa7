/* colour.c - numbers as colours. */
#include "ylm_figure.h"

#include <math.h>
#include <string.h>

/* Anchors at equal distances, 0xRRGGBB; between them linear.
   viridis, inferno, magma, plasma: Smith & van der Walt 2015 (CC0); turbo: Mikhailov 2019;
   coolwarm: Moreland 2009. */
typedef struct map {
  const char *name;
  int n;
  uint32_t anchor[16];
} map;

static const map maps[] = {
    {"viridis", 11, {0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e, 0x21918c, 0x22a884,
                     0x44bf70, 0x7ad151, 0xbddf26, 0xfde725}},
    {"inferno", 11, {0x000004, 0x160b39, 0x420a68, 0x6a176e, 0x932667, 0xbc3754, 0xdd513a,
                     0xf37819, 0xfca50a, 0xf6d746, 0xfcffa4}},
    {"magma", 11, {0x000004, 0x140e36, 0x3b0f70, 0x641a80, 0x8c2981, 0xb73779, 0xde4968,
                   0xf7705c, 0xfe9f6d, 0xfecf92, 0xfcfdbf}},
    {"plasma", 11, {0x0d0887, 0x41049d, 0x6a00a8, 0x8f0da4, 0xb12a90, 0xcc4778, 0xe16462,
                    0xf2844b, 0xfca636, 0xfcce25, 0xf0f921}},
    {"turbo", 15, {0x30123b, 0x4145ab, 0x4675ed, 0x39a2fc, 0x1bcfd4, 0x24eca6, 0x61fc6c, 0xa4fc3b,
                   0xd1e834, 0xf3c63a, 0xfe9b2d, 0xf36315, 0xd93806, 0xb11901, 0x7a0402}},
    {"coolwarm", 11, {0x3b4cc0, 0x5a78e4, 0x7b9ff9, 0x9ebeff, 0xc0d4f5, 0xdddcdc, 0xf2cbb7,
                      0xf7ac8e, 0xee8468, 0xd65244, 0xb40426}},
    {"grey", 2, {0x000000, 0xffffff}},
};

static const char *const names[] = {"viridis", "inferno", "magma", "plasma",
                                    "turbo", "coolwarm", "grey", NULL};

const char *const *ylm_figure_map_names(void) { return names; }

static const map *find(const char *name) {
  for (size_t i = 0; i < sizeof maps / sizeof *maps; i++)
    if (strcmp(maps[i].name, name) == 0) return &maps[i];
  return NULL;
}

static void colour_at(const map *m, double t, double rgb[3]) {
  t = fmin(1, fmax(0, t)) * (m->n - 1);
  int i = (int)t < m->n - 1 ? (int)t : m->n - 2;
  t -= i;
  for (int a = 0; a < 3; a++) {
    int shift = 16 - 8 * a;
    double x = m->anchor[i] >> shift & 255, y = m->anchor[i + 1] >> shift & 255;
    rgb[a] = (x + t * (y - x)) / 255;
  }
}

bool ylm_figure_map(const char *name, double t, double rgb[3]) {
  const map *m = find(name);
  if (m) colour_at(m, t, rgb);
  return m != NULL;
}

double ylm_figure_place(const ylm_figure_scale *s, double x) {
  double lo = s->least, hi = s->largest;
  if (s->logarithmic) {
    if (!(x > 0)) return NAN;
    x = log(x), lo = log(lo), hi = log(hi);
  }
  if (isnan(x)) return NAN;
  return hi > lo ? fmin(1, fmax(0, (x - lo) / (hi - lo))) : 0.5;
}

ylm_status ylm_figure_colours(const ylm_figure_scale *s, size_t n, const double *x,
                              const double none[3], double *rgb) {
  const map *m = find(s->map);
  if (!m) return YLM_EINVAL;
  for (size_t i = 0; i < n; i++) {
    double t = ylm_figure_place(s, x[i]);
    if (isnan(t)) memcpy(rgb + 3 * i, none, 3 * sizeof *rgb);
    else colour_at(m, t, rgb + 3 * i);
  }
  return YLM_OK;
}

ylm_status ylm_figure_pixels(const ylm_figure_volume *v, const ylm_figure_scale *s, double opacity,
                             uint8_t *rgba) {
  const map *m = find(s->map);
  if (!m) return YLM_EINVAL;
  size_t n = v->size[0] * v->size[1] * v->size[2];
  for (size_t i = 0; i < n; i++) {
    double t = ylm_figure_place(s, v->value[i * (size_t)v->components]), rgb[3] = {0, 0, 0};
    if (!isnan(t)) colour_at(m, t, rgb);
    for (size_t a = 0; a < 3; a++) rgba[4 * i + a] = (uint8_t)(255 * rgb[a] + 0.5);
    rgba[4 * i + 3] = isnan(t) ? 0 : (uint8_t)(255 * fmin(1, fmax(0, opacity)) + 0.5);
  }
  return YLM_OK;
}

ylm_status ylm_figure_places(const ylm_figure_volume *v, const ylm_figure_scale *s,
                             ylm_figure_volume *place) {
  size_t n = v->size[0] * v->size[1] * v->size[2];
  *place = *v;
  place->components = 1;
  place->value = ylm_alloc(n, sizeof(float));
  if (!place->value) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++)
    place->value[i] = (float)ylm_figure_place(s, v->value[i * (size_t)v->components]);
  return YLM_OK;
}
