/* sets.c - light along links that are found set by set, more of them where they are wanted, and not kept. */
#include <math.h>
#include <string.h>

#include "../calibration.h"
#include "../gloss/lobes.h"
#include "ylm_shade_bounce.h"

/* Points that still want a set, and its links. */
typedef struct round_of {
  const ylm_shade_view *view;
  const ylm_shade_sets *o;
  uint64_t done, total; /* sets of points */
  uint64_t *stream;
  size_t *pixel;                           /* [points] */
  uint32_t *point, *link;                  /* [points], [SETS_POINTS][YLM_SHADE_SET] */
  float (*origin)[3], (*normal)[3], *mean; /* [SETS_POINTS], mean [..][4] */
  uint64_t *own;
  size_t *start;    /* [SETS_POINTS+1] */
  uint16_t *weight; /* [SETS_POINTS][3][YLM_SHADE_SET], of lobes as shade_lobes has them */
  float *most;      /* [SETS_POINTS]; the three NULL: no point is a lobe */
} round_of;

static void round_free(round_of *r) {
  ylm_free(r->stream);
  ylm_free(r->pixel);
  ylm_free(r->point);
  ylm_free(r->link);
  ylm_free(r->origin);
  ylm_free(r->normal);
  ylm_free(r->mean);
  ylm_free(r->own);
  ylm_free(r->start);
  ylm_free(r->weight);
  ylm_free(r->most);
}

static bool is_lobe(const round_of *r, size_t i) {
  return !r->o->all && ylm__shade_glosses(r->view, i);
}

/* The room of lobes, where a point is one. */
static ylm_status make_room(round_of *r) {
  size_t i = 0;
  while (i < r->view->points && !is_lobe(r, i)) i++;
  if (i == r->view->points) return YLM_OK;
  r->start = ylm_alloc(SETS_POINTS + 1, sizeof *r->start);
  r->weight = ylm_alloc(SETS_POINTS, 3 * YLM_SHADE_SET * sizeof *r->weight);
  r->most = ylm_alloc(SETS_POINTS, sizeof *r->most);
  return r->start && r->weight && r->most ? YLM_OK : YLM_ENOMEM;
}

static ylm_status round_create(round_of *r) {
  size_t points = r->view->points;
  r->stream = ylm__shade_streams(r->view);
  r->pixel = ylm_alloc(points, sizeof *r->pixel);
  r->point = ylm_alloc(points, sizeof *r->point);
  r->link = ylm_alloc(SETS_POINTS, YLM_SHADE_SET * sizeof *r->link);
  r->origin = ylm_alloc(SETS_POINTS, sizeof *r->origin);
  r->normal = ylm_alloc(SETS_POINTS, sizeof *r->normal);
  r->mean = ylm_alloc(SETS_POINTS, 4 * sizeof *r->mean);
  r->own = ylm_alloc(SETS_POINTS, sizeof *r->own);
  if (!r->stream || !r->pixel || !r->point || !r->link || !r->origin || !r->normal || !r->mean ||
      !r->own)
    return YLM_ENOMEM;
  for (size_t i = 0; i < points; i++) r->stream[i] = ylm_mix64(r->stream[i]);
  for (size_t p = 0; !r->view->corner && p < r->view->stats.pixels; p++)
    for (size_t i = r->view->pixel[p].first; i < r->view->pixel[p + 1].first; i++) r->pixel[i] = p;
  return make_room(r);
}

/* Adds the light of a set of some points to a half. */
static ylm_status add_set(round_of *r, size_t n, const uint32_t *point, uint64_t seed, float *half,
                          ylm_error *e) {
  const ylm_shade_sets *o = r->o;
  for (size_t i = 0; i < n; i++) {
    ylm_rng rng;
    ylm_rng_seed(&rng, ylm_mix64(seed ^ SETS_PLACES), r->stream[point[i]]);
    if (!ylm__shade_places(r->view, r->pixel[point[i]], point[i], 1, &rng, r->origin + i))
      memcpy(r->origin[i], r->view->origin[point[i]], 12);
    memcpy(r->normal[i], r->view->normal[point[i]], 12);
    r->own[i] = r->stream[point[i]];
  }
  const float(*origin)[3] = (const float(*)[3])r->origin,
        (*normal)[3] = (const float(*)[3])r->normal;
  ylm_status s;
  if (o->targets && o->links % 2 == 0)
    s = ylm_transfer_gather_targets(o->targets, o->leaving, n, origin, normal, r->own, o->links,
                                    seed, o->threads, NULL, (float(*)[4])r->mean);
  else {
    s = ylm_transfer_find(o->transfer, n, origin, normal, r->own, o->links, seed, o->threads, NULL,
                          (ylm_links){.four = r->link}, 0, NULL, e);
    if (s == YLM_OK)
      ylm_transfer_sum(n, o->links, (ylm_links){.four = r->link}, 4, o->leaving, NULL, r->mean,
                       o->threads);
  }
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < n; i++)
    for (size_t c = 0; c < 3; c++) half[3 * (size_t)point[i] + c] += r->mean[4 * i + c];
  return YLM_OK;
}

