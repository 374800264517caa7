/* remote.c - rows of a grid's points kept on a device while the host refines it: ylm_grid_keeper.
 */
#include "occupied.h"
#include "points.h"

#define PART ((size_t)1 << 16) /* points whose keys are packed at a time */

static ylm_status begin(void *self, const ylm_grid *g, ylm_error *e) {
  gpu_points *p = self;
  const ylm_grid_source *source = p->source;
  ylm_gpu_buffer *there = p->there;
  if (!points_fit(ylm_grid_look(g)->resolution))
    return ylm_fail(e, YLM_ELIMIT, "more than 131071 voxels along an axis");
  ylm_status s = points_begin(p, p->l, g, e);
  p->source = source;
  p->there = there;
  return s;
}

/* -- shading points -------------------------------------------------------------------------- */

static ylm_status find_codes(occupied_voxels *o, uint64_t **code, size_t *n, uint64_t *outside) {
  uint32_t count[YLM_GPU_COUNTS];
  ylm_status s = ylm_gpu_buffer_create(o->l->gpu, YLM_GPU_COUNTS * 4, &o->counts, o->e);
  if (s != YLM_OK) return s;
  steps_fill(o->q, o->counts, 0);
  s = occupied_mark(o, count);
  if (s == YLM_OK) s = occupied_codes(o, code, n);
  if (s == YLM_OK) *outside += count[YLM_GPU_COUNT_OUTSIDE];
  return s;
}

static ylm_status codes(void *self, const ylm_grid *g, uint64_t **code, size_t *n,
                        uint64_t *outside, const ylm_progress *progress, ylm_error *e) {
  gpu_points *p = self;
  step_queue q = {
      .g = p->l->gpu, .times = &p->l->times, .progress = progress, .stage = "occupancy", .e = e};
  occupied_voxels o = {
      .l = p->l, .grid = g, .source = p->source, .there = p->there, .q = &q, .e = e};
  ylm_status s = ylm__lights_idle(p->l, e);
  if (s != YLM_OK) return s;
  p->l->busy = true;
  s = find_codes(&o, code, n, outside);
  p->l->busy = false;
  occupied_free(&o);
  ylm_gpu_buffer_free(o.counts);
  steps_free(&q);
  return s;
}

static ylm_status shading(void *self, size_t n, const size_t *index, float *out, ylm_error *e) {
  gpu_points *p = self;
  step_queue q = {.g = p->l->gpu, .times = &p->l->times, .stage = "points", .e = e};
  occupied_voxels o = {.l = p->l, .source = p->source, .there = p->there, .q = &q, .e = e};
  ylm_status s = occupied_points(&o, n, index, out);
  steps_free(&q);
  return s;
}

/* -- points of the grid ------------------------------------------------------------------------ */

/* Keys of n points from `first` on. */
static ylm_status upload_keys(gpu_points *p, size_t first, size_t n, const uint32_t *lattice) {
  uint32_t(*key)[2] = ylm_alloc(n < PART ? n : PART, sizeof *key);
  ylm_status s = key ? YLM_OK : ylm_fail(p->e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  double start = ylm_seconds();
  for (size_t at = 0, now; s == YLM_OK && at < n; at += now) {
    now = n - at < PART ? n - at : PART;
    for (size_t i = 0; i < now; i++) points_pack(lattice + 3 * (at + i), key[i]);
    s = ylm_gpu_upload(p->key, 8 * (first + at), 8 * now, key, p->e);
  }
  points_copied(p, "upload", start);
  ylm_free(key);
  return s;
}

static ylm_status evaluate(void *self, size_t first, size_t n, const uint32_t *lattice,
                           float *lambda, float *norm, uint8_t *inside, uint64_t *pairs,
                           const ylm_progress *progress, ylm_error *e) {
  gpu_points *p = self;
  bool full;
  uint64_t rows = first + n;
  p->e = p->q.e = e;
  if (rows > GRID_PARTS * p->part_rows || 16 * rows * p->stride > points_most_bytes(p))
    return ylm_fail(e, YLM_ENOMEM, "the device has no room for so many points");
  ylm_status s = ylm__lights_idle(p->l, e);
  if (s == YLM_OK) s = points_reserve(p, (uint32_t)n);
  if (s == YLM_OK) s = upload_keys(p, first, n, lattice);
  if (s != YLM_OK) return s;
  p->l->busy = true;
  s = points_evaluate(p, (uint32_t)n, progress, &full);
  p->l->busy = false;
  if (s == YLM_OK)
    s = points_extra(p, (uint32_t)first, (uint32_t)n, lambda, norm, inside); /* 1: INVALID */
  if (s == YLM_OK)
    *pairs += n * ylm__lights_pairs(p->l);
  else
    p->points = (uint32_t)first;
  return s;
}

static ylm_status residuals(void *self, size_t n, const ylm_grid_probe *probe, float *distance,
                            ylm_error *e) {
  gpu_points *p = self;
  p->e = p->q.e = e;
  return points_probe(p, n, probe, false, distance);
}

static ylm_status compare(void *self, size_t n, const float *places, const ylm_grid_probe *probe,
                          float *distance, uint8_t *inside, uint64_t *pairs,
                          const ylm_progress *progress, ylm_error *e) {
  gpu_points *p = self;
  p->e = p->q.e = e;
  ylm_status s = ylm__lights_idle(p->l, e);
  if (s != YLM_OK) return s;
  p->l->busy = true;
  s = points_values(p, n, places, inside, progress);
  p->l->busy = false;
  if (s == YLM_OK) s = points_probe(p, n, probe, true, distance);
  if (s == YLM_OK) *pairs += n * ylm__lights_pairs(p->l);
  return s;
}

static ylm_status values(void *self, size_t n, float *value, ylm_error *e) {
  gpu_points *p = self;
  double start = ylm_seconds();
  ylm_status s = ylm_gpu_download(p->value, 0, n * 4 * (uint64_t)p->width, value, e);
  points_copied(p, "download", start);
  return s;
}

static ylm_status take(void *self, size_t n, const uint32_t *point, float *row, ylm_error *e) {
  gpu_points *p = self;
  p->e = p->q.e = e;
  return points_take(p, n, point, row);
}

static ylm_status put(void *self, size_t n, const uint32_t *point, const float *row, ylm_error *e) {
  gpu_points *p = self;
  p->e = p->q.e = e;
  return points_put(p, n, point, row);
}

static ylm_status rows(void *self, size_t n, float *data, bool forget, ylm_error *e) {
  gpu_points *p = self;
  p->e = p->q.e = e;
  p->points = (uint32_t)n;
  ylm_status s = points_download(p, data);
  if (s == YLM_OK && forget) points_end(p);
  if (forget) points_forget(p);
  return s;
}

ylm_grid_keeper points_keeper(gpu_points *p) {
  return (ylm_grid_keeper){p,       begin,  codes, shading, evaluate, residuals,
                           compare, values, take,  put,     rows};
}
