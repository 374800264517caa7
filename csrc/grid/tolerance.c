/*
** tolerance.c - refinement until 99 % of the shading points are as accurate as promised.
**
** The Hessian's relative metric E is O(h^2), the interpolation error e of Hermite O(h^4): for one
** lamp e is close to E^2 times a constant, with background light the constant varies. So:
**   - kappa, a high quantile of e / E^2 where both are known, says where e may exceed the
**     tolerance; elsewhere nothing is measured;
**   - there e is measured at the voxel's centre, a corner of all its children, which is evaluated
**     anyway if the voxel is split;
**   - a voxel is split where its estimate times `tight` exceeds the tolerance;
**   - held-out shading points are compared with the field. Voxels in which they fail are split, and
**     `tight` grows until the estimates of (almost) all these would have said so. Then fresh
*points.
** The last comparison is made with points that decided nothing: it is what stats report.
*/
#include "dynamic.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define HELD_OUT 2048
#define MAX_ROUNDS 16
#define FEW 32 /* ratios before kappa is trusted */
#define FIRST_TIGHT 0.35

static void ratios_add(ratios *r, double x) {
  int k = x > 0 ? (int)(2 * log2(x)) + 128 : 0;
  r->count[k < 0 ? 0 : k > 255 ? 255 : k]++;
  r->n++;
}

/* The value that a fraction q of the ratios does not exceed. */
static double ratios_quantile(const ratios *r, double q) {
  uint64_t sum = 0, wanted = (uint64_t)ceil(q * (double)r->n);
  int k = 0;
  while (k < 255 && (sum += r->count[k]) < wanted) k++;
  return exp2(0.5 * (k + 1 - 128));
}

/* A held-out point after comparison. */
typedef struct verdict {
  double error; /* relative */
  uint32_t leaf;
} verdict;

typedef struct refiner {
  baker *b;
  double tolerance, tight;
  ratios ratio;
  cell_list tested, centre; /* cells to measure, and the points at their centres */
  float *row;               /* [width], for each worker */
  float *points;            /* [HELD_OUT][3] */
  float *exact, *sampled;   /* [HELD_OUT][width] */
  uint8_t *inside;
  verdict *verdict;
  size_t held, verdicts;
  bool frozen; /* an update: ratios and `tight` are those of the bake */
} refiner;

/* -- voxels that failed --------------------------------------------------------------------- */

/* Remembers, where updates follow, that a voxel is to be split. */
static ylm_status force(const refiner *r, const ylm_grid_cell *c) {
  grid_dynamic *d = r->b->g->dynamic;
  if (!d) return YLM_OK;
  if (lattice_hash_reserve(&d->forced, d->forced.used + 1) != YLM_OK) return YLM_ENOMEM;
  *lattice_hash_at(&d->forced, cell_key(c)) = (uint32_t)r->b->g->stats.update.updates;
  return YLM_OK;
}

static bool forced(const refiner *r, const ylm_grid_cell *c) {
  if (!r->frozen) return false;
  uint32_t when = lattice_hash_find(&r->b->g->dynamic->forced, cell_key(c));
  uint32_t now = (uint32_t)r->b->g->stats.update.updates;
  return when != YLM_GRID_NONE && now - when < FORCED_UPDATES;
}

/* Relative distance of two rows; 0 where both vanish. */
static double distance(const float *a, const float *exact, size_t width) {
  double d = 0, n = 0;
  for (size_t j = 0; j < width; j++) {
    double x = (double)a[j] - (double)exact[j];
    d += x * x;
    n += (double)exact[j] * (double)exact[j];
  }
  return d == 0 ? 0 : sqrt(d / n);
}

/* -- estimates ------------------------------------------------------------------------- */

static double metric_squared(const refiner *r, const ylm_grid_cell *c) {
  double e = (double)baker_metric(r->b, c, YLM_GRID_RELATIVE);
  return e * e;
}

/* The error that a cell may have. */
static double estimate(const refiner *r, const ylm_grid_cell *c) {
  if (!isnan(c->residual)) return (double)c->residual;
  double e2 = metric_squared(r, c);
  return r->ratio.n < FEW ? sqrt(e2) : ratios_quantile(&r->ratio, 0.5) * e2;
}

/* True if a measurement may change what happens to a cell. */
static bool wants_test(const refiner *r, const ylm_grid_cell *c) {
  if (c->level >= r->b->g->view.form.depth || c->flags & YLM_GRID_CROSSED) return false;
  if (!isnan(c->residual)) return false;
  double e2 = metric_squared(r, c);
  double high = r->ratio.n < FEW ? sqrt(e2) : ratios_quantile(&r->ratio, 0.98) * e2;
  return high * r->tight > r->tolerance;
}

