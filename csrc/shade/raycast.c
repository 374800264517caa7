/* raycast.c - light from the lamps themselves, by sampling their solid angles. */
#include <math.h>
#include <stdatomic.h>

#include "view.h"
#include "ylm_path.h"

#define GRAIN 32

typedef struct job {
  const ylm_shade_view *view;
  const ylm_scene *lit;
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
  ylm_rng_seed(&rng, j->seed, ylm__shade_stream(j->view, i));
  E[0] = E[1] = E[2] = 0;
  size_t rays = ylm_scene_aim(s->lamps, j->view->origin[i], j->view->normal[i], j->light_samples,
                              &rng, s->ray, s->value);
  if (j->shadows) ylm_trace_occluded(ylm_scene_trace(j->lit), rays, s->ray);
  for (size_t k = 0; k < rays; k++)
    if (!j->shadows || !(s->ray[k].far < 0))
      for (int c = 0; c < 3; c++) E[c] += s->value[k][c];
  return j->shadows ? rays : 0;
}

/* Materials whose radiance is the same in all directions: irradiance tells all of it. */
static bool is_matte(const ylm_material *m) {
  return ylm_material_kind(m) == ylm_material_kind_find("matte");
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  size_t light_samples = (size_t)j->light_samples, rays = 0;
  scratch s = {.lamps = ylm_scene_chooser_create(j->lit),
               .ray = ylm_alloc(light_samples, sizeof(ylm_trace_ray)),
               .value = ylm_alloc(light_samples, 12)};
  ylm_status status = s.lamps && s.ray && s.value ? YLM_OK : YLM_ENOMEM;
  for (size_t i = begin; status == YLM_OK && i < end; i++) {
    double E[3];
    if (!is_matte(ylm__shade_material(j->view, i))) continue;
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

/* The points that are of other materials; their number. */
static size_t list_glossy(const ylm_shade_view *v, size_t *point) {
  size_t n = 0;
  for (size_t i = 0; i < v->points; i++)
    if (!is_matte(ylm__shade_material(v, i))) point[n++] = i;
  return n;
}

/* Points of other materials by rays to lamps and rays that the material chooses, as many of each. */
static ylm_status cast_glossy(const job *j, int threads, const ylm_progress *progress,
                              uint64_t *rays) {
  const ylm_shade_view *v = j->view;
  size_t *point = ylm_alloc(v->points, sizeof *point), n = point ? list_glossy(v, point) : 0;
  ylm_scene_place *place = ylm_alloc(n, sizeof *place);
  float *room = ylm_alloc_zero(9 * n, sizeof *room);
  ylm_path_options o = {.samples = j->light_samples,
                        .first = 1,
                        .last = 1,
                        .seed = j->seed,
                        .threads = threads,
                        .progress = progress};
  ylm_path_sum sum = {0, room, room + 3 * n, room + 6 * n};
  ylm_path_stats stats = {0};
  ylm_status s = point && place && room ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && n > 0 && v->corner) s = YLM_EINVAL;
  for (size_t i = 0; s == YLM_OK && i < n; i++) place[i] = v->entry[point[i]].at;
  if (s == YLM_OK && n > 0)
    s = ylm_path_places(j->lit, n, place, v->frame.from, j->shadows, &o, &sum, &stats, NULL);
  for (size_t i = 0; s == YLM_OK && i < 3 * n; i++) j->out[3 * point[i / 3] + i % 3] = room[i];
  *rays += stats.nearest_rays + stats.shadow_rays;
  ylm_free(point);
  ylm_free(place);
  ylm_free(room);
  return s;
}

ylm_status ylm_shade_raycast(const ylm_shade_view *v, const ylm_scene *lit, int light_samples,
                             bool shadows, uint64_t seed, int threads, const ylm_progress *progress,
                             float *out, uint64_t *rays) {
  if (light_samples < 1 || light_samples > 65536) return YLM_ERANGE;
  if (lit && ylm_scene_meshes(lit) != ylm_scene_meshes(v->scene)) return YLM_EINVAL;
  job j = {.view = v,
           .lit = lit ? lit : v->scene,
           .light_samples = light_samples,
           .shadows = shadows,
           .seed = seed,
           .out = out};
  ylm_status s = ylm_parallel(v->points, GRAIN, threads, run, &j, progress, "raycast");
  uint64_t all = j.rays;
  if (s == YLM_OK) s = cast_glossy(&j, threads, progress, &all);
  if (rays) *rays = all;
  return s;
}
