/* choose.c - one lamp for one ray, and how likely it was: what estimates by several kinds of rays
   weigh them by (Veach & Guibas 1995). */
#include <math.h>

#include "scene.h"

#define PI 3.14159265358979323846
/* The part of rays that are aimed at distant lights where others are chosen by power. */
#define SKY_PART 0.5
/* Lamps that are weighed faster one by one. */
#define FEW 16

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
float ylm_scene_reach(const ylm_scene *s, uint32_t lamp, float t) {
  return lamp < s->lamps ? t : (t + ylm_trace_offset(s->trace)) * (1 / (1 - 1e-5f));
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

bool ylm_scene_choose(ylm_scene_chooser *c, const float x[3], const float *normal) {
  const ylm_scene *s = c->scene;
  c->in_space = !normal;
  memcpy(c->x, x, 12);
  if (normal) memcpy(c->normal, normal, 12);
  c->total = 0;
  if (!s->power) {
    if (normal && s->lamps > FEW)
      c->weights(c->spheres, s->lamp, s->lamp_luminance, x, normal, c->weight, c->sum);
    else
      weigh_spheres(c, normal);
    ylm__scene_patch_weights_of_one(s, x, normal, c->weight + c->spheres * YLM_LAMP_CHUNK,
                                    c->sum + c->spheres);
  }
  ylm__scene_sky_weights(s, normal, c->weight + c->near * YLM_LAMP_CHUNK, c->sum + c->near);
  for (size_t b = s->power ? c->near : 0; b < c->chunks; b++) c->total += (double)c->sum[b];
  return s->power || c->total > 0;
}

/* Of all rays, those that go to distant lights where the others are chosen by power. */
static double sky_part(const ylm_scene_chooser *c) { return c->total > 0 ? SKY_PART : 0; }

/* The place of a lamp in the chooser's weights. */
static size_t place_of(const ylm_scene_chooser *c, uint32_t lamp) {
  size_t near = ylm_scene_near(c->scene);
  if (lamp >= near) return c->near * YLM_LAMP_CHUNK + (lamp - near);
  return lamp < c->scene->lamps ? lamp : c->spheres * YLM_LAMP_CHUNK + (lamp - c->scene->lamps);
}

/* The lamp at a place; the reverse of it. */
static uint32_t lamp_at(const ylm_scene_chooser *c, size_t place) {
  const ylm_scene *s = c->scene;
  size_t near = c->near * YLM_LAMP_CHUNK, flat = c->spheres * YLM_LAMP_CHUNK;
  return (uint32_t)(place >= near   ? ylm_scene_near(s) + place - near
                    : place >= flat ? s->lamps + place - flat
                                    : place);
}

/* How often a lamp is chosen. */
static double share_of(const ylm_scene_chooser *c, uint32_t lamp) {
  const ylm_scene *s = c->scene;
  bool distant = lamp >= ylm_scene_near(s);
  if (s->power && !distant) return (1 - sky_part(c)) * s->power->share[lamp];
  if (!(c->total > 0)) return 0;
  return (s->power ? SKY_PART : 1) * (double)c->weight[place_of(c, lamp)] / c->total;
}

/* The lamp that u chooses; false: rounding led to none. */
static bool choose(const ylm_scene_chooser *c, double u, uint32_t *lamp) {
  scene_walk w = {0};
  if (c->scene->power) {
    double sky = sky_part(c);
    if (u >= sky) {
      double v = (u - sky) / (1 - sky);
      *lamp = (uint32_t)ylm__scene_by_power(c->scene->power, ylm_scene_near(c->scene), v);
      return true;
    }
    u /= sky;
    w.chunk = c->near;
    w.lamp = c->near * YLM_LAMP_CHUNK;
  }
  ylm__scene_walk_to(&w, c, u * c->total);
  *lamp = lamp_at(c, w.lamp);
  return c->weight[w.lamp] > 0;
}

double ylm_scene_density(const ylm_scene_chooser *c, uint32_t lamp, const float d[3]) {
  const ylm_scene *s = c->scene;
  const float *n = c->in_space ? NULL : c->normal;
  size_t near = ylm_scene_near(s);
  double share = share_of(c, lamp);
  if (!(share > 0)) return 0;
  if (lamp >= near) return share * ylm__scene_sky_density(s, lamp - near, n, d);
  if (lamp >= s->lamps) return share * ylm__scene_patch_density(s, lamp - s->lamps, c->x, d);
  return share * ylm__scene_sphere_density(s, lamp, c->x, n, d);
}

double ylm_scene_sample(const ylm_scene_chooser *c, const double u[3], ylm_trace_ray *ray,
                        float radiance[3], uint32_t *lamp) {
  const ylm_scene *s = c->scene;
  const float *n = c->in_space ? NULL : c->normal, *emitted;
  size_t near = ylm_scene_near(s);
  double e;
  if (!choose(c, u[0], lamp)) return 0;
  if (*lamp >= near)
    e = ylm__scene_sky_sample(s, *lamp - near, c->x, n, u[1], u[2], ray, radiance);
  else if (*lamp >= s->lamps) {
    e = ylm__scene_patch_sample_one(s, *lamp - s->lamps, c->x, n, u[1], u[2], ray, &emitted);
    if (e > 0) memcpy(radiance, emitted, 12);
  } else {
    e = ylm__scene_sphere_sample(s, *lamp, c->x, n, u[1], u[2], ray);
    memcpy(radiance, s->lamp_radiance + 3 * *lamp, 12);
  }
  if (!(e > 0)) return 0;
  return share_of(c, *lamp) * (n ? fmax(0, (double)ylm_dot3(ray->dir, n)) : 1) / e;
}
