/* store.c - cells and points of a grid, and the way from a position to its cell. */
#include "bake/panel.h"
#include "grid.h"
#include "ylm_list.h"

#include <math.h>
#include <string.h>

#define MAX_TABLE_LEVEL 6
#define LEAST_EXTENT 1e-30 /* of bounds: squares of a voxel's edges stay normal numbers */
#define MOST_EXTENT 1e18   /* as float they are finite */

/* -- making --------------------------------------------------------------------- */

static ylm_status check_bounds(const double *b, ylm_error *e) {
  for (int a = 0; a < 3; a++) {
    double lo = b[a], hi = b[a + 3];
    if (!isfinite(lo) || !isfinite(hi) || !isfinite(hi - lo) || !(lo < hi))
      return ylm_fail(e, YLM_EDOMAIN,
                      "bounds: max must exceed min along every axis, axis %d has %g and %g", a + 1,
                      lo, hi);
    if (hi - lo < LEAST_EXTENT)
      return ylm_fail(e, YLM_EDOMAIN,
                      "bounds: axis %d is only %g long; the least is %g (choose another unit)",
                      a + 1, hi - lo, LEAST_EXTENT);
    if (hi - lo > MOST_EXTENT)
      return ylm_fail(e, YLM_EDOMAIN,
                      "bounds: axis %d is %g long; the most is %g (choose another unit)", a + 1,
                      hi - lo, MOST_EXTENT);
  }
  return YLM_OK;
}

static ylm_status check_uniform(const ylm_grid_form *f, ylm_error *e) {
  uint64_t n = 1;
  for (int a = 0; a < 3; a++) {
    if (f->cells[a] < 1 || f->cells[a] > YLM_GRID_MAX_SIDE)
      return ylm_fail(e, YLM_ERANGE, "cells: 1 to %u along each axis, got %u", YLM_GRID_MAX_SIDE,
                      f->cells[a]);
    n *= f->cells[a];
    if (n > YLM_GRID_MAX_CELLS)
      return ylm_fail(e, YLM_EOVERFLOW, "cells: %u x %u x %u are too many", f->cells[0],
                      f->cells[1], f->cells[2]);
  }
  return YLM_OK;
}

static ylm_status check_adaptive(const ylm_grid_form *f, ylm_error *e) {
  if (f->depth < 0 || f->depth > YLM_GRID_MAX_DEPTH)
    return ylm_fail(e, YLM_ERANGE, "depth: 0 to %d, got %d", YLM_GRID_MAX_DEPTH, f->depth);
  if (f->metric != YLM_GRID_ABSOLUTE && f->metric != YLM_GRID_RELATIVE)
    return ylm_fail(e, YLM_EINVAL, "metric: absolute or relative");
  if (isnan(f->tolerance) || f->tolerance < 0 || isinf(f->tolerance))
    return ylm_fail(e, YLM_EDOMAIN, "tolerance: a positive number, got %g", f->tolerance);
  if (isnan(f->threshold) || isinf(f->threshold))
    return ylm_fail(e, YLM_EDOMAIN, "threshold: a number of at least 0, got %g", f->threshold);
  if (f->measure == YLM_GRID_IRRADIANCE && !(f->tolerance > 0))
    return ylm_fail(e, YLM_EINVAL, "measure: irradiance is of a tolerance, this grid has none");
  if (f->floor > 0 && (f->measure == YLM_GRID_IRRADIANCE || !(f->tolerance > 0)))
    return ylm_fail(e, YLM_EINVAL, "floor: it is of a tolerance of coefficients");
  if ((f->tolerance > 0) == (f->threshold >= 0))
    return ylm_fail(e, YLM_EINVAL, "either a tolerance or a threshold is wanted, not both");
  return YLM_OK;
}

static bool body_holds(const ylm_grid_body *b) {
  return ylm_all_finite(YLM_DOUBLE, b->at, 3, NULL) && b->radius >= 0 && isfinite(b->radius) &&
         b->area >= 0 && isfinite(b->area);
}

