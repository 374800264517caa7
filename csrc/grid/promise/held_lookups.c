/*
** held_lookups.c - held-out points of surfaces, which have normals: they are looked up as shading looks
** them up, and compared by the grid's measure.
**
** Where light jumps at surfaces, the field is asked a little off them, on the side that is seen.
*/
#include "../bake/surface.h"
#include "tolerance.h"

#include <math.h>
#include <string.h>

bool ylm__sides_wanted(const baker *b) {
  const ylm_grid_form *f = &b->g->contents.form;
  const ylm_grid_source *s = b->source;
  bool known = (s->occupied_points && s->normals) || s->meshes;
  return known && !b->remote && f->tolerance > 0 && (f->sides || f->measure == YLM_GRID_IRRADIANCE);
}

/* -- asking ---------------------------------------------------------------------------------- */

/* Places at which the field is asked for n points: themselves, or a little off their surfaces, whose rounding is
   relative to the origin of the scene. */
static void places(const ylm_grid *g, const ylm_grid_walls *walls, size_t n, const float *x,
                   const float *side, float *out) {
  const ylm_grid_form *f = &g->contents.form;
  bool jumps = ylm_quantity_jumps(f->quantity);
  double way[3];
  for (int a = 0; a < 3; a++) way[a] = walls ? g->origin[a] - walls->origin[a] : 0;
  for (size_t i = 0; i < n; i++) {
    double off = 0, largest = 0;
    for (size_t a = 0; a < 3; a++) {
      off += SIDES_OFF * fabs((double)side[3 * i + a]) / g->scale[a];
      largest = fmax(largest, fabs((double)x[3 * i + a] + way[a]));
    }
    off = jumps ? fmax(off, SIDES_ROUNDING * largest) : 0;
    for (size_t a = 0; a < 3; a++) out[3 * i + a] = x[3 * i + a] + (float)off * side[3 * i + a];
  }
}

ylm_status ylm__sides_ask(refiner *r) {
  if (!r->side) return ylm__evaluate_values(r->b, r->held, r->points, r->exact, r->inside);
  float *place = ylm_alloc(r->held, 3 * sizeof *place);
  if (!place) return YLM_ENOMEM;
  places(r->b->g, r->b->source->walls, r->held, r->points, r->side, place);
  ylm_status s = ylm__evaluate_values(r->b, r->held, place, r->exact, r->inside);
  ylm_free(place);
  return s;
}

/* -- a grid in the making ----------------------------------------------------------------------- */

typedef struct sides_job {
  refiner *r;
  double *error; /* negative: left out */
  float *room;   /* [workers][stride + ROW_PADDING] */
} sides_job;

/* The finest voxel with data that holds a place: its leaf, or an ancestor. */
static const ylm_grid_cell *voxel_of(const baker *b, uint32_t leaf) {
  while (leaf && !ylm__grid_is_complete(&b->g->cell[leaf])) leaf = b->parent.cell[(leaf - 1) / 8];
  return &b->g->cell[leaf];
}

static bool is_outside(const ylm_grid *g, const float p[3]) {
  const double *box = g->contents.form.bounds;
  bool out = false;
  double at[3];
  ylm__grid_outward(g, p, at);
  for (int a = 0; a < 3; a++) out |= !(at[a] >= box[a] && at[a] <= box[a + 3]);
  return out;
}

static ylm_status compare(void *context, size_t begin, size_t end, int worker) {
  const sides_job *j = context;
  const refiner *r = j->r;
  const ylm_grid *g = r->b->g;
  float *value = j->room + (size_t)worker * (g->stride + ROW_PADDING), t[3];
  for (size_t i = begin; i < end; i++) {
    const float *x = r->points + 3 * i;
    j->error[i] = -1;
    if (r->inside[i] || is_outside(g, x)) continue;
    const ylm_grid_cell *c = voxel_of(r->b, ylm__held_leaf(g, x));
    ylm__held_fractions(g, c, x, t);
    ylm__grid_interpolate(g, c, t, value, NULL);
    j->error[i] =
        ylm__measure_error(&r->b->measure, value, r->exact + i * g->width, r->side + 3 * i);
  }
  return YLM_OK;
}

ylm_status ylm__sides_compare(refiner *r) {
  const ylm_grid *g = r->b->g;
  int threads = ylm_threads(r->b->source->threads);
  sides_job j = {r, ylm_alloc(r->held, sizeof *j.error),
                 ylm_alloc((size_t)threads * (g->stride + ROW_PADDING), sizeof *j.room)};
  ylm_status s = j.error && j.room ? ylm__sides_ask(r) : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_parallel(r->held, BAKE_GRAIN, threads, compare, &j, NULL, NULL);
  r->verdicts = 0;
  for (size_t i = 0; s == YLM_OK && i < r->held; i++)
    if (j.error[i] >= 0) r->verdict[r->verdicts++] = (verdict){j.error[i], r->verdict[i].leaf};
  ylm_free(j.error);
  ylm_free(j.room);
  return s;
}

/* -- a finished grid ---------------------------------------------------------------------------- */

ylm_status ylm__sides_errors(const refiner *r, const panel *p, double *error) {
  const ylm_grid *g = r->b->g;
  size_t n = p->n, w = g->width;
  ylm_grid_query q = {.point_dtype = YLM_FLOAT,
                      .dtype = YLM_FLOAT,
                      .threads = r->b->source->threads,
                      .origin = ylm__grid_origin(g),
                      .normals = (const float(*)[3])p->side,
                      .walls = r->b->source->walls};
  float *value = ylm_alloc(n, w * sizeof *value);
  ylm_status s = value ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_grid_sample(g, &q, n, p->point, value, NULL, NULL, r->b->e);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    bool out = p->inside[i] || is_outside(g, p->point + 3 * i);
    const float *exact = p->exact + i * w;
    error[i] = out ? -1 : ylm__measure_error(&r->b->measure, value + i * w, exact, p->side + 3 * i);
    if (isnan(error[i])) error[i] = INFINITY;
  }
  ylm_free(value);
  return s;
}
