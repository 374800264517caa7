/*
** gather.c - probes of gathered light beside bare rays, a knot in a room: values, gradients and the metric of the
** field at points, and as many nearest hits from there by csrc/trace alone.
*/
#include <math.h>

#include "bench.h"
#include "room.h"
#include "ylm_transfer.h"

#define POINTS 64
#define MOST 32768

typedef struct task {
  const ylm_scene *scene;
  const ylm_radiosity *lit;
  ylm_gather *gather;
  ylm_field_query q;
  ylm_field_result r;
  float (*point)[3];
  float *out;
  ylm_trace_ray *ray;
  ylm_trace_hit *hit;
  size_t rays;
} task;

static void probes(void *context) {
  task *x = context;
  const ylm_field *f = ylm_gather_field(x->gather);
  if (f->evaluate(f, &x->q, POINTS, x->point, &x->r, NULL) != YLM_OK) exit(1);
}

static void bare(void *context) {
  task *x = context;
  for (size_t i = 0; i < x->rays; i += 256)
    ylm_trace_nearest(ylm_scene_trace(x->scene), x->rays - i < 256 ? x->rays - i : 256, x->ray + i,
                      false, x->hit);
}

/* The rays of all probes; or as many at random. */
static void aim(task *x, bool random) {
  float(*d)[3] = ylm_alloc(MOST, sizeof *d);
  ylm_rng r;
  ylm_rng_seed(&r, 5, 5);
  x->rays = 0;
  if (!d) exit(1);
  for (size_t p = 0; p < POINTS; p++) {
    size_t n = ylm_gather_directions(x->gather, x->point[p], MOST, d);
    for (size_t i = 0; i < n; i++) {
      double z = 2 * ylm_rng_double(&r) - 1, angle = 6.28318531 * ylm_rng_double(&r);
      double s = sqrt(1 - z * z), other[3] = {s * cos(angle), s * sin(angle), z};
      ylm_trace_ray *ray = &x->ray[x->rays++];
      *ray = (ylm_trace_ray){.far = INFINITY};
      for (int a = 0; a < 3; a++) {
        ray->org[a] = x->point[p][a];
        ray->dir[a] = random ? (float)other[a] : d[i][a];
      }
    }
  }
  ylm_free(d);
}

static void measure(task *x, int base, int lmax, ylm_gather_derivatives derivatives, int want) {
  static const char *const names[] = {"cells", "points"};
  ylm_gather_form form = ylm_gather_defaults();
  form.base = base;
  form.derivatives = derivatives;
  if (ylm_gather_create(x->lit, &form, &x->gather, NULL) != YLM_OK) exit(1);
  x->q.lmax = lmax;
  x->q.want = want;
  double least = bench_seconds(probes, x), same, random;
  aim(x, true);
  random = bench_seconds(bare, x);
  aim(x, false);
  same = bench_seconds(bare, x);
  printf("  %4d  %6s  %-8s  %5zu  %8.0f  %7.2f  %9.2f  %9.2f  %6.2f\n", lmax, names[derivatives],
         want == YLM_WANT_VALUE   ? "value"
         : want & YLM_WANT_METRIC ? "all"
                                  : "gradient",
         x->rays / POINTS, 1e6 * least / POINTS, 1e-6 * (double)x->rays / least,
         1e-6 * (double)x->rays / random, 1e-6 * (double)x->rays / same, same / least);
  ylm_gather_free(x->gather);
}

int main(void) {
  const int all = YLM_WANT_VALUE | YLM_WANT_GRADIENT | YLM_WANT_METRIC;
  task x = {.scene = bench_room(), .q = {.channels = 3, .metric_channels = 1, .threads = 1}};
  ylm_transfer *t;
  ylm_radiosity *lit;
  ylm_transfer_form form = {.spacing = 0.08, .links = 128, .lmax = -1, .seed = 1};
  if (ylm_transfer_create(x.scene, &form, &t, NULL) != YLM_OK ||
      ylm_radiosity_create(t, &lit) != YLM_OK ||
      ylm_radiosity_rays(lit, x.scene, 16, true, 1, 0, NULL, NULL) != YLM_OK ||
      ylm_radiosity_solve(lit, -1, 1e-3, true, 0, NULL, NULL, NULL) != YLM_OK)
    return 1;
  x.lit = lit;
  x.point = ylm_alloc(POINTS, 12);
  x.out = ylm_alloc(POINTS * 3 * 81 * 4 + 2 * POINTS, 4);
  x.ray = ylm_alloc_zero(POINTS * MOST, sizeof *x.ray);
  x.hit = ylm_alloc(256, sizeof *x.hit);
  if (!x.point || !x.out || !x.ray || !x.hit) return 1;
  x.r = (ylm_field_result){.value = x.out,
                           .gradient = x.out + POINTS * 3 * 81,
                           .lambda = x.out + POINTS * 3 * 81 * 4,
                           .norm = x.out + POINTS * 3 * 81 * 4 + POINTS};
  bench_fill(YLM_FLOAT, x.point, 3 * POINTS);
  for (size_t i = 0; i < POINTS; i++)
    for (int a = 0; a < 3; a++) x.point[i][a] *= a < 2 ? 2.8f : 1.8f;
  printf("probes of gathered light in a room with a knot, %zu elements; RGB; one thread\n"
         "'of' is the rate of a probe's rays beside that of the same rays alone\n"
         "  %4s  %6s  %-8s  %5s  %8s  %7s  %9s  %9s  %6s\n",
         ylm_transfer_count(t), "lmax", "by", "want", "rays", "us/probe", "M ray/s", "at random",
         "the same", "of");
  measure(&x, 11, 4, YLM_GATHER_CELLS, YLM_WANT_VALUE);
  measure(&x, 11, 4, YLM_GATHER_CELLS, YLM_WANT_VALUE | YLM_WANT_GRADIENT);
  measure(&x, 11, 4, YLM_GATHER_CELLS, all);
  measure(&x, 11, 4, YLM_GATHER_POINTS, all);
  measure(&x, 11, 2, YLM_GATHER_CELLS, all);
  measure(&x, 11, 8, YLM_GATHER_CELLS, all);
  measure(&x, 24, 4, YLM_GATHER_CELLS, all);
  return 0;
}
