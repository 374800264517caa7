/* cell.c - the kernel in use, and one point of one cell. */
#include "../grid.h"

#include <string.h>

YLM_KERNEL_CHOICE(sample_kernel, ylm__grid_kernel, ylm_k_grid_sample, ylm_k_grid_sample_reference);

void ylm__grid_set_edge(const ylm_grid *g, uint32_t edge, sample_batch *b) {
  for (int a = 0; a < 3; a++) b->edge[a] = (float)(edge / g->scale[a]);
}

/* Points the batch's rows at the corners of a cell. */
void ylm__grid_set_cell(const ylm_grid *g, const ylm_grid_cell *c, sample_batch *b) {
  ylm__grid_set_edge(g, ylm__grid_edge(g, c), b);
  for (int r = 0; r < 4; r++)
    for (int k = 0; k < 8; k++) b->row[8 * r + k] = ylm__grid_row(g, c->corner[k], r);
}

void ylm__grid_interpolate(const ylm_grid *g, const ylm_grid_cell *c, const float t[3],
                           float *value, float *gradient) {
  const float *row[ROWS];
  for (int r = 0; r < 4; r++)
    for (int k = 0; k < 8; k++) row[8 * r + k] = ylm__grid_row(g, c->corner[k], r);
  ylm__grid_mix(g, row, ylm__grid_edge(g, c), t, value, gradient);
}

void ylm__grid_mix(const ylm_grid *g, const float *const row[ROWS], uint32_t edge, const float t[3],
                   float *value, float *gradient) {
  sample_batch b = {.points = 1,
                    .width = (int)g->width,
                    .derivatives = gradient != NULL,
                    .interpolation = ylm__grid_interpolation(g, YLM_GRID_HERMITE)};
  ylm__grid_set_edge(g, edge, &b);
  memcpy(b.row, row, sizeof b.row);
  b.value[0] = value;
  for (int a = 0; a < 3; a++) {
    b.t[a][0] = t[a];
    if (gradient) b.gradient[a][0] = gradient + (size_t)a * g->stride;
  }
  ylm__grid_kernel()(&b);
}
