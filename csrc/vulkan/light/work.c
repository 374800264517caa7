/* work.c - the steps that evaluate a pass of points: sums, their reduction, maps, metric. */
#include <stdio.h>
#include <string.h>

#include "../device/steps.h"
#include "../gen/layout.h"
#include "lights.h"

#define ROWS 8u /* rows of a group of shaders/rows.real.comp */

/* -- steps ------------------------------------------------------------------------------ */

/* A pass, and the steps that it takes. */
typedef struct sum_steps {
  step_queue queue;
  ylm_gpu_lights *l;
  const sum_plan *p;
  const ylm_field_query *q;
  uint32_t n, stride;
} sum_steps;

static void clear(sum_steps *s, int which, uint64_t bytes) {
  s->queue.stage = "clearing";
  if (bytes)
    ylm__steps_work(&s->queue, &(ylm_gpu_work){.verb = YLM_GPU_FILL,
                                               .binds = 1,
                                               .bind = {{s->l->scratch[which], 0, bytes}}});
}

/* A dispatch of a kernel in the plan's precision, the group's size being its first constant. */
typedef struct sum_step {
  const char *stage, *kernel;
  int constants, words, binds;
  uint32_t constant[8];
  const uint32_t *push;
  const ylm_gpu_bind *bind;
  uint64_t groups;
  double cost; /* of a group */
} sum_step;

static void add_step(sum_steps *s, const sum_step *x) {
  char name[32];
  ylm_gpu_kernel *kernel = NULL;
  if (s->queue.status != YLM_OK || !x->groups) return;
  snprintf(name, sizeof name, "%s_%s", x->kernel, s->p->dtype == YLM_DOUBLE ? "double" : "float");
  s->queue.status =
      ylm_gpu_kernel_get(s->l->gpu, name, x->constants, x->constant, &kernel, s->queue.e);
  s->queue.stage = x->stage;
  ylm_gpu_work w = {.kernel = kernel,
                    .groups = x->groups,
                    .cost = x->cost,
                    .push = x->push,
                    .push_bytes = (size_t)x->words * 4,
                    .binds = x->binds};
  memcpy(w.bind, x->bind, (size_t)x->binds * sizeof *x->bind);
  ylm__steps_work(&s->queue, &w);
}

static ylm_gpu_bind whole(ylm_gpu_buffer *b) { return (ylm_gpu_bind){b, 0, 0}; }

/* -- sums ------------------------------------------------------------------------------ */

static size_t real_size(const sum_steps *s) { return ylm_dtype_size(s->p->dtype); }

/* A step of a pass: its kernel with constants. */
static sum_step pass_step(const sum_steps *s, const sum_set *set, const struct sum_pass *pass) {
  const ylm_gpu_lights *l = s->l;
  uint32_t c[] = {GROUP,
                  (uint32_t)s->p->lmax,
                  pass->loops ? (uint32_t)ylm__sum_derivatives(set->kinds) : set->kinds,
                  pass->m_first,
                  pass->m_last,
                  l->cosines.kind != NULL,
                  pass->block,
                  s->p->grow};
  if (pass->items) c[2] = pass->kinds;
  if (pass->rims) {
    memset(c + 1, 0, sizeof c - sizeof *c); /* one pipeline for every lmax */
    c[2] = pass->kinds, c[6] = l->rims.cut, c[7] = s->p->dtype == YLM_DOUBLE;
  }
  sum_step step = {.stage = "lights", .constants = pass->items ? 8 : 6};
  memcpy(step.constant, c, sizeof c);
  bool low = s->p->lmax <= YLM_GPU_LOW_LMAX;
  step.kernel = pass->rims        ? "rims"
                : pass->items     ? "moments_any"
                : pass->loops     ? low ? "product_low" : "product"
                : pass->second    ? low ? "flat_second_low" : "flat_second"
                : l->cosines.kind ? low ? "flat_low" : "flat"
                : low             ? "moments_low"
                                  : "moments";
  return step;
}

