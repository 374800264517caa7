/*
** held_lookups.c - held-out points of surfaces, which have normals: they are looked up as shading looks
** them up (sample/bias.c), and compared by the grid's measure.
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
  return known && !b->remote && f->tolerance > 0 &&
         (f->bias > 0 || f->measure == YLM_GRID_IRRADIANCE);
}

/* -- asking ---------------------------------------------------------------------------------- */

/* Places at which the field is asked for n points: themselves, or a little off their surfaces, whose rounding is
   relative to the origin of the scene. */
static void places(const ylm_grid *g, const ylm_grid_reach *reach, size_t n, const float *x,
                   const float *side, float *out) {
  const ylm_grid_form *f = &g->contents.form;
  double way[3];
  for (int a = 0; a < 3; a++)
    way[a] = reach ? g->origin[a] - (reach->origin ? reach->origin[a] : 0) : 0;
  for (size_t i = 0; i < n; i++) {
    double off = 0, largest = 0;
    for (size_t a = 0; a < 3; a++) {
      off += SIDES_OFF * fabs((double)side[4 * i + a]) / g->scale[a];
      largest = fmax(largest, fabs((double)x[3 * i + a] + way[a]));
    }
    off = fmax(off, SIDES_ROUNDING * largest);
    off = f->bias > 0 ? fmin(off, (double)side[4 * i + 3]) : 0;
    for (size_t a = 0; a < 3; a++) out[3 * i + a] = x[3 * i + a] + (float)off * side[4 * i + a];
  }
}

/* The light at the points that are held. */
static ylm_status ask(refiner *r) {
  float *place = ylm_alloc(r->held, 3 * sizeof *place);
  if (!place) return YLM_ENOMEM;
  places(r->b->g, r->b->source->reach, r->held, r->points, r->side, place);
  ylm_status s = ylm__evaluate_values(r->b, r->held, place, r->exact, r->inside);
  ylm_free(place);
  return s;
}

ylm_status ylm__sides_scale(refiner *r) {
  const ylm_grid_source *s = r->b->source;
  measure *m = &r->b->measure;
  size_t w = r->b->g->width,
         n = s->occupied_points && s->occupied < HELD_OUT ? s->occupied : HELD_OUT;
  size_t counted = 0;
  ylm_rng rng;
  ylm_rng_seed(&rng, s->seed, UINT32_MAX);
  ylm_status status = r->surface ? ylm__held_surface(r, UINT32_MAX, n)
                                 : ylm__held_points(r, &rng, n == s->occupied, n);
  r->held = n;
  if (status == YLM_OK) status = ask(r);
  for (size_t i = 0; status == YLM_OK && i < n; i++) {
    double E[3] = {0}, norm = 0;
    if (r->inside[i]) continue;
    ylm__measure_irradiance(m, r->exact + i * w, r->side + 4 * i, E);
    for (size_t k = 0; k < w; k++)
      norm += (double)r->exact[i * w + k] * (double)r->exact[i * w + k];
    for (int c = 0; c < m->channels; c++) m->mean[c] += fabs(E[c]);
    m->norm += sqrt(norm);
    counted++;
  }
  for (int c = 0; c < 3 && counted; c++) m->mean[c] /= (double)counted;
  if (counted) m->norm /= (double)counted;
  r->held = 0;
  return status;
}

/* -- a grid in the making ----------------------------------------------------------------------- */

typedef struct sides_job {
  refiner *r;
  double *error; /* negative: left out */
  float *room;   /* [workers][4][stride + ROW_PADDING] */
} sides_job;

static bool has_corners(const ylm_grid_cell *c) {
  for (int k = 0; k < 8; k++)
    if (c->corner[k] == YLM_GRID_NONE) return false;
  return true;
}

