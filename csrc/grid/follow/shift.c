/*
** shift.c - bringing the points that need it up to date.
**
** A point gets the difference of the state that its data have a light in and the present one: a
** field of one channel, as a rule, since a light that moves keeps its colour. Points are worked on
** in chunks, so that a chunk's rows are read once: kept for taking back, changed, measured, signed.
*/
#include "calibration.h"
#include "update.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* Which points are to be evaluated anew, and which get the difference. */
ylm_status ylm__update_choose_points(update *u) {
  ylm_grid *g = u->g;
  uint8_t *what = ylm_alloc(g->evaluated, 1);
  u->exact = ylm_alloc(g->evaluated, sizeof *u->exact);
  u->shift = ylm_alloc(g->evaluated, sizeof *u->shift);
  u->changed = ylm_alloc_zero(g->points, 1);
  ylm_status s = what && u->exact && u->shift && u->changed ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__grid_find_stale(g, u->tolerance, u->source.threads, what);
  for (uint32_t p = 0; s == YLM_OK && p < g->evaluated; p++) {
    if (what[p] == STALE_EXACT) u->exact[u->exacts++] = p;
    if (what[p] == STALE_SHIFT) u->shift[u->shifts++] = p;
    u->stats.skipped += what[p] == STALE_SKIPPED;
    u->changed[p] = what[p] == STALE_EXACT || what[p] == STALE_SHIFT;
  }
  ylm_free(what);
  return s;
}

/* -- differences ------------------------------------------------------------------------------- */

/* Scratch of a thread: the field at points of a chunk, and lists of these. */
typedef struct shift_work {
  float *position, *value, *gradient, *hessian; /* [SHIFT_CHUNK][..] */
  float *room;                                  /* [10 count] */
  double seconds;
  uint64_t pairs;
} shift_work;

typedef struct shift_job {
  update *u;
  shift_work *work;
  ylm_light_lambda2_fn *lambda2;
} shift_job;

/* Adds lights that are alike, one or two, of radiance `strength` times `colour`, at the n points
   `list`. */
static ylm_status add_lights(const shift_job *j, shift_work *w, size_t lights,
                             const ylm_light *const *light, const double *strength,
                             const double colour[3], size_t n, const uint32_t *list) {
  ylm_grid *g = j->u->g;
  ylm_light_set *set;
  ylm_status s = ylm_light_set_of(lights, light, strength, &set);
  const ylm_field *f = s == YLM_OK ? ylm_light_set_field(set) : NULL;
  for (size_t i = 0; i < n; i++) ylm__grid_asked(g, list[i], w->position + 3 * i);
  ylm_field_query q = {.lmax = g->contents.form.lmax,
                       .channels = 1,
                       .metric_channels = 1,
                       .dtype = YLM_FLOAT,
                       .threads = 1,
                       .origin = ylm__grid_origin(g),
                       .want = YLM_WANT_VALUE | YLM_WANT_GRADIENT |
                               (w->hessian ? YLM_WANT_HESSIAN : 0)};
  ylm_field_result r = {.value = w->value, .gradient = w->gradient, .hessian = w->hessian};
  double t = ylm_seconds();
  if (s == YLM_OK) s = ylm_field_evaluate(f, &q, n, w->position, &r, NULL);
  w->seconds += ylm_seconds() - t;
  w->pairs += r.pairs;
  ylm_light_set_free(set);
  size_t count = (size_t)g->contents.count;
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    ylm__dynamic_add(g, list[i],
                     &(point_change){w->value + i * count, w->gradient + 3 * i * count,
                                     w->hessian ? w->hessian + 6 * i * count : NULL,
                                     w->position + 3 * i, colour},
                     w->room);
  return s;
}

/* The length of a radiance, and its direction; darkness has that of `other`. */
static double colour_of(const double x[3], const double other[3], double colour[3]) {
  double s = 0;
  for (int c = 0; c < 3; c++) s += x[c] * x[c];
  const double *from = s > 0 ? x : other;
  double length = 0;
  for (int c = 0; c < 3; c++) length += from[c] * from[c];
  for (int c = 0; c < 3; c++) colour[c] = length > 0 ? from[c] / sqrt(length) : 0;
  return sqrt(s);
}

/* Subtracts the light a and adds b. */
static ylm_status exchange(const shift_job *j, shift_work *w, const ylm_light *a,
                           const ylm_light *b, size_t n, const uint32_t *list) {
  double colour[2][3], along = 0, off = 0;
  double strength[2] = {-colour_of(a->radiance, b->radiance, colour[0]),
                        colour_of(b->radiance, a->radiance, colour[1])};
  for (int c = 0; c < 3; c++) along += colour[0][c] * colour[1][c];
  for (int c = 0; c < 3; c++) off = fmax(off, fabs(colour[0][c] - along * colour[1][c]));
  if (off < 1e-9 && ylm_light_alike(a, b)) { /* one colour, or two opposite ones */
    strength[0] *= along;
    return add_lights(j, w, 2, (const ylm_light *const[]){a, b}, strength, colour[1], n, list);
  }
  ylm_status s = YLM_OK;
  if (strength[0] != 0) s = add_lights(j, w, 1, &a, strength, colour[0], n, list);
  if (s == YLM_OK && strength[1] != 0)
    s = add_lights(j, w, 1, &b, strength + 1, colour[1], n, list);
  return s;
}