/* One chunk range of a pass along rims: a group has a point. */
static void add_rims(sum_steps *s, const sum_set *set, const struct sum_pass *pass,
                     uint32_t chunk_first, uint32_t chunks) {
  const rim_set *r = &s->l->rims;
  uint32_t push[] = {s->n,        s->stride,           r->arcs,   r->chunk,    chunk_first,
                     chunks,      set->channel_first,  set->sums, pass->parts, 0,
                     pass->items, (uint32_t)s->p->lmax};
  ylm_gpu_bind bind[] = {whole(s->l->scratch[BUFFER_POINTS]),
                         whole(r->row),
                         whole(s->l->scratch[BUFFER_PARTIAL]),
                         whole(s->l->scratch[BUFFER_INSIDE]),
                         whole(pass->item),
                         whole(s->p->betas),
                         whole(r->rule),
                         whole(r->arc)};
  sum_step step = pass_step(s, set, pass);
  step.words = 12, step.push = push, step.binds = 8, step.bind = bind;
  step.groups = (uint64_t)s->n * pass->items * chunks * set->channels;
  step.cost = (double)r->chunk * GROUP;
  add_step(s, &step);
}

/* One chunk range of all passes of a set, into BUFFER_PARTIAL. */
static void add_sums(sum_steps *s, const sum_set *set, uint32_t chunk_first, uint32_t chunks) {
  const ylm_gpu_lights *l = s->l;
  for (int i = 0; i < set->passes; i++) {
    const struct sum_pass *pass = &set->pass[i];
    if (pass->rims) {
      add_rims(s, set, pass, chunk_first, chunks);
      continue;
    }
    uint32_t items = pass->items ? pass->items : 1;
    uint32_t push[] = {s->n,   s->stride,          l->active, l->chunk,    chunk_first,
                       chunks, set->channel_first, set->sums, pass->parts, pass->part,
                       items};
    ylm_gpu_bind bind[] = {whole(l->scratch[BUFFER_POINTS]),
                           whole(l->lamps[s->p->dtype]),
                           whole(l->scratch[BUFFER_PARTIAL]),
                           whole(l->scratch[BUFFER_INSIDE]),
                           whole(pass->item),
                           whole(s->p->constants)};
    sum_step step = pass_step(s, set, pass);
    step.words = 11, step.push = push, step.binds = pass->items ? 6 : 4, step.bind = bind;
    step.groups = (uint64_t)(s->stride / GROUP) * items * chunks * set->channels;
    step.cost = (double)l->chunk * GROUP;
    add_step(s, &step);
  }
}

/* Adds these partial sums to the totals, which begin at element `total`. */
static void add_reduction(sum_steps *s, const sum_set *set, uint64_t total, uint32_t chunks) {
  uint32_t row = set->sums * s->stride, elements = set->channels * row;
  uint32_t push[] = {elements, row, chunks};
  uint64_t at = total * s->stride * real_size(s), bytes = elements * real_size(s);
  ylm_gpu_bind bind[] = {whole(s->l->scratch[BUFFER_PARTIAL]),
                         {s->l->scratch[BUFFER_TOTAL], at, bytes},
                         {s->l->scratch[BUFFER_LOST], at, bytes}};
  add_step(s,
           &(sum_step){"adding", "reduce", 1, 3, 3, {GROUP}, push, bind, elements / GROUP, chunks});
}

static void add_set(sum_steps *s, const sum_set *set, uint64_t total, uint32_t at_once) {
  uint32_t all = ylm__lights_chunks(s->l);
  for (uint32_t first = 0; set->channels && first < all; first += at_once) {
    uint32_t chunks = all - first < at_once ? all - first : at_once;
    add_sums(s, set, first, chunks);
    add_reduction(s, set, total, chunks);
  }
}

/* -- maps -------------------------------------------------------------------------------- */

/* Sums in a buffer: element `first` on. */
typedef struct place {
  int buffer;
  uint32_t first;
} place;

