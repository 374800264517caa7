/*
** many_virtual.c - the tree of virtual lights: errors, and times beside the tree of sphere lights.
**
** Errors are against exact sums in double; in units of the tolerance, the quantiles 0.5, 0.99, 0.999 and the
** largest over points. Promised: 0.999 at most 1, the largest at most 4. Times are processor time of one thread at
** the same places of lights and points, in one run. BENCH=quick takes fewer lights and points.
*/
#include <math.h>
#include <time.h>

#include "bench.h"
#include "many.h"
#include "ylm_light_virtual.h"

#ifndef LMAX
#define LMAX 4
#endif
#define COUNT ((LMAX + 1) * (LMAX + 1))
#define WIDTH (3 * COUNT)

static const double tolerances[] = {1e-1, 1e-2, 1e-3};

/* -- scenes in the unit cube ----------------------------------------------------------------- */

typedef struct lamps {
  size_t n;
  int degree;
  ylm_light_virtual_profile profile;
  double core, *at, *normal, *radius, *emission, *radiance;
} lamps;

enum { ROOM, FURNISHED, CLOUD, BALLS, GLOSSY, FAR, CAPS, SCENES };
static const char *const names[SCENES] = {"room",   "furnished", "cloud", "balls",
                                          "glossy", "far",       "caps"};

static void unit(double *n) {
  double d = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  for (int a = 0; a < 3; a++) n[a] /= d;
}

/* A place on a wall, its normal inwards. */
static void on_wall(ylm_rng *r, double *at, double *n) {
  uint32_t wall = ylm_rng_u32(r) % 6;
  for (int a = 0; a < 3; a++) at[a] = ylm_rng_double(r), n[a] = 0;
  at[wall % 3] = wall < 3 ? 1 : 0;
  n[wall % 3] = wall < 3 ? -1 : 1;
}

/* A place on one of forty balls. */
static void on_ball(ylm_rng *r, const double (*ball)[4], double *at, double *n) {
  const double *b = ball[ylm_rng_u32(r) % 40];
  for (int a = 0; a < 3; a++) n[a] = bench_normal(r);
  unit(n);
  for (int a = 0; a < 3; a++) at[a] = b[a] + b[3] * n[a];
}

static lamps scene(int kind, size_t n) {
  int degree = kind == GLOSSY ? 2 : 0;
  size_t wide = YLM_LIGHT_VIRTUAL_NUMBERS(degree);
  lamps l = {n,
             degree,
             kind == FAR    ? YLM_LIGHT_VIRTUAL_FAR
             : kind == CAPS ? YLM_LIGHT_VIRTUAL_CAP
                            : YLM_LIGHT_VIRTUAL_GAUSS,
             0,
             ylm_alloc(n, 24),
             ylm_alloc(n, 24),
             ylm_alloc(n, 8),
             ylm_alloc_zero(n, 24 * wide),
             ylm_alloc(n, 24)};
  ylm_rng r;
  ylm_rng_seed(&r, 7, (uint64_t)kind);
  double ball[40][4], size = sqrt(3.0 / (double)n);
  for (int i = 0; i < 40; i++) {
    for (int a = 0; a < 3; a++) ball[i][a] = 0.15 + 0.7 * ylm_rng_double(&r);
    ball[i][3] = 0.02 + 0.1 * ylm_rng_double(&r);
  }
  l.core = 3 * sqrt(6.0 / (double)n);
  for (size_t i = 0; i < n; i++) {
    double *at = l.at + 3 * i, *m = l.normal + 3 * i;
    if (kind == CLOUD || (kind == GLOSSY && i % 2)) {
      for (int a = 0; a < 3; a++) at[a] = ylm_rng_double(&r), m[a] = bench_normal(&r);
      unit(m);
    } else if (kind == BALLS || (kind != ROOM && kind != FAR && i % 2)) {
      on_ball(&r, (const double(*)[4])ball, at, m);
    } else
      on_wall(&r, at, m);
    l.radius[i] = size * (kind == FURNISHED ? 0.5 + ylm_rng_double(&r) : 1);
    /* lit by a lamp: walls of one radiance would give a field without gradients */
    double lamp[3] = {at[0] - 0.3, at[1] - 0.8, at[2] - 0.4}, lit = 0.02;
    lit += 0.1 / (0.05 + lamp[0] * lamp[0] + lamp[1] * lamp[1] + lamp[2] * lamp[2]);
    for (int c = 0; c < 3; c++) {
      double e = (1 + 0.5 * c) * lit * (kind == ROOM ? 1 : 0.2 + ylm_rng_double(&r));
      l.emission[(3 * i + (size_t)c) * wide] = e * sqrt(4 * YLM_PI);
      for (size_t q = 1; q < wide; q++)
        l.emission[(3 * i + (size_t)c) * wide + q] = 2 * e * (ylm_rng_double(&r) - 0.5);
      l.radiance[3 * i + (size_t)c] = e;
    }
  }
  return l;
}

