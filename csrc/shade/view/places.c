/* places.c - other places of a shading point: those of its triangle that samples of its pixel hit. */
#include <string.h>

#include "../calibration.h"
#include "../view.h"

/* The number of the sample that has bit b. */
static int sample_of(const ylm_shade_view *v, int b) {
  int known = v->o.samples < SHADE_PLACES ? v->o.samples : SHADE_PLACES;
  return b * v->o.samples / known;
}

/* Bits that are set, in rising order; their number. */
static size_t list_bits(uint32_t bits, int list[32]) {
  size_t n = 0;
  for (int b = 0; b < 32; b++)
    if (bits >> b & 1) list[n++] = b;
  return n;
}

size_t ylm__shade_places(const ylm_shade_view *v, size_t p, size_t i, size_t n, ylm_rng *rng,
                         float (*origin)[3]) {
  int list[32], at[2];
  double shift[2];
  size_t known = v->corner ? 0 : list_bits(v->entry[i].samples, list);
  if (known < 2) return 0;
  if (n > known) n = known;
  ylm__shade_pixel_shift(v, p, at, shift);
  double first = ylm_rng_double(rng);
  for (size_t k = 0; k < n; k++) {
    size_t one = (size_t)(((double)k + first) / (double)n * (double)known);
    ylm_trace_ray ray;
    ylm_scene_place place;
    ylm_scene_surface s;
    ylm__shade_pixel_ray(v, at, shift, sample_of(v, list[one < known ? one : known - 1]), &ray);
    memcpy(origin[k], v->origin[i], 12);
    if (!ylm_scene_cross(v->scene, &v->entry[i].at, &ray, &place)) continue;
    ylm_scene_surfaces(v->scene, 1, &place, &s);
    memcpy(origin[k], s.origin, 12);
  }
  return n;
}