/* Takes the residual of the cell that was in the same place, if nothing that it depends on changed.
 */
static bool take_residual(const baker *b, ylm_grid_cell *c, uint32_t centre) {
  const ylm_grid_cell *old = baker_before(b, c);
  if (!old || isnan(old->residual) || b->changed[centre]) return false;
  for (int k = 0; k < 8; k++)
    if (b->changed[c->corner[k]]) return false;
  c->residual = old->residual;
  return true;
}

/* Residuals of the cells begin .. end-1 of r->tested, whose centres are in r->centre. */
static ylm_status find_residuals(void *context, size_t begin, size_t end, int worker) {
  const refiner *r = context;
  const baker *b = r->b;
  const ylm_grid *g = b->g;
  float *row = r->row + (size_t)worker * (g->stride + ROW_PADDING);
  for (size_t i = begin; i < end; i++) {
    ylm_grid_cell *c = &g->cell[r->tested.cell[i]];
    uint32_t centre = r->centre.cell[i];
    if (take_residual(b, c, centre)) {
      r->centre.cell[i] = YLM_GRID_NONE;
      continue;
    }
    ylm__grid_interpolate(g, c, (const float[3]){0.5f, 0.5f, 0.5f}, row, NULL);
    c->residual = (float)distance(row, ylm__grid_row(g, centre, 0), g->width);
  }
  return YLM_OK;
}

/* Evaluates the centres of the cells in r->tested and keeps what the interpolant misses there. */
static ylm_status measure(refiner *r) {
  baker *b = r->b;
  ylm_grid *g = b->g;
  ylm_status s = YLM_OK;
  double t = ylm_seconds();
  r->centre.n = 0;
  for (size_t i = 0; i < r->tested.n && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[r->tested.cell[i]];
    uint32_t half = ylm__grid_edge(g, c) / 2, at[3], point;
    for (int a = 0; a < 3; a++) at[a] = c->origin[a] + half;
    s = baker_point(b, at, YLM_GRID_POINT_TESTED, &point);
    if (s == YLM_OK) s = cell_list_push(&r->centre, point);
  }
  g->stats.lattice_seconds += ylm_seconds() - t;
  if (s == YLM_OK) s = baker_evaluate(b);
  t = ylm_seconds();
  if (s == YLM_OK)
    s = ylm_parallel(r->tested.n, 64, b->source->threads, find_residuals, r, NULL, NULL);
  for (size_t i = 0; i < r->tested.n && s == YLM_OK && !r->frozen; i++) {
    if (r->centre.cell[i] == YLM_GRID_NONE) continue;
    const ylm_grid_cell *c = &g->cell[r->tested.cell[i]];
    double e2 = metric_squared(r, c);
    if (e2 > 0 && isfinite(e2)) ratios_add(&r->ratio, (double)c->residual / e2);
  }
  g->stats.residual_seconds += ylm_seconds() - t;
  r->tested.n = 0;
  return s;
}

/* -- refinement -------------------------------------------------------------------------- */

/* Tests and splits what the wave holds, then its children, until nothing is left. */
static ylm_status refine(refiner *r) {
  baker *b = r->b;
  ylm_grid *g = b->g;
  ylm_status s = YLM_OK;
  while (b->wave.n && s == YLM_OK) {
    snprintf(b->stage_text, sizeof b->stage_text, "level %d", g->cell[b->wave.cell[0]].level);
    b->stage = b->stage_text;
    s = baker_corners(b);
    for (size_t i = 0; i < b->wave.n && s == YLM_OK; i++)
      if (wants_test(r, &g->cell[b->wave.cell[i]])) s = cell_list_push(&r->tested, b->wave.cell[i]);
    if (s == YLM_OK) s = measure(r);
    for (size_t i = 0; i < b->wave.n && s == YLM_OK; i++) {
      const ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
      if (c->level >= g->view.form.depth) continue;
      if (c->flags & YLM_GRID_CROSSED || estimate(r, c) * r->tight > r->tolerance || forced(r, c))
        s = baker_split(b, b->wave.cell[i]);
    }
    baker_advance(b);
  }
  return s;
}

/* Looks again at all leaves: those in which held-out points failed are split, and those that the
   tighter bound asks for. */