static void scene_free(lamps *l) {
  ylm_free(l->at), ylm_free(l->normal), ylm_free(l->radius);
  ylm_free(l->emission), ylm_free(l->radiance);
}

static ylm_light_set *lights_of(const lamps *l) {
  ylm_light_virtual_form f = {l->n,      l->at,       l->normal,  l->radius, NULL,
                              l->degree, l->emission, l->profile, l->core};
  ylm_light_virtual *v = NULL;
  ylm_light_set *s = NULL;
  ylm_error e;
  if (ylm_light_virtual_create(&f, &v, &e) != YLM_OK ||
      ylm_light_set_virtual(v, &s, &e) != YLM_OK) {
    fprintf(stderr, "%s\n", e.text);
    exit(1);
  }
  ylm_light_virtual_free(v);
  return s;
}

/* Where points are: anywhere, half of them on a floor; corners of a uniform grid; a floor's shading points. */
enum { ANYWHERE, RANDOM, GRID, FLOOR, SETS };
static const struct {
  const char *name;
  size_t n, side;
} sets[] = {{"256 anywhere", 256, 0},
            {"4096 in the cube", 4096, 0},
            {"a grid of 32^3", 32768, 32},
            {"a floor of 256^2", 65536, 256}};

static void *places(int set, size_t n, ylm_dtype t) {
  size_t side = sets[set].side;
  void *p = ylm_alloc(n, 3 * ylm_dtype_size(t));
  ylm_rng r;
  ylm_rng_seed(&r, 3, 3);
  for (size_t i = 0; i < n; i++) {
    size_t cell[3] = {0, 0, 0};
    double x[3];
    if (side) cell[0] = i % side, cell[1] = i / side % side, cell[2] = i / side / side;
    for (size_t a = 0; a < 3; a++)
      x[a] = side ? ((double)cell[a] + 0.5) / (double)side : ylm_rng_double(&r);
    if (set == ANYWHERE && i & 1) x[1] = 0.01;
    if (set == FLOOR) x[2] = 0.3;
    for (size_t a = 0; a < 3; a++)
      if (t == YLM_DOUBLE)
        ((double *)p)[3 * i + a] = (double)(float)x[a];
      else
        ((float *)p)[3 * i + a] = (float)x[a];
  }
  return p;
}

/* -- errors ----------------------------------------------------------------------------------- */

enum { VALUE, GRADIENT, BAKE, HESSIAN, FORMS };
static const int wants[FORMS] = {YLM_WANT_VALUE, YLM_WANT_VALUE | YLM_WANT_GRADIENT,
                                 YLM_WANT_VALUE | YLM_WANT_GRADIENT | YLM_WANT_METRIC |
                                     YLM_WANT_ROUGH,
                                 YLM_WANT_VALUE | YLM_WANT_GRADIENT | YLM_WANT_HESSIAN};
static const char *const forms[FORMS] = {"value", "gradient", "lambda", "Hessian"};

typedef struct answer {
  void *value, *gradient, *hessian, *lambda, *norm;
  double pairs;
} answer;

