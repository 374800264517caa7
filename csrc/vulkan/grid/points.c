/* points.c - data of a grid's points on a device: room for rows, and the light field. */
#include "points.h"

#include <math.h>
#include <string.h>

/* -- beginning and end ------------------------------------------------------------------- */

bool ylm__points_fit(const uint32_t resolution[3]) {
  return resolution[0] < 1u << 17 && resolution[1] < 1u << 17 && resolution[2] < 1u << 17;
}

static ylm_field_query query_of(const gpu_points *p) {
  const ylm_grid_form *f = &ylm_grid_look(p->grid)->form;
  return (ylm_field_query){.lmax = f->lmax,
                           .channels = f->channels,
                           .want = YLM_WANT_VALUE | YLM_WANT_GRADIENT |
                                   (f->metric_channels ? YLM_WANT_METRIC : 0),
                           .metric_channels = f->metric_channels == 3 ? 3 : 1,
                           .dtype = YLM_FLOAT};
}

/* The lights can be asked for what the grid wants, everywhere within its bounds. */
static ylm_status check(const gpu_points *p) {
  const ylm_grid_form *f = &ylm_grid_look(p->grid)->form;
  ylm_field_query q = query_of(p);
  float none[3] = {0, 0, 0};
  ylm_field_result r = {
      .value = none, .gradient = none, .lambda = none, .norm = none, .inside = NULL};
  const ylm_field *field = ylm_gpu_lights_field(p->l);
  ylm_status s = field->evaluate(field, &q, 0, none, &r, p->e);
  for (int i = 0; s == YLM_OK && i < 6; i++)
    if (fabs((double)(float)f->bounds[i]) > YLM_LIGHT_EXTENT)
      s = ylm_fail(p->e, YLM_ERANGE, "bounds: the grid reaches beyond %g", YLM_LIGHT_EXTENT);
  return s;
}

/* Where the lattice's planes are, so that all positions are the host's to the bit. */
static ylm_status upload_axes(gpu_points *p) {
  const uint32_t *resolution = ylm_grid_look(p->grid)->resolution;
  size_t n = (size_t)p->resolution + 1;
  float *f = ylm_alloc_zero(3 * n, 2 * sizeof *f);
  if (!f) return ylm_no_memory(p->e);
  for (uint32_t i = 0; i < n; i++) {
    double at[3];
    ylm_grid_position(p->grid, (uint32_t[]){i, i, i}, at);
    for (size_t a = 0; a < 3; a++) {
      float *to = f + 2 * (a * n + i);
      if (i > resolution[a]) continue;
      to[0] = (float)at[a];
      to[1] = (float)(at[a] - (double)to[0]);
    }
  }
  ylm_status s = ylm_gpu_buffer_from(p->g, 3 * n * 2 * sizeof *f, f, &p->axes, p->e);
  ylm_free(f);
  return s;
}

ylm_status ylm__points_begin(gpu_points *p, ylm_gpu_lights *l, const ylm_grid *grid, ylm_error *e) {
  const ylm_grid_contents *v = ylm_grid_look(grid);
  *p = (gpu_points){.g = l->gpu, .l = l, .grid = grid, .e = e};
  p->q = (step_queue){.g = l->gpu, .times = &l->times, .e = e, .stage = "points"};
  p->width = (uint32_t)(v->count * v->form.channels);
  p->stride = (uint32_t)v->stride;
  p->relative = v->form.metric == YLM_GRID_RELATIVE;
  for (int a = 0; a < 3; a++)
    if (v->resolution[a] > p->resolution) p->resolution = v->resolution[a];
  p->part_rows = ylm_gpu_about(p->g)->bind_bytes / (16 * (uint64_t)p->stride);
  ylm_status s = check(p);
  double start = ylm_seconds();
  if (s == YLM_OK) s = upload_axes(p);
  points_copied(p, "upload", start);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(p->g, 4, &p->bad, e);
  return s;
}

static void drop(ylm_gpu_buffer **b) {
  ylm_gpu_buffer_free(*b);
  *b = NULL;
}

void ylm__points_forget(gpu_points *p) {
  for (int i = 0; i < GRID_PARTS; i++) drop(&p->data[i]);
  p->parts = 0;
  p->part_room = 0;
  p->first = p->points;
}

void ylm__points_end(gpu_points *p) {
  ylm_gpu_buffer **own[] = {&p->axes,  &p->bad,  &p->key,    &p->ratio,
                            &p->extra, &p->item, &p->packed, &p->value};
  for (size_t i = 0; i < sizeof own / sizeof *own; i++) drop(own[i]);
  for (int i = 0; i < GRID_PARTS; i++) drop(&p->data[i]);
  ylm__steps_free(&p->q);
  p->q = (step_queue){.g = NULL};
}

void ylm__points_unit(const gpu_points *p, uint32_t unit[3]) {
  const ylm_grid_contents *v = ylm_grid_look(p->grid);
  for (int a = 0; a < 3; a++) {
    float edge = (float)((v->form.bounds[a + 3] - v->form.bounds[a]) / v->resolution[a]);
    memcpy(&unit[a], &edge, 4);
  }
}

