/* blend.c - points that gloss, by rays where the light's degree is too low for their lobes. */
#include <math.h>
#include <string.h>

#include "../calibration.h"
#include "gloss.h"
#include "ylm_shade_bounce.h"

typedef struct weighing {
  const ylm_shade_view *v;
  const shade_tables *t;
  int lmax;
  float *share, *error; /* [points] */
} weighing;

static bool glosses(const ylm_shade_view *v, size_t i) {
  return ylm__shade_gloss_slot(v->gloss, v->mesh[i]) != YLM_SHADE_MATTE;
}

static ylm_status weigh_points(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const weighing *w = context;
  for (size_t i = begin; i < end; i++)
    if (glosses(w->v, i))
      ylm__shade_gloss_shares(w->v, w->t, w->lmax, i, 1, w->share + i, w->error + i);
  return YLM_OK;
}

/* The shares of rays at all points, and the counts of the report. YLM_ENOMEM. */
static ylm_status weigh(const ylm_shade_view *v, const shade_tables *t, int lmax, bool rays,
                        int threads, float *share, ylm_shade_blended *r) {
  double harmonics = 0, square = 0;
  weighing w = {v, t, lmax, share, ylm_alloc(v->points, sizeof *w.error)};
  if (!w.error) return YLM_ENOMEM;
  ylm_parallel(v->points, SHADE_GRAIN, threads, weigh_points, &w, NULL, NULL);
  for (size_t i = 0; i < v->points; i++) {
    double e = (double)w.error[i];
    if (!glosses(v, i)) continue;
    if (!rays) share[i] = 0;
    r->sh += share[i] < 1;
    r->rays += share[i] > 0;
    harmonics += 1 - (double)share[i];
    square += (1 - (double)share[i]) * e * e;
  }
  if (harmonics > 0) r->missed = sqrt(square / harmonics);
  ylm_free(w.error);
  return YLM_OK;
}

/* The points of which rays are a part. */
static size_t list(const ylm_shade_view *v, const float *share, size_t *point) {
  size_t n = 0;
  for (size_t i = 0; i < v->points; i++)
    if (share[i] > 0) point[n++] = i;
  return n;
}

static ylm_status mix(const ylm_shade_view *v, shade_cast *c, const float *share, float *radiance,
                      ylm_shade_blended *r) {
  size_t *point = ylm_alloc(r->rays, sizeof *point);
  float *cast = ylm_alloc(3 * r->rays, sizeof *cast), *part = ylm_alloc(r->rays, sizeof *part);
  size_t n = point ? list(v, share, point) : 0;
  ylm_status s = point && cast && part ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) part[i] = share[point[i]];
  c->share = part;
  if (s == YLM_OK) s = ylm__shade_cast(v, c, n, point, cast, &r->traced);
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    for (size_t k = 0; k < 3; k++) {
      float w = share[point[i]], *to = radiance + 3 * point[i] + k, by_rays = cast[3 * i + k];
      *to = w < 1 ? (1 - w) * *to + w * by_rays : by_rays;
    }
  ylm_free(point);
  ylm_free(cast);
  ylm_free(part);
  return s;
}

ylm_status ylm_shade_blend(const ylm_shade_view *v, const ylm_shade_blending *o, float *radiance,
                           float *share, ylm_shade_blended *report, ylm_error *e) {
  const shade_tables *t;
  double start = ylm_seconds();
  *report = (ylm_shade_blended){.noise = -1};
  memset(share, 0, v->points * sizeof *share);
  if (o->light_samples < 0 || o->light_samples > YLM_SCENE_SAMPLES) return YLM_ERANGE;
  if (o->lit && ylm_scene_meshes(o->lit) != ylm_scene_meshes(v->scene)) return YLM_EINVAL;
  if (!v->gloss) return YLM_OK;
  int degree = o->weight == YLM_SHADE_TRANSFER ? v->o.lmax : o->lmax;
  ylm_status s = ylm__shade_gloss_tables(v, degree, o->threads, o->progress, &t, e);
  if (s != YLM_OK) return s;
  s = weigh(v, t, o->lmax, o->light_samples > 0, o->threads, share, report);
  shade_cast c = {.lit = o->lit,
                  .light_samples = o->light_samples,
                  .noise = o->noise,
                  .most = o->most_samples,
                  .shadows = o->shadows,
                  .seed = o->seed,
                  .threads = o->threads,
                  .progress = o->progress};
  if (s == YLM_OK && report->rays) s = mix(v, &c, share, radiance, report);
  if (report->rays && o->noise > 0) report->noise = c.noise;
  report->light_samples = report->rays ? c.light_samples : 0;
  report->seconds = ylm_seconds() - start;
  return s;
}

ylm_status ylm_shade_blend_links(const ylm_shade_links *l, const float *leaving, int lmax,
                                 bool known, int threads, const ylm_progress *progress,
                                 float *radiance, float *share, ylm_shade_blended *report,
                                 ylm_error *e) {
  const ylm_shade_view *v = ylm__shade_links_view(l);
  const shade_tables *t;
  double start = ylm_seconds();
  *report = (ylm_shade_blended){0};
  if (!known) memset(share, 0, v->points * sizeof *share);
  if (!v->gloss) return YLM_OK;
  float *found = ylm_alloc(v->points, 3 * sizeof *found);
  ylm_status s = found ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_shade_gather(l, leaving, NULL, threads, progress, found);
  if (s == YLM_OK && !known) s = ylm__shade_gloss_tables(v, lmax, threads, progress, &t, e);
  if (s == YLM_OK && !known) s = weigh(v, t, lmax, true, threads, share, report);
  for (size_t i = 0; s == YLM_OK && i < v->points; i++)
    for (size_t k = 0; share[i] > 0 && k < 3; k++) {
      float *to = radiance + 3 * i + k, rest = known ? 1 : 1 - share[i];
      *to = (rest > 0 ? rest * *to : 0) + share[i] * found[3 * i + k];
    }
  ylm_free(found);
  report->seconds = ylm_seconds() - start;
  return s;
}
