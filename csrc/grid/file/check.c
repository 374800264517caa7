/*
** check.c - what sampling relies on, checked in a grid that was read, whatever wrote it;
** and what a grid has beyond its file.
*/
#include "file.h"

#include <string.h>

/* -- cells ------------------------------------------------------------------------------------- */

/* The flags of a cell and its place among the octree's cells, so that descents end. */
static bool links_hold(const ylm_grid *g, size_t i) {
  const ylm_grid_cell *c = &g->cell[i];
  size_t octree = g->contents.octree_cells;
  if (c->child && (c->child <= i || c->child > g->cells - 8 || g->cells < 8)) return false;
  if (i >= octree) return c->flags & YLM_GRID_ADDED && !(c->flags & YLM_GRID_LEAF);
  if (c->flags & YLM_GRID_ADDED) return false;
  if (c->flags & YLM_GRID_LEAF) return !c->child || c->child >= octree;
  return c->child && c->child + 8 <= octree;
}

/* Corners are points, and where they should be. */
static bool corners_hold(const ylm_grid *g, const ylm_grid_cell *c) {
  uint32_t edge = ylm__grid_edge(g, c), wrong = 0;
  for (uint32_t k = 0; k < 8; k++) {
    if (c->corner[k] == YLM_GRID_NONE) continue;
    if (c->corner[k] >= g->points) return false;
    const uint32_t *at = g->lattice + 3 * (size_t)c->corner[k];
    for (uint32_t a = 0; a < 3; a++) wrong |= at[a] ^ (c->origin[a] + (k >> a & 1) * edge);
  }
  return !wrong;
}

/* Every cell is the root or the child of one parent, in its place. */
static const char *check_octree(const ylm_grid *g, uint8_t *seen) {
  seen[0] = 1;
  const ylm_grid_cell *root = &g->cell[0];
  if (root->level != g->contents.root_level) return "the root";
  if (memcmp(root->origin, g->contents.root, sizeof root->origin) != 0) return "the root";
  bool sides = g->contents.form.sides;
  if (!sides && !ylm__grid_is_complete(root)) return "the root's corners";
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (!seen[i]) return "a cell without parent";
    if (!links_hold(g, i)) return "a cell's children";
    if (!corners_hold(g, c)) return "a cell's corners";
    if (sides && c->flags & YLM_GRID_LEAF && !(c->flags & YLM_GRID_SIDED) &&
        !ylm__grid_is_complete(c))
      return "a cell's corners";
    if (c->detail && (c->detail > g->contents.form.depth || c->detail < c->level))
      return "a cell's detail";
    if (!c->child) continue;
    if (c->detail || c->level >= g->contents.form.depth) return "a cell's level";
    uint32_t half = ylm__grid_edge(g, c) / 2;
    for (uint32_t k = 0; k < 8; k++) {
      const ylm_grid_cell *d = &g->cell[c->child + k];
      if (seen[c->child + k]++ || d->level != c->level + 1) return "a cell with two parents";
      for (int a = 0; a < 3; a++)
        if (d->origin[a] != c->origin[a] + (k >> a & 1 ? half : 0)) return "a cell's origin";
    }
  }
  return NULL;
}

static const char *check_lattice(const ylm_grid *g) {
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    for (int a = 0; a < 3; a++)
      if (c->origin[a] >= g->contents.resolution[a]) return "a voxel's origin";
    bool complete =
        ylm__grid_is_complete(c) || (g->contents.form.sides && c->flags & YLM_GRID_SIDED);
    if (c->level || c->child || c->detail || !complete || !corners_hold(g, c)) return "a voxel";
    if (c->flags & YLM_GRID_ADDED || !(c->flags & YLM_GRID_LEAF)) return "a voxel's flags";
  }
  return NULL;
}

ylm_status ylm__grid_file_check_cells(const ylm_grid *g, const char *name, ylm_error *e) {
  bool lattice = g->contents.form.kind == YLM_GRID_UNIFORM;
  uint8_t *seen = lattice ? NULL : ylm_alloc_zero(g->cells, 1);
  if (!lattice && !seen) return ylm_no_memory_for(e, name);
  const char *what = lattice ? check_lattice(g) : check_octree(g, seen);
  ylm_free(seen);
  return what ? ylm__grid_file_bad(name, what, e) : YLM_OK;
}

/* -- sides --------------------------------------------------------------------------------------- */

/* The corners of a part are evaluated points, and where they should be. */
static bool part_holds(const ylm_grid *g, const ylm_grid_cell *c, const uint32_t node[8]) {
  ylm_grid_cell part = *c;
  memcpy(part.corner, node, sizeof part.corner);
  for (int k = 0; k < 8; k++)
    if (node[k] >= g->evaluated) return false;
  return corners_hold(g, &part);
}

/* A side is that of a leaf, and of its own parts. */
static const char *check_side(const ylm_grid *g, const ylm_grid_side *s) {
  const ylm_grid_cell *c = &g->cell[s->cell];
  if (!(c->flags & YLM_GRID_LEAF) || !(c->flags & YLM_GRID_SIDED) || c->child || c->detail)
    return "the leaf of a side";
  for (size_t i = 0; i < YLM_GRID_PIECES; i++) {
    uint32_t part = ylm_grid_side_part(s, i);
    if (part != YLM_GRID_PARTS && part >= s->parts) return "the part of a piece";
  }
  for (uint32_t p = s->first; p < s->first + s->parts; p++)
    if (!part_holds(g, c, g->sides.node[p])) return "a part's corners";
  for (int k = 0; k < 8; k++)
    if (c->corner[k] != (s->parts ? g->sides.node[s->first][k] : YLM_GRID_NONE))
      return "a side's corners";
  return NULL;
}

