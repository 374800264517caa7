/*
** lights.c - values for points in lights that lie on boundaries of bricks.
**
** Such a point takes the mean of first-order values from the valid corners of all voxels around it, layer by layer from the
** outside of the light (bake/invalid.c). Voxels hang together where they share a point in a light. Groups of voxels that
** reach a boundary are gathered from all bricks into one small grid, voxels in the order of the whole bake, and filled
** there. The other groups of a brick are its own affair.
*/
#include "brick.h"
#include "ylm_list.h"

#include <stdlib.h>
#include <string.h>

/* -- groups ------------------------------------------------------------------------------------------- */

static uint32_t leader_of(uint32_t *group, uint32_t p) {
  while (group[p] != p) p = group[p] = group[group[p]];
  return p;
}

static bool is_invalid(const ylm_grid *g, uint32_t p) {
  return p < g->evaluated && g->flags[p] & YLM_GRID_POINT_INVALID;
}

static bool is_on_boundary(const ylm_grid *g, const uint32_t at[3]) {
  bool on = false;
  for (int a = 0; a < 3; a++) on |= at[a] == g->contents.root[a] || at[a] > g->last[a];
  return on;
}

/* Joins the points in lights of each voxel to a group. */
static void join_groups(const ylm_grid *g, uint32_t *group) {
  for (uint32_t p = 0; p < g->evaluated; p++) group[p] = p;
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    uint32_t first = YLM_GRID_NONE;
    for (int k = 0; k < 8; k++) {
      if (!is_invalid(g, c->corner[k])) continue;
      uint32_t leader = leader_of(group, c->corner[k]);
      if (first == YLM_GRID_NONE) first = leader;
      group[leader] = first;
    }
  }
}

/* -- the voxels of a brick that others share points with ------------------------------------------- */

/* A list in the making. */
typedef struct gathering {
  const ylm_grid *g;
  uint32_t *number; /* [evaluated] of a point in the list */
  point_list l;
  size_t voxel_room, point_room;
} gathering;

static ylm_status add_point(gathering *t, uint32_t p, uint32_t *number) {
  if (t->number[p] == YLM_GRID_NONE) {
    if (!ylm_list_reserve(&t->l.point, t->l.points, t->l.points + 1, &t->point_room, t->l.bytes))
      return YLM_ENOMEM;
    t->number[p] = (uint32_t)t->l.points;
    ylm__point_put(t->g, p, t->l.point + t->l.points++ * t->l.bytes);
  }
  *number = t->number[p];
  return YLM_OK;
}

static ylm_status add_voxel(gathering *t, const ylm_grid_cell *c) {
  if (!ylm_list_reserve(&t->l.voxel, t->l.voxels, t->l.voxels + 1, &t->voxel_room,
                        sizeof *t->l.voxel))
    return YLM_ENOMEM;
  voxel_record v = {.level = c->level};
  memcpy(v.origin, c->origin, sizeof v.origin);
  ylm_status s = YLM_OK;
  for (int k = 0; k < 8 && s == YLM_OK; k++) {
    v.corner[k] = YLM_GRID_NONE;
    if (c->corner[k] < t->g->evaluated) s = add_point(t, c->corner[k], &v.corner[k]);
  }
  t->l.voxel[t->l.voxels++] = v;
  return s;
}

/* The voxels of groups that reach the boundary; of the top all groups. */
static ylm_status list_voxels(gathering *t, bool top) {
  const ylm_grid *g = t->g;
  uint32_t *group = ylm_alloc(g->evaluated, sizeof *group);
  uint8_t *open = ylm_alloc_zero(g->evaluated, 1);
  t->number = ylm_alloc(g->evaluated, sizeof *t->number);
  t->l.bytes = point_bytes(g);
  ylm_status s = group && open && t->number ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) join_groups(g, group);
  for (uint32_t p = 0; s == YLM_OK && p < g->evaluated; p++) {
    t->number[p] = YLM_GRID_NONE;
    if (is_invalid(g, p) && (top || is_on_boundary(g, g->lattice + 3 * (size_t)p)))
      open[leader_of(group, p)] = 1;
  }
  /* A brick's own cell is the top's too, which lists it. */
  for (size_t i = top ? 0 : 1; s == YLM_OK && i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    bool any = false;
    for (int k = 0; k < 8; k++)
      any |= is_invalid(g, c->corner[k]) && open[leader_of(group, c->corner[k])];
    if (any) s = add_voxel(t, c);
  }
  ylm_free(group);
  ylm_free(open);
  ylm_free(t->number);
  return s;
}

/* The list of a brick, or of the top. */
static ylm_status gather(const plan *p, const brick *k, int threads, point_list *l, ylm_error *e) {
  ylm_grid_source source;
  baker b;
  *l = (point_list){0};
  ylm_status s = ylm__brick_gather(p, k, threads, &source, &b, e);
  if (s == YLM_OK) {
    gathering t = {.g = b.g};
    s = ylm__grid_no_room(list_voxels(&t, !k), p->source, e);
    *l = t.l;
  }
  ylm__baker_free(&b);
  ylm_grid_free(b.g);
  return s;
}

