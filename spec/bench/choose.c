/*
** choose.c - lamps chosen for shadow rays: the time of a sample and the variance of what it brings,
** through the tree of lamps and with all lamps weighed one by one.
*/
#include <math.h>

#include "bench.h"
#include "ylm_geom.h"
#include "ylm_scene.h"

#define POINTS 1024
#define PI 3.14159265358979323846

/* Kinds of lamps. */
typedef enum kind { SPHERES, TRIANGLES } kind;

typedef struct job {
  const ylm_scene *scene;
  ylm_scene_chooser *chooser;
  int light_samples, repeats;
  float x[POINTS][3], n[POINTS][3];
  double variance; /* relative, of one estimate; mean over points */
  double mean[POINTS];
} job;

static double uniform(ylm_rng *r) { return ylm_rng_double(r); }

static void direction(ylm_rng *r, float d[3]) {
  double z = 2 * uniform(r) - 1, phi = 2 * PI * uniform(r), s = sqrt(1 - z * z);
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
  for (int i = 0; i < POINTS; i++) {
    ylm_rng_seed(&r, 7, (uint64_t)i);
    ylm_scene_aim(j->chooser, j->x[i], j->n[i], j->light_samples, &r, ray, value);
  }
}

static void one(void *context) {
  job *j = context;
  for (int i = 0; i < POINTS; i++) {
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
  for (int i = 0; i < POINTS; i++) {
    double sum = 0, squares = 0;
    ylm_rng_seed(&r, 8, (uint64_t)i);
    for (int k = 0; k < j->repeats; k++) {
      double e = 0;
      size_t n = ylm_scene_aim(j->chooser, j->x[i], j->n[i], j->light_samples, &r, ray, value);
      for (size_t q = 0; q < n; q++) e += (double)value[q][1];
      sum += e, squares += e * e;
    }
    double mean = sum / j->repeats;
    j->mean[i] = mean;
    if (mean > 0) j->variance += (squares / j->repeats - mean * mean) / (mean * mean) / POINTS;
  }
}

static const char *const names[] = {"spheres", "triangles"};

static void measure(kind k, size_t n) {
  static job tree, plain;
  ylm_scene_lamps lamps;
  float *shape = make_lamps(k, n, &lamps);
  ylm_scene *s[2], *again;
  lamps.one_by_one = 1;
  if (ylm_scene_create(0, NULL, &lamps, &s[0], NULL) != YLM_OK) exit(1);
  double least = 1e30;
  for (int i = 0; i < 3; i++) {
    double t = ylm_seconds();
    if (ylm_scene_relight(s[0], &lamps, &again, NULL) != YLM_OK) exit(1);
    least = fmin(least, ylm_seconds() - t);
    ylm_scene_free(again);
  }
  lamps.one_by_one = n;
  if (ylm_scene_create(0, NULL, &lamps, &s[1], NULL) != YLM_OK) exit(1);
  job *j[2] = {&tree, &plain};
  printf("%zu %s: relit in %.2f ms\n", n, names[k], 1e3 * least);
  for (int light_samples = 1; light_samples <= 16; light_samples *= 4) {
    double time[2] = {0}, choose[2] = {0};
    for (int i = 0; i < (n > 10000 ? 1 : 2); i++) {
      j[i]->scene = s[i];
      j[i]->light_samples = light_samples;
      j[i]->repeats = (n > 1000 && i == 1 ? 64 : 512) / (bench_is_quick() ? 8 : 1);
      j[i]->chooser = ylm_scene_chooser_create(s[i]);
      make_points(j[i]);
      time[i] = bench_seconds(aim, j[i]) / POINTS;
      if (light_samples == 1) choose[i] = bench_seconds(one, j[i]) / POINTS;
      spread(j[i]);
      ylm_scene_chooser_free(j[i]->chooser);
    }
    printf("  %2d samples: tree %7.0f ns a point, variance %7.4f", light_samples, 1e9 * time[0],
           tree.variance);
    if (n <= 10000)
      printf(";  one by one %8.0f ns, %7.4f;  efficiency %7.2f, with rays of 80 ns %7.2f",
             1e9 * time[1], plain.variance, plain.variance * time[1] / (tree.variance * time[0]),
             plain.variance * (time[1] + 80e-9 * light_samples) /
                 (tree.variance * (time[0] + 80e-9 * light_samples)));
    if (light_samples == 1)
      printf("; choose and sample %.0f, %.0f ns", 1e9 * choose[0], 1e9 * choose[1]);
    printf("\n");
  }
  ylm_scene_free(s[0]);
  ylm_scene_free(s[1]);
  free(shape);
}

int main(int argc, char **argv) {
  static const size_t counts[] = {8, 16, 32, 64, 128, 256, 2516, 100000, 1000000};
  for (int k = SPHERES; k <= TRIANGLES; k++)
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
      if (argc > 1 && (size_t)atol(argv[1]) != counts[i]) continue;
      measure((kind)k, counts[i]);
    }
  return 0;
}
