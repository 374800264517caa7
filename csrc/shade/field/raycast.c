/* raycast.c - light from the lamps themselves, by sampling their solid angles. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "../calibration.h"
#include "../gloss/lobes.h"
#include "ylm_random.h"

typedef struct job {
  const ylm_shade_view *view;
  const ylm_scene *lit;
  const ylm_scene_guide *guide;
  int light_samples, most; /* of a point */
  const float *own;        /* [points] or NULL: all have light_samples */
  bool shadows, spread;
  uint64_t seed;
  size_t step; /* of points, the first of so many */
  bool matte;  /* all points */
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

/* Has point i rays? */
static bool has_rays(const job *j, size_t i) { return !j->own || j->own[i] >= 1; }

static bool arrives(const job *j, const ylm_scene_batch *b, size_t k) {
  return !j->shadows || !(b->ray[k].far < 0);
}

/* Light that a matte point i reflects of rays first .. end-1. */
static void reflect(const job *j, const ylm_scene_batch *b, size_t first, size_t end, size_t i) {
  double E[3] = {0, 0, 0};
  for (size_t k = first; k < end; k++)
    if (arrives(j, b, k))
      for (int c = 0; c < 3; c++) E[c] += b->value[k][c];
  ylm_material_reflect(ylm__shade_material(j->view, i), E, j->out + 3 * i);
}

/* Light that point i, which glosses, reflects of rays first .. end-1: the irradiance of each by its f. */
static void reflect_lobe(const job *j, const ylm_scene_batch *b, size_t first, size_t end,
                         size_t i) {
  const ylm_material *m = ylm__shade_material(j->view, i);
  ylm_scene_surface s;
  float y[3], eye[3], wi[SHADE_LOBE_RAYS][3], wo[SHADE_LOBE_RAYS][3], f[SHADE_LOBE_RAYS][3];
  size_t of[SHADE_LOBE_RAYS], n = 0;
  double sum[3] = {0, 0, 0};
  ylm__shade_frame(j->view, NULL, i, &s, y, eye);
  for (size_t k = first; k < end; k++) {
    if (arrives(j, b, k)) {
      const float *d = b->ray[k].dir;
      float each = 1 / sqrtf(ylm_dot3(d, d));
      wi[n][0] = each * ylm_dot3(d, s.tangent);
      wi[n][1] = each * ylm_dot3(d, y);
      wi[n][2] = each * ylm_dot3(d, s.normal);
      memcpy(wo[n], eye, sizeof eye);
      of[n++] = k;
    }
    if (n < SHADE_LOBE_RAYS && (k + 1 < end || n == 0)) continue;
    ylm_material_eval(m, n, (const float(*)[3])wi, (const float(*)[3])wo, f);
    for (; n > 0; n--)
      for (int c = 0; c < 3; c++) sum[c] += b->value[of[n - 1]][c] * (double)f[n - 1][c];
  }
  for (int c = 0; c < 3; c++) j->out[3 * i + (size_t)c] = (float)sum[c];
}

/* Traces the rays of all points so far; writes the radiance of these. */
static void finish(const job *j, waiting *w) {
  ylm_scene_batch *b = &w->lit;
  if (j->shadows) ylm_scene_batch_trace(b);
  for (size_t p = 0, first = 0; p < w->points; first = w->end[p++]) {
    size_t i = w->point[p];
    (ylm__shade_glosses(j->view, i) ? reflect_lobe : reflect)(j, b, first, w->end[p], i);
    ylm__shade_tint(j->view, i, 1, j->out + 3 * i);
  }
  w->points = b->rays = 0;
}

/* Has rays from `first` on start from places all over point i's part of pixel p, and end where they ended. */
static void spread(const job *j, ylm_scene_batch *b, size_t first, size_t p, size_t i,
                   ylm_rng *rng) {
  float origin[SHADE_PLACES_MOST][3];
  size_t n = (b->rays - first + SHADE_PLACE_RAYS - 1) / SHADE_PLACE_RAYS;
  n = ylm__shade_places(j->view, p, i, n < SHADE_PLACES_MOST ? n : SHADE_PLACES_MOST, rng, origin);
  size_t turn = n ? (size_t)(ylm_draw_double(rng) * (double)n) : 0;
  for (size_t k = first; n > 0 && k < b->rays; k++) {
    ylm_trace_ray *ray = b->ray + k;
    const float *from = origin[(k - first + turn) % n];
    if (!(ray->far > 0)) continue;
    for (int a = 0; a < 3; a++) {
      ray->dir[a] += (ray->org[a] - from[a]) / ray->far; /* 0 of lamps that are infinitely far */
      ray->org[a] = from[a];
    }
  }
}

