/*
** bake.c - grids baked on a device, by the loop of ylm_grid_bake. With a threshold, and of a
** uniform grid, cells and points are the device's (octree.c); with a tolerance it keeps the rows of
** points (remote.c). Where kernels have too few buffers for that, it sums.
*/
#include "../device/gpu.h"
#include "octree.h"

/* ylm_grid_bake with a back end of the lights' device, whose points stay there. */
static ylm_status bake_with(ylm_gpu_lights *l, const ylm_grid_form *form,
                            const ylm_grid_source *source, const ylm_grid_backend *backend,
                            gpu_points *p, ylm_grid **out, ylm_gpu_grid **copy, ylm_error *e) {
  ylm_grid_source own = *source;
  own.backend = backend;
  ylm_status s = ylm_grid_bake(form, &own, out, e);
  l->busy = false;
  p->e = p->q.e = e;
  if (s == YLM_OK && p->grid) s = ylm__points_copy(p, copy);
  if (s == YLM_OK) return YLM_OK;
  ylm_grid_free(*out);
  *out = NULL;
  return s;
}

/* With the octree, or the lattice, on the device. */
static ylm_status bake_octree(ylm_gpu_lights *l, const ylm_grid_form *form,
                              const ylm_grid_source *source, ylm_gpu_buffer *there, ylm_grid **out,
                              ylm_gpu_grid **copy, ylm_error *e) {
  octree *t = ylm_alloc_zero(1, sizeof *t);
  if (!t) return ylm_no_memory(e);
  t->l = l;
  t->occupied.there = there;
  ylm_grid_backend backend = ylm__octree_backend(t);
  ylm_status s = bake_with(l, form, source, &backend, &t->p, out, copy, e);
  if (s == YLM_EINVAL && t->gathered) s = ylm__octree_fails(t); /* that is not the caller's doing */
  ylm__octree_end(t);
  ylm_free(t);
  return s;
}

/* With rows of points on the device. */
static ylm_status bake_kept(ylm_gpu_lights *l, const ylm_grid_form *form,
                            const ylm_grid_source *source, ylm_gpu_buffer *there, ylm_grid **out,
                            ylm_gpu_grid **copy, ylm_error *e) {
  gpu_points p = {.l = l, .there = there};
  ylm_grid_backend backend = ylm__points_backend(&p);
  ylm_status s = bake_with(l, form, source, &backend, &p, out, copy, e);
  ylm__points_end(&p);
  return s;
}

/* Shading points in the device's memory are what the source says of them. */
static ylm_status check_points(const ylm_gpu_lights *l, const ylm_grid_source *source,
                               const ylm_gpu_buffer *there, ylm_error *e) {
  size_t row = 3 * ylm_dtype_size(source->occupied_dtype);
  if (!there) return YLM_OK;
  if (ylm_gpu_buffer_device(there) != l->gpu)
    return ylm_fail(e, YLM_EINVAL, "occupied is in the memory of another device");
  if (!source->occupied || ylm_gpu_buffer_bytes(there) / row < source->occupied)
    return ylm_fail_plain(e, YLM_ESHAPE);
  return YLM_OK;
}

/* By kernels, as far as the device has them. there: shading points on the device, or NULL. */
static ylm_status bake(ylm_gpu_lights *l, const ylm_grid_form *form, const ylm_grid_source *source,
                       ylm_gpu_buffer *there, ylm_grid **out, ylm_gpu_grid **copy, ylm_error *e) {
  ylm_grid_source own = *source;
  void *points = NULL;
  bool kernels = ylm_gpu_about(l->gpu)->binds >= OCTREE_BINDS;
  if (kernels && ylm__octree_takes(l->gpu, form, &own))
    return bake_octree(l, form, &own, there, out, copy, e);
  if (kernels && form->kind == YLM_GRID_ADAPTIVE && !form->dynamic)
    return bake_kept(l, form, &own, there, out, copy, e);
  ylm_status s = there ? ylm__occupied_fetch(&own, there, &points, e) : YLM_OK;
  if (points) own.occupied_points = points;
  if (s == YLM_OK && kernels && !form->dynamic && ylm__points_fit(form->cells))
    s = bake_kept(l, form, &own, NULL, out, copy, e);
  else if (s == YLM_OK)
    s = ylm_grid_bake(form, &own, out, e);
  ylm_free(points);
  return s;
}

ylm_status ylm_gpu_grid_bake(ylm_gpu_lights *l, const ylm_grid_form *form,
                             const ylm_grid_source *source, ylm_gpu_buffer *there, ylm_grid **out,
                             ylm_gpu_grid **copy, ylm_error *e) {
  double start = ylm_seconds();
  ylm_grid_source own = *source;
  own.field = ylm_gpu_lights_field(l);
  own.backend = NULL;
  *out = NULL;
  *copy = NULL;
  if (there)
    own.occupied_points = NULL;
  else if (!own.occupied_points)
    own.occupied = 0;
  ylm_status s = check_points(l, &own, there, e);
  if (s == YLM_OK) s = ylm__lights_idle(l, e);
  if (s != YLM_OK) return s;
  l->gpu->running++; /* from progress functions it cannot be closed */
  s = bake(l, form, &own, there, out, copy, e);
  l->gpu->running--;
  if (s == YLM_OK) ylm_grid_stats_of(*out)->seconds = ylm_seconds() - start;
  return s;
}
