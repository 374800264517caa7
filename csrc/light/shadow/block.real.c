/* block.real.c - a block of points of a query, stage by stage. */
#include "block.h"

#include <string.h>

/* The block of a thread, which keeps its lists from block to block; NULL without memory. */
static block *block_of(shadow_query *w, size_t begin, size_t end, int worker, ylm_error *e) {
  void **kept = &w->block[worker];
  if (!*kept) *kept = ylm_alloc_zero(1, sizeof(block));
  block *b = *kept;
  if (!b) return NULL;
  b->w = w;
  b->begin = begin;
  b->m = end - begin;
  b->e = e;
  b->worker = worker;
  b->seens = b->befores = b->parts = b->terms = b->lights = b->requests = 0;
  memset(b->inside, 0, sizeof b->inside);
  memset(b->any, 0, sizeof b->any);
  memset(b->lambda, 0, sizeof b->lambda);
  for (size_t i = 0; i < b->m; i++)
    for (size_t a = 0; a < 3; a++)
      b->point[i][a] = (double)((const real *)w->points)[3 * (begin + i) + a] +
                       (w->q->origin ? w->q->origin[a] : 0);
  return b;
}

void SHADOW(block_free)(void *kept) {
  block *b = kept;
  if (!b) return;
  ylm_free(b->seen);
  ylm_free(b->by_caster_first);
  ylm_free(b->by_caster);
  ylm_free(b->before);
  ylm_free(b->part);
  ylm_free(b->look);
  ylm_free(b->viewers);
  ylm_free(b->term);
  ylm_free(b->blur);
  ylm_free(b->filled);
  ylm_free(b->light);
  ylm_free(b);
}

/* Room for the results of the block's points, or none where rows of coefficients stand as they are wanted. Whatever adds to
   rows begins with 0; even light writes them. */
static bool begin_out(block *b) {
  const shadow_query *w = b->w;
  size_t wide = w->channels * w->rows * w->count;
  b->out = NULL;
  if (w->rows > 1 || w->metric || w->channels != (size_t)w->q->channels ||
      !(w->q->want & YLM_WANT_VALUE)) {
    b->out = room(b, ROOM_OUT, b->m * wide);
    if (!b->out) return false;
  }
  for (size_t i = 0; i < b->m && (!w->even || w->s->local || w->rows > 1); i++)
    memset(out_row(b, i), 0, wide * sizeof *b->out);
  return true;
}

/* Points begin .. end-1 of a query. */
ylm_status SHADOW(block)(shadow_query *w, size_t begin, size_t end, int worker, ylm_error *e) {
  const ylm_light_shadowed *s = w->s;
  block *b = block_of(w, begin, end, worker, e);
  if (!b) return YLM_ENOMEM;
  /* terms without lamps depend on what is seen alone, so that layers are known before anything is hidden */
  b->layered = s->form.layers && s->rest && !s->local && !w->exponential;
  ylm_status status = begin_out(b) ? SHADOW(see)(b) : YLM_ENOMEM;
  if (status == YLM_OK && b->seens && !b->layered) status = SHADOW(hide)(b);
  if (status == YLM_OK && s->rest)
    status = w->even ? SHADOW(add_even)(b) : SHADOW(sum_lights)(b, s->rest, true);
  if (status == YLM_OK && s->local) status = SHADOW(sum_lights)(b, s->local, false);
  size_t from = b->terms;
  for (size_t k = 0; k < s->lamps && b->seens && status == YLM_OK; k++)
    status = SHADOW(before_lamp)(b, &s->lamp[k], from);
  if (status == YLM_OK) {
    SHADOW(layer)(b);
    SHADOW(count)(b);
    if (b->layered && b->seens) status = SHADOW(hide)(b);
  }
  if (status == YLM_OK) status = SHADOW(multiply)(b);
  if (status == YLM_OK) SHADOW(write)(b);
  return status;
}

ylm_status SHADOW(even)(shadow_query *w, ylm_error *e) {
  size_t lanes = ylm_sh_nodes_lanes(w->nodes, DTYPE), values = tile_values(w);
  void *scratch = ylm_alloc(ylm_sh_nodes_scratch(w->nodes, DTYPE), 1);
  real *even = w->even = ylm_alloc_zero(even_before(w, w->channels), sizeof *even);
  real *values_of = ylm_alloc(values, sizeof *values_of);
  ylm_field_query q = {.lmax = w->q->lmax,
                       .channels = (int)w->channels,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 1,
                       .dtype = DTYPE,
                       .threads = 1,
                       .origin = w->q->origin};
  /* the room of values at nodes, of which there are more than coefficients */
  real *value = even ? even_nodes(w, 0) : NULL;
  ylm_field_result r = {.value = value};
  ylm_status s = scratch && even && values_of ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_field_evaluate(w->s->rest, &q, 1, w->points, &r, e);
  for (size_t c = 0; c < w->channels && s == YLM_OK; c++)
    memcpy(even + c * w->rows * w->count, value + c * w->count, w->count * sizeof *even);
  for (size_t c = 0; c < w->channels && s == YLM_OK; c++) {
    const void *row[16];
    real *to = even_nodes(w, c);
    for (size_t i = 0; i < lanes; i++) row[i] = even_row(w, c);
    ylm_sh_nodes_synthesise(w->nodes, DTYPE, row, false, values_of, scratch);
    w->even_most[c] = SHADOW(largest)(values_of, values, lanes, 0);
    for (size_t i = 0; i < values / lanes; i++) to[i] = values_of[i * lanes];
  }
  atomic_fetch_add(&w->pairs, r.pairs);
  ylm_free(scratch);
  ylm_free(values_of);
  return s;
}
