/*
** continuity.c - no jumps across faces that change level.
**
** A leaf that has an evaluated point inside of one of its faces or edges is split, until there is
** none. A new corner that was not evaluated takes value and gradient from the interpolant of the very cell that was split.
** Its eight children alone share it. An interpolant restricted to a face depends on that face's
** four corners (values, tangential derivatives) alone, and its children reproduce it. By induction,
** two cells that share a face agree on it, whatever else happens around. (One point for all cells
** around an edge would not do: across an edge the cells' transversal derivatives differ.)
*/
#include "baker.h"
#include "ylm_list.h"

#include <math.h>
#include <string.h>

/* Lambda and norm at fraction t of a cell: trilinear. */
static void interpolate_metric(ylm_grid *g, const ylm_grid_cell *c, const float t[3], size_t to) {
  float lambda = 0, norm = 0;
  for (int k = 0; k < 8; k++) {
    float w = 1;
    for (int a = 0; a < 3; a++) w *= k >> a & 1 ? t[a] : 1 - t[a];
    lambda += w * g->lambda[c->corner[k]];
    norm += w * g->norm[c->corner[k]];
  }
  g->lambda[to] = lambda;
  g->norm[to] = norm;
}

/* A point of its own at place n (0 .. 26) of a cell's half-edge lattice; its data come later. */
static ylm_status add_interpolated(ylm_grid *g, uint32_t parent, int n, uint32_t *index) {
  ylm_status s = ylm__grid_reserve_points(g, 1);
  if (s != YLM_OK) return s;
  size_t p = g->points, born = p - g->evaluated;
  if (!ylm_list_reserve(&g->birth, born, born + 1, &g->birth_room, sizeof *g->birth))
    return YLM_ENOMEM;
  const ylm_grid_cell *c = &g->cell[parent];
  uint32_t half = ylm__grid_edge(g, c) / 2,
           place[3] = {(uint32_t)n % 3, (uint32_t)n / 3 % 3, (uint32_t)n / 9};
  for (int a = 0; a < 3; a++) g->lattice[3 * p + (size_t)a] = c->origin[a] + place[a] * half;
  g->birth[born] = (ylm_grid_birth){parent, (uint32_t)n};
  g->flags[p] = YLM_GRID_POINT_INTERPOLATED;
  g->points++;
  *index = (uint32_t)p;
  return YLM_OK;
}

typedef struct interpolation {
  ylm_grid *g;
  uint8_t *changed;
  const uint32_t *order; /* births by the level of their cell */
  size_t first;          /* of the level at hand */
  bool keep, keep_all;   /* the follower is told of points that are computed; of the others too */
} interpolation;

/* Data of the n points that were born of one cell, the first of which is order[0]. */
static void interpolate_births(ylm_grid *g, const uint32_t *order, int n, const ylm_grid_cell *c) {
  sample_batch b = {.points = n,
                    .width = (int)g->width,
                    .derivatives = g->rows > 1,
                    .sparse = true,
                    .interpolation = ylm__grid_interpolation(g, YLM_GRID_HERMITE)};
  ylm__grid_set_cell(g, c, &b);
  for (int i = 0; i < n; i++) {
    size_t p = g->evaluated + order[i];
    uint32_t place = g->birth[order[i]].place;
    float *to = g->data + p * ylm__grid_record(g), t[3];
    for (int a = 0; a < 3; a++, place /= 3) b.t[a][i] = t[a] = 0.5f * (float)(place % 3);
    b.value[i] = to;
    for (size_t a = 0; b.derivatives && a < 3; a++) b.gradient[a][i] = to + (a + 1) * g->stride;
    for (size_t r = 0; r < g->rows; r++)
      memset(to + r * g->stride + g->width, 0, (g->stride - g->width) * sizeof *to);
    interpolate_metric(g, c, t, p);
  }
  ylm__grid_kernel()(&b);
}

