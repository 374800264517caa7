/*
** path.c - the path tracer beside its own rays: those of a run are recorded and traced again, in the
** same batches, with nothing else to do; once without and once with the looks for lamps along them. Then
** paths with guides, the time of a picture, and paths among so many lamps that all are weighed, or a tree of them is asked.
*/
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <dlfcn.h>
#include <math.h>

#include "bench.h"
#include "ylm_geom.h"
#include "ylm_path.h"

/* Batches of rays: of the camera, nearest hits, occlusion, looks for lamps. */
typedef enum query { INTERSECT, NEAREST, OCCLUDED, LAMPS, QUERIES } query;

typedef struct batch {
  query query;
  size_t n;
  ylm_trace_ray *ray;
} batch;

static struct {
  bool on;
  size_t n, room;
  batch *batch;
  size_t rays[QUERIES];
} record;

static void keep(query q, size_t n, const ylm_trace_ray *rays) {
  if (!record.on || n == 0) return;
  if (record.n == record.room) {
    size_t room = 2 * record.room + 1024;
    batch *more = realloc(record.batch, room * sizeof *more);
    if (!more) exit(1);
    record.batch = more;
    record.room = room;
  }
  ylm_trace_ray *copy = ylm_alloc_copy(rays, n, sizeof *rays);
  if (!copy) exit(1);
  record.batch[record.n++] = (batch){q, n, copy};
  record.rays[q] += n;
}

/* The library's own functions, before which these stand: its calls come here first. */
typedef void hits_fn(const ylm_trace *, size_t, const ylm_trace_ray *, bool, ylm_trace_hit *);
typedef void occluded_fn(const ylm_trace *, size_t, ylm_trace_ray *);
static hits_fn *intersect, *nearest;
static occluded_fn *occluded, *meets_lamps;

void ylm_trace_intersect(const ylm_trace *t, size_t n, const ylm_trace_ray *rays, bool coherent,
                         ylm_trace_hit *hits) {
  keep(INTERSECT, n, rays);
  intersect(t, n, rays, coherent, hits);
}

void ylm_trace_nearest(const ylm_trace *t, size_t n, const ylm_trace_ray *rays, bool coherent,
                       ylm_trace_hit *hits) {
  keep(NEAREST, n, rays);
  nearest(t, n, rays, coherent, hits);
}

void ylm_trace_occluded(const ylm_trace *t, size_t n, ylm_trace_ray *rays) {
  keep(OCCLUDED, n, rays);
  occluded(t, n, rays);
}

void ylm_trace_meets_lamps(const ylm_trace *t, size_t n, ylm_trace_ray *rays) {
  keep(LAMPS, n, rays);
  meets_lamps(t, n, rays);
}

static void find_library(void) {
  *(void **)&intersect = dlsym(RTLD_NEXT, "ylm_trace_intersect");
  *(void **)&nearest = dlsym(RTLD_NEXT, "ylm_trace_nearest");
  *(void **)&occluded = dlsym(RTLD_NEXT, "ylm_trace_occluded");
  *(void **)&meets_lamps = dlsym(RTLD_NEXT, "ylm_trace_meets_lamps");
  if (!intersect || !nearest || !occluded || !meets_lamps) exit(1);
}

/* -- rooms -------------------------------------------------------------------------- */

typedef struct room {
  ylm_scene *scene;
  ylm_mesh *mesh[8];
  ylm_material *material[3];
} room;

static void add_quad(room *r, ylm_scene_mesh *out, int i, const double c[3], const double u[3],
                     const double v[3], int material) {
  if (ylm_mesh_quad(c, u, v, 1, 1, &r->mesh[i], NULL) != YLM_OK) exit(1);
  out[i].material = r->material[material];
}

/* Spheres below the ceiling. */
static void fill_spheres(size_t n, float (*sphere)[4], float (*radiance)[3]) {
  ylm_rng rng;
  ylm_rng_seed(&rng, 1, 1);
  for (size_t i = 0; i < n; i++) {
    for (int a = 0; a < 3; a++)
      sphere[i][a] = (float)(1.8 * ylm_rng_double(&rng) - .9) * (a == 1 ? .1f : 1);
    sphere[i][1] += 1.8f, sphere[i][3] = .004f;
    for (int c = 0; c < 3; c++) radiance[i][c] = (float)(10 * ylm_rng_double(&rng));
  }
}

/* Five walls, open to the camera; in it a knot where `knot`, else a box. Lamps: so many spheres; if 0, one sphere and
   two of a flat one's triangles. */
