/*
** merl_file.c - MERL's files, read and written:
**
**     int32 [3]: 90, 90, 180
**     float64 [3][90][90][180]: planes of red, green and blue over theta_h, theta_d, phi_d
**
** Numbers are little-endian; times 1/1500, 1.15/1500 and 1.66/1500 they are sr^-1. A negative number
** stands where nothing was measured.
*/
#include <math.h>
#include <string.h>

#include "kind.h"
#include "merl.h"

static const double scale[3] = {1 / 1500., 1.15 / 1500, 1.66 / 1500};

/* A larger reflectance cannot be measured, and products of it could overflow. */
#define LARGEST 1e12

static uint64_t number(const unsigned char *p, int n) {
  uint64_t x = 0;
  for (int i = n - 1; i >= 0; i--) x = x << 8 | p[i];
  return x;
}

static void put(unsigned char *p, int n, uint64_t x) {
  for (int i = 0; i < n; i++, x >>= 8) p[i] = (unsigned char)x;
}

static double real(const unsigned char *p) {
  uint64_t bits = number(p, 8);
  double x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

static void put_real(unsigned char *p, double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof x);
  put(p, 8, bits);
}

/* -- reading ---------------------------------------------------------------- */

#define HEADER 12

/* The header, and that the file's size is as it says. */
static ylm_status read_header(const unsigned char *bytes, size_t size, const char *name, int *phis,
                              ylm_error *e) {
  if (size < HEADER)
    return ylm_fail(e, YLM_EFORMAT, "%s: the file ends within its header of %d bytes", name,
                    HEADER);
  int32_t n[3];
  for (int a = 0; a < 3; a++) n[a] = (int32_t)(uint32_t)number(bytes + 4 * a, 4);
  if (n[0] == YLM_MERL_THETA_H << 24)
    return ylm_fail(e, YLM_EFORMAT, "%s: its numbers are big-endian, little-endian ones expected",
                    name);
  if (n[0] != YLM_MERL_THETA_H || n[1] != YLM_MERL_THETA_D ||
      (n[2] != YLM_MERL_PHI_D && n[2] != 2 * YLM_MERL_PHI_D))
    return ylm_fail(e, YLM_EFORMAT,
                    "%s: %d x %d x %d bins of theta_h, theta_d and phi_d, %d x %d x %d or %d "
                    "expected",
                    name, (int)n[0], (int)n[1], (int)n[2], YLM_MERL_THETA_H, YLM_MERL_THETA_D,
                    YLM_MERL_PHI_D, 2 * YLM_MERL_PHI_D);
  size_t wanted = HEADER + 24 * (size_t)n[0] * (size_t)n[1] * (size_t)n[2];
  if (size != wanted)
    return ylm_fail(e, YLM_EFORMAT, "%s: %zu bytes, but %d x %d x %d bins take %zu", name, size,
                    (int)n[0], (int)n[1], (int)n[2], wanted);
  *phis = n[2];
  return YLM_OK;
}

static ylm_status wrong_number(const char *name, int colour, size_t i, int phis, double x,
                               ylm_error *e) {
  static const char *const names[] = {"red", "green", "blue"};
  return ylm_fail(e, YLM_EFORMAT, "%s: the %s number at theta_h %zu, theta_d %zu, phi_d %zu is %g",
                  name, names[colour], i / (size_t)phis / YLM_MERL_THETA_D + 1,
                  i / (size_t)phis % YLM_MERL_THETA_D + 1, i % (size_t)phis + 1, x);
}

/* Fills the bins; one with a negative number is missing. */
static ylm_status read_bins(const unsigned char *numbers, const char *name, merl_table *t,
                            ylm_error *e) {
  size_t bins = (size_t)YLM_MERL_THETA_H * YLM_MERL_THETA_D * (size_t)t->phis, measured = 0;
  for (size_t i = 0; i < bins; i++) {
    float *bin = t->bin[i];
    bin[3] = 1;
    for (int c = 0; c < 3; c++) {
      double x = real(numbers + 8 * ((size_t)c * bins + i)) * scale[c];
      if (!(fabs(x) <= LARGEST)) return wrong_number(name, c, i, t->phis, x / scale[c], e);
      if (x < 0) bin[3] = 0;
      bin[c] = (float)x;
    }
    measured += bin[3] != 0;
  }
  if (!measured)
    return ylm_fail(e, YLM_EFORMAT, "%s: nothing is measured: every bin has a negative number",
                    name);
  return YLM_OK;
}

