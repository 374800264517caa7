/* choose.c - one lamp for one ray, and how likely it was: what estimates by several kinds of rays
   weigh them by (Veach & Guibas 1995). */
#include <math.h>

#include "calibration.h"
#include "scene.h"

size_t ylm_scene_near(const ylm_scene *s) { return s->lamps + s->triangles + s->disks; }

bool ylm_scene_near_radiance(const ylm_scene *s, const ylm_trace_ray *ray, uint32_t lamp, float t,
                             float radiance[3]) {
  ylm_trace_hit hit = {.mesh = YLM_TRACE_LAMP, .element = lamp, .t = t};
  if (lamp >= s->lamps && s->horizon && ylm_dot3(s->horizon + 3 * (lamp - s->lamps), ray->dir) < 0)
    return false;
  memcpy(radiance, ylm_scene_lamp_radiance(s, ray, &hit), 12);
  return true;
}

/* As far as ylm__scene_patch_sample lets rays come to a flat lamp. */
float ylm_scene_reach(const ylm_scene *s, uint32_t lamp, const ylm_trace_ray *ray, float t) {
  float at[3];
  if (lamp < s->lamps) return t;
  for (int a = 0; a < 3; a++) at[a] = ray->org[a] + t * ray->dir[a];
  return (t + ylm_trace_offset(s->trace, at)) * (1 / (1 - 1e-5f));
}

/* ylm_scene_weights_fn for few lamps, and for points in space. */
static void weigh_spheres(const ylm_scene_chooser *c, const float *normal) {
  const ylm_scene *s = c->scene;
  for (size_t i = 0; i < s->lamps; i++) {
    double v[3];
    if (i % YLM_LAMP_CHUNK == 0) c->sum[i / YLM_LAMP_CHUNK] = 0;
    for (int a = 0; a < 3; a++) v[a] = (double)s->lamp[a][i] - (double)c->x[a];
    c->weight[i] =
        (float)ylm__scene_weight(v, (double)s->lamp[3][i], normal) * s->lamp_luminance[i];
    c->sum[i / YLM_LAMP_CHUNK] += c->weight[i];
  }
}

/* The chance of the tree of lamps: the rest are distant lights. */
static double tree_part(const ylm_scene_chooser *c) {
  return c->scene->tree ? ylm__scene_tree_weight(c) / c->total : 0;
}

bool ylm_scene_choose(ylm_scene_chooser *c, const float x[3], const float *normal) {
  const ylm_scene *s = c->scene;
  ylm__scene_turn_to(c, x, normal);
  if (!s->tree) {
    if (normal && s->lamps > CHOOSE_FEW)
      c->weights(c->spheres, s->lamp, s->lamp_luminance, x, normal, c->weight, c->sum);
    else
      weigh_spheres(c, normal);
    ylm__scene_patch_weights_of_one(s, x, normal, c->weight + c->spheres * YLM_LAMP_CHUNK,
                                    c->sum + c->spheres, c->solid);
  }
  return ylm__scene_add_weights(c, 1) > 0;
}

/* The place of a lamp in the chooser's weights. */
static size_t place_of(const ylm_scene_chooser *c, uint32_t lamp) {
  size_t near = ylm_scene_near(c->scene), spots = near + c->scene->sky_lights;
  if (lamp >= spots) return c->sky * YLM_LAMP_CHUNK + (lamp - spots);
  if (lamp >= near) return c->near * YLM_LAMP_CHUNK + (lamp - near);
  return lamp < c->scene->lamps ? lamp : c->spheres * YLM_LAMP_CHUNK + (lamp - c->scene->lamps);
}

uint32_t ylm__scene_lamp_at(const ylm_scene_chooser *c, size_t place) {
  const ylm_scene *s = c->scene;
  size_t near = c->near * YLM_LAMP_CHUNK, flat = c->spheres * YLM_LAMP_CHUNK;
  size_t spots = c->sky * YLM_LAMP_CHUNK;
  if (place >= spots) return (uint32_t)(ylm_scene_near(s) + s->sky_lights + place - spots);
  return (uint32_t)(place >= near   ? ylm_scene_near(s) + place - near
                    : place >= flat ? s->lamps + place - flat
                                    : place);
}

double ylm_scene_share(const ylm_scene_chooser *c, uint32_t lamp) {
  if (!(c->total > 0)) return 0;
  if (c->scene->tree && lamp < ylm_scene_near(c->scene)) {
    double part = tree_part(c);
    return part > 0 ? part * ylm__scene_drawn_share(c, lamp) : 0;
  }
  return (double)c->weight[place_of(c, lamp)] / c->total;
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
  const ylm_scene *s = c->scene;
  const float *n = c->in_space ? NULL : c->normal;
  size_t near = ylm_scene_near(s);
  double share = ylm_scene_share(c, lamp);
  if (!(share > 0) || lamp >= near + s->sky_lights) return 0; /* no direction meets a spot */
  if (lamp >= near) return share * ylm__scene_sky_density(s, lamp - near, n, d);
  if (lamp >= s->lamps)
    return share * ylm__scene_patch_density(s, lamp - s->lamps, c->x,
                                            ylm__scene_solid(c, lamp - s->lamps), d);
  return share * ylm__scene_sphere_density(s, lamp, c->x, n, d);
}

double ylm_scene_sample(const ylm_scene_chooser *c, const double u[3], ylm_trace_ray *ray,
                        float radiance[3], uint32_t *lamp) {
  const ylm_scene *s = c->scene;
  const float *n = c->in_space ? NULL : c->normal, *emitted;
  size_t near = ylm_scene_near(s);
  double e, share = choose(c, u[0], lamp);
  if (!(share > 0)) return 0;
  if (*lamp >= near + s->sky_lights)
    e = ylm__scene_spot_sample(s, *lamp - near - s->sky_lights, c->x, n, ray, radiance);
  else if (*lamp >= near)
    e = ylm__scene_sky_sample(s, *lamp - near, c->x, n, u[1], u[2], ray, radiance);
  else if (*lamp >= s->lamps) {
    size_t i = *lamp - s->lamps;
    e = ylm__scene_patch_sample_one(s, i, c->x, n, u[1], u[2], ylm__scene_solid(c, i), ray,
                                    &emitted);
    if (e > 0) memcpy(radiance, emitted, 12);
  } else {
    e = ylm__scene_sphere_sample(s, *lamp, c->x, n, u[1], u[2], ray);
    memcpy(radiance, s->lamp_radiance + 3 * *lamp, 12);
  }
  if (!(e > 0)) return 0;
  return share * (n ? fmax(0, (double)ylm_dot3(ray->dir, n)) : 1) / e;
}
