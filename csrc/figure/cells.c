/* cells.c - edges and faces of a grid's boxes. */
#include "shape.h"

#include <math.h>
#include <string.h>

/* -- a set of edges on the lattice of the smallest cells ------------------------ */

typedef struct edge {
  int32_t at[3];
  int16_t axis, level; /* axis -1: an empty slot */
} edge;

typedef struct edge_set {
  edge *slot;
  size_t room, used; /* room is a power of two */
} edge_set;

static uint64_t hash(const edge *e) {
  uint64_t h = 0x9E3779B97F4A7C15u;
  h = (h ^ (uint32_t)e->at[0]) * 0xBF58476D1CE4E5B9u;
  h = (h ^ (uint32_t)e->at[1] ^ h >> 29) * 0x94D049BB133111EBu;
  h = (h ^ (uint32_t)e->at[2] ^ h >> 31) * 0xBF58476D1CE4E5B9u;
  h ^= (uint64_t)(e->axis + 4 * e->level);
  h *= 0x94D049BB133111EBu;
  return h ^ h >> 32;
}

static bool same(const edge *a, const edge *b) { return memcmp(a, b, sizeof *a) == 0; }

/* The slot that holds e, or the empty one where it would go. */
static edge *find(const edge_set *set, const edge *e) {
  size_t k = (size_t)hash(e) & (set->room - 1);
  while (set->slot[k].axis >= 0 && !same(&set->slot[k], e)) k = (k + 1) & (set->room - 1);
  return &set->slot[k];
}

static bool set_init(edge_set *set, size_t room) {
  set->room = 64;
  set->used = 0;
  while (set->room < room) set->room *= 2;
  set->slot = ylm_alloc(set->room, sizeof(edge));
  for (size_t i = 0; set->slot && i < set->room; i++) set->slot[i].axis = -1;
  return set->slot != NULL;
}

static bool set_grow(edge_set *set) {
  edge_set larger;
  if (!set_init(&larger, set->room * 2)) return false;
  for (size_t i = 0; i < set->room; i++)
    if (set->slot[i].axis >= 0) *find(&larger, &set->slot[i]) = set->slot[i];
  larger.used = set->used;
  ylm_free(set->slot);
  *set = larger;
  return true;
}

static bool insert(edge_set *set, const edge *e) {
  if (set->used * 2 >= set->room && !set_grow(set)) return false;
  edge *slot = find(set, e);
  if (slot->axis < 0) *slot = *e, set->used++;
  return true;
}

/* Does the set hold an edge of a coarser level that covers e? */
static bool covered(const edge_set *set, const edge *e, int deepest) {
  for (int level = e->level - 1; level >= 0; level--) {
    edge c = *e;
    int step = 1 << (deepest - level);
    c.level = (int16_t)level;
    c.at[c.axis] -= ((c.at[c.axis] % step) + step) % step;
    if (find(set, &c)->axis >= 0) return true;
  }
  return false;
}

/* -- edges ------------------------------------------------------------------------ */

static int level_of(const ylm_figure_cells *cells, size_t i) {
  double l = cells->level ? cells->level[i] : 0;
  return l > 0 ? (l < 20 ? (int)l : 20) : 0;
}

static bool is_drawn(const ylm_figure_cells *cells, size_t i) {
  return !cells->drawn || cells->drawn[i] != 0;
}

/* Extent of the cells, their deepest level, and the size of a cell at it. */
static bool lattice(const ylm_figure_cells *cells, double origin[3], double unit[3], int *deepest) {
  bool any = false;
  *deepest = 0;
  for (size_t i = 0; i < cells->n; i++) {
    if (!is_drawn(cells, i)) continue;
    for (int a = 0; a < 3; a++) {
      double x = cells->origin[3 * i + (size_t)a];
      if (!any || x < origin[a]) origin[a] = x;
    }
    int l = level_of(cells, i);
    if (!any || l > *deepest) {
      *deepest = l;
      memcpy(unit, cells->size + 3 * i, 3 * sizeof *unit);
    }
    any = true;
  }
  return any;
}

