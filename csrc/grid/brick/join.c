/*
** join.c - the last task of a brick: evaluated points of its neighbours on its boundary, then all that a bake does at its
** end.
**
** Continuity of a leaf depends on the evaluated points in its own closed box, and no leaf is larger than its brick. The top, the
** cells above and beside bricks, is joined like a brick. Of points that several have, the first in order counts: the top's, then
** that of the brick with the least code.
*/
#include "brick.h"
#include "ylm_list.h"

#include <string.h>

/* A grid that takes points over. */
typedef struct joining {
  const plan *p;
  const brick *k; /* NULL: the top */
  baker *b;
  uint8_t *taken; /* [room] by point: it was taken over; others' are not better */
  size_t room;
  uint32_t box[6];
} joining;

/* -- points ----------------------------------------------------------------------------------------- */

/* Does a point touch a leaf of the top that is no brick? */
static bool touches_top(const joining *j, const uint32_t at[3]) {
  const ylm_grid *g = j->b->g;
  for (int side = 0; side < 8; side++) {
    uint32_t beside[3];
    if (ylm__grid_side(g, at, side, beside) &&
        !(g->cell[ylm__grid_finest(g, beside)].flags & YLM_GRID_BRICK))
      return true;
  }
  return false;
}

/* Does the grid want a point there? */
static bool is_wanted(const joining *j, const uint32_t at[3]) {
  if (!j->k) return touches_top(j, at);
  bool in = true;
  for (int a = 0; a < 3; a++) in &= at[a] >= j->box[a] && at[a] <= j->box[a + 3];
  return in;
}

/* One point of another grid, which is `better` than one of the brick's own. */
static ylm_status take_point(joining *j, const void *record, bool better) {
  ylm_grid *g = j->b->g;
  point_record r;
  uint32_t point;
  memcpy(&r, record, sizeof r);
  if (!is_wanted(j, r.at)) return YLM_OK;
  size_t before = g->points;
  ylm_status s = ylm__corners_point(j->b, r.at, 0, &point);
  if (s == YLM_OK && g->points > j->room) {
    size_t room = 2 * g->points;
    if (!ylm_list_resize(&j->taken, j->room, room, 1)) return YLM_ENOMEM;
    memset(j->taken + j->room, 0, room - j->room);
    j->room = room;
  }
  if (s != YLM_OK) return s;
  bool is_new = g->points > before;
  if (g->validity && is_new &&
      !ylm_list_resize(&g->validity, before, g->points, sizeof *g->validity))
    return YLM_ENOMEM;
  g->evaluated = g->points;
  if (j->taken[point] || !(is_new || better)) return YLM_OK;
  j->taken[point] = 1;
  ylm__point_take(g, point, record);
  return YLM_OK;
}

/* -- the top's points for a brick ------------------------------------------------------------------- */

static ylm_status take_top(joining *j) {
  const ylm_grid *top = j->p->top.g;
  char *record = ylm_alloc(1, point_bytes(top));
  ylm_status s = record ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < top->evaluated && s == YLM_OK; i++) {
    if (!is_wanted(j, top->lattice + 3 * i)) continue;
    ylm__point_put(top, (uint32_t)i, record);
    s = take_point(j, record, true);
  }
  ylm_free(record);
  return s;
}

/* -- other bricks' points ----------------------------------------------------------------------------- */

/* The closed box of a section of a brick's boundary. */
static void section_box(const uint32_t box[6], int section, uint32_t out[6]) {
  for (int a = 0; a < 3; a++, section /= 3) {
    out[a] = section % 3 == 2 ? box[a + 3] : box[a];
    out[a + 3] = section % 3 == 0 ? box[a] : box[a + 3];
  }
}