static ylm_status refine_again(refiner *r) {
  baker *b = r->b;
  ylm_grid *g = b->g;
  ylm_status s = YLM_OK;
  size_t cells = g->cells;
  for (size_t i = 0; i < cells && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (c->flags & YLM_GRID_LEAF && c->flags & YLM_GRID_OCCUPIED && wants_test(r, c))
      s = cell_list_push(&r->tested, (uint32_t)i);
  }
  if (s == YLM_OK) s = measure(r);
  for (size_t i = 0; i < r->verdicts && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[r->verdict[i].leaf];
    if (r->verdict[i].error > r->tolerance && c->flags & YLM_GRID_LEAF &&
        c->level < g->view.form.depth) {
      s = force(r, c);
      if (s == YLM_OK) s = baker_split(b, r->verdict[i].leaf);
    }
  }
  for (size_t i = 0; i < cells && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (c->flags & YLM_GRID_LEAF && c->flags & YLM_GRID_OCCUPIED && c->level < g->view.form.depth &&
        estimate(r, c) * r->tight > r->tolerance)
      s = baker_split(b, (uint32_t)i);
  }
  baker_advance(b);
  return s == YLM_OK ? refine(r) : s;
}

/* -- verification ------------------------------------------------------------------------- */

/* Chooses points for this round: shading points, or any where every voxel is occupied. */
static void hold_out(refiner *r, uint64_t round) {
  const ylm_grid_source *s = r->b->source;
  const double *box = r->b->g->view.form.bounds;
  ylm_rng rng;
  ylm_rng_seed(&rng, s->seed, round);
  r->held = s->occupied_points && s->occupied < HELD_OUT ? s->occupied : HELD_OUT;
  for (size_t i = 0; i < r->held; i++) {
    size_t k = r->held < HELD_OUT ? i : (size_t)(ylm_rng_double(&rng) * (double)s->occupied);
    for (size_t a = 0; a < 3; a++) {
      double x;
      if (!s->occupied_points)
        x = box[a] + (box[a + 3] - box[a]) * ylm_rng_double(&rng);
      else if (s->occupied_dtype == YLM_DOUBLE)
        x = ((const double *)s->occupied_points)[3 * k + a];
      else
        x = (double)((const float *)s->occupied_points)[3 * k + a];
      r->points[3 * i + a] = (float)x;
    }
  }
}

/* Samples the held-out points, whose exact values are known, and compares. */
static ylm_status compare(refiner *r) {
  ylm_grid *g = r->b->g;
  ylm_grid_query q = {
      .point_dtype = YLM_FLOAT, .dtype = YLM_FLOAT, .threads = r->b->source->threads};
  ylm_status s = ylm_grid_sample(g, &q, r->held, r->points, r->sampled, NULL, NULL, r->b->e);
  r->verdicts = 0;
  for (size_t i = 0; i < r->held && s == YLM_OK; i++) {
    double p[3];
    if (r->inside[i]) continue;
    for (size_t a = 0; a < 3; a++) p[a] = (double)r->points[3 * i + a];
    size_t k = i * g->width;
    r->verdict[r->verdicts++] = (verdict){distance(r->sampled + k, r->exact + k, g->width),
                                          ylm_grid_locate(g, p, false, NULL)};
  }
  return s;
}

static int by_error(const void *a, const void *b) {
  double x = ((const verdict *)a)->error, y = ((const verdict *)b)->error;
  return x < y ? -1 : x > y;
}

static int downwards(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return x > y ? -1 : x < y;
}

/* Writes what the comparison says to the grid's stats. */
static void report(refiner *r, bool limited) {
  ylm_grid_stats *s = &r->b->g->stats;
  size_t n = r->verdicts;
  s->verified = n;
  s->error = s->largest_error = 0;
  if (n) {
    qsort(r->verdict, n, sizeof *r->verdict, by_error);
    s->error = r->verdict[(size_t)ceil(0.99 * (double)n) - 1].error;
    s->largest_error = r->verdict[n - 1].error;
  }
  s->met = s->error <= r->tolerance;
  s->limited = !s->met && limited;
}

