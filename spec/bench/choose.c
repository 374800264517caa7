/*
** choose.c - lamps chosen for shadow rays: the time of a sample and the variance of what it brings,
** through the tree of lamps and with all lamps weighed one by one.
*/
#include <math.h>

#include "bench.h"
#include "ylm_geom.h"
#include "ylm_scene.h"

#define POINTS 1024

/* Kinds of lamps. */
typedef enum kind { SPHERES, TRIANGLES } kind;

typedef struct job {
  ylm_scene_chooser *chooser;
  const ylm_trace *trace; /* NULL: rays are not traced */
  int light_samples, repeats, points;
  float x[POINTS][3], n[POINTS][3];
  double variance; /* relative, of one estimate; mean over points */
} job;

static double uniform(ylm_rng *r) { return ylm_rng_double(r); }

static void direction(ylm_rng *r, float d[3]) {
  double z = 2 * uniform(r) - 1, phi = 2 * YLM_PI * uniform(r), s = sqrt(1 - z * z);
  d[0] = (float)(s * cos(phi)), d[1] = (float)(s * sin(phi)), d[2] = (float)z;
}

/* Lamps all over a hall of 20 x 12 x 4, in groups, a few of them bright. */
static float *make_lamps(kind k, size_t n, ylm_scene_lamps *lamps) {
  size_t width = k == SPHERES ? 4 : 9;
  float *shape = malloc((n + 1) * (width + 3) * sizeof *shape), *radiance = shape + n * width;
  ylm_rng r;
  ylm_rng_seed(&r, 5, n);
  if (!shape) exit(1);
  double centre[3] = {0, 0, 0}, size = 4 / cbrt((double)n);
  for (size_t i = 0; i < n; i++) {
    if (i % 7 == 0)
      for (int a = 0; a < 3; a++) centre[a] = (a == 0 ? 20 : a == 1 ? 12 : 4) * uniform(&r);
    double e = pow(10, 2 * uniform(&r)), p[3];
    for (int a = 0; a < 3; a++) p[a] = centre[a] + (uniform(&r) - 0.5) * size;
    for (int c = 0; c < 3; c++)
      radiance[3 * i + (size_t)c] = (float)(e * (0.5 + 0.5 * uniform(&r)));
    float *s = shape + width * i, d[3];
    if (k == SPHERES) {
      for (int a = 0; a < 3; a++) s[a] = (float)p[a];
      s[3] = (float)(size * 0.05 * (0.5 + uniform(&r)));
      continue;
    }
    for (int c = 0; c < 3; c++) {
      direction(&r, d);
      for (int a = 0; a < 3; a++) s[3 * c + a] = (float)p[a] + (float)(size * 0.1) * d[a];
    }
  }
  *lamps = (ylm_scene_lamps){.radiance = radiance};
  if (k == SPHERES)
    lamps->shape.spheres = n, lamps->shape.sphere = shape;
  else
    lamps->shape.triangles = n, lamps->shape.triangle = shape;
  return shape;
}

/* Points on the hall's floor and walls, and some on bodies anywhere in it. */
static void make_points(job *j) {
  ylm_rng r;
  ylm_rng_seed(&r, 6, 6);
  for (int i = 0; i < POINTS; i++) {
    for (int a = 0; a < 3; a++)
      j->x[i][a] = (float)((a == 0 ? 20 : a == 1 ? 12 : 4) * uniform(&r)), j->n[i][a] = 0;
    if (i % 3 == 0) {
      direction(&r, j->n[i]);
      continue;
    }
    int a = i % 3 == 1 ? 2 : i / 3 % 3;
    j->x[i][a] = 0;
    j->n[i][a] = 1;
  }
}

static void aim(void *context) {
  job *j = context;
  ylm_trace_ray ray[64];
  float value[64][3];
  ylm_rng r;
  for (int i = 0; i < j->points; i++) {
    ylm_rng_seed(&r, 7, (uint64_t)i);
    ylm_scene_aim(j->chooser, j->x[i], j->n[i], NULL, j->light_samples, &r, ray, value);
  }
}

static void one(void *context) {
  job *j = context;
  for (int i = 0; i < j->points; i++) {
    double u[3] = {ylm_scene_radical((uint32_t)i), 0.3, 0.7};
    ylm_trace_ray ray;
    float radiance[3];
    uint32_t lamp;
    if (ylm_scene_choose(j->chooser, j->x[i], j->n[i]))
      ylm_scene_sample(j->chooser, u, &ray, radiance, &lamp);
  }
}