/* Flags of parts that there are, and no fingerprint of another. */
static bool prints_hold(const ylm_grid_prints *p) {
  return p->known <= YLM_GRID_PRINT_ALL && (!p->geometry || p->known & YLM_GRID_PRINT_GEOMETRY) &&
         (!p->materials || p->known & YLM_GRID_PRINT_MATERIALS) &&
         (!p->lights || p->known & YLM_GRID_PRINT_LIGHTS);
}

ylm_status ylm__grid_check_form(const ylm_grid_form *f, ylm_error *e) {
  ylm_status s = check_bounds(f->bounds, e);
  if (s != YLM_OK) return s;
  if (f->lmax < 0 || f->lmax > 255)
    return ylm_fail(e, YLM_ERANGE, "lmax: 0 to 255, got %d", f->lmax);
  if (f->channels != 1 && f->channels != 3)
    return ylm_fail(e, YLM_EINVAL, "channels: 1 or 3, got %d", f->channels);
  bool none = f->metric_channels == 0 && (f->kind == YLM_GRID_UNIFORM || f->sides);
  if (f->metric_channels != 1 && !none && (f->metric_channels != 3 || f->channels != 3))
    return ylm_fail(e, YLM_EINVAL,
                    "metric_channels: 1, 3 where channels are 3, or 0 where the grid is uniform");
  if (f->measure != YLM_GRID_COEFFICIENTS && f->measure != YLM_GRID_IRRADIANCE)
    return ylm_fail(e, YLM_EINVAL, "measure: coefficients or irradiance");
  if ((int)f->quantity < 0 || f->quantity >= YLM_QUANTITY_COUNT)
    return ylm_fail(e, YLM_EINVAL, "quantity: lights, direct, indirect, all or visibility");
  if (!(f->floor >= 0 && isfinite(f->floor)))
    return ylm_fail(e, YLM_EDOMAIN, "floor: a number of at least 0, got %g", f->floor);
  if (!body_holds(&f->body))
    return ylm_fail(e, YLM_EDOMAIN, "body: a finite place, radius and area expected");
  if (!prints_hold(&f->prints))
    return ylm_fail(e, YLM_EINVAL, "fingerprints: of geometry, materials and lights expected");
  if (f->sides && f->dynamic)
    return ylm_fail(e, YLM_EINVAL, "dynamic: a grid with sides follows no lights");
  if (f->dynamic && (f->floor > 0 || f->measure != YLM_GRID_COEFFICIENTS))
    return ylm_fail(e, YLM_EINVAL,
                    "dynamic: a grid that follows lights has no floor, and a tolerance of "
                    "coefficients");
  if (f->kind == YLM_GRID_UNIFORM) return check_uniform(f, e);
  if (f->kind == YLM_GRID_ADAPTIVE) return check_adaptive(f, e);
  return ylm_fail(e, YLM_EINVAL, "kind: adaptive or uniform");
}

void ylm__grid_sync(ylm_grid *g) {
  ylm_grid_contents *v = &g->contents;
  v->cells = g->cells;
  v->cell = g->cell;
  v->points = g->points;
  v->evaluated = g->evaluated;
  v->lattice = g->lattice;
  v->stride = g->stride;
  v->rows = g->rows;
  v->data = g->data;
  v->lambda = g->lambda;
  v->norm = g->norm;
  v->flags = g->flags;
  v->validity = g->validity;
  v->birth = g->birth;
  v->sides = g->sides.n;
  v->side = g->sides.side;
  v->parts = g->sides.parts;
  v->node = (const uint32_t(*)[8])g->sides.node;
  v->asked = (const float(*)[3])g->sides.asked;
  v->origin = g->origin;
  v->stats = &g->stats;
}

