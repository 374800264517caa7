/* sky.c - distant lights: seen by rays that hit nothing, and aimed at. */
#include <math.h>

#include "scene.h"

#define PI 3.14159265358979323846
/* Directions that the mean luminance of the sky is taken over. */
#define LOOKS 64

static double luminance_of(const double *c) {
  return YLM_LUMINANCE_R * fabs(c[0]) + YLM_LUMINANCE_G * fabs(c[1]) + YLM_LUMINANCE_B * fabs(c[2]);
}

/* The mean over directions that are spread evenly (Fibonacci's lattice). */
static double mean_luminance(const ylm_light_set *sky) {
  double sum = 0;
  for (int i = 0; i < LOOKS; i++) {
    double z = (2 * i + 1.0) / LOOKS - 1, r = sqrt(1 - z * z), u = 2 * PI * i * 0.6180339887498949;
    double d[3] = {r * cos(u), r * sin(u), z}, rgb[3];
    ylm_light_set_sky(sky, d, false, rgb);
    sum += luminance_of(rgb) / LOOKS;
  }
  return sum;
}

ylm_status ylm__scene_share_sky(ylm_scene *s, const ylm_scene_lamps *l) {
  ylm_light_cone cone;
  if (!l->sky || !ylm_light_set_is_distant(l->sky)) return YLM_OK;
  ylm_status status = ylm_light_set_create(1, &(ylm_light_source){.set = l->sky}, &s->sky, NULL);
  if (status != YLM_OK) return status;
  size_t n = 0;
  while (ylm_light_set_cone(s->sky, n, &cone)) n++;
  s->cone = ylm_alloc(n, sizeof *s->cone);
  if (!s->cone) return YLM_ENOMEM;
  for (s->cones = 0; s->cones < n; s->cones++)
    ylm_light_set_cone(s->sky, s->cones, &s->cone[s->cones]);
  s->sky_is_seen = l->sky_is_seen;
  s->sky_luminance = (float)mean_luminance(s->sky);
  return YLM_OK;
}

void ylm__scene_free_sky(ylm_scene *s) {
  ylm_light_set_free(s->sky);
  ylm_free(s->cone);
}

bool ylm_scene_sky_radiance(const ylm_scene *s, const ylm_trace_ray *ray, double radiance[3]) {
  double d[3], length = 0;
  if (!s->sky || !s->sky_is_seen) return false;
  for (int a = 0; a < 3; a++) length += (double)ray->dir[a] * (double)ray->dir[a];
  for (int a = 0; a < 3; a++) d[a] = (double)ray->dir[a] / sqrt(length);
  ylm_light_set_sky(s->sky, d, true, radiance);
  return true;
}

/* Bound of the irradiance over pi of a cone of radiance 1; n NULL: the scalar one. */
static double cone_weight(const ylm_light_cone *c, const float n[3]) {
  double up = 0, wide = sqrt(fmax(0, 1 - c->cosine * c->cosine));
  if (!n) return 2 * (1 - c->cosine);
  for (int a = 0; a < 3; a++) up += c->axis[a] * (double)n[a];
  return fmax(0, up + wide) * 2 * (1 - c->cosine);
}

void ylm__scene_sky_weights(const ylm_scene *s, const float n[3], float *weight, float *sum) {
  size_t count = ylm__scene_sky_lights(s);
  for (size_t b = 0; b * YLM_LAMP_CHUNK < count; b++) {
    size_t first = b * YLM_LAMP_CHUNK,
           end = count - first < YLM_LAMP_CHUNK ? count : first + YLM_LAMP_CHUNK;
    double total = 0;
    for (size_t i = first; i < end; i++) {
      double w = i == 0 ? (n ? 1 : 4) * (double)s->sky_luminance
                        : cone_weight(&s->cone[i - 1], n) * luminance_of(s->cone[i - 1].radiance);
      weight[i] = (float)w;
      total += (double)weight[i];
    }
    sum[b] = (float)total;
  }
}

double ylm__scene_sky_sample(const ylm_scene *s, size_t i, const float x[3], const float n[3],
                             double u0, double u1, ylm_trace_ray *ray, float radiance[3]) {
  static const float pole[3] = {0, 0, 1};
  double rgb[3], d[3];
  for (int a = 0; a < 3; a++) ray->org[a] = x[a];
  ray->near = 0;
  ray->far = INFINITY;
  if (i > 0) {
    const ylm_light_cone *c = &s->cone[i - 1];
    float axis[3] = {(float)c->axis[0], (float)c->axis[1], (float)c->axis[2]};
    ylm__scene_turn(axis, 1 - u0 * (1 - c->cosine), u1, ray->dir);
    for (int a = 0; a < 3; a++) radiance[a] = (float)c->radiance[a];
    return (n ? fmax(0, (double)ylm_dot3(ray->dir, n)) : 1) * 2 * PI * (1 - c->cosine);
  }
  ylm__scene_turn(n ? n : pole, n ? sqrt(1 - u0) : 1 - 2 * u0, u1, ray->dir);
  for (int a = 0; a < 3; a++) d[a] = (double)ray->dir[a];
  ylm_light_set_sky(s->sky, d, false, rgb);
  for (int a = 0; a < 3; a++) radiance[a] = (float)rgb[a];
  return n ? PI : 4 * PI;
}

double ylm__scene_sky_density(const ylm_scene *s, size_t i, const float n[3], const float d[3]) {
  if (i > 0) return 1 / (2 * PI * (1 - s->cone[i - 1].cosine));
  return n ? fmax(0, (double)ylm_dot3(d, n)) / PI : 1 / (4 * PI);
}

size_t ylm_scene_distant(const ylm_scene *s) { return ylm__scene_sky_lights(s); }

bool ylm_scene_distant_radiance(const ylm_scene *s, size_t i, const float direction[3],
                                float radiance[3]) {
  double d[3], rgb[3], cosine = 0;
  for (int a = 0; a < 3; a++) d[a] = (double)direction[a];
  if (i == 0) {
    ylm_light_set_sky(s->sky, d, false, rgb);
    for (int a = 0; a < 3; a++) radiance[a] = (float)rgb[a];
    return true;
  }
  const ylm_light_cone *c = &s->cone[i - 1];
  for (int a = 0; a < 3; a++) cosine += c->axis[a] * d[a], radiance[a] = (float)c->radiance[a];
  return cosine >= c->cosine;
}
