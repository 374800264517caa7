/* lamps.c - what lamps emit, and rays from a point to the lamps, chosen by what they may bring. */
#include <math.h>

#include "scene.h"

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
  double r = sqrt(fmax(0, 1 - z * z)), c = r * cos(2 * YLM_PI * u), s = r * sin(2 * YLM_PI * u);
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

double ylm__scene_sphere_density(const ylm_scene *s, size_t i, const float x[3], const float n[3],
                                 const float d[3]) {
  double v[3], r = s->lamp[3][i], d2 = to_centre(s, i, x, v);
  if (d2 <= r * r) return n ? fmax(0, (double)ylm_dot3(d, n)) / YLM_PI : 1 / (4 * YLM_PI);
  return 1 / (2 * YLM_PI * cap_of(r, d2));
}

ylm_scene_chooser *ylm_scene_chooser_create(const ylm_scene *s) {
  size_t patches = s->triangles + s->disks;
  ylm_scene_chooser *c = ylm_alloc_zero(1, sizeof *c);
  if (!c) return NULL;
  c->scene = s;
  c->weights = ylm__scene_weights();
  c->nodes = ylm__scene_nodes();
  c->aim_at_spheres = ylm__scene_spheres();
  c->spheres = s->tree ? 0 : (s->lamps + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK;
  c->near = c->spheres + (s->tree ? 0 : (patches + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK);
  c->sky = c->near + (ylm__scene_sky_lights(s) + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK;
  c->chunks = c->sky + (s->spots + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK;
  c->weight = ylm_alloc_zero(c->chunks * YLM_LAMP_CHUNK, sizeof *c->weight); /* padding stays 0 */
  c->sum = ylm_alloc(c->chunks, sizeof *c->sum);
  c->cut = s->tree ? ylm_alloc(1, sizeof *c->cut) : NULL;
  c->solid = s->tree ? NULL : ylm_alloc_zero(patches, sizeof *c->solid);
  if (c->weight && c->sum && (s->tree ? c->cut != NULL : c->solid != NULL)) return c;
  ylm_scene_chooser_free(c);
  return NULL;
}

void ylm_scene_chooser_free(ylm_scene_chooser *c) {
  if (!c) return;
  ylm_free(c->weight);
  ylm_free(c->sum);
  ylm_free(c->cut);
  ylm_free(c->solid);
  ylm_free(c);
}

void ylm__scene_turn_to(ylm_scene_chooser *c, const float x[3], const float *normal) {
  c->in_space = !normal;
  memcpy(c->x, x, 12);
  if (normal) memcpy(c->normal, normal, 12);
}

double ylm__scene_add_weights(ylm_scene_chooser *c, int light_samples) {
  const ylm_scene *s = c->scene;
  c->total = 0;
  if (s->tree) {
    ylm__scene_look(c, light_samples);
    c->total = ylm__scene_tree_weight(c);
  }
  ylm__scene_sky_weights(s, c->in_space ? NULL : c->normal, c->weight + c->near * YLM_LAMP_CHUNK,
                         c->sum + c->near);
  ylm__scene_spot_weights(s, c->x, c->in_space ? NULL : c->normal,
                          c->weight + c->sky * YLM_LAMP_CHUNK, c->sum + c->sky);
  for (size_t b = 0; b < c->chunks; b++) c->total += (double)c->sum[b];
  return c->total;
}