ylm_grid *ylm__grid_new(const ylm_grid_form *form) {
  ylm_grid *g = ylm_alloc_zero(1, sizeof *g);
  if (!g) return NULL;
  g->contents.form = *form;
  g->contents.count = (form->lmax + 1) * (form->lmax + 1);
  g->width = (uint32_t)(g->contents.count * form->channels);
  g->stride = (g->width + 7) / 8 * 8;
  g->rows = form->sides ? 1 : 4;
  for (int a = 0; a < 3; a++) {
    g->contents.resolution[a] = form->kind == YLM_GRID_UNIFORM ? form->cells[a] : 1u << form->depth;
    g->last[a] = g->contents.resolution[a] - 1;
    g->scale[a] = g->contents.resolution[a] / (form->bounds[a + 3] - form->bounds[a]);
  }
  g->field.self = g;
  g->field.evaluate = ylm__grid_evaluate;
  g->field.quantity = form->quantity;
  g->field.relative = true;
  ylm_origin(form->bounds, g->origin);
  g->stats.error = g->stats.largest_error = NAN;
  if (form->dynamic) g->follower = &ylm__follower;
  ylm__grid_sync(g);
  return g;
}

void ylm__grid_set_root(ylm_grid *g, int level, const uint32_t origin[3]) {
  g->contents.root_level = level;
  for (int a = 0; a < 3; a++) {
    g->contents.root[a] = origin[a];
    g->last[a] = origin[a] + (1u << (g->contents.form.depth - level)) - 1;
  }
}

void ylm__grid_free_points(ylm_grid *g) {
  ylm_free(g->lattice);
  ylm_regrow_free(g->data, g->data_bytes);
  ylm_free(g->lambda);
  ylm_free(g->norm);
  ylm_free(g->flags);
  ylm_free(g->validity);
  ylm_free(g->sides.asked);
}

void ylm_grid_free(ylm_grid *g) {
  if (!g) return;
  ylm_free(g->cell);
  ylm__grid_free_points(g);
  ylm_free(g->table);
  ylm__lattice_hash_free(&g->hash);
  ylm_free(g->birth);
  ylm_free(g->frames);
  ylm_free(g->judge);
  ylm__grid_forget_panel(g);
  ylm__sides_free(&g->sides);
  if (g->follower) g->follower->free(g);
  ylm_free(g);
}

void ylm_grid_take(ylm_grid *g, ylm_grid *from) {
  ylm_grid before = *g;
  *g = *from;
  *from = before;
  g->field.self = g;
  from->field.self = from;
  ylm__grid_sync(g);
  ylm_grid_free(from);
}

ylm_status ylm__grid_reserve_cells(ylm_grid *g, size_t more) {
  size_t wanted = g->cells + more;
  if (wanted <= g->cell_room) return YLM_OK;
  if (wanted >= YLM_GRID_NONE) return YLM_ELIMIT;
  size_t room = g->cell_room * 2 > wanted ? g->cell_room * 2 : wanted;
  if (!ylm_list_resize(&g->cell, g->cells, room, sizeof *g->cell)) return YLM_ENOMEM;
  g->cell_room = room;
  return YLM_OK;
}

ylm_status ylm__grid_reserve_points(ylm_grid *g, size_t more) {
  size_t wanted = g->points + more, n = g->points;
  if (wanted <= g->point_room) return YLM_OK;
  if (wanted >= YLM_GRID_NONE) return YLM_ELIMIT;
  size_t room = g->point_room * 2 > wanted ? g->point_room * 2 : wanted;
  size_t record = ylm__grid_record(g) * sizeof(float), padding = ROW_PADDING * sizeof(float);
  if (room > SIZE_MAX / record - 1) return YLM_ENOMEM;
  float *data = ylm_regrow(g->data, g->data_bytes, room * record + padding);
  if (!data) return YLM_ENOMEM;
  g->data = data;
  g->data_bytes = room * record + padding;
  if (!ylm_list_resize(&g->lattice, n, room, 3 * sizeof *g->lattice) ||
      !ylm_list_resize(&g->lambda, n, room, sizeof *g->lambda) ||
      !ylm_list_resize(&g->norm, n, room, sizeof *g->norm) ||
      !ylm_list_resize(&g->flags, n, room, 1) ||
      (g->validity && !ylm_list_resize(&g->validity, n, room, sizeof *g->validity)) ||
      (g->contents.form.sides &&
       !ylm_list_resize(&g->sides.asked, n, room, sizeof *g->sides.asked)))
    return YLM_ENOMEM;
  g->point_room = room;
  return YLM_OK;
}