/* True if something changed that the points born of the cell of birth `first` are made of. */
static bool is_wanted(const interpolation *j, uint32_t first) {
  const ylm_grid *g = j->g;
  const ylm_grid_cell *c = &g->cell[g->birth[first].cell];
  bool wanted = !j->changed || j->changed[g->evaluated + first];
  for (int k = 0; k < 8 && !wanted; k++) wanted = j->changed[c->corner[k]];
  return wanted;
}

static ylm_status interpolate_range(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const interpolation *j = context;
  ylm_grid *g = j->g;
  bool wanted = is_wanted(j, j->order[j->first + begin]);
  for (size_t i = begin; i < end;) {
    const uint32_t *order = j->order + j->first + i;
    uint32_t cell = g->birth[order[0]].cell;
    int n = 0;
    for (; i < end && n < BATCH && g->birth[order[n]].cell == cell; n++, i++)
      if (j->changed && wanted) j->changed[g->evaluated + order[n]] = 1;
    bool next = i < end && is_wanted(j, order[n]);
    if (next) ylm__grid_fetch(g, &g->cell[g->birth[order[n]].cell]);
    if (wanted) interpolate_births(g, order, n, &g->cell[cell]);
    if ((wanted && j->keep) || j->keep_all) g->follower->born(g, &g->cell[cell], (size_t)n, order);
    wanted = next;
  }
  return YLM_OK;
}

/* Corners of a cell were born of coarser cells, so levels follow one another. */
ylm_status ylm__grid_interpolate_points(ylm_grid *g, uint8_t *changed, int threads,
                                        const ylm_progress *progress) {
  size_t n = g->points - g->evaluated, first[YLM_GRID_MAX_DEPTH + 2] = {0};
  if (!n) return YLM_OK;
  uint32_t *order = ylm_alloc(n, sizeof *order);
  if (!order) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) first[g->cell[g->birth[i].cell].level + 1]++;
  for (int k = 0; k <= YLM_GRID_MAX_DEPTH; k++) first[k + 1] += first[k];
  size_t next[YLM_GRID_MAX_DEPTH + 1];
  memcpy(next, first, sizeof next);
  for (size_t i = 0; i < n; i++) order[next[g->cell[g->birth[i].cell].level]++] = (uint32_t)i;
  bool all = false, keep = g->follower && g->follower->births(g, &all);
  interpolation j = {g, changed, order, 0, keep, keep && all};
  ylm_status s = YLM_OK;
  for (int k = 0; k <= YLM_GRID_MAX_DEPTH && s == YLM_OK; k++) {
    j.first = first[k];
    s = ylm_parallel(first[k + 1] - first[k], BAKE_GRAIN, threads, interpolate_range, &j, progress,
                     NULL);
  }
  ylm_free(order);
  return s;
}

/* The corners (bits) around places 0 .. 26 of a cell's half-edge lattice: the ends of an edge,
   those of a face; one alone is the corner itself. */
static const uint8_t around[27] = {0x01, 0x03, 0x02, 0x05, 0x0f, 0x0a, 0x04, 0x0c, 0x08,
                                   0x11, 0x33, 0x22, 0x55, 0xff, 0xaa, 0x44, 0xcc, 0x88,
                                   0x10, 0x30, 0x20, 0x50, 0xf0, 0xa0, 0x40, 0xc0, 0x80};
#define CENTRE 13
static bool is_corner(uint32_t n) { return (around[n] & (around[n] - 1)) == 0; }

/* A box, of a cell or of what would be one, with those of its corners that are evaluated points. */
typedef struct touched_box {
  uint32_t origin[3], edge, corner[8];
} touched_box;

static touched_box box_of(const ylm_grid *g, const ylm_grid_cell *c) {
  touched_box b = {.edge = ylm__grid_edge(g, c)};
  memcpy(b.origin, c->origin, sizeof b.origin);
  for (int k = 0; k < 8; k++)
    b.corner[k] = c->corner[k] < g->evaluated ? c->corner[k] : YLM_GRID_NONE;
  return b;
}

