/*
** many_lights.c - error against speed of the tree of lights, and time against their number.
**
** Error: of value, gradient, Hessian (L2 over channels and coefficients, Frobenius over axes) and
** lambda, each divided by that of the lights with the absolute values of their radiance, all
** against the exact sum; in units of the tolerance, the 99.9 % quantile and the largest over
** points. Promised: at most 1 and at most 4. BENCH=quick takes fewer points.
*/
#include <math.h>
#include <time.h>

#include "bench.h"
#include "many.h"
#include "ylm_light.h"

#ifndef LMAX
#define LMAX 4
#endif
#define COUNT ((LMAX + 1) * (LMAX + 1))
#define WIDTH (3 * COUNT)

static const double tolerances[] = {1e-1, 1e-2, 1e-3};

/* -- scenes in the unit cube ----------------------------------------------------------------- */

typedef struct lamps {
  size_t n;
  double *at, *radius, *radiance;
} lamps;

enum { UNIFORM, CLUSTERED, WALLS, RADII, SIGNS, ALL, SCENES };
static const char *const names[SCENES] = {"uniform",      "clustered", "wall-mounted",
                                          "mixed radius", "signs",     "all of it"};

static lamps scene(int kind, size_t n) {
  lamps l = {n, ylm_alloc(n, 24), ylm_alloc(n, 8), ylm_alloc(n, 24)};
  ylm_rng r;
  ylm_rng_seed(&r, 7, (uint64_t)kind);
  double centre[100][4], size = 0.25 * pow((double)n, -1.0 / 3);
  for (int i = 0; i < 100; i++)
    for (int a = 0; a < 4; a++) centre[i][a] = ylm_rng_double(&r);
  bool coloured = kind == SIGNS || kind == ALL || kind == CLUSTERED,
       signs = kind == SIGNS || kind == ALL;
  for (size_t i = 0; i < n; i++) {
    double *at = l.at + 3 * i;
    int how = kind == ALL ? (int)(i % 3) : kind == SIGNS ? (int)(i & 1) : kind;
    for (int a = 0; a < 3; a++) at[a] = ylm_rng_double(&r);
    if (how == WALLS) {
      uint32_t wall = ylm_rng_u32(&r) % 5;
      at[wall % 3] = wall < 3 ? 0.999 : 0.001;
    }
    if (how == CLUSTERED) {
      const double *c = centre[ylm_rng_u32(&r) % 100];
      for (int a = 0; a < 3; a++) at[a] = c[a] + 0.03 * c[3] * bench_normal(&r);
    }
    l.radius[i] = size;
    if (kind == RADII || kind == ALL) l.radius[i] *= exp(log(100) * (ylm_rng_double(&r) - 0.7));
    double e = 1, sign = signs && ylm_rng_u32(&r) & 1 ? -1 : 1;
    for (int a = 0; a < 3; a++)
      l.radiance[3 * i + (size_t)a] = sign * e * (coloured ? ylm_rng_double(&r) : 1 + 0.5 * a);
    if (kind == ALL) l.radiance[3 * i] *= ylm_rng_u32(&r) & 1 ? -1 : 1;
  }
  return l;
}

static void scene_free(lamps *l) {
  ylm_free(l->at);
  ylm_free(l->radius);
  ylm_free(l->radiance);
}

/* Where points are: few and anywhere (half of them on a floor), more in the whole cube, corners of
   a uniform grid, a floor's shading points; for errors, more of the first. */
enum { ANYWHERE, RANDOM, GRID, FLOOR, SETS, SCATTERED = SETS };
static const struct {
  const char *name;
  size_t n, side;
} sets[] = {{"256 anywhere", 256, 0},
            {"4096 in the cube", 4096, 0},
            {"a grid of 32^3", 32768, 32},
            {"a floor of 256^2", 65536, 256},
            {"anywhere", 10000, 0}};

/* The points of a set, n of them if it has no sides. */
static double *places(int set, size_t n) {
  size_t side = sets[set].side;
  double *p = ylm_alloc(n, 3 * sizeof *p);
  ylm_rng r;
  ylm_rng_seed(&r, 3, 3);
  for (size_t i = 0; i < n; i++) {
    size_t at[3] = {0, 0, 0};
    if (side) at[0] = i % side, at[1] = i / side % side, at[2] = i / side / side;
    for (size_t a = 0; a < 3; a++)
      p[3 * i + a] = side ? ((double)at[a] + 0.5) / (double)side : ylm_rng_double(&r);
    if (!side && set != RANDOM && i & 1) p[3 * i + 1] = 0.01;
    if (set == FLOOR) p[3 * i + 2] = 0.3;
  }
  return p;
}

/* -- errors ------------------------------------------------------------------------------------ */

