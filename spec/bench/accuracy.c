/*
** accuracy.c - errors of the sums over sphere lights against the reference, as parts of the bound
** of ylm_light.h, at positions that are hard: the worst of all points and of lmax 0 .. 31.
**
** Errors are L2 over all degrees, relative to the true sum; the bound is 4e-6 + 1.5e-7 c in float
** and 1e-13 + 1e-15 c in double with c = d/(d-r) of the nearest light. BENCH=quick takes every
** fifth lmax.
*/
#include <math.h>

#include "bench.h"
#include "ylm_light.h"

#define LMAX 31
#define COUNT ((LMAX + 1) * (LMAX + 1))
#define POINTS 64
#define LIGHTS 2048

/* Lights and points, exact in float. */
typedef struct scene {
  size_t n, points;
  float at[LIGHTS][3], radius[LIGHTS], radiance[LIGHTS], x[POINTS][3];
} scene;

/* A class of positions. One light of `radius` at `centre` (x, -x, x/2), points at `ratio` radii; or
   many lights (cone > 0) of radiances from 1 to `span` in a cone of this width, or all around. */
typedef struct kind {
  const char *name;
  double flat; /* directions: 0 a pole, below 1 within this angle of one, 1 anywhere */
  double radius, ratio, centre, cone, span;
} kind;

static const kind kinds[] = {
    {"touching, d = 1.001 r", 1, 0.5, 1.001, 0, 0, 0},
    {"touching, off the origin", 1, 0.37, 1.001, 3, 0, 0},
    {"touching, above or below", 0, 0.37, 1.001, 0, 0, 0},
    {"d = 1.1 r", 1, 0.37, 1.1, 0, 0, 0},
    {"d = 2 r", 1, 0.37, 2, 3, 0, 0},
    {"d = 10 r", 1, 0.37, 10, 0, 0, 0},
    {"above or below, d = 10 r", 0, 0.37, 10, 0, 0, 0},
    {"within 1 degree of the poles", 0.02, 0.37, 10, 0, 0, 0},
    {"within 10 degrees", 0.17, 0.37, 10, 0, 0, 0},
    {"within 30 degrees", 0.5, 0.37, 10, 0, 0, 0},
    {"far, d = 1e4 r", 1, 0.37, 1e4, 0, 0, 0},
    {"far, within 10 degrees", 0.17, 0.37, 1e4, 0, 0, 0},
    {"very far, d = 1e6 r", 1, 0.37, 1e6, 0, 0, 0},
    {"tiny, r = 1e-12 at 1", 1, 1e-12, 1e12, 0, 0, 0},
    {"tiny scene, r = 1e-9, d = 2 r", 1, 1e-9, 2, 0, 0, 0},
    {"huge scene, r = 1e9, d = 2 r", 1, 1e9, 2, 0, 0, 0},
    {"inside", 1, 0.37, 0.5, 0, 0, 0},
    {"2048 lights in one direction", 1, 0, 0, 0, 0.02, 1},
    {"2048 lights straight above", 0, 0, 0, 0, 0.02, 1},
    {"2048 all around", 1, 0, 0, 0, 2, 1},
    {"2048, radiance 1 to 1e6", 1, 0, 0, 0, 2, 1e6},
};

static double number(ylm_rng *r) { return 2 * ylm_rng_double(r) - 1; }

static void normalise(double *w) {
  double n = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  for (int a = 0; a < 3; a++) w[a] /= n;
}

static void direction(ylm_rng *r, double flat, double *w) {
  do {
    for (int a = 0; a < 3; a++) w[a] = number(r);
  } while (hypot(w[0], w[1]) < 0.01 || hypot(hypot(w[0], w[1]), w[2]) > 1);
  if (flat < 1) {
    double s = flat * sqrt(ylm_rng_double(r)) / hypot(w[0], w[1]);
    w[0] *= s, w[1] *= s, w[2] = w[2] < 0 ? -1 : 1;
  }
  normalise(w);
}

static void one_light(const kind *k, ylm_rng *r, scene *s) {
  const double centre[3] = {k->centre, -k->centre, 0.5 * k->centre};
  s->n = 1, s->points = POINTS, s->radius[0] = (float)k->radius, s->radiance[0] = 1;
  for (int a = 0; a < 3; a++) s->at[0][a] = (float)centre[a];
  for (size_t i = 0; i < POINTS; i++) {
    double w[3];
    direction(r, k->flat, w);
    for (int a = 0; a < 3; a++)
      s->x[i][a] = (float)((double)s->at[0][a] + w[a] * k->ratio * (double)s->radius[0]);
  }
}

static void many_lights(const kind *k, ylm_rng *r, scene *s) {
  double axis[3], w[3];
  direction(r, k->flat, axis);
  s->n = LIGHTS, s->points = 4;
  for (size_t i = 0; i < LIGHTS; i++) {
    double d = 2 + 2 * ylm_rng_double(r);
    direction(r, 1, w);
    for (int a = 0; a < 3; a++)
      s->at[i][a] = (float)(d * (k->cone > 1 ? w[a] : axis[a] + k->cone * w[a]));
    s->radius[i] = (float)(0.01 + 0.04 * ylm_rng_double(r));
    s->radiance[i] = (float)pow(k->span, ylm_rng_double(r));
  }
  for (size_t i = 0; i < s->points; i++)
    for (int a = 0; a < 3; a++) s->x[i][a] = (float)(0.001 * number(r));
}

