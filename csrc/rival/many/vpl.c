/* vpl.c - what a bound takes from virtual points, found by rays (Kollig & Keller 2004). */
#include <math.h>
#include <string.h>

#include "many.h"
#include "ylm_vector.h"

#define GRAIN 256
#define PATHS 16 /* of each place that rays meet */

/* Places near to points, whose light the bound cut. */
typedef struct found {
  ylm_scene_place *place;
  uint32_t *point;
  float (*factor)
      [3]; /* of the radiance that leaves the place: pi/rays times the part that was cut, times f where the
                         point glosses */
  size_t n, room;
} found;

typedef struct job {
  const ylm_many_ask *ask;
  found *blocks;
} job;

static bool grow(found *f) {
  size_t room = f->room ? 2 * f->room : GRAIN;
  ylm_scene_place *place = ylm_realloc(f->place, f->n * sizeof *place, room, sizeof *place);
  if (place) f->place = place;
  uint32_t *point = ylm_realloc(f->point, f->n * sizeof *point, room, sizeof *point);
  if (point) f->point = point;
  float(*factor)[3] = ylm_realloc(f->factor, f->n * sizeof *factor, room, sizeof *factor);
  if (factor) f->factor = factor;
  if (!place || !point || !factor) return false;
  f->room = room;
  return true;
}

static void drop(found *f) {
  ylm_free(f->place);
  ylm_free(f->point);
  ylm_free(f->factor);
}

/* The part of the light of a hit that the bound cuts. */
static double cut(const ylm_many_ask *a, const ylm_trace_ray *ray, const ylm_scene_surface *s,
                  float t, const float N[3]) {
  float facing = -ylm_dot3(s->normal, ray->dir);
  if (!(facing > 0)) facing = -ylm_dot3(s->flat, ray->dir);
  double d2 = (double)t * (double)t, g = (double)ylm_dot3(N, ray->dir) * (double)facing / d2;
  return g > 0 && d2 > 0 ? 1 - ylm__many_bound(a, g, d2) / g : 0;
}

static ylm_status meet(const job *j, size_t i, uint64_t stream, ylm_trace_ray *ray,
                       ylm_trace_hit *hit, found *f) {
  ylm_many_ask a = *j->ask;
  const ylm_many_host *v = a.host;
  int n = a.o->compensate;
  bool glosses = v->glosses(v->gloss, v->view, i);
  ylm_many_receiver receiver;
  float albedo[3], x[3], y[3], tint[3] = {1, 1, 1}, f3[1][3] = {{1, 1, 1}};
  ylm_rng rng;
  v->albedo(v->view, i, albedo);
  a.reflectance =
      (float)((YLM_LUMINANCE_R * (double)albedo[0] + YLM_LUMINANCE_G * (double)albedo[1] +
               YLM_LUMINANCE_B * (double)albedo[2]) /
              YLM_PI);
  if (glosses) {
    v->tint(v->view, i, 1, tint);
    /* without tables it cannot fail */
    (void)v->receive(v->gloss, v->view, i, NULL, &receiver);
  }
  ylm_rng_seed(&rng, ~a.o->seed, stream);
  v->basis(v->normal[i], x, y);
  for (int k = 0; k < n; k++) {
    double u = (k + ylm_rng_double(&rng)) / n, turn = 2 * YLM_PI * ylm_rng_double(&rng),
           r = sqrt(u);
    memcpy(ray[k].org, v->origin[i], 12);
    for (int c = 0; c < 3; c++)
      ray[k].dir[c] = (float)(r * cos(turn) * (double)x[c] + r * sin(turn) * (double)y[c] +
                              sqrt(1 - u) * (double)v->normal[i][c]);
    ray[k].near = 0;
    ray[k].far = INFINITY;
  }
  v->nearest(v->trace, (size_t)n, ray, false, hit);
  for (int k = 0; k < n; k++) {
    ylm_scene_surface s;
    if (hit[k].mesh < 0) continue;
    bool back = ylm_dot3(hit[k].normal, ray[k].dir) > 0;
    ylm_scene_place place = {(uint32_t)hit[k].mesh, hit[k].element, hit[k].u, hit[k].v, back};
    v->surfaces(v->scene, 1, &place, &s);
    if (glosses) {
      v->eval(&receiver, 1, (const float(*)[3])ray[k].dir, f3);
      for (int c = 0; c < 3; c++) f3[0][c] *= tint[c];
      a.reflectance =
          (float)(YLM_LUMINANCE_R * (double)f3[0][0] + YLM_LUMINANCE_G * (double)f3[0][1] +
                  YLM_LUMINANCE_B * (double)f3[0][2]);
    }
    double part = cut(&a, &ray[k], &s, hit[k].t, v->normal[i]);
    if (!(part > 0)) continue;
    if (f->n == f->room && !grow(f)) return YLM_ENOMEM;
    f->place[f->n] = place;
    f->point[f->n] = (uint32_t)i;
    for (int c = 0; c < 3; c++) f->factor[f->n][c] = (float)(YLM_PI / n * part) * f3[0][c];
    f->n++;
  }
  return YLM_OK;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t n = (size_t)j->ask->o->compensate;
  ylm_trace_ray *ray = ylm_alloc(n, sizeof *ray);
  ylm_trace_hit *hit = ylm_alloc(n, sizeof *hit);
  ylm_status s = ray && hit ? YLM_OK : YLM_ENOMEM;
  const ylm_many_host *v = j->ask->host;
  for (size_t i = begin; s == YLM_OK && i < end; i++)
    s = meet(j, i, v->stream(v->view, i), ray, hit, &j->blocks[begin / GRAIN]);
  ylm_free(ray);
  ylm_free(hit);
  return s;
}