/*
** The evaluated points at the places of a box, YLM_GRID_NONE where there is none; true if there are
** any in its edges or faces but for the corners. The point, at the middle or anywhere else, is the
** corner of an occupied voxel that touches the edge or face. All ancestors of that voxel were
** evaluated. One has the box's size: its corners are the ends of the edge, or the corners of the
** face. One has half that size: a corner of it is the middle.
** Where nothing is there, nothing is finer.
*/
static bool find_middles(const ylm_grid *g, const touched_box *b, uint32_t point[27]) {
  uint64_t key[27];
  uint32_t half = b->edge / 2, wanted = 0;
  uint8_t corners = 0;
  for (int k = 0; k < 8; k++) corners |= (uint8_t)((b->corner[k] != YLM_GRID_NONE) << k);
  for (uint32_t n = 0; n < 27; n++) {
    point[n] = is_corner(n) ? b->corner[__builtin_ctz(around[n])] : YLM_GRID_NONE;
    if (!half || is_corner(n) || (around[n] & corners) != around[n]) continue;
    key[n] = lattice_key((const uint32_t[3]){
        b->origin[0] + n % 3 * half, b->origin[1] + n / 3 % 3 * half, b->origin[2] + n / 9 * half});
    ylm__lattice_hash_prefetch(&g->hash, key[n]);
    wanted |= 1u << n;
  }
  bool any = false;
  for (uint32_t n = 0; n < 27; n++) {
    if (!(wanted >> n & 1)) continue;
    point[n] = ylm__lattice_hash_find(&g->hash, key[n]);
    any |= point[n] != YLM_GRID_NONE && n != CENTRE;
  }
  return any;
}

/* Where corner i of child k stands among the 27. */
static uint32_t place_of(uint32_t k, uint32_t i) {
  return (k & 1) + (i & 1) + 3 * ((k >> 1 & 1) + (i >> 1 & 1)) + 9 * ((k >> 2) + (i >> 2));
}

/* Gives the new children of a cell their corners: its own, evaluated points where there are any
   (`point`), or points that they alone share. */
static ylm_status complete_children(ylm_grid *g, uint32_t parent, uint32_t point[27]) {
  uint32_t first = g->cell[parent].child;
  for (uint32_t n = 0; n < 27; n++) {
    if (is_corner(n)) point[n] = g->cell[parent].corner[__builtin_ctz(around[n])];
    if (point[n] != YLM_GRID_NONE) continue;
    ylm_status s = add_interpolated(g, parent, (int)n, &point[n]);
    if (s != YLM_OK) return s;
  }
  for (uint32_t k = 0; k < 8; k++)
    for (uint32_t i = 0; i < 8; i++) g->cell[first + k].corner[i] = point[place_of(k, i)];
  return YLM_OK;
}

/* Splits a leaf that has data while evaluated points lie in its faces or edges. */
static ylm_status split_leaf(ylm_grid *g, uint32_t cell) {
  uint32_t point[27], first;
  touched_box box = box_of(g, &g->cell[cell]);
  if (!find_middles(g, &box, point)) return YLM_OK;
  ylm_status s = ylm__grid_split(g, cell, &first);
  if (s != YLM_OK) return s;
  for (uint32_t k = 0; k < 8; k++) g->cell[first + k].flags = YLM_GRID_ADDED;
  s = complete_children(g, cell, point);
  for (uint32_t k = 0; k < 8 && s == YLM_OK; k++) s = split_leaf(g, first + k);
  return s;
}

/* The level down to which evaluated points touch a box of `level`; 0: there are none. */
static int finest_middle(const ylm_grid *g, const touched_box *b, int level) {
  uint32_t point[27];
  if (!find_middles(g, b, point)) return 0;
  int found = level + 1;
  for (uint32_t k = 0; k < 8; k++) {
    touched_box child = {.edge = b->edge / 2};
    for (int a = 0; a < 3; a++) child.origin[a] = b->origin[a] + (k >> a & 1 ? b->edge / 2 : 0);
    for (uint32_t i = 0; i < 8; i++) child.corner[i] = point[place_of(k, i)];
    int below = finest_middle(g, &child, level + 1);
    if (below > found) found = below;
  }
  return found;
}

