/*
** cells.c - what a point sees: a ray for each cell of the lattice, and sixteen more where the light of neighbours
** differs.
**
** The lattice is never turned, so that what it misses changes slowly from point to point. A point's rays are
** traced by themselves: what it sees does not depend on the points that are asked with it.
*/
#include "calibration.h"
#include "gather.h"

static size_t most_splits(const gather_lattice *l) {
  return (size_t)(CELLS_ROUND * (double)l->cells) / 16;
}

size_t ylm__gather_most(const gather_lattice *l) {
  return l->cells + 16 * most_splits(l) * (size_t)l->levels;
}

gather_sight *ylm__gather_sight_create(const ylm_gather *g) {
  gather_sight *v = ylm_alloc_zero(1, sizeof *v);
  size_t n = g->most;
  if (!v) return NULL;
  v->g = g;
  v->cell = ylm_alloc(n, sizeof *v->cell);
  v->place = ylm_alloc(n, sizeof *v->place);
  v->toward = ylm_alloc(n, sizeof *v->toward);
  v->radiance = ylm_alloc(n, sizeof *v->radiance);
  v->split = ylm_alloc(n / 16 + 1, sizeof *v->split);
  v->contrast = ylm_alloc(n, sizeof *v->contrast);
  v->sorted = ylm_alloc(n, sizeof *v->sorted);
  if (v->cell && v->place && v->toward && v->radiance && v->split && v->contrast && v->sorted)
    return v;
  ylm__gather_sight_free(v);
  return NULL;
}

void ylm__gather_sight_free(gather_sight *v) {
  if (!v) return;
  ylm_free(v->cell);
  ylm_free(v->place);
  ylm_free(v->toward);
  ylm_free(v->radiance);
  ylm_free(v->split);
  ylm_free(v->contrast);
  ylm_free(v->sorted);
  ylm_free(v);
}

/* -- light ------------------------------------------------------------------------------------- */

/* The one place where light comes from: radiance of cells first .. first+n-1. */
static void shine(gather_sight *v, size_t first, size_t n) {
  const ylm_gather *g = v->g;
  const float(*leaving)[4] = (const float(*)[4])ylm_radiosity_leaving(g->radiosity);
  bool sky = ylm__gather_sky_cell(g->lamps, 0) != NULL,
       indirect = g->form.parts & YLM_GATHER_INDIRECT;
  for (size_t i = first; i < first + n; i++) {
    uint32_t element = v->cell[i].element;
    float *to = v->radiance[i];
    memcpy(to, leaving[indirect && element < g->elements ? element : g->elements], 16);
    if (sky && element == g->elements) {
      if (i < g->lattice.cells)
        memcpy(to, ylm__gather_sky_cell(g->lamps, i), 12);
      else
        ylm__gather_sky(g->lamps, v->toward[i], to);
    }
    to[3] = 1 / fmaxf(v->cell[i].distance, g->spacing);
  }
}

static float angle_of(const gather_sight *v, size_t i) {
  return i < v->g->lattice.cells ? v->g->lattice.angle[i] : v->toward[i][3];
}

/* Where all cells are alike exactly their radiance. */
static void find_mean(gather_sight *v) {
  double sum[3] = {0, 0, 0};
  const float *first = NULL;
  for (size_t i = 0; i < v->cells; i++) {
    if (ylm__gather_is_split(&v->cell[i])) continue;
    if (!first) first = v->radiance[i];
    for (int c = 0; c < 3; c++) sum[c] += (double)(angle_of(v, i) * (v->radiance[i][c] - first[c]));
  }
  for (int c = 0; c < 3; c++) v->mean[c] = first[c] + (float)(sum[c] / (4 * YLM_PI));
}

/* -- rays -------------------------------------------------------------------------------------- */

