/*
** octree_points.c - the corners of a level's voxels on a device: found in a table, numbered, and
** evaluated where they are new.
*/
#include <string.h>

#include "octree.h"

/* Data that wait on the device are brought to the host beyond so many bytes. */
#define PENDING_BYTES ((uint64_t)1 << 30)
#define MOST_VOXELS (1u << 27) /* of a level: candidates are numbered by 30 bits */

/* -- the table ----------------------------------------------------------------------------- */

/* A table at most half full with `more` points beside those there are. */
static ylm_status reserve_table(octree *t, uint64_t more) {
  uint64_t slots = t->slots ? t->slots : 1024;
  while (slots < 2 * (t->points + more)) slots *= 2;
  if (slots == t->slots) return YLM_OK;
  if (slots > (uint64_t)1 << 31)
    return ylm_fail(t->e, YLM_ELIMIT, "more than 2^30 points on a device");
  ylm_gpu_buffer_free(t->slot);
  t->slot = NULL;
  t->slots = (uint32_t)slots;
  ylm_status s = ylm_gpu_buffer_create(t->g, 4 * slots, &t->slot, t->e);
  if (s != YLM_OK) return s;
  steps_fill(&t->q, t->slot, UINT32_MAX);
  step_kernel k = {"octree_insert", 1, {1, 0}, 0};
  uint32_t push[] = {t->points, 0, t->slots - 1};
  ylm_gpu_buffer *bind[] = {t->slot, t->key, t->level[0].voxel};
  if (t->points) steps_dispatch(&t->q, &k, t->points, 3, push, 3, bind);
  return YLM_OK;
}

/* A buffer that keeps its first `used` bytes as it grows; what waits is done first. */
static ylm_status grow(octree *t, ylm_gpu_buffer **b, uint64_t used, uint64_t bytes) {
  ylm_gpu_buffer *more;
  ylm_status s = steps_run(&t->q);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, bytes, &more, t->e);
  if (s != YLM_OK) return s;
  if (used) steps_copy(&t->q, *b, used, more);
  s = steps_run(&t->q);
  ylm_gpu_buffer_free(*b);
  *b = more;
  return s;
}

static ylm_status reserve_points(octree *t, uint32_t more) {
  uint64_t wanted = (uint64_t)t->points + more, room = 2 * (uint64_t)t->room;
  size_t most = t->source->max_points;
  if ((most && wanted > most) || wanted >= YLM_GRID_NONE)
    return ylm_fail(t->e, YLM_ELIMIT, "the grid needs more than %zu points",
                    most ? most : (size_t)YLM_GRID_NONE);
  if (wanted <= t->room) return YLM_OK;
  if (room < wanted) room = wanted;
  uint64_t bind = ylm_gpu_about(t->g)->bind_bytes / 8;
  if (room > bind && wanted <= bind) room = bind;
  ylm_status s = grow(t, &t->key, 8 * (uint64_t)t->points, 8 * room);
  if (s == YLM_OK) s = grow(t, &t->ratio, 4 * (uint64_t)t->points, 4 * room);
  if (s == YLM_OK) t->room = (uint32_t)room;
  return s;
}

/* -- a level's corners --------------------------------------------------------------------- */

/* No more points than so many are new: all corners, or those of cells that were split. */
static uint64_t most_fresh(const octree *t, int level) {
  uint64_t corners = 8 * (uint64_t)t->level[level].voxels;
  uint64_t inner = level ? 19 * (uint64_t)t->level[level - 1].splits : 8;
  return corners < inner ? corners : inner;
}