/*
** True if refinement may stop. Else `tight` has grown so that the estimates of the voxels in which
** points failed (but for a few, which are split because of their points) exceed the tolerance.
** The margin below 1 % is for the next person's held-out points.
*/
static bool satisfied(refiner *r, bool *limited) {
  const ylm_grid *g = r->b->g;
  double *estimates = (double *)r->sampled; /* free again, see begin() */
  size_t refinable = 0, stuck = 0, n = r->verdicts;
  for (size_t i = 0; i < n; i++) {
    const ylm_grid_cell *c = &g->cell[r->verdict[i].leaf];
    if (!(r->verdict[i].error > r->tolerance)) continue;
    if (c->level < g->view.form.depth)
      estimates[refinable++] = estimate(r, c);
    else
      stuck++;
  }
  double all = (double)n;
  *limited = stuck > 0;
  if ((double)(refinable + stuck) <= 0.006 * all || (double)refinable <= 0.001 * all) return true;
  if ((double)stuck > 0.01 * all && (double)refinable <= 0.005 * all) return true;
  qsort(estimates, refinable, sizeof *estimates, downwards);
  size_t caught = refinable - (size_t)(0.004 * all);
  double wanted = 1.001 * r->tolerance / estimates[caught - 1];
  if (wanted > 1.5 * r->tight) wanted = 1.5 * r->tight;
  if (wanted > r->tight) r->tight = wanted;
  return false;
}

static ylm_status begin(refiner *r) {
  size_t w = r->b->g->width;
  r->row = ylm_alloc((size_t)ylm_threads(r->b->source->threads) * (r->b->g->stride + ROW_PADDING),
                     sizeof *r->row);
  r->points = ylm_alloc(HELD_OUT, 3 * sizeof *r->points);
  r->exact = ylm_alloc(HELD_OUT, w * sizeof *r->exact);
  r->sampled = ylm_alloc(HELD_OUT, w * sizeof *r->sampled + sizeof(double));
  r->inside = ylm_alloc(HELD_OUT, 1);
  r->verdict = ylm_alloc(HELD_OUT, sizeof *r->verdict);
  bool ok = r->row && r->points && r->exact && r->sampled && r->inside && r->verdict;
  return ok ? YLM_OK : YLM_ENOMEM;
}

/* One verification of the grid as it is. */
static ylm_status verify(refiner *r, uint64_t round) {
  baker *b = r->b;
  double t = ylm_seconds();
  hold_out(r, round);
  b->stage = "verifying";
  ylm_status s = baker_finish(b, false);
  if (s == YLM_OK) s = baker_values(b, r->held, r->points, r->exact, r->inside);
  if (s == YLM_OK) s = compare(r);
  b->g->stats.verify_seconds += ylm_seconds() - t;
  return s;
}

static ylm_status run(refiner *r) {
  bool limited = false;
  ylm_status s = refine(r);
  for (uint64_t round = 1; s == YLM_OK; round++) {
    r->b->g->stats.rounds = round;
    s = verify(r, round);
    if (s != YLM_OK || satisfied(r, &limited) || round == MAX_ROUNDS) break;
    s = refine_again(r);
  }
  if (s == YLM_OK) s = baker_finish(r->b, true);
  if (s == YLM_OK) s = compare(r);
  if (s == YLM_OK) report(r, limited);
  return s;
}

static void end(refiner *r) {
  ylm_free(r->row);
  ylm_free(r->points);
  ylm_free(r->exact);
  ylm_free(r->sampled);
  ylm_free(r->inside);
  ylm_free(r->verdict);
  ylm_free(r->tested.cell);
  ylm_free(r->centre.cell);
}

ylm_status ylm__grid_bake_tolerance(baker *b) {
  refiner r = {.b = b, .tolerance = b->g->view.form.tolerance, .tight = FIRST_TIGHT};
  ylm_status s = begin(&r);
  if (s == YLM_OK) s = run(&r);
  end(&r);
  if (b->g->dynamic) {
    b->g->dynamic->ratio = r.ratio;
    b->g->dynamic->tight = r.tight;
  }
  return s;
}

/* -- updates ------------------------------------------------------------------------------- */

#define UPDATE_HELD 256    /* points that are compared */
#define UPDATE_DRAWN 16384 /* tries to find as many in voxels that changed */
#define UPDATE_ROUNDS 3

static bool touched(const ylm_grid_cell *c, const uint8_t *changed, size_t known) {
  for (int k = 0; k < 8; k++)
    if (c->corner[k] >= known || changed[c->corner[k]]) return true;
  return false;
}

/* A random shading point, or any where every voxel is occupied. */
static void draw(const refiner *r, ylm_rng *rng, float out[3]) {
  const ylm_grid_source *s = r->b->source;
  const double *box = r->b->g->view.form.bounds;
  size_t k = s->occupied_points ? (size_t)(ylm_rng_double(rng) * (double)s->occupied) : 0;
  for (size_t a = 0; a < 3; a++)
    out[a] = !s->occupied_points ? (float)(box[a] + (box[a + 3] - box[a]) * ylm_rng_double(rng))
             : s->occupied_dtype == YLM_DOUBLE
                 ? (float)((const double *)s->occupied_points)[3 * k + a]
                 : ((const float *)s->occupied_points)[3 * k + a];
}

