/* lamps.c - what rays see of lamps; choosers, and walks along the sum of their weights. */
#include <math.h>

#include "scene.h"

void ylm_scene_lamp_radiance(const ylm_scene *s, const ylm_trace_ray *ray, const ylm_trace_hit *h,
                             float radiance[3]) {
  double p[3];
  if (h->element < s->lamps) {
    if (ylm__scene_directed_radiance(s, h->element, ray->dir, radiance)) return;
    memcpy(radiance, s->lamp_radiance + 3 * h->element, 12);
    return;
  }
  for (int a = 0; a < 3; a++) p[a] = (double)ray->org[a] + (double)h->t * (double)ray->dir[a];
  ylm__scene_patch_radiance(s, h->element - s->lamps, p, ray->dir, radiance);
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
  double r = sqrt(fmax(0, 1 - z * z)), c, s;
  ylm_turn(u, &c, &s);
  c *= r, s *= r;
  ylm_scene_basis(axis, a, b);
  for (int k = 0; k < 3; k++) out[k] = (float)(c * a[k] + s * b[k] + z * axis[k]);
}

ylm_scene_chooser *ylm_scene_chooser_create(const ylm_scene *s) {
  ylm_scene_chooser *c = ylm_alloc_zero(1, sizeof *c);
  size_t lamps = 0;
  if (!c) return NULL;
  c->scene = s;
  c->weights = ylm__scene_weights();
  c->nodes = ylm__scene_nodes();
  c->aim_at_spheres = ylm__scene_spheres();
  for (int k = 0; k < SCENE_STORAGES; k++) {
    size_t count = ylm__scene_storage[k]->count(s);
    c->chunk[k] = c->chunks;
    c->first[k] = lamps;
    lamps += count;
    if (!s->tree || !ylm__scene_is_planted(k))
      c->chunks += (count + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK;
  }
  c->chunk[SCENE_STORAGES] = c->chunks;
  c->weight = ylm_alloc_zero(c->chunks * YLM_LAMP_CHUNK, sizeof *c->weight); /* padding stays 0 */
  c->sum = ylm_alloc(c->chunks, sizeof *c->sum);
  c->cut = s->tree ? ylm_alloc(1, sizeof *c->cut) : NULL;
  c->solid = s->tree ? NULL : ylm_alloc_zero(s->triangles + s->disks, sizeof *c->solid);
  if (c->weight && c->sum && (s->tree ? c->cut != NULL : c->solid != NULL) &&
      ylm__scene_ahead_create(c))
    return c;
  ylm_scene_chooser_free(c);
  return NULL;
}

void ylm_scene_chooser_free(ylm_scene_chooser *c) {
  if (!c) return;
  ylm_free(c->weight);
  ylm_free(c->sum);
  ylm_free(c->cut);
  ylm_free(c->solid);
  ylm_free(c->ahead);
  ylm_free(c);
}

void ylm__scene_turn_to(ylm_scene_chooser *c, const float x[3], const float *normal) {
  c->in_space = !normal;
  memcpy(c->x, x, 12);
  if (normal) memcpy(c->normal, normal, 12);
}

double ylm__scene_weigh(ylm_scene_chooser *c, bool one, int light_samples) {
  const ylm_scene *s = c->scene;
  c->total = 0;
  if (s->tree) {
    ylm__scene_look(c, light_samples);
    c->total = ylm__scene_tree_weight(c);
  }
  for (int k = 0; k < SCENE_STORAGES; k++)
    if (c->chunk[k] < c->chunk[k + 1])
      ylm__scene_storage[k]->weigh(c, one, c->weight + c->chunk[k] * YLM_LAMP_CHUNK,
                                   c->sum + c->chunk[k]);
  for (size_t b = 0; b < c->chunks; b++) c->total += (double)c->sum[b];
  return c->total;
}