static ylm_light_set *lights_of(const scene *s) {
  static double at[LIGHTS][3], radius[LIGHTS], radiance[LIGHTS][3];
  ylm_light_set *lights = NULL;
  for (size_t i = 0; i < s->n; i++) {
    radius[i] = (double)s->radius[i];
    for (int a = 0; a < 3; a++)
      at[i][a] = (double)s->at[i][a], radiance[i][a] = (double)s->radiance[i];
  }
  return ylm_light_set_spheres(s->n, at[0], radius, radiance[0], &lights, NULL) == YLM_OK ? lights
                                                                                          : NULL;
}

/* The bound at point i. */
static double bound(const scene *s, size_t i, ylm_dtype t) {
  double closest = 0;
  for (size_t j = 0; j < s->n; j++) {
    double d2 = 0, r = (double)s->radius[j];
    for (int a = 0; a < 3; a++) d2 += pow((double)s->at[j][a] - (double)s->x[i][a], 2);
    if (sqrt(d2) > r) closest = fmax(closest, sqrt(d2) / (sqrt(d2) - r));
  }
  return t == YLM_DOUBLE ? 1e-13 + 1e-15 * closest : 4e-6 + 1.5e-7 * closest;
}

typedef struct results {
  double value[POINTS * COUNT], gradient[POINTS * COUNT * 3], hessian[POINTS * COUNT * 6];
} results;

static bool evaluate(const ylm_light_set *lights, ylm_isa isa, const scene *s, int lmax,
                     ylm_dtype t, results *out) {
  double x[POINTS][3];
  ylm_field_query q = {
      .lmax = lmax, .channels = 1, .metric_channels = 1, .want = 7, .dtype = t, .threads = 1};
  ylm_field_result r = {.value = out->value, .gradient = out->gradient, .hessian = out->hessian};
  for (size_t i = 0; i < s->points; i++)
    for (int a = 0; a < 3; a++) x[i][a] = (double)s->x[i][a];
  const void *points = t == YLM_DOUBLE ? (const void *)x : (const void *)s->x;
  return ylm_light_set_evaluate(lights, isa, &q, s->points, points, &r, NULL) == YLM_OK;
}

/* The relative error of n numbers from `first` on. */
static double error(const double *truth, const double *got, ylm_dtype t, size_t first, size_t n) {
  double difference = 0, norm = 0;
  for (size_t i = first; i < first + n; i++) {
    double x = t == YLM_DOUBLE ? got[i] : (double)((const float *)got)[i];
    difference += (x - truth[i]) * (x - truth[i]), norm += truth[i] * truth[i];
  }
  return difference == 0 ? 0 : sqrt(difference / norm);
}

/* A kernel set and type under judgement, with the worst errors so far relative to the bound. */
typedef struct candidate {
  ylm_isa isa;
  ylm_dtype t;
  double worst[3]; /* of value, gradient, Hessian */
  int where[3];    /* their lmax */
} candidate;

/* Raises the worst errors to those at one lmax. */
static bool judge(const scene *s, const ylm_light_set *lights, int lmax, const results *truth,
                  candidate *c) {
  static results got;
  const double *a[3] = {truth->value, truth->gradient, truth->hessian};
  const double *b[3] = {got.value, got.gradient, got.hessian};
  size_t count = (size_t)((lmax + 1) * (lmax + 1)), width[3] = {count, 3 * count, 6 * count};
  if (!evaluate(lights, c->isa, s, lmax, c->t, &got)) return false;
  for (int k = 0; k < 3; k++)
    for (size_t i = 0; i < s->points; i++) {
      double e = error(a[k], b[k], c->t, i * width[k], width[k]) / bound(s, i, c->t);
      if (!(e <= c->worst[k])) c->worst[k] = e, c->where[k] = lmax;
    }
  return true;
}

static void print(const char *name, const candidate *c) {
  printf("%-30s %-7s %-6s", name, ylm_isa_name(c->isa), c->t == YLM_DOUBLE ? "double" : "float");
  for (int k = 0; k < 3; k++) printf("  %4.2f (%2d)", c->worst[k], c->where[k]);
  printf("\n");
  fflush(stdout);
}

/* All kernel sets and types at one kind of positions. */
static bool table(const kind *k) {
  static scene s;
  static results truth;
  candidate c[2 * YLM_ISA_COUNT];
  size_t n = 0;
  ylm_rng r;
  for (int isa = YLM_ISA_COUNT - 1; isa > YLM_ISA_reference; isa--)
    for (int t = 0; ylm_isa_available((ylm_isa)isa) && t < 2; t++)
      c[n++] = (candidate){(ylm_isa)isa, t ? YLM_DOUBLE : YLM_FLOAT, {0}, {0}};
  ylm_rng_seed(&r, 1, (uint64_t)(k - kinds));
  (k->cone > 0 ? many_lights : one_light)(k, &r, &s);
  ylm_light_set *lights = lights_of(&s);
  bool fine = lights != NULL;
  for (int lmax = 0; fine && lmax <= LMAX; lmax += bench_is_quick() ? 5 : 1) {
    fine = evaluate(lights, YLM_ISA_reference, &s, lmax, YLM_DOUBLE, &truth);
    for (size_t i = 0; fine && i < n; i++) fine = judge(&s, lights, lmax, &truth, &c[i]);
  }
  ylm_light_set_free(lights);
  for (size_t i = 0; i < n; i++) print(k->name, &c[i]);
  return fine;
}

int main(void) {
  printf("sphere lights: largest errors of value, gradient, Hessian as parts of the bound (at "
         "lmax)\n");
  for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
    if (!table(&kinds[k])) return 1;
  return 0;
}
