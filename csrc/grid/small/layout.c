/*
** layout.c - a grid's cells, sides and points as bits.
**
** Cells are visited in the order of their levels. A cell whose eight corners are evaluated points brings those that are new;
** so does each part of a leaf that surfaces cross. Corners that cells share, cells that continuity adds and interpolated
** points follow from these, as they do in a bake, and need no bits.
*/
#include "small.h"

#include <math.h>
#include <string.h>

#include "../sides/sides.h"
#include "ylm_list.h"

#define ASKED_WIDE 4.0 /* edges of a leaf that these cover */
#define NEAR (1 << SMALL_NEAR_BITS)
#define NEAR_ENOUGH                                                                                \
  0.01 /* edges of the leaf, from such a way: a small part of what lies between the place and the wall */
#define NUMBERS 64                             /* estimates of a number */
#define ORDERS_SHARED (YLM_GRID_MAX_DEPTH + 1) /* levels of shared points */
#define ORDERS (4 * (ORDERS_SHARED + 256))

struct layout_chances {
  bit_chance split[YLM_GRID_MAX_DEPTH + 1][4], occupied[8], data[8], crossed[8], sided[4], brick[2],
      centre[YLM_GRID_MAX_DEPTH + 1];
  bit_chance gap[NUMBERS], loose[3][NUMBERS], parts[16], piece[3][17], label[16], ghost[3],
      fresh[2], near[1 << SMALL_NEAR_BITS], back[NUMBERS];
};

static bool decoding(const small_layout *k) { return k->c->decoding; }

static ylm_status damaged(small_layout *k, const char *what) {
  k->bad = what;
  return YLM_EFORMAT;
}

/* -- points ------------------------------------------------------------------------------------- */

static bool room_of_points(small_layout *k, size_t n) {
  return ylm_list_reserve(&k->source, k->met, n, &k->source_room, sizeof *k->source) &&
         ylm_list_reserve(&k->level, k->met, n, &k->level_room, 1) &&
         ylm_list_reserve(&k->old, k->met, n, &k->old_room, sizeof *k->old) &&
         ylm_list_reserve(&k->before, k->met, n, &k->before_room, sizeof *k->before);
}

/* A new point; `old` is that of `from`. */
static ylm_status meet(small_layout *k, const uint32_t at[3], int level, uint8_t flags,
                       uint32_t old, uint32_t *point) {
  ylm_grid *g = k->g;
  if (decoding(k) && k->met >= k->most_points) return damaged(k, "its number of points");
  ylm_status s = ylm__grid_reserve_points(g, 1);
  if (s == YLM_OK && !room_of_points(k, k->met + 1)) s = YLM_ENOMEM;
  if (s != YLM_OK) return s;
  size_t p = g->points++;
  memcpy(g->lattice + 3 * p, at, 3 * sizeof *at);
  g->flags[p] = flags;
  g->lambda[p] = g->norm[p] = NAN;
  k->level[p] = (uint8_t)level;
  k->old[p] = old;
  k->before[p] = YLM_GRID_NONE;
  k->source[p] = (small_source){.kin = YLM_GRID_NONE};
  for (int i = 0; i < SMALL_PARENTS; i++) k->source[p].parent[i] = YLM_GRID_NONE;
  k->met = g->points;
  *point = (uint32_t)p;
  return YLM_OK;
}

/* The point of `from` at a place that is no ghost. */
static uint32_t old_at(const small_layout *k, const uint32_t at[3]) {
  return k->from ? ylm__lattice_hash_find(&k->known, lattice_key(at)) : YLM_GRID_NONE;
}

/* The point at a place that is no ghost, a new one where there is none. */
static ylm_status point_at(small_layout *k, const uint32_t at[3], int level, uint32_t *point) {
  ylm_status s = ylm__lattice_hash_reserve(&k->g->hash, k->g->hash.used + 1);
  if (s != YLM_OK) return s;
  uint32_t *entry = ylm__lattice_hash_at(&k->g->hash, lattice_key(at));
  if (*entry == YLM_GRID_NONE) {
    s = meet(k, at, level, 0, old_at(k, at), point);
    if (s == YLM_OK) *entry = *point;
    return s;
  }
  *point = *entry;
  return YLM_OK;
}

