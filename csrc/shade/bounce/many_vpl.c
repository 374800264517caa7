/* many_vpl.c - what a bound takes from virtual points, found by rays (Kollig & Keller 2004). */
#include <math.h>
#include <string.h>

#include "many_gloss.h"
#include "ylm_list.h"

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
  const ylm_shade_view *view;
  const gather_ask *ask;
  const gather_gloss *gloss;
  found *blocks;
} job;

static bool grow(found *f) {
  size_t room = ylm_list_room(f->room, f->n + 1);
  bool grown = ylm_list_resize(&f->place, f->n, room, sizeof *f->place) &&
               ylm_list_resize(&f->point, f->n, room, sizeof *f->point) &&
               ylm_list_resize(&f->factor, f->n, room, sizeof *f->factor);
  if (grown) f->room = room;
  return grown;
}

static void drop(found *f) {
  ylm_free(f->place);
  ylm_free(f->point);
  ylm_free(f->factor);
}

/* The part of the light of a hit that the bound cuts. */
static double cut(const gather_ask *a, const ylm_trace_ray *ray, const ylm_scene_surface *s,
                  float t, const float N[3]) {
  float facing = -ylm_dot3(s->normal, ray->dir);
  if (!(facing > 0)) facing = -ylm_dot3(s->flat, ray->dir);
  double d2 = (double)t * (double)t, g = (double)ylm_dot3(N, ray->dir) * (double)facing / d2;
  return g > 0 && d2 > 0 ? 1 - ylm__gather_bound(a, g, d2) / g : 0;
}

static ylm_status meet(const job *j, size_t i, uint64_t stream, ylm_trace_ray *ray,
                       ylm_trace_hit *hit, found *f) {
  const ylm_shade_view *v = j->view;
  gather_ask a = *j->ask;
  int n = a.o->compensate;
  bool glosses = ylm__gather_glosses(j->gloss, v, i);
  gather_receiver receiver;
  float albedo[3], x[3], y[3], tint[3] = {1, 1, 1}, f3[1][3] = {{1, 1, 1}};
  ylm_rng rng;
  ylm__shade_albedo(v, i, albedo);
  a.reflectance =
      (float)((YLM_LUMINANCE_R * (double)albedo[0] + YLM_LUMINANCE_G * (double)albedo[1] +
               YLM_LUMINANCE_B * (double)albedo[2]) /
              YLM_PI);
  if (glosses) {
    ylm__shade_tint(v, i, 1, tint);
    (void)ylm__gather_receive(j->gloss, v, i, NULL, &receiver); /* without tables it cannot fail */
  }
  ylm_rng_seed(&rng, ~a.o->seed, stream);
  ylm_scene_basis(v->normal[i], x, y);
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
  ylm_trace_nearest(ylm_scene_trace(v->scene), (size_t)n, ray, false, hit);
  for (int k = 0; k < n; k++) {
    ylm_scene_surface s;
    if (hit[k].mesh < 0) continue;
    bool back = ylm_dot3(hit[k].normal, ray[k].dir) > 0;
    ylm_scene_place place = {(uint32_t)hit[k].mesh, hit[k].element, hit[k].u, hit[k].v, back};
    ylm_scene_surfaces(v->scene, 1, &place, &s);
    if (glosses) {
      ylm__gather_eval(&receiver, 1, (const float(*)[3])ray[k].dir, f3);
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
  shade_stream at = ylm__shade_stream_at(j->view, begin);
  for (size_t i = begin; s == YLM_OK && i < end; i++)
    s = meet(j, i, ylm__shade_stream_next(j->view, &at), ray, hit, &j->blocks[begin / GRAIN]);
  ylm_free(ray);
  ylm_free(hit);
  return s;
}

/* Adds the light of the places that a block found. */
static ylm_status add(const ylm_shade_view *v, const gather_ask *a, uint64_t seed, const found *f,
                      float *out, uint64_t *rays, ylm_error *e) {
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
  ylm_status s = f->n > 0 ? ylm_path_places(v->scene, f->n, f->place, NULL, NULL, v->frame.from,
                                            true, &o, &sum, &stats, e)
                          : YLM_OK;
  for (size_t k = 0; s == YLM_OK && k < 3 * f->n; k++)
    out[3 * f->point[k / 3] + k % 3] += f->factor[k / 3][k % 3] * room[k];
  *rays += stats.nearest_rays + stats.shadow_rays + stats.lamp_rays;
  ylm_free(room);
  return s;
}

ylm_status ylm__gather_compensate(const ylm_shade_view *v, const gather_ask *a,
                                  const gather_gloss *gloss, float *out, uint64_t *rays,
                                  ylm_error *e) {
  size_t blocks = (v->points + GRAIN - 1) / GRAIN;
  job j = {v, a, gloss, ylm_alloc_zero(blocks, sizeof *j.blocks)};
  if (!j.blocks) return YLM_ENOMEM;
  ylm_status s =
      ylm_parallel(v->points, GRAIN, a->o->threads, run, &j, a->o->progress, "compensation");
  for (size_t b = 0; s == YLM_OK && b < blocks; b++)
    s = add(v, a, a->o->seed + (b << 32), &j.blocks[b], out, rays, e);
  for (size_t b = 0; b < blocks; b++) drop(&j.blocks[b]);
  ylm_free(j.blocks);
  *rays += (uint64_t)v->points * (uint64_t)a->o->compensate;
  return s;
}
