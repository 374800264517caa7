/* places.c - paths that begin at places of surfaces which an eye sees. */
#include "path.h"

#define PLACES 0x706c61636573u /* random numbers that no path has */

/* The ray that finds a place from where it is seen, and its hit. */
static void find(const path_job *j, const ylm_scene_place *p, ylm_trace_ray *ray,
                 ylm_trace_hit *hit) {
  ylm_scene_surface at;
  ylm_scene_surfaces(j->scene, 1, p, &at);
  for (int a = 0; a < 3; a++) {
    ray->org[a] = (float)j->eye[a];
    ray->dir[a] = (float)((double)at.position[a] - j->eye[a]);
  }
  *hit = (ylm_trace_hit){.mesh = (int32_t)p->mesh, .element = p->element, .u = p->u, .v = p->v};
  for (int a = 0; a < 3; a++) hit->normal[a] = p->back ? ray->dir[a] : -ray->dir[a];
}

/* The places of the samples of a batch. Which of them are at which place is chosen anew for each batch, so
   that no place has the same strata of light twice. */
static void choose(const path_job *j, uint64_t item, uint64_t batch, size_t place[YLM_PATH_BATCH]) {
  size_t first = j->first ? j->first[item] : item, n = j->first ? j->first[item + 1] - first : 1;
  ylm_rng rng;
  double total = 0, shift, sum = 0;
  for (size_t k = 0; k < YLM_PATH_BATCH; k++) place[k] = first;
  if (n == 1) return;
  ylm_rng_seed(&rng, j->o->seed ^ PLACES, item << 24 ^ batch);
  shift = ylm_rng_double(&rng);
  size_t step = 2 * (size_t)(ylm_rng_double(&rng) * YLM_PATH_BATCH / 2) + 1;
  size_t start = (size_t)(ylm_rng_double(&rng) * YLM_PATH_BATCH), p = 0;
  for (size_t i = 0; i < n; i++) total += (double)j->weight[first + i];
  sum = (double)j->weight[first];
  for (size_t k = 0; k < YLM_PATH_BATCH; k++) {
    while (p + 1 < n && ((double)k + shift) / YLM_PATH_BATCH * total >= sum)
      sum += (double)j->weight[first + ++p];
    place[(k * step + start) % YLM_PATH_BATCH] = first + p;
  }
}

static void begin(path_tile *t) {
  size_t place[YLM_PATH_BATCH];
  t->rays.n = t->pairs * YLM_PATH_BATCH;
  for (size_t i = 0; i < t->rays.n; i++) {
    path_state *p = &t->path[i];
    size_t k = i % YLM_PATH_BATCH, pair = i / YLM_PATH_BATCH;
    if (k == 0) choose(t->job, t->item[pair], t->batch[pair], place);
    find(t->job, &t->job->places[place[k]], &t->rays.ray[i], &t->rays.hit[i]);
    t->rays.of[i] = (uint32_t)i;
    for (int c = 0; c < 3; c++) p->throughput[c] = 1, p->radiance[c] = 0;
  }
}

ylm_status ylm_path_places(const ylm_scene *scene, size_t n, const ylm_scene_place *places,
                           const size_t *first, const float *weight, const double eye[3],
                           bool shadows, const ylm_path_options *o, ylm_path_sum *sum,
                           ylm_path_stats *stats, ylm_error *e) {
  static const path_kind kind = {"places", begin, ylm__path_mean};
  path_job j = {.kind = &kind,
                .scene = scene,
                .o = o,
                .items = n,
                .values = 3,
                .batches_per_tile = 1,
                .places = places,
                .first = first,
                .weight = weight,
                .eye = {eye[0], eye[1], eye[2]},
                .open = !shadows};
  return ylm__path_run(&j, sum, stats, e);
}