/* The mean over points of variance over squared mean. */
static void spread(job *j) {
  ylm_trace_ray ray[64];
  float value[64][3];
  ylm_rng r;
  j->variance = 0;
  for (int i = 0; i < j->points; i++) {
    double sum = 0, squares = 0;
    ylm_rng_seed(&r, 8, (uint64_t)i);
    for (int k = 0; k < j->repeats; k++) {
      double e = 0;
      size_t n =
          ylm_scene_aim(j->chooser, j->x[i], j->n[i], NULL, j->light_samples, &r, ray, value);
      if (j->trace) ylm_trace_occluded(j->trace, n, ray);
      for (size_t q = 0; q < n; q++)
        if (!j->trace || !(ray[q].far < 0)) e += (double)value[q][1];
      sum += e, squares += e * e;
    }
    double mean = sum / j->repeats;
    if (mean > 0) j->variance += (squares / j->repeats - mean * mean) / (mean * mean) / j->points;
  }
}

static const char *const names[] = {"spheres", "triangles"};

/* Times and variance of one way, by the first `points` points. */
static void measure_way(job *j, const ylm_scene *scene, int light_samples, int points, int repeats,
                        double *seconds) {
  j->light_samples = light_samples;
  j->points = points;
  j->repeats = repeats;
  j->chooser = ylm_scene_chooser_create(scene);
  make_points(j);
  *seconds = bench_seconds(light_samples > 0 ? aim : one, j) / points;
  j->variance = 0;
  if (light_samples > 0 && repeats > 1) spread(j);
  ylm_scene_chooser_free(j->chooser);
}

static void measure(kind k, size_t n) {
  static job tree, plain;
  ylm_scene_lamps lamps;
  float *shape = make_lamps(k, n, &lamps);
  ylm_scene *s[2], *again;
  double least = 1e30, time[2];
  int less = bench_is_quick() ? 4 : 1, few = n > 10000 ? 4 : n > 1000 ? 256 : POINTS;
  lamps.one_by_one = 1;
  if (ylm_scene_create(0, NULL, &lamps, &s[0], NULL) != YLM_OK) exit(1);
  for (int i = 0; i < 3; i++) {
    double t = ylm_seconds();
    if (ylm_scene_relight(s[0], &lamps, &again, NULL) != YLM_OK) exit(1);
    least = fmin(least, ylm_seconds() - t);
    ylm_scene_free(again);
  }
  lamps.one_by_one = n * 8;
  if (ylm_scene_create(0, NULL, &lamps, &s[1], NULL) != YLM_OK) exit(1);
  printf("%zu %s: relit in %.2f ms\n", n, names[k], 1e3 * least);
  for (int samples = 0; samples <= 16; samples = samples ? 4 * samples : 1) {
    if (n == 1 && samples == 0) continue;
    measure_way(&tree, s[0], samples, POINTS, 256 / less, &time[0]);
    measure_way(&plain, s[1], samples, few,
                n > 10000  ? 1
                : n > 1000 ? 64 / less
                           : 256 / less,
                &time[1]);
    if (samples == 0)
      printf("  choose, sample: tree %6.0f ns a point, one by one %11.0f\n", 1e9 * time[0],
             1e9 * time[1]);
    else
      printf("  %2d samples     : tree %6.0f ns a point, one by one %11.0f; relative variance %.4f",
             samples, 1e9 * time[0], 1e9 * time[1], tree.variance);
    if (samples && n <= 10000)
      printf(", %.4f; efficiency %.2f", plain.variance,
             plain.variance * time[1] / (tree.variance * time[0]));
    if (samples) printf("\n");
  }
  ylm_scene_free(s[0]);
  ylm_scene_free(s[1]);
  free(shape);
}

/* -- a frame --------------------------------------------------------------------------------- */

#define FRAME 300000
#define TOGETHER 256

typedef struct frame {
  const ylm_scene *scene;
  const job *points;
  int threads;
  bool traces;
} frame;

static ylm_status shade(void *context, size_t begin, size_t end, int worker) {
  const frame *f = context;
  ylm_trace_ray ray[TOGETHER];
  float value[TOGETHER][3];
  size_t rays = 0;
  ylm_scene_chooser *c = ylm_scene_chooser_create(f->scene);
  (void)worker;
  for (size_t i = begin; i < end; i++) {
    const float *n = f->points->n[i % POINTS];
    float x[3];
    ylm_rng r;
    ylm_rng_seed(&r, 9, i);
    /* points of a picture lie side by side */
    for (int a = 0; a < 3; a++)
      x[a] = f->points->x[i % POINTS][a] + (float)(n[a] == 0 ? 0.02 * ylm_rng_double(&r) : 0);
    rays += ylm_scene_aim(c, x, n, NULL, 4, &r, ray + rays, value + rays);
    if (rays + 4 <= TOGETHER && i + 1 < end) continue;
    if (f->traces) ylm_trace_occluded(ylm_scene_trace(f->scene), rays, ray);
    rays = 0;
  }
  ylm_scene_chooser_free(c);
  return YLM_OK;
}

