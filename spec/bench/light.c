/*
** light.c - fields of sphere lights: nanoseconds per light-point pair and fraction of the peak of
** multiply-adds for each kernel set, what threads bring, and the papers' rows.
*/
#include "peak.h"
#include "ylm_light.h"

#define LIGHTS 2516
#define POINTS 32

typedef struct job {
  const ylm_light_set *lights;
  ylm_isa isa;
  ylm_field_query q;
  size_t n;
  void *points;
  ylm_field_result r;
} job;

/* A query and its name. */
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

/*
** Operations of the multiply-add units per pair, as the generator counts them (its counts of sums
** and recurrences stand in csrc/light/gen): for each sum one (three channels: a product and three),
** two for each step of a polynomial in z, and about 28 + 7 a degree for directions and weights.
*/
static double operations(const form *f, int lmax) {
  double l = lmax, m0 = (l + 1) * (l + 1), m1 = (l + 2) * (l + 2) - 1, m2 = (l + 3) * (l + 3) - 3;
  bool metric = f->want & 8;
  double K = l + (f->want & 4 || metric ? 2 : f->want & 2 ? 1 : 0);
  double sums = f->want & 1 ? m0 : 0;
  if (f->want & 2) sums += m1;
  if (f->want & 4) sums += m2;
  double columns = f->want & 4 ? l + 2 : f->want & 2 ? l + 1 : l; /* of the asked results */
  double n = 28 + 7 * K + (f->want & 2 ? l + 1 : 0) + (f->want & 4 || metric ? 2 * l + 3 : 0);
  if (f->want & 7) n += (f->channels == 3 ? 4 : 1) * sums + 2 * columns * columns;
  if (metric) n += m2 + 2 * K * K + (f->want & 1 ? 0 : m0);
  return n;
}

static void evaluate(void *context) {
  job *j = context;
  ylm_light_set_evaluate(j->lights, j->isa, &j->q, j->n, j->points, &j->r, NULL);
}

/* Small lamps in the unit cube about the origin; points lie outside of it. */
static ylm_light_set *lamps(void) {
  static double at[LIGHTS][3], radius[LIGHTS], radiance[LIGHTS][3];
  ylm_light_set *lights = NULL;
  bench_fill(YLM_DOUBLE, at, 3 * LIGHTS);
  for (int i = 0; i < LIGHTS; i++) {
    radius[i] = 0.02;
    for (int a = 0; a < 3; a++) radiance[i][a] = 1 + a;
  }
  return ylm_light_set_spheres(LIGHTS, at[0], radius, radiance[0], &lights, NULL) == YLM_OK ? lights
                                                                                            : NULL;
}

static void place_points(ylm_dtype t, void *points, size_t n) {
  bench_fill(t, points, 3 * n);
  for (size_t i = 0; i < n; i++) {
    if (t == YLM_DOUBLE)
      ((double *)points)[3 * i] += 2.5;
    else
      ((float *)points)[3 * i] += 2.5f;
  }
}

/* Room for n points' results at lmax, three channels, double. */
static bool reserve(job *j, size_t n, int lmax) {
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1) * 3;
  ylm_free(j->points), ylm_free(j->r.value), ylm_free(j->r.gradient), ylm_free(j->r.hessian);
  ylm_free(j->r.lambda), ylm_free(j->r.norm);
  j->n = n;
  j->points = ylm_alloc(n, 24);
  j->r.value = ylm_alloc_zero(n * count, 8), j->r.gradient = ylm_alloc_zero(n * count, 24);
  j->r.hessian = ylm_alloc_zero(n * count, 48);
  j->r.lambda = ylm_alloc(n, 8), j->r.norm = ylm_alloc(n, 8);
  return j->points && j->r.value && j->r.gradient && j->r.hessian && j->r.lambda && j->r.norm;
}

static void ask(job *j, const form *f, int lmax) {
  j->q.channels = f->channels, j->q.want = f->want, j->q.dtype = f->t, j->q.lmax = lmax;
  place_points(f->t, j->points, j->n);
}

