/* reference.c - sampling one voxel, one point and one coefficient after the other: the
   short form that judges the kernels. */
#include "../grid.h"

#define F float
#include "../gen/interpolation.h"

static void mix(const sample_batch *b, const float *w, float *out) {
  int rows = b->interpolation == YLM_GRID_LINEAR ? 8 : ROWS;
  for (int j = 0; j < b->width; j++) {
    float sum = 0;
    for (int r = 0; r < rows; r++) sum += w[r] * b->row[r][j];
    out[j] = sum;
  }
}

void ylm_k_grid_sample_reference(const sample_batch *b) {
  for (int p = 0; p < b->points; p++) {
    axis_functions f[3], d[3];
    float w[ROWS];
    for (int a = 0; a < 3; a++) {
      axis_values(&f[a], b->t[a][p], b->edge[a], b->interpolation);
      axis_slopes(&d[a], b->t[a][p], b->edge[a], b->interpolation);
    }
    weights(&f[0], &f[1], &f[2], w, 1);
    mix(b, w, b->value[p]);
    for (int a = 0; b->derivatives && a < 3; a++) {
      weights(a == 0 ? &d[0] : &f[0], a == 1 ? &d[1] : &f[1], a == 2 ? &d[2] : &f[2], w, 1);
      mix(b, w, b->gradient[a][p]);
    }
  }
}