/* Does a box touch a leaf of the top that is no brick? */
static bool meets_leaf(const joining *j, uint32_t cell, const uint32_t box[6]) {
  const ylm_grid_cell *c = &j->p->top.g->cell[cell];
  uint32_t own[6];
  brick_box(j->p, c->origin, c->level, own);
  if (c->flags & YLM_GRID_BRICK || !boxes_touch(own, box)) return false;
  if (!c->child) return true;
  for (uint32_t k = 0; k < 8; k++)
    if (meets_leaf(j, c->child + k, box)) return true;
  return false;
}

/* The points that a brick has to give; a file that is damaged is removed, to be baked anew. */
static ylm_status take_brick(joining *j, const brick *from, ylm_error *e) {
  char path[FOLDER_PATH];
  border_head h;
  uint32_t box[6], part[6];
  size_t bytes = point_bytes(j->b->g);
  ylm__folder_brick(j->p->how.folder, from->code, "b", path);
  ylm_status s = ylm__border_head(path, &h, e);
  brick_box(j->p, from->origin, from->level, box);
  for (int section = 0; section < 27 && s == YLM_OK; section++) {
    char *record;
    section_box(box, section, part);
    bool any = h.first[section + 1] > h.first[section] &&
               (j->k ? boxes_touch(part, j->box) : meets_leaf(j, 0, part));
    if (!any) continue;
    s = ylm__border_section(path, j->b->g, &h, section, &record, e);
    if (s != YLM_OK) break;
    for (size_t i = 0; i < h.first[section + 1] - h.first[section] && s == YLM_OK; i++)
      s = take_point(j, record + i * bytes, j->k && ylm__brick_before(from, j->k));
    ylm_free(record);
    if (s != YLM_OK) ylm__grid_no_room(s, j->p->source, e);
  }
  if (s == YLM_EIO && !ylm__folder_has(path)) /* another process found it damaged, and removed it */
    s = YLM_ECHECKSUM;
  if (s != YLM_ECHECKSUM) return s;
  remove(path);
  return ylm_fail(
      e, s,
      "%s: the file is damaged, and removed: bake again, or all anew, with fresh = true (ylm "
      "bake --fresh)",
      path);
}

static ylm_status take_all(joining *j, ylm_error *e) {
  const plan *p = j->p;
  uint32_t *list;
  size_t n;
  ylm_status s = j->k ? take_top(j) : YLM_OK;
  if (s == YLM_OK) s = ylm__plan_touching(p, j->box, &list, &n);
  if (s != YLM_OK) return ylm__grid_no_room(s, p->source, e);
  for (size_t i = 0; i < n && s == YLM_OK; i++)
    if (!j->k || strcmp(p->brick[list[i]].code, j->k->code) != 0)
      s = take_brick(j, &p->brick[list[i]], e);
  ylm_free(list);
  return s;
}

/* -- a grid with all its points --------------------------------------------------------------------- */

/* The grid as it was refined; a file that is damaged is removed, to be baked anew. */
static ylm_status read_own(const plan *p, const brick *k, ylm_grid **g, ylm_error *e) {
  char path[FOLDER_PATH];
  if (!k) return ylm__top_copy(p, g, e);
  ylm__folder_brick(p->how.folder, k->code, "a", path);
  ylm_status s = ylm_grid_read(path, g, e);
  if (s == YLM_ECHECKSUM || s == YLM_EFORMAT) remove(path);
  return s;
}

/* The hash of evaluated points, which a grid without continuity does not keep. */
static ylm_status index_points(ylm_grid *g) {
  ylm_status s = ylm__lattice_hash_reserve(&g->hash, g->evaluated);
  for (size_t i = 0; s == YLM_OK && i < g->evaluated; i++)
    *ylm__lattice_hash_at(&g->hash, lattice_key(g->lattice + 3 * i)) = (uint32_t)i;
  return s;
}

