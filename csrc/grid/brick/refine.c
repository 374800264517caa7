/* refine.c - the first task of a brick: its cells and evaluated points, without regard to its neighbours. */
#include "brick.h"

#include <string.h>

/* A brick so deep is never given up: its children would hardly have any of their own. */
static bool may_be_given_up(const plan *p, const brick *k) { return k->level < p->form.depth - 2; }

bool ylm__brick_given_up(const plan *p, const brick *k) {
  char path[FOLDER_PATH];
  ylm__folder_brick(p->how.folder, k->code, "s", path);
  return ylm__folder_has(path);
}

bool ylm__brick_refined(const plan *p, const brick *k) {
  char path[FOLDER_PATH];
  border_head h;
  ylm_grid_file_info info;
  ylm__folder_brick(p->how.folder, k->code, "b", path);
  if (!ylm__folder_has(path) || ylm__border_head(path, &h, NULL) != YLM_OK) return false;
  ylm__folder_brick(p->how.folder, k->code, "a", path);
  bool holds = ylm__folder_has(path) && ylm_grid_file_look(path, &info, NULL) == YLM_OK;
  if (!holds) return false;
  holds = info.stats.points == h.evaluated;
  ylm_grid_file_forget(&info);
  return holds;
}

/* The mark that a brick is given up. */
static ylm_status give_up(const plan *p, const brick *k, ylm_error *e) {
  char path[FOLDER_PATH];
  ylm__folder_brick(p->how.folder, k->code, "s", path);
  ylm_status s = ylm_file_save(path, k->code, strlen(k->code), e);
  if (s == YLM_OK) ylm__folder_sync(path);
  return s;
}

/* The boundary first: where the cells are, it is there too. */
static ylm_status save(const plan *p, const brick *k, ylm_grid *g, ylm_error *e) {
  char path[FOLDER_PATH];
  g->contents.octree_cells = g->cells;
  ylm__folder_brick(p->how.folder, k->code, "b", path);
  ylm_status s = ylm__border_write(g, path, e);
  ylm__folder_brick(p->how.folder, k->code, "a", path);
  if (s == YLM_OK) s = ylm_grid_write(g, path, e);
  if (s == YLM_OK) ylm__folder_sync(path);
  return s;
}

/* Cells and points of a brick whose grid is empty. */
static ylm_status make(const plan *p, baker *b, const brick *k) {
  ylm__grid_set_root(b->g, k->level, k->origin);
  b->learnt.occupied = p->top.learnt.occupied;
  if (p->source->field->tells_validity) {
    b->g->validity = ylm_alloc(1, sizeof *b->g->validity);
    if (!b->g->validity) return YLM_ENOMEM;
  }
  ylm_status s = ylm__cells_root(b);
  return s == YLM_OK ? ylm__refine(b, 1) : s;
}

ylm_status ylm__brick_refine(const plan *p, const brick *k, int threads,
                             const ylm_progress *progress, ylm_error *e) {
  if (ylm__brick_given_up(p, k) || ylm__brick_refined(p, k)) return YLM_OK;
  ylm_grid_source source = *p->source;
  source.threads = threads;
  source.progress = progress;
  source.max_points = may_be_given_up(p, k) ? p->how.points : 0;
  baker b;
  ylm__baker_begin(&b, ylm__grid_new(&p->form), &source, e);
  ylm_status s = b.g ? make(p, &b, k) : YLM_ENOMEM;
  if (s == YLM_ELIMIT && source.max_points && b.g->points >= source.max_points)
    s = give_up(p, k, e);
  else if (s == YLM_OK)
    s = save(p, k, b.g, e);
  else if (!b.told)
    ylm__grid_no_room(s, &source, e);
  ylm__baker_free(&b);
  ylm_grid_free(b.g);
  return s;
}
