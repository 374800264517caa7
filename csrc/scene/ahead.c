/* ahead.c - choosers that are told of many places before they choose at each: few lamps are then weighed in vectors. */
#include <math.h>

#include "scene.h"
#include "ylm_sets.h"

static YLM_KERNEL_CHOICE(ylm_scene_ahead_fn, kernel, ylm_k_scene_ahead, NULL);

bool ylm__scene_ahead_create(ylm_scene_chooser *c) {
  const ylm_scene *s = c->scene;
  size_t lamps = s->lamps + s->triangles;
  if (s->tree || lamps == 0 || lamps > CHOOSE_FEW || lamps != ylm_scene_lamps_all(s) ||
      s->directions > 0 || !(c->weigh_ahead = kernel()))
    return true;
  c->ahead = ylm_alloc_zero(1, sizeof *c->ahead);
  return c->ahead != NULL;
}

void ylm_scene_look_ahead(ylm_scene_chooser *c, size_t n, const float (*x)[3],
                          const float (*normal)[3]) {
  if (c->guide) ylm__scene_guide_ahead(c, n, x, normal);
  if (!c->ahead || n == 0) return;
  for (size_t i = 0; i < YLM_SCENE_AHEAD; i++)
    for (int a = 0; a < 3; a++) {
      c->ahead->x[a][i] = x[i < n ? i : 0][a];
      c->ahead->normal[a][i] = normal[i < n ? i : 0][a];
    }
  c->weigh_ahead(c->scene, n, c->ahead);
}

/* As ylm__scene_weigh for one lamp. */
static double weigh(ylm_scene_chooser *c, size_t k) {
  const ylm_scene *s = c->scene;
  const scene_ahead *a = c->ahead;
  float *weight = c->weight, *sum = c->sum;
  float total = 0;
  for (size_t i = 0; i < s->lamps; i++)
    total += weight[i] = (float)a->weight[i][k] * s->lamp_luminance[i];
  c->total = 0;
  if (s->lamps > 0) c->total += (double)(*sum++ = total), weight += YLM_LAMP_CHUNK;
  total = 0;
  for (size_t i = 0; i < s->triangles; i++) {
    double w = a->weight[s->lamps + i][k], solid = 0;
    if (a->near[i][k] > 0) {
      solid = fabs(2 * atan2(a->arc[0][i][k], a->arc[1][i][k]));
      w = w > 0 ? solid / YLM_PI * w : 0;
    }
    c->solid[i] = solid;
    total += weight[i] = (float)(w * (double)s->patch_luminance[i]);
  }
  if (s->triangles > 0) c->total += (double)(*sum = total);
  return c->total;
}

bool ylm_scene_choose_ahead(ylm_scene_chooser *c, size_t k, const float x[3],
                            const float normal[3]) {
  ylm__scene_turn_to(c, x, normal);
  if (!((c->ahead ? weigh(c, k) : ylm__scene_weigh(c, true, 1)) > 0)) return false;
  if (c->guide) ylm__scene_guide_weights_ahead(c, k);
  return c->total > 0;
}
