/* verify.c - held-out shading points against the light field. */
#include "tolerance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Shading point k in float. */
static void shading_point(const ylm_grid_source *s, size_t k, float out[3]) {
  for (size_t a = 0; a < 3; a++)
    out[a] = s->occupied_dtype == YLM_DOUBLE
                 ? (float)((const double *)s->occupied_points)[3 * k + a]
                 : ((const float *)s->occupied_points)[3 * k + a];
}

void refiner_draw(const refiner *r, ylm_rng *rng, float out[3]) {
  const ylm_grid_source *s = r->b->source;
  const double *box = r->b->g->view.form.bounds;
  if (r->surface) {
    uint64_t high = ylm_rng_u32(rng), low = ylm_rng_u32(rng);
    refiner_surface_point(r, high << 32 | low, 0, 1, out);
  } else if (s->occupied_points)
    shading_point(s, (size_t)(ylm_rng_double(rng) * (double)s->occupied), out);
  else
    for (size_t a = 0; a < 3; a++)
      out[a] = (float)(box[a] + (box[a + 3] - box[a]) * ylm_rng_double(rng));
}

uint32_t refiner_leaf(const ylm_grid *g, const float x[3]) {
  return ylm_grid_locate(g, (double[3]){(double)x[0], (double)x[1], (double)x[2]}, false, NULL);
}

/* n shading points, all there are or random ones, or free places where there are none. */
static ylm_status choose(refiner *r, ylm_rng *rng, bool all, size_t n) {
  const ylm_grid_source *s = r->b->source;
  bool here = s->occupied_points || !baker_has_shading(s);
  size_t index[HELD_OUT];
  for (size_t i = 0; i < n; i++) {
    if (here && !all)
      refiner_draw(r, rng, r->points + 3 * i);
    else if (here)
      shading_point(s, i, r->points + 3 * i);
    else
      index[i] = all ? i : (size_t)(ylm_rng_double(rng) * (double)s->occupied);
  }
  return here ? YLM_OK : s->keeper->shading(s->keeper->self, n, index, r->points, r->b->e);
}

/* Chooses points for this round: all, if there are not more. One that rounding to float moved out
   of occupied voxels is left out. */
static ylm_status hold_out(refiner *r, uint64_t round) {
  const ylm_grid_source *s = r->b->source;
  const ylm_grid *g = r->b->g;
  bool all = baker_has_shading(s) && s->occupied < HELD_OUT;
  size_t n = all ? s->occupied : HELD_OUT;
  r->all = all;
  ylm_rng rng;
  ylm_rng_seed(&rng, s->seed, round);
  r->held = 0;
  ylm_status status = r->surface ? refiner_hold_surface(r, round, n) : choose(r, &rng, all, n);
  for (size_t i = 0; status == YLM_OK && i < n; i++) {
    const float *x = r->points + 3 * i;
    uint32_t leaf = refiner_leaf(g, x);
    if (!(g->cell[leaf].flags & YLM_GRID_OCCUPIED)) continue;
    memmove(r->points + 3 * r->held, x, 3 * sizeof *x);
    r->verdict[r->held++].leaf = leaf;
  }
  return status;
}

void refiner_fractions(const ylm_grid *g, const ylm_grid_cell *c, const float x[3], float t[3]) {
  double at[3], inverse = 1 / (double)ylm__grid_edge(g, c);
  ylm__grid_coordinates(g, (double[3]){(double)x[0], (double)x[1], (double)x[2]}, at);
  for (int a = 0; a < 3; a++) t[a] = (float)edge_fraction(at[a], c->origin[a], inverse);
}

/* Errors of held-out points begin .. end-1, interpolated in their leaves. */
static ylm_status compare_range(void *context, size_t begin, size_t end, int worker) {
  refiner *r = context;
  const ylm_grid *g = r->b->g;
  float *row = r->row + (size_t)worker * (g->stride + ROW_PADDING);
  for (size_t i = begin; i < end; i++) {
    const ylm_grid_cell *c = &g->cell[r->verdict[i].leaf];
    float t[3];
    refiner_fractions(g, c, r->points + 3 * i, t);
    ylm__grid_interpolate(g, c, t, row, NULL);
    r->verdict[i].error = refiner_distance(row, r->exact + i * g->width, g->width);
  }
  return YLM_OK;
}

