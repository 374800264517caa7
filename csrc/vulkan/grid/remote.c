/* remote.c - rows of a grid's points kept on a device while the processor refines it: the back end
   of a bake with a tolerance. */
#include "../calibration.h"
#include "occupied.h"
#include "points.h"

/* Where memory runs out, the first evaluation says so. */
static ylm_status begin(gpu_points *p, const ylm_grid_making *m) {
  ylm_gpu_buffer *there = p->there;
  ylm_status s = ylm__points_begin(p, p->l, m->grid, m->e);
  p->source = m->source;
  p->there = there;
  if (s != YLM_ENOMEM && s != YLM_ELIMIT) return s;
  p->unfit = s;
  return YLM_OK;
}

/* Messages of a call go to its error. */
static gpu_points *points_of(void *self, const ylm_grid_making *m) {
  gpu_points *p = self;
  p->e = p->q.e = m->e;
  return p;
}

/* -- shading points -------------------------------------------------------------------------- */

static ylm_status find_codes(occupied_voxels *o, uint64_t **code, size_t *n, uint64_t *outside) {
  uint32_t count[YLM_GPU_COUNTS];
  ylm_status s = ylm_gpu_buffer_create(o->l->gpu, YLM_GPU_COUNTS * 4, &o->counts, o->e);
  if (s != YLM_OK) return s;
  ylm__steps_fill(o->q, o->counts, 0);
  s = ylm__occupied_mark(o, count);
  if (s == YLM_OK) s = ylm__occupied_codes(o, code, n);
  if (s == YLM_OK) *outside += count[YLM_GPU_COUNT_OUTSIDE];
  return s;
}

/* By kernels; where the device has no room for that, the processor finds them if it has the
   points. */
static ylm_status mark(gpu_points *p, const ylm_grid_making *m, uint64_t **code, size_t *n) {
  step_queue q = {.g = p->l->gpu,
                  .times = &p->l->times,
                  .progress = m->progress,
                  .stage = "occupancy",
                  .e = m->e};
  occupied_voxels o = {
      .l = p->l, .grid = m->grid, .source = m->source, .there = p->there, .q = &q, .e = m->e};
  ylm_status s = ylm__lights_idle(p->l, m->e);
  if (s != YLM_OK) return s;
  p->l->busy = true;
  s = find_codes(&o, code, n, &m->stats->outside);
  p->l->busy = false;
  ylm__occupied_free(&o);
  ylm_gpu_buffer_free(o.counts);
  ylm__steps_free(&q);
  if ((s != YLM_ENOMEM && s != YLM_ELIMIT) || !m->source->occupied_points) return s;
  *code = NULL;
  return YLM_OK;
}

static ylm_status occupied(void *self, const ylm_grid_making *m, uint64_t **code, size_t *n) {
  gpu_points *p = self;
  ylm_status s = begin(p, m);
  bool octree = ylm_grid_look(m->grid)->form.kind == YLM_GRID_ADAPTIVE;
  return s == YLM_OK && octree && m->source->occupied ? mark(p, m, code, n) : s;
}

static ylm_status shading(void *self, const ylm_grid_making *m, size_t n, const size_t *index,
                          float *out) {
  gpu_points *p = self;
  step_queue q = {.g = p->l->gpu, .times = &p->l->times, .stage = "points", .e = m->e};
  occupied_voxels o = {.l = p->l, .source = m->source, .there = p->there, .q = &q, .e = m->e};
  ylm_status s = ylm__occupied_points(&o, n, index, out);
  ylm__steps_free(&q);
  return s;
}

/* -- points of the grid ------------------------------------------------------------------------ */

/* Keys of n points from `first` on. */
static ylm_status upload_keys(gpu_points *p, size_t first, size_t n, const uint32_t *lattice) {
  uint32_t(*key)[2] = ylm_alloc(n < REMOTE_KEYS ? n : REMOTE_KEYS, sizeof *key);
  ylm_status s = key ? YLM_OK : ylm_no_memory(p->e);
  double start = ylm_seconds();
  for (size_t at = 0, now; s == YLM_OK && at < n; at += now) {
    now = n - at < REMOTE_KEYS ? n - at : REMOTE_KEYS;
    for (size_t i = 0; i < now; i++) points_pack(lattice + 3 * (at + i), key[i]);
    s = ylm_gpu_upload(p->key, 8 * (first + at), 8 * now, key, p->e);
  }
  points_copied(p, "upload", start);
  ylm_free(key);
  return s;
}

