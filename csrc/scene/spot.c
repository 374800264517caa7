/*
** spot.c - spots: places that rays are aimed at.
**
** A spot is sampled as if it filled a solid angle so small that no other ray finds it: estimates by several
** kinds of rays leave its light to the rays that are aimed.
*/
#include <math.h>

#include "scene.h"
#include "ylm_light_spot.h"

#define SOLID 1e-12    /* sr */
#define BRIGHTEST 1e36 /* of a radiance, whose sums are floats */

ylm_status ylm__scene_copy_spots(ylm_scene *s, const ylm_scene_lamps *l) {
  ylm_light_spot one;
  size_t n = 0;
  while (l->sky && ylm_light_set_spot(l->sky, n, &one)) n++;
  s->spot = ylm_alloc(n, sizeof *s->spot);
  if (!s->spot) return YLM_ENOMEM;
  for (; s->spots < n; s->spots++) {
    ylm_light_spot *spot = &s->spot[s->spots];
    ylm_light_set_spot(l->sky, s->spots, spot);
    for (int a = 0; a < 3; a++) spot->at[a] -= s->origin[a];
  }
  return YLM_OK;
}

size_t ylm_scene_spots(const ylm_scene *s, const ylm_light_spot **spot) {
  if (spot) *spot = s->spot;
  return s->spots;
}

/* The way to spot i, of length 1, its length, and the part of the intensity that comes along it, over its square. */
static double look(const ylm_scene *s, size_t i, const float x[3], double v[3], double *distance) {
  const ylm_light_spot *spot = &s->spot[i];
  double d2 = 0, along = 0;
  for (int a = 0; a < 3; a++) {
    v[a] = spot->at[a] - (double)x[a];
    d2 += v[a] * v[a];
  }
  *distance = sqrt(d2);
  if (!(d2 > 0)) return 0;
  for (int a = 0; a < 3; a++) {
    v[a] /= *distance;
    along -= v[a] * spot->axis[a];
  }
  return ylm_light_spot_part(spot, along) / d2;
}

static double facing(const double v[3], const float *n) {
  return n ? fmax(0, v[0] * (double)n[0] + v[1] * (double)n[1] + v[2] * (double)n[2]) : 1;
}

void ylm__scene_spot_weights(const ylm_scene *s, const float x[3], const float *n, float *weight,
                             float *sum) {
  for (size_t i = 0; i < s->spots; i++) {
    double v[3], d, part = look(s, i, x, v, &d);
    if (i % YLM_LAMP_CHUNK == 0) sum[i / YLM_LAMP_CHUNK] = 0;
    weight[i] =
        (float)fmin(part * facing(v, n) * ylm_luminance_size(s->spot[i].intensity), BRIGHTEST);
    sum[i / YLM_LAMP_CHUNK] += weight[i];
  }
}

double ylm__scene_spot_sample(const ylm_scene *s, size_t i, const float x[3], const float *n,
                              ylm_trace_ray *ray, float radiance[3]) {
  double v[3], d, part = look(s, i, x, v, &d);
  float at[3];
  if (!(part > 0)) return 0;
  for (int a = 0; a < 3; a++) {
    at[a] = (float)s->spot[i].at[a];
    ray->org[a] = x[a];
    ray->dir[a] = (float)v[a];
    radiance[a] = (float)fmin(fmax(s->spot[i].intensity[a] * part / SOLID, -BRIGHTEST), BRIGHTEST);
  }
  ray->near = 0; /* a spot may be on a wall: the ray ends just before it */
  ray->far = fmaxf(0, (float)(d * (1 - 1e-5)) - ylm_trace_offset(s->trace, at));
  return SOLID * facing(v, n);
}