/* A query with the error that is measured: each is asked for with nothing stricter beside it. */
enum { VALUE, GRADIENT, BAKE, HESSIAN, FORMS };
static const int wants[FORMS] = {YLM_WANT_VALUE, YLM_WANT_VALUE | YLM_WANT_GRADIENT,
                                 YLM_WANT_VALUE | YLM_WANT_GRADIENT | YLM_WANT_METRIC,
                                 YLM_WANT_VALUE | YLM_WANT_GRADIENT | YLM_WANT_HESSIAN};
static const char *const forms[FORMS] = {"value", "gradient", "lambda", "Hessian"};

typedef struct answer {
  void *value, *gradient, *hessian, *lambda, *norm;
  double seconds, pairs;
} answer;

static answer ask(const ylm_field *f, ylm_dtype t, size_t n, const void *points, int form) {
  size_t b = ylm_dtype_size(t);
  answer a = {ylm_alloc(n, b * WIDTH),
              ylm_alloc(n, 3 * b * WIDTH),
              form == HESSIAN ? ylm_alloc(n, 6 * b * WIDTH) : NULL,
              ylm_alloc(n, b),
              ylm_alloc(n, b),
              0,
              0};
  ylm_field_query q = {.lmax = LMAX,
                       .channels = 3,
                       .want = wants[form],
                       .metric_channels = 1,
                       .dtype = t,
                       .threads = t == YLM_FLOAT};
  ylm_field_result r = {.value = a.value,
                        .gradient = a.gradient,
                        .hessian = a.hessian,
                        .lambda = a.lambda,
                        .norm = a.norm};
  double begin = ylm_seconds();
  if (f->evaluate(f, &q, n, points, &r, NULL) != YLM_OK) abort();
  a.seconds = ylm_seconds() - begin;
  a.pairs = (double)r.pairs;
  return a;
}

static void answer_free(answer *a) {
  ylm_free(a->value), ylm_free(a->gradient), ylm_free(a->hessian);
  ylm_free(a->lambda), ylm_free(a->norm);
}

/* Distance of x from y over `width` numbers; y NULL: from zero. */
static double distance(const double *x, const double *y, size_t width, bool tensor) {
  static const double times[6] = {1, 2, 2, 1, 2, 1};
  double s = 0;
  for (size_t i = 0; i < width; i++) {
    double d = x[i] - (y ? y[i] : 0);
    s += (tensor ? times[i % 6] : 1) * d * d;
  }
  return sqrt(s);
}

/* The error of the row-th point of an answer, the i-th of the others, in what a form looks at. */
static double error_of(const answer *a, size_t row, const answer *exact, const answer *whole,
                       size_t i, int form) {
  size_t w = form == BAKE ? 1 : form == VALUE ? WIDTH : form == GRADIENT ? 3 * WIDTH : 6 * WIDTH;
  const double *x[3];
  const answer *from[3] = {a, exact, whole};
  for (int k = 0; k < 3; k++) {
    const double *all[FORMS] = {from[k]->value, from[k]->gradient, from[k]->lambda,
                                from[k]->hessian};
    x[k] = all[form] + (k == 0 ? row : i) * w;
  }
  return distance(x[0], x[1], w, form == HESSIAN) / distance(x[2], NULL, w, form == HESSIAN);
}

static ylm_light_set *lights_of(const lamps *l) {
  ylm_light_set *lights = NULL;
  if (ylm_light_set_spheres(l->n, l->at, l->radius, l->radiance, &lights, NULL) != YLM_OK) abort();
  return lights;
}

/* Errors in double of a scene at n points of a set, of which about `sample` are compared: true if
   they are as promised. */
static bool measure_errors(int kind, size_t lights, int set, size_t n, size_t sample) {
  lamps l = scene(kind, lights);
  ylm_light_set *given = lights_of(&l), *positive;
  for (size_t i = 0; i < 3 * l.n; i++) l.radiance[i] = fabs(l.radiance[i]);
  positive = lights_of(&l);
  size_t stride = n / sample | 1, m = (n + stride - 1) / stride;
  double *points = places(set, n), *some = ylm_alloc(m, 24), *e = ylm_alloc(m, sizeof *e);
  for (size_t i = 0; i < 3 * m; i++) some[i] = points[i / 3 * stride * 3 + i % 3];
  double high[3][FORMS], most[3][FORMS], pairs[3][FORMS];
  bool kept = true;
  for (int form = 0; form < FORMS; form++) {
    answer exact = ask(ylm_light_set_field(given), YLM_DOUBLE, m, some, form);
    answer whole = ask(ylm_light_set_field(positive), YLM_DOUBLE, m, some, form);
    for (int t = 0; t < 3; t++) {
      ylm_light_cut *cut = bench_cut(given, tolerances[t]);
      answer a = ask(ylm_light_cut_field(cut), YLM_DOUBLE, n, points, form);
      for (size_t i = 0; i < m; i++)
        e[i] = error_of(&a, i * stride, &exact, &whole, i, form) / tolerances[t];
      qsort(e, m, sizeof *e, bench_upwards);
      high[t][form] = e[(size_t)ceil(0.999 * (double)m) - 1], most[t][form] = e[m - 1];
      pairs[t][form] = a.pairs / (double)n;
      kept = kept && high[t][form] <= 1 && most[t][form] <= 4;
      answer_free(&a);
      ylm_light_cut_free(cut);
    }
    answer_free(&exact);
    answer_free(&whole);
  }
  for (int t = 0; t < 3; t++) {
    printf("%-13s %-9g", names[kind], tolerances[t]);
    for (int k = 0; k < FORMS; k++)
      printf("  %5.2f %5.2f %6.0f", high[t][k], most[t][k], pairs[t][k]);
    printf("\n");
    fflush(stdout);
  }
  ylm_free(points), ylm_free(some), ylm_free(e);
  ylm_light_set_free(given), ylm_light_set_free(positive);
  scene_free(&l);
  return kept;
}