ylm_status ylm__merl_read(const unsigned char *bytes, size_t size, const char *name, merl_table **t,
                          size_t *held, ylm_error *e) {
  int phis = 0;
  ylm_status s = read_header(bytes, size, name, &phis, e);
  if (s != YLM_OK) return s;
  merl_table *new = ylm__merl_new(phis, held);
  if (!new) return YLM_ENOMEM;
  s = read_bins(bytes + HEADER, name, new, e);
  if (s != YLM_OK) {
    ylm_free(new);
    return s;
  }
  ylm__merl_complete(new);
  *t = new;
  return YLM_OK;
}

/* -- writing ---------------------------------------------------------------- */

/* A file as it is made; table: NULL where the material is none. */
typedef struct writing {
  const ylm_material *m;
  const merl_table *table;
  size_t bins;
  int phis;
  unsigned char *numbers;
} writing;

/* f at the centres of a row of YLM_MERL_PHI_D bins; -1 where one of the directions is below the surface. */
static void evaluate_row(const ylm_material *m, int theta_h, int theta_d, float (*f)[3]) {
  float wi[YLM_MERL_PHI_D][3], wo[YLM_MERL_PHI_D][3];
  bool above[YLM_MERL_PHI_D];
  for (int p = 0; p < YLM_MERL_PHI_D; p++) {
    double i[3], o[3];
    above[p] = ylm_material_merl_centre(theta_h, theta_d, p, i, o);
    for (int a = 0; a < 3; a++) wi[p][a] = (float)i[a], wo[p][a] = (float)o[a];
  }
  ylm_material_eval(m, YLM_MERL_PHI_D, (const float(*)[3])wi, (const float(*)[3])wo, f);
  for (int p = 0; p < YLM_MERL_PHI_D; p++)
    if (!above[p]) f[p][0] = f[p][1] = f[p][2] = -1;
}

/* The same of a table: its own numbers. */
static void copy_row(const merl_table *t, size_t row, float (*f)[3]) {
  const merl_bin *bin = t->bin + row * (size_t)t->phis;
  for (int p = 0; p < t->phis; p++)
    for (int c = 0; c < 3; c++) f[p][c] = bin[p][3] != 0 ? bin[p][c] : -1;
}

static ylm_status write_rows(void *context, size_t begin, size_t end, int worker) {
  const writing *w = context;
  float f[2 * YLM_MERL_PHI_D][3];
  (void)worker;
  for (size_t row = begin; row < end; row++) {
    if (w->table)
      copy_row(w->table, row, f);
    else
      evaluate_row(w->m, (int)(row / YLM_MERL_THETA_D), (int)(row % YLM_MERL_THETA_D), f);
    for (size_t p = 0; p < (size_t)w->phis; p++)
      for (size_t c = 0; c < 3; c++)
        put_real(w->numbers + 8 * (c * w->bins + row * (size_t)w->phis + p),
                 f[p][c] < 0 ? -1 : (double)f[p][c] / scale[c]);
  }
  return YLM_OK;
}

ylm_status ylm_material_write_merl(const ylm_material *m, const char *path, ylm_error *e) {
  if (!ylm_material_isotropic(m))
    return ylm_fail(e, YLM_EDOMAIN,
                    "MERL's files hold isotropic materials, and this %s material is anisotropic",
                    ylm_material_kind_name(ylm_material_kind(m)));
  writing w = {.m = m, .table = ylm__merl_table_of(m)};
  w.phis = w.table ? w.table->phis : YLM_MERL_PHI_D;
  size_t rows = (size_t)YLM_MERL_THETA_H * YLM_MERL_THETA_D;
  w.bins = rows * (size_t)w.phis;
  size_t size = HEADER + 24 * w.bins;
  unsigned char *bytes = ylm_alloc(size, 1);
  if (!bytes) return YLM_ENOMEM;
  int32_t extents[3] = {YLM_MERL_THETA_H, YLM_MERL_THETA_D, w.phis};
  for (int a = 0; a < 3; a++) put(bytes + 4 * a, 4, (uint64_t)extents[a]);
  w.numbers = bytes + HEADER;
  ylm_status s = ylm_parallel(rows, YLM_MERL_THETA_D, 0, write_rows, &w, NULL, NULL);
  if (s == YLM_OK) s = ylm_file_save(path, bytes, size, e);
  ylm_free(bytes);
  return s;
}
