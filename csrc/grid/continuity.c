/*
** continuity.c - no jumps across faces that change level, and values for points inside lights.
**
** A leaf that has an evaluated point inside of one of its faces or edges is split, until there is
** none. A new corner that nobody evaluated takes value and gradient from the interpolant of the
** very cell that was split, and is shared by its eight children only: an interpolant restricted
** to a face depends on that face's four corners (values, tangential derivatives) alone and is
** reproduced by its children, so two cells that share a face agree on it by induction, whatever
** else happens around. (One point for all cells around an edge would not do: across an edge the
** cells' transversal derivatives differ.)
*/
#include "grid.h"

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
  if (born == g->birth_room) {
    size_t room = born ? 2 * born : 256;
    grid_birth *more = ylm_realloc(g->birth, born * sizeof *more, room, sizeof *more);
    if (!more) return YLM_ENOMEM;
    g->birth = more;
    g->birth_room = room;
  }
  const ylm_grid_cell *c = &g->cell[parent];
  uint32_t half = ylm__grid_edge(g, c) / 2,
           place[3] = {(uint32_t)n % 3, (uint32_t)n / 3 % 3, (uint32_t)n / 9};
  for (int a = 0; a < 3; a++) g->lattice[3 * p + (size_t)a] = c->origin[a] + place[a] * half;
  g->birth[born] = (grid_birth){parent, (uint32_t)n};
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
} interpolation;

/* Data of the n points that were born of one cell, the first of which is order[0]. */
static void interpolate_births(ylm_grid *g, const uint32_t *order, int n, const ylm_grid_cell *c) {
  sample_batch b = {.points = n,
                    .width = (int)g->width,
                    .derivatives = 1,
                    .sparse = true,
                    .interpolation = YLM_GRID_HERMITE};
  ylm__grid_set_cell(g, c, &b);
  for (int i = 0; i < n; i++) {
    size_t p = g->evaluated + order[i];
    uint32_t place = g->birth[order[i]].place;
    float *to = g->data + p * 4 * g->stride, t[3];
    for (int a = 0; a < 3; a++, place /= 3) b.t[a][i] = t[a] = 0.5f * (float)(place % 3);
    b.value[i] = to;
    for (size_t a = 0; a < 3; a++) b.gradient[a][i] = to + (a + 1) * g->stride;
    for (size_t r = 0; r < 4; r++)
      memset(to + r * g->stride + g->width, 0, (g->stride - g->width) * sizeof *to);
    interpolate_metric(g, c, t, p);
  }
  ylm__grid_kernel()(&b);
}

static ylm_status interpolate_range(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const interpolation *j = context;
  ylm_grid *g = j->g;
  for (size_t i = begin; i < end;) {
    const uint32_t *order = j->order + j->first + i;
    uint32_t cell = g->birth[order[0]].cell;
    const ylm_grid_cell *c = &g->cell[cell];
    bool wanted = !j->changed;
    for (int k = 0; k < 8 && !wanted; k++) wanted = j->changed[c->corner[k]];
    int n = 0;
    for (; i < end && n < BATCH && g->birth[order[n]].cell == cell; n++, i++)
      if (j->changed && wanted) j->changed[g->evaluated + order[n]] = 1;
    if (wanted) interpolate_births(g, order, n, c);
  }
  return YLM_OK;
}

/* Corners of a cell were born of coarser cells, so levels follow one another. */
ylm_status ylm__grid_interpolate_points(ylm_grid *g, uint8_t *changed, int threads) {
  size_t n = g->points - g->evaluated, first[YLM_GRID_MAX_DEPTH + 2] = {0};
  if (!n) return YLM_OK;
  uint32_t *order = ylm_alloc(n, sizeof *order);
  if (!order) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) first[g->cell[g->birth[i].cell].level + 1]++;
  for (int k = 0; k <= YLM_GRID_MAX_DEPTH; k++) first[k + 1] += first[k];
  size_t next[YLM_GRID_MAX_DEPTH + 1];
  memcpy(next, first, sizeof next);
  for (size_t i = 0; i < n; i++) order[next[g->cell[g->birth[i].cell].level]++] = (uint32_t)i;
  interpolation j = {g, changed, order, 0};
  for (int k = 0; k <= YLM_GRID_MAX_DEPTH; k++) {
    j.first = first[k];
    ylm_parallel(first[k + 1] - first[k], 64, threads, interpolate_range, &j, NULL, NULL);
  }
  ylm_free(order);
  return YLM_OK;
}

/* Gives the new children of a cell their corners: its own, evaluated points where there are any, or
   points that they alone share. */
