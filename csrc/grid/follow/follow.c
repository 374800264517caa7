/* follow.c - the state that updates need: made by the bake, kept per point. */
#include "follow.h"
#include "../bake/surface.h"

#include <string.h>

/* -- lights ---------------------------------------------------------------------------------- */

/* The lights of a bake. */
static ylm_status take_lights(grid_dynamic *d, const ylm_light_set *lights) {
  ylm_light_list list;
  ylm_status s = ylm_light_set_list(lights, &list);
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < list.n && s == YLM_OK; i++) s = ylm_light_keep(&d->shapes, &list.light[i]);
  ylm_free(list.shapes);
  d->light = list.light;
  d->lights = list.n;
  d->mover_of = ylm_alloc(d->lights, sizeof *d->mover_of);
  if (!d->mover_of) return YLM_ENOMEM;
  for (size_t i = 0; i < d->lights; i++) d->mover_of[i] = -1;
  return s;
}

void ylm__dynamic_sweep(grid_dynamic *d) {
  if (!d->shapes.n) return;
  for (size_t i = 0; i < d->lights; i++) ylm_light_mark(&d->light[i]);
  for (size_t m = 0; m < d->movers; m++)
    for (int k = 0; k < STATES; k++)
      if (d->mover[m].taken[k]) ylm_light_mark(&d->mover[m].state[k]);
  ylm_light_sweep(&d->shapes);
}

/* -- making ------------------------------------------------------------------------------- */

/* Shading points or surfaces of a bake. */
static ylm_status take_occupied(grid_dynamic *d, const ylm_grid *g, ylm_error *e) {
  ylm_grid_source *s = &d->source;
  if (s->meshes) {
    ylm_status status = ylm_grid_surface_create(s->meshes, s->mesh, g->contents.form.bounds,
                                                s->threads, &d->surface, e);
    if (status == YLM_OK) status = ylm__surface_keep(d->surface);
    if (status == YLM_OK) s->mesh = ylm__surface_meshes(d->surface);
    return status;
  }
  if (!s->occupied_points) return YLM_OK;
  d->occupied_points =
      ylm_alloc_copy(s->occupied_points, s->occupied * 3 * ylm_dtype_size(s->occupied_dtype), 1);
  s->occupied_points = d->occupied_points;
  return d->occupied_points ? YLM_OK : YLM_ENOMEM;
}

/* Before a bake: lights and shading points are copied. */
static ylm_status begin(ylm_grid *g, const ylm_grid_source *source,
                        const ylm_grid_surface **surface, ylm_error *e) {
  grid_dynamic *d = g->dynamic = ylm_alloc_zero(1, sizeof *d);
  if (!d) return YLM_ENOMEM;
  ylm_status s = take_lights(d, source->lights);
  if (s != YLM_OK) return s;
  d->source = *source;
  d->source.field = NULL;
  d->source.lights = NULL;
  d->source.progress = NULL;
  s = take_occupied(d, g, e);
  if (s != YLM_OK) return s;
  *surface = d->surface;
  d->hessians = 6 * (size_t)g->contents.count * (size_t)g->contents.form.metric_channels;
  d->bounds =
      (ylm_light_bounds){.lmax = g->contents.form.lmax, .channels = g->contents.form.channels};
  return ylm_light_bounds_meet(&d->bounds, d->lights, d->light, e);
}

static size_t bytes(const ylm_grid *g) {
  const grid_dynamic *d = g->dynamic;
  if (!d) return 0;
  return sizeof *d + d->shapes.bytes + d->lights * (sizeof *d->light + sizeof *d->mover_of) +
         d->movers * (sizeof *d->mover + d->room) +
         d->room * ((d->hessians + 2) * sizeof(float) + sizeof *d->sign) +
         (d->born_room + d->cell_room) * sizeof *d->sign +
         d->source.occupied * 3 * ylm_dtype_size(d->source.occupied_dtype) +
         ylm__surface_bytes(d->surface) + d->log_bytes + d->spare_room * sizeof *d->spare +
         ylm__panel_bytes(&d->panel, g->width);
}

static ylm_status end(ylm_grid *g, learnt *l) {
  grid_dynamic *d = g->dynamic;
  d->occupied = l->occupied;
  d->ratio = l->ratio;
  d->tight = d->loosest = l->tight;
  d->panel = l->panel;
  *l = (learnt){0};
  ylm__dynamic_sign_all(g, d->source.threads);
  g->stats.bytes += bytes(g);
  return YLM_OK;
}

static void free_all(ylm_grid *g) {
  grid_dynamic *d = g->dynamic;
  if (!d) return;
  for (size_t m = 0; m < d->movers; m++) ylm_free(d->mover[m].seen);
  ylm_free(d->mover);
  ylm_light_sweep(&d->shapes); /* all of them: none is marked */
  ylm_free(d->shapes.shape);
  ylm_free(d->light);
  ylm_free(d->mover_of);
  ylm_free(d->hessian);
  ylm_free(d->size);
  ylm_free(d->drift);
  ylm_free(d->sign);
  ylm_free(d->born_sign);
  ylm_free(d->cell_sign);
  ylm_free(d->occupied_points);
  ylm_grid_surface_free(d->surface);
  ylm_regrow_free(d->log, d->log_bytes);
  ylm_free(d->spare);
  ylm__occupancy_free(&d->occupied);
  ylm__lattice_hash_free(&d->forced);
  ylm__panel_free(&d->panel);
  ylm_free(d);
}

/* -- voxels that failed --------------------------------------------------------------------- */

/* Remembers that a voxel is to be split. */
static ylm_status failed(ylm_grid *g, const ylm_grid_cell *c) {
  grid_dynamic *d = g->dynamic;
  if (ylm__lattice_hash_reserve(&d->forced, d->forced.used + 1) != YLM_OK) return YLM_ENOMEM;
  *ylm__lattice_hash_at(&d->forced, cell_key(c)) = (uint32_t)g->stats.update.updates;
  return YLM_OK;
}

bool ylm__dynamic_forced(const ylm_grid *g, const ylm_grid_cell *c) {
  uint32_t when = ylm__lattice_hash_find(&g->dynamic->forced, cell_key(c));
  uint32_t now = (uint32_t)g->stats.update.updates;
  return when != YLM_GRID_NONE && now - when < FORCED_UPDATES;
}

const follower ylm__follower = {begin,
                                ylm__dynamic_reserve,
                                ylm__dynamic_store,
                                ylm__dynamic_sign,
                                ylm__dynamic_room_births,
                                ylm__dynamic_sign_births,
                                failed,
                                end,
                                free_all,
                                bytes};