/* Corners as entries of the table; *fresh of them are new. */
static ylm_status find_corners(octree *t, int level, uint32_t *fresh) {
  octree_level *v = &t->level[level];
  uint32_t n = 8 * v->voxels, edge = octree_edge(t, level), count[COUNTS];
  ylm_status s = reserve_table(t, most_fresh(t, level));
  if (s == YLM_OK && !t->key) s = reserve_points(t, 8);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, 4 * (uint64_t)n, &v->corner, t->e);
  if (s == YLM_OK) s = steps_reserve(t->g, &t->before[0], 4 * (uint64_t)n, t->e);
  if (s != YLM_OK) return s;
  step_kernel insert = {"octree_insert", 1, {0, 0}, 0}, find = {"octree_find", 0, {0, 0}, 0};
  uint32_t push[] = {n, edge, t->slots - 1};
  ylm_gpu_buffer *bind[] = {t->slot, t->key, v->voxel, v->corner};
  steps_dispatch(&t->q, &insert, n, 3, push, 3, bind);
  steps_dispatch(&t->q, &find, n, 3, push, 4, bind);
  steps_scan(&t->q, SCAN_OWN, 0, v->corner, n, t->before[0], t->counts, COUNT_FRESH);
  s = octree_counts(t, count);
  *fresh = count[COUNT_FRESH];
  return s;
}

/* Gives new points their numbers. */
static void number_corners(octree *t, int level) {
  octree_level *v = &t->level[level];
  uint32_t n = 8 * v->voxels, push[] = {n, octree_edge(t, level), t->points};
  step_kernel number = {"octree_number", 0, {0, 0}, 0}, settle = {"octree_settle", 0, {0, 0}, 0};
  ylm_gpu_buffer *bind[] = {v->corner, t->before[0], t->key, v->voxel};
  steps_dispatch(&t->q, &number, n, 3, push, 4, bind);
  uint32_t slots[] = {t->slots, t->points};
  ylm_gpu_buffer *table[] = {t->slot, t->before[0]};
  steps_dispatch(&t->q, &settle, t->slots, 2, slots, 2, table);
}

/* -- evaluating ---------------------------------------------------------------------------- */

static ylm_field_query query_of(const octree *t) {
  return (ylm_field_query){.lmax = t->form.lmax,
                           .channels = t->form.channels,
                           .want = YLM_WANT_VALUE | YLM_WANT_GRADIENT | YLM_WANT_METRIC,
                           .metric_channels = t->form.metric_channels,
                           .dtype = YLM_FLOAT};
}