static void run_frame(void *context) {
  frame *f = context;
  if (ylm_parallel(FRAME, 1024, f->threads, shade, f, NULL, NULL) != YLM_OK) exit(1);
}

/* Four shadow rays, traced: with lamps drawn from the tree, and weighed one by one. */
static void compare_shadowed(const ylm_scene *s, ylm_scene_lamps *lamps) {
  static job j;
  ylm_scene *plain;
  double time[2], variance[2];
  lamps->one_by_one = SIZE_MAX;
  if (ylm_scene_relight(s, lamps, &plain, NULL) != YLM_OK) exit(1);
  for (int i = 0; i < 2; i++) {
    j.trace = ylm_scene_trace(s);
    measure_way(&j, i ? plain : s, 4, 256, bench_is_quick() ? 32 : 256, &time[i]);
    time[i] = 1e30;
    variance[i] = j.variance;
    for (int k = 0; k < 3; k++) {
      double t = bench_cpu();
      j.chooser = ylm_scene_chooser_create(i ? plain : s);
      spread(&j);
      ylm_scene_chooser_free(j.chooser);
      time[i] = fmin(time[i], (bench_cpu() - t) / (j.points * j.repeats));
    }
  }
  printf(
      "  a point with its shadows: tree %.0f ns, relative variance %.4f; one by one %.0f ns, %.4f; "
      "efficiency %.2f\n",
      1e9 * time[0], variance[0], 1e9 * time[1], variance[1],
      variance[1] * time[1] / (variance[0] * time[0]));
  ylm_scene_free(plain);
}

/* 300,000 points of a hall with 40 bodies, in the order of a picture: blocks of 1,024. */
static void measure_frame(void) {
  static job points;
  ylm_scene_lamps lamps;
  float *shape = make_lamps(SPHERES, 2516, &lamps);
  ylm_mesh *body[40];
  ylm_scene_mesh mesh[40] = {0};
  ylm_material *grey;
  ylm_scene *s;
  ylm_rng r;
  ylm_rng_seed(&r, 10, 10);
  if (ylm_material_create(0, 3, (float[]){.5f, .5f, .5f}, &grey, NULL) != YLM_OK) exit(1);
  for (int i = 0; i < 40; i++) {
    if (ylm_mesh_knot(2, 3, .5, .2, .1, 128, 16, &body[i], NULL) != YLM_OK) exit(1);
    float at[3] = {(float)(20 * uniform(&r)), (float)(12 * uniform(&r)), (float)(4 * uniform(&r))};
    for (size_t v = 0; v < 3 * body[i]->vertices; v++) body[i]->position[v] += at[v % 3];
    mesh[i] = (ylm_scene_mesh){.positions = body[i]->position,
                               .vertices = body[i]->vertices,
                               .triangles = body[i]->index,
                               .count = body[i]->triangles,
                               .material = grey,
                               .occludes = true};
  }
  if (ylm_scene_create(40, mesh, &lamps, &s, NULL) != YLM_OK) exit(1);
  points.points = POINTS;
  make_points(&points);
  printf("300,000 points x 4 shadow rays under 2,516 spheres, 40 knots of 4,096 triangles\n");
  compare_shadowed(s, &lamps);
  double t[3];
  for (int k = 0; k < 3; k++) {
    frame f = {s, &points, k < 2 ? 1 : 2, k > 0};
    t[k] = k < 2 ? bench_seconds(run_frame, &f) : bench_wall(run_frame, &f);
  }
  printf("  processor time of one thread: choosing %.0f ms, with tracing %.0f; two threads on the "
         "clock %.0f\n",
         1e3 * t[0], 1e3 * t[1], 1e3 * t[2]);
  ylm_scene_free(s);
  for (int i = 0; i < 40; i++) ylm_mesh_free(body[i]);
  ylm_material_free(grey);
  free(shape);
}

int main(void) {
  static const size_t counts[] = {1, 32, 256, 2516, 100000, 1000000};
  for (int k = SPHERES; k <= TRIANGLES; k++)
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) measure((kind)k, counts[i]);
  measure_frame();
  return 0;
}
