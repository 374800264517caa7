/* corners.c - points at lattice coordinates, and which of them are the corners of cells. */
#include "baker.h"
#include "ylm_list.h"

#include <string.h>

/* -- points --------------------------------------------------------------------------------- */

/* Room for marks of as many points as the grid has room for. */
static ylm_status reserve_used(baker *b) {
  size_t room = b->g->point_room;
  if (!b->used || b->used_room >= room) return YLM_OK;
  if (!ylm_list_resize(&b->used, b->used_room, room, 1)) return YLM_ENOMEM;
  memset(b->used + b->used_room, 0, room - b->used_room);
  b->used_room = room;
  return YLM_OK;
}

ylm_status ylm__corners_room(baker *b) {
  if (b->source->max_points && b->g->points >= b->source->max_points) return YLM_ELIMIT;
  ylm_status s = ylm__grid_reserve_points(b->g, 1);
  return s == YLM_OK ? reserve_used(b) : s;
}

ylm_status ylm__corners_point(baker *b, const uint32_t at[3], uint8_t flags, uint32_t *index) {
  ylm_grid *g = b->g;
  ylm_status s = ylm__lattice_hash_reserve(&b->g->hash, b->g->hash.used + 1);
  if (s == YLM_OK) s = ylm__grid_reserve_points(g, 1);
  if (s == YLM_OK) s = reserve_used(b);
  if (s != YLM_OK) return s;
  uint32_t *entry = ylm__lattice_hash_at(&b->g->hash, lattice_key(at));
  if (*entry == YLM_GRID_NONE) {
    if (b->source->max_points && g->points >= b->source->max_points) return YLM_ELIMIT;
    *entry = (uint32_t)g->points++;
    memcpy(g->lattice + 3 * (size_t)*entry, at, 3 * sizeof *at);
    g->flags[*entry] = flags;
  }
  if (!flags) g->flags[*entry] &= (uint8_t)~YLM_GRID_POINT_TESTED;
  if (b->used) b->used[*entry] = 1;
  *index = *entry;
  return YLM_OK;
}

/* -- cells ---------------------------------------------------------------------------------- */

/*
** The eight children of a voxel share 27 corner positions, a half-edge lattice of 3 x 3 x 3. A
** corner that one child has found is not looked up by its siblings; the outer eight are the
** parent's. A voxel of a uniform grid counts as child 0 and takes four corners from its left
** neighbour.
*/
typedef struct family {
  uint32_t number, point[27], asked; /* asked: bits of places that were looked for */
} family;
#define NOBODY ((family){.number = YLM_GRID_NONE})

/* Where corner i of child k stands among the 27. */
static uint32_t family_place(uint32_t k, uint32_t i) {
  return (k & 1) + (i & 1) + 3 * ((k >> 1 & 1) + (i >> 1 & 1)) + 9 * ((k >> 2) + (i >> 2));
}

/* The voxel of a uniform grid after that of which `f` has the corners: those they share. */
static void meet_neighbour(const ylm_grid *g, uint32_t cell, family *f) {
  const uint32_t *now = g->cell[cell].origin, *was = cell ? g->cell[cell - 1].origin : now;
  bool beside = f->number != YLM_GRID_NONE && f->number + 1 == cell && now[0] == was[0] + 1 &&
                now[1] == was[1] && now[2] == was[2];
  for (uint32_t i = 0; i < 8; i += 2) {
    f->point[family_place(0, i)] = beside ? f->point[family_place(0, i + 1)] : YLM_GRID_NONE;
    f->point[family_place(0, i + 1)] = YLM_GRID_NONE;
  }
  f->number = cell;
  f->asked = 0;
}

static void meet_brothers(const baker *b, uint32_t cell, family *f) {
  const ylm_grid *g = b->g;
  const ylm_grid_cell *parent = &g->cell[b->parent.cell[(cell - 1) / 8]];
  uint32_t half = ylm__grid_edge(g, parent) / 2;
  for (uint32_t n = 0; n < 27; n++) {
    uint32_t place[3] = {n % 3, n / 3 % 3, n / 9}, at[3];
    bool corner = place[0] != 1 && place[1] != 1 && place[2] != 1;
    for (int a = 0; a < 3; a++) at[a] = parent->origin[a] + place[a] * half;
    f->point[n] = corner ? parent->corner[place[0] / 2 + place[1] + place[2] * 2] : YLM_GRID_NONE;
    if (!corner) ylm__lattice_hash_prefetch(&g->hash, lattice_key(at));
  }
  f->asked = 0;
}