/* The finest voxel with data that holds a place: its leaf, or an ancestor. */
static const ylm_grid_cell *voxel_of(const baker *b, uint32_t leaf) {
  while (leaf && !has_corners(&b->g->cell[leaf])) leaf = b->parent.cell[(leaf - 1) / 8];
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

/* The place at which a point is looked up. */
static void look_up(const refiner *r, const float *x, const float *side, float place[3]) {
  const ylm_grid *g = r->b->g;
  if (g->contents.form.bias > 0)
    ylm__grid_beside(g, g->contents.form.bias, g->origin, x, side, (double)side[3],
                     r->b->source->reach, place);
  else
    memcpy(place, x, 3 * sizeof *place);
}

static ylm_status compare(void *context, size_t begin, size_t end, int worker) {
  const sides_job *j = context;
  const refiner *r = j->r;
  const ylm_grid *g = r->b->g;
  size_t row = g->stride + ROW_PADDING;
  float *value = j->room + (size_t)worker * 4 * row, *gradient = value + row;
  for (size_t i = begin; i < end; i++) {
    const float *x = r->points + 3 * i, *side = r->side + 4 * i;
    float place[3], t[3], back[3];
    look_up(r, x, side, place);
    j->error[i] = -1;
    if (r->inside[i] || is_outside(g, place)) continue;
    uint32_t leaf = ylm__held_leaf(g, place);
    const ylm_grid_cell *c = voxel_of(r->b, leaf);
    ylm__held_fractions(g, c, place, t);
    ylm__grid_interpolate(g, c, t, value, gradient);
    for (int a = 0; a < 3; a++) back[a] = x[a] - place[a];
    for (size_t k = 0; k < g->width; k++)
      value[k] += back[0] * gradient[k] + back[1] * gradient[g->stride + k] +
                  back[2] * gradient[2 * g->stride + k];
    j->error[i] = ylm__measure_error(&r->b->measure, value, r->exact + i * g->width, side);
    if (!(g->cell[leaf].flags & YLM_GRID_OCCUPIED)) leaf = r->verdict[i].leaf; /* it has no data */
    r->verdict[i].beyond = leaf;
  }
  return YLM_OK;
}

ylm_status ylm__sides_compare(refiner *r) {
  const ylm_grid *g = r->b->g;
  int threads = ylm_threads(r->b->source->threads);
  sides_job j = {r, ylm_alloc(r->held, sizeof *j.error),
                 ylm_alloc((size_t)threads * 4 * (g->stride + ROW_PADDING), sizeof *j.room)};
  ylm_status s = j.error && j.room ? ask(r) : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_parallel(r->held, BAKE_GRAIN, threads, compare, &j, NULL, NULL);
  r->verdicts = 0;
  for (size_t i = 0; s == YLM_OK && i < r->held; i++)
    if (j.error[i] >= 0)
      r->verdict[r->verdicts++] = (verdict){j.error[i], r->verdict[i].leaf, r->verdict[i].beyond};
  ylm_free(j.error);
  ylm_free(j.room);
  return s;
}

/* -- a finished grid ---------------------------------------------------------------------------- */

ylm_status ylm__sides_errors(const refiner *r, const panel *p, double *error) {
  const ylm_grid *g = r->b->g;
  size_t n = p->n, w = g->width;
  int threads = r->b->source->threads;
  ylm_grid_query q = {.point_dtype = YLM_FLOAT,
                      .dtype = YLM_FLOAT,
                      .threads = threads,
                      .origin = ylm__grid_origin(g)};
  float *value = ylm_alloc(n, w * sizeof *value);
  float(*place)[3] = ylm_alloc(n, sizeof *place);
  float(*normal)[3] = ylm_alloc(n, sizeof *normal), *limit = ylm_alloc(n, sizeof *limit);
  const float(*x)[3] = (const float(*)[3])p->point;
  ylm_status s = value && place && normal && limit ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    memcpy(normal[i], p->side + 4 * i, sizeof normal[i]);
    limit[i] = p->side[4 * i + 3];
  }
  if (s == YLM_OK) {
    ylm_grid_bias(g, g->contents.form.bias, g->origin, n, x, (const float(*)[3])normal, limit,
                  r->b->source->reach, place, threads);
    s = ylm_grid_sample_biased(g, &q, n, x, (const float(*)[3])place, value, NULL, r->b->e);
  }
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    error[i] = p->inside[i] || is_outside(g, place[i])
                   ? -1
                   : ylm__measure_error(&r->b->measure, value + i * w, p->exact + i * w, normal[i]);
    if (isnan(error[i])) error[i] = INFINITY;
  }
  ylm_free(value);
  ylm_free(place);
  ylm_free(normal);
  ylm_free(limit);
  return s;
}

