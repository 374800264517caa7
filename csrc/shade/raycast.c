/* raycast.c - light from the lamps themselves, by sampling their solid angles. */
#include <math.h>
#include <stdatomic.h>

#include "view.h"
#include "ylm_path.h"

#define GRAIN 256
/* Rays that are traced in one go, where a point has fewer; points whose rays these are, at most. */
#define BATCH 512

typedef struct job {
  const ylm_shade_view *view;
  const ylm_scene *lit;
  int light_samples, matte; /* the kind */
  bool shadows;
  uint64_t seed;
  float *out;
  atomic_uint_fast64_t rays;
} job;

typedef struct scratch {
  ylm_scene_chooser *lamps;
  ylm_trace_ray *ray;  /* [room] */
  float (*value)[3];   /* [room]: irradiance that the ray brings if nothing is hit */
  size_t point[BATCH]; /* whose rays these are */
  size_t end[BATCH];   /* of each point's rays */
  size_t points, rays, room;
  uint64_t traced;
} scratch;

static bool scratch_create(const job *j, scratch *s) {
  size_t each = (size_t)j->light_samples;
  s->room = each > BATCH ? each : BATCH;
  s->lamps = ylm_scene_chooser_create(j->lit);
  s->ray = ylm_alloc(s->room, sizeof *s->ray);
  s->value = ylm_alloc(s->room, sizeof *s->value);
  return s->lamps && s->ray && s->value;
}

static void scratch_free(scratch *s) {
  ylm_scene_chooser_free(s->lamps);
  ylm_free(s->ray);
  ylm_free(s->value);
}

/* Traces the rays of all points so far; writes the radiance of these. */
static void finish(const job *j, scratch *s) {
  if (j->shadows) {
    ylm_trace_occluded(ylm_scene_trace(j->lit), s->rays, s->ray);
    s->traced += s->rays;
  }
  for (size_t p = 0, k = 0; p < s->points; p++) {
    size_t i = s->point[p];
    double E[3] = {0, 0, 0};
    for (; k < s->end[p]; k++)
      if (!j->shadows || !(s->ray[k].far < 0))
        for (int c = 0; c < 3; c++) E[c] += s->value[k][c];
    ylm_material_reflect(ylm__shade_material(j->view, i), E, j->out + 3 * i);
    ylm__shade_tint(j->view, i, 1, j->out + 3 * i);
  }
  s->points = s->rays = 0;
}

/* Aims rays from a point whose random numbers have the number `stream`. */
static void aim(const job *j, scratch *s, size_t i, uint64_t stream) {
  ylm_rng rng;
  if (s->points == BATCH || s->rays + (size_t)j->light_samples > s->room) finish(j, s);
  ylm_rng_seed(&rng, j->seed, stream);
  s->rays += ylm_scene_aim(s->lamps, j->view->origin[i], j->view->normal[i], j->light_samples, &rng,
                           s->ray + s->rays, s->value + s->rays);
  s->point[s->points] = i;
  s->end[s->points++] = s->rays;
}

static bool is_matte(const job *j, size_t i) {
  return ylm_material_kind(ylm__shade_material(j->view, i)) == j->matte;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  scratch s = {0};
  ylm_status status = scratch_create(j, &s) ? YLM_OK : YLM_ENOMEM;
  shade_stream at = ylm__shade_stream_at(j->view, begin);
  for (size_t i = begin; status == YLM_OK && i < end; i++) {
    uint64_t stream = ylm__shade_stream_next(j->view, &at);
    if (is_matte(j, i)) aim(j, &s, i, stream);
  }
  if (status == YLM_OK) finish(j, &s);
  scratch_free(&s);
  atomic_fetch_add_explicit(&j->rays, s.traced, memory_order_relaxed);
  return status;
}

/* The points that are of other materials; their number. */
static size_t list_glossy(const job *j, size_t *point) {
  size_t n = 0;
  for (size_t i = 0; i < j->view->points; i++)
    if (!is_matte(j, i)) point[n++] = i;
  return n;
}

ylm_status ylm__shade_cast(const ylm_shade_view *v, const shade_cast *c, size_t n,
                           const size_t *point, float *out, uint64_t *rays) {
  ylm_scene_place *place = ylm_alloc(n, sizeof *place);
  float *room = ylm_alloc_zero(6 * n, sizeof *room);
  ylm_path_options o = {.samples = c->light_samples,
                        .first = 1,
                        .last = 1,
                        .seed = c->seed,
                        .threads = c->threads,
                        .progress = c->progress};
  ylm_path_sum sum = {0, out, room, room + 3 * n};
  ylm_path_stats stats = {0};
  ylm_status s = place && room ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && n > 0 && v->corner) s = YLM_EINVAL;
  for (size_t i = 0; s == YLM_OK && i < n; i++) place[i] = v->entry[point[i]].at;
  if (s == YLM_OK && n > 0)
    s = ylm_path_places(c->lit ? c->lit : v->scene, n, place, v->frame.from, c->shadows, &o, &sum,
                        &stats, NULL);
  *rays += stats.nearest_rays + stats.shadow_rays;
  ylm_free(place);
  ylm_free(room);
  return s;
}

/* Points of other materials. */
static ylm_status cast_glossy(const job *j, int threads, const ylm_progress *progress,
                              uint64_t *rays) {
  const ylm_shade_view *v = j->view;
  size_t *point = ylm_alloc(v->points, sizeof *point), n = point ? list_glossy(j, point) : 0;
  float *radiance = ylm_alloc_zero(3 * n, sizeof *radiance);
  shade_cast c = {j->lit, j->light_samples, j->shadows, j->seed, threads, progress};
  ylm_status s = point && radiance ? ylm__shade_cast(v, &c, n, point, radiance, rays) : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < 3 * n; i++) j->out[3 * point[i / 3] + i % 3] = radiance[i];
  ylm_free(point);
  ylm_free(radiance);
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
           .matte = ylm_material_kind_find("matte"),
           .shadows = shadows,
           .seed = seed,
           .out = out};
  ylm_status s = ylm_parallel(v->points, GRAIN, threads, run, &j, progress, "raycast");
  uint64_t all = j.rays;
  if (s == YLM_OK) s = cast_glossy(&j, threads, progress, &all);
  if (rays) *rays = all;
  return s;
}