/* Begins with the family of a cell, if it is another than before; returns which child the cell
   is. */
static uint32_t meet_family(const baker *b, uint32_t cell, family *f) {
  if (b->g->contents.form.kind == YLM_GRID_UNIFORM) {
    meet_neighbour(b->g, cell, f);
    return 0;
  }
  if (cell == 0) {
    *f = NOBODY;
    memset(f->point, 0xff, sizeof f->point);
    return 0;
  }
  if (f->number != (cell - 1) / 8) meet_brothers(b, cell, f);
  f->number = (cell - 1) / 8;
  return (cell - 1) & 7;
}

/* Gives a cell the corners it lacks that are known to the family or to the hash. */
static void look_for_corners(const baker *b, uint32_t cell, family *f) {
  const ylm_grid *g = b->g;
  uint32_t child = meet_family(b, cell, f);
  ylm_grid_cell *c = &b->g->cell[cell];
  for (uint32_t i = 0; i < 8; i++) {
    uint32_t n = family_place(child, i), at[3];
    if (c->corner[i] == YLM_GRID_NONE && f->point[n] == YLM_GRID_NONE && !(f->asked >> n & 1)) {
      ylm__grid_corner_at(g, c, (int)i, at);
      f->point[n] = ylm__lattice_hash_find(&g->hash, lattice_key(at));
      f->asked |= 1u << n;
    }
    if (c->corner[i] == YLM_GRID_NONE) c->corner[i] = f->point[n];
  }
}

/* For cells of the wave; those that were there before an update have the corners they had. */
static ylm_status look_in_wave(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const baker *b = context;
  family f = NOBODY;
  for (size_t j = begin; j < end; j++) {
    ylm_grid_cell *c = &b->g->cell[b->wave.cell[j]];
    const ylm_grid_cell *old = cells_before(b, c);
    if (old && old->flags & YLM_GRID_OCCUPIED)
      memcpy(c->corner, old->corner, sizeof c->corner);
    else
      look_for_corners(b, b->wave.cell[j], &f);
  }
  return YLM_OK;
}

/* Finds the corners of the wave's cells; new points wait, in the order of cells. */
ylm_status ylm__corners_find(baker *b) {
  ylm_grid *g = b->g;
  ylm_parallel(b->wave.n, BAKE_LOOK_GRAIN, b->source->threads, look_in_wave, b, NULL, NULL);
  for (size_t j = 0; j < b->wave.n; j++) {
    ylm_grid_cell *c = &g->cell[b->wave.cell[j]];
    for (int i = 0; i < 8; i++) {
      uint32_t at[3];
      if (c->corner[i] == YLM_GRID_NONE) {
        ylm__grid_corner_at(g, c, i, at);
        ylm_status s = ylm__corners_point(b, at, 0, &c->corner[i]);
        if (s != YLM_OK) return s;
      }
      g->flags[c->corner[i]] &= (uint8_t)~YLM_GRID_POINT_TESTED;
      if (b->used) b->used[c->corner[i]] = 1;
    }
  }
  return YLM_OK;
}

typedef struct shared_job {
  const baker *b;
  const uint8_t *only; /* [cells]; NULL: all */
} shared_job;

static ylm_status find_shared_corners(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const shared_job *j = context;
  family f = NOBODY;
  for (size_t i = begin; i < end; i++)
    if (!j->only || j->only[i]) look_for_corners(j->b, (uint32_t)i, &f);
  return YLM_OK;
}

/* Corners of unoccupied cells that were evaluated for their neighbours. */
void ylm__corners_find_shared(baker *b, const uint8_t *only) {
  shared_job j = {b, only};
  ylm_parallel(b->g->contents.octree_cells, BAKE_CELLS_GRAIN, b->source->threads,
               find_shared_corners, &j, NULL, NULL);
}

/* The parents of cells that the caller has made. */
ylm_status ylm__corners_find_parents(baker *b) {
  const ylm_grid *g = b->g;
  ylm_status s = YLM_OK;
  if (g->contents.form.kind == YLM_GRID_UNIFORM || b->parent.n == (g->cells - 1) / 8) return YLM_OK;
  b->parent.n = 0;
  for (size_t i = 0; i < (g->cells - 1) / 8 && s == YLM_OK; i++)
    s = ylm__cell_list_push(&b->parent, 0);
  for (size_t i = 0; i < g->cells && s == YLM_OK; i++)
    if (g->cell[i].child) b->parent.cell[(g->cell[i].child - 1) / 8] = (uint32_t)i;
  return s;
}
