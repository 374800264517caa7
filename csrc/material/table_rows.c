/* table_rows.c - what stands between the rows and columns of a material's table. */
#include <math.h>

#include "table.h"
#include "ylm_sets.h"
#include "ylm_sh.h"

/* -- kernels --------------------------------------------------------------------- */

static void plain(size_t n, int rows, const float *const *a, const float *w, float *out) {
  for (size_t k = 0; k < n; k++) {
    float sum = w[0] * a[0][k];
    for (int q = 1; q < rows; q++) sum += w[q] * a[q][k];
    out[k] = sum;
  }
}

static YLM_KERNEL_CHOICE(material_blend_fn, blend_now, ylm_k_material_blend, plain);

/* -- asking ---------------------------------------------------------------------- */

/* acos x for x in 0 .. 1, to 3e-8 (Abramowitz & Stegun 1964, 4.4.46). */
static double arc(double x) {
  static const double c[8] = {1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046,
                              0.0308918810, -0.0170881256, 0.0066700901, -0.0012624911};
  double sum = c[7];
  for (int i = 6; i >= 0; i--) sum = sum * x + c[i];
  return sqrt(1 - x) * sum;
}

/* The row before a direction, and how far it is from there to the next. */
static int row_at(const ylm_material_table *t, const float wo[3], double *part) {
  double z = (double)wo[2], x = z > 0 ? (z < 1 ? z : 1) : 0; /* NaN: 0 */
  double row = arc(x) * ((t->rows - 1) / TABLE_LAST);
  int i = (int)row;
  if (row < 0) row = i = 0;
  if (row > t->rows - 1) row = t->rows - 1;
  if (i > t->rows - 2) i = t->rows - 2;
  *part = row - i;
  return i;
}

static int column_at(const ylm_material_table *t, const float wo[3], double *part) {
  *part = 0;
  if (t->columns == 1) return 0;
  double column = atan2((double)wo[1], (double)wo[0]) / (2 * YLM_PI) * t->columns;
  if (column < 0) column += t->columns;
  int j = (int)column;
  *part = column - j;
  return j % t->columns;
}

void ylm_material_table_rows(const ylm_material_table *t, size_t n, const float (*wo)[3],
                             float *restrict out) {
  material_blend_fn *blend = blend_now();
  size_t line = (size_t)t->functions * t->width;
  int columns = t->columns == 1 ? 1 : 4;
  for (size_t i = 0; i < n; i++, out += line) {
    double by_row, by_column, u[4], v[4] = {1};
    float weight[16];
    const float *from[16];
    int row = row_at(t, wo[i], &by_row), column = column_at(t, wo[i], &by_column);
    ylm__table_cubic(by_row, u);
    if (columns > 1) ylm__table_cubic(by_column, v);
    for (int j = 0, q = 0; j < columns; j++) {
      int beside = columns == 1 ? 0 : (column - 1 + j + t->columns) % t->columns;
      const float *a = ylm__table_row(t, row - 1, beside);
      for (int k = 0; k < 4; k++, q++) {
        weight[q] = (float)(u[k] * v[j]);
        from[q] = a + (size_t)k * line;
      }
    }
    blend(line, 4 * columns, from, weight, out);
  }
}

/* One channel of a row in the surface's frame, whose eye stands at an azimuth. */
static void turn_slice(const ylm_material_table *t, int channel, double azimuth, const float *row,
                       float *out) {
  size_t k = 0;
  for (int l = 0; l <= t->lmax; l++) {
    double c[2 * YLM_MATERIAL_TABLE_LMAX + 1] = {0};
    for (int m = t->halves ? 0 : -l; m <= l; m++, k++)
      for (int f = 0; f < t->functions; f++)
        c[l + m] += (double)t->mix[channel][f] * (double)row[(size_t)f * t->width + k];
    out[l * l + l] = (float)c[l];
    for (int m = 1; m <= l; m++) {
      double ca = cos(m * azimuth), sa = sin(m * azimuth);
      out[l * l + l + m] = (float)(ca * c[l + m] - sa * c[l - m]);
      out[l * l + l - m] = (float)(sa * c[l + m] + ca * c[l - m]);
    }
  }
}

ylm_status ylm_material_table_slices(const ylm_material_table *t, size_t n, const float (*wo)[3],
                                     float *out) {
  size_t count = ylm_sh_count(t->lmax);
  float *row = ylm_alloc((size_t)t->functions * t->width, sizeof *row);
  if (!row) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    double azimuth = atan2((double)wo[i][1], (double)wo[i][0]);
    ylm_material_table_rows(t, 1, wo + i, row);
    for (int c = 0; c < 3; c++, out += count) turn_slice(t, c, azimuth, row, out);
  }
  ylm_free(row);
  return YLM_OK;
}

void ylm_material_table_missed(const ylm_material_table *t, int lmax, size_t n,
                               const float (*wo)[3], float *error) {
  size_t degrees = (size_t)t->lmax + 1, l = (size_t)(lmax < t->lmax ? lmax : t->lmax);
  for (size_t i = 0; i < n; i++) {
    double by_row, by_column;
    int row = row_at(t, wo[i], &by_row), column = column_at(t, wo[i], &by_column);
    if (by_column > 0.5) column = (column + 1) % t->columns;
    const float *a = t->missed + ((size_t)column * (size_t)t->rows + (size_t)row) * degrees + l;
    error[i] = (float)((1 - by_row) * (double)a[0] + by_row * (double)a[degrees]);
  }
}