/* -- voxels that surfaces cross ----------------------------------------------------------------- */

/* Marks the leaf that holds the finest voxel with a Morton code. */
static void mark_code(const ylm_grid *g, uint64_t code, uint8_t *mark) {
  uint32_t cell = 0;
  int depth = g->contents.form.depth;
  while (!(g->cell[cell].flags & YLM_GRID_LEAF) && g->cell[cell].child)
    cell = g->cell[cell].child + (uint32_t)(code >> 3 * (depth - 1 - (int)g->cell[cell].level) & 7);
  mark[cell] = 1;
}

/* Marks the leaves that hold shading points, or that triangles meet. */
static ylm_status mark_surfaces(const refiner *r, uint8_t *mark) {
  const ylm_grid *g = r->b->g;
  const ylm_grid_source *s = r->b->source;
  uint64_t *code, outside = 0;
  size_t n;
  for (size_t i = 0; s->occupied_points && i < s->occupied; i++) {
    double p[3];
    for (size_t a = 0; a < 3; a++) p[a] = ylm_get(s->occupied_dtype, s->occupied_points, 3 * i + a);
    mark[ylm_grid_locate(g, p, false, NULL)] = 1;
  }
  if (!s->meshes) return YLM_OK;
  ylm_status status = ylm_grid_surface_voxels(g, s, &code, &n, &outside, r->b->e);
  for (size_t i = 0; status == YLM_OK && i < n; i++) mark_code(g, code[i], mark);
  if (status == YLM_OK) ylm_free(code);
  return status;
}

/* True if light jumps within a voxel: along one of its edges the mean slope misses the difference by
   more than a quarter of the larger norm. */
static bool jumps_within(const ylm_grid *g, const ylm_grid_cell *c) {
  double edge = ylm__grid_edge(g, c);
  for (int k = 0; k < 8; k++)
    for (int a = 0; a < 3; a++) {
      if (k >> a & 1 || !has_corners(c)) continue;
      const float *p[2] = {ylm__grid_row(g, c->corner[k], 0),
                           ylm__grid_row(g, c->corner[k | 1 << a], 0)};
      double half = 0.5 * edge / g->scale[a], missed = 0, norm[2] = {0};
      for (size_t j = 0; j < g->width; j++) {
        size_t slope = (size_t)(a + 1) * g->stride + j;
        double d =
            (double)p[1][j] - (double)p[0][j] - half * ((double)p[0][slope] + (double)p[1][slope]);
        missed += d * d;
        for (int i = 0; i < 2; i++) norm[i] += (double)p[i][j] * (double)p[i][j];
      }
      if (missed > SIDES_JUMP * SIDES_JUMP * fmax(norm[0], norm[1])) return true;
    }
  return false;
}

ylm_status ylm__sides_count(const refiner *r, const panel *p, const double *error,
                            uint64_t *crossed) {
  const ylm_grid *g = r->b->g;
  double tolerance = g->contents.form.tolerance;
  uint8_t *mark = ylm_alloc_zero(g->cells, 1);
  bool jumps = ylm_quantity_jumps(g->contents.form.quantity);
  ylm_status s = !mark ? YLM_ENOMEM : jumps ? mark_surfaces(r, mark) : YLM_OK;
  *crossed = 0;
  for (size_t i = 0; s == YLM_OK && i < p->n; i++) {
    float place[3];
    if (!(error[i] > tolerance)) continue;
    look_up(r, p->point + 3 * i, p->side + 4 * i, place);
    uint32_t leaf = ylm__held_leaf(g, place);
    *crossed += mark[leaf] || (jumps && jumps_within(g, voxel_of(r->b, leaf)));
  }
  ylm_free(mark);
  return s;
}