/* -- room ---------------------------------------------------------------------------------- */

ylm_status ylm__points_grow(gpu_points *p, ylm_gpu_buffer **b, uint64_t used, uint64_t bytes) {
  ylm_gpu_buffer *more;
  ylm_status s = ylm__steps_run(&p->q);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(p->g, bytes, &more, p->e);
  if (s != YLM_OK) return s;
  if (used) ylm__steps_copy(&p->q, *b, used, more);
  s = ylm__steps_run(&p->q);
  ylm_gpu_buffer_free(*b);
  *b = more;
  return s;
}

ylm_status ylm__points_reserve(gpu_points *p, uint32_t more) {
  uint64_t wanted = (uint64_t)p->points + more, room = 2 * (uint64_t)p->room, n = p->points;
  if (wanted >= YLM_GRID_NONE)
    return ylm_fail(p->e, YLM_ELIMIT, "the grid needs more than %u points", YLM_GRID_NONE);
  if (wanted <= p->room) return YLM_OK;
  if (room < wanted) room = wanted;
  uint64_t bind = ylm_gpu_about(p->g)->bind_bytes / 12;
  if (room > bind && wanted <= bind) room = bind;
  ylm_status s = ylm__points_grow(p, &p->key, 8 * n, 8 * room);
  if (s == YLM_OK) s = ylm__points_grow(p, &p->ratio, 4 * n, 4 * room);
  if (s == YLM_OK) s = ylm__points_grow(p, &p->extra, 12 * n, 12 * room);
  if (s == YLM_OK) p->room = (uint32_t)room;
  return s;
}

uint64_t ylm__points_most_bytes(const gpu_points *p) {
  return ylm_gpu_about(p->g)->memory_bytes / 4;
}

/*
** Room for the rows of some of the next n points, *some of them, in one part: at least of `few`,
** for all that come if there is so much. *some is 0 where there is no room for any.
*/
static ylm_status reserve_rows(gpu_points *p, uint32_t n, uint32_t few, uint32_t *some) {
  uint64_t row = 16 * (uint64_t)p->stride, at = p->points - p->first, part = p->part_rows;
  uint64_t k = part ? at / part : GRID_PARTS, used = part ? at % part : 0,
           most = ylm__points_most_bytes(p);
  *some = 0;
  if (k >= GRID_PARTS) return YLM_OK;
  uint64_t room = k == (uint64_t)p->parts ? 0 : p->part_room, before = k * part * row;
  uint64_t end = most > before ? (most - before) / row : 0, last = end < part ? end : part;
  uint64_t wanted[] = {used + n > 2 * room ? used + n : 2 * room, used + n, used + few};
  ylm_status s = used < room ? YLM_OK : YLM_ENOMEM;
  for (int i = 0; i < 3 && s == YLM_ENOMEM; i++) {
    uint64_t rows = wanted[i] < last ? wanted[i] : last;
    if (rows > used) s = ylm__points_grow(p, &p->data[k], used * row, rows * row);
    if (s == YLM_OK) room = rows;
  }
  if (s != YLM_OK) return s == YLM_ENOMEM ? YLM_OK : s;
  p->parts = (int)k + 1;
  p->part_room = room;
  *some = (uint32_t)(room - used < n ? room - used : n);
  return YLM_OK;
}

/* -- evaluating ------------------------------------------------------------------------------ */

/* The light field at n points from p->points on, whose rows are in one part. */
static ylm_status pass(gpu_points *p, const sum_plan *plan, const ylm_field_query *q, uint32_t n,
                       const sum_reach *reach, const ylm_progress *progress) {
  ylm_gpu_buffer **scratch = p->l->scratch;
  ylm_status s = ylm__lights_scratch(p->l, BUFFER_POINTS, 12 * reach->places, p->e);
  if (s != YLM_OK) return s;
  uint64_t row = p->points - p->first;
  bool metric = q->want & YLM_WANT_METRIC;
  step_kernel place = {"octree_place", 0, {0, 0}, 0}, store = {"octree_store", 0, {0, 0}, 0};
  uint32_t where[] = {n, p->points, p->resolution};
  ylm_gpu_buffer *from[] = {p->key, p->axes, scratch[BUFFER_POINTS]};
  p->q.stage = "points";
  ylm__steps_dispatch(&p->q, &place, n, 3, where, 3, from);
  s = ylm__steps_run(&p->q);
  if (s == YLM_OK) s = ylm__sum_run(p->l, plan, q, n, reach->at_once, progress, p->e);
  uint32_t what[] = {n,         p->points,   p->resolution, p->width,
                     p->stride, p->relative, metric,        (uint32_t)(row % p->part_rows)};
  ylm_gpu_buffer *value = scratch[BUFFER_VALUE];
  ylm_gpu_buffer *bind[] = {value,
                            scratch[BUFFER_GRADIENT],
                            metric ? scratch[BUFFER_LAMBDA] : value,
                            metric ? scratch[BUFFER_NORM] : value,
                            scratch[BUFFER_INSIDE],
                            p->key,
                            p->axes,
                            p->data[row / p->part_rows],
                            p->extra,
                            p->ratio,
                            p->bad};
  if (s == YLM_OK) ylm__steps_dispatch(&p->q, &store, (uint64_t)n * p->stride, 8, what, 11, bind);
  return s == YLM_OK ? ylm__steps_run(&p->q) : s;
}

