/*
** sphere_set.c - spheres that stand for a body.
**
** A lattice of points in and around the body measures volumes. Spheres are taken one by one, each the largest inside of the
** body where most is not yet covered. Then each is moved and resized in turn, where less of the body is left out or less
** is covered outside of it.
**
** Source  the error is that of Wang et al. 2006, "Variational sphere set approximation for solid objects", both ways
*/
#include "lattice.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ROUNDS 10
#define POINTS 20000     /* inside of the body, at least; */
#define POINTS_EACH 60   /* of a sphere, at least */
#define CANDIDATES 20000 /* of centres */
#define BINS 8           /* of radii, a step of the lattice */
#define BINS_MOST 4096

typedef struct sphere {
  double at[3], radius;
} sphere;

typedef struct candidate {
  double gain;
  size_t point;
} candidate;

typedef struct work {
  ylm__lattice l;
  uint16_t *cover; /* [points] how many spheres cover it */
  float *depth;
  candidate *heap;
  size_t heaped;
  int32_t *bin; /* [BINS_MOST] */
  const ylm_progress *progress;
  double told; /* when the last report was */
} work;

/* -- points of a sphere ------------------------------------------------------------------------------ */

typedef void visit_fn(work *w, size_t point, double square, void *context);

/* fn of each point of the lattice within a radius. */
static void visit(work *w, const double at[3], double radius, visit_fn *fn, void *context) {
  const ylm__lattice *l = &w->l;
  size_t from[3], to[3];
  for (int a = 0; a < 3; a++) {
    double x = (at[a] - l->low[a]) / l->step, r = radius / l->step, n = (double)l->n[a];
    from[a] = (size_t)fmin(n, fmax(0, ceil(x - r)));
    to[a] = (size_t)fmin(n, fmax(0, floor(x + r) + 1));
  }
  for (size_t k = from[2]; k < to[2]; k++)
    for (size_t j = from[1]; j < to[1]; j++) {
      double z = l->low[2] + l->step * (double)k - at[2],
             y = l->low[1] + l->step * (double)j - at[1];
      double rest = radius * radius - y * y - z * z;
      for (size_t i = from[0]; i < to[0] && rest >= 0; i++) {
        double x = l->low[0] + l->step * (double)i - at[0];
        if (x * x <= rest) fn(w, lattice_at(l, i, j, k), x * x + y * y + z * z, context);
      }
    }
}

static void count_one(work *w, size_t point, double square, void *context) {
  (void)square;
  *(double *)context += w->l.in[point] && !w->cover[point];
}

static void cover_one(work *w, size_t point, double square, void *context) {
  (void)square;
  w->cover[point] = (uint16_t)(w->cover[point] + *(int *)context);
}

static void cover(work *w, const sphere *s, int by) { visit(w, s->at, s->radius, cover_one, &by); }

/* -- the best radius ----------------------------------------------------------------------------------- */

typedef struct fit {
  double at[3], bins; /* bins a unit of length */
  double sum[3], n;   /* of points of the body that no other sphere covers */
} fit;

static void bin_one(work *w, size_t point, double square, void *context) {
  const fit *f = context;
  if (w->cover[point]) return;
  size_t bin = (size_t)(sqrt(square) * f->bins);
  w->bin[bin < BINS_MOST ? bin : BINS_MOST - 1] += w->l.in[point] ? 1 : -1;
}

/* The radius up to `most` that gains most points: those of the body less the others, where no other sphere is. */
static double best_radius(work *w, const double at[3], double most, double *gain) {
  fit f = {.bins = fmin(BINS / w->l.step, (BINS_MOST - 1) / most)};
  size_t bins = (size_t)(most * f.bins) + 1;
  memcpy(f.at, at, sizeof f.at);
  memset(w->bin, 0, bins * sizeof *w->bin);
  visit(w, at, most, bin_one, &f);
  int32_t sum = 0, best = 0;
  size_t at_best = 0;
  for (size_t i = 0; i < bins; i++) {
    sum += w->bin[i];
    if (sum > best) {
      best = sum;
      at_best = i + 1;
    }
  }
  *gain = best;
  return fmin(most, (double)at_best / f.bins);
}