void ylm__grid_trim(ylm_grid *g) {
  size_t n = g->points, bytes = (n * ylm__grid_record(g) + ROW_PADDING) * sizeof(float);
  if (!n || n == g->point_room) return;
  float *data = ylm_regrow(g->data, g->data_bytes, bytes);
  if (!data) return;
  g->data = data;
  g->data_bytes = bytes;
  g->point_room = n; /* of all arrays, though the others may have more */
  ylm_list_resize(&g->lattice, n, n, 3 * sizeof *g->lattice);
  ylm_list_resize(&g->lambda, n, n, sizeof *g->lambda);
  ylm_list_resize(&g->norm, n, n, sizeof *g->norm);
  ylm_list_resize(&g->flags, n, n, 1);
  if (ylm_list_resize(&g->cell, g->cells, g->cells, sizeof *g->cell)) g->cell_room = g->cells;
  size_t born = n - g->evaluated;
  if (born && ylm_list_resize(&g->birth, born, born, sizeof *g->birth)) g->birth_room = born;
  ylm__grid_count(g);
  ylm__grid_sync(g);
}

ylm_status ylm__grid_split(ylm_grid *g, uint32_t cell, uint32_t *first) {
  ylm_status s = ylm__grid_reserve_cells(g, 8);
  if (s != YLM_OK) return s;
  ylm_grid_cell parent = g->cell[cell];
  uint32_t half = ylm__grid_edge(g, &parent) / 2;
  *first = (uint32_t)g->cells;
  for (uint32_t k = 0; k < 8; k++) {
    ylm_grid_cell c = {.level = (uint8_t)(parent.level + 1), .error = NAN, .residual = NAN};
    for (int a = 0; a < 3; a++) c.origin[a] = parent.origin[a] + (k >> a & 1 ? half : 0);
    for (int i = 0; i < 8; i++) c.corner[i] = YLM_GRID_NONE;
    g->cell[g->cells++] = c;
  }
  g->cell[cell].child = *first;
  return YLM_OK;
}

/* -- finishing --------------------------------------------------------------------- */

static bool has_corners(const ylm_grid_cell *c, size_t below) {
  for (int i = 0; i < 8; i++)
    if (c->corner[i] >= below) return false;
  return true;
}

void ylm__grid_find_baked(ylm_grid *g) {
  for (size_t i = 0; i < g->cells; i++) {
    ylm_grid_cell *c = &g->cell[i];
    c->flags &= (uint8_t)~YLM_GRID_BAKED;
    if (!(c->flags & YLM_GRID_ADDED) && has_corners(c, g->evaluated)) c->flags |= YLM_GRID_BAKED;
  }
}

/* Each cell's source: itself where it has its corners, else its parent's. */
static void find_sources(ylm_grid *g) {
  for (size_t i = 0; i < g->cells; i++) {
    ylm_grid_cell *c = &g->cell[i];
    bool root = i == 0 || g->contents.form.kind == YLM_GRID_UNIFORM || c->flags & YLM_GRID_SIDED;
    if (root || has_corners(c, g->points)) c->source = (uint32_t)i;
    for (uint32_t k = 0; c->child && k < 8; k++) g->cell[c->child + k].source = c->source;
  }
}