/* Arrays of the host's, for a block of points at which the field is not finite. */
typedef struct bad_block {
  uint32_t (*key)[2];
  float *position, *value, *gradient;
} bad_block;

/* The field at n points from `first` on, once more, for what there is to say. */
static ylm_status look_again(gpu_points *p, uint32_t first, uint32_t n, const bad_block *k) {
  ylm_field_query q = query_of(p);
  ylm_field_result r = {.value = k->value, .gradient = k->gradient};
  const ylm_field *field = ylm_gpu_lights_field(p->l);
  bool busy = p->l->busy;
  q.want = YLM_WANT_VALUE | YLM_WANT_GRADIENT;
  ylm_status s = ylm_gpu_download(p->key, 8 * (uint64_t)first, 8 * (uint64_t)n, k->key, p->e);
  for (uint32_t i = 0; s == YLM_OK && i < n; i++) {
    uint32_t lattice[3];
    double at[3];
    points_unpack(k->key[i], lattice);
    ylm_grid_position(p->grid, lattice, at);
    for (int a = 0; a < 3; a++) k->position[3 * i + (uint32_t)a] = (float)at[a];
  }
  p->l->busy = false; /* the evaluation that failed is over */
  if (s == YLM_OK) s = field->evaluate(field, &q, n, k->position, &r, p->e);
  p->l->busy = busy;
  return s == YLM_OK ? ylm_light_finite(&q, n, k->position, &r, p->e) : s;
}

/* Says at which of the points from `begin` to `end` the field is not finite, if there is one. The
   message is that of the processor, which asks for blocks of points. */
static ylm_status check_finite(gpu_points *p, uint32_t begin, uint32_t end) {
  uint32_t bad;
  ylm_status s = ylm_gpu_download(p->bad, 0, 4, &bad, p->e);
  if (s != YLM_OK || !bad) return s;
  uint32_t first = begin + (~bad - begin) / YLM_GRID_BLOCK * YLM_GRID_BLOCK;
  uint32_t n = end - first < YLM_GRID_BLOCK ? end - first : YLM_GRID_BLOCK;
  bad_block k = {ylm_alloc(n, sizeof *k.key), ylm_alloc(n, 3 * sizeof(float)),
                 ylm_alloc(n, p->width * sizeof(float)),
                 ylm_alloc(n, 3 * (size_t)p->width * sizeof(float))};
  s = k.key && k.position && k.value && k.gradient ? look_again(p, first, n, &k)
                                                   : ylm_no_memory(p->e);
  if (s == YLM_OK)
    s = ylm_light_beyond("the light field", YLM_FLOAT, ~bad - first, k.position, p->e);
  ylm_free(k.key);
  ylm_free(k.position);
  ylm_free(k.value);
  ylm_free(k.gradient);
  return s;
}

ylm_status ylm__points_evaluate(gpu_points *p, uint32_t n, const ylm_progress *progress,
                                bool *full) {
  ylm_field_query q = query_of(p);
  const sum_plan *plan;
  sum_reach reach;
  uint32_t begin = p->points, end = begin + n, now;
  *full = false;
  ylm_status s = ylm__sum_plan_get(p->l, &q, &plan, p->e);
  if (s == YLM_OK) s = ylm__lights_reach(p->l, plan, &q, n, 16 * (size_t)p->stride, &reach, p->e);
  p->q.status = YLM_OK;
  ylm__steps_fill(&p->q, p->bad, 0);
  while (s == YLM_OK && !*full && p->points < end) {
    uint32_t left = end - p->points, few = left < reach.rows ? left : (uint32_t)reach.rows;
    s = reserve_rows(p, left, few, &now);
    if (now > few) now = few;
    *full = s == YLM_OK && !now;
    ylm_progress_part part;
    const ylm_progress *inner =
        ylm_progress_part_of(&part, progress, NULL, p->points - begin, now, n);
    if (s == YLM_OK && now) s = pass(p, plan, &q, now, &reach, inner);
    if (s == YLM_OK) p->points += now;
  }
  if (s == YLM_OK) s = ylm__steps_run(&p->q);
  if (s == YLM_OK) s = check_finite(p, begin, p->points);
  p->q.n = 0;
  if (s != YLM_OK) p->points = begin;
  if (s == YLM_OK && *full)
    s = ylm_fail(p->e, YLM_ENOMEM, "the device has no room for more points");
  return s;
}
