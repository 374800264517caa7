/*
** grid.c - baking and sampling grids: where the time of an adaptive bake goes, bytes per point, and
** millions of shading points a second from adaptive and uniform grids.
*/
#include <math.h>

#include "bench.h"
#include "ylm_grid.h"
#include "ylm_light.h"

#define LIGHTS 2516
#define LMAX 4

typedef struct scene {
  ylm_light_set *lights;
  float *points; /* [n][3], shading points, row by row */
  size_t n;
} scene;

/* Lamps that hover in three heights over a floor of 8 x 8; the floor and a ball are what is lit. */
static bool make_scene(scene *s, size_t across) {
  static double at[LIGHTS][3], radius[LIGHTS], radiance[LIGHTS][3], u[LIGHTS][4];
  bench_fill(YLM_DOUBLE, u, 4 * LIGHTS);
  for (int i = 0; i < LIGHTS; i++) {
    at[i][0] = 4 * u[i][0], at[i][1] = 0.12 + 0.05 * (i % 3), at[i][2] = 4 * u[i][1];
    radius[i] = 0.02 + 0.01 * fabs(u[i][2]);
    for (int a = 0; a < 3; a++) radiance[i][a] = 1 + u[i][3] * (a - 1) / 2;
  }
  if (ylm_light_set_spheres(LIGHTS, at[0], radius, radiance[0], &s->lights, NULL) != YLM_OK)
    return false;
  s->n = 2 * across * across;
  s->points = ylm_alloc(s->n, 3 * sizeof *s->points);
  if (!s->points) return false;
  for (size_t i = 0; i < across * across; i++) {
    double x = (double)(i % across) / (double)across, z = (double)(i / across) / (double)across;
    float *p = s->points + 3 * i, *q = p + 3 * across * across;
    p[0] = (float)(8 * x - 4), p[1] = 0, p[2] = (float)(8 * z - 4);
    double polar = 3.14159265 * z, around = 6.28318531 * x;
    q[0] = (float)(1.2 * sin(polar) * cos(around));
    q[1] = (float)(1.5 + 1.2 * cos(polar));
    q[2] = (float)(1.2 * sin(polar) * sin(around));
  }
  return true;
}

static ylm_grid *bake(const scene *s, const ylm_grid_form *form, int threads) {
  ylm_grid_source source = {.field = ylm_light_set_field(s->lights),
                            .occupied_points = s->points,
                            .occupied = s->n,
                            .occupied_dtype = YLM_FLOAT,
                            .threads = threads};
  ylm_grid *g = NULL;
  ylm_error e = {0};
  if (ylm_grid_bake(form, &source, &g, &e) != YLM_OK) printf("bake: %s\n", e.text);
  return g;
}

/* Seconds that the metric (maps and eigenvalues) adds to a point, whatever the lights. */
static double metric_seconds(const scene *s) {
  ylm_light_set *one = NULL;
  double at[3] = {9, 9, 9}, radius = 0.1, radiance[3] = {1, 1, 1}, t[2] = {1e30, 1e30};
  size_t n = s->n < 8192 ? s->n : 8192;
  float *out = ylm_alloc(n, (75 * 4 + 2) * sizeof *out);
  if (!out || ylm_light_set_spheres(1, at, &radius, radiance, &one, NULL) != YLM_OK) return 0;
  ylm_field_result r = {
      .value = out, .gradient = out + 75 * n, .lambda = out + 300 * n, .norm = out + 301 * n};
  for (int i = 0; i < 10; i++) {
    ylm_field_query q = {.lmax = LMAX,
                         .channels = 3,
                         .metric_channels = 1,
                         .want = 3 | (i % 2 ? YLM_WANT_METRIC : 0),
                         .threads = 1};
    double begin = bench_cpu();
    ylm_light_set_evaluate(one, ylm_isa_current(), &q, n, s->points, &r, NULL);
    begin = bench_cpu() - begin;
    if (begin < t[i % 2]) t[i % 2] = begin;
  }
  ylm_free(out);
  ylm_light_set_free(one);
  return (t[1] - t[0]) / (double)n;
}

static void shares(const scene *s, const ylm_grid_form *form, int threads) {
  ylm_grid_stats best = {.seconds = 1e30};
  for (int i = 0; i < (bench_is_quick() ? 1 : 3); i++) {
    ylm_grid *g = bake(s, form, threads);
    if (!g) return;
    ylm_grid_stats t = *ylm_grid_look(g)->stats;
    if (t.seconds < best.seconds) best = t;
    ylm_grid_free(g);
  }
  double other = best.seconds - best.field_seconds - best.occupancy_seconds - best.lattice_seconds -
                 best.residual_seconds - best.continuity_seconds;
  double metric = metric_seconds(s) * (double)best.points / threads, all = best.seconds / 100;
  printf(
      "  %d thread%s %7.1f ms: field %.1f %% (eigenvalues and their maps %.1f), octree of points "
      "%.1f, lattice hash %.1f, residuals %.1f, continuity %.1f, rest %.1f; %.1f of all to "
      "verify\n",
      threads, threads > 1 ? "s" : " ", best.seconds * 1e3, best.field_seconds / all, metric / all,
      best.occupancy_seconds / all, best.lattice_seconds / all, best.residual_seconds / all,
      best.continuity_seconds / all, other / all, best.verify_seconds / all);
}

