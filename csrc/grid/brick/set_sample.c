/* set_sample.c - sampling a grid in bricks: points brick by brick. */
#include "set.h"

#include <string.h>

/* Points in the order of their bricks. */
typedef struct sorting {
  ylm_grid_set *set;
  ylm_dtype dtype;
  const void *points;
  const double *origin;     /* [3] of the points; NULL: 0 */
  uint32_t *number, *order; /* [n] */
  size_t *first;            /* [bricks + 2] of each brick in the order */
  uint32_t *brick;          /* [bricks + 1] those that have points */
} sorting;

/* The brick of a point. */
static ylm_status find_bricks(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const sorting *t = context;
  const ylm_grid *g = t->set->top;
  leaf_cursor cursor = {.leaf = YLM_GRID_NONE};
  for (size_t i = begin; i < end; i++) {
    double p[3], at[3];
    for (size_t a = 0; a < 3; a++)
      p[a] = ylm_get(t->dtype, t->points, 3 * i + a) + (t->origin ? t->origin[a] : 0);
    ylm__grid_coordinates(g, p, at);
    t->number[i] = t->set->number[ylm__grid_leaf_again(g, &cursor, at)];
  }
  return YLM_OK;
}

static void end_sorting(sorting *t) {
  ylm_free(t->number);
  ylm_free(t->order);
  ylm_free(t->first);
  ylm_free(t->brick);
}

/* Sorts n points by brick; stable. */
static ylm_status sort_points(sorting *t, size_t n, int threads) {
  size_t bricks = t->set->bricks + 1;
  t->number = ylm_alloc(n, sizeof *t->number);
  t->order = ylm_alloc(n, sizeof *t->order);
  t->first = ylm_alloc_zero(bricks + 1, sizeof *t->first);
  t->brick = ylm_alloc(bricks, sizeof *t->brick);
  if (!t->number || !t->order || !t->first || !t->brick) return YLM_ENOMEM;
  ylm_parallel(n, 4096, threads, find_bricks, t, NULL, NULL);
  for (size_t i = 0; i < n; i++) t->first[t->number[i] + 1]++;
  for (size_t k = 0; k < bricks; k++) t->first[k + 1] += t->first[k];
  for (size_t i = 0; i < n; i++) t->order[t->first[t->number[i]]++] = (uint32_t)i;
  memmove(t->first + 1, t->first, bricks * sizeof *t->first);
  t->first[0] = 0;
  return YLM_OK;
}

/* The bricks that have points, those in memory first; how many. */
static size_t list_bricks(sorting *t) {
  size_t n = 0;
  for (int held = 1; held >= 0; held--)
    for (size_t k = 0; k <= t->set->bricks; k++)
      if (t->first[k] < t->first[k + 1] && set_holds(t->set, k) == held)
        t->brick[n++] = (uint32_t)k;
  return n;
}

/* n points of one brick, in an order: an array of them, or a list of numbers. */
typedef ylm_status set_work(void *context, const ylm_grid *g, size_t n, const uint32_t *order,
                            ylm_error *e);

/* Calls `work` for the points of each brick, at most SET_CHUNK at a time; bricks in memory first, since others take their
   place. */
static ylm_status each_brick(sorting *t, size_t n, int threads, set_work *work, void *context,
                             const ylm_progress *progress, ylm_error *e) {
  ylm_grid_set *set = t->set;
  if (n > UINT32_MAX) return ylm_fail(e, YLM_ELIMIT, "more than 2^32 points at once");
  pthread_mutex_lock(&set->lock);
  ylm_status s = sort_points(t, n, threads);
  if (s != YLM_OK) ylm_fail(e, s, "no memory to sample %zu points", n);
  size_t listed = s == YLM_OK ? list_bricks(t) : 0, done = 0;
  for (size_t i = 0; i < listed && s == YLM_OK; i++) {
    const ylm_grid *g;
    size_t k = t->brick[i], end = t->first[k + 1];
    s = ylm__set_get(set, k, threads, &g, e);
    for (size_t j = t->first[k]; j < end && s == YLM_OK; j += SET_CHUNK) {
      size_t now = end - j < SET_CHUNK ? end - j : SET_CHUNK;
      s = work(context, g, now, t->order + j, e);
      if (s == YLM_OK) s = ylm__set_report(set, progress, done += now, n, "sampling");
      if (s == YLM_OK) s = ylm__set_get(set, k, threads, &g, e);
    }
  }
  end_sorting(t);
  pthread_mutex_unlock(&set->lock);
  return s;
}

/* Do points follow one another? Then they are used where they are. */
static bool is_run(size_t n, const uint32_t *order) {
  return order[n - 1] - order[0] == n - 1; /* each once, ascending */
}

static void collect(const void *points, size_t bytes, size_t n, const uint32_t *order, char *to) {
  for (size_t i = 0; i < n; i++)
    memcpy(to + i * bytes, (const char *)points + order[i] * bytes, bytes);
}

static void distribute(void *to, size_t bytes, size_t n, const uint32_t *order, const char *from) {
  for (size_t i = 0; to && i < n; i++)
    memcpy((char *)to + order[i] * bytes, from + i * bytes, bytes);
}

/* -- samples ----------------------------------------------------------------------------------------- */

typedef struct set_sampling {
  const ylm_grid_query *q;
  const char *points;
  char *value, *gradient;
  size_t width; /* bytes of a value */
  char *point_room, *value_room, *gradient_room;
  ylm_grid_report report;
} set_sampling;