/* Brings n points, at most SHIFT_CHUNK, up to date for one mover, one state after the other. */
static ylm_status follow_mover(const shift_job *j, shift_work *w, mover *m, size_t n,
                               const uint32_t *point) {
  uint32_t list[SHIFT_CHUNK];
  size_t first[STATES + 1] = {0}, next[STATES];
  for (size_t i = 0; i < n; i++) first[m->seen[point[i]] + 1]++;
  for (int k = 0; k < STATES; k++) first[k + 1] += first[k], next[k] = first[k];
  for (size_t i = 0; i < n; i++) list[next[m->seen[point[i]]]++] = point[i];
  for (int k = 0; k < STATES; k++) {
    size_t some = first[k + 1] - first[k];
    if (k == m->current || some == 0) continue;
    ylm_status s = exchange(j, w, &m->state[k], &m->state[m->current], some, list + first[k]);
    if (s != YLM_OK) return s;
    for (size_t i = first[k]; i < first[k + 1]; i++) m->seen[list[i]] = (uint8_t)m->current;
  }
  return YLM_OK;
}

static ylm_status shift_chunk(void *context, size_t begin, size_t end, int worker) {
  const shift_job *j = context;
  update *u = j->u;
  const uint32_t *point = u->shift + begin;
  ylm_status s = YLM_OK;
  for (size_t i = begin; i < end; i++)
    ylm__update_log_row(u, u->old.logs - u->shifts + i, u->shift[i]);
  for (size_t m = 0; m < u->d->movers && s == YLM_OK; m++)
    s = follow_mover(j, &j->work[worker], &u->d->mover[m], end - begin, point);
  for (size_t i = 0; i < end - begin && s == YLM_OK; i++)
    ylm__dynamic_measure(u->g, point[i], j->lambda2);
  return s;
}

/* -- all together ------------------------------------------------------------------------------ */

/* Sorts the points by the first state that is not the present one, so that chunks are mostly of one
   state. */
static ylm_status sort_shifts(update *u) {
  const grid_dynamic *d = u->d;
  size_t kinds = d->movers * STATES + 1;
  uint32_t *other = ylm_alloc(u->shifts, sizeof *other), *kind = ylm_alloc(u->shifts, sizeof *kind);
  size_t *next = ylm_alloc_zero(kinds + 1, sizeof *next);
  ylm_status s = other && kind && next ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < u->shifts; i++) {
    size_t m = 0;
    while (m < d->movers && d->mover[m].seen[u->shift[i]] == d->mover[m].current) m++;
    kind[i] = (uint32_t)(m * STATES + (m < d->movers ? d->mover[m].seen[u->shift[i]] : 0));
    next[kind[i] + 1]++;
  }
  for (size_t k = 0; s == YLM_OK && k < kinds; k++) next[k + 1] += next[k];
  for (size_t i = 0; s == YLM_OK && i < u->shifts; i++) other[next[kind[i]]++] = u->shift[i];
  if (s == YLM_OK) memcpy(u->shift, other, u->shifts * sizeof *other);
  ylm_free(other);
  ylm_free(kind);
  ylm_free(next);
  return s;
}

static void free_work(shift_job *j, int threads) {
  for (int i = 0; j->work && i < threads; i++) {
    shift_work *w = &j->work[i];
    ylm_free(w->position);
    ylm_free(w->value);
    ylm_free(w->gradient);
    ylm_free(w->hessian);
    ylm_free(w->room);
  }
  ylm_free(j->work);
}

static ylm_status make_work(shift_job *j, int threads) {
  size_t count = (size_t)j->u->g->contents.count, size = SHIFT_CHUNK * sizeof(float);
  bool hessians = j->u->d->hessians > 0, ok = true;
  j->work = ylm_alloc_zero((size_t)threads, sizeof *j->work);
  for (int i = 0; j->work && i < threads && ok; i++) {
    shift_work *w = &j->work[i];
    w->position = ylm_alloc(3, size);
    w->value = ylm_alloc(count, size);
    w->gradient = ylm_alloc(3 * count, size);
    w->hessian = hessians ? ylm_alloc(6 * count, size) : NULL;
    w->room = ylm_alloc(10 * count, sizeof(float));
    ok = w->position && w->value && w->gradient && w->room && (w->hessian || !hessians);
  }
  return j->work && ok ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm__update_shift_all(update *u) {
  int threads = ylm_threads(u->source.threads);
  shift_job j = {.u = u, .lambda2 = ylm_light_lambda2()};
  if (!u->shifts) return YLM_OK;
  ylm_status s = make_work(&j, threads);
  if (s == YLM_OK) s = sort_shifts(u);
  if (s == YLM_OK)
    s = ylm_parallel(u->shifts, SHIFT_CHUNK, threads, shift_chunk, &j, u->b.making.progress,
                     "updating");
  size_t chunks = (u->shifts + SHIFT_CHUNK - 1) / SHIFT_CHUNK;
  double together = chunks < (size_t)threads ? (double)chunks : threads;
  for (int i = 0; j.work && i < threads; i++) {
    u->g->stats.field_seconds += j.work[i].seconds / together;
    u->g->stats.pairs += j.work[i].pairs;
  }
  free_work(&j, threads);
  return s;
}
