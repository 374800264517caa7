/*
** kernels.c - compares what sets of kernels compute: lights, grids, rotations and products.
**
**     YLM_ISA=reference kernels FILE            writes every result
**     YLM_ISA=neon      kernels FILE compare    works it out again, and says how far off it is
**
** spec/neon_spec.lua builds it for aarch64 and runs it under qemu-user. Prints the largest error of
** each kind, relative to the largest number of its array, and "ok" where all are within bounds.
*/
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ylm_grid.h"
#include "ylm_light.h"
#include "ylm_rival.h"
#include "ylm_sh.h"

enum { POINTS = 11, LIGHTS = 9 }; /* neither is a multiple of what a kernel works on at once */

static void stop(const char *where, ylm_status s) {
  if (s == YLM_OK) return;
  printf("%s: %s\n", where, ylm_status_text(s));
  exit(1);
}

static void *room(size_t n) {
  void *p = ylm_alloc_zero(n, sizeof(double));
  if (!p) stop("room", YLM_ENOMEM);
  return p;
}

static FILE *file;
static bool comparing;
static struct worst {
  const char *what;
  double error[2];
} table[16];

/* The place in the table of a kind of result. */
static struct worst *find(const char *what) {
  struct worst *w = table;
  while (w->what && strcmp(w->what, what) != 0) w++;
  w->what = what;
  return w;
}

/* Writes n numbers to the file, or holds them against those that stand there. */
static void result(const char *what, ylm_dtype t, size_t n, const void *x) {
  if (!comparing) {
    if (fwrite(x, ylm_dtype_size(t), n, file) != n) stop("file", YLM_EIO);
    return;
  }
  void *other = room(n);
  if (fread(other, ylm_dtype_size(t), n, file) != n) stop("file", YLM_EIO);
  double largest = 0, off = 0;
  for (size_t i = 0; i < n; i++) {
    double a = t ? ((const double *)x)[i] : (double)((const float *)x)[i];
    double b = t ? ((const double *)other)[i] : (double)((const float *)other)[i];
    if (!(fabs(a - b) <= off)) off = fabs(a - b); /* a NaN stays */
    if (!(fabs(b) <= largest)) largest = fabs(b);
  }
  double *worst = &find(what)->error[t];
  if (!(off <= *worst * largest)) *worst = off / largest;
  ylm_free(other);
}

/* n numbers of [-1, 1) that a float holds, as both types. */
static void random_numbers(uint64_t seed, size_t n, double *d, float *f) {
  ylm_rng r;
  ylm_rng_seed(&r, seed, 1);
  for (size_t i = 0; i < n; i++) d[i] = (double)(f[i] = (float)(2 * ylm_rng_double(&r) - 1));
}

static ylm_light_set *some_lights(void) {
  double x[7 * LIGHTS], radius[LIGHTS];
  float unused[7 * LIGHTS];
  random_numbers(3, 7 * LIGHTS, x, unused);
  for (int i = 0; i < LIGHTS; i++) {
    double *at = x + 3 * i; /* from 3 to 5 from the origin: outside of all points */
    double d = sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
    for (int a = 0; a < 3; a++) at[a] *= (4 + x[6 * LIGHTS + i]) / d;
    radius[i] = 0.05 + 0.4 * (i % 3);
  }
  ylm_light_set *l;
  ylm_error e;
  stop("lights", ylm_light_set_spheres(LIGHTS, x, radius, x + 3 * LIGHTS, &l, &e));
  return l;
}

static void light_sums(const ylm_light_set *lights, const double *pd, const float *pf) {
  for (int t = 0; t < 2; t++)
    for (int lmax = 0; lmax <= 12; lmax++)
      for (int channels = 1; channels <= 3; channels += 2) {
        size_t count = ylm_sh_count(lmax) * (size_t)channels * POINTS;
        ylm_field_query q = {.lmax = lmax,
                             .channels = channels,
                             .metric_channels = channels,
                             .want = YLM_WANT_VALUE | YLM_WANT_GRADIENT | YLM_WANT_HESSIAN |
                                     YLM_WANT_METRIC,
                             .dtype = (ylm_dtype)t,
                             .threads = 1};
        ylm_field_result r = {.value = room(count),
                              .gradient = room(3 * count),
                              .hessian = room(6 * count),
                              .lambda = room(POINTS),
                              .norm = room(POINTS)};
        uint8_t inside[POINTS];
        r.inside = inside;
        ylm_error e;
        stop("evaluate", ylm_light_set_evaluate(lights, ylm_isa_current(), &q, POINTS,
                                                t ? (const void *)pd : pf, &r, &e));
        result("light", q.dtype, count, r.value);
        result("light gradient", q.dtype, 3 * count, r.gradient);
        result("light hessian", q.dtype, 6 * count, r.hessian);
        result("light lambda", q.dtype, POINTS, r.lambda);
        result("light norm", q.dtype, POINTS, r.norm);
        ylm_free(r.value), ylm_free(r.gradient), ylm_free(r.hessian);
        ylm_free(r.lambda), ylm_free(r.norm);
      }
}

