/*
** green.c - transfer vectors with bounces beside the loops of Green 2003 and Sloan et al. 2002: shadow rays from
** every vertex, then for every bounce a ray again through each direction that was in shadow, and there the vectors
** of three corners. And transfer matrices beside a sum of all products of basis functions for every ray. The loops
** stand here as they are described, in scalar double; their rays are Embree's, one at a time.
*/
#include <math.h>

#include "bench.h"
#include "ylm_geom.h"
#include "ylm_sh.h"
#include "ylm_transfer.h"

enum { LMAX = 4, COUNT = 25, WIDE = 3 * COUNT, BOUNCES = 3, SOME = 256, MATRICES = 8 };

/* The vertices of all meshes, one after the other. */
typedef struct world {
  ylm_scene *scene;
  size_t n;
  float (*position)[3], (*normal)[3], (*origin)[3];
  double (*albedo)[3];
  size_t first[7];
  const ylm_mesh *mesh[6];
  int meshes;
} world;

static void must(bool good) {
  if (good) return;
  fprintf(stderr, "green: no memory, or no scene\n");
  exit(1);
}

/* -- as it is described ---------------------------------------------------------------- */

/* A direction of the sphere that all vertices share, with the basis there. */
typedef struct sample {
  double direction[3], y[COUNT];
} sample;

typedef struct green {
  const world *w;
  int samples;
  sample *sample;
  uint8_t *self; /* [n][samples] the ray hits the scene */
  double *buffer[BOUNCES + 1], rays;
} green;

/* Jittered on a square grid. */
static void make_samples(green *g, int side) {
  ylm_rng r;
  ylm_rng_seed(&r, 11, 1);
  g->samples = side * side;
  for (int i = 0; i < g->samples; i++) {
    double x = (i / side + ylm_rng_double(&r)) / side, y = (i % side + ylm_rng_double(&r)) / side;
    double z = 1 - 2 * x, s = sqrt(1 - z * z),
           d[3] = {s * cos(2 * YLM_PI * y), s * sin(2 * YLM_PI * y), z};
    memcpy(g->sample[i].direction, d, sizeof d);
    must(ylm_sh_eval(LMAX, 0, false, YLM_DOUBLE, 1, d, g->sample[i].y, NULL, NULL, 1, NULL) ==
         YLM_OK);
  }
}

static ylm_trace_ray ray_of(const green *g, size_t v, int s) {
  ylm_trace_ray ray = {.far = INFINITY};
  for (int a = 0; a < 3; a++) {
    ray.org[a] = g->w->origin[v][a];
    ray.dir[a] = (float)g->sample[s].direction[a];
  }
  return ray;
}

static double cosine(const green *g, size_t v, int s) {
  const double *d = g->sample[s].direction;
  const float *n = g->w->normal[v];
  return d[0] * (double)n[0] + d[1] * (double)n[1] + d[2] * (double)n[2];
}

static void green_direct(green *g) {
  const ylm_trace *trace = ylm_scene_trace(g->w->scene);
  for (size_t v = 0; v < g->w->n; v++) {
    double *out = g->buffer[0] + v * WIDE;
    for (int s = 0; s < g->samples; s++) {
      double h = cosine(g, v, s);
      g->self[v * (size_t)g->samples + (size_t)s] = 0;
      if (!(h > 0)) continue;
      ylm_trace_ray ray = ray_of(g, v, s);
      ylm_trace_occluded(trace, 1, &ray);
      g->rays++;
      if (ray.far < 0) {
        g->self[v * (size_t)g->samples + (size_t)s] = 1;
        continue;
      }
      for (int k = 0; k < COUNT; k++) {
        double value = h * g->sample[s].y[k];
        out[k] += g->w->albedo[v][0] * value;
        out[COUNT + k] += g->w->albedo[v][1] * value;
        out[2 * COUNT + k] += g->w->albedo[v][2] * value;
      }
    }
    for (int k = 0; k < WIDE; k++) out[k] *= 4 * YLM_PI / g->samples;
  }
}

