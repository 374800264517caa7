/* occlusion.c - light that a view's visibility by direction lets pass, and that it takes away. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "../calibration.h"
#include "../view.h"
#include "ylm_image.h"

#define STREAMS 0x6f63636c7573696fu /* random numbers that no other estimate of the view uses */

/* Luminance that the lamps bring to a place of the picture: where the view lets it, where the scene
   does; the former without the latter, and the reverse. */
enum { METHOD, TRUTH, PASSING, MISSING, LIGHTS };

typedef struct job {
  const ylm_shade_view *view;
  size_t places;
  int light_samples;
  double (*light)[LIGHTS]; /* [places] */
  atomic_uint_fast64_t rays;
} job;

typedef struct scratch {
  ylm_scene_batch to_lamp;
  ylm_trace_ray *near; /* [light_samples] */
} scratch;

static double luminance(const float value[3], const float albedo[3]) {
  double rgb[3];
  for (int c = 0; c < 3; c++) rgb[c] = (double)(value[c] * albedo[c]);
  return fabs(ylm_luminance(rgb));
}

/* A random entry of stratum k, and the shading point that colours it: of a view per vertex one of
   the triangle's corners, as often as its colour counts. */
static size_t choose(const job *j, size_t k, ylm_rng *rng, size_t *entry) {
  const ylm_shade_view *v = j->view;
  double at = ((double)k + ylm_rng_double(rng)) / (double)j->places * (double)v->entries;
  *entry = at < (double)v->entries ? (size_t)at : v->entries - 1;
  if (!v->corner) return *entry;
  float w[3];
  double u = ylm_rng_double(rng);
  ylm__shade_corner_weights(&v->entry[*entry], w);
  int c = u < (double)w[0] ? 0 : u < (double)w[0] + (double)w[1] ? 1 : 2;
  return v->corner[*entry][c];
}

/* Rays of which the view knows whether they are free: the same, up to occlusion_distance. */
static void by_direction(const ylm_shade_view *v, const scratch *s) {
  float far = (float)fmin(v->o.occlusion_distance, 3e38);
  memcpy(s->near, s->to_lamp.ray, s->to_lamp.rays * sizeof *s->near);
  for (size_t i = 0; i < s->to_lamp.rays; i++) s->near[i].far = far;
}

/* The light of place k; returns the number of rays. */
static size_t look(const job *j, size_t k, scratch *s, double *out) {
  const ylm_shade_view *v = j->view;
  bool shadows = v->o.visibility != YLM_SHADE_UNSHADOWED;
  size_t entry;
  ylm_rng rng;
  ylm_rng_seed(&rng, v->o.seed ^ STREAMS, k);
  size_t point = choose(j, k, &rng, &entry);
  float albedo[3];
  ylm__shade_albedo(v, point, albedo);
  ylm_scene_batch *b = &s->to_lamp;
  b->rays = 0;
  ylm_scene_batch_aim(b, v->lit[point], v->normal[point], v->origin[point], j->light_samples, &rng);
  size_t n = b->rays;
  memset(out, 0, LIGHTS * sizeof *out);
  if (shadows) by_direction(v, s);
  ylm_scene_batch_trace(b);
  if (shadows) ylm_trace_occluded(ylm_scene_trace(v->scene), n, s->near);
  for (size_t i = 0; i < n; i++) {
    double c = (double)v->entry[entry].weight * luminance(b->value[i], albedo);
    if (!isfinite(c)) continue;
    bool free = !(b->ray[i].far < 0), seen = !shadows || !(s->near[i].far < 0);
    out[METHOD] += seen ? c : 0;
    out[TRUTH] += free ? c : 0;
    out[PASSING] += seen && !free ? c : 0;
    out[MISSING] += free && !seen ? c : 0;
  }
  return shadows ? 2 * n : n;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  size_t light_samples = (size_t)j->light_samples, rays = 0;
  scratch s = {.near = ylm_alloc(light_samples, sizeof *s.near)};
  ylm_status status = ylm_scene_batch_create(j->view->scene, light_samples, &s.to_lamp);
  if (!s.near) status = YLM_ENOMEM;
  for (size_t k = begin; status == YLM_OK && k < end; k++) rays += look(j, k, &s, j->light[k]);
  ylm_scene_batch_free(&s.to_lamp);
  ylm_free(s.near);
  atomic_fetch_add_explicit(&j->rays, rays, memory_order_relaxed);
  return status;
}

/* The ratio of two sums over the places, and its standard error by linearisation (Cochran 1977). */
static double share(const job *j, int part, int whole, double *error) {
  double parts = 0, wholes = 0, squares = 0, n = (double)j->places;
  for (size_t k = 0; k < j->places; k++) {
    parts += j->light[k][part];
    wholes += j->light[k][whole];
  }
  *error = 0;
  if (!(wholes > 0)) return 0;
  for (size_t k = 0; k < j->places; k++) {
    double d = j->light[k][part] - parts / wholes * j->light[k][whole];
    squares += d * d;
  }
  if (n > 1) *error = sqrt(squares * n / (n - 1)) / wholes;
  return parts / wholes;
}

ylm_status ylm_shade_measure_occlusion(const ylm_shade_view *v, size_t places, int light_samples,
                                       int threads, ylm_shade_occlusion *out) {
  *out = (ylm_shade_occlusion){0};
  if (places < 1 || light_samples < 1 || light_samples > YLM_SCENE_SAMPLES) return YLM_ERANGE;
  if (v->o.visibility == YLM_SHADE_RAYS) return YLM_OK;
  double start = ylm_seconds();
  job j = {.view = v,
           .places = places < v->entries ? places : v->entries,
           .light_samples = light_samples};
  j.light = ylm_alloc_zero(j.places, sizeof *j.light);
  if (!j.light) return YLM_ENOMEM;
  ylm_status s = ylm_parallel(j.places, SHADE_MEASURED_GRAIN, threads, run, &j, NULL, NULL);
  if (s == YLM_OK) {
    out->passing = share(&j, PASSING, METHOD, &out->passing_error);
    out->missing = share(&j, MISSING, TRUTH, &out->missing_error);
    out->points = j.places;
    out->rays = j.rays;
    out->seconds = ylm_seconds() - start;
  }
  ylm_free(j.light);
  return s;
}