void ylm__grid_count(ylm_grid *g) {
  ylm_grid_stats *s = &g->stats;
  size_t octree = g->contents.octree_cells;
  s->points = g->evaluated;
  s->interpolated = g->points - g->evaluated;
  s->cells = octree;
  s->leaves = s->occupied = s->levels = s->continuity = s->invalid = s->tested = s->ghosts = 0;
  s->crossed_leaves = g->sides.n;
  s->parts = g->sides.parts;
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (i >= octree) {
      s->continuity += !c->child;
      continue;
    }
    if (c->flags & YLM_GRID_LEAF) s->leaves++;
    if ((c->flags & YLM_GRID_LEAF) && (c->flags & YLM_GRID_OCCUPIED)) s->occupied++;
    if (c->level + 1u > s->levels) s->levels = c->level + 1u;
  }
  for (size_t i = 0; i < g->evaluated; i++) {
    s->invalid += (g->flags[i] & YLM_GRID_POINT_INVALID) != 0;
    s->tested += (g->flags[i] & YLM_GRID_POINT_TESTED) != 0;
    s->ghosts += (g->flags[i] & YLM_GRID_POINT_GHOST) != 0;
  }
  s->bytes = g->hash.size * sizeof *g->hash.entry;
  size_t table = (size_t)g->top[0] * g->top[1] * g->top[2];
  s->bytes += g->cell_room * sizeof *g->cell + table * sizeof *g->table +
              g->point_room * (ylm__grid_record(g) * sizeof(float) + 3 * sizeof *g->lattice +
                               2 * sizeof(float) + 1);
  s->bytes += g->sides.n * sizeof *g->sides.side + g->sides.parts * sizeof *g->sides.node;
  if (g->contents.form.sides) s->bytes += g->point_room * sizeof *g->sides.asked;
  s->bytes += g->birth_room * sizeof *g->birth + (g->follower ? g->follower->bytes(g) : 0);
}

/* Writes a cell into the part of the table that it covers. */
static void cover(ylm_grid *g, uint32_t cell) {
  const ylm_grid_cell *c = &g->cell[cell];
  uint32_t n = ylm__grid_edge(g, c) >> g->top_shift, o[3];
  for (int a = 0; a < 3; a++) o[a] = c->origin[a] >> g->top_shift;
  for (uint32_t z = 0; z < n; z++)
    for (uint32_t y = 0; y < n; y++)
      for (uint32_t x = 0; x < n; x++)
        g->table[ylm__grid_table_index(g, o[0] + x, o[1] + y, o[2] + z) - g->table_first] = cell;
}

/* Voxels without data take the nearest (counted in faces) that has some. */
static ylm_status spread_table(ylm_grid *g) {
  size_t n = (size_t)g->top[0] * g->top[1] * g->top[2], head = 0, tail = 0;
  uint32_t *queue = ylm_alloc(n, sizeof *queue);
  if (!queue) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++)
    if (g->table[i] != YLM_GRID_NONE) queue[tail++] = (uint32_t)i;
  while (head < tail) {
    uint32_t i = queue[head++],
             at[3] = {i % g->top[0], i / g->top[0] % g->top[1], i / g->top[0] / g->top[1]};
    size_t step[3] = {1, g->top[0], (size_t)g->top[0] * g->top[1]};
    for (int a = 0; a < 3; a++)
      for (int way = 0; way < 2; way++) {
        if (way ? at[a] + 1 >= g->top[a] : at[a] == 0) continue;
        size_t k = way ? i + step[a] : i - step[a];
        if (g->table[k] != YLM_GRID_NONE) continue;
        g->table[k] = g->table[i];
        queue[tail++] = (uint32_t)k;
      }
  }
  ylm_free(queue);
  return YLM_OK;
}

ylm_status ylm__grid_build_table(ylm_grid *g) {
  bool uniform = g->contents.form.kind == YLM_GRID_UNIFORM;
  int level = 0, root = g->contents.root_level, shift;
  if (!uniform)
    while (root + level < g->contents.form.depth && level < MAX_TABLE_LEVEL &&
           (size_t)1 << 3 * level < 2 * g->cells)
      level++;
  g->top_shift = shift = uniform ? 0 : g->contents.form.depth - root - level;
  for (int a = 0; a < 3; a++) g->top[a] = uniform ? g->contents.resolution[a] : 1u << level;
  const uint32_t *o = g->contents.root;
  g->table_first = ylm__grid_table_index(g, o[0] >> shift, o[1] >> shift, o[2] >> shift);
  size_t n = (size_t)g->top[0] * g->top[1] * g->top[2];
  uint32_t *table = ylm_alloc(n, sizeof *table);
  if (!table) return YLM_ENOMEM;
  ylm_free(g->table);
  g->table = table;
  for (size_t i = 0; i < n; i++) g->table[i] = YLM_GRID_NONE;
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (uniform || c->level == root + level || (c->level < root + level && !c->child))
      cover(g, (uint32_t)i);
  }
  return uniform ? spread_table(g) : YLM_OK;
}