static void green_bounce(green *g, const double *before, double *after) {
  const ylm_trace *trace = ylm_scene_trace(g->w->scene);
  double sh[WIDE];
  for (size_t v = 0; v < g->w->n; v++) {
    double *out = after + v * WIDE;
    for (int s = 0; s < g->samples; s++) {
      if (!g->self[v * (size_t)g->samples + (size_t)s]) continue;
      double h = cosine(g, v, s);
      ylm_trace_ray ray = ray_of(g, v, s);
      ylm_trace_hit hit;
      ylm_trace_nearest(trace, 1, &ray, false, &hit);
      g->rays++;
      if (hit.mesh < 0) continue;
      const uint32_t *t = g->w->mesh[hit.mesh]->index + 3 * hit.element;
      const double *corner[3];
      for (int k = 0; k < 3; k++) corner[k] = before + (g->w->first[hit.mesh] + t[k]) * WIDE;
      double b = (double)hit.u, c = (double)hit.v, a = 1 - b - c;
      for (int k = 0; k < WIDE; k++) sh[k] = a * corner[0][k] + b * corner[1][k] + c * corner[2][k];
      for (int k = 0; k < COUNT; k++) {
        out[k] += g->w->albedo[v][0] / YLM_PI * h * sh[k];
        out[COUNT + k] += g->w->albedo[v][1] / YLM_PI * h * sh[COUNT + k];
        out[2 * COUNT + k] += g->w->albedo[v][2] / YLM_PI * h * sh[2 * COUNT + k];
      }
    }
    for (int k = 0; k < WIDE; k++) out[k] *= 4 * YLM_PI / g->samples;
  }
}

/* All bounces into buffer 0; seconds of this thread. */
static double green_run(green *g) {
  double begun = bench_cpu();
  green_direct(g);
  for (int b = 1; b <= BOUNCES; b++) green_bounce(g, g->buffer[b - 1], g->buffer[b]);
  for (int b = 1; b <= BOUNCES; b++)
    for (size_t i = 0; i < g->w->n * WIDE; i++) g->buffer[0][i] += g->buffer[b][i];
  return bench_cpu() - begun;
}

static void green_free(green *g) {
  ylm_free(g->sample);
  ylm_free(g->self);
  for (int b = 0; b <= BOUNCES; b++) ylm_free(g->buffer[b]);
}

static void green_create(green *g, const world *w, int side) {
  *g = (green){.w = w, .sample = ylm_alloc((size_t)(side * side), sizeof *g->sample)};
  g->self = ylm_alloc_zero(w->n, (size_t)(side * side));
  must(g->sample && g->self);
  for (int b = 0; b <= BOUNCES; b++) {
    g->buffer[b] = ylm_alloc_zero(w->n, WIDE * sizeof(double));
    must(g->buffer[b]);
  }
  make_samples(g, side);
}

/* -- ours --------------------------------------------------------------------------------- */

typedef struct ours {
  ylm_transfer *t;
  float *vectors, *out; /* of elements; [n][3][count] of vertices */
  double links, solve, places, all;
} ours;

static const uint8_t front[6] = {YLM_TRANSFER_FRONT, YLM_TRANSFER_FRONT, YLM_TRANSFER_FRONT,
                                 YLM_TRANSFER_FRONT, YLM_TRANSFER_FRONT, YLM_TRANSFER_FRONT};

/* From a scene to vectors with all bounces, by a clock: at n places by links of theirs, or (links 0) at the vertices by the
   elements around them. */