/* -- time ------------------------------------------------------------------------------------- */

/* The least processor time of three, or of two where there are many points, in microseconds per
 * point: other processes do not count. */
static double time_of(const ylm_field *f, size_t n, const float *points, int form) {
  double least = 1e30;
  for (int turn = 0; turn < (n > 1000 ? 2 : 3); turn++) {
    struct timespec a, b;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &a);
    answer x = ask(f, YLM_FLOAT, n, points, form);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &b);
    answer_free(&x);
    least = fmin(least, (double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec));
  }
  return 1e6 * least / (double)n;
}

static void print_times(const ylm_field *f, size_t n, const float *points) {
  for (int form = 0; form < HESSIAN; form++) printf(" %9.2f", time_of(f, n, points, form));
  printf("\n");
  fflush(stdout);
}

static float *points_of(int set) {
  size_t n = sets[set].n;
  double *from = places(set, n);
  float *p = ylm_alloc(n, 3 * sizeof *p);
  for (size_t i = 0; i < 3 * n; i++) p[i] = (float)from[i];
  ylm_free(from);
  return p;
}

/* Uniform lights of fixed power in all. */
static void measure_times(int set, size_t most) {
  size_t points = sets[set].n;
  float *p = points_of(set);
  printf("us per point, one thread, %s, lmax %d, rgb, uniform lights of fixed power in all\n"
         "%8s  %-9s %9s %9s %9s\n",
         sets[set].name, LMAX, "lights", "tolerance", "value", "gradient", "bake");
  for (size_t n = 1000; n <= most; n *= 10) {
    lamps l = scene(UNIFORM, n);
    for (size_t i = 0; i < n; i++) l.radius[i] = 0.5 / sqrt((double)n) / 20;
    ylm_light_set *lights = lights_of(&l);
    if (n <= (set == ANYWHERE ? 100000 : 1000)) {
      printf("%8zu  %-9s", n, "exact");
      print_times(ylm_light_set_field(lights), points, p);
    }
    double begin = ylm_seconds();
    for (double tolerance = 1e-1; n > 1000 && tolerance > 5e-4; tolerance /= 10) {
      ylm_light_cut *cut = bench_cut(lights, tolerance);
      if (tolerance > 0.05 && set == ANYWHERE)
        printf("%8zu  tree made in %.2f s, %.0f bytes per light\n", n, ylm_seconds() - begin,
               (double)ylm_light_set_tree_bytes(lights) / (double)n);
      printf("%8zu  %-9.3g", n, tolerance);
      print_times(ylm_light_cut_field(cut), points, p);
      ylm_light_cut_free(cut);
    }
    ylm_light_set_free(lights);
    scene_free(&l);
  }
  ylm_free(p);
}

/* The errors of all scenes at n points of a set; true if they are as promised. */
static bool measure_scenes(size_t lights, int set, size_t n, size_t sample) {
  bool kept = true;
  printf("tree of lights: errors over tolerance (99.9 %%, largest) and lights and proxies summed, "
         "%zu lights, %zu points, %s, lmax %d\n%-13s %-9s",
         lights, n, sets[set].name, LMAX, "lights", "tolerance");
  for (int k = 0; k < FORMS; k++) printf("  %-18s", forms[k]);
  printf("\n");
  for (int kind = 0; kind < SCENES; kind++)
    kept &= measure_errors(kind, lights, set, n, sample < n ? sample : n);
  return kept;
}

int main(void) {
  bool quick = bench_is_quick(), kept = true;
  kept &= measure_scenes(10000, SCATTERED, quick ? 1000 : 10000, 10000);
  if (!quick) kept &= measure_scenes(100000, SCATTERED, 2000, 2000);
  for (int set = GRID; set <= FLOOR && !quick; set++)
    kept &= measure_scenes(100000, set, sets[set].n, 2000);
  for (int set = 0; set < (quick ? 1 : SETS); set++) measure_times(set, quick ? 10000 : 1000000);
  printf("%s\n", kept ? "all within the tolerance" : "NOT within the tolerance");
  return !kept;
}