/* Cell `parent`, one level above, has the point at a half of its edges. */
static void add_parent(small_layout *k, uint32_t point, uint32_t parent) {
  uint32_t *list = k->source[point].parent;
  for (int i = 0; i < SMALL_PARENTS; i++) {
    if (list[i] == parent) return;
    if (list[i] != YLM_GRID_NONE) continue;
    list[i] = parent;
    return;
  }
}

static void set_kin(small_layout *k, uint32_t point, uint32_t row, int corner, bool of_part) {
  small_source *s = &k->source[point];
  if (s->kin != YLM_GRID_NONE) return;
  s->kin = row;
  s->corner = (uint8_t)corner;
  s->of_part = of_part;
}

/* -- cells ---------------------------------------------------------------------------------------- */

/* Has a cell of `from` all its corners among evaluated points that are no ghosts? */
static bool has_data(const small_layout *k, const ylm_grid_cell *c) {
  uint32_t at[3];
  if (c->flags & YLM_GRID_SIDED) return false;
  for (int i = 0; i < 8; i++) {
    ylm__grid_corner_at(k->from, c, i, at);
    if (old_at(k, at) == YLM_GRID_NONE) return false;
  }
  return true;
}

/* The middle of a leaf, in lattice coordinates. */
static void centre_of(const ylm_grid *g, const ylm_grid_cell *c, uint32_t at[3]) {
  for (int a = 0; a < 3; a++) at[a] = c->origin[a] + ylm__grid_edge(g, c) / 2;
}

static int flag(bit_coder *c, bit_chance *p, uint8_t flags, uint8_t which) {
  return ylm__coder_bit(c, p, (flags & which) != 0) ? which : 0;
}

/* A cell's bits: whether it is split, through *split, whether its corners are points, through *data, and its middle. */
static void code_cell(small_layout *k, uint32_t cell, uint32_t parent, bool *split, bool *data,
                      bool *centre) {
  struct layout_chances *p = k->chance;
  ylm_grid_cell *c = &k->g->cell[cell];
  const ylm_grid_cell *was = k->from ? &k->from->cell[k->was[cell]] : c;
  uint8_t above = parent == YLM_GRID_NONE ? 0 : k->g->cell[parent].flags,
          beside = cell ? k->g->cell[cell - 1].flags : 0, flags = 0;
  bool octree = k->g->contents.form.kind == YLM_GRID_ADAPTIVE;
  bool deeper = octree && c->level < k->g->contents.form.depth;
  bool was_split = k->from && !(was->flags & YLM_GRID_LEAF);
  int last = cell && !(beside & YLM_GRID_LEAF);
  *split = deeper &&
           ylm__coder_bit(k->c, &p->split[c->level][2 * last + ((beside & YLM_GRID_OCCUPIED) != 0)],
                          was_split);
  if (!*split) flags |= YLM_GRID_LEAF;
  int about = 4 * *split + 2 * ((beside & YLM_GRID_OCCUPIED) != 0);
  flags |= (uint8_t)flag(k->c, &p->occupied[about + ((above & YLM_GRID_OCCUPIED) != 0)], was->flags,
                         YLM_GRID_OCCUPIED);
  int crossed = 2 * ((beside & YLM_GRID_CROSSED) != 0) + ((above & YLM_GRID_CROSSED) != 0);
  flags |= (uint8_t)flag(k->c, &p->crossed[4 * *split + crossed], was->flags, YLM_GRID_CROSSED);
  if (!*split && k->g->contents.form.sides)
    flags |= (uint8_t)flag(
        k->c, &p->sided[2 * ((flags & YLM_GRID_OCCUPIED) != 0) + ((beside & YLM_GRID_SIDED) != 0)],
        was->flags, YLM_GRID_SIDED);
  if (!*split && octree) flags |= (uint8_t)flag(k->c, p->brick, was->flags, YLM_GRID_BRICK);
  c->flags = flags;
  *data = false;
  if (!(flags & YLM_GRID_SIDED))
    *data = ylm__coder_bit(k->c,
                           &p->data[4 * *split + 2 * ((flags & YLM_GRID_OCCUPIED) != 0) +
                                    ((beside & YLM_GRID_OCCUPIED) != 0)],
                           k->from && has_data(k, was));
  *centre = false;
  if (*data && !*split && deeper && k->g->rows > 1) {
    uint32_t at[3];
    centre_of(k->g, c, at);
    *centre = ylm__coder_bit(k->c, &p->centre[c->level], old_at(k, at) != YLM_GRID_NONE);
  }
}