static void make_room(room *r, bool knot, size_t spheres) {
  static const float colours[3][3] = {{.75f, .75f, .75f}, {.6f, .1f, .1f}, {.1f, .5f, .1f}};
  static const double corner[5][3] = {{-1, 0, 1}, {-1, 2, -1}, {-1, 0, -1}, {-1, 0, 1}, {1, 0, -1}};
  static const double u[5][3] = {{2, 0, 0}, {2, 0, 0}, {2, 0, 0}, {0, 0, -2}, {0, 0, 2}};
  static const double v[5][3] = {{0, 0, -2}, {0, 0, 2}, {0, 2, 0}, {0, 2, 0}, {0, 2, 0}};
  static const float sphere[4] = {.5f, 1.5f, .5f, .1f};
  static const float triangle[18] = {-.3f, 1.99f, -.3f, .3f, 1.99f, -.3f, .3f,  1.99f, .3f,
                                     -.3f, 1.99f, -.3f, .3f, 1.99f, .3f,  -.3f, 1.99f, .3f};
  static const float radiance[9] = {10, 8, 6, 8, 8, 8, 8, 8, 8};
  ylm_scene_mesh mesh[6] = {0};
  ylm_scene_lamps lamps = {.shape = {1, 2, 0, sphere, triangle, NULL}, .radiance = radiance};
  float(*many)[4] = ylm_alloc(spheres, sizeof *many), (*lit)[3] = ylm_alloc(spheres, sizeof *lit);
  if (!many || !lit) exit(1);
  fill_spheres(spheres, many, lit);
  if (spheres > 0)
    lamps = (ylm_scene_lamps){.shape = {spheres, 0, 0, many[0], NULL, NULL}, .radiance = lit[0]};
  *r = (room){0};
  for (int i = 0; i < 3; i++)
    if (ylm_material_create(0, 3, colours[i], &r->material[i], NULL) != YLM_OK) exit(1);
  for (int i = 0; i < 5; i++) add_quad(r, mesh, i, corner[i], u[i], v[i], i < 3 ? 0 : i - 2);
  ylm_status s =
      knot ? ylm_mesh_knot(2, 3, .35, .14, .06, 600, 100, &r->mesh[5], NULL)
           : ylm_mesh_box((double[]){.2, 0, -.2}, (double[]){.7, .8, .3}, 1, &r->mesh[5], NULL);
  if (s != YLM_OK) exit(1);
  for (size_t i = 0; knot && i < r->mesh[5]->vertices; i++) r->mesh[5]->position[3 * i + 1] += .6f;
  mesh[5].material = r->material[0];
  for (int i = 0; i < 6; i++) {
    const ylm_mesh *m = r->mesh[i];
    mesh[i].positions = m->position;
    mesh[i].normals = m->normal;
    mesh[i].vertices = m->vertices;
    mesh[i].triangles = m->index;
    mesh[i].count = m->triangles;
    mesh[i].occludes = true;
  }
  if (ylm_scene_create(6, mesh, &lamps, &r->scene, NULL) != YLM_OK) exit(1);
  ylm_free(many), ylm_free(lit);
}

static void free_room(room *r) {
  ylm_scene_free(r->scene);
  for (int i = 0; i < 8; i++) ylm_mesh_free(r->mesh[i]);
  for (int i = 0; i < 3; i++) ylm_material_free(r->material[i]);
}

/* -- measurements --------------------------------------------------------------------- */

typedef struct job {
  const ylm_scene *scene;
  int width, height, samples, threads;
  float *data;
  ylm_path_stats stats;
  ylm_trace_hit *hit;
  ylm_trace_ray *copy;
  bool looks;            /* for lamps, too */
  ylm_path_guides *kept; /* NULL: paths have no guides */
} job;

static void paths(void *context) {
  job *j = context;
  static const ylm_camera camera = {
      .from = {0, 1, 2.9}, .at = {0, 1, 0}, .up = {0, 1, 0}, .fov = 45};
  static const float black[3] = {0, 0, 0};
  size_t n = 3 * (size_t)j->width * (size_t)j->height;
  ylm_path_options o = {.samples = j->samples, .last = -1, .seed = 1, .threads = j->threads};
  o.guides = j->kept != NULL, o.kept = j->kept;
  ylm_path_sum sum = {0, j->data, j->data + n, j->data + 2 * n};
  if (ylm_path_image(j->scene, &camera, j->width, j->height, black, &o, &sum, &j->stats, NULL) !=
      YLM_OK)
    exit(1);
}

