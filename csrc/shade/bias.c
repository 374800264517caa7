/* bias.c - radiance of shading points under a grid whose light jumps at surfaces: it is looked up
   beside them, and its irradiance is reflected as it is: shadows are in the grid. */
#include <math.h>
#include <stdatomic.h>

#include "view.h"
#include "ylm_sh.h"

#define BLOCK 512   /* points whose coefficients stay in the second-level cache */
#define SURFACES 64 /* places asked for at once */

void ylm_shade_view_flats(const ylm_shade_view *v, size_t first, size_t n, float (*out)[3]) {
  ylm_scene_surface surface[SURFACES];
  ylm_scene_place place[SURFACES];
  if (v->corner) {
    memcpy(out, v->normal + first, n * sizeof *out);
    return;
  }
  for (size_t i = 0; i < n; i += SURFACES) {
    size_t some = n - i < SURFACES ? n - i : SURFACES;
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

ylm_status ylm_shade_bias(const ylm_shade_view *v, const ylm_grid *grid, double factor,
                          size_t first, size_t n, const float (*flat)[3], float *b) {
  float most = 0;
  float *limit = ylm_alloc(n, sizeof *limit);
  if (!limit) return YLM_ENOMEM;
  ylm_grid_bias(grid, factor, n, (const float(*)[3])v->position + first, flat, NULL, b, 1);
  for (size_t i = 0; i < n; i++) most = fmaxf(most, b[i]);
  ylm_status s = factor > 0 ? ylm_shade_limits(v, first, n, flat, most, limit) : YLM_OK;
  for (size_t i = 0; s == YLM_OK && factor > 0 && i < n; i++) b[i] = fminf(b[i], limit[i]);
  ylm_free(limit);
  return s;
}
