/* bias.c - where shading points look a grid up whose light jumps at surfaces. */
#include <math.h>

#include "../calibration.h"
#include "../view.h"

void ylm_shade_view_flats(const ylm_shade_view *v, size_t first, size_t n, float (*out)[3]) {
  ylm_scene_surface surface[SHADE_BIAS_POINTS];
  ylm_scene_place place[SHADE_BIAS_POINTS];
  if (v->corner) {
    memcpy(out, v->normal + first, n * sizeof *out);
    return;
  }
  for (size_t i = 0; i < n; i += SHADE_BIAS_POINTS) {
    size_t some = n - i < SHADE_BIAS_POINTS ? n - i : SHADE_BIAS_POINTS;
    for (size_t k = 0; k < some; k++) place[k] = v->entry[first + i + k].at;
    ylm_scene_surfaces(v->scene, some, place, surface);
    for (size_t k = 0; k < some; k++) memcpy(out[i + k], surface[k].flat, sizeof *out);
  }
}

ylm_status ylm_shade_limits(const ylm_shade_view *v, size_t first, size_t n, const float (*flat)[3],
                            float most, float *limit) {
  ylm_trace_ray *ray = ylm_alloc(n, sizeof *ray);
  ylm_trace_hit *hit = ylm_alloc(n, sizeof *hit);
  ylm_status s = ray && hit ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    ray[i].near = 0;
    ray[i].far = 2 * most;
    memcpy(ray[i].org, v->origin[first + i], sizeof ray[i].org);
    memcpy(ray[i].dir, flat[i], sizeof ray[i].dir);
  }
  if (s == YLM_OK) ylm_trace_nearest(ylm_scene_trace(v->scene), n, ray, false, hit);
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    limit[i] = hit[i].mesh == YLM_TRACE_NOTHING ? INFINITY : 0.5f * hit[i].t;
  ylm_free(ray);
  ylm_free(hit);
  return s;
}

double ylm_shade_reach(const void *scene, const float x[3], const float direction[3], double far) {
  ylm_trace_ray ray = {.near = 0, .far = (float)far};
  ylm_trace_hit hit;
  memcpy(ray.org, x, sizeof ray.org);
  memcpy(ray.dir, direction, sizeof ray.dir);
  ylm_trace_nearest(ylm_scene_trace(scene), 1, &ray, false, &hit);
  return hit.mesh == YLM_TRACE_NOTHING ? far : (double)hit.t;
}

ylm_status ylm_shade_bias(const ylm_shade_view *v, const ylm_grid *grid, double factor,
                          size_t first, size_t n, const float (*flat)[3], float (*places)[3]) {
  const float(*x)[3] = (const float(*)[3])v->position + first;
  ylm_grid_reach reach = {ylm_shade_reach, v->scene, v->world};
  float *limit = ylm_alloc(n, sizeof *limit);
  ylm_status s = limit ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && factor > 0) s = ylm_shade_limits(v, first, n, flat, INFINITY, limit);
  if (s == YLM_OK) ylm_grid_bias(grid, factor, v->world, n, x, flat, limit, &reach, places, 1);
  ylm_free(limit);
  return s;
}
