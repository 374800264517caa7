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

/* -- points inside lights ---------------------------------------------------------------- */

/* Per point, while filling. */
typedef struct filling {
  double *weight; /* [invalid] */
  uint32_t *slot; /* [points] place among the invalid ones, YLM_GRID_NONE: valid or filled */
  float *sum;     /* [invalid][4][stride] */
} filling;

/* Adds the first-order expansion about point q to the sums of point p. */
static void add_neighbour(const ylm_grid *g, filling *f, uint32_t p, uint32_t q) {
  double a[3], b[3], d2 = 0;
  ylm_grid_position(g, g->lattice + 3 * (size_t)p, a);
  ylm_grid_position(g, g->lattice + 3 * (size_t)q, b);
  for (int i = 0; i < 3; i++) d2 += (a[i] - b[i]) * (a[i] - b[i]);
  float w = (float)(1 / d2), dx[3];
  for (int i = 0; i < 3; i++) dx[i] = (float)(a[i] - b[i]);
  const float *row[4];
  for (int r = 0; r < 4; r++) row[r] = ylm__grid_row(g, q, r);
  float *to = f->sum + (size_t)f->slot[p] * 4 * g->stride;
  for (size_t j = 0; j < g->width; j++) {
    to[j] += w * (row[0][j] + dx[0] * row[1][j] + dx[1] * row[2][j] + dx[2] * row[3][j]);
    for (size_t r = 1; r < 4; r++) to[r * g->stride + j] += w * row[r][j];
  }
  f->weight[f->slot[p]] += (double)w;
}

/* Sums over the cells of one level; returns whether anything was added. */
static bool gather(const ylm_grid *g, filling *f, int level) {
  bool any = false;
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (c->level != level || c->flags & YLM_GRID_ADDED) continue;
    for (int k = 0; k < 8; k++) {
      uint32_t p = c->corner[k];
      if (p == YLM_GRID_NONE || f->slot[p] == YLM_GRID_NONE) continue;
      for (int m = 0; m < 8; m++) {
        uint32_t q = c->corner[m];
        if (q == YLM_GRID_NONE || f->slot[q] != YLM_GRID_NONE) continue;
        add_neighbour(g, f, p, q);
        any = true;
      }
    }
  }
  return any;
}

/* Means from the sums; those points count as valid from now on. */
static void settle(ylm_grid *g, filling *f) {
  for (size_t p = 0; p < g->evaluated; p++) {
    uint32_t slot = f->slot[p];
    if (slot == YLM_GRID_NONE || !(f->weight[slot] > 0)) continue;
    float scale = (float)(1 / f->weight[slot]), *to = g->data + p * 4 * g->stride;
    const float *from = f->sum + (size_t)slot * 4 * g->stride;
    for (size_t j = 0; j < 4 * g->stride; j++) to[j] = scale * from[j];
    f->slot[p] = YLM_GRID_NONE;
  }
}

ylm_status ylm__grid_fill_invalid(ylm_grid *g) {
  uint32_t invalid = 0;
  for (size_t p = 0; p < g->evaluated; p++) invalid += (g->flags[p] & YLM_GRID_POINT_INVALID) != 0;
  if (!invalid) return YLM_OK;
  filling f = {ylm_alloc_zero(invalid, sizeof *f.weight), ylm_alloc(g->evaluated, sizeof *f.slot),
               ylm_alloc_zero(invalid, 4 * g->stride * sizeof *f.sum)};
  ylm_status s = f.weight && f.slot && f.sum ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    uint32_t next = 0;
    for (size_t p = 0; p < g->evaluated; p++)
      f.slot[p] = g->flags[p] & YLM_GRID_POINT_INVALID ? next++ : YLM_GRID_NONE;
    /* Finest cells first; what is deeper inside follows from what has been filled. */
    int depth = g->view.form.kind == YLM_GRID_UNIFORM ? 0 : g->view.form.depth;
    for (int level = depth; level >= 0; level--)
      while (gather(g, &f, level)) settle(g, &f);
  }
  ylm_free(f.weight);
  ylm_free(f.slot);
  ylm_free(f.sum);
  return s;
}

/* -- continuity ------------------------------------------------------------------------------ */

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