static void memory(const ylm_grid *g, const char *name) {
  const ylm_grid_contents *v = ylm_grid_look(g);
  printf("  %-9s %8zu points, %8zu cells: %6.0f bytes a point in all, of which %zu are its "
         "coefficients and gradients\n",
         name, v->points, v->cells, (double)v->stats->bytes / (double)v->points, 16 * v->stride);
}

/* -- sampling ------------------------------------------------------------------------- */

typedef struct job {
  const ylm_grid *g;
  ylm_grid_query q;
  size_t n;
  float *points, *out;
} job;

static void sample(void *context) {
  job *j = context;
  ylm_grid_sample(j->g, &j->q, j->n, j->points, j->out, NULL, NULL, NULL);
}

/* Points in the order of a grid's leaves, `each` in every leaf that has data. */
static size_t place_points(const ylm_grid *g, float *points, size_t most, size_t each) {
  const ylm_grid_contents *v = ylm_grid_look(g);
  ylm_rng r;
  size_t n = 0;
  ylm_rng_seed(&r, 2, 2);
  for (size_t i = 0; i < v->cells; i++) {
    double box[6];
    if (v->cell[i].child || !(v->cell[i].flags & YLM_GRID_OCCUPIED)) continue;
    ylm_grid_box(g, i, box);
    for (size_t k = 0; k < each && n < most; k++, n++)
      for (int a = 0; a < 3; a++)
        points[3 * n + (size_t)a] = (float)(box[a] + (box[3 + a] - box[a]) * ylm_rng_double(&r));
  }
  return n;
}

static void sampling(const ylm_grid *adaptive, const ylm_grid *uniform) {
  enum { MOST = 1 << 20, EACH = 128 };
  int all = ylm_threads(0);
  job j = {.points = ylm_alloc(MOST, 12), .out = ylm_alloc_zero(MOST, 300)};
  if (!j.points || !j.out) return;
  double rate[2][2];
  printf("sampling, lmax %d, RGB, Hermite, float, %d points to a leaf, in cell order: M points/s\n",
         LMAX, EACH);
  for (int k = 0; k < 2; k++) {
    j.g = k ? uniform : adaptive;
    j.n = place_points(j.g, j.points, MOST, EACH);
    for (int t = 0; t < 2; t++) {
      j.q.threads = t ? all : 1;
      rate[k][t] = (double)j.n / bench_wall(sample, &j) * 1e-6;
    }
    printf("  %-9s %8zu points  one thread %6.1f  %d threads %6.1f\n", k ? "uniform" : "adaptive",
           j.n, rate[k][0], all, rate[k][1]);
  }
  printf("  adaptive costs %.2f times uniform on one thread, %.2f on %d\n", rate[1][0] / rate[0][0],
         rate[1][1] / rate[0][1], all);
  ylm_free(j.points);
  ylm_free(j.out);
}

int main(void) {
  scene s;
  int all = ylm_threads(0);
  ylm_grid_form form = {.kind = YLM_GRID_ADAPTIVE,
                        .bounds = {-4.01, -0.01, -4.01, 4.01, 3.01, 4.01},
                        .lmax = LMAX,
                        .channels = 3,
                        .metric_channels = 1,
                        .depth = 9,
                        .metric = YLM_GRID_RELATIVE,
                        .threshold = -1,
                        .tolerance = bench_is_quick() ? 0.03 : 0.01,
                        .continuous = true};
  if (!make_scene(&s, 400)) return 1;
  printf("adaptive bake to a tolerance of %g: %d lights, lmax %d, RGB, %zu shading points; wall "
         "times\n",
         form.tolerance, LIGHTS, LMAX, s.n);
  shares(&s, &form, 1);
  if (all > 1) shares(&s, &form, all);
  ylm_grid *adaptive = bake(&s, &form, 0);
  if (!adaptive) return 1;
  /* a uniform grid of about as many points */
  size_t points = ylm_grid_look(adaptive)->evaluated;
  double edge = cbrt(8.02 * 8.02 * 3.02 / (double)points);
  ylm_grid_form even = form;
  even.kind = YLM_GRID_UNIFORM, even.metric_channels = 0, even.tolerance = 0;
  even.cells[0] = even.cells[2] = (uint32_t)(8.02 / edge), even.cells[1] = (uint32_t)(3.02 / edge);
  scene everywhere = {.lights = s.lights};
  ylm_grid *uniform = bake(&everywhere, &even, 0);
  if (!uniform) return 1;
  memory(adaptive, "adaptive"), memory(uniform, "uniform");
  sampling(adaptive, uniform);
  ylm_grid_free(adaptive), ylm_grid_free(uniform);
  ylm_light_set_free(s.lights);
  ylm_free(s.points);
  return 0;
}
