/*
** emit.c - virtual lights of a scene: particles beside bare rays from the same lamp, and milliseconds that
** radii and merging take.
*/
#include <math.h>

#include "bare.h"
#include "room.h"
#include "ylm_emit.h"

#define RAYS (1 << 16)
#define PARTICLES (1 << 19)

typedef struct task {
  const ylm_scene *scene;
  ylm_emit_options o;
  ylm_emit_report report;
} task;

/* Rays from places of the lamp, as the cosine. */
static void from_lamp(ylm_trace_ray *ray) {
  ylm_rng r;
  ylm_rng_seed(&r, 3, 3);
  for (size_t i = 0; i < RAYS; i++) {
    float n[2][3];
    for (int k = 0; k < 2; k++) {
      double z = 2 * ylm_rng_double(&r) - 1, phi = 6.28318531 * ylm_rng_double(&r);
      double s = sqrt(1 - z * z), to[3] = {s * cos(phi), s * sin(phi), z};
      for (int a = 0; a < 3; a++) n[k][a] = (float)to[a];
    }
    float d2 = 0;
    ray[i] = (ylm_trace_ray){.far = INFINITY};
    for (int a = 0; a < 3; a++) {
      ray[i].org[a] = bench_lamp[a] + bench_lamp[3] * n[0][a];
      ray[i].dir[a] = n[0][a] + n[1][a];
      d2 += ray[i].dir[a] * ray[i].dir[a];
    }
    for (int a = 0; a < 3; a++) ray[i].dir[a] /= sqrtf(d2);
  }
}

static void emit(void *context) {
  task *x = context;
  ylm_emit_lights l;
  if (ylm_emit(x->scene, &x->o, &l, &x->report, NULL) != YLM_OK) exit(1);
  ylm_emit_free(&l);
}

/* Millions of rays a second of all that ylm_emit does but radii. */
static double rate(task *x, int bounces) {
  x->o.bounces = bounces;
  x->o.radius = YLM_EMIT_FIXED;
  double least = bench_seconds(emit, x);
  return (double)x->report.rays / least * 1e-6;
}

static double processor(task *x) {
  double begun = bench_cpu();
  emit(x);
  return 1e3 * (bench_cpu() - begun);
}

/* Least milliseconds of radii by density of n particles; merged into `lights`, of merging and their radii. */
static double find(task *x, size_t n, size_t lights) {
  double least = INFINITY, other = INFINITY;
  x->o.particles = n;
  for (int k = 0; k < (bench_is_quick() ? 2 : 7); k++) {
    x->o.merge = false;
    x->o.radius = YLM_EMIT_FIXED;
    x->o.lights = 0;
    other = fmin(other, processor(x));
    x->o.merge = lights > 0;
    x->o.lights = lights;
    x->o.radius = YLM_EMIT_DENSITY;
    least = fmin(least, processor(x));
  }
  return least - other;
}

int main(void) {
  ylm_trace_ray *ray = ylm_alloc(RAYS, sizeof *ray);
  task x = {.scene = bench_room(),
            .o = {.particles = PARTICLES, .fixed = 0.1, .scale = 1.5, .seed = 1}};
  if (!ray) return 1;
  from_lamp(ray);
  x.o.threads = 1;
  bare_rays b = {ylm_scene_trace(x.scene), RAYS, ray, 0};
  printf(
      "particles in a room with a knot, millions of rays a second beside bare rays from the lamp; "
      "one thread\n  %8s  %9s  %9s  %6s\n",
      "bounces", "bare", "particles", "of");
  for (int bounces = 1; bounces <= 4; bounces *= 4) {
    double bare = (double)RAYS / bench_seconds(bare_nearest, &b) * 1e-6, own = rate(&x, bounces);
    printf("  %8d  %9.2f  %9.2f  %6.2f\n", bounces, bare, own, own / bare);
  }
  printf("ms of processor time, one thread, beyond lights of a given radius\n  %9s  %16s  %33s\n",
         "particles", "radii by density", "merged into 2000, and their radii");
  x.o.bounces = 1;
  for (size_t n = 10000; n <= 1000000; n *= 10)
    printf("  %9zu  %16.2f  %33.2f\n", n, find(&x, n, 0), find(&x, n, 2000));
  ylm_scene_free((ylm_scene *)x.scene);
  ylm_free(ray);
  return 0;
}
