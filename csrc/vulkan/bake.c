/*
** bake.c - grids baked on a device. With a threshold the octree is refined there, a uniform grid is
*one
** level (octree.c); with a tolerance the host decides, by what the device tells it of the points'
** rows, which it keeps (keeper.c). Where kernels have too few buffers for that, the device sums.
*/
#include "gpu.h"
#include "octree.h"

/* The host's bake; rows stay on the device. */
static ylm_status bake_kept(ylm_gpu_lights *l, const ylm_grid_form *form,
                            const ylm_grid_source *source, ylm_grid **out, ylm_gpu_grid **copy,
                            ylm_error *e) {
  gpu_points p = {.l = l};
  ylm_grid_keeper keeper = points_keeper(&p);
  ylm_grid_source own = *source;
  own.keeper = &keeper;
  ylm_status s = ylm_grid_bake(form, &own, out, e);
  p.e = p.q.e = e;
  if (s == YLM_OK && p.grid) s = points_copy(&p, copy);
  points_end(&p);
  if (s == YLM_OK) return YLM_OK;
  ylm_grid_free(*out);
  *out = NULL;
  return s;
}

ylm_status ylm_gpu_grid_bake(ylm_gpu_lights *l, const ylm_grid_form *form,
                             const ylm_grid_source *source, ylm_grid **out, ylm_gpu_grid **copy,
                             ylm_error *e) {
  double start = ylm_seconds();
  ylm_grid_source own = *source;
  own.field = ylm_gpu_lights_field(l);
  *out = NULL;
  *copy = NULL;
  if (ylm_gpu_about(l->gpu)->binds < OCTREE_BINDS) return ylm_grid_bake(form, &own, out, e);
  ylm_status s = ylm__lights_idle(l, e);
  if (s != YLM_OK) return s;
  l->gpu->running++; /* from progress functions it cannot be closed */
  s = (octree_takes(l->gpu, form, &own) ? octree_bake : bake_kept)(l, form, &own, out, copy, e);
  l->gpu->running--;
  if (s == YLM_OK) ylm_grid_stats_of(*out)->seconds = ylm_seconds() - start;
  return s;
}
