/* sight.c - whether the surfaces at two places are one: near each other's plane, and in sight of each other. */
#include <math.h>

#include "surface.h"

typedef struct pairs {
  const surface_bake *b;
  const uint32_t (*pair)[2];
  bool *joined;
} pairs;

/* A ray from a to b. */
static ylm_trace_ray between(const float a[3], const float b[3]) {
  return (ylm_trace_ray){
      .org = {a[0], a[1], a[2]}, .far = 1, .dir = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}};
}

/* The rays that join two places, 3 at most; how many: -1: they do not join; 0: they are one. */
static int aim(const surface_bake *b, const surface_site *p, const surface_site *q,
               ylm_trace_ray ray[3]) {
  double unit = b->charts.unit, bit = JOIN_BIT * unit, off = SIGHT_OFF * unit, d[3],
         way[2] = {0, 0};
  for (int a = 0; a < 3; a++) {
    d[a] = (double)q->position[a] - (double)p->position[a];
    way[0] += d[a] * (double)p->normal[a];
    way[1] += d[a] * (double)q->normal[a];
  }
  double length = sqrt(ylm_dot3d(d, d)), most = JOIN_SLOPE * length + bit;
  float along = ylm_dot3(p->normal, q->normal);
  if (fabs(way[0]) > most || fabs(way[1]) > most || along < 0.1f) return -1;
  if (length < 1e-3 * bit) return 0;
  bool plane = along > 0.9999f && fabs(way[0]) < bit;
  float at[4][3], up = (float)(SIGHT_UP * length), low = (float)off;
  if (plane) { /* no higher than rays start: a wall that leans hides more above the surface than on it */
    ylm_scene_ray_origin(b->scene, p->position, p->normal, at[1]);
    ylm_scene_ray_origin(b->scene, q->position, q->normal, at[2]);
    ray[0] = between(at[1], at[2]);
    return 1;
  }
  for (int a = 0; a < 3; a++) {
    at[0][a] = p->position[a] + low * p->normal[a];
    at[1][a] = p->position[a] + up * p->normal[a];
    at[2][a] = q->position[a] + up * q->normal[a];
    at[3][a] = q->position[a] + low * q->normal[a];
  }
  ray[0] = between(at[1], at[2]);
  ray[1] = between(at[0], at[1]);
  ray[2] = between(at[3], at[2]);
  return 3;
}

static ylm_status look(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const pairs *j = context;
  for (size_t i = begin; i < end; i++) {
    ylm_trace_ray ray[3];
    int n = aim(j->b, &j->b->site[j->pair[i][0]], &j->b->site[j->pair[i][1]], ray);
    j->joined[i] = n >= 0;
    if (n <= 0) continue;
    ylm_trace_occluded(ylm_scene_trace(j->b->scene), (size_t)n, ray);
    for (int k = 0; k < n; k++) j->joined[i] &= !(ray[k].far < 0);
  }
  return YLM_OK;
}

ylm_status ylm__surface_join(surface_bake *b, size_t n, const uint32_t (*pair)[2], bool *joined) {
  pairs j = {b, pair, joined};
  b->stats.rays += n;
  return ylm_parallel(n, SURFACE_GRAIN, b->form->light.threads, look, &j, NULL, NULL);
}
