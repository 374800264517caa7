/* bake.c - grids baked on a device: by which of the ways, and what of them stays there. */
#include "gpu.h"
#include "octree.h"

ylm_status ylm_gpu_grid_bake(ylm_gpu_lights *l, const ylm_grid_form *form,
                             const ylm_grid_source *source, ylm_grid **out, ylm_gpu_grid **copy,
                             ylm_error *e) {
  double start = ylm_seconds();
  ylm_grid_source own = *source;
  own.field = ylm_gpu_lights_field(l);
  *out = NULL;
  *copy = NULL;
  if (ylm_gpu_about(l->gpu)->binds < OCTREE_BINDS || form->kind != YLM_GRID_ADAPTIVE ||
      form->tolerance > 0)
    return ylm_grid_bake(form, &own, out, e);
  ylm_status s = ylm__lights_idle(l, e);
  if (s != YLM_OK) return s;
  l->gpu->running++; /* from progress functions it cannot be closed */
  s = octree_bake(l, form, &own, out, copy, e);
  l->gpu->running--;
  if (s == YLM_OK) ylm_grid_stats_of(*out)->seconds = ylm_seconds() - start;
  return s;
}
