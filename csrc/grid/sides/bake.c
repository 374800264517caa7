/* bake.c - a bake of a grid with sides: cuts new leaves, evaluates the points at their corners, and finishes. */
#include "sides.h"

#include "ylm_list.h"

#include <math.h>
#include <string.h>

/* -- cutting ------------------------------------------------------------------------------------- */

/* Leaves that are cut together. */
typedef struct cut_job {
  const side_baker *k;
  const uint32_t *leaf;
  ylm_grid_side *side; /* [n] cell YLM_GRID_NONE: no surface crosses it */
  part_view *view;     /* [n][YLM_GRID_PARTS] */
  uint64_t *joined;    /* [n] */
} cut_job;

/* Does a surface cross a leaf? */
static bool is_crossed(const ylm_grid *g, const ylm_grid_walls *w, uint32_t leaf) {
  double box[6];
  ylm_grid_box(g, leaf, box);
  for (int a = 0; a < 3; a++) {
    double more = SIDES_MARGIN * (box[a + 3] - box[a]), from = w->origin[a];
    box[a] -= more + from;
    box[a + 3] += more - from;
  }
  return w->meets(w->self, box);
}

/* Does a leaf that no surface crosses lie in a body? */
static bool is_buried(const ylm_grid *g, const ylm_grid_walls *w, uint32_t leaf) {
  double box[6];
  float middle[3];
  ylm_grid_box(g, leaf, box);
  for (int a = 0; a < 3; a++) middle[a] = (float)(0.5 * (box[a] + box[a + 3]) - w->origin[a]);
  return place_buried(g, w, middle);
}

static ylm_status cut_leaves(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const cut_job *j = context;
  const ylm_grid *g = j->k->b->g;
  const ylm_grid_walls *w = j->k->b->source->walls;
  for (size_t i = begin; i < end; i++) {
    j->side[i].cell = YLM_GRID_NONE;
    j->joined[i] = 0;
    if (is_crossed(g, w, j->leaf[i]))
      j->joined[i] = ylm__side_cut(g, w, j->leaf[i], &j->side[i], j->view + i * YLM_GRID_PARTS);
    else if (is_buried(g, w, j->leaf[i])) {
      j->side[i] = (ylm_grid_side){.cell = j->leaf[i]};
      memset(j->side[i].part, 0xff, sizeof j->side[i].part);
    }
  }
  return YLM_OK;
}

/* Sides that were cut join those of the grid. */
static ylm_status keep_sides(side_baker *k, size_t n, const cut_job *j) {
  ylm_grid *g = k->b->g;
  grid_sides *s = &g->sides;
  for (size_t i = 0; i < n; i++) {
    ylm_grid_side *side = &j->side[i];
    k->row[j->leaf[i]] = side->cell == YLM_GRID_NONE ? (uint32_t)ROW_OPEN : (uint32_t)s->n;
    if (side->cell == YLM_GRID_NONE) continue;
    size_t parts = s->parts + side->parts;
    if (parts >= YLM_GRID_NONE) return YLM_ELIMIT;
    if (!ylm_list_reserve(&s->side, s->n, s->n + 1, &s->room, sizeof *s->side) ||
        !ylm_list_reserve(&s->node, s->parts, parts, &s->part_room, sizeof *s->node) ||
        !ylm_list_reserve(&k->view, s->parts, parts, &k->view_room, sizeof *k->view))
      return YLM_ENOMEM;
    side->first = (uint32_t)s->parts;
    ylm_copy(k->view + s->parts, j->view + i * YLM_GRID_PARTS, side->parts * sizeof *k->view);
    s->parts = parts;
    s->side[s->n++] = *side;
    g->cell[side->cell].flags |= YLM_GRID_SIDED;
    g->stats.joined += j->joined[i];
  }
  return YLM_OK;
}

/* Rows of cells that are new: unknown. */
static ylm_status extend_rows(side_baker *k) {
  size_t n = k->b->g->cells;
  if (!ylm_list_reserve(&k->row, k->rows, n, &k->row_room, sizeof *k->row)) return YLM_ENOMEM;
  for (; k->rows < n; k->rows++) k->row[k->rows] = ROW_UNKNOWN;
  return YLM_OK;
}

/* Looks at leaves that are new, `most` at a time. */
static ylm_status cut_new(side_baker *k) {
  enum { MOST = 4096 };
  const ylm_grid *g = k->b->g;
  uint32_t *leaf = ylm_alloc(MOST, sizeof *leaf);
  cut_job j = {k, leaf, ylm_alloc(MOST, sizeof *j.side),
               ylm_alloc(MOST * YLM_GRID_PARTS, sizeof *j.view), ylm_alloc(MOST, sizeof *j.joined)};
  bool ok = leaf && j.side && j.view && j.joined;
  ylm_status s = ok ? extend_rows(k) : YLM_ENOMEM;
  const char *before = k->b->stage;
  k->b->stage = "sides";
  for (size_t i = 0; s == YLM_OK && i < g->cells;) {
    size_t n = 0;
    for (; i < g->cells && n < MOST; i++)
      if (g->cell[i].flags & YLM_GRID_LEAF && k->row[i] == ROW_UNKNOWN) leaf[n++] = (uint32_t)i;
    s = ylm_parallel(n, SIDES_GRAIN, k->b->source->threads, cut_leaves, &j, k->b->making.progress,
                     "sides");
    if (s == YLM_OK) s = keep_sides(k, n, &j);
  }
  k->b->stage = before;
  ylm_free(leaf);
  ylm_free(j.side);
  ylm_free(j.view);
  ylm_free(j.joined);
  return s;
}