/* The corners of a cell whose corners are points. */
static ylm_status bring_corners(small_layout *k, uint32_t cell, uint32_t parent) {
  bool above = parent != YLM_GRID_NONE && ylm__grid_is_complete(&k->g->cell[parent]);
  for (int i = 0; i < 8; i++) {
    uint32_t at[3], point;
    ylm__grid_corner_at(k->g, &k->g->cell[cell], i, at);
    ylm_status s = point_at(k, at, k->g->cell[cell].level, &point);
    if (s != YLM_OK) return s;
    k->g->cell[cell].corner[i] = point;
    if (k->level[point] != k->g->cell[cell].level) continue;
    if (above) add_parent(k, point, parent);
    set_kin(k, point, cell, i, false);
  }
  return YLM_OK;
}

/* -- sides ------------------------------------------------------------------------------------------ */

/* The parts of a leaf's pieces: those of the pieces before along the axes, or another. */
static void code_pieces(small_layout *k, ylm_grid_side *s, const ylm_grid_side *was) {
  static const size_t step[3] = {1, YLM_GRID_PIECES_ALL, YLM_GRID_PIECES_ALL * YLM_GRID_PIECES_ALL};
  struct layout_chances *p = k->chance;
  for (size_t i = 0; i < YLM_GRID_PIECES; i++) {
    uint8_t beside[3], want = was ? ylm_grid_side_part(was, i) : 0, got = 0;
    int n = 0;
    for (int a = 0; a < 3; a++) {
      if (i / step[a] % YLM_GRID_PIECES_ALL == 0) continue;
      uint8_t part = ylm_grid_side_part(s, i - step[a]);
      bool new = true;
      for (int m = 0; m < n; m++) new &= beside[m] != part;
      if (new) beside[n++] = part;
    }
    int found = 0;
    for (int m = 0; m < n && !found; m++) {
      found = ylm__coder_bit(k->c, &p->piece[m][4 * n + (int)(i % 2)], beside[m] == want);
      if (found) got = beside[m];
    }
    if (!found) got = (uint8_t)ylm__coder_symbol(k->c, p->label, 4, want);
    side_set_part(s, i, got);
  }
}

/* An edge of a leaf and its lowest corner along an axis, relative to the grid's origin. */
static void extent_of(const ylm_grid *g, const ylm_grid_cell *c, int a, double *edge,
                      double *corner) {
  *edge = ylm__grid_edge(g, c) / g->scale[a];
  *corner = g->contents.form.bounds[a] + c->origin[a] / g->scale[a] - g->origin[a];
}

/* The middle of a piece, in edges of its leaf. */
static void middle_of(size_t piece, double t[3]) {
  for (int a = 0; a < 3; a++) t[a] = piece_middle(piece, a);
}

/* Pieces of a part by their distance from a corner of its leaf, the nearest NEAR first; how many. */
static int near_pieces(const ylm_grid_side *s, uint32_t part, int corner, size_t piece[NEAR]) {
  double way[NEAR];
  int n = 0;
  for (size_t i = 0; i < YLM_GRID_PIECES; i++) {
    double t[3], d = 0;
    if (ylm_grid_side_part(s, i) != part) continue;
    middle_of(i, t);
    for (int a = 0; a < 3; a++) d += (t[a] - (corner >> a & 1)) * (t[a] - (corner >> a & 1));
    int at = n < NEAR ? n++ : NEAR;
    for (; at > 0 && d < way[at - 1]; at--)
      if (at < NEAR) way[at] = way[at - 1], piece[at] = piece[at - 1];
    if (at < NEAR) way[at] = d, piece[at] = i;
  }
  return n;
}

