/* bake.c - the three bakes: by a threshold, by a tolerance, and of a uniform grid. */
#include "baker.h"
#include "surface.h"

#include <math.h>
#include <string.h>

ylm_status cell_list_push(cell_list *l, uint32_t cell) {
  if (l->n == l->room) {
    size_t room = l->room ? l->room * 2 : 64;
    uint32_t *more = ylm_realloc(l->cell, l->n * sizeof *more, room, sizeof *more);
    if (!more) return YLM_ENOMEM;
    l->cell = more;
    l->room = room;
  }
  l->cell[l->n++] = cell;
  return YLM_OK;
}

/* -- the three bakes ------------------------------------------------------------------------ */

ylm_status baker_refine_threshold(baker *b) {
  ylm_grid *g = b->g;
  int depth = g->view.form.depth;
  for (int level = 0; b->wave.n; level++) {
    snprintf(b->stage_text, sizeof b->stage_text, "level %d", level);
    ylm_status s = baker_corners(b);
    for (size_t i = 0; s == YLM_OK && i < b->wave.n; i++) {
      const ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
      bool crossed = c->flags & YLM_GRID_CROSSED;
      if (c->level < depth && cell_splits((double)c->error, g->view.form.threshold, crossed))
        s = baker_split(b, b->wave.cell[i]);
    }
    if (s != YLM_OK) return s;
    baker_advance(b);
  }
  return YLM_OK;
}

/* The paper's: split where the metric exceeds the threshold. */
static ylm_status bake_threshold(baker *b) {
  ylm_status s = baker_refine_threshold(b);
  return s == YLM_OK ? baker_finish(b) : s;
}

ylm_status baker_root(baker *b) {
  ylm_grid *g = b->g;
  ylm_status s = ylm__grid_reserve_cells(g, 1);
  if (s != YLM_OK) return s;
  ylm_grid_cell root = {
      .error = NAN, .residual = NAN, .flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED | YLM_GRID_CROSSED};
  for (int k = 0; k < 8; k++) root.corner[k] = YLM_GRID_NONE;
  g->cell[g->cells++] = root;
  return cell_list_push(&b->wave, 0);
}

/* Room for what is known before: voxels, and where all are occupied their points. */
static ylm_status reserve_uniform(baker *b, const uint8_t *mark, size_t n) {
  ylm_grid *g = b->g;
  const uint32_t *r = g->view.resolution;
  size_t cells = 0, points = (size_t)(r[0] + 1) * (r[1] + 1) * (r[2] + 1);
  for (size_t i = 0; i < n; i++) cells += mark[i];
  ylm_status s = ylm__grid_reserve_cells(g, cells);
  bool all = cells == n && (!b->source->max_points || points <= b->source->max_points);
  return s == YLM_OK && all ? ylm__grid_reserve_points(g, points) : s;
}

/* Marks the voxels of a lattice that are occupied: all, those that hold shading points, or those
   that surfaces meet. */
static ylm_status mark_uniform(baker *b, uint8_t *mark, size_t n) {
  ylm_grid_stats *stats = &b->g->stats;
  uint64_t *voxel;
  size_t voxels;
  if (!b->source->meshes) {
    if (!b->source->occupied_points)
      memset(mark, 1, n);
    else
      occupancy_mark_uniform(b->g, b->source, mark, &stats->outside);
    return YLM_OK;
  }
  ylm_status s = ylm_grid_surface_voxels(b->g, b->source, &voxel, &voxels, &stats->outside, b->e);
  b->told = s != YLM_OK;
  for (size_t i = 0; s == YLM_OK && i < voxels; i++) mark[voxel[i]] = 1;
  if (s == YLM_OK) ylm_free(voxel);
  return s;
}

/* Voxels of a lattice, all or those that are occupied. */
static ylm_status bake_uniform(baker *b) {
  ylm_grid *g = b->g;
  const uint32_t *r = g->view.resolution;
  size_t n = (size_t)r[0] * r[1] * r[2];
  uint8_t *mark = ylm_alloc_zero(n, 1);
  if (!mark) return YLM_ENOMEM;
  double t = ylm_seconds();
  ylm_status s = mark_uniform(b, mark, n);
  g->stats.occupancy_seconds = ylm_seconds() - t;
  if (s == YLM_OK) s = reserve_uniform(b, mark, n);
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    if (!mark[i]) continue;
    s = cell_list_push(&b->wave, (uint32_t)g->cells);
    if (s != YLM_OK) break;
    ylm_grid_cell c = {.error = NAN, .residual = NAN, .flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED};
    c.origin[0] = (uint32_t)(i % r[0]);
    c.origin[1] = (uint32_t)(i / r[0] % r[1]);
    c.origin[2] = (uint32_t)(i / r[0] / r[1]);
    for (int k = 0; k < 8; k++) c.corner[k] = YLM_GRID_NONE;
    g->cell[g->cells++] = c;
  }
  ylm_free(mark);
  snprintf(b->stage_text, sizeof b->stage_text, "baking");
  if (s == YLM_OK) s = baker_corners(b);
  return s == YLM_OK ? baker_finish(b) : s;
}

