/* occupied.h - which voxels hold shading points, on a device: of an octree for all levels at once,
   or of a lattice. Private. */
#ifndef YLM_GPU_OCCUPIED_H
#define YLM_GPU_OCCUPIED_H

#include "../device/steps.h"
#include "../gen/layout.h"
#include "../light/lights.h"

#define OCTREE_LEVELS (YLM_GRID_MAX_DEPTH + 1)

/* Nodes of a level that hold shading points: a bit for each child of each such node of the level
   above, and how many bits there are in the words before. A lattice: a bit for each voxel. */
typedef struct occupied_level {
  ylm_gpu_buffer *bits, *before;
  uint32_t words;
} occupied_level;

typedef struct occupied_voxels {
  ylm_gpu_lights *l; /* their times count copies */
  const ylm_grid *grid;
  const ylm_grid_source *source;
  ylm_gpu_buffer *there; /* shading points in the device's memory; NULL: the source's */
  step_queue *q;
  ylm_gpu_buffer *counts;
  ylm_error *e;
  occupied_level level[OCTREE_LEVELS]; /* level k of an octree, 0 has none; 0 of a lattice */
} occupied_voxels;

/* Marks them; counts are those of outside points and, of a lattice, voxels. YLM_EDOMAIN where a
   point in the device's memory is not finite. */
ylm_status ylm__occupied_mark(occupied_voxels *o, uint32_t count[YLM_GPU_COUNTS]);
void ylm__occupied_free(occupied_voxels *o);

/* Marks the voxels that the source's surfaces meet. occupied_surface.c */
ylm_status ylm__occupied_surfaces(occupied_voxels *o, uint32_t count[YLM_GPU_COUNTS]);

/* -- occupied_host.c ------------------------------------------------------------------------- */

/* Morton codes of the finest nodes of an octree that has been marked, sorted, each once. */
ylm_status ylm__occupied_codes(const occupied_voxels *o, uint64_t **code, size_t *n);
/* Shading points of n indices, rounded to float, [n][3]. */
ylm_status ylm__occupied_points(const occupied_voxels *o, size_t n, const size_t *index,
                                float *out);
/* All shading points in the device's memory, as they are; the caller frees them. */
ylm_status ylm__occupied_fetch(const ylm_grid_source *source, const ylm_gpu_buffer *there,
                               void **points, ylm_error *e);

#endif
