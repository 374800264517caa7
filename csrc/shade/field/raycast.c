/* raycast.c - light from the lamps themselves, by sampling their solid angles. */
#include <math.h>
#include <stdatomic.h>

#include "../calibration.h"
#include "../view.h"

typedef struct job {
  const ylm_shade_view *view;
  const ylm_scene *lit;
  int light_samples;
  bool shadows;
  uint64_t seed;
  size_t step; /* of points, the first of so many */
  float *out;
  atomic_uint_fast64_t rays;
} job;

/* Points whose rays wait to be traced. */
typedef struct waiting {
  ylm_scene_batch lit;
  size_t point[SHADE_CAST_POINTS];
  size_t end[SHADE_CAST_POINTS]; /* of each point's rays */
  size_t points;
} waiting;

/* Traces the rays of all points so far; writes the radiance of these. */
static void finish(const job *j, waiting *w) {
  ylm_scene_batch *b = &w->lit;
  if (j->shadows) ylm_scene_batch_trace(b);
  for (size_t p = 0, k = 0; p < w->points; p++) {
    size_t i = w->point[p];
    double E[3] = {0, 0, 0};
    for (; k < w->end[p]; k++)
      if (!j->shadows || !(b->ray[k].far < 0))
        for (int c = 0; c < 3; c++) E[c] += b->value[k][c];
    ylm_material_reflect(ylm__shade_material(j->view, i), E, j->out + 3 * i);
    ylm__shade_tint(j->view, i, 1, j->out + 3 * i);
  }
  w->points = b->rays = 0;
}

/* Aims rays from a point whose random numbers have the number `stream`. */
static void aim(const job *j, waiting *w, size_t i, uint64_t stream) {
  ylm_rng rng;
  if (w->points == SHADE_CAST_POINTS || w->lit.rays + (size_t)j->light_samples > w->lit.room)
    finish(j, w);
  ylm_rng_seed(&rng, j->seed, stream);
  ylm_scene_batch_aim(&w->lit, j->view->lit[i], j->view->normal[i], j->view->origin[i],
                      j->light_samples, &rng);
  w->point[w->points] = i;
  w->end[w->points++] = w->lit.rays;
}

static bool is_matte(const job *j, size_t i) {
  return !ylm_material_glosses(ylm__shade_material(j->view, i));
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  waiting w;
  w.points = 0;
  ylm_status status = ylm_scene_batch_create(j->lit, (size_t)j->light_samples, &w.lit);
  shade_stream at = ylm__shade_stream_at(j->view, begin);
  for (size_t i = begin; status == YLM_OK && i < end; i++) {
    uint64_t stream = ylm__shade_stream_next(j->view, &at);
    if (i % j->step == 0 && is_matte(j, i)) aim(j, &w, i, stream);
  }
  if (status == YLM_OK) finish(j, &w);
  ylm_scene_batch_free(&w.lit);
  atomic_fetch_add_explicit(&j->rays, w.lit.traced, memory_order_relaxed);
  return status;
}

/* The points that are of other materials; their number. */
static size_t list_glossy(const job *j, size_t *point) {
  size_t n = 0;
  for (size_t i = 0; i < j->view->points; i += j->step)
    if (!is_matte(j, i)) point[n++] = i;
  return n;
}

/* Points of other materials. */
static ylm_status cast_glossy(const job *j, int threads, const ylm_progress *progress,
                              uint64_t *rays) {
  const ylm_shade_view *v = j->view;
  size_t *point = ylm_alloc(v->points, sizeof *point), n = point ? list_glossy(j, point) : 0;
  float *radiance = ylm_alloc_zero(3 * n, sizeof *radiance);
  shade_cast c = {.lit = j->lit,
                  .light_samples = j->light_samples,
                  .shadows = j->shadows,
                  .seed = j->seed,
                  .threads = threads,
                  .progress = progress};
  ylm_status s = point && radiance ? ylm__shade_cast(v, &c, n, point, radiance, rays) : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < 3 * n; i++) j->out[3 * point[i / 3] + i % 3] = radiance[i];
  ylm_free(point);
  ylm_free(radiance);
  return s;
}

ylm_status ylm_shade_raycast(const ylm_shade_view *v, const ylm_scene *lit, int light_samples,
                             bool shadows, uint64_t seed, int threads, const ylm_progress *progress,
                             float *out, uint64_t *rays) {
  if (light_samples < 1 || light_samples > YLM_SCENE_SAMPLES) return YLM_ERANGE;
  if (lit && ylm_scene_meshes(lit) != ylm_scene_meshes(v->scene)) return YLM_EINVAL;
  job j = {.view = v,
           .lit = lit ? lit : v->scene,
           .light_samples = light_samples,
           .shadows = shadows,
           .seed = seed,
           .step = 1,
           .out = out};
  ylm_status s = ylm_parallel(v->points, SHADE_CAST_GRAIN, threads, run, &j, progress, "raycast");
  uint64_t all = j.rays;
  if (s == YLM_OK) s = cast_glossy(&j, threads, progress, &all);
  if (rays) *rays = all;
  return s;
}

/* The number of points of which one is asked for noise. */
static size_t noise_step(size_t points) {
  size_t n = points / NOISE_PART;
  if (n < NOISE_RAYS_LEAST) n = NOISE_RAYS_LEAST;
  if (n > NOISE_RAYS_MOST) n = NOISE_RAYS_MOST;
  return points / n + 1;
}

static double luminance_at(const float *rgb, size_t i) {
  return ylm_luminance(
      (double[]){(double)rgb[3 * i], (double)rgb[3 * i + 1], (double)rgb[3 * i + 2]});
}

ylm_status ylm_shade_raycast_noise(const ylm_shade_view *v, const ylm_scene *lit, int light_samples,
                                   bool shadows, uint64_t seed, int threads, const float *radiance,
                                   double *noise) {
  size_t points = v->points, n = 0;
  double square = 0, mean = 0;
  uint64_t rays = 0;
  *noise = 0;
  if (light_samples < 1 || light_samples > YLM_SCENE_SAMPLES) return YLM_ERANGE;
  if (lit && ylm_scene_meshes(lit) != ylm_scene_meshes(v->scene)) return YLM_EINVAL;
  job j = {.view = v,
           .lit = lit ? lit : v->scene,
           .light_samples = light_samples,
           .shadows = shadows,
           .seed = ~seed,
           .step = noise_step(points),
           .out = ylm_alloc_zero(3 * points, sizeof(float))};
  if (!j.out) return YLM_ENOMEM;
  ylm_status s = ylm_parallel(points, SHADE_CAST_GRAIN, threads, run, &j, NULL, NULL);
  if (s == YLM_OK) s = cast_glossy(&j, threads, NULL, &rays);
  for (size_t i = 0; s == YLM_OK && i < points; i += j.step, n++) {
    double a = luminance_at(j.out, i), b = luminance_at(radiance, i);
    square += (a - b) * (a - b) / 2;
    mean += (a + b) / 2;
  }
  if (mean > 0) *noise = sqrt(square * (double)n) / mean;
  ylm_free(j.out);
  return s;
}
