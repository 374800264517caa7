/* metric.c - the metric of cells, and which of them lights' surfaces cross. */
#include "baker.h"

#include <math.h>
#include <string.h>

float ylm__metric_of(const baker *b, const ylm_grid_cell *c, ylm_grid_metric metric) {
  const ylm_grid *g = b->g;
  if (!g->contents.form.metric_channels) return NAN;
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

double ylm__metric_above(const baker *b, const ylm_grid_cell *c, double least) {
  const ylm_grid *g = b->g;
  double box = 0, sum = 0, edge = ylm__grid_edge(g, c);
  int n = 0;
  for (int a = 0; a < 3; a++) box += edge / g->scale[a] * (edge / g->scale[a]);
  for (int k = 0; k < 8; k++) {
    uint32_t p = c->corner[k];
    if (g->flags[p] & YLM_GRID_POINT_INVALID) continue;
    sum += point_ratio((double)g->lambda[p], fmax((double)g->norm[p], least), true);
    n++;
  }
  return cell_metric(sum, n, box, 0.5);
}

static ylm_status find_metric(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const baker *b = context;
  for (size_t i = begin; i < end; i++) {
    ylm_grid_cell *c = &b->g->cell[b->wave.cell[i]];
    c->error = ylm__metric_of(b, c, b->g->contents.form.metric);
  }
  return YLM_OK;
}

/* -- surfaces of lights ---------------------------------------------------------------------- */

/* The cell in the same place before an update, if no light that changed is near it: the same
   surfaces of lights cross both. */
static const ylm_grid_cell *settled(const baker *b, uint32_t cell) {
  const ylm_grid_cell *old = cells_before(b, &b->g->cell[cell]);
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
** Finds which cells of the wave a light's surface crosses. Cells come with their parent's answer. A
** surface that meets a child meets its parent, so only children of crossed cells are asked about.
** Where there was an answer before, only cells near lights that changed are.
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

ylm_status ylm__metric_find(baker *b) {
  ylm_status s =
      ylm_parallel(b->wave.n, BAKE_LOOK_GRAIN, b->source->threads, find_metric, b, NULL, NULL);
  return s == YLM_OK && b->g->contents.form.kind != YLM_GRID_UNIFORM ? find_crossed(b) : s;
}