/* The recorded batches again. */
static void bare(void *context) {
  job *j = context;
  const ylm_trace *t = ylm_scene_trace(j->scene);
  for (size_t i = 0; i < record.n; i++) {
    const batch *b = &record.batch[i];
    if (b->query == INTERSECT) intersect(t, b->n, b->ray, true, j->hit);
    if (b->query == NEAREST) nearest(t, b->n, b->ray, false, j->hit);
    if (b->query < OCCLUDED || (b->query == LAMPS && !j->looks)) continue;
    memcpy(j->copy, b->ray, b->n * sizeof *j->copy);
    (b->query == LAMPS ? meets_lamps : occluded)(t, b->n, j->copy);
  }
}

static void forget(void) {
  for (size_t i = 0; i < record.n; i++) ylm_free(record.batch[i].ray);
  record.n = 0;
  memset(record.rays, 0, sizeof record.rays);
}

/* Paths by guides that a first run has learnt. */
static void measure_guided(job *j) {
  if (!(j->kept = ylm_path_guides_create())) exit(1);
  paths(j);
  double learnt = j->stats.seconds, seconds = bench_seconds(paths, j);
  double camera = (double)j->width * j->height * j->samples;
  double rays = camera + (double)(j->stats.nearest_rays + j->stats.shadow_rays);
  printf("  with guides %6.2f M rays/s, %.2f us a path; %zu clusters, learnt in %.2f s\n",
         rays / seconds * 1e-6, seconds / camera * 1e6, j->stats.clusters, learnt - seconds);
  ylm_path_guides_free(j->kept);
  j->kept = NULL;
}

static void measure(const char *name, bool knot) {
  room r;
  make_room(&r, knot, 0);
  job j = {.scene = r.scene, .width = 160, .height = 90, .samples = 32, .threads = 1};
  j.data = ylm_alloc(9 * 320 * 180, sizeof *j.data);
  j.hit = ylm_alloc(4096, sizeof *j.hit);
  j.copy = ylm_alloc(4096, sizeof *j.copy);
  if (!j.data || !j.hit || !j.copy) exit(1);
  record.on = true;
  paths(&j);
  record.on = false;
  double ours = bench_seconds(paths, &j), alone = bench_seconds(bare, &j), looking;
  j.looks = true;
  looking = bench_seconds(bare, &j);
  double rays = (double)(record.rays[INTERSECT] + record.rays[NEAREST] + record.rays[OCCLUDED]);
  printf("%s: %zu camera, %zu nearest, %zu occlusion rays\n", name, record.rays[INTERSECT],
         record.rays[NEAREST], record.rays[OCCLUDED]);
  printf("  paths %6.2f M rays/s, the same rays alone %6.2f: %.2f of their rate; one thread\n",
         rays / ours * 1e-6, rays / alone * 1e-6, alone / ours);
  printf("  with %zu looks for lamps along them %6.2f M rays/s: %.2f of their rate\n",
         record.rays[LAMPS], rays / looking * 1e-6, looking / ours);
  measure_guided(&j);
  if (!bench_is_quick()) {
    j.width = 320, j.height = 180, j.samples = 256, j.threads = 2;
    double start = ylm_seconds();
    paths(&j);
    printf("  320 x 180, 256 samples, all bounces: %.1f s by two threads (%.1f M paths/s)\n",
           ylm_seconds() - start, (double)j.stats.paths / j.stats.seconds * 1e-6);
  }
  forget();
  free_room(&r);
  ylm_free(j.data), ylm_free(j.hit), ylm_free(j.copy);
}

/* One run, of 57,600 paths. */
static void measure_many(size_t spheres) {
  room r;
  make_room(&r, false, spheres);
  job j = {.scene = r.scene, .width = 80, .height = 45, .samples = 16, .threads = 1};
  j.data = ylm_alloc(9 * 80 * 45, sizeof *j.data);
  if (!j.data) exit(1);
  double start = bench_cpu();
  paths(&j);
  double seconds = bench_cpu() - start;
  uint64_t rays = j.stats.nearest_rays + j.stats.shadow_rays;
  printf("a room with a box and %zu lamps: %.2f s, %llu rays, %.2f M rays/s; one thread\n", spheres,
         seconds, (unsigned long long)rays, (double)rays / seconds * 1e-6);
  free_room(&r);
  ylm_free(j.data);
}

int main(void) {
  find_library();
  measure("a room with a box, 22 triangles", false);
  measure("a room with a knot, 120,010 triangles", true);
  measure_many(4000);
  measure_many(5000);
  free(record.batch);
  return 0;
}
