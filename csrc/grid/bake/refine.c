/*
** refine.c - the loop over levels that makes every grid, whoever finds, evaluates and keeps its
** points: corners of the voxels, their light, their metric, then what is split. A uniform grid is
** one level. By a threshold the back end splits with the metric; by a tolerance b->choose does,
** which measures residuals first.
*/
#include "baker.h"

/* The stage that progress names. */
static void name_stage(baker *b, int level) {
  if (b->g->contents.form.kind == YLM_GRID_UNIFORM)
    snprintf(b->stage_text, sizeof b->stage_text, "baking");
  else
    snprintf(b->stage_text, sizeof b->stage_text, "level %d", level);
}

static ylm_status refine_level(baker *b, int level, size_t *voxels) {
  const ylm_grid_backend *k = backend_keeps_cells(b) ? b->remote : &b->own;
  size_t fresh = 0;
  name_stage(b, b->wave.n ? b->g->cell[b->wave.cell[0]].level : level);
  double t = ylm_seconds();
  ylm_status s = k->corners(k->self, &b->making, level, &fresh);
  b->g->stats.lattice_seconds += ylm_seconds() - t;
  *voxels = 0;
  if (s == YLM_OK) s = ylm__backend_evaluate(b, fresh);
  if (s == YLM_OK) s = k->metric(k->self, &b->making, level, voxels);
  if (s != YLM_OK || !b->choose) return s;
  s = b->choose(b->chooser);
  ylm__cells_advance(b);
  *voxels = b->wave.n;
  return s;
}

ylm_status ylm__refine(baker *b, size_t voxels) {
  ylm_status s = YLM_OK;
  for (int level = 0; voxels && s == YLM_OK; level++) s = refine_level(b, level, &voxels);
  b->told |= s != YLM_OK && backend_keeps_cells(b);
  return s;
}