/* The part of the way from a piece's middle to a corner that is nearest to a place, and the distance there. */
static double way_to(const double from[3], int corner, const double place[3], double *distance) {
  double dot = 0, all = 0, off = 0;
  for (int a = 0; a < 3; a++) {
    double d = (corner >> a & 1) - from[a];
    dot += d * (place[a] - from[a]);
    all += d * d;
  }
  double t = fmin(fmax(all > 0 ? dot / all : 0, 0), 1);
  for (int a = 0; a < 3; a++) {
    double d = from[a] + t * ((corner >> a & 1) - from[a]) - place[a];
    off += d * d;
  }
  *distance = sqrt(off);
  return t;
}

/* The place where the field was asked for a ghost: on the way from one of the part's pieces to the corner; else anywhere. */
static void code_asked(small_layout *k, uint32_t point, const ylm_grid_side *side, uint32_t part,
                       int corner) {
  const ylm_grid_cell *c = &k->g->cell[side->cell];
  struct layout_chances *p = k->chance;
  size_t piece[NEAR];
  double place[3] = {0}, middle[3], way = 0, off, best = NEAR_ENOUGH;
  int n = near_pieces(side, part, corner, piece), which = 0;
  double edge[3], low[3];
  for (int a = 0; a < 3; a++) extent_of(k->g, c, a, &edge[a], &low[a]);
  for (int a = 0; k->from && a < 3; a++)
    place[a] = ((double)k->from->sides.asked[k->old[point]][a] - low[a]) / edge[a];
  for (int i = 0; k->from && i < n; i++) {
    middle_of(piece[i], middle);
    double t = way_to(middle, corner, place, &off);
    if (off < best) best = off, way = t, which = i;
  }
  if (n && ylm__coder_bit(k->c, &p->fresh[1], best < NEAR_ENOUGH)) {
    which = (int)ylm__coder_symbol(k->c, p->near, SMALL_NEAR_BITS, (uint32_t)which);
    uint32_t bits =
        ylm__coder_raw(k->c, SMALL_WAY_BITS, (uint32_t)(way * ((1 << SMALL_WAY_BITS) - 1) + 1e-6));
    if (which >= n) which = 0; /* of a damaged stream */
    middle_of(piece[which], middle);
    way = (double)bits / ((1 << SMALL_WAY_BITS) - 1);
    for (int a = 0; a < 3; a++) place[a] = middle[a] + way * ((corner >> a & 1) - middle[a]);
  } else
    for (int a = 0; a < 3; a++) {
      double unit = ASKED_WIDE / (1 << SMALL_ASKED_BITS), last = (1 << SMALL_ASKED_BITS) - 1,
             m = floor((place[a] + ASKED_WIDE / 2) / unit + 0.5);
      uint32_t bits =
          ylm__coder_raw(k->c, SMALL_ASKED_BITS, (uint32_t)(m > 0 ? m < last ? m : last : 0));
      place[a] = bits * unit - ASKED_WIDE / 2;
    }
  for (int a = 0; a < 3; a++) k->g->sides.asked[point][a] = (float)(low[a] + edge[a] * place[a]);
}

/* The ghost at a corner of a part. */
static ylm_status bring_ghost(small_layout *k, uint32_t part, int corner, const uint32_t at[3],
                              uint32_t old, uint32_t *point) {
  struct layout_chances *p = k->chance;
  ylm_status s = ylm__lattice_hash_reserve(&k->ghost, k->ghost.used + 1);
  if (s != YLM_OK) return s;
  uint32_t *last = ylm__lattice_hash_at(&k->ghost, lattice_key(at)), back = 0, found = *last;
  while (k->from && found != YLM_GRID_NONE && k->old[found] != old) {
    found = k->before[found];
    back++;
  }
  bool fresh = *last == YLM_GRID_NONE || ylm__coder_bit(k->c, &p->fresh[0], found == YLM_GRID_NONE);
  if (!fresh) {
    back = ylm__coder_number(k->c, p->back, back);
    for (found = *last; back && found != YLM_GRID_NONE; back--) found = k->before[found];
    if (found == YLM_GRID_NONE) return damaged(k, "its ghosts");
    *point = found;
    return YLM_OK;
  }
  const ylm_grid_side *side = &k->g->sides.side[k->g->sides.n - 1];
  s = meet(k, at, k->g->cell[side->cell].level, YLM_GRID_POINT_GHOST, old, point);
  if (s != YLM_OK) return s;
  k->before[*point] = *last;
  *last = *point;
  code_asked(k, *point, side, part - side->first, corner);
  return YLM_OK;
}