static void grid_samples(const ylm_light_set *lights, const double *pd) {
  for (int lmax = 1; lmax <= 4; lmax += 3) {
    ylm_grid_form form = {.kind = YLM_GRID_UNIFORM,
                          .bounds = {-1, -1, -1, 1, 1, 1},
                          .lmax = lmax,
                          .channels = 3,
                          .cells = {3, 2, 4}};
    ylm_grid_source source = {.field = ylm_light_set_field(lights), .threads = 1};
    ylm_grid *g;
    ylm_error e;
    stop("bake", ylm_grid_bake(&form, &source, &g, &e));
    size_t count = ylm_sh_count(lmax) * 3 * POINTS;
    double *value = room(count), *gradient = room(3 * count);
    for (int k = 0; k < 3; k++) {
      ylm_grid_query q = {.interpolation = (ylm_grid_interpolation)k,
                          .point_dtype = YLM_DOUBLE,
                          .dtype = YLM_FLOAT,
                          .threads = 1};
      ylm_grid_report report;
      stop("sample", ylm_grid_sample(g, &q, POINTS, pd, value, gradient, &report, &e));
      result("grid", q.dtype, count, value);
      result("grid gradient", q.dtype, 3 * count, gradient);
    }
    ylm_free(value), ylm_free(gradient);
    ylm_grid_free(g);
  }
}

static void rotations_and_products(void) {
  static const int degrees[] = {1, 2, 4, 6, 9};
  static const ylm_sh_product_method methods[] = {YLM_SH_PRODUCT_gaunt, YLM_SH_PRODUCT_fourier,
                                                  YLM_SH_PRODUCT_quadrature};
  double cd[2 * POINTS * 100];
  float cf[2 * POINTS * 100];
  random_numbers(5, 2 * POINTS * 100, cd, cf);
  const double axis[3] = {1, 2, 3};
  double r[9];
  ylm_error e;
  ylm_rival_register();
  stop("axis", ylm_sh_rotation_from_axis(axis, 1, r, &e));
  ylm_sh_rotator *rotator;
  stop("rotator", ylm_sh_rotator_create(9, &rotator, &e));
  double *out = room(POINTS * 100);
  for (int t = 0; t < 2; t++)
    for (size_t k = 0; k < sizeof degrees / sizeof *degrees; k++) {
      int lmax = degrees[k];
      size_t count = ylm_sh_count(lmax), n = POINTS * count;
      const void *a = t ? (const void *)cd : cf;
      const void *b = t ? (const void *)(cd + n) : cf + n;
      stop("rotate", ylm_sh_rotate(rotator, r, lmax, (ylm_dtype)t, POINTS, a, out, 1, NULL, &e));
      result("rotate", (ylm_dtype)t, n, out);
      for (int m = 0; m < 3; m++) {
        ylm_sh_product *p;
        stop("plan", ylm_sh_product_create(lmax, 2, methods[m], methods[m], &p, &e));
        const void *factor[2] = {a, b};
        size_t stride[2] = {count, count};
        stop("product",
             ylm_sh_product_apply(p, (ylm_dtype)t, POINTS, factor, stride, out, 1, NULL, NULL));
        result("product", (ylm_dtype)t, n, out);
        ylm_sh_product_free(p);
      }
    }
  ylm_free(out);
  ylm_sh_rotator_free(rotator);
}

/* Prints the table; true if every error is within its bound. */
static bool report(void) {
  bool good = table[0].what;
  for (const struct worst *w = table; w->what; w++) {
    bool within = w->error[0] < 2e-5 && w->error[1] < 1e-12;
    printf("%-16s float %.2g double %.2g%s\n", w->what, w->error[0], w->error[1],
           within ? "" : "  TOO FAR OFF");
    good = good && within;
  }
  return good;
}

int main(int argc, char **argv) {
  if (argc < 2) return 2;
  comparing = argc > 2;
  file = fopen(argv[1], comparing ? "rb" : "wb");
  if (!file) stop("file", YLM_EIO);
  double pd[3 * POINTS];
  float pf[3 * POINTS];
  random_numbers(1, 3 * POINTS, pd, pf);
  ylm_light_set *lights = some_lights();
  light_sums(lights, pd, pf);
  grid_samples(lights, pd);
  rotations_and_products();
  ylm_light_set_free(lights);
  printf("%s\n", ylm_isa_name(ylm_isa_current()));
  if (fclose(file) != 0) stop("file", YLM_EIO);
  return comparing && !report() ? 1 : puts("ok") < 0;
}
