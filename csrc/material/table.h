/* table.h - what table.c makes and table_rows.c asks. Private to csrc/material. */
#ifndef YLM_MATERIAL_TABLE_PRIVATE_H
#define YLM_MATERIAL_TABLE_PRIVATE_H

#include "calibration.h"
#include "ylm_material_table.h"

/* The last of the rows: f wi.z has a limit at the horizon, but no value. */
#define TABLE_LAST (89.5 / 180 * YLM_PI)

struct ylm_material_table {
  int lmax, rows, columns, functions;
  bool halves;
  size_t width;
  float mix[3][3];
  float *data;   /* [columns][rows + 2][functions][width]: one row more at either end */
  float *missed; /* [columns][rows][lmax + 1] */
  ylm_material_table_facts facts;
};

/* Catmull and Rom's weights at t in 0 .. 1 between the second and third of four places. */
static inline void ylm__table_cubic(double t, double w[4]) {
  w[0] = t * (-0.5 + t * (1 - 0.5 * t));
  w[1] = 1 + t * t * (-2.5 + 1.5 * t);
  w[2] = t * (0.5 + t * (2 - 1.5 * t));
  w[3] = t * t * (-0.5 + 0.5 * t);
}

/* Row `row` of column `column` of the table: -1 and `rows` are those beyond its ends. */
static inline float *ylm__table_row(const ylm_material_table *t, int row, int column) {
  return t->data + (size_t)t->functions * t->width *
                       ((size_t)column * (size_t)(t->rows + 2) + (size_t)(row + 1));
}

/* out[k] = the sum over q < rows of w[q] a[q][k], k < n: kernels of table_rows.isa.c, table_rows.c has the plain form. */
typedef void material_blend_fn(size_t n, int rows, const float *const *a, const float *w,
                               float *out);

#endif