static void ours_run(const world *w, ours *o, int of_element, int links, int threads, size_t n,
                     const float (*origin)[3], const float (*normal)[3], double (*clock)(void)) {
  ylm_transfer_form form = {.spacing = 100,
                            .links = of_element,
                            .lmax = LMAX,
                            .mesh_sides = front,
                            .seed = 1,
                            .threads = threads};
  double begun = clock();
  must(ylm_transfer_create(w->scene, &form, &o->t, NULL) == YLM_OK);
  o->links = clock() - begun;
  o->vectors = ylm_alloc(ylm_transfer_count(o->t) + 1, ylm_transfer_width(o->t) * sizeof(float));
  o->out = ylm_alloc(n, WIDE * sizeof(float));
  must(o->vectors && o->out);
  double then = clock();
  must(ylm_transfer_vectors(o->t, links ? BOUNCES - 1 : BOUNCES, 1e-3, false, threads, NULL, NULL,
                            o->vectors, NULL) == YLM_OK);
  o->solve = clock() - then;
  then = clock();
  if (links)
    must(ylm_transfer_vectors_at(o->t, o->vectors, n, origin, normal, NULL, links, 2, threads, NULL,
                                 o->out, NULL) == YLM_OK);
  for (int m = 0; !links && m < w->meshes; m++)
    must(ylm_transfer_vectors_of(o->t, o->vectors, (size_t)m, o->out + w->first[m] * WIDE) ==
         YLM_OK);
  o->places = clock() - then;
  o->all = clock() - begun;
}

static void ours_free(ours *o) {
  ylm_transfer_free(o->t);
  ylm_free(o->vectors);
  ylm_free(o->out);
}

/* -- the scene: a knot in a court under the sky ----------------------------------------------- */

static void add(world *w, ylm_scene_mesh *m, ylm_mesh *mesh, const float albedo[3]) {
  ylm_material *matte = NULL;
  must(ylm_material_create(0, 3, albedo, &matte, NULL) == YLM_OK);
  m[w->meshes] = (ylm_scene_mesh){.positions = mesh->position,
                                  .normals = mesh->normal,
                                  .vertices = mesh->vertices,
                                  .triangles = mesh->index,
                                  .count = mesh->triangles,
                                  .material = matte,
                                  .occludes = true};
  w->mesh[w->meshes++] = mesh;
  w->first[w->meshes] = w->first[w->meshes - 1] + mesh->vertices;
}

static void make_world(world *w, int along, int across, int wall) {
  static const double quad[5][3][3] = {{{-4, -4, -1.2}, {8, 0, 0}, {0, 8, 0}},
                                       {{-4, -4, -1.2}, {0, 8, 0}, {0, 0, 4}},
                                       {{4, -4, -1.2}, {0, 0, 4}, {0, 8, 0}},
                                       {{-4, -4, -1.2}, {0, 0, 4}, {8, 0, 0}},
                                       {{-4, 4, -1.2}, {8, 0, 0}, {0, 0, 4}}};
  static const float colour[6][3] = {{0.7f, 0.5f, 0.3f},    {0.6f, 0.6f, 0.75f},
                                     {0.8f, 0.2f, 0.2f},    {0.2f, 0.7f, 0.2f},
                                     {0.75f, 0.75f, 0.75f}, {0.75f, 0.75f, 0.75f}};
  ylm_mesh *shape = NULL;
  ylm_scene_mesh mesh[6];
  *w = (world){0};
  must(ylm_mesh_knot(2, 3, 2, 0.8, 0.35, along, across, &shape, NULL) == YLM_OK);
  add(w, mesh, shape, colour[0]);
  for (int i = 0; i < 5; i++) {
    must(ylm_mesh_quad(quad[i][0], quad[i][1], quad[i][2], wall, wall, &shape, NULL) == YLM_OK);
    add(w, mesh, shape, colour[i + 1]);
  }
  ylm_scene_lamps none = {0};
  must(ylm_scene_create(6, mesh, &none, &w->scene, NULL) == YLM_OK);
  w->n = w->first[6];
  w->position = ylm_alloc(w->n, 12), w->normal = ylm_alloc(w->n, 12);
  w->origin = ylm_alloc(w->n, 12), w->albedo = ylm_alloc(w->n, sizeof *w->albedo);
  must(w->position && w->normal && w->origin && w->albedo);
  const ylm_trace *trace = ylm_scene_trace(w->scene);
  for (int m = 0; m < 6; m++)
    for (size_t i = w->first[m]; i < w->first[m + 1]; i++)
      for (size_t a = 0; a < 3; a++) {
        size_t at = 3 * (i - w->first[m]) + a;
        w->normal[i][a] = w->mesh[m]->normal[at];
        w->position[i][a] = w->mesh[m]->position[at];
        w->albedo[i][a] = (double)colour[m][a];
      }
  for (size_t i = 0; i < w->n; i++)
    for (int a = 0; a < 3; a++)
      w->origin[i][a] =
          w->position[i][a] + 4 * ylm_trace_offset(trace, w->position[i]) * w->normal[i][a];
}