static ylm_status evaluate(void *self, const ylm_grid_making *m, size_t n) {
  gpu_points *p = points_of(self, m);
  const ylm_grid_parts *to = &m->parts;
  bool full;
  size_t first = p->points;
  uint64_t rows = first + n;
  if (p->unfit != YLM_OK) return p->unfit;
  if (rows > GRID_PARTS * p->part_rows || 16 * rows * p->stride > ylm__points_most_bytes(p))
    return ylm_fail(p->e, YLM_ENOMEM, "the device has no room for so many points");
  double start = ylm_seconds();
  ylm_status s = ylm__lights_idle(p->l, p->e);
  if (s == YLM_OK) s = ylm__points_reserve(p, (uint32_t)n);
  if (s == YLM_OK) s = upload_keys(p, first, n, to->lattice + 3 * first);
  if (s != YLM_OK) return s;
  p->l->busy = true;
  s = ylm__points_evaluate(p, (uint32_t)n, m->progress, &full);
  p->l->busy = false;
  if (s == YLM_OK)
    s = ylm__points_extra(p, (uint32_t)first, (uint32_t)n, to->lambda + first, to->norm + first,
                          to->flags + first);
  m->stats->field_seconds += ylm_seconds() - start;
  if (s == YLM_OK)
    m->stats->pairs += n * ylm__lights_pairs(p->l);
  else
    p->points = (uint32_t)first;
  return s;
}

/* Values at the free places, for probes that come next. */
static ylm_status evaluate_held(gpu_points *p, const ylm_grid_making *m, size_t n,
                                const ylm_grid_held *held) {
  ylm_status s = ylm__lights_idle(p->l, p->e);
  if (s != YLM_OK) return s;
  p->l->busy = true;
  s = ylm__points_values(p, n, held->place, held->inside, m->progress);
  p->l->busy = false;
  double start = ylm_seconds();
  if (s == YLM_OK) s = ylm_gpu_download(p->value, 0, n * 4 * (uint64_t)p->width, held->value, p->e);
  points_copied(p, "download", start);
  if (s == YLM_OK) m->stats->pairs += n * ylm__lights_pairs(p->l);
  return s;
}

static ylm_status residuals(void *self, const ylm_grid_making *m, size_t n,
                            const ylm_grid_probe *probe, const ylm_grid_held *held,
                            double *distance) {
  gpu_points *p = points_of(self, m);
  double start = ylm_seconds();
  float *near = ylm_alloc(n, sizeof *near);
  ylm_status s = near ? YLM_OK : ylm_no_memory(p->e);
  if (s == YLM_OK && held) s = evaluate_held(p, m, n, held);
  if (s == YLM_OK) s = ylm__points_probe(p, n, probe, held != NULL, near);
  for (size_t i = 0; s == YLM_OK && i < n; i++) distance[i] = (double)near[i];
  if (held) m->stats->field_seconds += ylm_seconds() - start;
  ylm_free(near);
  return s;
}

static ylm_status rows(void *self, const ylm_grid_making *m, ylm_grid_rows which, size_t n,
                       const uint32_t *point, float *row) {
  gpu_points *p = points_of(self, m);
  if (which == YLM_GRID_ROWS_TAKE) return ylm__points_take(p, n, point, row);
  if (which == YLM_GRID_ROWS_PUT) return ylm__points_put(p, n, point, row);
  p->points = (uint32_t)n;
  ylm_status s = ylm__points_download(p, row);
  if (which == YLM_GRID_ROWS_ALL) return s;
  if (s == YLM_OK) ylm__points_end(p);
  ylm__points_forget(p);
  return s;
}

ylm_grid_backend ylm__points_backend(gpu_points *p) {
  return (ylm_grid_backend){.self = p,
                            .occupied = occupied,
                            .shading = shading,
                            .evaluate = evaluate,
                            .residuals = residuals,
                            .rows = rows};
}