static ylm_status sample_brick(void *context, const ylm_grid *g, size_t n, const uint32_t *order,
                               ylm_error *e) {
  set_sampling *j = context;
  ylm_grid_query q = *j->q;
  ylm_grid_report report;
  size_t point = 3 * ylm_dtype_size(q.point_dtype), at = order[0];
  bool run = is_run(n, order);
  q.progress = NULL;
  if (!run) collect(j->points, point, n, order, j->point_room);
  ylm_status s = ylm_grid_sample(g, &q, n, run ? j->points + at * point : j->point_room,
                                 run ? j->value + at * j->width : j->value_room,
                                 !j->gradient ? NULL
                                 : run        ? j->gradient + 3 * at * j->width
                                              : j->gradient_room,
                                 &report, e);
  if (!run) distribute(j->value, j->width, n, order, j->value_room);
  if (!run) distribute(j->gradient, 3 * j->width, n, order, j->gradient_room);
  j->report.outside += report.outside;
  j->report.unbaked += report.unbaked;
  return s;
}

ylm_status ylm_grid_set_sample(ylm_grid_set *set, const ylm_grid_query *q, size_t n,
                               const void *points, void *value, void *gradient,
                               ylm_grid_report *report, ylm_error *e) {
  double begin = ylm_seconds();
  size_t most = n < SET_CHUNK ? n : SET_CHUNK, width = set->top->width * ylm_dtype_size(q->dtype);
  set_sampling j = {.q = q,
                    .points = points,
                    .value = value,
                    .gradient = gradient,
                    .width = width,
                    .point_room = ylm_alloc(most, 3 * sizeof(double)),
                    .value_room = ylm_alloc(most, width),
                    .gradient_room = ylm_alloc(gradient ? most : 0, 3 * width)};
  sorting t = {.set = set, .dtype = q->point_dtype, .points = points, .origin = q->origin};
  ylm_status s = YLM_ENOMEM;
  if (j.point_room && j.value_room && j.gradient_room)
    s = each_brick(&t, n, q->threads, sample_brick, &j, q->progress, e);
  else
    ylm_fail(e, s, "no memory to sample %zu points", n);
  ylm_free(j.point_room);
  ylm_free(j.value_room);
  ylm_free(j.gradient_room);
  j.report.seconds = ylm_seconds() - begin;
  if (report) *report = j.report;
  return s;
}

/* -- the field ----------------------------------------------------------------------------------------- */

typedef struct set_asking {
  const ylm_field_query *q;
  const char *points;
  ylm_field_result *r;
  size_t width; /* numbers of a value */
  char *room;   /* SET_CHUNK rows: point, value, gradient, lambda, norm, inside */
} set_asking;

static ylm_status ask_brick(void *context, const ylm_grid *g, size_t n, const uint32_t *order,
                            ylm_error *e) {
  const set_asking *j = context;
  ylm_field_result *r = j->r;
  size_t size = ylm_dtype_size(j->q->dtype), w = j->width * size;
  char *point = j->room, *value = point + 3 * size * n, *gradient = value + w * n,
       *lambda = gradient + 3 * w * n, *norm = lambda + size * n, *inside = norm + size * n;
  ylm_field_query q = *j->q;
  ylm_field_result part = {.value = r->value ? value : NULL,
                           .gradient = r->gradient ? gradient : NULL,
                           .lambda = r->lambda ? lambda : NULL,
                           .norm = r->norm ? norm : NULL,
                           .inside = r->inside ? (uint8_t *)inside : NULL};
  q.progress = NULL;
  collect(j->points, 3 * size, n, order, point);
  ylm_status s = g->field.evaluate(&g->field, &q, n, point, &part, e);
  if (s != YLM_OK) return s;
  if (q.want & YLM_WANT_VALUE) distribute(r->value, w, n, order, value);
  if (q.want & YLM_WANT_GRADIENT) distribute(r->gradient, 3 * w, n, order, gradient);
  if (q.want & YLM_WANT_METRIC) distribute(r->lambda, size, n, order, lambda);
  if (q.want & YLM_WANT_METRIC) distribute(r->norm, size, n, order, norm);
  distribute(r->inside, 1, n, order, inside);
  return s;
}

ylm_status ylm__set_evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                             const void *points, ylm_field_result *r, ylm_error *e) {
  ylm_grid_set *set = (ylm_grid_set *)(uintptr_t)f->self;
  size_t width = (size_t)(q->channels * (q->lmax + 1) * (q->lmax + 1)),
         most = n < SET_CHUNK ? n : SET_CHUNK;
  size_t row = ylm_dtype_size(q->dtype) * (3 + 4 * width + 2) + 1;
  if (q->lmax > set->top->contents.form.lmax)
    return ylm_fail(e, YLM_ERANGE, "the grid has coefficients up to lmax %d, %d is wanted",
                    set->top->contents.form.lmax, q->lmax);
  set_asking j = {q, points, r, width, ylm_alloc(most, row)};
  sorting t = {.set = set, .dtype = q->dtype, .points = points, .origin = q->origin};
  if (!j.room) return ylm_fail(e, YLM_ENOMEM, "no memory to sample %zu points", n);
  ylm_status s = each_brick(&t, n, q->threads, ask_brick, &j, q->progress, e);
  ylm_free(j.room);
  return s;
}