/* The corners of a part. */
static ylm_status bring_part(small_layout *k, uint32_t cell, uint32_t part, const uint32_t *was) {
  const ylm_grid_cell leaf = k->g->cell[cell];
  for (int i = 0; i < 8; i++) {
    uint32_t at[3], point;
    bool ghost = was && k->from->flags[was[i]] & YLM_GRID_POINT_GHOST;
    ylm__grid_corner_at(k->g, &leaf, i, at);
    int sure =
        i ? 1 + ((k->g->flags[k->g->sides.node[part][i - 1]] & YLM_GRID_POINT_GHOST) != 0) : 0;
    ghost = ylm__coder_bit(k->c, &k->chance->ghost[sure], ghost);
    ylm_status s = ghost ? bring_ghost(k, part, i, at, was ? was[i] : 0, &point)
                         : point_at(k, at, leaf.level, &point);
    if (s != YLM_OK) return s;
    k->g->sides.node[part][i] = point;
    set_kin(k, point, part, i, true);
  }
  return YLM_OK;
}

/* A leaf that surfaces cross. */
static ylm_status bring_side(small_layout *k, uint32_t cell) {
  grid_sides *s = &k->g->sides;
  const grid_sides *old = k->from ? &k->from->sides : NULL;
  const ylm_grid_side *was = old ? &old->side[old->of[k->was[cell]]] : NULL;
  ylm_grid_side side = {.cell = cell, .first = (uint32_t)s->parts};
  side.parts = ylm__coder_symbol(k->c, k->chance->parts, 4, was ? was->parts : 0);
  code_pieces(k, &side, was);
  if (!ylm_list_reserve(&s->side, s->n, s->n + 1, &s->room, sizeof *s->side) ||
      !ylm_list_reserve(&s->node, s->parts, s->parts + side.parts, &s->part_room, sizeof *s->node))
    return YLM_ENOMEM;
  s->side[s->n++] = side;
  for (uint32_t p = 0; p < side.parts; p++) {
    s->parts++;
    ylm_status status = bring_part(k, cell, side.first + p, was ? old->node[was->first + p] : NULL);
    if (status != YLM_OK) return status;
  }
  if (side.parts) memcpy(k->g->cell[cell].corner, s->node[side.first], sizeof k->g->cell->corner);
  return YLM_OK;
}

/* -- the walk --------------------------------------------------------------------------------------- */

static bool room_of_cells(small_layout *k) {
  return !k->from ||
         ylm_list_reserve(&k->was, k->was_room, k->g->cells, &k->was_room, sizeof *k->was);
}

/* The eight children of a cell. */
static ylm_status split(small_layout *k, uint32_t cell) {
  uint32_t first;
  if (decoding(k) && k->g->cells + 8 > k->most_cells) return damaged(k, "its number of cells");
  ylm_status s = ylm__grid_split(k->g, cell, &first);
  if (s == YLM_OK && !room_of_cells(k)) s = YLM_ENOMEM;
  if (s != YLM_OK) return s;
  for (uint32_t i = 0; i < 8; i++) {
    k->g->cell[first + i].source = cell; /* the parent, as long as the grid is made */
    if (k->from) k->was[first + i] = k->from->cell[k->was[cell]].child + i;
  }
  return YLM_OK;
}

static ylm_status visit(small_layout *k, uint32_t cell) {
  bool is_split, data, centre;
  bool top = cell == 0 || k->g->contents.form.kind == YLM_GRID_UNIFORM;
  uint32_t parent = top ? YLM_GRID_NONE : k->g->cell[cell].source;
  code_cell(k, cell, parent, &is_split, &data, &centre);
  ylm_status s = data ? bring_corners(k, cell, parent) : YLM_OK;
  if (s == YLM_OK && k->g->cell[cell].flags & YLM_GRID_SIDED) s = bring_side(k, cell);
  if (s == YLM_OK && centre) {
    uint32_t at[3], point;
    centre_of(k->g, &k->g->cell[cell], at);
    s = point_at(k, at, k->g->cell[cell].level + 1, &point);
    if (s == YLM_OK) add_parent(k, point, cell);
  }
  if (s == YLM_OK && is_split) s = split(k, cell);
  if (s == YLM_OK && decoding(k) && k->c->short_by) s = damaged(k, "its octree ends early");
  return s;
}

