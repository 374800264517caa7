/*
** flat.c - fields of exact flat lights: microseconds per light-point pair of squares and of disks,
** seen from all sides, whole and cut by a horizon, by the kernels in use and by the reference.
*/
#include <math.h>

#include "bench.h"
#include "ylm_light.h"

#define LIGHTS 8
#define POINTS 64

typedef struct job {
  const ylm_light_set *lights;
  ylm_isa isa;
  ylm_field_query q;
  const void *points;
  ylm_field_result r;
} job;

static void evaluate(void *context) {
  job *j = context;
  ylm_light_set_evaluate(j->lights, j->isa, &j->q, POINTS, j->points, &j->r, NULL);
}

/* Squares or disks of the same size, turned every way, in the unit cube about the origin. */
static ylm_light_set *lights_of(bool disks, const double *horizon) {
  double record[LIGHTS][7 + 12], radiance[LIGHTS][3], c[LIGHTS][3], u[LIGHTS][3];
  double *out = record[0];
  ylm_light_set *lights = NULL;
  bench_fill(YLM_DOUBLE, c, 3 * LIGHTS), bench_fill(YLM_DOUBLE, radiance, 3 * LIGHTS);
  bench_fill(YLM_DOUBLE, u, 3 * LIGHTS);
  for (int i = 0; i < LIGHTS; i++) {
    double x = u[i][1], y = -u[i][0], size = 0.4 / hypot(x, y);
    double v[3] = {x * size, y * size, 0}, up[3] = {-y * 0.2, x * 0.2, 0.2};
    for (int a = 0; a < 3; a++) *out++ = radiance[i][a];
    for (int a = 0; a < 3; a++) *out++ = horizon ? horizon[a] : 0;
    *out++ = disks ? 0 : 4;
    for (int k = 0; k < (disks ? 3 : 4); k++)
      for (int a = 0; a < 3; a++) {
        double corner = c[i][a] + (k == 0 || k == 3 ? v[a] : -v[a]) + (k < 2 ? up[a] : -up[a]);
        *out++ = disks ? k == 0 ? c[i][a] : k == 1 ? v[a] : up[a] : corner;
      }
  }
  ylm_light_source all = {"polygon", record[0], (size_t)(out - record[0]), NULL, NULL};
  return ylm_light_set_create(1, &all, &lights, NULL) == YLM_OK ? lights : NULL;
}

static void line(job *j, const char *name, ylm_dtype t) {
  static const int want[3] = {1, 3, 7};
  printf("%-18s %-9s %-6s", name, ylm_isa_name(j->isa), t == YLM_DOUBLE ? "double" : "float");
  j->q.dtype = t;
  for (int lmax = 4; lmax <= 8; lmax += 4)
    for (int k = 0; k < 3; k++) {
      j->q.lmax = lmax, j->q.want = want[k];
      printf(" %9.3g", bench_seconds(evaluate, j) * 1e6 / LIGHTS / POINTS);
      fflush(stdout);
    }
  printf("\n");
}

int main(void) {
  static const double up[3] = {0, 0.6, 0.8};
  static double x[2][3 * POINTS], value[POINTS * 81], gradient[POINTS * 243], hessian[POINTS * 486];
  job j = {.q = {.threads = 1, .channels = 1, .metric_channels = 1}};
  j.r = (ylm_field_result){.value = value, .gradient = gradient, .hessian = hessian};
  printf("flat lights, exact: us per light-point pair, one thread; %d lights, %d points\n", LIGHTS,
         POINTS);
  printf("%-34s  lmax 4: value, gradient, Hessian; lmax 8\n", "");
  for (int t = 0; t < 2; t++) {
    bench_fill(t ? YLM_DOUBLE : YLM_FLOAT, x[t], 3 * POINTS);
    for (int i = 0; i < 3 * POINTS; i++) {
      if (t)
        x[t][i] *= 2;
      else
        ((float *)x[t])[i] *= 2;
    }
  }
  for (int k = 0; k < 4; k++) {
    static const char *const names[4] = {"squares", "disks", "squares, horizon", "disks, horizon"};
    ylm_light_set *lights = lights_of(k % 2 != 0, k > 1 ? up : NULL);
    if (!lights) return 1;
    j.lights = lights;
    for (int i = 0; i < 2; i++)
      for (int t = 0; t < 2; t++) {
        j.isa = i ? YLM_ISA_reference : ylm_isa_current();
        j.points = x[t];
        line(&j, names[k], t ? YLM_DOUBLE : YLM_FLOAT);
      }
    ylm_light_set_free(lights);
  }
  return 0;
}