/* Puts the twelve edges of cell i into the set. */
static bool collect(edge_set *set, const ylm_figure_cells *cells, size_t i, const double origin[3],
                    const double unit[3], int deepest) {
  int level = level_of(cells, i);
  int32_t at[3], step = 1 << (deepest - level);
  for (int a = 0; a < 3; a++)
    at[a] = (int32_t)lrint((cells->origin[3 * i + (size_t)a] - origin[a]) / unit[a]);
  for (int k = 0; k < 12; k++) {
    edge e;
    int axis = k / 4, u = (axis + 1) % 3, v = (axis + 2) % 3;
    memset(&e, 0, sizeof e);
    memcpy(e.at, at, sizeof at);
    e.at[u] += k & 1 ? step : 0;
    e.at[v] += k & 2 ? step : 0;
    e.axis = (int16_t)axis;
    e.level = (int16_t)level;
    if (!insert(set, &e)) return false;
  }
  return true;
}

ylm_status ylm_figure_add_edges(ylm_figure_shape *s, const ylm_figure_cells *cells, size_t levels,
                                const double *colours) {
  double origin[3] = {0, 0, 0}, unit[3] = {1, 1, 1};
  int deepest;
  if (levels == 0 || !lattice(cells, origin, unit, &deepest)) return YLM_OK;
  edge_set set;
  if (!set_init(&set, 1024)) return YLM_ENOMEM;
  ylm_status status = YLM_OK;
  for (size_t i = 0; i < cells->n && status == YLM_OK; i++)
    if (is_drawn(cells, i) && !collect(&set, cells, i, origin, unit, deepest)) status = YLM_ENOMEM;
  for (size_t i = 0; i < set.room && status == YLM_OK; i++) {
    const edge *e = &set.slot[i];
    if (e->axis < 0 || covered(&set, e, deepest)) continue;
    double from[3], to[3];
    for (int a = 0; a < 3; a++) from[a] = to[a] = origin[a] + unit[a] * e->at[a];
    to[e->axis] += unit[e->axis] * (1 << (deepest - e->level));
    size_t l = (size_t)e->level < levels ? (size_t)e->level : levels - 1;
    status = ylm_figure_add_segments(s, 1, from, to, colours + 4 * l);
  }
  ylm_free(set.slot);
  return status;
}

/* -- faces -------------------------------------------------------------------------- */

/* One box of 6 faces with their own normals. */
static void box(ylm_figure_shape *s, const double lo[3], const double hi[3], const double rgb[3],
                double opacity) {
  for (int axis = 0; axis < 3; axis++)
    for (int side = 0; side < 2; side++) {
      int u = (axis + 1) % 3, v = (axis + 2) % 3;
      double n[3] = {0, 0, 0}, p[3];
      uint32_t first = (uint32_t)s->points;
      n[axis] = side ? 1 : -1;
      for (int k = 0; k < 4; k++) {
        p[axis] = side ? hi[axis] : lo[axis];
        p[u] = (k == 1 || k == 2) ? hi[u] : lo[u];
        p[v] = k >= 2 ? hi[v] : lo[v];
        ylm__figure_point(s, p, n, rgb, opacity);
      }
      uint32_t b = first + (side ? 1 : 2), c = first + (side ? 2 : 1);
      uint32_t d = first + (side ? 2 : 3), f = first + (side ? 3 : 2);
      ylm__figure_triangle(s, first, b, c);
      ylm__figure_triangle(s, first, d, f);
    }
}

ylm_status ylm_figure_add_boxes(ylm_figure_shape *s, const ylm_figure_cells *cells,
                                const double *colour, double shrink, double opacity) {
  size_t n = 0;
  for (size_t i = 0; i < cells->n; i++) n += is_drawn(cells, i);
  if (n > UINT32_MAX / 24) return YLM_EOVERFLOW;
  ylm_status status = ylm__figure_reserve(s, n * 24, n * 12);
  if (status != YLM_OK) return status;
  for (size_t i = 0; i < cells->n; i++) {
    if (!is_drawn(cells, i)) continue;
    double lo[3], hi[3];
    for (size_t a = 0; a < 3; a++) {
      double o = cells->origin[3 * i + a], d = cells->size[3 * i + a];
      lo[a] = o + d * shrink / 2;
      hi[a] = o + d * (1 - shrink / 2);
    }
    box(s, lo, hi, colour + 3 * i, opacity);
  }
  return YLM_OK;
}