ylm_status ylm__grid_finish(ylm_grid *g) {
  ylm__grid_find_baked(g);
  find_sources(g);
  ylm_status s = ylm__grid_build_table(g);
  if (s == YLM_OK && g->contents.form.sides) s = ylm__sides_index(g);
  if (s != YLM_OK) return s;
  ylm__grid_count(g);
  ylm__grid_sync(g);
  return YLM_OK;
}

/* -- finding ------------------------------------------------------------------------ */

/* Moves lattice coordinates into a brick; true if they were inside. */
static bool clamp_to_brick(const ylm_grid *g, double at[3]) {
  bool inside = true;
  for (int a = 0; a < 3; a++) {
    double lo = g->contents.root[a], hi = (double)g->last[a] + 1;
    inside &= at[a] >= lo && at[a] <= hi;
    at[a] = at[a] < lo ? lo : at[a] > hi ? hi : at[a];
  }
  return inside;
}

bool ylm__grid_coordinates(const ylm_grid *g, const double p[3], double out[3]) {
  const double *b = g->contents.form.bounds;
  bool inside = true;
  for (int a = 0; a < 3; a++) {
    inside &= within(p[a], b[a], b[a + 3]);
    out[a] = lattice_coordinate(p[a], b[a], b[a + 3], g->scale[a], g->contents.resolution[a]);
  }
  return g->contents.root_level ? clamp_to_brick(g, out) && inside : inside;
}

uint32_t ylm__grid_leaf(const ylm_grid *g, const double at[3]) {
  uint32_t c[3];
  for (int a = 0; a < 3; a++) {
    uint32_t i = (uint32_t)at[a];
    c[a] = i > g->last[a] ? g->last[a] : i;
  }
  return ylm__grid_finest(g, c);
}

const ylm_grid_contents *ylm_grid_look(const ylm_grid *g) { return &g->contents; }

void ylm_grid_position(const ylm_grid *g, const uint32_t lattice[3], double out[3]) {
  const double *b = g->contents.form.bounds;
  for (int a = 0; a < 3; a++) {
    uint32_t n = g->contents.resolution[a];
    out[a] = lattice[a] >= n ? b[a + 3] : b[a] + (b[a + 3] - b[a]) * ((double)lattice[a] / n);
  }
}

void ylm_grid_box(const ylm_grid *g, size_t cell, double out[6]) {
  const ylm_grid_cell *c = &g->cell[cell];
  uint32_t edge = ylm__grid_edge(g, c), far[3];
  for (int a = 0; a < 3; a++) far[a] = c->origin[a] + edge;
  ylm_grid_position(g, c->origin, out);
  ylm_grid_position(g, far, out + 3);
}

uint32_t ylm_grid_locate(const ylm_grid *g, const double p[3], bool finest, bool *outside) {
  double at[3];
  bool inside = ylm__grid_coordinates(g, p, at);
  if (outside) *outside = !inside;
  if (finest || g->contents.form.kind == YLM_GRID_UNIFORM) {
    uint32_t leaf = ylm__grid_leaf(g, at);
    if (g->contents.form.kind == YLM_GRID_ADAPTIVE) return leaf;
    for (int a = 0; a < 3; a++) {
      uint32_t i =
          (uint32_t)at[a] == g->contents.resolution[a] ? (uint32_t)at[a] - 1 : (uint32_t)at[a];
      if (i != g->cell[leaf].origin[a]) return YLM_GRID_NONE;
    }
    return leaf;
  }
  uint32_t cell = 0;
  while (!(g->cell[cell].flags & YLM_GRID_LEAF)) {
    int shift = g->contents.form.depth - g->cell[cell].level - 1;
    uint32_t i[3];
    for (int a = 0; a < 3; a++)
      i[a] = (uint32_t)at[a] > g->last[a] ? (uint32_t)at[a] - 1 : (uint32_t)at[a];
    cell = g->cell[cell].child + octant_of(i[0], i[1], i[2], (uint32_t)shift);
  }
  return cell;
}
