/*
** tables.c - tables of materials: seconds of one thread to make them, and ns to ask them, a row of each function.
*/
#include <math.h>

#include "bench.h"
#include "material_files.h"
#include "ylm_material_table.h"

enum { BATCH = 256 };

typedef struct job {
  const ylm_material_table *table;
  float wo[BATCH][3], *row;
} job;

static void rows(void *context) {
  job *j = context;
  ylm_material_table_rows(j->table, BATCH, (const float(*)[3])j->wo, j->row);
}

static ylm_material *made(const char *kind, size_t n, const float *x) {
  ylm_material *m = NULL;
  ylm_material_create(ylm_material_kind_find(kind), n, x, &m, NULL);
  return m;
}

/* One line; frees the material. */
static int measure(const char *says, ylm_material *m, int lmax) {
  static job j;
  ylm_material_table_form form = {
      .lmax = lmax, .rows = 32, .columns = 64, .error = 0.002, .threads = 1};
  ylm_material_table_facts f;
  double least = 1e30;
  ylm_material_table *t = NULL;
  if (!m) return 1;
  for (int i = 0; i < 3; i++) { /* the least: others use the machine too */
    double start = bench_cpu();
    ylm_material_table_free(t);
    if (ylm_material_table_create(m, &form, &t, NULL) != YLM_OK) return 1;
    least = fmin(least, bench_cpu() - start);
    if (bench_is_quick()) break;
  }
  ylm_material_table_look(t, &f);
  ylm_rng r;
  ylm_rng_seed(&r, 7, 1);
  for (size_t i = 0; i < BATCH; i++) {
    double z = 0.02 + 0.98 * ylm_rng_double(&r), phi = 6.28318531 * ylm_rng_double(&r);
    j.wo[i][0] = (float)(sqrt(1 - z * z) * cos(phi));
    j.wo[i][1] = (float)(sqrt(1 - z * z) * sin(phi));
    j.wo[i][2] = (float)z;
  }
  j.table = t;
  j.row = ylm_alloc(BATCH * (size_t)f.functions * f.width, sizeof(float));
  if (!j.row) return 1;
  double each = 1e9 / BATCH / f.functions * bench_seconds(rows, &j);
  printf("%-20s %4d  %4d x %-3d  %9d  %8.4f  %8.1f  %7.4f\n", says, lmax, f.rows, f.columns,
         f.functions, least, each, f.error);
  fflush(stdout);
  ylm_free(j.row);
  ylm_material_table_free(t);
  ylm_material_free(m);
  return 0;
}

int main(void) {
  static const int degrees[] = {4, 8, 14};
  static const float gold[] = {0.3f, 0.3f, 1, 0.78f, 0.34f, 0, 0, 0, 1};
  static const float grey[] = {0.1f, 0.1f, 0.9f, 0.9f, 0.9f, 0, 0, 0, 1};
  static const float brushed[] = {0.1f, 0.4f, 1, 0.78f, 0.34f, 0, 0, 0, 1};
  static const float abc[] = {0.01f, 0.01f, 0.01f, 1.7f, 1.1f, 0.4f, 54, 1.5f, 9, 1};
  printf(
      "one thread                         rows x                            ns a row   between\n");
  printf("material             lmax   columns  functions   seconds  and function    rows\n");
  for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++) {
    int lmax = degrees[i];
    if (measure("ggx, coloured, 0.3", made("ggx", 9, gold), lmax) ||
        measure("ggx, grey, 0.1", made("ggx", 9, grey), lmax) ||
        measure("ggx, 0.1 by 0.4", made("ggx", 9, brushed), lmax) ||
        measure("abc", made("abc", 10, abc), lmax) || measure("merl", bench_merl(true), lmax))
      return 1;
  }
  return 0;
}
