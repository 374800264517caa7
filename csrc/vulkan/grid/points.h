/*
** points.h - data of a grid's points in a device's memory: evaluated there, and kept where kernels
** that interpolate read them. Private.
**
** A row is a point's values and gradients, [4][stride] floats, as ylm_grid_contents has them. Rows lie
** in up to GRID_PARTS buffers of `part_rows` each, as long as a kernel sees, which grow as points
** come. Points before `first` have been brought to the host and are not on the device.
*/
#ifndef YLM_GPU_POINTS_H
#define YLM_GPU_POINTS_H

#include "../light/lights.h"
#include "copy.h"

typedef struct gpu_points {
  ylm_gpu *g;
  ylm_gpu_lights *l;
  const ylm_grid *grid; /* in the making */
  /* The source, and its shading points where they are in the device's memory: remote.c */
  const ylm_grid_source *source;
  ylm_gpu_buffer *there;
  ylm_error *e;
  step_queue q;
  ylm_status unfit;                   /* not YLM_OK: points cannot be kept here */
  uint32_t width, stride, resolution; /* resolution: the largest of the three */
  bool relative;
  ylm_gpu_buffer *axes; /* vec2 [3][resolution + 1]: the nearest float, what it lacks */
  ylm_gpu_buffer *bad;  /* the complement of the lowest point where the field is not finite; 0 */

  uint32_t points, room;               /* there are; keys, ratios and extras there is room for */
  ylm_gpu_buffer *key, *ratio, *extra; /* extra: lambda, norm, 1 in a light: [room][3] */
  uint32_t first;
  int parts;
  uint64_t part_rows, part_room; /* of a full part; of the last one */
  ylm_gpu_buffer *data[GRID_PARTS];
  ylm_gpu_buffer *item, *packed; /* of calls */
  ylm_gpu_buffer *value;         /* [..][width]: of the field at free places */
} gpu_points;

/* Keys of lattice coordinates. */
static inline void points_pack(const uint32_t at[3], uint32_t key[2]) {
  key[0] = key_low(at[0], at[1]);
  key[1] = key_high(at[1], at[2]);
}
static inline void points_unpack(const uint32_t key[2], uint32_t at[3]) {
  at[0] = key_x(key[0]);
  at[1] = key_y(key[0], key[1]);
  at[2] = key_z(key[1]);
}
/* Can points of a grid of such resolution be named by a key (octree.glsl)? */
bool ylm__points_fit(const uint32_t resolution[3]);
/* For a grid in the making; ylm__points_end frees what there is. */
ylm_status ylm__points_begin(gpu_points *p, ylm_gpu_lights *l, const ylm_grid *grid, ylm_error *e);
void ylm__points_end(gpu_points *p);
/* Room for the keys of `more` points. */
ylm_status ylm__points_reserve(gpu_points *p, uint32_t more);
/*
** ylm__points_evaluate - the light field at n points from p->points on, whose keys are there.
**
** Returns  what sums return. YLM_ENOMEM with *full set: there is no room for more rows, in parts or
**          in a quarter of the device's memory; p->points says how many there are. After other
**          failures they are as many as before.
*/
ylm_status ylm__points_evaluate(gpu_points *p, uint32_t n, const ylm_progress *progress,
                                bool *full);
/* Rows of points from p->first on, to `data`, the array of all points. */
ylm_status ylm__points_download(gpu_points *p, float *data);
/* Forgets the rows there are: they are the host's. */
void ylm__points_forget(gpu_points *p);
/* Lambda and norm of n points from `first` on; flags those that are in a light. */
ylm_status ylm__points_extra(gpu_points *p, uint32_t first, uint32_t n, float *lambda, float *norm,
                             uint8_t *flags);
/* Copies rows of n points, none of which has been forgotten, to [n][4][stride], or from there. */
ylm_status ylm__points_take(gpu_points *p, size_t n, const uint32_t *point, float *rows);
ylm_status ylm__points_put(gpu_points *p, size_t n, const uint32_t *point, const float *rows);
/*
** points_probe.c: interpolants against values, relative distances [n]. `held`: the values are those
** of ylm__points_values, the light field at n free places [n][3], which are kept; inside [n] is 1 in a
** light.
*/
ylm_status ylm__points_probe(gpu_points *p, size_t n, const ylm_grid_probe *probe, bool held,
                             float *distance);
ylm_status ylm__points_values(gpu_points *p, size_t n, const float *places, uint8_t *inside,
                              const ylm_progress *progress);
/* remote.c: what keeps a grid's rows on the device while the processor refines it; *p is zero but
   for `l` and `there`. */
ylm_grid_backend ylm__points_backend(gpu_points *p);
/* The grid's copy from these rows, which are then its own, and what the finished grid has beside
   them. *copy is NULL where rows are the host's alone, or do not fit: points_copy.c */
ylm_status ylm__points_copy(gpu_points *p, ylm_gpu_grid **copy);
/* A buffer of so many bytes in *b that has the first `used` of the one that was there. */
ylm_status ylm__points_grow(gpu_points *p, ylm_gpu_buffer **b, uint64_t used, uint64_t bytes);
/* Of the device's memory, that rows may take. */
uint64_t ylm__points_most_bytes(const gpu_points *p);
/* A lattice cell in scene units, floats as push constants. */
void ylm__points_unit(const gpu_points *p, uint32_t unit[3]);
/* The push constants of shaders/grid_rows.glsl. */
static inline void points_bind(const gpu_points *p, ylm_gpu_buffer *bind[GRID_PARTS]) {
  for (int i = 0; i < GRID_PARTS; i++) bind[i] = p->data[i < p->parts ? i : 0];
}
/* Adds the wall time of a copy since `start`. */
static inline void points_copied(const gpu_points *p, const char *name, double start) {
  ylm__lights_copied(p->l, name, start);
}

#endif
