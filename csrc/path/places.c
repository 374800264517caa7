/* places.c - paths that begin at places of surfaces which an eye sees. */
#include "path.h"

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

static void begin(path_tile *t) {
  t->rays.n = t->pairs * YLM_PATH_BATCH;
  for (size_t i = 0; i < t->rays.n; i++) {
    path_state *p = &t->path[i];
    find(t->job, &t->job->places[t->item[i / YLM_PATH_BATCH]], &t->rays.ray[i], &t->rays.hit[i]);
    t->rays.of[i] = (uint32_t)i;
    for (int c = 0; c < 3; c++) p->throughput[c] = 1, p->radiance[c] = 0;
  }
}

ylm_status ylm_path_places(const ylm_scene *scene, size_t n, const ylm_scene_place *places,
                           const double eye[3], bool shadows, const ylm_path_options *o,
                           ylm_path_sum *sum, ylm_path_stats *stats, ylm_error *e) {
  static const path_kind kind = {"places", begin, ylm__path_mean};
  path_job j = {.kind = &kind,
                .scene = scene,
                .o = o,
                .items = n,
                .values = 3,
                .batches_per_tile = 1,
                .places = places,
                .eye = {eye[0], eye[1], eye[2]},
                .open = !shadows};
  return ylm__path_run(&j, sum, stats, e);
}