ylm_status ylm__brick_gather(const plan *p, const brick *k, int threads, ylm_grid_source *source,
                             baker *b, ylm_error *e) {
  ylm_grid *g = NULL;
  *source = *p->source;
  source->threads = threads;
  source->max_points = 0;
  source->team = NULL;
  ylm_status s = read_own(p, k, &g, e);
  ylm__baker_begin(b, g, source, e);
  if (s != YLM_OK) return s;
  joining j = {.p = p, .k = k, .b = b, .room = g->points};
  if (k)
    brick_box(p, k->origin, k->level, j.box);
  else
    brick_box(p, (const uint32_t[3]){0, 0, 0}, 0, j.box);
  j.taken = ylm_alloc_zero(j.room, 1);
  s = j.taken ? index_points(g) : YLM_ENOMEM;
  if (s == YLM_OK)
    s = take_all(&j, e);
  else
    ylm__grid_no_room(s, p->source, e);
  ylm_free(j.taken);
  if (s != YLM_OK) return s;
  s = ylm__corners_find_parents(b);
  if (s == YLM_OK) ylm__corners_find_shared(b, NULL);
  return ylm__grid_no_room(s, p->source, e);
}

/* -- finishing ---------------------------------------------------------------------------------------- */

/* Gives points in lights the values that all bricks share; those have filled[point] = 1. */
static ylm_status take_filled(const plan *p, ylm_grid *g, uint8_t *filled, ylm_error *e) {
  char path[FOLDER_PATH];
  point_list l;
  ylm__folder_file(p->how.folder, "fill", path);
  ylm_status s = ylm__points_read(path, g, &l, e);
  for (size_t i = 0; s == YLM_OK && i < l.points; i++) {
    point_record r;
    memcpy(&r, l.point + i * l.bytes, sizeof r);
    uint32_t point = ylm__lattice_hash_find(&g->hash, lattice_key(r.at));
    if (point == YLM_GRID_NONE || point >= g->evaluated) continue;
    ylm__point_take(g, point, l.point + i * l.bytes);
    filled[point] = 1;
  }
  if (s == YLM_OK) ylm__points_free(&l);
  return s;
}

static ylm_status fill(const plan *p, ylm_grid *g, ylm_error *e) {
  uint8_t *filled = ylm_alloc_zero(g->evaluated, 1);
  if (!filled) return ylm__grid_no_room(YLM_ENOMEM, p->source, e);
  ylm_status s = p->filled ? take_filled(p, g, filled, e) : YLM_OK;
  if (s == YLM_OK) s = ylm__grid_no_room(ylm__grid_fill_others(g, filled), p->source, e);
  ylm_free(filled);
  return s;
}

/* The end of a bake, as ylm__finish. */
static ylm_status finish(const plan *p, ylm_grid *g, int threads, ylm_error *e) {
  ylm_status s = fill(p, g, e);
  if (s != YLM_OK) return s;
  ylm__grid_find_baked(g);
  if (g->contents.form.continuous) s = ylm__grid_make_continuous(g, threads, NULL);
  if (s == YLM_OK) s = ylm__grid_finish(g);
  return ylm__grid_no_room(s, p->source, e);
}

ylm_status ylm__brick_join(const plan *p, const brick *k, int threads, ylm_error *e) {
  char path[FOLDER_PATH];
  ylm_grid_file_info info;
  if (k)
    ylm__folder_brick(p->how.folder, k->code, "ylm", path);
  else
    ylm__folder_file(p->how.folder, "top.ylm", path);
  if (ylm__folder_has(path) && ylm_grid_file_look(path, &info, NULL) == YLM_OK) {
    ylm_grid_file_forget(&info);
    return YLM_OK;
  }
  ylm_grid_source source;
  baker b;
  ylm_status s = ylm__brick_gather(p, k, threads, &source, &b, e);
  if (s == YLM_OK) s = finish(p, b.g, threads, e);
  if (s == YLM_OK) s = ylm_grid_write(b.g, path, e);
  if (s == YLM_OK) ylm__folder_sync(path);
  ylm__baker_free(&b);
  ylm_grid_free(b.g);
  return s;
}
