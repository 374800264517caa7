/* raycast.c - light from the lamps themselves, by sampling their solid angles. */
#include <math.h>
#include <stdatomic.h>

#include "calibration.h"
#include "view.h"
#include "ylm_path.h"

typedef struct job {
  const ylm_shade_view *view;
  const ylm_scene *lit;
  int light_samples;
  bool shadows;
  uint64_t seed;
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
  ylm_scene_batch_aim(&w->lit, j->view->origin[i], j->view->normal[i], j->light_samples, &rng);
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
    if (is_matte(j, i)) aim(j, &w, i, stream);
  }
  if (status == YLM_OK) finish(j, &w);
  ylm_scene_batch_free(&w.lit);
  atomic_fetch_add_explicit(&j->rays, w.lit.traced, memory_order_relaxed);
  return status;
}

/* The points that are of other materials; their number. */
static size_t list_glossy(const job *j, size_t *point) {
  size_t n = 0;
  for (size_t i = 0; i < j->view->points; i++)
    if (!is_matte(j, i)) point[n++] = i;
  return n;
}

/* Points that are lit together: those of one pixel and mesh, which are parts of one highlight. */
typedef struct items {
  size_t n;
  size_t *first;          /* [points+1] of each item's points in `order` */
  size_t *order;          /* [points] their places in the list             */
  ylm_scene_place *place; /* [points] in that order */
  float *weight;          /* [points]               */
} items;

static void items_free(items *x) {
  ylm_free(x->first);
  ylm_free(x->order);
  ylm_free(x->place);
  ylm_free(x->weight);
}

static bool items_create(items *x, size_t n) {
  *x = (items){.first = ylm_alloc(n + 1, sizeof *x->first),
               .order = ylm_alloc(n, sizeof *x->order),
               .place = ylm_alloc(n, sizeof *x->place),
               .weight = ylm_alloc(n, sizeof *x->weight)};
  return x->first && x->order && x->place && x->weight;
}

/* Lists the points list[from] .. list[behind-1], of one pixel, mesh by mesh. */
static void gather(const ylm_shade_view *v, const size_t *list, size_t from, size_t behind,
                   items *x) {
  size_t end = from;
  for (size_t i = from; i < behind; i++) {
    uint32_t mesh = v->entry[list[i]].at.mesh;
    bool known = false;
    for (size_t k = from; v->o.share > 0 && k < i && !known; k++)
      known = v->entry[list[k]].at.mesh == mesh;
    if (known) continue;
    x->first[x->n++] = end;
    for (size_t k = i; k < (v->o.share > 0 ? behind : i + 1); k++)
      if (v->entry[list[k]].at.mesh == mesh) {
        x->place[end] = v->entry[list[k]].at;
        x->weight[end] = v->entry[list[k]].weight;
        x->order[end++] = k;
      }
  }
}

/* The items of n listed points. */
static void list_items(const ylm_shade_view *v, size_t n, const size_t *list, items *x) {
  for (size_t i = 0, behind, pixel = 0; i < n; i = behind) {
    while (v->pixel[pixel + 1].first <= list[i]) pixel++;
    for (behind = i + 1; behind < n && list[behind] < v->pixel[pixel + 1].first;) behind++;
    gather(v, list, i, behind, x);
  }
  x->first[x->n] = n;
}

/* Radiance of items, with its variance: room [9 n] zeros, mean [n][3] first, variance [n][3] last. */
static ylm_status cast_items(const ylm_shade_view *v, const shade_cast *c, int light_samples,
                             const items *x, float *room, uint64_t *rays) {
  ylm_path_options o = {.samples = light_samples,
                        .first = 1,
                        .last = 1,
                        .seed = c->seed,
                        .threads = c->threads,
                        .progress = c->progress};
  ylm_path_stats stats = {0};
  ylm_path_sum sum = {0, room, room + 3 * x->n, room + 6 * x->n};
  bool single = x->first[x->n] == x->n;
  ylm_status s =
      ylm_path_places(c->lit ? c->lit : v->scene, x->n, x->place, single ? NULL : x->first,
                      x->weight, v->frame.from, c->shadows, &o, &sum, &stats, NULL);
  *rays += stats.nearest_rays + stats.shadow_rays;
  return s;
}

/* Some of the items, spread evenly over all; `out` has room for all. */
static void pick(const items *all, size_t n, items *out) {
  size_t end = 0;
  for (out->n = 0; out->n < n; out->n++) {
    size_t i = (size_t)(((double)out->n + 0.5) / (double)n * (double)all->n);
    out->first[out->n] = end;
    for (size_t k = all->first[i]; k < all->first[i + 1]; k++, end++) {
      out->place[end] = all->place[k];
      out->weight[end] = all->weight[k];
    }
  }
  out->first[n] = end;
}

/* The number of samples that leave c->noise, from c->light_samples to c->most; what noise that is. */
static ylm_status choose_samples(const ylm_shade_view *v, shade_cast *c, const items *all,
                                 uint64_t *rays) {
  size_t n = all->n < NOISE_TRIALS ? all->n : NOISE_TRIALS;
  items some;
  float *room = ylm_alloc_zero(9 * n, sizeof *room);
  shade_cast trial = *c;
  double square = 0, variance = 0;
  trial.seed = ~c->seed;
  trial.progress = NULL;
  ylm_status s = items_create(&some, all->first[all->n]) && room ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) pick(all, n, &some);
  if (s == YLM_OK) s = cast_items(v, &trial, NOISE_TRIAL_SAMPLES, &some, room, rays);
  for (size_t i = 0; s == YLM_OK && i < 3 * n; i++) {
    square += (double)room[i] * (double)room[i];
    variance += (double)room[6 * n + i];
  }
  if (s == YLM_OK && square > variance) {
    double one = variance * NOISE_TRIAL_SAMPLES / (square - variance); /* of one sample */
    double wanted = ceil(one / (c->noise * c->noise) / YLM_PATH_BATCH) * YLM_PATH_BATCH;
    c->light_samples = (int)fmin(fmax(c->light_samples, wanted), c->most);
    c->noise = sqrt(one / c->light_samples);
  } else
    c->noise = 0;
  items_free(&some);
  ylm_free(room);
  return s;
}

ylm_status ylm__shade_cast(const ylm_shade_view *v, shade_cast *c, size_t n, const size_t *point,
                           float *out, uint64_t *rays) {
  items x;
  float *room = ylm_alloc_zero(9 * n, sizeof *room);
  ylm_status s = items_create(&x, n) && room ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && n > 0 && v->corner) s = YLM_EINVAL;
  if (s == YLM_OK) list_items(v, n, point, &x);
  if (s == YLM_OK && n > 0 && c->noise > 0) s = choose_samples(v, c, &x, rays);
  if (s == YLM_OK && n > 0) s = cast_items(v, c, c->light_samples, &x, room, rays);
  for (size_t i = 0; s == YLM_OK && i < x.n; i++)
    for (size_t k = x.first[i]; k < x.first[i + 1]; k++)
      for (size_t a = 0; a < 3; a++) out[3 * x.order[k] + a] = room[3 * i + a];
  items_free(&x);
  ylm_free(room);
  return s;
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
           .out = out};
  ylm_status s = ylm_parallel(v->points, SHADE_CAST_GRAIN, threads, run, &j, progress, "raycast");
  uint64_t all = j.rays;
  if (s == YLM_OK) s = cast_glossy(&j, threads, progress, &all);
  if (rays) *rays = all;
  return s;
}