/* -- comparisons --------------------------------------------------------------------------------- */

/* Root mean square of a vertex's error over that of its vector, at `n` vertices of the knot `step` apart. */
static double error_of(const float *truth, size_t n, size_t step, const float *f, const double *d,
                       double (*albedo)[3]) {
  double off = 0, size = 0;
  for (size_t i = 0; i < n; i++)
    for (size_t k = 0; k < WIDE; k++) {
      double x =
          f ? (double)f[i * step * WIDE + k] : d[i * step * WIDE + k] / albedo[i * step][k / COUNT];
      off += pow(x - (double)truth[i * WIDE + k], 2);
      size += pow((double)truth[i * WIDE + k], 2);
    }
  return sqrt(off / size);
}

static void truth_of(const world *w, size_t step, float *truth) {
  float(*origin)[3] = ylm_alloc(SOME, 12), (*normal)[3] = ylm_alloc(SOME, 12);
  ours o;
  must(origin && normal);
  for (size_t i = 0; i < SOME; i++) {
    memcpy(origin[i], w->origin[i * step], 12);
    memcpy(normal[i], w->normal[i * step], 12);
  }
  ours_run(w, &o, 64, 4096, 0, SOME, (const float(*)[3])origin, (const float(*)[3])normal,
           bench_cpu);
  memcpy(truth, o.out, SOME * WIDE * sizeof *truth);
  ours_free(&o);
  ylm_free(origin);
  ylm_free(normal);
}

static void vectors(const world *w) {
  size_t step = w->first[1] / SOME;
  float *truth = ylm_alloc(SOME, WIDE * sizeof *truth);
  must(truth);
  truth_of(w, step, truth);
  green g;
  green_create(&g, w, 16);
  double theirs = green_run(&g), worse = error_of(truth, SOME, step, NULL, g.buffer[0], w->albedo);
  printf("transfer vectors with %d bounces, lmax %d, at %zu vertices of a knot in a court under "
         "the sky\n",
         BOUNCES, LMAX, w->n);
  printf("                                             seconds   times  error    one thread but "
         "where it says wall\n");
  printf("  written out, 256 directions of the sphere  %7.2f          %.4f   %.1f M single rays\n",
         theirs, worse, g.rays * 1e-6);
  green_free(&g);
  static const int few[][2] = {{32, 128}, {32, 64}, {32, 0}, {16, 0}, {8, 0}};
  static const char *const place[] = {"128 a vertex", "64 a vertex", "vertices: means",
                                      "vertices: means", "vertices: means"};
  for (size_t k = 0; k < sizeof few / sizeof *few; k++) {
    ours o;
    ours_run(w, &o, few[k][0], few[k][1], 1, w->n, (const float(*)[3])w->origin,
             (const float(*)[3])w->normal, bench_cpu);
    printf("  links: %2d an element, %-18s  %7.2f  %6.1f  %.4f   links %.2f, bounces %.2f, "
           "vertices %.2f s\n",
           few[k][0], place[k], o.all, theirs / o.all,
           error_of(truth, SOME, step, o.out, NULL, NULL), o.links, o.solve, o.places);
    ours_free(&o);
    if (ylm_threads(0) < 2) continue;
    ours_run(w, &o, few[k][0], few[k][1], 0, w->n, (const float(*)[3])w->origin,
             (const float(*)[3])w->normal, ylm_seconds);
    printf("    %d threads, wall                           %7.2f  %6.1f\n", ylm_threads(0), o.all,
           theirs / o.all);
    ours_free(&o);
  }
  ylm_free(truth);
}

