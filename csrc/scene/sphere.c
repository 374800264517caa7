/* sphere.c - lamps that are spheres: how bright each may be at a place, and rays to it. */
#include <math.h>
#include <string.h>

#include "calibration.h"
#include "scene.h"

static size_t count(const ylm_scene *s) { return s->lamps; }

/* ylm_scene_weights_fn for few lamps, and for points in space. */
static void weigh_few(const ylm_scene_chooser *c, const float *normal, float *weight, float *sum) {
  const ylm_scene *s = c->scene;
  for (size_t i = 0; i < s->lamps; i++) {
    double v[3];
    if (i % YLM_LAMP_CHUNK == 0) sum[i / YLM_LAMP_CHUNK] = 0;
    for (int a = 0; a < 3; a++) v[a] = (double)s->lamp[a][i] - (double)c->x[a];
    weight[i] = (float)ylm__scene_weight(v, (double)s->lamp[3][i], normal) * s->lamp_luminance[i];
    sum[i / YLM_LAMP_CHUNK] += weight[i];
  }
}

static void weigh(const ylm_scene_chooser *c, bool one, float *weight, float *sum) {
  const ylm_scene *s = c->scene;
  const float *n = c->in_space ? NULL : c->normal;
  if (n && (!one || s->lamps > CHOOSE_FEW))
    c->weights(s->lamps, s->lamp, s->lamp_luminance, c->x, n, weight, sum);
  else
    weigh_few(c, n, weight, sum);
  if (s->directions > 0) ylm__scene_weigh_directed(s, 0, s->lamps, c->x, weight, sum);
}

/* From x to the centre of sphere i, and the square of that distance. */
static double to_centre(const ylm_scene *s, size_t i, const float x[3], double v[3]) {
  double d2 = 0;
  for (int a = 0; a < 3; a++) {
    v[a] = (double)s->lamp[a][i] - (double)x[a];
    d2 += v[a] * v[a];
  }
  return d2;
}

/* 1 minus the cosine of the half angle that a sphere fills at a distance: its part of 2 pi. */
static double cap_of(double r, double d2) {
  double s2 = r * r / d2;
  return s2 / (1 + sqrt(1 - s2));
}

static double sample_all(const ylm_scene *s, size_t i, const scene_aim *aim, ylm_trace_ray *ray,
                         float radiance[3]) {
  static const float pole[3] = {0, 0, 1};
  const float *x = aim->x, *n = aim->normal;
  double u0 = aim->u[0], u1 = aim->u[1];
  double v[3], r = s->lamp[3][i], d2 = to_centre(s, i, x, v);
  for (int a = 0; a < 3; a++) ray->org[a] = x[a];
  ray->near = 0;
  memcpy(radiance, s->lamp_radiance + 3 * i, 12);
  if (d2 <= r * r) { /* light from everywhere: directions as the cosine, to the lamp's far side */
    ylm__scene_turn(n ? n : pole, n ? sqrt(1 - u0) : 1 - 2 * u0, u1, ray->dir);
    double along = 0;
    for (int a = 0; a < 3; a++) along += v[a] * (double)ray->dir[a];
    ray->far = (float)(along + sqrt(fmax(0, along * along + r * r - d2)));
    return n ? YLM_PI : 4 * YLM_PI;
  }
  float axis[3];
  double d = sqrt(d2), cap = cap_of(r, d2);
  for (int a = 0; a < 3; a++) axis[a] = (float)(v[a] / d);
  double z = 1 - u0 * cap, side2 = d2 * fmax(0, 1 - z * z);
  ylm__scene_turn(axis, z, u1, ray->dir);
  ray->far = (float)(d * z - sqrt(fmax(0, r * r - side2)));
  return (n ? fmax(0, (double)ylm_dot3(ray->dir, n)) : 1) * 2 * YLM_PI * cap;
}

static double sample(const ylm_scene *s, size_t i, const scene_aim *aim, ylm_trace_ray *ray,
                     float radiance[3]) {
  double e = sample_all(s, i, aim, ray, radiance);
  if (e > 0) ylm__scene_directed_radiance(s, i, ray->dir, radiance);
  return e;
}

static double density(const ylm_scene_chooser *c, size_t i, const float d[3]) {
  const ylm_scene *s = c->scene;
  const float *x = c->x, *n = c->in_space ? NULL : c->normal;
  double v[3], r = s->lamp[3][i], d2 = to_centre(s, i, x, v);
  if (d2 <= r * r) return n ? fmax(0, (double)ylm_dot3(d, n)) / YLM_PI : 1 / (4 * YLM_PI);
  return 1 / (2 * YLM_PI * cap_of(r, d2));
}

static bool emitter(const ylm_scene *s, size_t i, ylm_light_emitter *out) {
  const double at[3] = {(double)s->lamp[0][i], (double)s->lamp[1][i], (double)s->lamp[2][i]};
  const ylm_light_emitter *directed = ylm__scene_directed(s, i);
  if (directed)
    *out = *directed;
  else
    ylm_light_emitter_sphere(s->lamp_radiance + 3 * i, at, (double)s->lamp[3][i], out);
  return true;
}

const scene_storage ylm__scene_spheres_storage = {count, weigh, sample, density, emitter};