/* y = A x. Results go to y's element `first` + row * to_row + point * to_point. */
static void add_rows(sum_steps *s, const device_rows *A, place x, place y, uint32_t to_row,
                     uint32_t to_point) {
  uint32_t push[] = {s->n, s->stride, A->n, x.first * s->stride, y.first, to_row, to_point};
  if (!A->n) return;
  ylm_gpu_bind bind[] = {whole(s->l->scratch[x.buffer]), whole(s->l->scratch[y.buffer]),
                         whole(A->start), whole(A->index), whole(A->coef)};
  add_step(s, &(sum_step){"coefficients",
                          "rows",
                          1,
                          7,
                          5,
                          {GROUP},
                          push,
                          bind,
                          (uint64_t)(s->stride / GROUP) * ((A->n + ROWS - 1) / ROWS),
                          (double)A->terms / A->n * ROWS * GROUP});
}

/* The sums that kind `kind` of channel c of `channels` follows from, and the maps. */
static place source(const sum_steps *s, int kind, int channels, uint32_t c, const device_maps **m) {
  const sum_plan *p = s->p;
  uint32_t lum = p->lum.channels ? p->lum.sums : 0;
  if (channels == 3) return *m = &p->from_rgb, (place){BUFFER_TOTAL, lum + c * p->rgb.sums};
  if (p->mixed & kind) return *m = &p->from_mixed, (place){BUFFER_MIXED, 0};
  return *m = &p->from_lum, (place){BUFFER_TOTAL, 0};
}

/* Hessians of channel c, to y. */
static void add_hessian(sum_steps *s, int channels, uint32_t c, place y, uint32_t to_row,
                        uint32_t to_point) {
  const device_maps *m;
  place x = source(s, 4, channels, c, &m);
  if (m->to_u.n) {
    add_rows(s, &m->to_u, x, (place){BUFFER_U, 0}, s->stride, 1);
    x = (place){BUFFER_U, 0};
  }
  add_rows(s, &m->hessian, x, y, to_row, to_point);
}

static void add_results(sum_steps *s) {
  const ylm_field_query *q = s->q;
  uint32_t count = (uint32_t)(q->lmax + 1) * (uint32_t)(q->lmax + 1), C = (uint32_t)q->channels;
  const device_maps *m;
  for (uint32_t c = 0; c < C; c++) {
    if (q->want & YLM_WANT_VALUE) {
      place x = source(s, 1, q->channels, c, &m);
      add_rows(s, &m->value, x, (place){BUFFER_VALUE, c * count}, 1, C * count);
    }
    if (q->want & YLM_WANT_GRADIENT) {
      place x = source(s, 2, q->channels, c, &m);
      add_rows(s, &m->gradient, x, (place){BUFFER_GRADIENT, c * 3 * count}, 1, C * 3 * count);
    }
    if (q->want & YLM_WANT_HESSIAN)
      add_hessian(s, q->channels, c, (place){BUFFER_HESSIAN, c * 6 * count}, 1, C * 6 * count);
  }
}

static void add_metric(sum_steps *s) {
  const ylm_field_query *q = s->q;
  uint32_t count = (uint32_t)(q->lmax + 1) * (uint32_t)(q->lmax + 1);
  uint32_t channels = (uint32_t)q->metric_channels;
  const device_maps *m;
  for (uint32_t c = 0; c < channels; c++) {
    place x = source(s, 1, q->metric_channels, c, &m);
    add_rows(s, &m->value, x, (place){BUFFER_METRIC_VALUE, c * count * s->stride}, s->stride, 1);
    add_hessian(s, q->metric_channels, c, (place){BUFFER_METRIC_HESSIAN, c * 6 * count * s->stride},
                s->stride, 1);
  }
  uint32_t push[] = {s->n, s->stride, channels * count};
  ylm_gpu_bind bind[] = {whole(s->l->scratch[BUFFER_METRIC_VALUE]),
                         whole(s->l->scratch[BUFFER_METRIC_HESSIAN]),
                         whole(s->l->scratch[BUFFER_LAMBDA]), whole(s->l->scratch[BUFFER_NORM])};
  add_step(
      s,
      &(sum_step){
          "metric", "metric", 1, 3, 4, {GROUP}, push, bind, s->stride / GROUP, channels * count});
}

/* -- memory -------------------------------------------------------------------------------- */

