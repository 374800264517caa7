/* finish.c - from cells and points to a grid that can be sampled. */
#include "baker.h"

ylm_status ylm__finish(baker *b) {
  ylm_grid *g = b->g;
  int threads = b->source->threads;
  ylm_status s = ylm__backend_fetch(b);
  if (s == YLM_OK && backend_keeps_cells(b)) s = ylm__assemble(b);
  if (s != YLM_OK) return s;
  g->contents.octree_cells = g->cells;
  s = ylm__corners_find_parents(b);
  if (s != YLM_OK) return s;
  double t = ylm_seconds();
  ylm__corners_find_shared(b, NULL);
  g->stats.lattice_seconds += ylm_seconds() - t;
  s = ylm__grid_fill_invalid(g);
  t = ylm_seconds();
  ylm__grid_find_baked(g);
  bool continuous = g->contents.form.kind == YLM_GRID_ADAPTIVE && g->contents.form.continuous;
  ylm_progress_part whole; /* the last stage stays at its end; an update is not broken off here */
  const ylm_progress *progress = g->contents.form.dynamic ? NULL : b->making.progress;
  progress = ylm_progress_part_of(&whole, progress, NULL, 1, 0, 1);
  if (s == YLM_OK && continuous) s = ylm__grid_make_continuous(g, threads, progress);
  g->stats.continuity_seconds += ylm_seconds() - t;
  return s == YLM_OK ? ylm__grid_finish(g) : s;
}
