/* merl_write.c - MERL's files, written; merl_file.c has their format. */
#include <string.h>

#include "kind.h"
#include "merl.h"

static void put(unsigned char *p, int n, uint64_t x) {
  for (int i = 0; i < n; i++, x >>= 8) p[i] = (unsigned char)x;
}

static void put_real(unsigned char *p, double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof x);
  put(p, 8, bits);
}

/* The table of a material that is one; NULL: it is of another kind. */
static const merl_table *table_of(const ylm_material *m) {
  bool is_table =
      m->kind == ylm_material_kind_find("merl") || m->kind == ylm_material_kind_find("tabulated");
  return is_table ? m->table : NULL;
}

/* A file as it is made; table: NULL where the material is none. */
typedef struct writing {
  const ylm_material *m;
  const merl_table *table;
  size_t bins;
  int phis;
  unsigned char *numbers;
} writing;

/* f at the centres of a row of MERL_PHI_D bins; -1 where one of the directions is below the surface. */
static void evaluate_row(const ylm_material *m, int theta_h, int theta_d, float (*f)[3]) {
  float wi[MERL_PHI_D][3], wo[MERL_PHI_D][3];
  bool above[MERL_PHI_D];
  for (int p = 0; p < MERL_PHI_D; p++) {
    double i[3], o[3];
    above[p] = ylm_material_merl_centre(theta_h, theta_d, p, i, o);
    for (int a = 0; a < 3; a++) wi[p][a] = (float)i[a], wo[p][a] = (float)o[a];
  }
  ylm_material_eval(m, MERL_PHI_D, (const float(*)[3])wi, (const float(*)[3])wo, f);
  for (int p = 0; p < MERL_PHI_D; p++)
    if (!above[p]) f[p][0] = f[p][1] = f[p][2] = -1;
}

/* A row of a table: its own numbers. */
static void copy_row(const merl_table *t, size_t row, float (*f)[3]) {
  const merl_bin *bin = t->bin + row * (size_t)t->phis;
  for (int p = 0; p < t->phis; p++)
    for (int c = 0; c < 3; c++) f[p][c] = bin[p][3] != 0 ? bin[p][c] : -1;
}

static ylm_status write_rows(void *context, size_t begin, size_t end, int worker) {
  const writing *w = context;
  float f[2 * MERL_PHI_D][3];
  (void)worker;
  for (size_t row = begin; row < end; row++) {
    if (w->table)
      copy_row(w->table, row, f);
    else
      evaluate_row(w->m, (int)(row / MERL_THETA_D), (int)(row % MERL_THETA_D), f);
    for (size_t p = 0; p < (size_t)w->phis; p++)
      for (size_t c = 0; c < 3; c++)
        put_real(w->numbers + 8 * (c * w->bins + row * (size_t)w->phis + p),
                 f[p][c] < 0 ? -1 : (double)f[p][c] / ylm__merl_scale[c]);
  }
  return YLM_OK;
}

ylm_status ylm_material_write_merl(const ylm_material *m, const char *path, ylm_error *e) {
  if (!ylm_material_isotropic(m))
    return ylm_fail(e, YLM_EDOMAIN,
                    "MERL's files hold isotropic materials, and this %s material is anisotropic",
                    ylm_material_kind_name(ylm_material_kind(m)));
  writing w = {.m = m, .table = table_of(m)};
  w.phis = w.table ? w.table->phis : MERL_PHI_D;
  size_t rows = (size_t)MERL_THETA_H * MERL_THETA_D;
  w.bins = rows * (size_t)w.phis;
  size_t size = MERL_HEADER + 24 * w.bins;
  unsigned char *bytes = ylm_alloc(size, 1);
  if (!bytes) return YLM_ENOMEM;
  int32_t extents[3] = {MERL_THETA_H, MERL_THETA_D, w.phis};
  for (int a = 0; a < 3; a++) put(bytes + 4 * a, 4, (uint64_t)extents[a]);
  w.numbers = bytes + MERL_HEADER;
  ylm_status s = ylm_parallel(rows, MERL_THETA_D, 0, write_rows, &w, NULL, NULL);
  if (s == YLM_OK) s = ylm_file_save(path, bytes, size, e);
  ylm_free(bytes);
  return s;
}