/* Aims rays from point i of pixel p whose random numbers have the number `stream`. */
static void aim(const job *j, waiting *w, size_t p, size_t i, uint64_t stream) {
  ylm_rng rng;
  int rays = j->own ? (int)j->own[i] : j->light_samples;
  if (w->points == SHADE_CAST_POINTS || w->lit.rays + (size_t)rays > w->lit.room) finish(j, w);
  ylm_draw_seed(&rng, j->seed, stream);
  size_t first = w->lit.rays;
  ylm_scene_batch_aim(&w->lit, j->view->lit[i], j->view->normal[i], j->view->origin[i], rays, &rng);
  if (j->spread) spread(j, &w->lit, first, p, i, &rng);
  w->point[w->points] = i;
  w->end[w->points++] = w->lit.rays;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  waiting w;
  w.points = 0;
  ylm_status status = ylm_scene_batch_create(j->lit, (size_t)j->most, &w.lit);
  if (status == YLM_OK && !ylm_scene_chooser_follow(w.lit.lamps, j->guide)) status = YLM_EINVAL;
  shade_stream at = ylm__shade_stream_at(j->view, begin);
  for (size_t i = begin; status == YLM_OK && i < end; i++) {
    uint64_t stream = ylm__shade_stream_next(j->view, &at);
    if (!has_rays(j, i)) memset(j->out + 3 * i, 0, 12);
    if (i % j->step == 0 && has_rays(j, i) && (j->matte || ylm__shade_is_soft(j->view, i)))
      aim(j, &w, at.pixel, i, stream);
  }
  if (status == YLM_OK) finish(j, &w);
  ylm_scene_batch_free(&w.lit);
  atomic_fetch_add_explicit(&j->rays, w.lit.traced, memory_order_relaxed);
  return status;
}

/* Whether rays to lamps find the light of all points: no material glosses. */
static bool are_matte(const ylm_shade_view *v) {
  for (size_t k = 0; k < ylm_scene_meshes(v->scene); k++)
    if (ylm_material_glosses(ylm__shade_mesh_material(v, k))) return false;
  return true;
}

/* The points with rays whose lobes are narrow; their number. */
static size_t list_narrow(const job *j, size_t *point) {
  size_t n = 0;
  for (size_t i = 0; i < j->view->points; i += j->step)
    if (has_rays(j, i) && !ylm__shade_is_soft(j->view, i)) point[n++] = i;
  return n;
}

/* Points whose lobes are narrow. */
static ylm_status cast_narrow(const job *j, int threads, const ylm_progress *progress,
                              uint64_t *rays) {
  const ylm_shade_view *v = j->view;
  if (j->matte) return YLM_OK;
  size_t *point = ylm_alloc(v->points, sizeof *point), n = point ? list_narrow(j, point) : 0;
  float *radiance = ylm_alloc_zero(3 * n, sizeof *radiance);
  float *own = j->own ? ylm_alloc(n, sizeof *own) : NULL;
  shade_cast c = {.lit = j->lit,
                  .own = own,
                  .light_samples = j->light_samples,
                  .shadows = j->shadows,
                  .seed = j->seed,
                  .threads = threads,
                  .progress = progress};
  for (size_t i = 0; point && own && i < n; i++) own[i] = j->own[point[i]];
  bool made = point && radiance && (own || !j->own);
  ylm_status s = made ? ylm__shade_cast(v, &c, n, point, radiance, rays) : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < 3 * n; i++) j->out[3 * point[i / 3] + i % 3] = radiance[i];
  ylm_free(point);
  ylm_free(own);
  ylm_free(radiance);
  return s;
}

