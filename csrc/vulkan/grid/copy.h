/* copy.h - a grid in the device's memory: what copy.c and sample.c share. Private. */
#ifndef YLM_GPU_GRID_H
#define YLM_GPU_GRID_H

#include "../device/steps.h"
#include "../gen/layout.h"
#include "ylm_grid.h"

#define GRID_PARTS 4 /* grid_rows.glsl: buffers that the data are cut into at most */

struct ylm_gpu_grid {
  ylm_gpu *g;
  ylm_grid_form form;
  uint64_t updates; /* of the grid, when it was copied */
  uint32_t resolution[3];
  size_t cell_count, width, stride;
  bool wide;   /* points are located in double */
  bool packed; /* rows are words of ylm_grid_pack, `stride` of them */
  ylm_grid_packing packing;
  bool busy; /* a call has not returned: its progress function runs */
  ylm_gpu_buffer *cells, *table, *bounds, *counts;
  /* Rows of coefficients and gradients, `part_rows` of the grid's points in each buffer. */
  int parts;
  size_t part_rows;
  ylm_gpu_buffer *data[GRID_PARTS];
  /* Of a pass, kept for the next: arrays of the host's, places, points in the order of cells. */
  ylm_gpu_buffer *points, *places, *order, *tally, *value, *gradient, *transfer, *material;
  step_queue queue;
};

/* copy.c: a grid's copy but for the rows of points, k->part_rows of which go into a buffer. */
ylm_status ylm__gpu_grid_begin(ylm_gpu *g, const ylm_grid *grid, bool packed, ylm_gpu_grid **k,
                               ylm_error *e);

#endif