/* Traces rays of cells first .. first+n-1. */
static void trace(gather_sight *v, size_t first, size_t n) {
  const ylm_gather *g = v->g;
  const ylm_trace *scene = ylm_scene_trace(g->scene);
  ylm_trace_ray ray[CELLS_RAYS];
  ylm_trace_hit hit[CELLS_RAYS];
  uint32_t number[CELLS_RAYS];
  const float *leaving = ylm_radiosity_leaving(g->radiosity);
  for (size_t begin = first; begin < first + n; begin += CELLS_RAYS) {
    size_t rays = first + n - begin < CELLS_RAYS ? first + n - begin : CELLS_RAYS;
    for (size_t i = 0; i < rays; i++) {
      size_t cell = begin + i;
      memcpy(ray[i].org, v->at, 12);
      ray[i].near = 0;
      ray[i].far = INFINITY;
      memcpy(ray[i].dir, cell < g->lattice.cells ? g->lattice.direction[cell] : v->toward[cell],
             12);
    }
    ylm_trace_nearest(scene, rays, ray, false, hit);
    ylm_transfer_hits(g->transfer, rays, ray, hit, number);
    for (size_t i = 0; i < rays; i++) {
      v->cell[begin + i] = (gather_cell){number[i], hit[i].t};
      if (number[i] < g->elements) {
        __builtin_prefetch(leaving + 4 * (size_t)number[i]);
        if (g->normal) __builtin_prefetch(g->normal[number[i]]);
      }
    }
  }
  v->rays += n;
}

void ylm__gather_glance(gather_sight *v, const float at[3]) {
  const gather_lattice *l = &v->g->lattice;
  double buried = 0;
  memcpy(v->at, at, 12);
  v->splits = 0;
  v->cells = l->cells;
  trace(v, 0, l->cells);
  for (size_t i = 0; i < l->cells; i++)
    if (v->cell[i].element > v->g->elements) buried += (double)l->angle[i];
  v->buried = (float)(buried / (4 * YLM_PI));
}

/* -- borders ----------------------------------------------------------------------------------- */

/* Of the children of a cell, the one at quarter q of an edge. */
static uint32_t child_at(const gather_cell *c, int side, uint32_t q) {
  uint32_t first = ylm__gather_children(c);
  switch (side) {
  case LEAST_U: return first + 4 * q;
  case MOST_U: return first + 4 * q + 3;
  case LEAST_V: return first + q;
  default: return first + 12 + q;
  }
}

gather_border ylm__gather_quarter(const gather_sight *v, const gather_border *b, uint32_t q) {
  const gather_cell *low = &v->cell[b->low], *high = &v->cell[b->high];
  gather_border part = *b;
  part.size /= 4;
  part.from = (uint16_t)(b->from + q * part.size);
  if (ylm__gather_is_split(low)) part.low = child_at(low, b->side_low, q);
  if (ylm__gather_is_split(high)) part.high = child_at(high, b->side_high, q);
  return part;
}

/* The borders of the children of a cell with each other. */
static void visit_inside(gather_sight *v, uint32_t cell, gather_visit *visit, void *context) {
  gather_place p = v->place[cell];
  uint32_t first = ylm__gather_children(&v->cell[cell]);
  size_t size = v->g->lattice.fine / (size_t)v->g->lattice.base >> 2 * (p.level + 1);
  for (uint8_t across = 0; across < 2; across++)
    for (uint32_t k = 1; k < 4; k++) {
      size_t line = 4 * (size_t)(across ? p.j : p.i) + k, from = 4 * (size_t)(across ? p.i : p.j);
      gather_border b[4];
      for (uint32_t q = 0; q < 4; q++) {
        uint32_t high = first + (across ? 4 * k + q : 4 * q + k);
        b[q] = (gather_border){.low = high - (across ? 4 : 1),
                               .high = high,
                               .line = (uint16_t)(line * size),
                               .from = (uint16_t)((from + q) * size),
                               .size = (uint16_t)size,
                               .face = p.face,
                               .across = across,
                               .side_low = across ? MOST_V : MOST_U,
                               .side_high = across ? LEAST_V : LEAST_U};
      }
      visit(v, 4, b, NULL, context);
    }
}

void ylm__gather_borders(gather_sight *v, gather_visit *visit, void *context) {
  const gather_lattice *l = &v->g->lattice;
  for (size_t i = 0; i < l->borders; i++) visit(v, 1, &l->border[i], &l->line[i], context);
  for (size_t i = 0; i < v->splits; i++) visit_inside(v, v->split[i], visit, context);
}

/* -- splitting --------------------------------------------------------------------------------- */

static inline float larger(float a, float b) { return a > b ? a : b; }

static void compare(gather_sight *v, const gather_border *b) {
  const float *x = v->radiance[b->low], *y = v->radiance[b->high];
  float d = fabsf(x[0] - y[0]) + fabsf(x[1] - y[1]) + fabsf(x[2] - y[2]);
  v->contrast[b->low] = larger(v->contrast[b->low], d);
  v->contrast[b->high] = larger(v->contrast[b->high], d);
}