ylm_status ylm__brick_lights(const plan *p, const brick *k, int threads, ylm_error *e) {
  char path[FOLDER_PATH];
  point_list l;
  ylm__folder_brick(p->how.folder, k->code, "c", path);
  if (ylm__folder_has(path) && ylm__points_read(path, p->top.g, &l, NULL) == YLM_OK) {
    ylm__points_free(&l);
    return YLM_OK;
  }
  ylm_status s = gather(p, k, threads, &l, e);
  if (s == YLM_OK) s = ylm__points_write(path, &l, e);
  ylm__points_free(&l);
  return s;
}

/* -- all of them --------------------------------------------------------------------------------------- */

/* The points and voxels of a list join the grid. */
static ylm_status add_list(baker *b, const point_list *l) {
  ylm_grid *g = b->g;
  uint32_t *point = ylm_alloc(l->points, sizeof *point);
  ylm_status s = point ? ylm__grid_reserve_cells(g, l->voxels) : YLM_ENOMEM;
  for (size_t i = 0; i < l->points && s == YLM_OK; i++) {
    point_record r;
    memcpy(&r, l->point + i * l->bytes, sizeof r);
    size_t before = g->points;
    s = ylm__corners_point(b, r.at, 0, &point[i]);
    if (s == YLM_OK && g->points > before) ylm__point_take(g, point[i], l->point + i * l->bytes);
  }
  for (size_t i = 0; i < l->voxels && s == YLM_OK; i++) {
    const voxel_record *v = &l->voxel[i];
    ylm_grid_cell c = {.level = (uint8_t)v->level};
    memcpy(c.origin, v->origin, sizeof c.origin);
    for (int k = 0; k < 8; k++)
      c.corner[k] = v->corner[k] == YLM_GRID_NONE ? YLM_GRID_NONE : point[v->corner[k]];
    g->cell[g->cells++] = c;
  }
  g->evaluated = g->points;
  ylm_free(point);
  return s;
}

/* The order of the whole bake: level by level, along Morton codes. */
static int by_place(const void *a, const void *b) {
  const ylm_grid_cell *x = a, *y = b;
  uint64_t p = ylm_morton(x->origin[0], x->origin[1], x->origin[2]),
           q = ylm_morton(y->origin[0], y->origin[1], y->origin[2]);
  return x->level != y->level ? (x->level < y->level ? -1 : 1) : p < q ? -1 : p > q;
}

static ylm_status add_brick(const plan *p, const brick *k, baker *b, ylm_error *e) {
  char path[FOLDER_PATH];
  point_list l;
  ylm__folder_brick(p->how.folder, k->code, "c", path);
  ylm_status s = ylm__points_read(path, b->g, &l, e);
  if (s != YLM_OK) return s;
  s = ylm__grid_no_room(add_list(b, &l), p->source, e);
  ylm__points_free(&l);
  return s;
}

static ylm_status add_top(const plan *p, baker *b, ylm_error *e) {
  point_list l;
  ylm_status s = gather(p, NULL, 0, &l, e);
  if (s == YLM_OK) s = ylm__grid_no_room(add_list(b, &l), p->source, e);
  ylm__points_free(&l);
  return s;
}

/* The points in lights of the grid, to the file. */
static ylm_status write_filled(const ylm_grid *g, const char *path, ylm_error *e) {
  point_list l = {.bytes = point_bytes(g)};
  size_t n = 0;
  for (uint32_t i = 0; i < g->evaluated; i++) n += is_invalid(g, i);
  l.point = ylm_alloc(n, l.bytes);
  if (!l.point) return ylm_no_memory_for(e, path);
  for (uint32_t i = 0; i < g->evaluated; i++)
    if (is_invalid(g, i)) ylm__point_put(g, i, l.point + l.points++ * l.bytes);
  ylm_status s = ylm__points_write(path, &l, e);
  ylm__points_free(&l);
  return s;
}

ylm_status ylm__brick_fill(const plan *p, ylm_error *e) {
  char path[FOLDER_PATH];
  point_list done;
  ylm_grid_source source = *p->source;
  source.max_points = 0;
  source.team = NULL;
  ylm__folder_file(p->how.folder, "fill", path);
  if (ylm__folder_has(path) && ylm__points_read(path, p->top.g, &done, NULL) == YLM_OK) {
    ylm__points_free(&done);
    return YLM_OK;
  }
  baker b;
  ylm__baker_begin(&b, ylm__grid_new(&p->form), &source, e);
  ylm_status s = b.g ? YLM_OK : ylm__grid_no_room(YLM_ENOMEM, p->source, e);
  if (s == YLM_OK) s = add_top(p, &b, e);
  for (size_t i = 0; i < p->wanteds && s == YLM_OK; i++) s = add_brick(p, &p->wanted[i], &b, e);
  if (s == YLM_OK) {
    if (b.g->cells) qsort(b.g->cell, b.g->cells, sizeof *b.g->cell, by_place);
    s = ylm__grid_no_room(ylm__grid_fill_invalid(b.g), p->source, e);
  }
  if (s == YLM_OK) s = write_filled(b.g, path, e);
  ylm__baker_free(&b);
  ylm_grid_free(b.g);
  return s;
}
