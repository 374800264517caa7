/*
** material.c - materials of each kind on each kernel set: ns a direction to evaluate, to sample, and
** for the density.
*/
#include <math.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bench.h"
#include "material_files.h"
#include "ylm_material.h"

enum { BATCH = 1024 };

typedef struct job {
  ylm_material *material;
  float wi[BATCH][3], wo[BATCH][3], u[BATCH][3], out[BATCH][3], weight[BATCH][3], pdf[BATCH];
} job;

#define ROWS(a) ((const float(*)[3])(a))

static void eval(void *context) {
  job *j = context;
  ylm_material_eval(j->material, BATCH, ROWS(j->wi), ROWS(j->wo), j->out);
}

static void sample(void *context) {
  job *j = context;
  ylm_material_sample(j->material, BATCH, ROWS(j->wo), ROWS(j->u), j->out, j->weight, j->pdf);
}

static void pdf(void *context) {
  job *j = context;
  ylm_material_pdf(j->material, BATCH, ROWS(j->wi), ROWS(j->wo), j->pdf);
}

static void direction(ylm_rng *r, float d[3]) {
  double z = 0.02 + 0.98 * ylm_rng_double(r), turn = 6.28318531 * ylm_rng_double(r);
  d[0] = (float)(sqrt(1 - z * z) * cos(turn));
  d[1] = (float)(sqrt(1 - z * z) * sin(turn));
  d[2] = (float)z;
}

static const struct row {
  const char *says, *kind;
  size_t n;
  float x[YLM_MATERIAL_NUMBERS];
} rows[] = {
    {"matte", "matte", 3, {0.5f, 0.5f, 0.5f}},
    {"ggx, one reflection", "ggx", 9, {0.3f, 0.3f, 1, 0.8f, 0.3f, 0, 0, 0, 0}},
    {"ggx, compensated", "ggx", 9, {0.3f, 0.3f, 1, 0.8f, 0.3f, 0, 0, 0, 1}},
    {"ggx over a base", "ggx", 9, {0.1f, 0.4f, 0.04f, 0.04f, 0.04f, 0.5f, 0.4f, 0.3f, 1}},
    {"phong", "phong", 7, {40, 0.4f, 0.4f, 0.4f, 0.3f, 0.3f, 0.3f}},
    {"abc", "abc", 10, {0.01f, 0.01f, 0.01f, 1.7f, 1.1f, 0.4f, 54, 1.5f, 9, 1}},
};

static const char *const tables[] = {"merl, linear", "merl, nearest", "rgl, isotropic",
                                     "rgl, anisotropic"};

/* The material of a row; NULL where it cannot be made. */
static ylm_material *made(const struct row *w) {
  ylm_material *m = NULL;
  ylm_material_create(ylm_material_kind_find(w->kind), w->n, w->x, &m, NULL);
  return m;
}

static ylm_material *read_table(size_t i) {
  return i < 2 ? bench_merl(i == 0) : bench_rgl(i == 2 ? 1 : 17);
}

/* One row of the table; frees the material. */
static int measure_one(job *j, const char *says, ylm_material *m) {
  if (!m) return 1;
  j->material = m;
  double e = bench_seconds(eval, j), s = bench_seconds(sample, j), p = bench_seconds(pdf, j);
  printf("%-10s %-20s %7.2f  %7.2f  %7.2f\n", ylm_isa_name(ylm_isa_current()), says,
         1e9 * e / BATCH, 1e9 * s / BATCH, 1e9 * p / BATCH);
  ylm_material_free(m);
  return 0;
}

/* All rows on the kernel set in use. */
static int measure(void) {
  static job j;
  ylm_rng r;
  ylm_rng_seed(&r, 1, 1);
  for (size_t i = 0; i < BATCH; i++) {
    direction(&r, j.wi[i]);
    direction(&r, j.wo[i]);
    for (int a = 0; a < 3; a++) j.u[i][a] = fminf((float)ylm_rng_double(&r), 0x1.fffffep-1f);
  }
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
    if (measure_one(&j, rows[i].says, made(&rows[i]))) return 1;
  for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
    if (measure_one(&j, tables[i], read_table(i))) return 1;
  return 0;
}

/* A kernel set is chosen once a process: each has one of its own. */
int main(void) {
  printf("ns a direction, one thread, %d directions a call\n", BATCH);
  printf("kernels    material               eval   sample      pdf\n");
  for (int isa = 0; isa < YLM_ISA_COUNT; isa++) {
    if (!ylm_isa_available((ylm_isa)isa)) continue;
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
      setenv("YLM_ISA", ylm_isa_name((ylm_isa)isa), 1);
      int failed = measure();
      fflush(stdout);
      _exit(failed);
    }
    int status = 1;
    if (child < 0 || waitpid(child, &status, 0) < 0 || status != 0) return 1;
  }
  return 0;
}
