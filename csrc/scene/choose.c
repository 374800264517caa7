/* choose.c - one lamp for one ray, and how likely it was: what estimates by several kinds of rays
   weigh them by (Veach & Guibas 1995). */
#include <math.h>

#include "calibration.h"
#include "scene.h"

bool ylm_scene_near_radiance(const ylm_scene *s, const ylm_trace_ray *ray, uint32_t lamp, float t,
                             float radiance[3]) {
  ylm_trace_hit hit = {.mesh = YLM_TRACE_LAMP, .element = lamp, .t = t};
  if (lamp >= s->lamps && s->horizon && ylm_dot3(s->horizon + 3 * (lamp - s->lamps), ray->dir) < 0)
    return false;
  ylm_scene_lamp_radiance(s, ray, &hit, radiance);
  return true;
}

/* As far as ylm__scene_patch_sample lets rays come to a flat lamp. */
float ylm_scene_reach(const ylm_scene *s, uint32_t lamp, const ylm_trace_ray *ray, float t) {
  float at[3];
  if (lamp < s->lamps) return t;
  for (int a = 0; a < 3; a++) at[a] = ray->org[a] + t * ray->dir[a];
  return (t + ylm_trace_offset(s->trace, at)) * (1 / (1 - 1e-5f));
}

/* The chance of the tree of lamps: the rest are distant lights. */
static double tree_part(const ylm_scene_chooser *c) {
  return c->scene->tree ? ylm__scene_tree_weight(c) / c->total : 0;
}

bool ylm_scene_choose(ylm_scene_chooser *c, const float x[3], const float *normal) {
  ylm__scene_turn_to(c, x, normal);
  if (!(ylm__scene_weigh(c, true, 1) > 0)) return false;
  if (c->guide && normal) ylm__scene_guide_weights(c);
  return c->total > 0;
}

double ylm_scene_share(const ylm_scene_chooser *c, uint32_t lamp) {
  if (!(c->total > 0)) return 0;
  if (c->scene->tree && lamp < ylm_scene_near(c->scene)) {
    double part = tree_part(c);
    return part > 0 ? part * ylm__scene_drawn_share(c, lamp) : 0;
  }
  return (double)c->weight[ylm__scene_place_of(c, lamp)] / c->total;
}

/* The lamp that u chooses; returns how often it is: 0 where rounding led to none. */
static double choose(const ylm_scene_chooser *c, double u, uint32_t *lamp) {
  scene_walk w = {0};
  double target = u * c->total, tree = c->scene->tree ? ylm__scene_tree_weight(c) : 0;
  if (tree > 0 && (target < tree || c->chunks == 0)) {
    scene_drawn d = {.at = {fmin(target / tree, SCENE_BELOW_ONE)}};
    ylm__scene_draw(c, 1, &d);
    if (d.share[0] > 0) *lamp = d.lamp[0];
    return tree_part(c) * d.share[0];
  }
  ylm__scene_walk_to(&w, c, target - tree);
  *lamp = ylm__scene_lamp_at(c, w.lamp);
  return (double)c->weight[w.lamp] / c->total;
}

double ylm_scene_density(const ylm_scene_chooser *c, uint32_t lamp, const float d[3]) {
  double share = ylm_scene_share(c, lamp);
  size_t i = lamp;
  if (!(share > 0)) return 0;
  int k = ylm__scene_storage_in(c, &i);
  return share * ylm__scene_storage[k]->density(c, i, d);
}

double ylm_scene_sample(const ylm_scene_chooser *c, const double u[3], ylm_trace_ray *ray,
                        float radiance[3], uint32_t *lamp) {
  scene_aim a = {
      .x = c->x, .normal = c->in_space ? NULL : c->normal, .u = {u[1], u[2]}, .one = true};
  double share = choose(c, u[0], lamp);
  if (!(share > 0)) return 0;
  size_t i = *lamp;
  int k = ylm__scene_storage_in(c, &i);
  a.solid = ylm__scene_solid(c, k, i);
  double e = ylm__scene_storage[k]->sample(c->scene, i, &a, ray, radiance);
  if (!(e > 0)) return 0;
  return share * (a.normal ? fmax(0, (double)ylm_dot3(ray->dir, a.normal)) : 1) / e;
}