static answer ask(const ylm_field *f, ylm_dtype t, size_t n, const void *points, int form,
                  int threads) {
  size_t b = ylm_dtype_size(t);
  answer a = {ylm_alloc(n, b * WIDTH),
              ylm_alloc(n, 3 * b * WIDTH),
              form == HESSIAN ? ylm_alloc(n, 6 * b * WIDTH) : NULL,
              ylm_alloc(n, b),
              ylm_alloc(n, b),
              0};
  ylm_field_query q = {.lmax = LMAX,
                       .channels = 3,
                       .want = wants[form],
                       .metric_channels = 1,
                       .dtype = t,
                       .threads = threads};
  ylm_field_result r = {.value = a.value,
                        .gradient = a.gradient,
                        .hessian = a.hessian,
                        .lambda = a.lambda,
                        .norm = a.norm};
  ylm_error e;
  if (f->evaluate(f, &q, n, points, &r, &e) != YLM_OK) {
    fprintf(stderr, "%s\n", e.text);
    exit(1);
  }
  a.pairs = (double)r.pairs;
  return a;
}

static void answer_free(answer *a) {
  ylm_free(a->value), ylm_free(a->gradient), ylm_free(a->hessian);
  ylm_free(a->lambda), ylm_free(a->norm);
}

/* The error of point i in what a form looks at, relative to the exact norm. */
static double error_of(const answer *a, const answer *exact, size_t i, int form) {
  static const double times[6] = {1, 2, 2, 1, 2, 1};
  size_t w = form == BAKE ? 1 : form == VALUE ? WIDTH : form == GRADIENT ? 3 * WIDTH : 6 * WIDTH;
  const float *all[FORMS] = {a->value, a->gradient, a->lambda, a->hessian}, *x = all[form] + i * w;
  const double *real[FORMS] = {exact->value, exact->gradient, exact->lambda, exact->hessian},
               *y = real[form] + i * w;
  double s = 0, norm = 0;
  for (size_t k = 0; k < w; k++) {
    double d = (double)x[k] - y[k], m = form == HESSIAN ? times[k % 6] : 1;
    s += m * d * d, norm += m * y[k] * y[k];
  }
  return sqrt(s / fmax(norm, 1e-300));
}

/* Errors of a scene at n points: true if they are as promised. */
static bool measure_errors(int kind, size_t lights, size_t n) {
  lamps l = scene(kind, lights);
  ylm_light_set *set = lights_of(&l);
  double *points = places(ANYWHERE, n, YLM_DOUBLE), *e = ylm_alloc(n, sizeof *e);
  float *single = places(ANYWHERE, n, YLM_FLOAT);
  bool kept = true;
  for (int form = 0; form < FORMS; form++) {
    answer exact = ask(ylm_light_set_field(set), YLM_DOUBLE, n, points, form, 0);
    printf("%-10s %-9s", names[kind], forms[form]);
    for (int t = 0; t < 3; t++) {
      ylm_light_cut *cut = bench_cut(set, tolerances[t]);
      answer a = ask(ylm_light_cut_field(cut), YLM_FLOAT, n, single, form, 0);
      for (size_t i = 0; i < n; i++) e[i] = error_of(&a, &exact, i, form) / tolerances[t];
      qsort(e, n, sizeof *e, bench_upwards);
      double high = e[(size_t)ceil(0.999 * (double)n) - 1], most = e[n - 1];
      printf(" | %5.3f %5.3f %5.3f %5.2f %6.0f", e[n / 2], e[(size_t)ceil(0.99 * (double)n) - 1],
             high, most, a.pairs / (double)n);
      kept = kept && high <= 1 && most <= 4;
      answer_free(&a);
      ylm_light_cut_free(cut);
    }
    printf("\n");
    fflush(stdout);
    answer_free(&exact);
  }
  ylm_free(points), ylm_free(single), ylm_free(e);
  ylm_light_set_free(set);
  scene_free(&l);
  return kept;
}

/* -- time ------------------------------------------------------------------------------------- */

/* The least processor time of three, in microseconds a point; pairs a point. */
static double time_of(const ylm_field *f, size_t n, const float *points, int form, double *pairs) {
  double least = 1e30;
  for (int turn = 0; turn < 3; turn++) {
    struct timespec a, b;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &a);
    answer x = ask(f, YLM_FLOAT, n, points, form, 1);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &b);
    *pairs = x.pairs / (double)n;
    answer_free(&x);
    least = fmin(least, (double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec));
  }
  return 1e6 * least / (double)n;
}

