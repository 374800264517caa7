/*
** point.c - lamps that have a place and no size: rays are aimed there, and no other ray finds them.
**
** Their kind says what they send to a point (ylm_light_emitter.h).
*/
#include <math.h>

#include "scene.h"

ylm_status ylm__scene_copy_points(ylm_scene *s, const ylm_scene_lamps *l) {
  ylm_light_emitter one;
  const double way[3] = {-s->origin[0], -s->origin[1], -s->origin[2]};
  size_t n = 0;
  while (l->sky && ylm_light_set_emitter(l->sky, n, &one)) n++;
  s->point = ylm_alloc(n, sizeof *s->point);
  if (!s->point) return YLM_ENOMEM;
  for (; s->points < n; s->points++) {
    ylm_light_set_emitter(l->sky, s->points, &s->point[s->points]);
    ylm_light_emitter_keep(&s->point[s->points]);
    ylm_light_emitter_move(&s->point[s->points], way);
  }
  return YLM_OK;
}

void ylm__scene_free_points(ylm_scene *s) {
  for (size_t i = 0; i < s->points; i++) ylm_light_emitter_drop(&s->point[i]);
  ylm_free(s->point);
}

size_t ylm_scene_points(const ylm_scene *s, const ylm_light_emitter **point) {
  if (point) *point = s->point;
  return s->points;
}

static void weigh(const ylm_scene_chooser *c, bool one, float *weight, float *sum) {
  const double x[3] = {(double)c->x[0], (double)c->x[1], (double)c->x[2]};
  const float *n = c->in_space ? NULL : c->normal;
  (void)one;
  for (size_t i = 0; i < c->scene->points; i++) {
    if (i % YLM_LAMP_CHUNK == 0) sum[i / YLM_LAMP_CHUNK] = 0;
    weight[i] = (float)ylm_light_emitter_weight(&c->scene->point[i], x, n);
    sum[i / YLM_LAMP_CHUNK] += weight[i];
  }
}

static double sample(const ylm_scene *s, size_t i, const scene_aim *a, ylm_trace_ray *ray,
                     float radiance[3]) {
  const double x[3] = {(double)a->x[0], (double)a->x[1], (double)a->x[2]};
  const float *n = a->normal;
  ylm_light_way way;
  float at[3];
  if (!ylm_light_emitter_toward(&s->point[i], x, &way)) return 0;
  for (int k = 0; k < 3; k++) {
    at[k] = (float)way.at[k];
    ray->org[k] = a->x[k];
    ray->dir[k] = (float)way.to[k];
    radiance[k] = (float)way.radiance[k];
  }
  ray->near = 0; /* it may be on a wall: the ray ends just before it */
  ray->far = fmaxf(0, (float)(way.distance * (1 - 1e-5)) - ylm_trace_offset(s->trace, at));
  double facing =
      n ? fmax(0, way.to[0] * (double)n[0] + way.to[1] * (double)n[1] + way.to[2] * (double)n[2])
        : 1;
  return way.solid * facing;
}

/* No direction meets one. */
static double density(const ylm_scene_chooser *c, size_t i, const float d[3]) {
  (void)c, (void)i, (void)d;
  return 0;
}

static bool emitter(const ylm_scene *s, size_t i, ylm_light_emitter *out) {
  *out = s->point[i];
  return true;
}

static size_t count(const ylm_scene *s) { return s->points; }

const scene_storage ylm__scene_point_storage = {count, weigh, sample, density, emitter};
