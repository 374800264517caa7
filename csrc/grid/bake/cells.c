/* cells.c - cells under way: their metric, lights that cross them, children, and what finishes
 * them. */
#include "baker.h"

#include <math.h>
#include <string.h>

float baker_metric(const baker *b, const ylm_grid_cell *c, ylm_grid_metric metric) {
  const ylm_grid *g = b->g;
  if (!g->view.form.metric_channels) return NAN;
  double box = 0, sum = 0, edge = ylm__grid_edge(g, c);
  int n = 0;
  for (int a = 0; a < 3; a++) box += edge / g->scale[a] * (edge / g->scale[a]);
  for (int k = 0; k < 8; k++) {
    uint32_t p = c->corner[k];
    if (g->flags[p] & YLM_GRID_POINT_INVALID) continue;
    sum += point_ratio((double)g->lambda[p], (double)g->norm[p], metric == YLM_GRID_RELATIVE);
    n++;
  }
  return (float)cell_metric(sum, n, box, 0.5);
}

/* The cell in the same place before an update, if no light that changed is near it: what crossed it
   then does so now. */
static const ylm_grid_cell *settled(const baker *b, uint32_t cell) {
  const ylm_grid_cell *old = baker_before(b, &b->g->cell[cell]);
  double box[6];
  if (!old) return NULL;
  ylm_grid_box(b->g, cell, box);
  for (size_t i = 0; i < b->unsettleds; i++) {
    const double *u = b->unsettled + 6 * i;
    bool apart = false;
    for (int a = 0; a < 3; a++) apart |= box[a] > u[a + 3] || u[a] > box[a + 3];
    if (!apart) return NULL;
  }
  return old;
}

/* Asks the field about n cells, which are flagged as crossed. */
static ylm_status ask_crossed(baker *b, size_t n, const uint32_t *cell) {
  const ylm_field *f = b->source->field;
  ylm_grid *g = b->g;
  double *box = ylm_alloc(n, 6 * sizeof *box);
  uint8_t *out = ylm_alloc_zero(n, 1);
  ylm_status s = box && out ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) ylm_grid_box(g, cell[i], box + 6 * i);
  double t = ylm_seconds();
  if (s == YLM_OK) s = f->crosses(f, n, box, out);
  g->stats.field_seconds += ylm_seconds() - t;
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    if (!out[i]) g->cell[cell[i]].flags &= (uint8_t)~YLM_GRID_CROSSED;
  ylm_free(box);
  ylm_free(out);
  return s;
}

/*
** Finds which cells of the wave a light's surface crosses. Cells come with their parent's answer: a
** surface that meets a child meets its parent, so only children of crossed cells are asked about,
** and of these only those near lights that changed, where there was an answer before.
*/
static ylm_status find_crossed(baker *b) {
  ylm_grid *g = b->g;
  size_t n = 0;
  uint32_t *ask = ylm_alloc(b->wave.n, sizeof *ask);
  if (!ask) return YLM_ENOMEM;
  for (size_t i = 0; i < b->wave.n; i++) {
    ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
    if (!(c->flags & YLM_GRID_CROSSED)) continue;
    const ylm_grid_cell *old = settled(b, b->wave.cell[i]);
    if (!b->source->field->crosses || (old && !(old->flags & YLM_GRID_CROSSED)))
      c->flags &= (uint8_t)~YLM_GRID_CROSSED;
    else if (!old)
      ask[n++] = b->wave.cell[i];
  }
  ylm_status s = n ? ask_crossed(b, n, ask) : YLM_OK;
  ylm_free(ask);
  return s;
}

static ylm_status find_metric(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const baker *b = context;
  for (size_t i = begin; i < end; i++) {
    ylm_grid_cell *c = &b->g->cell[b->wave.cell[i]];
    c->error = baker_metric(b, c, b->g->view.form.metric);
  }
  return YLM_OK;
}

ylm_status baker_corners(baker *b) {
  ylm_grid *g = b->g;
  double t = ylm_seconds();
  ylm_status s = baker_find_corners(b);
  g->stats.lattice_seconds += ylm_seconds() - t;
  if (s == YLM_OK) s = baker_evaluate(b);
  if (s == YLM_OK) s = ylm_parallel(b->wave.n, 512, b->source->threads, find_metric, b, NULL, NULL);
  return s == YLM_OK && g->view.form.kind != YLM_GRID_UNIFORM ? find_crossed(b) : s;
}

ylm_status baker_split(baker *b, uint32_t cell) {
  ylm_grid *g = b->g;
  uint32_t first;
  ylm_status s = ylm__grid_split(g, cell, &first);
  if (s == YLM_OK) s = cell_list_push(&b->parent, cell);
  if (s != YLM_OK) return s;
  const ylm_grid_cell *old = baker_before(b, &g->cell[cell]);
  if (old && old->flags & YLM_GRID_LEAF) old = NULL; /* it had none, or for continuity only */
  g->cell[cell].flags &= (uint8_t)~YLM_GRID_LEAF;
  uint8_t occupied =
      occupancy_children(&b->learnt.occupied, g->cell[cell].level, g->cell[cell].origin);
  for (uint32_t k = first; k < first + 8; k++) {
    ylm_grid_cell *c = &g->cell[k];
    c->flags = YLM_GRID_LEAF;
    if (b->before) c->source = old ? old->child + (k - first) : YLM_GRID_NONE;
    if (!(occupied >> (k - first) & 1)) continue;
    c->flags |= YLM_GRID_OCCUPIED | (g->cell[cell].flags & YLM_GRID_CROSSED);
    s = cell_list_push(&b->next, k);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}

void baker_advance(baker *b) {
  cell_list spent = b->wave;
  b->wave = b->next;
  b->next = spent;
  b->next.n = 0;
}

ylm_status baker_finish(baker *b) {
  ylm_grid *g = b->g;
  int threads = b->source->threads;
  g->view.octree_cells = g->cells;
  ylm_status s = baker_find_parents(b);
  if (s == YLM_OK) s = baker_fetch(b);
  if (s != YLM_OK) return s;
  double t = ylm_seconds();
  baker_find_shared(b, NULL);
  g->stats.lattice_seconds += ylm_seconds() - t;
  s = ylm__grid_fill_invalid(g);
  t = ylm_seconds();
  ylm__grid_find_baked(g);
  bool continuous = g->view.form.kind == YLM_GRID_ADAPTIVE && g->view.form.continuous;
  if (s == YLM_OK && continuous) s = ylm__grid_make_continuous(g, threads);
  g->stats.continuity_seconds += ylm_seconds() - t;
  return s == YLM_OK ? ylm__grid_finish(g) : s;
}
