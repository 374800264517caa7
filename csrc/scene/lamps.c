/* lamps.c - what lamps emit, and rays from a point to the lamps, chosen by what they may bring. */
#include <math.h>

#include "scene.h"

#define PI 3.14159265358979323846

const float *ylm_scene_lamp_radiance(const ylm_scene *s, const ylm_trace_ray *ray,
                                     const ylm_trace_hit *h) {
  double p[3];
  if (h->element < s->lamps) return s->lamp_radiance + 3 * h->element;
  for (int a = 0; a < 3; a++) p[a] = (double)ray->org[a] + (double)h->t * (double)ray->dir[a];
  return ylm__scene_patch_radiance(s, h->element - s->lamps, p);
}

void ylm__scene_walk_to(scene_walk *w, const ylm_scene_chooser *s, double target) {
  size_t chunks = s->chunks;
  while (w->lamp % YLM_LAMP_CHUNK == 0 && w->chunk + 1 < chunks &&
         w->passed + s->sum[w->chunk] <= target) {
    w->passed += s->sum[w->chunk++];
    w->lamp = w->chunk * YLM_LAMP_CHUNK;
  }
  while (w->passed + s->weight[w->lamp] <= target && w->lamp + 1 < chunks * YLM_LAMP_CHUNK) {
    w->passed += s->weight[w->lamp++];
    w->chunk = w->lamp / YLM_LAMP_CHUNK;
    while (w->lamp % YLM_LAMP_CHUNK == 0 && w->chunk + 1 < chunks &&
           w->passed + s->sum[w->chunk] <= target) {
      w->passed += s->sum[w->chunk++];
      w->lamp = w->chunk * YLM_LAMP_CHUNK;
    }
  }
}

void ylm__scene_turn(const float axis[3], double z, double u, float out[3]) {
  float a[3], b[3];
  double r = sqrt(fmax(0, 1 - z * z)), c = r * cos(2 * PI * u), s = r * sin(2 * PI * u);
  ylm_scene_basis(axis, a, b);
  for (int k = 0; k < 3; k++) out[k] = (float)(c * a[k] + s * b[k] + z * axis[k]);
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

double ylm__scene_sphere_sample(const ylm_scene *s, size_t i, const float x[3], const float n[3],
                                double u0, double u1, ylm_trace_ray *ray) {
  static const float pole[3] = {0, 0, 1};
  double v[3], r = s->lamp[3][i], d2 = to_centre(s, i, x, v);
  for (int a = 0; a < 3; a++) ray->org[a] = x[a];
  ray->near = 0;
  if (d2 <= r * r) { /* light from everywhere: directions as the cosine, to the lamp's far side */
    ylm__scene_turn(n ? n : pole, n ? sqrt(1 - u0) : 1 - 2 * u0, u1, ray->dir);
    double along = 0;
    for (int a = 0; a < 3; a++) along += v[a] * (double)ray->dir[a];
    ray->far = (float)(along + sqrt(fmax(0, along * along + r * r - d2)));
    return n ? PI : 4 * PI;
  }
  float axis[3];
  double d = sqrt(d2), cap = cap_of(r, d2);
  for (int a = 0; a < 3; a++) axis[a] = (float)(v[a] / d);
  double z = 1 - u0 * cap, side2 = d2 * fmax(0, 1 - z * z);
  ylm__scene_turn(axis, z, u1, ray->dir);
  ray->far = (float)(d * z - sqrt(fmax(0, r * r - side2)));
  return (n ? fmax(0, (double)ylm_dot3(ray->dir, n)) : 1) * 2 * PI * cap;
}

double ylm__scene_sphere_density(const ylm_scene *s, size_t i, const float x[3], const float n[3],
                                 const float d[3]) {
  double v[3], r = s->lamp[3][i], d2 = to_centre(s, i, x, v);
  if (d2 <= r * r) return n ? fmax(0, (double)ylm_dot3(d, n)) / PI : 1 / (4 * PI);
  return 1 / (2 * PI * cap_of(r, d2));
}

static double wrap(double x) { return x - floor(x); }

ylm_scene_chooser *ylm_scene_chooser_create(const ylm_scene *s) {
  size_t patches = s->triangles + s->disks;
  ylm_scene_chooser *c = ylm_alloc_zero(1, sizeof *c);
  if (!c) return NULL;
  c->scene = s;
  c->weights = ylm__scene_weights();
  c->spheres = (s->lamps + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK;
  c->near = c->spheres + (patches + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK;
  c->chunks = c->near + (ylm__scene_sky_lights(s) + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK;
  c->weight = ylm_alloc_zero(c->chunks * YLM_LAMP_CHUNK, sizeof *c->weight); /* padding stays 0 */
  c->sum = ylm_alloc(c->chunks, sizeof *c->sum);
  if (c->weight && c->sum) return c;
  ylm_scene_chooser_free(c);
  return NULL;
}

void ylm_scene_chooser_free(ylm_scene_chooser *c) {
  if (!c) return;
  ylm_free(c->weight);
  ylm_free(c->sum);
  ylm_free(c);
}

/* Places on lamps follow Roberts' sequence R2, shifted at random, so that successive rays, most of
   them to one lamp, spread over it. */
size_t ylm_scene_aim(const ylm_scene_chooser *a, const float x[3], const float n[3],
                     int light_samples, ylm_rng *rng, ylm_trace_ray *ray, float (*value)[3]) {
  const ylm_scene *scene = a->scene;
  double total = 0;
  size_t rays = 0, before = a->spheres * YLM_LAMP_CHUNK; /* places of spheres */
  size_t near = a->near * YLM_LAMP_CHUNK;                /* of these and of patches */
  float sky[3];
  a->weights(a->spheres, scene->lamp, scene->lamp_luminance, x, n, a->weight, a->sum);
  ylm__scene_patch_weights(scene, x, n, a->weight + before, a->sum + a->spheres);
  ylm__scene_sky_weights(scene, n, a->weight + near, a->sum + a->near);
  for (size_t b = 0; b < a->chunks; b++) total += a->sum[b];
  if (!(total > 0)) return 0;
  scene_walk w = {0};
  double s0 = ylm_rng_double(rng), s1 = ylm_rng_double(rng);
  for (int k = 0; k < light_samples; k++) {
    double target = (k + ylm_rng_double(rng)) / light_samples * total;
    double u0 = wrap(s0 + k * 0.75487766624669276), u1 = wrap(s1 + k * 0.56984029099805327);
    ylm__scene_walk_to(&w, a, target);
    if (!(a->weight[w.lamp] > 0)) continue; /* padding has none */
    bool flat = w.lamp >= before;
    const float *radiance = scene->lamp_radiance + (flat ? 0 : 3 * w.lamp);
    double e;
    if (w.lamp >= near) {
      e = ylm__scene_sky_sample(scene, w.lamp - near, x, n, u0, u1, &ray[rays], sky);
      radiance = sky;
    } else if (flat)
      e = ylm__scene_patch_sample(scene, w.lamp - before, x, n, u0, u1, &ray[rays], &radiance);
    else
      e = ylm__scene_sphere_sample(scene, w.lamp, x, n, u0, u1, &ray[rays]);
    if (!(e > 0)) continue;
    e *= total / a->weight[w.lamp] / light_samples;
    for (int c = 0; c < 3; c++) value[rays][c] = (float)e * radiance[c];
    rays++;
  }
  return rays;
}