/* One line for each form: ns, and per cent of the peak. */
static void table(job *j, double peak[2]) {
  for (size_t f = 0; f < sizeof forms / sizeof *forms; f++) {
    printf("%-7s %-15s", ylm_isa_name(j->isa), forms[f].name);
    for (int lmax = 1; lmax <= 20; lmax++) {
      char text[32] = "-";
      if (!bench_is_quick() || lmax == 4 || lmax == 8 || lmax == 12) {
        ask(j, &forms[f], lmax);
        double ns = bench_seconds(evaluate, j) * 1e9 / LIGHTS / (double)j->n;
        double of = peak[forms[f].t] > 0 ? operations(&forms[f], lmax) / ns / peak[forms[f].t] : 0;
        snprintf(text, sizeof text, "%.3g/%.0f", ns, 100 * of);
      }
      printf(" %-9s", text);
      fflush(stdout);
    }
    printf("\n");
  }
}

static double process_cpu(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The gain of all threads, for some forms: by wall time, and by the threads' processor time, which
   other processes on the machine disturb less. */
static void threads(job *j) {
  int all = ylm_threads(0);
  printf("\n%d threads over one, 2048 points: by wall time (by processor time), least of several\n",
         all);
  if (!reserve(j, 2048, 8)) return;
  for (size_t f = 0; f < sizeof forms / sizeof *forms; f++) {
    if (forms[f].t == YLM_DOUBLE && forms[f].want != 7) continue;
    printf("  %-16s", forms[f].name);
    for (int lmax = 4; lmax <= 8; lmax += 4) {
      double t[2], cpu[2];
      ask(j, &forms[f], lmax);
      for (int k = 0; k < 2; k++) {
        j->q.threads = k ? all : 1;
        t[k] = bench_wall(evaluate, j);
        cpu[k] = bench_least(evaluate, j, process_cpu);
      }
      printf("  lmax %d: %.2f (%.2f)", lmax, t[0] / t[1], all * cpu[0] / cpu[1]);
    }
    printf("\n");
  }
}

/* The papers' bakes beside ours. */
static void papers(job *j) {
  static const struct {
    const char *name, *theirs;
    size_t points;
    form f;
  } rows[] = {
      {"2025: 2683 adaptive points, Hessians", "1532 ms, ten cores", 2683, {"", 3, 7, YLM_FLOAT}},
      {"the same, gradients and metric, which a bake needs", "", 2683, {"", 3, 11, YLM_FLOAT}},
      {"2025: uniform 16^3, gradients", "1532 ms, ten cores", 4913, {"", 3, 3, YLM_FLOAT}},
  };
  int all = ylm_threads(0);
  printf("\nthe papers' work: %d lights, lmax 4, RGB, ms (wall, least of several)\n", LIGHTS);
  printf("  %-52s %-20s %10s %8d threads\n", "", "printed", "one thread", all);
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    double t[2];
    if (!reserve(j, rows[i].points, 4)) return;
    ask(j, &rows[i].f, 4);
    for (int k = 0; k < 2; k++) j->q.threads = k ? all : 1, t[k] = bench_wall(evaluate, j) * 1e3;
    printf("  %-52s %-20s %10.1f %8.1f\n", rows[i].name, rows[i].theirs, t[0], t[1]);
  }
}

int main(void) {
  job j = {.lights = lamps(), .q = {.threads = 1, .metric_channels = 1}};
  if (!j.lights || !reserve(&j, POINTS, 20)) return 1;
  printf("sphere lights: ns per light-point pair / %% of the peak of multiply-adds; %d lights, %d "
         "points, one thread, everything included\n",
         LIGHTS, POINTS);
  printf("%-7s %-15s", "kernel", "form");
  for (int lmax = 1; lmax <= 20; lmax++) printf(" lmax %-4d", lmax);
  printf("\n");
  for (int isa = YLM_ISA_COUNT - 1; isa > YLM_ISA_reference; isa--) {
    if (!ylm_isa_available((ylm_isa)isa)) continue;
    double peak[2] = {bench_peak((ylm_isa)isa, YLM_FLOAT), bench_peak((ylm_isa)isa, YLM_DOUBLE)};
    j.isa = (ylm_isa)isa;
    table(&j, peak);
  }
  j.isa = ylm_isa_current();
  threads(&j);
  papers(&j);
  ylm_light_set_free((ylm_light_set *)j.lights);
  return 0;
}