const char *ylm__grid_file_check_sides(const ylm_grid *g) {
  const grid_sides *s = &g->sides;
  size_t parts = 0, sided = 0;
  for (size_t i = 0; i < g->cells; i++) sided += (g->cell[i].flags & YLM_GRID_SIDED) != 0;
  if (sided != s->n) return "the number of its sides";
  for (size_t i = 0; i < s->n; i++) {
    const ylm_grid_side *side = &s->side[i];
    if (side->cell >= g->contents.octree_cells || (i && side->cell <= s->side[i - 1].cell))
      return "the order of its sides";
    if (side->parts > YLM_GRID_PARTS || side->first != parts || side->parts > s->parts - parts)
      return "the number of a side's parts";
    const char *what = check_side(g, side);
    if (what) return what;
    parts += side->parts;
  }
  return parts == s->parts ? NULL : "the number of its parts";
}

bool ylm__grid_file_table_holds(const ylm_grid *g, uint64_t cells) {
  const uint32_t *r = g->contents.resolution;
  return g->contents.form.kind != YLM_GRID_UNIFORM ||
         (uint64_t)r[0] * r[1] * r[2] <= 4096 * cells + (1u << 20);
}

/* -- points ------------------------------------------------------------------------------------ */

const char *ylm__grid_file_check_points(const ylm_grid *g) {
  bool metric = g->contents.form.metric_channels != 0;
  /* No lambda of a grid that was read from few bytes is known. */
  bool known = g->evaluated && !isnan(g->lambda[0]);
  for (size_t i = 0; i < g->evaluated; i++) {
    if (metric && (isnan(g->norm[i]) || isnan(g->lambda[i]) == known)) return "a point's metric";
    if (g->flags[i] & YLM_GRID_POINT_INTERPOLATED) return "a point's flags";
    if (g->validity && !(g->validity[i] >= 0 && g->validity[i] <= 1)) return "a point's validity";
    for (size_t a = 0; a < 3; a++)
      if (g->lattice[3 * i + a] < g->contents.root[a] || g->lattice[3 * i + a] > g->last[a] + 1)
        return "a point's place";
  }
  return NULL;
}

/* The cell of a birth can be interpolated. */
static bool birth_holds(const ylm_grid *g, const ylm_grid_birth *b) {
  if (b->cell >= g->cells || b->place >= 27) return false;
  const ylm_grid_cell *c = &g->cell[b->cell];
  if (c->level >= g->contents.form.depth) return false;
  for (int k = 0; k < 8; k++)
    if (c->corner[k] >= g->points) return false;
  return true;
}

/* Corners that a cell is interpolated from were born of coarser cells, so they are there before. */
static bool ancestors_hold(const ylm_grid *g, const ylm_grid_cell *c) {
  for (int k = 0; k < 8; k++)
    if (c->corner[k] >= g->evaluated &&
        g->cell[g->birth[c->corner[k] - g->evaluated].cell].level >= c->level)
      return false;
  return true;
}

const char *ylm__grid_file_check_births(const ylm_grid *g) {
  size_t n = g->points - g->evaluated;
  for (size_t i = 0; i < n; i++)
    if (!birth_holds(g, &g->birth[i])) return "where a point is interpolated";
  for (size_t i = 0; i < n; i++)
    if (!ancestors_hold(g, &g->cell[g->birth[i].cell]))
      return "a point that is interpolated from itself";
  return NULL;
}

void ylm__grid_file_place_births(ylm_grid *g) {
  for (size_t p = g->evaluated; p < g->points; p++) {
    const ylm_grid_birth *b = &g->birth[p - g->evaluated];
    const ylm_grid_cell *c = &g->cell[b->cell];
    uint32_t half = ylm__grid_edge(g, c) / 2,
             place[3] = {b->place % 3, b->place / 3 % 3, b->place / 9};
    for (int a = 0; a < 3; a++) g->lattice[3 * p + (size_t)a] = c->origin[a] + place[a] * half;
    g->flags[p] = YLM_GRID_POINT_INTERPOLATED;
  }
}

/* -- what a file does not hold ---------------------------------------------------------------- */

/* The hash of the evaluated points, which voxels without data are sampled with. */
static ylm_status index_points(ylm_grid *g) {
  if (g->contents.form.kind == YLM_GRID_UNIFORM || !g->contents.form.continuous) return YLM_OK;
  return ylm__sides_hash(g);
}

void ylm__grid_file_forget_times(ylm_grid_stats *s) {
  s->seconds = s->field_seconds = s->occupancy_seconds = s->lattice_seconds = NAN;
  s->residual_seconds = s->continuity_seconds = s->verify_seconds = NAN;
}

ylm_status ylm__grid_file_finish(ylm_grid *g) {
  ylm_status status = index_points(g);
  return status == YLM_OK ? ylm__grid_finish(g) : status;
}