/* Draws points in occupied leaves whose corners changed. */
static void hold_out_changed(refiner *r, uint64_t stream, const uint8_t *changed, size_t known) {
  const ylm_grid *g = r->b->g;
  ylm_rng rng;
  ylm_rng_seed(&rng, r->b->source->seed, stream);
  r->held = 0;
  for (int i = 0; i < UPDATE_DRAWN && r->held < UPDATE_HELD; i++) {
    float x[3];
    draw(r, &rng, x);
    uint32_t leaf =
        ylm_grid_locate(g, (double[3]){(double)x[0], (double)x[1], (double)x[2]}, false, NULL);
    if (!(g->cell[leaf].flags & YLM_GRID_OCCUPIED) || !touched(&g->cell[leaf], changed, known))
      continue;
    r->verdict[r->held].leaf = leaf;
    memcpy(r->points + 3 * r->held++, x, sizeof x);
  }
}

/* Evaluates the points that are held out and compares them with their leaves' interpolants. Returns
   how many fail in leaves that can be split, which come first. */
static ylm_status compare_changed(refiner *r, size_t *failed) {
  ylm_grid *g = r->b->g;
  ylm_status s = baker_values(r->b, r->held, r->points, r->exact, r->inside);
  r->verdicts = *failed = 0;
  for (size_t i = 0; i < r->held && s == YLM_OK; i++) {
    if (r->inside[i]) continue;
    verdict v = r->verdict[i];
    const ylm_grid_cell *c = &g->cell[v.leaf];
    double at[3], edge = ylm__grid_edge(g, c);
    const float *x = r->points + 3 * i;
    ylm__grid_coordinates(g, (double[3]){(double)x[0], (double)x[1], (double)x[2]}, at);
    float t[3];
    for (int a = 0; a < 3; a++) t[a] = (float)((at[a] - c->origin[a]) / edge);
    ylm__grid_interpolate(g, c, t, r->row, NULL);
    v.error = distance(r->row, r->exact + i * g->width, g->width);
    r->verdict[r->verdicts++] = v;
    *failed += v.error > r->tolerance && c->level < g->view.form.depth;
  }
  return s;
}

static ylm_status split_failed(refiner *r) {
  baker *b = r->b;
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < r->verdicts && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &b->g->cell[r->verdict[i].leaf];
    if (!(r->verdict[i].error > r->tolerance) || !(c->flags & YLM_GRID_LEAF) ||
        c->level >= b->g->view.form.depth)
      continue;
    s = force(r, c);
    if (s == YLM_OK) s = baker_split(b, r->verdict[i].leaf);
  }
  baker_advance(b);
  return s == YLM_OK ? refine(r) : s;
}

static ylm_status refine_changed(refiner *r, const uint8_t *changed, size_t known) {
  ylm_grid_update_stats *stats = &r->b->g->stats.update;
  ylm_status s = refine(r);
  stats->verified = 0;
  for (uint64_t round = 0; s == YLM_OK && round < UPDATE_ROUNDS; round++) {
    size_t failed;
    double start = ylm_seconds();
    s = ylm__grid_fill_invalid(r->b->g);
    hold_out_changed(r, 1000 + stats->updates * UPDATE_ROUNDS + round, changed, known);
    r->b->stage = "verifying";
    if (s == YLM_OK) s = compare_changed(r, &failed);
    r->b->g->stats.verify_seconds += ylm_seconds() - start;
    if (s != YLM_OK || r->verdicts == 0) break;
    bool last = (double)failed <= 0.006 * (double)r->verdicts || round + 1 == UPDATE_ROUNDS;
    if (!last) s = split_failed(r);
    if (!last || s != YLM_OK) continue;
    qsort(r->verdict, r->verdicts, sizeof *r->verdict, by_error);
    stats->verified = r->verdicts;
    stats->error = r->verdict[(size_t)ceil(0.99 * (double)r->verdicts) - 1].error;
    stats->met = stats->error <= r->tolerance;
    break;
  }
  return s;
}

ylm_status ylm__grid_update_tolerance(baker *b, const uint8_t *changed, size_t known) {
  grid_dynamic *d = b->g->dynamic;
  refiner r = {.b = b,
               .tolerance = b->g->view.form.tolerance,
               .tight = d->tight,
               .ratio = d->ratio,
               .frozen = true};
  ylm_status s = begin(&r);
  if (s == YLM_OK) s = refine_changed(&r, changed, known);
  end(&r);
  return s;
}