/* Errors of all held-out points, where rows are kept elsewhere. */
static ylm_status ask_errors(refiner *r) {
  baker *b = r->b;
  ylm_grid_probe *probe = ylm_alloc(r->held, sizeof *probe);
  float *distance = ylm_alloc(r->held, sizeof *distance), t[3];
  ylm_status s = probe && distance ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < r->held; i++) {
    const ylm_grid_cell *c = &b->g->cell[r->verdict[i].leaf];
    refiner_fractions(b->g, c, r->points + 3 * i, t);
    probe[i] = baker_probe(b, c, t, (uint32_t)i);
  }
  if (s == YLM_OK && r->held) s = keeper_compare(b, r->held, r->points, probe, distance, r->inside);
  for (size_t i = 0; s == YLM_OK && b->keeper && i < r->held; i++)
    r->verdict[i].error = (double)distance[i];
  ylm_free(probe);
  ylm_free(distance);
  return s;
}

static ylm_status find_errors(refiner *r) {
  baker *b = r->b;
  ylm_status s = baker_values(b, r->held, r->points, r->exact, r->inside);
  return s == YLM_OK ? ylm_parallel(r->held, 64, b->source->threads, compare_range, r, NULL, NULL)
                     : s;
}

ylm_status refiner_compare(refiner *r) {
  ylm_status s = r->b->keeper ? ask_errors(r) : YLM_OK;
  if (s == YLM_OK && !r->b->keeper) s = find_errors(r);
  r->verdicts = 0;
  for (size_t i = 0; i < r->held && s == YLM_OK; i++)
    if (!r->inside[i]) r->verdict[r->verdicts++] = r->verdict[i];
  return s;
}

static int downwards(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return x > y ? -1 : x < y;
}

/*
** True if refinement may stop. Else `tight` has grown so that the estimates of the voxels in which
** points failed (but for a few, which are split because of their points) exceed the tolerance.
** The margin below 1 % is for the next person's held-out points.
*/
bool refiner_satisfied(refiner *r, bool *limited) {
  const ylm_grid *g = r->b->g;
  double estimates[HELD_OUT];
  size_t refinable = 0, stuck = 0, n = r->verdicts;
  for (size_t i = 0; i < n; i++) {
    const ylm_grid_cell *c = &g->cell[r->verdict[i].leaf];
    if (!(r->verdict[i].error > r->tolerance)) continue;
    if (c->level < g->view.form.depth)
      estimates[refinable++] = refiner_estimate(r, c);
    else
      stuck++;
  }
  double all = (double)n;
  *limited = stuck > 0;
  if ((double)(refinable + stuck) <= 0.006 * all || (double)refinable <= 0.001 * all) return true;
  if ((double)stuck > 0.01 * all && (double)refinable <= 0.005 * all) return true;
  size_t few = (size_t)(0.004 * all);
  if (refinable <= few) return false; /* the others are at the finest level */
  qsort(estimates, refinable, sizeof *estimates, downwards);
  double wanted = 1.001 * r->tolerance / estimates[refinable - few - 1];
  if (wanted > 1.5 * r->tight) wanted = 1.5 * r->tight;
  if (wanted > r->tight) r->tight = wanted;
  return false;
}

ylm_status refiner_verify(refiner *r, uint64_t round) {
  baker *b = r->b;
  double t = ylm_seconds();
  b->stage = "verifying";
  ylm_status s = hold_out(r, round);
  if (s == YLM_OK) s = baker_fill_invalid(b);
  if (s == YLM_OK) s = refiner_compare(r);
  b->g->stats.verify_seconds += ylm_seconds() - t;
  return s;
}
