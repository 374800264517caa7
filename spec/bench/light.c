/* light.c - nanoseconds per light-point pair of fields of sphere lights: one thread, each kernel
 * set. */
#include "bench.h"
#include "ylm_light.h"

#define LIGHTS 2516
#define POINTS 64

typedef struct job {
  const ylm_lights *lights;
  ylm_isa isa;
  ylm_field_query q;
  void *points;
  ylm_field_result r;
} job;

/* What is asked for: its name, and the query. */
typedef struct form {
  const char *name;
  int channels, want;
  ylm_dtype t;
} form;

static const form forms[] = {
    {"float value", 1, 1, YLM_FLOAT},         {"float gradient", 1, 3, YLM_FLOAT},
    {"float Hessian", 1, 7, YLM_FLOAT},       {"float metric", 1, 8, YLM_FLOAT},
    {"rgb value", 3, 1, YLM_FLOAT},           {"rgb gradient", 3, 3, YLM_FLOAT},
    {"rgb grad+metric", 3, 3 | 8, YLM_FLOAT}, {"rgb Hessian", 3, 7, YLM_FLOAT},
    {"double value", 1, 1, YLM_DOUBLE},       {"double gradient", 1, 3, YLM_DOUBLE},
    {"double Hessian", 1, 7, YLM_DOUBLE},
};

static void evaluate(void *context) {
  job *j = context;
  ylm_lights_evaluate(j->lights, j->isa, &j->q, POINTS, j->points, &j->r, NULL);
}

/* Small lamps in the unit cube about the origin; points lie outside of it. */
static ylm_lights *lamps(void) {
  static double at[LIGHTS][3], radius[LIGHTS], radiance[LIGHTS][3];
  ylm_lights *lights = NULL;
  bench_fill(YLM_DOUBLE, at, 3 * LIGHTS);
  for (int i = 0; i < LIGHTS; i++) {
    radius[i] = 0.02;
    for (int a = 0; a < 3; a++) radiance[i][a] = 1 + a;
  }
  return ylm_lights_create(LIGHTS, at[0], radius, radiance[0], &lights, NULL) == YLM_OK ? lights
                                                                                        : NULL;
}

static void place_points(ylm_dtype t, void *points) {
  bench_fill(t, points, 3 * POINTS);
  for (int i = 0; i < POINTS; i++) {
    if (t == YLM_DOUBLE)
      ((double *)points)[3 * i] += 2.5;
    else
      ((float *)points)[3 * i] += 2.5f;
  }
}

int main(void) {
  static const int degrees[] = {1,  2,  3,  4,  5,  6,  7,  8,  9,  10,
                                11, 12, 13, 14, 15, 16, 17, 18, 19, 20};
  const size_t n = sizeof degrees / sizeof *degrees, most = POINTS * 3 * 441;
  job j = {.lights = lamps(), .q = {.threads = 1, .metric_channels = 1}};
  j.points = ylm_alloc(POINTS, 3 * sizeof(double));
  j.r.value = ylm_alloc(most, 8), j.r.gradient = ylm_alloc(most, 24),
  j.r.hessian = ylm_alloc(most, 48);
  j.r.lambda = ylm_alloc(POINTS, 8), j.r.norm = ylm_alloc(POINTS, 8);
  if (!j.lights || !j.points || !j.r.value || !j.r.gradient || !j.r.hessian || !j.r.lambda ||
      !j.r.norm)
    return 1;
  printf("sphere lights: ns per light-point pair, %d lights, %d points, one thread, everything "
         "included\n",
         LIGHTS, POINTS);
  printf("%-9s %-16s", "kernel", "form");
  for (size_t k = 0; k < n; k++) printf(" lmax %-4d", degrees[k]);
  printf("\n");
  for (int isa = YLM_ISA_COUNT - 1; isa > YLM_ISA_reference; isa--) {
    if (!ylm_isa_available((ylm_isa)isa)) continue;
    j.isa = (ylm_isa)isa;
    for (size_t f = 0; f < sizeof forms / sizeof *forms; f++) {
      printf("%-9s %-16s", ylm_isa_name(j.isa), forms[f].name);
      j.q.channels = forms[f].channels, j.q.want = forms[f].want, j.q.dtype = forms[f].t;
      place_points(forms[f].t, j.points);
      for (size_t k = 0; k < n; k++) {
        j.q.lmax = degrees[k];
        if (bench_is_quick() && degrees[k] != 4 && degrees[k] != 8)
          printf(" %-9s", "-");
        else
          printf(" %-9.3g", bench_seconds(evaluate, &j) * 1e9 / LIGHTS / POINTS);
        fflush(stdout);
      }
      printf("\n");
    }
  }
  ylm_lights_free((ylm_lights *)j.lights);
  return 0;
}
