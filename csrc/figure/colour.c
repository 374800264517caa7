/* colour.c - numbers as colours. */
#include "ylm_figure.h"
#include "ylm_image.h"

#include <math.h>
#include <string.h>

/* The colour at t of a map of csrc/image. */
static void colour_at(ylm_colourmap m, double t, double rgb[3]) {
  float c[3];
  ylm_colourmap_at(m, t, c);
  for (int a = 0; a < 3; a++) rgb[a] = fmin(1, fmax(0, (double)c[a]));
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
  ylm_colourmap m;
  if (!ylm_colourmap_find(s->map, &m)) return YLM_EINVAL;
  for (size_t i = 0; i < n; i++) {
    double t = ylm_figure_place(s, x[i]);
    if (isnan(t))
      memcpy(rgb + 3 * i, none, 3 * sizeof *rgb);
    else
      colour_at(m, t, rgb + 3 * i);
  }
  return YLM_OK;
}

ylm_status ylm_figure_pixels(const ylm_figure_volume *v, const ylm_figure_scale *s, double opacity,
                             uint8_t *rgba) {
  ylm_colourmap m;
  if (!ylm_colourmap_find(s->map, &m)) return YLM_EINVAL;
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