/* How far a sphere about a point may reach: not out of the lattice. */
static double reach(const work *w, const double at[3], double wanted) {
  for (int a = 0; a < 3; a++) {
    double end = w->l.low[a] + w->l.step * (double)(w->l.n[a] - 1);
    wanted = fmin(wanted, fmin(at[a] - w->l.low[a], end - at[a]));
  }
  return fmax(w->l.step, wanted);
}

/* -- one by one ------------------------------------------------------------------------------------------ */

static void place_of(const ylm__lattice *l, size_t point, double at[3]) {
  size_t i[3] = {point % l->n[0], point / l->n[0] % l->n[1], point / l->n[0] / l->n[1]};
  for (int a = 0; a < 3; a++) at[a] = l->low[a] + l->step * (double)i[a];
}

/* Points of the body that a sphere in it about a point would add. */
static double gain_of(work *w, size_t point) {
  double at[3], sum = 0;
  place_of(&w->l, point, at);
  visit(w, at, (double)w->depth[point], count_one, &sum);
  return sum;
}

static bool above(const candidate *a, const candidate *b) {
  return a->gain > b->gain || (a->gain == b->gain && a->point < b->point);
}

static void sink(work *w, size_t i) {
  candidate x = w->heap[i];
  for (;;) {
    size_t child = 2 * i + 1;
    if (child + 1 < w->heaped && above(&w->heap[child + 1], &w->heap[child])) child++;
    if (child >= w->heaped || !above(&w->heap[child], &x)) break;
    w->heap[i] = w->heap[child];
    i = child;
  }
  w->heap[i] = x;
}

/* Every so many points of the body are candidates. */
static void fill_heap(work *w) {
  size_t every = w->l.inside / CANDIDATES + 1, seen = 0;
  for (size_t i = 0; i < w->l.points; i++)
    if (w->l.in[i] && seen++ % every == 0) w->heap[w->heaped++] = (candidate){gain_of(w, i), i};
  for (size_t i = w->heaped / 2; i-- > 0;) sink(w, i);
}

/* The next sphere; false where the candidates cover everything. Gains only fall, so one that is still the largest when it
   is counted anew is the largest. */
static bool next_sphere(work *w, sphere *s) {
  for (;;) {
    candidate *top = &w->heap[0];
    double was = top->gain;
    if (!(was >= 1)) return false;
    top->gain = gain_of(w, top->point);
    size_t point = top->point;
    bool same = top->gain == was;
    sink(w, 0);
    if (!same) continue;
    place_of(&w->l, point, s->at);
    double gain, depth = (double)w->depth[point];
    s->radius = best_radius(w, s->at, reach(w, s->at, depth + 2 * w->l.step), &gain);
    if (!(s->radius > 0)) s->radius = depth;
    return true;
  }
}

/* -- in turn ----------------------------------------------------------------------------------------------- */

static void middle_one(work *w, size_t point, double square, void *context) {
  fit *f = context;
  double at[3];
  (void)square;
  if (!w->l.in[point] || w->cover[point]) return;
  place_of(&w->l, point, at);
  for (int a = 0; a < 3; a++) f->sum[a] += at[a];
  f->n++;
}

/* Takes another place where that gains more; s itself is not covered. */
static void try_place(work *w, const double at[3], sphere *s, double *best) {
  double gain, wanted = fmax(1.3 * s->radius, s->radius + 3 * w->l.step);
  double radius = best_radius(w, at, reach(w, at, wanted), &gain);
  if (!(gain > *best)) return;
  *best = gain;
  memcpy(s->at, at, sizeof s->at);
  s->radius = radius;
}

static void improve(work *w, sphere *s, double step) {
  double best = -1;
  sphere was = *s;
  cover(w, s, -1);
  try_place(w, was.at, s, &best);
  fit f = {.n = 0};
  visit(w, was.at, was.radius, middle_one, &f);
  double middle[3];
  for (int a = 0; a < 3; a++) middle[a] = f.n > 0 ? f.sum[a] / f.n : was.at[a];
  try_place(w, middle, s, &best);
  memcpy(was.at, s->at, sizeof was.at);
  for (int a = 0; a < 3; a++)
    for (int sign = -1; sign <= 1; sign += 2) {
      double at[3] = {was.at[0], was.at[1], was.at[2]};
      at[a] += sign * step;
      try_place(w, at, s, &best);
    }
  cover(w, s, 1);
}