/* The voxels of a lattice: how many are left out before each. */
static ylm_status lay_out_voxels(small_layout *k) {
  ylm_grid *g = k->g;
  const uint32_t *r = g->contents.resolution;
  uint64_t next = 0, all = (uint64_t)r[0] * r[1] * r[2];
  for (size_t i = 0; i < k->most_cells; i++) {
    uint32_t gap = 0;
    if (k->from) {
      const uint32_t *o = k->from->cell[i].origin;
      gap = (uint32_t)(((uint64_t)o[2] * r[1] + o[1]) * r[0] + o[0] - next);
    }
    next += ylm__coder_number(k->c, k->chance->gap, gap);
    if (next >= all || k->c->short_by) return damaged(k, "its voxels");
    ylm_grid_cell c = {.error = NAN, .residual = NAN};
    c.origin[0] = (uint32_t)(next % r[0]);
    c.origin[1] = (uint32_t)(next / r[0] % r[1]);
    c.origin[2] = (uint32_t)(next / r[0] / r[1]);
    for (int corner = 0; corner < 8; corner++) c.corner[corner] = YLM_GRID_NONE;
    ylm_status s = ylm__grid_reserve_cells(g, 1);
    if (s != YLM_OK) return s;
    g->cell[g->cells++] = c;
    if (!room_of_cells(k)) return YLM_ENOMEM;
    if (k->from) k->was[i] = (uint32_t)i;
    s = visit(k, (uint32_t)i);
    if (s != YLM_OK) return s;
    next++;
  }
  return YLM_OK;
}

static ylm_status lay_out_octree(small_layout *k) {
  ylm_grid *g = k->g;
  ylm_grid_cell root = {.level = (uint8_t)g->contents.root_level, .error = NAN, .residual = NAN};
  memcpy(root.origin, g->contents.root, sizeof root.origin);
  for (int i = 0; i < 8; i++) root.corner[i] = YLM_GRID_NONE;
  ylm_status s = ylm__grid_reserve_cells(g, 1);
  if (s != YLM_OK) return s;
  g->cell[g->cells++] = root;
  if (!room_of_cells(k)) return YLM_ENOMEM;
  if (k->from) k->was[0] = 0;
  for (size_t i = 0; i < g->cells && s == YLM_OK; i++) s = visit(k, (uint32_t)i);
  return s;
}

ylm_status ylm__small_lay_out(small_layout *k) {
  k->chance = ylm_alloc(1, sizeof *k->chance);
  if (!k->chance) return YLM_ENOMEM;
  ylm__coder_even((bit_chance *)k->chance, sizeof *k->chance / sizeof(bit_chance));
  ylm_status s = k->from ? ylm__sides_hash_to(k->from, &k->known) : YLM_OK;
  if (s != YLM_OK) return s;
  if (k->g->contents.form.kind == YLM_GRID_UNIFORM) return lay_out_voxels(k);
  return lay_out_octree(k);
}

/* -- points of no cell -------------------------------------------------------------------------------- */

/* Evaluated points in faces and edges of a brick, and of a top, are its neighbours' too; others that no cell has say nothing. */
static bool is_border(const small_layout *k, const uint32_t at[3]) {
  return small_on_border(k->g, at) || small_is_shared(k->g, k->finest, at);
}