/* Seconds of one thread, and bytes a light, of making a tree. */
static double build(ylm_light_set *set, double *bytes) {
  double begin = ylm_seconds();
  ylm_light_cut *cut = NULL;
  if (ylm_light_cut_create(set, 0.01, 1, &cut, NULL) != YLM_OK) abort();
  double seconds = ylm_seconds() - begin;
  *bytes = (double)ylm_light_set_tree_bytes(set) / (double)ylm_light_set_count(set);
  ylm_light_cut_free(cut);
  return seconds;
}

static void measure_times(int kind, size_t n, int from, int to) {
  lamps l = scene(kind, n);
  ylm_light_set *set = lights_of(&l), *spheres = NULL;
  double bytes[2], seconds[2], pairs[2];
  for (size_t i = 0; i < n; i++) l.radius[i] *= 0.2; /* lamps that no point is inside of */
  if (ylm_light_set_spheres(n, l.at, l.radius, l.radiance, &spheres, NULL) != YLM_OK) abort();
  seconds[0] = build(spheres, &bytes[0]);
  seconds[1] = build(set, &bytes[1]);
  printf("%s, %zu lights, one thread: trees made in %.2f s (spheres %.2f, ratio %.2f), %.0f bytes "
         "a light (spheres "
         "%.0f)\n",
         names[kind], n, seconds[1], seconds[0], seconds[1] / seconds[0], bytes[1], bytes[0]);
  for (int p = from; p < to; p++) {
    float *points = places(p, sets[p].n, YLM_FLOAT);
    for (int t = 0; t < 3; t++) {
      ylm_light_cut *cut[2] = {bench_cut(spheres, tolerances[t]), bench_cut(set, tolerances[t])};
      printf("%-17s %-6g", sets[p].name, tolerances[t]);
      for (int form = 0; form < HESSIAN; form++) {
        double us[2];
        for (int k = 0; k < 2; k++)
          us[k] = time_of(ylm_light_cut_field(cut[k]), sets[p].n, points, form, &pairs[k]);
        printf(" | %-8s %7.2f %7.2f us, ratio %5.2f, pairs %5.0f %5.0f",
               form == BAKE ? "bake" : forms[form], us[0], us[1], us[1] / us[0], pairs[0],
               pairs[1]);
      }
      printf("\n");
      fflush(stdout);
      for (int k = 0; k < 2; k++) ylm_light_cut_free(cut[k]);
    }
    ylm_free(points);
  }
  double us[FORMS], unused;
  float *points = places(ANYWHERE, 64, YLM_FLOAT);
  for (int form = 0; form < HESSIAN && n <= 100000; form++)
    us[form] = time_of(ylm_light_set_field(set), 64, points, form, &unused);
  if (n <= 100000)
    printf("exact sums: value %.0f, gradient %.0f, bake %.0f us\n", us[0], us[1], us[2]);
  ylm_free(points);
  ylm_light_set_free(set), ylm_light_set_free(spheres);
  scene_free(&l);
}

int main(int argc, char **argv) {
  bool quick = bench_is_quick(), kept = true;
  size_t lights = quick ? 5000 : 20000, points = quick ? 1000 : 4000;
  int only = argc > 1 ? atoi(argv[1]) : -1;
  printf("tree of virtual lights: errors over tolerance .1 | .01 | .001: 50 %%, 99 %%, 99.9 %%, "
         "largest; lights and "
         "proxies a point; %zu lights, %zu points, lmax %d\n",
         lights, points, LMAX);
  for (int kind = 0; kind < SCENES && only != 100; kind++)
    if (only < 0 || only == kind) kept &= measure_errors(kind, lights, points);
  printf("us a point of the spheres' tree and of virtual lights', lmax %d, rgb\n", LMAX);
  if (only < 0 || only == 100) {
    measure_times(ROOM, quick ? 10000 : 100000, ANYWHERE, quick ? 1 : SETS);
    if (!quick) measure_times(FURNISHED, 100000, ANYWHERE, SETS);
    if (!quick) measure_times(GLOSSY, 100000, RANDOM, GRID);
    if (!quick) measure_times(ROOM, 1000000, ANYWHERE, GRID);
  }
  printf("%s\n", kept ? "all within the tolerance" : "NOT within the tolerance");
  return !kept;
}