static ylm_status complete_children(ylm_grid *g, uint32_t parent) {
  const ylm_grid_cell *c = &g->cell[parent];
  uint32_t point[27], first = c->child, half = ylm__grid_edge(g, c) / 2;
  uint64_t key[27];
  for (uint32_t n = 0; n < 27; n++) {
    uint32_t place[3] = {n % 3, n / 3 % 3, n / 9}, at[3];
    for (int a = 0; a < 3; a++) at[a] = c->origin[a] + place[a] * half;
    key[n] = lattice_key(at);
    if (place[0] == 1 || place[1] == 1 || place[2] == 1) {
      point[n] = YLM_GRID_NONE;
      lattice_hash_prefetch(&g->hash, key[n]);
    } else
      point[n] = c->corner[place[0] / 2 + place[1] + place[2] * 2];
  }
  for (uint32_t n = 0; n < 27; n++) {
    if (point[n] == YLM_GRID_NONE) point[n] = lattice_hash_find(&g->hash, key[n]);
    if (point[n] != YLM_GRID_NONE) continue;
    ylm_status s = add_interpolated(g, parent, (int)n, &point[n]);
    if (s != YLM_OK) return s;
  }
  for (uint32_t k = 0; k < 8; k++)
    for (uint32_t i = 0; i < 8; i++)
      g->cell[first + k].corner[i] =
          point[(k & 1) + (i & 1) + 3 * ((k >> 1 & 1) + (i >> 1 & 1)) + 9 * ((k >> 2) + (i >> 2))];
  return YLM_OK;
}

/* True if the point lies inside of a face or an edge of the cell that it touches. */
static bool hangs(const ylm_grid *g, const ylm_grid_cell *c, const uint32_t at[3]) {
  uint32_t edge = ylm__grid_edge(g, c);
  int inner = 0;
  for (int a = 0; a < 3; a++) inner += at[a] != c->origin[a] && at[a] != c->origin[a] + edge;
  return inner == 1 || inner == 2;
}

/* The level at which a lattice point first is a corner. */
static int level_of(const ylm_grid *g, const uint32_t at[3]) {
  uint32_t bits = at[0] | at[1] | at[2] | g->view.resolution[0];
  return g->view.form.depth - __builtin_ctz(bits);
}

/* Splits the leaf on one side of an evaluated point until the point is its corner. A leaf without
   data of its own only notes the level down to which sampling has to look for such points. */
static ylm_status split_beside(ylm_grid *g, const uint32_t at[3], const uint32_t beside[3]) {
  for (;;) {
    uint32_t cell = ylm__grid_finest(g, beside), first;
    ylm_grid_cell *c = &g->cell[cell];
    if (!hangs(g, c, at)) return YLM_OK;
    if (!(c->flags & (YLM_GRID_BAKED | YLM_GRID_ADDED))) {
      int level = level_of(g, at);
      if (level > c->detail) c->detail = (uint16_t)level;
      return YLM_OK;
    }
    ylm_status s = ylm__grid_split(g, cell, &first);
    if (s != YLM_OK) return s;
    for (uint32_t k = 0; k < 8; k++) g->cell[first + k].flags = YLM_GRID_ADDED;
    s = complete_children(g, cell);
    if (s != YLM_OK) return s;
  }
}

/* Leaves without data note the level at which corners of their own were evaluated. */
static void note_corners(ylm_grid *g, const ylm_grid_cell *parent) {
  for (uint32_t k = 0; k < 8; k++) {
    ylm_grid_cell *c = &g->cell[parent->child + k];
    if (c->flags & YLM_GRID_BAKED) continue;
    for (uint32_t i = 0; i < 8; i++)
      if (i != k && c->corner[i] != YLM_GRID_NONE) c->detail = c->level;
  }
}

/* The finest lattice cell on a side of a point; false if that is outside of the grid. */
static bool side_of(const ylm_grid *g, const uint32_t at[3], int side, uint32_t beside[3]) {
  bool out = false;
  for (int a = 0; a < 3; a++) {
    out |= side >> a & 1 ? at[a] == g->view.resolution[a] : at[a] == 0;
    beside[a] = side >> a & 1 ? at[a] : at[a] - 1;
  }
  return !out;
}

typedef struct hanging_job {
  const ylm_grid *g;
  uint8_t *hanging; /* [evaluated] one bit per side */
} hanging_job;

static ylm_status find_hanging(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const hanging_job *j = context;
  for (size_t p = begin; p < end; p++) {
    const uint32_t *at = j->g->lattice + 3 * p;
    uint32_t beside[3];
    j->hanging[p] = 0;
    for (int side = 0; side < 8; side++)
      if (side_of(j->g, at, side, beside) &&
          hangs(j->g, &j->g->cell[ylm__grid_finest(j->g, beside)], at))
        j->hanging[p] |= (uint8_t)(1 << side);
  }
  return YLM_OK;
}

/* Splitting makes no point hang that did not: a corner of a cell is a corner of its child there. */
ylm_status ylm__grid_make_continuous(ylm_grid *g, int threads) {
  uint8_t *hanging = ylm_alloc(g->evaluated, 1);
  if (!hanging) return YLM_ENOMEM;
  for (size_t i = 0; i < g->view.octree_cells; i++)
    if (g->cell[i].child) note_corners(g, &g->cell[i]);
  hanging_job j = {g, hanging};
  ylm_status s = ylm__grid_build_table(g);
  if (s == YLM_OK) s = ylm_parallel(g->evaluated, 512, threads, find_hanging, &j, NULL, NULL);
  for (size_t p = 0; p < g->evaluated && s == YLM_OK; p++)
    for (int side = 0; side < 8 && s == YLM_OK; side++) {
      uint32_t at[3], beside[3];
      if (!(hanging[p] >> side & 1)) continue;
      memcpy(at, g->lattice + 3 * p, sizeof at); /* splitting may move the array */
      side_of(g, at, side, beside);
      s = split_beside(g, at, beside);
    }
  ylm_free(hanging);
  return s == YLM_OK ? ylm__grid_interpolate_points(g, NULL, threads) : s;
}