/* -- making --------------------------------------------------------------------------------------------------- */

static ylm_status tell(work *w, size_t done, size_t total) {
  double now = ylm_seconds();
  if (!w->progress || now - w->told < 0.2) return YLM_OK;
  w->told = now;
  return ylm_report(w->progress, done, total, "spheres");
}

static ylm_status fit_spheres(work *w, size_t count, sphere *s, size_t *n) {
  ylm_status status = YLM_OK;
  *n = 0;
  fill_heap(w);
  while (*n < count && status == YLM_OK && next_sphere(w, &s[*n])) {
    cover(w, &s[(*n)++], 1);
    status = tell(w, *n, count * (ROUNDS + 1));
  }
  double step = 2 * w->l.step;
  for (size_t round = 1; round <= ROUNDS; round++, step *= 0.75)
    for (size_t i = 0; i < *n && status == YLM_OK; i++) {
      improve(w, &s[i], step);
      status = tell(w, round * count + i, count * (ROUNDS + 1));
    }
  return status;
}

/* Volumes, and the spheres that cover something. */
static void finish(const work *w, size_t n, const sphere *s, double *at, double *radius,
                   ylm_sphere_set *set) {
  double cell = w->l.volume / (double)w->l.inside;
  *set = (ylm_sphere_set){.volume = w->l.volume, .step = w->l.step};
  for (size_t i = 0; i < w->l.points; i++) {
    if (w->l.in[i] && !w->cover[i]) set->uncovered += cell;
    if (!w->l.in[i] && w->cover[i]) set->outside += cell;
  }
  for (size_t i = 0; i < n; i++) {
    if (!(s[i].radius > 0)) continue;
    for (size_t a = 0; a < 3; a++) at[3 * set->count + a] = s[i].at[a];
    radius[set->count++] = s[i].radius;
  }
}

ylm_status ylm_mesh_sphere_set(const ylm_mesh *m, size_t count, double *at, double *radius,
                               ylm_sphere_set *set, const ylm_progress *progress, ylm_error *e) {
  work w = {.progress = progress, .told = ylm_seconds()};
  sphere *s = NULL;
  *set = (ylm_sphere_set){.count = 0};
  if (count < 1 || count > YLM_SPHERE_SET)
    return ylm_fail(e, YLM_ERANGE, "1 to %d spheres expected, got %zu", YLM_SPHERE_SET, count);
  size_t points = POINTS_EACH * count > POINTS ? POINTS_EACH * count : POINTS, n = 0;
  ylm_mesh near = *m; /* about its own origin */
  memset(near.origin, 0, sizeof near.origin);
  ylm_status status = ylm__lattice_create(&near, points, &w.l, e);
  if (status != YLM_OK) return status;
  w.cover = ylm_alloc_zero(w.l.points, sizeof *w.cover);
  w.depth = ylm__lattice_depth(&w.l);
  w.heap = ylm_alloc(w.l.inside, sizeof *w.heap);
  w.bin = ylm_alloc(BINS_MOST, sizeof *w.bin);
  s = ylm_alloc(count, sizeof *s);
  status = w.cover && w.depth && w.heap && w.bin && s ? fit_spheres(&w, count, s, &n) : YLM_ENOMEM;
  if (status == YLM_ENOMEM) ylm_no_memory(e);
  if (status == YLM_OK) finish(&w, n, s, at, radius, set);
  for (size_t i = 0; status == YLM_OK && i < 3 * set->count; i++) at[i] += m->origin[i % 3];
  ylm_free(w.l.in);
  ylm_free(w.cover);
  ylm_free(w.depth);
  ylm_free(w.heap);
  ylm_free(w.bin);
  ylm_free(s);
  return status;
}
