/*
** virtual.c - fields of virtual lights beside those of sphere lights in the same run: nanoseconds per
** light-point pair, and the ratio. All lights face the points; nothing is left out.
*/
#include "bench.h"
#include "ylm_light.h"
#include "ylm_light_virtual.h"

#define LIGHTS 2000
#define POINTS 64

typedef struct job {
  const ylm_light_set *set;
  ylm_isa isa;
  ylm_field_query q;
  float points[POINTS][3];
  ylm_field_result r;
} job;

static const struct form {
  const char *name;
  int want;
} forms[] = {{"rgb value", 1},
             {"rgb gradient", 3},
             {"a bake's point", 3 | 8 | YLM_WANT_ROUGH},
             {"to a threshold", 3 | 8}};

static double at[LIGHTS][3], radius[LIGHTS], normal[LIGHTS][3], emission[LIGHTS][3][81];

static void evaluate(void *context) {
  job *j = context;
  ylm_light_set_evaluate(j->set, j->isa, &j->q, POINTS, j->points, &j->r, NULL);
}

static ylm_light_set *spheres(void) {
  ylm_light_set *s = NULL;
  return ylm_light_set_spheres(LIGHTS, at[0], radius, normal[0], &s, NULL) == YLM_OK ? s : NULL;
}

static ylm_light_set *virtuals(ylm_light_virtual_profile profile, int degree) {
  size_t wide = YLM_LIGHT_VIRTUAL_NUMBERS(degree);
  double *b = ylm_alloc(LIGHTS * 3 * wide, sizeof *b);
  for (size_t i = 0; b && i < LIGHTS; i++)
    for (size_t c = 0; c < 3; c++) memcpy(b + (3 * i + c) * wide, emission[i][c], wide * sizeof *b);
  ylm_light_virtual_form f = {LIGHTS, at[0], normal[0], radius, NULL, degree, b, profile, 0.2};
  ylm_light_virtual *v = NULL;
  ylm_light_set *s = NULL;
  if (b && ylm_light_virtual_create(&f, &v, NULL) == YLM_OK) ylm_light_set_virtual(v, &s, NULL);
  ylm_light_virtual_free(v);
  ylm_free(b);
  return s;
}

/* Lamps in the unit cube about the origin that face points beside it. */
static void place(job *j) {
  bench_fill(YLM_DOUBLE, at, sizeof at / sizeof(double));
  bench_fill(YLM_DOUBLE, emission, sizeof emission / sizeof(double));
  bench_fill(YLM_FLOAT, j->points, sizeof j->points / sizeof(float));
  for (int i = 0; i < LIGHTS; i++) radius[i] = 0.05, normal[i][0] = 1, emission[i][0][0] = 2;
  for (int i = 0; i < POINTS; i++) j->points[i][0] += 4;
}

static double measure(job *j, const ylm_light_set *set) {
  j->set = set;
  return bench_seconds(evaluate, j) * 1e9 / LIGHTS / POINTS;
}

int main(void) {
  static job j;
  static const int degrees[] = {0, 1, 2, 4};
  place(&j);
  size_t most = POINTS * 3 * 81;
  j.r.value = ylm_alloc(most, 4), j.r.gradient = ylm_alloc(most, 12),
  j.r.lambda = ylm_alloc(POINTS, 4);
  j.r.norm = ylm_alloc(POINTS, 4);
  ylm_light_set *ball = spheres();
  printf("ns a pair (over sphere lights, measured before and after), one thread, %d lights, %d "
         "points\n\n",
         LIGHTS, POINTS);
  printf("| kernels | lmax | form | spheres | gauss, degree 0 | 1 | 2 | 4 | cap, 0 | point, 0 | "
         "far, 0 |\n");
  printf("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (int isa = YLM_ISA_COUNT - 1; isa > 0; isa--) {
    if (!ylm_isa_available((ylm_isa)isa)) continue;
    if (bench_is_quick() && isa != (int)ylm_isa_current()) continue;
    for (int lmax = 2; lmax <= 8; lmax *= 2)
      for (size_t f = 0; f < sizeof forms / sizeof *forms; f++) {
        j.isa = (ylm_isa)isa;
        j.q = (ylm_field_query){.lmax = lmax,
                                .channels = 3,
                                .want = forms[f].want,
                                .metric_channels = 1,
                                .dtype = YLM_FLOAT,
                                .threads = 1};
        double base = measure(&j, ball);
        printf("| %s | %d | %s | %.2f |", ylm_isa_name(j.isa), lmax, forms[f].name, base);
        for (int k = 0; k < 7; k++) {
          static const ylm_light_virtual_profile profiles[] = {
              YLM_LIGHT_VIRTUAL_CAP, YLM_LIGHT_VIRTUAL_POINT, YLM_LIGHT_VIRTUAL_FAR};
          ylm_light_set *s =
              virtuals(k < 4 ? YLM_LIGHT_VIRTUAL_GAUSS : profiles[k - 4], k < 4 ? degrees[k] : 0);
          if (!s) return 1;
          double t = measure(&j, s), again = measure(&j, ball);
          printf(" %.2f (%.2f) |", t, t / (0.5 * (base + again)));
          fflush(stdout);
          base = again;
          ylm_light_set_free(s);
        }
        printf("\n");
      }
  }
  ylm_light_set_free(ball);
  return 0;
}