ylm_status ylm__small_loose(small_layout *k) {
  ylm_grid *g = k->g;
  size_t n = 0;
  if (g->contents.form.kind == YLM_GRID_UNIFORM) return YLM_OK;
  if (decoding(k)) n = k->loose;
  for (size_t i = 0; decoding(k) ? i < n : i < k->from->evaluated; i++) {
    uint32_t at[3] = {0}, point;
    if (!decoding(k)) {
      memcpy(at, k->from->lattice + 3 * i, sizeof at);
      if (k->from->flags[i] & YLM_GRID_POINT_GHOST || !is_border(k, at) ||
          ylm__lattice_hash_find(&g->hash, lattice_key(at)) != YLM_GRID_NONE)
        continue;
      k->loose++;
    }
    for (int a = 0; a < 3; a++) {
      at[a] = g->contents.root[a] +
              ylm__coder_number(k->c, k->chance->loose[a], at[a] - g->contents.root[a]);
      if (at[a] > g->last[a] + 1) return damaged(k, "its loose points");
    }
    if (k->c->short_by) return damaged(k, "its loose points");
    ylm_status s = point_at(k, at, SMALL_LOOSE, &point);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}

/* -- finishing ------------------------------------------------------------------------------------------ */

/* Of how many axes a point is in the middle of its parent's edges; 0: it has no parent. */
static int middles_of(const small_layout *k, size_t point) {
  uint32_t parent = k->source[point].parent[0];
  if (parent == YLM_GRID_NONE) return 0;
  const ylm_grid_cell *c = &k->g->cell[parent];
  uint32_t half = ylm__grid_edge(k->g, c) / 2;
  int n = 0;
  for (size_t a = 0; a < 3; a++) n += k->g->lattice[3 * point + a] - c->origin[a] == half;
  return n;
}

/* Of how many axes a place is in the middle of the edges of the lattice's cells one level above its own. */
static int lattice_middles(const uint32_t at[3]) {
  uint32_t all = at[0] | at[1] | at[2], half = all & -all;
  return ((at[0] & half) != 0) + ((at[1] & half) != 0) + ((at[2] & half) != 0);
}

/* Shared points are coded first. Points are coded by levels; of a level in the middle of edges first, then of faces, then of
   cells: each is predicted from those before. */
static size_t order_of(const small_layout *k, size_t point) {
  const uint32_t *at = k->g->lattice + 3 * point;
  if (small_is_shared(k->g, k->finest, at))
    return 4 * (size_t)small_lattice_level(k->g, at) + (size_t)lattice_middles(at);
  return 4 * (ORDERS_SHARED + (size_t)k->level[point]) + (size_t)middles_of(k, point);
}

static ylm_status sort_points(small_layout *k) {
  size_t n = k->met, *first = ylm_alloc_zero(ORDERS + 1, sizeof *first);
  uint32_t *order = ylm_alloc(n, sizeof *order), *old = ylm_alloc_copy(k->old, n, sizeof *old);
  uint8_t *level = ylm_alloc_copy(k->level, n, 1);
  small_source *source = ylm_alloc_copy(k->source, n, sizeof *source);
  bool ok = first && order && old && level && source;
  for (size_t i = 0; ok && i < n; i++) first[order_of(k, i) + 1]++;
  for (size_t i = 0; ok && i < ORDERS; i++) first[i + 1] += first[i];
  for (size_t i = 0; ok && i < n; i++) order[first[order_of(k, i)]++] = (uint32_t)i;
  for (size_t i = 0; ok && i < n; i++) {
    k->old[i] = old[order[i]];
    k->level[i] = level[order[i]];
    k->source[i] = source[order[i]];
    k->before[i] =
        order[i]; /* of ghosts no more is needed: the number that the point was met with */
  }
  ylm_free(first);
  ylm_free(order);
  ylm_free(old);
  ylm_free(level);
  ylm_free(source);
  return ok ? YLM_OK : YLM_ENOMEM;
}

/* Where points stand in the end: in the order in which they are coded, ghosts last. */
static void find_places(small_layout *k) {
  size_t next = 0;
  for (int ghosts = 0; ghosts < 2; ghosts++)
    for (size_t i = 0; i < k->met; i++)
      if (!(k->g->flags[k->before[i]] & YLM_GRID_POINT_GHOST) == !ghosts)
        k->place[i] = (uint32_t)next++;
  for (size_t i = 0; i < k->met; i++) k->rank[k->place[i]] = (uint32_t)i;
}

/* Moves what is known of points to their places. */
static ylm_status move_points(small_layout *k, uint32_t *number) {
  ylm_grid *g = k->g;
  size_t n = k->met;
  uint32_t *lattice = ylm_alloc_copy(g->lattice, n, 3 * sizeof *lattice);
  uint8_t *flags = ylm_alloc_copy(g->flags, n, 1);
  float(*asked)[3] = g->sides.asked ? ylm_alloc_copy(g->sides.asked, n, sizeof *asked) : NULL;
  bool ok = lattice && flags && !asked == !g->sides.asked;
  for (size_t i = 0; ok && i < n; i++) {
    size_t to = k->place[i], was = k->before[i];
    memcpy(g->lattice + 3 * to, lattice + 3 * was, 3 * sizeof *lattice);
    if (asked) memcpy(g->sides.asked[to], asked[was], sizeof *asked);
    g->flags[to] = flags[was];
    number[was] = (uint32_t)to;
  }
  ylm_free(lattice);
  ylm_free(flags);
  ylm_free(asked);
  return ok ? YLM_OK : YLM_ENOMEM;
}

/* Points get the numbers that they are coded by. */
static ylm_status number(small_layout *k) {
  ylm_grid *g = k->g;
  k->place = ylm_alloc(k->met, sizeof *k->place);
  k->rank = ylm_alloc(k->met, sizeof *k->rank);
  uint32_t *to = ylm_alloc(k->met, sizeof *to);
  ylm_status s = k->place && k->rank && to ? sort_points(k) : YLM_ENOMEM;
  if (s == YLM_OK) {
    find_places(k);
    s = move_points(k, to);
  }
  for (size_t i = 0; s == YLM_OK && i < g->cells; i++)
    for (int c = 0; c < 8; c++)
      if (g->cell[i].corner[c] != YLM_GRID_NONE) g->cell[i].corner[c] = to[g->cell[i].corner[c]];
  for (size_t p = 0; s == YLM_OK && p < g->sides.parts; p++)
    for (int c = 0; c < 8; c++) g->sides.node[p][c] = to[g->sides.node[p][c]];
  ylm_free(to);
  ylm__lattice_hash_free(&g->hash);
  return s == YLM_OK ? ylm__sides_hash(g) : s;
}

/* Corners that were evaluated for others. */
static void share_corners(ylm_grid *g) {
  for (size_t i = 0; i < g->cells; i++) {
    ylm_grid_cell *c = &g->cell[i];
    bool whole = c->flags & YLM_GRID_SIDED;
    for (int k = 0; !whole && k < 8; k++) {
      uint32_t at[3];
      ylm__grid_corner_at(g, c, k, at);
      c->corner[k] = ylm__lattice_hash_find(&g->hash, lattice_key(at));
    }
    if (!g->contents.form.sides || whole || ylm__grid_is_complete(c)) continue;
    for (int k = 0; k < 8; k++) c->corner[k] = YLM_GRID_NONE;
  }
}

ylm_status ylm__small_finish(small_layout *k) {
  ylm_grid *g = k->g;
  g->evaluated = g->points;
  g->contents.octree_cells = g->cells;
  if (!k->met) return damaged(k, "it has no points");
  ylm_status s = number(k);
  if (s != YLM_OK) return s;
  share_corners(g);
  ylm__grid_find_baked(g);
  for (size_t i = 0; i < g->cells; i++) g->cell[i].source = 0;
  return g->contents.form.sides ? ylm__sides_index(g) : YLM_OK;
}

ylm_status ylm__small_continue(small_layout *k, int threads) {
  ylm_grid *g = k->g;
  bool continuous = g->contents.form.kind == YLM_GRID_ADAPTIVE && g->contents.form.continuous;
  ylm_status s = continuous ? ylm__grid_make_continuous(g, threads, NULL) : YLM_OK;
  return s == YLM_OK ? ylm__grid_finish(g) : s;
}

void ylm__small_layout_free(small_layout *k) {
  ylm_free(k->was);
  ylm_free(k->old);
  ylm__lattice_hash_free(&k->known);
  ylm_free(k->source);
  ylm_free(k->place);
  ylm_free(k->rank);
  ylm_free(k->level);
  ylm_free(k->before);
  ylm__lattice_hash_free(&k->ghost);
  ylm_free(k->chance);
}
