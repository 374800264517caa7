/*
** octree.h - a grid made on a device, an adaptive one level by level (Iwasaki & Dobashi 2025, Sec.
** 5.1): what the files octree*.c share. Private.
**
**   octree.c            the back end of ylm_grid_bake, whose loop asks for level after level
**   occupied.c          which nodes hold shading points, for all levels at once
**   octree_points.c     the corners of a level's voxels, each once; their light field
**   octree_split.c      surfaces of lights, the metric, what is split, the voxels that come next
**   octree_result.c     back to the host, as cells and points of a ylm_grid
**
** A level is the array of its voxels: the cells that hold shading points, in the order in which
** ylm_grid_bake has them. Points are numbered as there. Cells, points and their order are those of the processor's grid,
** whatever the device does first. The host reads a few counts per level. A uniform grid has one level, whose voxels are
** those of the lattice.
*/
#ifndef YLM_GPU_OCTREE_H
#define YLM_GPU_OCTREE_H

#include "occupied.h"
#include "points.h"

#define OCTREE_BINDS 11 /* buffers of a kernel at most */

typedef struct octree_level {
  uint32_t voxels, splits;
  ylm_gpu_buffer *voxel;  /* uvec4: key (two words), rank among occupied nodes, cell of the level */
  ylm_gpu_buffer *state;  /* uint */
  ylm_gpu_buffer *error;  /* float */
  ylm_gpu_buffer *corner; /* uint [8]: points */
} octree_level;

typedef struct octree {
  ylm_gpu *g;
  ylm_gpu_lights *l;
  const ylm_grid_source *source;
  ylm_grid *grid; /* in the making */
  ylm_grid_form form;
  ylm_grid_stats *stats;
  ylm_error *e;
  uint32_t resolution;
  bool all;     /* every voxel is occupied */
  bool uniform; /* a lattice: one level, whose voxels are found at once */
  step_queue q;
  ylm_gpu_buffer *counts;
  ylm_gpu_buffer *exact; /* double [3][resolution + 1]: where the lattice's planes are */
  occupied_voxels occupied;

  octree_level level[OCTREE_LEVELS];
  int levels;
  bool gathered;         /* the host has all of it */
  ylm_gpu_buffer *asked; /* voxels of the present level that a surface may cross */
  uint32_t asks;
  ylm_gpu_buffer
      *sphere[2]; /* dvec4: centres and radii of lights; of those that stand for flat ones */
  uint32_t spheres[2];
  ylm_gpu_buffer *before[2]; /* prefix sums of the present level */

  gpu_points p;
  ylm_gpu_buffer *slot;
  uint32_t slots; /* a power of two */

  /* Progress of a part of the stage at hand: done .. done + now of all. */
  uint64_t done, now, of;
  double told;               /* when progress was last reported */
  const ylm_progress *outer; /* the bake's */
  ylm_progress progress;
} octree;

/* The edge of cells of a level, in units of the lattice. */
static inline uint32_t octree_edge(const octree *t, int level) {
  return 1u << (t->form.depth - level);
}
/* Reads the counts; zeroes them for what comes next. */
ylm_status ylm__octree_counts(octree *t, uint32_t count[YLM_GPU_COUNTS]);
/* Progress counts from the beginning: another stage of the bake, or level, begins. */
void ylm__octree_restart(octree *t);
/* Reports `done`; YLM_ECANCELLED. */
ylm_status ylm__octree_report(octree *t);

/* Corners of the voxels of a level; *fresh points that they add have numbers and keys. */
ylm_status ylm__octree_corners(octree *t, int level, uint32_t *fresh);
/* Evaluates n points from t->p.points on; rows for which the device has no room go to the host. */
ylm_status ylm__octree_evaluate(octree *t, uint32_t n);
/* Decides about the voxels of a level; makes the next level, which is empty where nothing is
   split. */
ylm_status ylm__octree_split(octree *t, int level);
/* The metric of a uniform grid's voxels. */
ylm_status ylm__octree_errors(octree *t);
/* Can a grid be made by these kernels? */
bool ylm__octree_takes(const ylm_gpu *g, const ylm_grid_form *form, const ylm_grid_source *source);
/* The grid's cells and points from what is on the device, where points' rows stay. */
ylm_status ylm__octree_gather(octree *t);
/* The device's numbers do not fit together. */
ylm_status ylm__octree_fails(const octree *t);

/* The back end of a grid with a threshold, or a uniform one, of t->l and the shading points in
   t->occupied.there (NULL: the source's), on a device whose kernels have enough buffers. The rest
   of *t is zero; ylm__octree_end frees what there is. */
ylm_grid_backend ylm__octree_backend(octree *t);
void ylm__octree_end(octree *t);

#endif