/* Adds the light of a set of some points that gloss to a half: radiance, along links that their materials choose. */
static ylm_status add_lobes(round_of *r, size_t n, const uint32_t *point, uint64_t seed,
                            float *half) {
  const ylm_shade_sets *o = r->o;
  size_t links = (size_t)o->links;
  shade_lobes x = {.start = r->start, .link = r->link, .weight = r->weight, .most = r->most};
  for (size_t i = 0; i <= n; i++) r->start[i] = i * links;
  ylm_status s = ylm__shade_lobes(r->view, o->transfer, o->targets, n, point, r->stream, links,
                                  seed, o->threads, NULL, &x);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    double light[3];
    ylm__shade_lobe(&x, i, o->leaving, -1, light);
    for (size_t c = 0; c < 3; c++) half[3 * (size_t)point[i] + c] += (float)light[c];
  }
  return s;
}

/* How many sets of a point are in a half: of an odd number, the first has one more. */
static float sets_of(float sets, int half) { return floorf((sets + (float)(1 - half)) / 2); }

/* The sets of a half from their sums to the radiance that points reflect. */
static void finish(const round_of *r, int h, float *half) {
  for (size_t i = 0; i < r->view->points; i++) {
    float n = sets_of(r->o->sets[i], h);
    bool lobe = is_lobe(r, i);
    for (size_t c = 0; n > 0 && c < 3; c++) half[3 * i + c] *= (lobe ? 1 : (float)YLM_PI) / n;
    if (lobe)
      ylm__shade_tint(r->view, i, 1, half + 3 * i);
    else
      ylm__shade_reflect(r->view, i, 1, half + 3 * i);
  }
}

/* All sets of number `k` of the points that are, or are not, lobes; *rays counts links. */
static ylm_status run_kind(round_of *r, int k, bool lobes, float *half, uint64_t *rays,
                           ylm_error *e) {
  size_t n = 0;
  uint64_t seed = ylm_mix64(ylm_mix64(r->o->seed) + (uint64_t)k);
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < r->view->points; i++)
    if ((float)k < r->o->sets[i] && is_lobe(r, i) == lobes) r->point[n++] = (uint32_t)i;
  for (size_t at = 0; s == YLM_OK && at < n; at += SETS_POINTS) {
    size_t some = n - at < SETS_POINTS ? n - at : SETS_POINTS;
    s = lobes ? add_lobes(r, some, r->point + at, seed, half)
              : add_set(r, some, r->point + at, seed, half, e);
    r->done += some;
    if (s == YLM_OK) s = ylm_report(r->o->progress, r->done, r->total, "links");
  }
  *rays += n * (size_t)r->o->links;
  return s;
}

static ylm_status run_round(round_of *r, int k, float *half, uint64_t *rays, ylm_error *e) {
  ylm_status s = run_kind(r, k, false, half, rays, e);
  return s == YLM_OK ? run_kind(r, k, true, half, rays, e) : s;
}

ylm_status ylm_shade_gather_sets(const ylm_shade_view *v, const ylm_shade_sets *o, float *half[2],
                                 uint64_t *rays, ylm_error *e) {
  round_of r = {.view = v, .o = o};
  float most = 0;
  if (o->links < 4 || o->links > YLM_SHADE_SET || o->links % 4) return YLM_ERANGE;
  for (size_t i = 0; i < v->points; i++) {
    most = fmaxf(most, o->sets[i]);
    r.total += (uint64_t)o->sets[i];
  }
  *rays = 0;
  memset(half[0], 0, v->points * 12);
  memset(half[1], 0, v->points * 12);
  ylm_status s = round_create(&r);
  for (int k = 0; s == YLM_OK && (float)k < most; k++) s = run_round(&r, k, half[k % 2], rays, e);
  for (int h = 0; s == YLM_OK && h < 2; h++) finish(&r, h, half[h]);
  round_free(&r);
  return s;
}

ylm_status ylm_shade_targets(const ylm_shade_view *v, const ylm_transfer *t, const float *leaving,
                             uint64_t seed, int threads, const ylm_progress *progress,
                             ylm_transfer_targets **out) {
  size_t step = v->points / TARGETS_MOST + 1, n = 0;
  float(*x)[3] = ylm_alloc(2 * (v->points / step + 1), sizeof *x);
  float(*normal)[3] = x + v->points / step + 1;
  *out = NULL;
  if (!x) return YLM_ENOMEM;
  for (size_t i = 0; i < v->points; i += step) {
    if (!ylm__shade_is_soft(v, i)) continue;
    memcpy(x[n], v->origin[i], 12);
    memcpy(normal[n++], v->normal[i], 12);
  }
  ylm_scene_places places = {n, (const float(*)[3])x, (const float(*)[3])normal,
                             (const float(*)[3])x};
  ylm_status s = ylm_transfer_targets_create(t, leaving, &places, seed, threads, progress, out);
  ylm_free(x);
  return s;
}