/* A matrix from `rays` directions: all products of basis functions for each of them. */
static void written_out(const world *w, size_t v, int rays, float matrix[COUNT][COUNT]) {
  ylm_rng r;
  ylm_rng_seed(&r, 3, v);
  memset(matrix, 0, sizeof(float[COUNT][COUNT]));
  for (int s = 0; s < rays; s++) {
    double z = 1 - 2 * ylm_rng_double(&r), phi = 2 * YLM_PI * ylm_rng_double(&r),
           p = sqrt(1 - z * z);
    float d[3] = {(float)(p * cos(phi)), (float)(p * sin(phi)), (float)z}, y[COUNT];
    ylm_trace_ray ray = {.org = {w->origin[v][0], w->origin[v][1], w->origin[v][2]},
                         .dir = {d[0], d[1], d[2]},
                         .far = INFINITY};
    ylm_trace_occluded(ylm_scene_trace(w->scene), 1, &ray);
    if (ray.far < 0) continue;
    ylm_sh_eval(LMAX, 0, false, YLM_FLOAT, 1, d, y, NULL, NULL, 1, NULL);
    for (int i = 0; i < COUNT; i++)
      for (int j = 0; j < COUNT; j++)
        matrix[i][j] += y[i] * y[j] * (float)(4 * YLM_PI) / (float)rays;
  }
}

static void matrices(const world *w) {
  int rays = 4096;
  size_t step = w->first[1] / MATRICES;
  float matrix[COUNT][COUNT], *out = ylm_alloc(MATRICES, 3 * sizeof matrix);
  float(*origin)[3] = ylm_alloc(MATRICES, 12), (*normal)[3] = ylm_alloc(MATRICES, 12);
  must(out && origin && normal);
  double theirs = bench_cpu();
  for (size_t i = 0; i < MATRICES; i++) written_out(w, i * step, rays, matrix);
  theirs = (bench_cpu() - theirs) / MATRICES;
  for (size_t i = 0; i < MATRICES; i++) {
    memcpy(origin[i], w->origin[i * step], 12);
    memcpy(normal[i], w->normal[i * step], 12);
  }
  ylm_transfer_form form = {
      .spacing = 100, .links = 4, .lmax = LMAX, .mesh_sides = front, .threads = 1};
  ylm_transfer *t = NULL;
  must(ylm_transfer_create(w->scene, &form, &t, NULL) == YLM_OK);
  float *all = ylm_alloc(ylm_transfer_count(t) + 1, ylm_transfer_width(t) * sizeof *all);
  must(all && ylm_transfer_vectors(t, 2, 1e-3, false, 1, NULL, NULL, all, NULL) == YLM_OK);
  printf("transfer matrices %dx%d, %d rays a place, one thread: ms a place\n", COUNT, COUNT, rays);
  printf("  written out, one channel, no bounce         %7.2f\n", 1e3 * theirs);
  for (int bounces = 0; bounces < 2; bounces++) {
    double begun = bench_cpu();
    must(ylm_transfer_matrices(t, bounces ? all : NULL, MATRICES, (const float(*)[3])origin,
                               (const float(*)[3])normal, NULL, rays / 2, 1, LMAX, LMAX, 1, NULL,
                               out, NULL) == YLM_OK);
    double ms = 1e3 * (bench_cpu() - begun) / MATRICES;
    printf("  here, %s %7.2f   %.1f times\n",
           bounces ? "three channels, all bounces        " : "three channels, no bounce          ",
           ms, 1e3 * theirs / ms);
  }
  ylm_transfer_free(t);
  ylm_free(all);
  ylm_free(out);
  ylm_free(origin);
  ylm_free(normal);
}

int main(void) {
  world w;
  if (bench_is_quick())
    make_world(&w, 100, 20, 15);
  else
    make_world(&w, 300, 80, 72);
  vectors(&w);
  matrices(&w);
  return 0;
}