/* Elements of type real that a point takes in each buffer (BUFFER_PARTIAL: of one chunk). */
static void elements(const sum_plan *p, const ylm_field_query *q, size_t n[BUFFERS]) {
  size_t count = (size_t)(q->lmax + 1) * (size_t)(q->lmax + 1), C = (size_t)q->channels;
  size_t to_u = 3 * (size_t)(q->lmax + 2) * (size_t)(q->lmax + 2);
  size_t lum = p->lum.channels * p->lum.sums, rgb = p->rgb.channels * p->rgb.sums;
  size_t metric = q->want & YLM_WANT_METRIC ? (size_t)q->metric_channels * count : 0;
  memset(n, 0, BUFFERS * sizeof *n);
  n[BUFFER_POINTS] = 3;
  n[BUFFER_PARTIAL] = lum > rgb ? lum : rgb;
  n[BUFFER_TOTAL] = n[BUFFER_LOST] = lum + rgb;
  n[BUFFER_MIXED] = p->mixed ? p->rgb.sums : 0;
  n[BUFFER_U] = (p->need_lum | p->need_rgb) & 4 ? to_u : 0;
  n[BUFFER_METRIC_VALUE] = metric;
  n[BUFFER_METRIC_HESSIAN] = 6 * metric;
  n[BUFFER_LAMBDA] = n[BUFFER_NORM] = metric ? 1 : 0;
  n[BUFFER_VALUE] = q->want & YLM_WANT_VALUE ? C * count : 0;
  n[BUFFER_GRADIENT] = q->want & YLM_WANT_GRADIENT ? 3 * C * count : 0;
  n[BUFFER_HESSIAN] = q->want & YLM_WANT_HESSIAN ? 6 * C * count : 0;
  n[BUFFER_INSIDE] = 1;
}

sum_size ylm__sum_size(const sum_plan *p, const ylm_field_query *q) {
  size_t n[BUFFERS], real = ylm_dtype_size(p->dtype);
  sum_size s = {0, 0, 0};
  elements(p, q, n);
  for (int i = 0; i < BUFFERS; i++) {
    if (n[i] * real > s.widest) s.widest = n[i] * real;
    if (i != BUFFER_PARTIAL) s.all += n[i] * real;
  }
  s.partial = n[BUFFER_PARTIAL] * real;
  return s;
}

/* -- a pass ----------------------------------------------------------------------------------- */

static void reserve(sum_steps *s, uint32_t chunks) {
  size_t n[BUFFERS];
  elements(s->p, s->q, n);
  n[BUFFER_PARTIAL] *= chunks;
  for (int i = 0; i < BUFFERS && s->queue.status == YLM_OK; i++)
    s->queue.status = ylm__lights_scratch(s->l, i, n[i] * s->stride * real_size(s), s->queue.e);
  clear(s, BUFFER_TOTAL, n[BUFFER_TOTAL] * s->stride * real_size(s));
  clear(s, BUFFER_LOST, n[BUFFER_LOST] * s->stride * real_size(s));
  clear(s, BUFFER_INSIDE, s->stride * 4);
}

ylm_status ylm__sum_run(ylm_gpu_lights *l, const sum_plan *p, const ylm_field_query *q, uint32_t n,
                        uint32_t at_once, const ylm_progress *progress, ylm_error *e) {
  sum_steps s = {.queue = {.g = l->gpu, .times = &l->times, .progress = progress, .e = e},
                 .l = l,
                 .p = p,
                 .q = q,
                 .n = n,
                 .stride = (n + GROUP - 1) / GROUP * GROUP};
  reserve(&s, at_once);
  add_set(&s, &p->lum, 0, at_once);
  add_set(&s, &p->rgb, p->lum.channels * p->lum.sums, at_once);
  if (p->mixed)
    add_rows(&s, &p->mix, (place){BUFFER_TOTAL, p->lum.channels * p->lum.sums},
             (place){BUFFER_MIXED, 0}, s.stride, 1);
  add_results(&s);
  if (q->want & YLM_WANT_METRIC) add_metric(&s);
  ylm_status status = ylm__steps_run(&s.queue);
  ylm__steps_free(&s.queue);
  return status;
}
