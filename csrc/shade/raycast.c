/* raycast.c - light from the lamps themselves, by sampling their solid angles. */
#include <math.h>
#include <stdatomic.h>

#include "view.h"

#define GRAIN 32

typedef struct job {
  const ylm_shade_view *view;
  int light_samples;
  bool shadows;
  uint64_t seed;
  float *out;
  atomic_uint_fast64_t rays;
} job;

typedef struct scratch {
  ylm_scene_chooser *lamps;
  ylm_trace_ray *ray; /* [light_samples] */
  float (*value)[3];  /* [light_samples]: irradiance that the ray brings if nothing is hit */
} scratch;

/* Irradiance of one point; returns the number of rays that were traced. */
static size_t gather(const job *j, size_t i, const scratch *s, double E[3]) {
  ylm_rng rng;
  ylm_rng_seed(&rng, j->seed, i);
  E[0] = E[1] = E[2] = 0;
  size_t rays = ylm_scene_aim(s->lamps, j->view->origin[i], j->view->normal[i], j->light_samples,
                              &rng, s->ray, s->value);
  if (j->shadows) ylm_trace_occluded(ylm_scene_trace(j->view->scene), rays, s->ray);
  for (size_t k = 0; k < rays; k++)
    if (!j->shadows || !(s->ray[k].far < 0))
      for (int c = 0; c < 3; c++) E[c] += s->value[k][c];
  return j->shadows ? rays : 0;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  size_t light_samples = (size_t)j->light_samples, rays = 0;
  scratch s = {.lamps = ylm_scene_chooser_create(j->view->scene),
               .ray = ylm_alloc(light_samples, sizeof(ylm_trace_ray)),
               .value = ylm_alloc(light_samples, 12)};
  ylm_status status = s.lamps && s.ray && s.value ? YLM_OK : YLM_ENOMEM;
  for (size_t i = begin; status == YLM_OK && i < end; i++) {
    double E[3];
    rays += gather(j, i, &s, E);
    ylm_material_reflect(ylm__shade_material(j->view, i), E, j->out + 3 * i);
    ylm__shade_tint(j->view, i, 1, j->out + 3 * i);
  }
  ylm_scene_chooser_free(s.lamps);
  ylm_free(s.ray);
  ylm_free(s.value);
  atomic_fetch_add_explicit(&j->rays, rays, memory_order_relaxed);
  return status;
}

ylm_status ylm_shade_raycast(const ylm_shade_view *v, int light_samples, bool shadows,
                             uint64_t seed, int threads, const ylm_progress *progress, float *out,
                             uint64_t *rays) {
  if (light_samples < 1 || light_samples > 65536) return YLM_ERANGE;
  job j = {.view = v, .light_samples = light_samples, .shadows = shadows, .seed = seed, .out = out};
  ylm_status s = ylm_parallel(v->points, GRAIN, threads, run, &j, progress, "raycast");
  if (rays) *rays = j.rays;
  return s;
}