static void compare_parts(gather_sight *v, int n, const gather_border *b, const gather_line *line,
                          void *context) {
  for (int i = 0; i < n; i++) {
    if (!ylm__gather_is_parted(v, &b[i]))
      compare(v, &b[i]);
    else
      for (uint32_t q = 0; q < 4; q++) {
        gather_border part = ylm__gather_quarter(v, &b[i], q);
        compare_parts(v, 1, &part, line, context);
      }
  }
}

static bool may_split(const gather_sight *v, size_t i) {
  return !ylm__gather_is_split(&v->cell[i]) && v->place[i].level < v->g->lattice.levels;
}

/* Puts the k-th largest of n numbers at x[k], larger ones before it. */
static void select(float *x, size_t n, size_t k) {
  for (size_t first = 0, last = n - 1; first < last;) {
    float pivot = x[(first + last) / 2];
    size_t i = first, j = last;
    while (i <= j) {
      while (x[i] > pivot) i++;
      while (x[j] < pivot) j--;
      if (i > j) break;
      float swap = x[i];
      x[i++] = x[j];
      x[j] = swap;
      if (j == 0) break;
      j--;
    }
    if (k <= j && j < last)
      last = j;
    else if (k >= i)
      first = i;
    else
      return;
  }
}

/* The contrast above which cells are split: `least`, or more where there are more than `most`. */
static float threshold_of(gather_sight *v, float least, size_t most) {
  size_t n = 0;
  float *found = v->sorted;
  for (size_t i = 0; i < v->cells; i++)
    if (v->contrast[i] > least && may_split(v, i)) found[n++] = v->contrast[i];
  if (n <= most) return least;
  select(found, n, most);
  return found[most];
}

void ylm__gather_place_children(gather_sight *v, size_t i, size_t first) {
  gather_place p = v->place[i];
  for (size_t k = 0; k < 16; k++)
    v->place[first + k] = (gather_place){p.face, (uint8_t)(p.level + 1),
                                         (uint16_t)(4 * p.i + k % 4), (uint16_t)(4 * p.j + k / 4)};
  ylm__gather_children_of(&v->g->lattice, p, v->toward + first);
}

/* Makes room for the children of cell i. */
static void split(gather_sight *v, size_t i) {
  ylm__gather_place_children(v, i, v->cells);
  v->cell[i].element = GATHER_SPLIT | (uint32_t)v->cells;
  v->split[v->splits++] = (uint32_t)i;
  v->cells += 16;
}

/* Splits cells whose light differs from a neighbour's; false: there was none. */
static bool refine(gather_sight *v) {
  size_t before = v->cells, most = most_splits(&v->g->lattice);
  float least = (float)v->g->form.contrast * (v->mean[0] + v->mean[1] + v->mean[2]);
  ylm_zero(v->contrast, v->cells * sizeof *v->contrast);
  ylm__gather_borders(v, compare_parts, NULL);
  float threshold = threshold_of(v, least, most);
  for (size_t i = 0; i < before; i++)
    if (v->contrast[i] > threshold && may_split(v, i)) split(v, i);
  if (v->cells == before) return false;
  trace(v, before, v->cells - before);
  shine(v, before, v->cells - before);
  return true;
}

static void look(gather_sight *v, const float at[3]) {
  ylm__gather_glance(v, at);
  shine(v, 0, v->cells);
  find_mean(v);
  for (int k = 0; k < v->g->lattice.levels && refine(v); k++) {
  }
  if (v->splits) find_mean(v);
}

ylm_status ylm__gather_look(gather_sight *v, const float at[3]) {
  const gather_lattice *l = &v->g->lattice;
  size_t n = (size_t)l->base;
  v->rays = 0;
  for (size_t i = 0; i < l->cells; i++)
    v->place[i] =
        (gather_place){(uint8_t)(i / (n * n)), 0, (uint16_t)(i % n), (uint16_t)(i / n % n)};
  memcpy(v->at, at, 12);
  if (!v->g->memory) {
    look(v, at);
    return YLM_OK;
  }
  if (!ylm__gather_recall(v->g->memory, v)) {
    look(v, at);
    return ylm__gather_keep(v->g->memory, v);
  }
  shine(v, 0, v->cells);
  find_mean(v);
  return YLM_OK;
}