static ylm_status bake(baker *b) {
  b->stage = b->stage_text;
  if (b->g->view.form.kind == YLM_GRID_UNIFORM) return bake_uniform(b);
  double t = ylm_seconds();
  bool found;
  ylm_status s = keeper_occupancy(b, &found);
  if (b->source->meshes) {
    s = occupancy_from_surfaces(&b->learnt.occupied, b->g, b->source, &b->g->stats.outside, b->e);
    b->told = s != YLM_OK && s != YLM_ENOMEM;
  } else if (!found)
    s = occupancy_build(&b->learnt.occupied, b->g, b->source, &b->g->stats.outside);
  b->g->stats.occupancy_seconds = ylm_seconds() - t;
  if (s == YLM_OK) s = baker_root(b);
  if (s != YLM_OK) return s;
  return b->g->view.form.tolerance > 0 ? ylm__grid_bake_tolerance(b) : bake_threshold(b);
}

ylm_status ylm__grid_check_source(const ylm_grid_source *s, bool dynamic, ylm_error *e) {
  size_t bad;
  if (!s->field || !s->field->evaluate) return ylm_fail(e, YLM_EINVAL, "no light field");
  if (dynamic && !s->lights)
    return ylm_fail(e, YLM_EINVAL,
                    "dynamic: a grid that is to be updated is baked from sphere or flat lights");
  if (s->meshes && (s->occupied || s->occupied_points))
    return ylm_fail(e, YLM_EINVAL, "occupied: either points or surfaces");
  if (s->meshes) return ylm__grid_check_meshes(s->meshes, s->mesh, e);
  if (!s->occupied_points) return YLM_OK;
  if (s->occupied == 0) return ylm_fail(e, YLM_EINVAL, "occupied: no points");
  if (!ylm_all_finite(s->occupied_dtype, s->occupied_points, 3 * s->occupied, &bad))
    return ylm_fail(e, YLM_EDOMAIN, "occupied: point %zu is not finite", bad / 3 + 1);
  return YLM_OK;
}

void baker_free(baker *b) {
  baker_free_block(&b->block);
  ylm_free(b->wave.cell);
  ylm_free(b->next.cell);
  ylm_free(b->parent.cell);
  ylm_free(b->used);
}

ylm_status ylm__grid_no_room(ylm_status s, const ylm_grid_source *source, ylm_error *e) {
  if (s == YLM_ENOMEM) ylm_fail(e, s, "the grid does not fit into memory");
  if (s == YLM_ELIMIT)
    ylm_fail(e, s, "the grid needs more than %zu points",
             source->max_points ? source->max_points : (size_t)YLM_GRID_NONE);
  return s;
}

ylm_status ylm_grid_bake(const ylm_grid_form *form, const ylm_grid_source *source, ylm_grid **out,
                         ylm_error *e) {
  double begin = ylm_seconds();
  *out = NULL;
  ylm_status s = ylm__grid_check_form(form, e);
  if (s == YLM_OK) s = ylm__grid_check_source(source, form->dynamic, e);
  if (s != YLM_OK) return s;
  baker b = {.g = ylm__grid_new(form), .source = source, .e = e};
  s = b.g ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && b.g->follower) s = b.g->follower->begin(b.g, source, &b.surface, e);
  if (s == YLM_OK) s = keeper_begin(&b);
  if (s == YLM_OK) s = bake(&b);
  if (s == YLM_OK && b.g->follower) s = b.g->follower->end(b.g, &b.learnt);
  occupancy_free(&b.learnt.occupied);
  panel_free(&b.learnt.panel);
  baker_free(&b);
  if (s != YLM_OK) {
    ylm_grid_free(b.g);
    return b.told ? s : ylm__grid_no_room(s, source, e);
  }
  if (!form->dynamic) ylm__grid_trim(b.g);
  b.g->stats.seconds = ylm_seconds() - begin;
  *out = b.g;
  return YLM_OK;
}