/* Adds the light of the places that a block found. */
static ylm_status add(const ylm_many_ask *a, uint64_t seed, const found *f, float *out,
                      uint64_t *rays, ylm_error *e) {
  float *room = ylm_alloc_zero(9 * f->n, sizeof *room);
  ylm_path_options o = {.samples = PATHS,
                        .first = 1,
                        .last = a->o->bounces,
                        .seed = seed,
                        .threads = a->o->threads,
                        .progress = a->o->progress};
  ylm_path_sum sum = {0, room, room ? room + 3 * f->n : NULL, room ? room + 6 * f->n : NULL};
  ylm_path_stats stats = {0};
  if (!room) return YLM_ENOMEM;
  const ylm_many_host *v = a->host;
  ylm_status s =
      f->n > 0 ? v->places(v->scene, f->n, f->place, NULL, NULL, v->eye, true, &o, &sum, &stats, e)
               : YLM_OK;
  for (size_t k = 0; s == YLM_OK && k < 3 * f->n; k++)
    out[3 * f->point[k / 3] + k % 3] += f->factor[k / 3][k % 3] * room[k];
  *rays += stats.nearest_rays + stats.shadow_rays + stats.lamp_rays;
  ylm_free(room);
  return s;
}

ylm_status ylm__many_compensate(const ylm_many_ask *a, float *out, uint64_t *rays, ylm_error *e) {
  size_t points = a->host->points, blocks = (points + GRAIN - 1) / GRAIN;
  job j = {a, ylm_alloc_zero(blocks, sizeof *j.blocks)};
  if (!j.blocks) return YLM_ENOMEM;
  ylm_status s =
      ylm_parallel(points, GRAIN, a->o->threads, run, &j, a->o->progress, "compensation");
  for (size_t b = 0; s == YLM_OK && b < blocks; b++)
    s = add(a, a->o->seed + (b << 32), &j.blocks[b], out, rays, e);
  for (size_t b = 0; b < blocks; b++) drop(&j.blocks[b]);
  ylm_free(j.blocks);
  *rays += (uint64_t)points * (uint64_t)a->o->compensate;
  return s;
}
