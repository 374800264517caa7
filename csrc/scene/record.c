/* record.c - lamps of a scene one by one: the light that each of them is, and rays to it. */
#include <math.h>

#include "scene.h"
#include "ylm_light.h"

static void widen(const float *from, int n, double *to) {
  for (int a = 0; a < n; a++) to[a] = (double)from[a];
}

/* Radiance, horizon and corners of a triangle; of a disk its centre and two half axes. */
static size_t flat_record(const ylm_scene *s, size_t i, double *x) {
  bool triangle = i < s->triangles;
  widen(s->lamp_radiance + 3 * (s->lamps + i), 3, x);
  for (int a = 0; a < 3; a++) x[3 + a] = s->horizon ? (double)s->horizon[3 * i + (size_t)a] : 0;
  x[6] = triangle ? 3 : 0;
  if (triangle) {
    widen(s->triangle + 9 * i, 9, x + 7);
    return 16;
  }
  const float *d = s->disk + 7 * (i - s->triangles);
  double n[3];
  float unit[3], a[3], b[3];
  widen(d + 4, 3, n);
  ylm_unit3(n);
  for (int k = 0; k < 3; k++) unit[k] = (float)n[k];
  ylm_scene_basis(unit, a, b);
  widen(d, 3, x + 7);
  for (int k = 0; k < 3; k++) {
    x[10 + k] = (double)d[3] * (double)a[k];
    x[13 + k] = (double)d[3] * (double)b[k];
  }
  return 16;
}

static size_t cone_record(const ylm_light_cone *c, double *x) {
  double area = YLM_PI * (1 - c->cosine * c->cosine);
  for (int k = 0; k < 3; k++) {
    x[k] = c->radiance[k] * area;
    x[3 + k] = c->axis[k];
  }
  x[6] = acos(c->cosine) * 360 / YLM_PI;
  return 7;
}

size_t ylm_scene_lamp_record(const ylm_scene *s, size_t lamp, const char **kind, double x[16]) {
  size_t near = ylm_scene_near(s), tiles = s->sky_lights - s->cones;
  if (lamp < s->lamps) {
    *kind = "sphere";
    widen(s->lamp_radiance + 3 * lamp, 3, x);
    for (int a = 0; a < 4; a++) x[3 + a] = (double)s->lamp[a][lamp];
    return 7;
  }
  if (lamp < near) {
    *kind = "polygon";
    return flat_record(s, lamp - s->lamps, x);
  }
  if (lamp - near < tiles) return 0;
  *kind = "sun";
  return cone_record(&s->cone[lamp - near - tiles], x);
}

bool ylm_scene_lamp_ray(const ylm_scene *s, size_t lamp, const float x[3], const double u[2],
                        ylm_trace_ray *ray) {
  size_t near = ylm_scene_near(s);
  float radiance[3];
  const float *there;
  if (lamp < s->lamps) return ylm__scene_sphere_sample(s, lamp, x, NULL, u[0], u[1], ray) > 0;
  if (lamp < near)
    return ylm__scene_patch_sample_one(s, lamp - s->lamps, x, NULL, u[0], u[1], 0, ray, &there) > 0;
  return ylm__scene_sky_sample(s, lamp - near, x, NULL, u[0], u[1], ray, radiance) > 0;
}

double ylm_scene_distant_ray(const ylm_scene *s, size_t i, const double u[2], float direction[3],
                             float radiance[3]) {
  ylm_trace_ray ray;
  double area =
      ylm__scene_sky_sample(s, i, (const float[]){0, 0, 0}, NULL, u[0], u[1], &ray, radiance);
  memcpy(direction, ray.dir, sizeof ray.dir);
  return area;
}

double ylm_scene_distant_power(const ylm_scene *s, size_t i) {
  return YLM_PI * (double)s->sky_bound[5][i]; /* times power over pi */
}

const ylm_light_set *ylm_scene_sky(const ylm_scene *s) { return s->sky; }