ylm_status ylm__grid_continue_leaf(ylm_grid *g, uint32_t cell) {
  ylm_grid_cell *c = &g->cell[cell];
  if (c->flags & YLM_GRID_BRICK) return YLM_OK;
  if (c->flags & YLM_GRID_BAKED) return split_leaf(g, cell);
  /* A leaf without data notes the level down to which sampling has to look for such points. */
  touched_box box = box_of(g, c);
  int detail = finest_middle(g, &box, c->level), corners = 0;
  for (int i = 0; i < 8; i++) corners += c->corner[i] != YLM_GRID_NONE;
  bool own = corners > (cell > 0 && c->corner[(cell - 1) & 7] != YLM_GRID_NONE);
  if (!detail && own) detail = c->level;
  c->detail = (uint16_t)detail;
  return YLM_OK;
}

/* -- which leaves ----------------------------------------------------------------------------- */

bool ylm__grid_side(const ylm_grid *g, const uint32_t at[3], int side, uint32_t beside[3]) {
  bool out = false;
  for (int a = 0; a < 3; a++) {
    out |= side >> a & 1 ? at[a] > g->last[a] : at[a] == g->contents.root[a];
    beside[a] = side >> a & 1 ? at[a] : at[a] - 1;
  }
  return !out;
}

/* True if the point is not a corner of the cell that it touches. */
static bool hangs(const ylm_grid *g, const ylm_grid_cell *c, const uint32_t at[3]) {
  uint32_t edge = ylm__grid_edge(g, c);
  bool corner = true;
  for (int a = 0; a < 3; a++) corner &= at[a] == c->origin[a] || at[a] == c->origin[a] + edge;
  return !corner;
}

typedef struct hanging_job {
  const ylm_grid *g;
  uint8_t *leaf; /* [cells] that an evaluated point touches, or leaves without data */
} hanging_job;

static ylm_status find_hanging(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const hanging_job *j = context;
  for (size_t p = begin; p < end; p++) {
    const uint32_t *at = j->g->lattice + 3 * p;
    uint32_t beside[3];
    for (int side = 0; side < 8; side++) {
      if (!ylm__grid_side(j->g, at, side, beside)) continue;
      uint32_t cell = ylm__grid_finest(j->g, beside);
      const ylm_grid_cell *c = &j->g->cell[cell];
      if (c->flags & YLM_GRID_SIDED) continue;
      if (!(c->flags & YLM_GRID_BAKED) || hangs(j->g, c, at))
        __atomic_store_n(&j->leaf[cell], 1, __ATOMIC_RELAXED);
    }
  }
  return YLM_OK;
}

/* Leaves between two reports. */
#define REPORTED ((size_t)1024)

ylm_status ylm__grid_make_continuous(ylm_grid *g, int threads, const ylm_progress *progress) {
  size_t cells = g->cells;
  hanging_job j = {g, ylm_alloc_zero(cells, 1)};
  ylm_status s = j.leaf ? ylm__grid_build_table(g) : YLM_ENOMEM;
  if (s == YLM_OK)
    s = ylm_parallel(g->evaluated, BAKE_LOOK_GRAIN, threads, find_hanging, &j, progress, NULL);
  for (size_t i = 0, leaves = 0; i < cells && s == YLM_OK; i++) {
    if (!j.leaf[i]) continue;
    s = ylm__grid_continue_leaf(g, (uint32_t)i);
    if (s == YLM_OK && ++leaves % REPORTED == 0) s = ylm_report(progress, i, cells, NULL);
  }
  ylm_free(j.leaf);
  return s == YLM_OK ? ylm__grid_interpolate_points(g, NULL, threads, progress) : s;
}