/* The meaning of options for the points of a view; `out` and `step` are the caller's. */
static ylm_status begin(const ylm_shade_view *v, const ylm_shade_casting *o, job *j) {
  if (o->light_samples < 1 || o->light_samples > YLM_SCENE_SAMPLES) return YLM_ERANGE;
  if (o->lit && ylm_scene_meshes(o->lit) != ylm_scene_meshes(v->scene)) return YLM_EINVAL;
  *j = (job){.view = v,
             .lit = o->lit ? o->lit : v->scene,
             .guide = o->guide,
             .light_samples = o->light_samples,
             .shadows = o->shadows,
             .spread = o->spread && !v->corner,
             .seed = o->seed,
             .own = o->rays,
             .most = o->light_samples,
             .step = 1,
             .matte = are_matte(v)};
  for (size_t i = 0; o->rays && i < v->points; i++) {
    if (!(o->rays[i] >= 0 && o->rays[i] <= YLM_SCENE_SAMPLES)) return YLM_ERANGE;
    if (o->rays[i] > (float)j->most) j->most = (int)o->rays[i];
  }
  return YLM_OK;
}

ylm_status ylm_shade_raycast(const ylm_shade_view *v, const ylm_shade_casting *o, float *out,
                             uint64_t *rays) {
  job j;
  ylm_status s = begin(v, o, &j);
  if (s != YLM_OK) return s;
  j.out = out;
  s = ylm_parallel(v->points, SHADE_CAST_GRAIN, o->threads, run, &j, o->progress, "raycast");
  uint64_t all = j.rays;
  if (s == YLM_OK) s = cast_narrow(&j, o->threads, o->progress, &all);
  if (rays) *rays = all;
  return s;
}

/* The places of points that rays to lamps light, to be freed: [3][n]. */
static ylm_status list_places(const job *j, float (**room)[3], ylm_scene_places *out) {
  const ylm_shade_view *v = j->view;
  size_t n = 0, all = 0;
  for (size_t i = 0; i < v->points; i++) all += ylm__shade_is_soft(j->view, i);
  float(*x)[3] = *room = ylm_alloc(3 * all, sizeof **room);
  if (!x) return YLM_ENOMEM;
  for (size_t i = 0; i < v->points; i++) {
    if (!ylm__shade_is_soft(j->view, i)) continue;
    memcpy(x[n], v->lit[i], 12);
    memcpy(x[all + n], v->normal[i], 12);
    memcpy(x[2 * all + n++], v->origin[i], 12);
  }
  *out = (ylm_scene_places){all, (const float(*)[3])x, (const float(*)[3])(x + all),
                            (const float(*)[3])(x + 2 * all)};
  return YLM_OK;
}

ylm_status ylm_shade_guide(const ylm_shade_view *v, const ylm_shade_casting *o,
                           ylm_scene_guide **out) {
  job j;
  ylm_scene_places places;
  float(*room)[3] = NULL;
  *out = NULL;
  ylm_status s = begin(v, o, &j);
  if (s != YLM_OK || !ylm_scene_guides(j.lit)) return s;
  s = list_places(&j, &room, &places);
  if (s == YLM_OK)
    s = ylm_scene_guide_create(j.lit, &places, o->light_samples, o->seed, o->threads, o->progress,
                               out);
  ylm_free(room);
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

ylm_status ylm_shade_raycast_noise(const ylm_shade_view *v, const ylm_shade_casting *o,
                                   const float *radiance, double *noise) {
  size_t points = v->points, n = 0;
  double square = 0, mean = 0;
  uint64_t rays = 0;
  job j;
  *noise = 0;
  ylm_status s = begin(v, o, &j);
  if (s != YLM_OK) return s;
  j.seed = ~o->seed;
  j.step = noise_step(points);
  if (!(j.out = ylm_alloc_zero(3 * points, sizeof(float)))) return YLM_ENOMEM;
  s = ylm_parallel(points, SHADE_CAST_GRAIN, o->threads, run, &j, NULL, NULL);
  if (s == YLM_OK) s = cast_narrow(&j, o->threads, NULL, &rays);
  for (size_t i = 0; s == YLM_OK && i < points; i += j.step, n++) {
    double a = luminance_at(j.out, i), b = luminance_at(radiance, i);
    square += (a - b) * (a - b) / 2;
    mean += (a + b) / 2;
  }
  if (mean > 0) *noise = sqrt(square * (double)n) / mean;
  ylm_free(j.out);
  return s;
}
