/* processor.c - the processor as the back end of a bake: the grid itself keeps cells and rows. */
#include "baker.h"

static ylm_status corners(void *self, const ylm_grid_making *m, int level, size_t *fresh) {
  baker *b = self;
  (void)m;
  (void)level;
  ylm_status s = ylm__corners_find(b);
  *fresh = b->g->points - b->g->evaluated;
  return s;
}

static ylm_status evaluate(void *self, const ylm_grid_making *m, size_t n) {
  baker *b = self;
  (void)m;
  return ylm__evaluate_points(b, n, NULL, b->g->evaluated);
}

/* Splits the wave's cells by the threshold. */
static ylm_status split(baker *b, double threshold) {
  const ylm_grid *g = b->g;
  ylm_status s = YLM_OK;
  for (size_t i = 0; s == YLM_OK && i < b->wave.n; i++) {
    const ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
    bool crossed = c->flags & YLM_GRID_CROSSED;
    if (c->level < g->contents.form.depth && cell_splits((double)c->error, threshold, crossed))
      s = ylm__cells_split(b, b->wave.cell[i]);
  }
  ylm__cells_advance(b);
  return s;
}

static ylm_status metric(void *self, const ylm_grid_making *m, int level, size_t *next) {
  baker *b = self;
  const ylm_grid_form *f = &b->g->contents.form;
  (void)m;
  (void)level;
  ylm_status s = ylm__metric_find(b);
  if (s != YLM_OK || f->kind == YLM_GRID_UNIFORM || f->tolerance > 0) return s;
  s = split(b, f->threshold);
  *next = b->wave.n;
  return s;
}

/* -- residuals ------------------------------------------------------------------------------- */

typedef struct comparison {
  const baker *b;
  const ylm_grid_probe *probe;
  const float *exact; /* by probe.point; NULL: the points' rows */
  double *distance;
} comparison;

static ylm_status compare(void *context, size_t begin, size_t end, int worker) {
  const comparison *j = context;
  const ylm_grid *g = j->b->g;
  float *value = j->b->row + (size_t)worker * (g->stride + ROW_PADDING);
  for (size_t i = begin; i < end; i++) {
    const ylm_grid_probe *p = &j->probe[i];
    const float *row[ROWS],
        *exact = j->exact ? j->exact + (size_t)p->point * g->width : ylm__grid_row(g, p->point, 0);
    for (int r = 0; r < 4; r++)
      for (int k = 0; k < 8; k++) row[8 * r + k] = ylm__grid_row(g, p->corner[k], r);
    ylm__grid_mix(g, row, p->edge, p->t, value, NULL);
    j->distance[i] = ylm__measure_anywhere(&j->b->measure, value, exact);
  }
  return YLM_OK;
}

static ylm_status residuals(void *self, const ylm_grid_making *m, size_t n,
                            const ylm_grid_probe *probe, const ylm_grid_held *held,
                            double *distance) {
  baker *b = self;
  ylm_status s = held ? ylm__evaluate_values(b, n, held->place, held->value, held->inside) : YLM_OK;
  comparison j = {b, probe, held ? held->value : NULL, distance};
  (void)m;
  return s == YLM_OK ? ylm_parallel(n, BAKE_GRAIN, b->source->threads, compare, &j, NULL, NULL) : s;
}

/* -- the table ------------------------------------------------------------------------------- */

ylm_grid_backend ylm__processor_backend(baker *b) {
  return (ylm_grid_backend){.self = b,
                            .corners = corners,
                            .evaluate = evaluate,
                            .metric = metric,
                            .residuals = residuals};
}