/* Room for the data of n points from `first` on. */
static ylm_status add_chunk(octree *t, uint32_t first, uint32_t n) {
  uint64_t data = 16 * (uint64_t)n * t->stride, extra = 12 * (uint64_t)n;
  uint64_t most = ylm_gpu_about(t->g)->memory_bytes / 4;
  if (t->pending + data > (most < PENDING_BYTES ? most : PENDING_BYTES)) {
    ylm_status s = octree_flush(t);
    if (s != YLM_OK) return s;
  }
  if (t->chunks == t->chunk_room) {
    size_t room = t->chunk_room ? 2 * t->chunk_room : 16;
    octree_chunk *more = ylm_realloc(t->chunk, t->chunks * sizeof *more, room, sizeof *more);
    if (!more) return ylm_fail(t->e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
    t->chunk = more;
    t->chunk_room = room;
  }
  octree_chunk *c = &t->chunk[t->chunks++];
  *c = (octree_chunk){NULL, NULL, first, n};
  ylm_status s = ylm_gpu_buffer_create(t->g, data, &c->data, t->e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(t->g, extra, &c->extra, t->e);
  if (s == YLM_OK) t->pending += data + extra;
  return s;
}

/* The light field at n points from `first` on. */
static ylm_status pass(octree *t, const sum_plan *plan, const ylm_field_query *q, uint32_t first,
                       uint32_t n, const sum_reach *reach) {
  ylm_gpu_buffer **scratch = t->l->scratch;
  ylm_status s = ylm__lights_scratch(t->l, BUFFER_POINTS, 12 * reach->places, t->e);
  if (s == YLM_OK) s = add_chunk(t, first, n);
  if (s != YLM_OK) return s;
  step_kernel place = {"octree_place", 0, {0, 0}, 0}, store = {"octree_store", 0, {0, 0}, 0};
  uint32_t where[] = {n, first, t->resolution};
  ylm_gpu_buffer *from[] = {t->key, t->axes, scratch[BUFFER_POINTS]};
  const ylm_progress *outer = t->q.progress;
  t->q.progress = NULL;
  t->q.stage = "points";
  steps_dispatch(&t->q, &place, n, 3, where, 3, from);
  s = steps_run(&t->q);
  if (s == YLM_OK) s = ylm__sum_run(t->l, plan, q, n, reach->at_once, outer, t->e);
  const octree_chunk *c = &t->chunk[t->chunks - 1];
  uint32_t what[] = {n,        first,     t->resolution,
                     t->width, t->stride, t->form.metric == YLM_GRID_RELATIVE};
  ylm_gpu_buffer *bind[] = {scratch[BUFFER_VALUE],
                            scratch[BUFFER_GRADIENT],
                            scratch[BUFFER_LAMBDA],
                            scratch[BUFFER_NORM],
                            scratch[BUFFER_INSIDE],
                            t->key,
                            t->axes,
                            c->data,
                            c->extra,
                            t->ratio,
                            t->counts};
  steps_dispatch(&t->q, &store, (uint64_t)n * t->stride, 6, what, 11, bind);
  if (s == YLM_OK) s = steps_run(&t->q);
  t->q.progress = outer;
  return s;
}

/* Names the point whose field is not finite. */
static ylm_status not_finite(octree *t, uint32_t point) {
  uint32_t key[2], at[3];
  double p[3];
  ylm_status s = ylm_gpu_download(t->key, 8 * (uint64_t)point, 8, key, t->e);
  if (s != YLM_OK) return s;
  octree_unpack(key, at);
  ylm_grid_position(t->grid, at, p);
  return ylm_fail(t->e, YLM_EDOMAIN, "the light field is not finite at (%g, %g, %g)", p[0], p[1],
                  p[2]);
}

/* Evaluates n points from t->points on. */
static ylm_status evaluate(octree *t, uint32_t n) {
  ylm_field_query q = query_of(t);
  const sum_plan *plan;
  sum_reach reach;
  uint32_t count[COUNTS];
  double start = ylm_seconds();
  ylm_status s = ylm__sum_plan_get(t->l, &q, &plan, t->e);
  if (s == YLM_OK) s = ylm__lights_reach(t->l, plan, &q, n, 16 * (size_t)t->stride, &reach, t->e);
  for (uint32_t at = 0, now; s == YLM_OK && at < n; at += now) {
    now = n - at < reach.rows ? n - at : (uint32_t)reach.rows;
    t->done = at;
    t->now = now;
    t->of = n;
    s = pass(t, plan, &q, t->points + at, now, &reach);
  }
  t->done = n;
  t->now = 0;
  t->points += n;
  t->stats->pairs += (uint64_t)n * t->l->active;
  if (s == YLM_OK) s = octree_counts(t, count);
  t->stats->field_seconds += ylm_seconds() - start;
  return s == YLM_OK && count[COUNT_BAD] ? not_finite(t, ~count[COUNT_BAD]) : s;
}

ylm_status octree_corners(octree *t, int level) {
  uint32_t fresh = 0;
  double start = ylm_seconds();
  if (t->level[level].voxels >= MOST_VOXELS)
    return ylm_fail(t->e, YLM_ELIMIT, "more than 2^27 voxels in a level on a device");
  t->q.stage = "points";
  ylm_status s = find_corners(t, level, &fresh);
  if (s == YLM_OK) s = reserve_points(t, fresh);
  if (s == YLM_OK) number_corners(t, level);
  if (s == YLM_OK) s = steps_run(&t->q);
  t->stats->lattice_seconds += ylm_seconds() - start;
  return s == YLM_OK && fresh ? evaluate(t, fresh) : s;
}