ylm_status ylm__sides_renew(side_baker *k) {
  ylm_grid *g = k->b->g;
  ylm_status s = cut_new(k);
  if (s == YLM_OK) s = ylm__sides_find_nodes(k);
  if (s == YLM_OK) s = ylm__backend_evaluate(k->b, g->points - g->evaluated);
  return s;
}

/* -- by a threshold -------------------------------------------------------------------------------- */

/* The metric of a leaf: the largest of its parts'. */
static float metric_of(const baker *b, const ylm_grid_side *side, const ylm_grid_cell *c) {
  ylm_grid_metric metric = b->g->contents.form.metric;
  if (!side) return ylm__metric_of(b, c, metric);
  float worst = side->parts ? 0 : NAN;
  for (uint32_t p = side->first; p < side->first + side->parts; p++) {
    ylm_grid_cell part = *c;
    memcpy(part.corner, b->g->sides.node[p], sizeof part.corner);
    worst = fmaxf(worst, ylm__metric_of(b, &part, metric));
  }
  return worst;
}

/* Finds the metric of the wave's leaves; those above the threshold are split. */
static ylm_status split_wave(side_baker *k) {
  baker *b = k->b;
  ylm_grid *g = b->g;
  const ylm_grid_form *f = &g->contents.form;
  ylm_status s = YLM_OK;
  for (size_t i = 0; s == YLM_OK && i < b->wave.n; i++) {
    uint32_t cell = b->wave.cell[i], row = k->row[cell];
    ylm_grid_cell *c = &g->cell[cell];
    c->error = metric_of(b, row == ROW_OPEN ? NULL : &g->sides.side[row], c);
    if (f->kind == YLM_GRID_ADAPTIVE && c->level < f->depth &&
        cell_splits((double)c->error, f->threshold, false))
      s = ylm__sides_split(k, cell);
  }
  ylm__cells_advance(b);
  return s;
}

ylm_status ylm__sides_split(side_baker *k, uint32_t cell) {
  ylm_grid *g = k->b->g;
  ylm_status s = extend_rows(k);
  uint32_t row = s == YLM_OK ? k->row[cell] : (uint32_t)ROW_UNKNOWN;
  if (s == YLM_OK) s = ylm__cells_split(k->b, cell);
  if (s == YLM_OK) s = extend_rows(k);
  if (s != YLM_OK) return s;
  g->cell[cell].flags &= (uint8_t)~YLM_GRID_SIDED;
  for (uint32_t c = g->cell[cell].child; c < g->cell[cell].child + 8; c++) {
    g->cell[c].flags &= (uint8_t)~YLM_GRID_CROSSED;
    if (row == ROW_OPEN) k->row[c] = ROW_OPEN;
  }
  return YLM_OK;
}

static ylm_status refine(side_baker *k) {
  baker *b = k->b;
  ylm_status s = YLM_OK;
  for (int level = 0; s == YLM_OK && b->wave.n; level++) {
    snprintf(b->stage_text, sizeof b->stage_text, "level %d", level);
    s = ylm__sides_renew(k);
    if (s == YLM_OK) s = split_wave(k);
  }
  return s;
}

/* -- begin and end --------------------------------------------------------------------------------- */

ylm_status ylm__sides_finish(side_baker *k) {
  baker *b = k->b;
  ylm_grid *g = b->g;
  ylm_status s = ylm__sides_compact(k);
  if (s != YLM_OK) return s;
  g->contents.octree_cells = g->cells;
  s = ylm__sides_index(g);
  if (s == YLM_OK) s = ylm__grid_fill_invalid(g);
  ylm__grid_find_baked(g);
  double t = ylm_seconds();
  if (s == YLM_OK && g->contents.form.kind == YLM_GRID_ADAPTIVE && g->contents.form.continuous)
    s = ylm__grid_make_continuous(g, b->source->threads, b->making.progress);
  g->stats.continuity_seconds += ylm_seconds() - t;
  return s == YLM_OK ? ylm__grid_finish(g) : s;
}

ylm_status ylm__sides_bake(baker *b) {
  side_baker k = {.b = b};
  ylm_grid *g = b->g;
  for (size_t i = 0; i < g->cells; i++) g->cell[i].flags &= (uint8_t)~YLM_GRID_CROSSED;
  ylm_status s;
  if (g->contents.form.tolerance > 0)
    s = ylm__pool_bake(&k);
  else {
    s = refine(&k);
    if (s == YLM_OK) s = ylm__sides_finish(&k);
  }
  ylm_free(k.view);
  ylm_free(k.row);
  ylm_keys_free(&k.ghosts);
  ylm_free(k.ghost_point);
  return s;
}