static ylm_status interpolate_range(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const interpolation *j = context;
  ylm_grid *g = j->g;
  for (size_t i = begin; i < end; i++) {
    uint32_t born = j->order[j->first + i];
    const ylm_grid_cell *c = &g->cell[g->birth[born].cell];
    size_t p = g->evaluated + born;
    bool wanted = !j->changed;
    for (int k = 0; k < 8 && !wanted; k++) wanted = j->changed[c->corner[k]];
    if (!wanted) continue;
    uint32_t n = g->birth[born].place;
    float t[3] = {0.5f * (float)(n % 3), 0.5f * (float)(n / 3 % 3), 0.5f * (float)(n / 9)};
    float *to = g->data + p * 4 * g->stride;
    memset(to, 0, 4 * g->stride * sizeof *to);
    ylm__grid_interpolate(g, c, t, to, to + g->stride);
    interpolate_metric(g, c, t, p);
    if (j->changed) j->changed[p] = 1;
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

/* Gives the children of a cell the corners they lack: evaluated points where there are any. */
static ylm_status complete_children(ylm_grid *g, uint32_t parent) {
  uint32_t shared[27], first = g->cell[parent].child;
  for (int n = 0; n < 27; n++) shared[n] = YLM_GRID_NONE;
  for (uint32_t k = 0; k < 8; k++)
    for (uint32_t i = 0; i < 8; i++) {
      ylm_grid_cell *c = &g->cell[first + k];
      if (c->corner[i] != YLM_GRID_NONE) continue;
      uint32_t edge = ylm__grid_edge(g, c), at[3];
      int n = 0, power = 1;
      for (int a = 0; a < 3; a++, power *= 3) {
        at[a] = c->origin[a] + (i >> a & 1 ? edge : 0);
        n += power * (int)((k >> a & 1) + (i >> a & 1));
      }
      if (shared[n] == YLM_GRID_NONE) shared[n] = lattice_hash_find(&g->hash, lattice_key(at));
      if (shared[n] == YLM_GRID_NONE) {
        ylm_status s = add_interpolated(g, parent, n, &shared[n]);
        if (s != YLM_OK) return s;
      }
      g->cell[first + k].corner[i] = shared[n];
    }
  return YLM_OK;
}

/* The leaf that holds the finest cell `at`, with added cells. */
static uint32_t finest(const ylm_grid *g, const uint32_t at[3]) {
  uint32_t cell = 0;
  while (g->cell[cell].child) {
    int shift = g->view.form.depth - g->cell[cell].level - 1;
    cell = g->cell[cell].child +
           ((at[0] >> shift & 1) | (at[1] >> shift & 1) << 1 | (at[2] >> shift & 1) << 2);
  }
  return cell;
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
    uint32_t cell = finest(g, beside), first;
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
      if (side_of(j->g, at, side, beside) && hangs(j->g, &j->g->cell[finest(j->g, beside)], at))
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
  ylm_status s = ylm_parallel(g->evaluated, 512, threads, find_hanging, &j, NULL, NULL);
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

/* -- voxels without data, while sampling ------------------------------------------------------- */

/* Gives the virtual cell the corner at place n of its own half-edge lattice: an evaluated point's
   rows, or rows interpolated into `to`. */
static void virtual_corner(const ylm_grid *g, const virtual_cell *v, const uint32_t place[3],
                           float *to, const float *row[4]) {
  uint32_t half = v->edge / 2, at[3];
  int corner = 0, middle = 0;
  float t[3];
  for (int a = 0; a < 3; a++) {
    at[a] = v->origin[a] + place[a] * half;
    t[a] = 0.5f * (float)place[a];
    middle += place[a] == 1;
    corner |= (int)(place[a] / 2) << a;
  }
  uint32_t point = middle ? lattice_hash_find(&g->hash, lattice_key(at)) : YLM_GRID_NONE;
  for (int r = 0; r < 4; r++) {
    if (!middle) /* its rows may lie in the room that the next descent writes to */
      row[r] = memcpy(to + (size_t)r * g->stride, v->row[8 * r + corner], g->stride * sizeof *to);
    else if (point != YLM_GRID_NONE)
      row[r] = ylm__grid_row(g, point, r);
    else
      row[r] = to + (size_t)r * g->stride;
  }
  if (middle && point == YLM_GRID_NONE) ylm__grid_mix(g, v->row, v->edge, t, to, to + g->stride);
}

/* Replaces the virtual cell by its child number k; `to` is room for eight corners. */
static void virtual_descend(const ylm_grid *g, virtual_cell *v, uint32_t k, float *to) {
  const float *row[32];
  for (uint32_t i = 0; i < 8; i++) {
    uint32_t place[3];
    const float *corner[4];
    for (int a = 0; a < 3; a++) place[a] = (k >> a & 1) + (i >> a & 1);
    virtual_corner(g, v, place, to + i * 4 * g->stride, corner);
    for (uint32_t r = 0; r < 4; r++) row[8 * r + i] = corner[r];
  }
  memcpy(v->row, row, sizeof row);
  v->edge /= 2;
  for (int a = 0; a < 3; a++) v->origin[a] += k >> a & 1 ? v->edge : 0;
}

void ylm__grid_virtual(const ylm_grid *g, uint32_t leaf, const double at[3], virtual_cell *v,
                       float *scratch) {
  const ylm_grid_cell *c = &g->cell[leaf], *from = &g->cell[c->source];
  memcpy(v->origin, from->origin, sizeof v->origin);
  v->edge = ylm__grid_edge(g, from);
  for (int r = 0; r < 4; r++)
    for (int k = 0; k < 8; k++) v->row[8 * r + k] = ylm__grid_row(g, from->corner[k], r);
  uint32_t last = 1u << (g->view.form.depth - c->detail);
  for (int level = 0; v->edge > last; level++) {
    uint32_t k = 0;
    for (int a = 0; a < 3; a++) k |= (uint32_t)(at[a] >= v->origin[a] + v->edge / 2) << a;
    /* Children interpolate from their parent: two rooms in turn. */
    virtual_descend(g, v, k, scratch + (size_t)(level & 1) * 32 * g->stride);
  }
}
