/* lights.c - lights in a device's memory, and their light field. */
#include "lights.h"
#include "../calibration.h"

#include <math.h>
#include <string.h>

#include "ylm_image.h"

/* -- lamps ------------------------------------------------------------------------------ */

/* Rows of four numbers of a light: see shaders/lamps.glsl. */
static size_t lamp_rows(const ylm_gpu_lights *l) { return l->cosines.kind ? 4 : 3; }

static void pack_lamp(const ylm_light_lamp *l, bool cosine, ylm_dtype t, double x[16]) {
  const double *rgb = l->radiance;
  double r = t == YLM_FLOAT ? (double)(float)l->radius : l->radius;
  /* in float r^2 is exact in double; there the rest is by fma */
  double square = r * r, high = t == YLM_FLOAT ? (double)(float)square : square;
  double low = t == YLM_FLOAT ? square - high : fma(r, r, -square);
  double lum = ylm_luminance(rgb);
  double plain = cosine ? 0 : 1;
  double rest[9] = {high, low, r, plain, lum, rgb[0], rgb[1], rgb[2], 0};
  memcpy(x, l->at, 3 * sizeof *x);
  memcpy(x + 3, rest, sizeof rest);
  memcpy(x + 12, l->normal, sizeof l->normal);
  x[15] = 0;
}

/* Packs lights that emit, from number `next` on; returns the number after the last. */
static size_t pack(const ylm_light_part *p, ylm_dtype t, size_t wide, void *to, size_t next) {
  for (size_t i = 0; i < p->lamps; i++) {
    ylm_light_lamp lamp;
    double x[16];
    p->lamp(p->of, i, &lamp);
    if (lamp.radius == 0) continue;
    pack_lamp(&lamp, p->cosine, t, x);
    for (size_t k = 0; k < wide; k++, next++)
      if (t == YLM_DOUBLE)
        ((double *)to)[next] = x[k];
      else
        ((float *)to)[next] = (float)x[k];
  }
  return next;
}

/* Uploads the lights in a precision, once. */
static ylm_status upload(ylm_gpu_lights *l, ylm_dtype t, ylm_error *e) {
  if (l->lamps[t]) return YLM_OK;
  size_t wide = 4 * lamp_rows(l), bytes = (size_t)l->active * wide * ylm_dtype_size(t);
  void *packed = ylm_alloc(bytes, 1);
  if (!packed) return ylm_no_memory(e);
  pack(&l->cosines, t, wide, packed, pack(&l->spheres, t, wide, packed, 0));
  ylm_status s = ylm_gpu_buffer_from(l->gpu, bytes, packed, &l->lamps[t], e);
  ylm_free(packed);
  return s;
}

ylm_status ylm__lights_idle(const ylm_gpu_lights *l, ylm_error *e) {
  if (!l->busy) return YLM_OK;
  return ylm_fail(e, YLM_EBUSY, "the lights are in use by a call that has not returned");
}

ylm_status ylm__lights_scratch(ylm_gpu_lights *l, int which, uint64_t bytes, ylm_error *e) {
  ylm_gpu_buffer **b = &l->scratch[which];
  if (*b && ylm_gpu_buffer_bytes(*b) >= bytes) return YLM_OK;
  ylm_gpu_buffer_free(*b);
  *b = NULL;
  return ylm_gpu_buffer_create(l->gpu, bytes, b, e);
}

/* -- queries ------------------------------------------------------------------------------ */

static ylm_status check(const ylm_gpu_lights *l, const ylm_field_query *q, size_t n,
                        const void *points, ylm_field_result *r, ylm_error *e) {
  int most = l->rims.objects ? YLM_LIGHT_RIM_LMAX : YLM_LIGHT_LMAX;
  ylm_status s = ylm__loops_check(l, q, e);
  if (s == YLM_OK) s = ylm_light_check(q, most, n, points, r, e);
  if (s != YLM_OK) return s;
  if (q->dtype == YLM_DOUBLE && !ylm_gpu_about(l->gpu)->float64)
    return ylm_fail(e, YLM_EMISSING, "'%s' does not compute in double",
                    ylm_gpu_about(l->gpu)->name);
  return ylm_gpu_state(l->gpu, e);
}

void ylm__lights_copied(ylm_gpu_lights *l, const char *name, double start) {
  ylm_gpu_times *t = &l->times;
  double seconds = ylm_seconds() - start;
  int i = 0;
  while (i < t->stages && strcmp(t->stage[i].name, name) != 0) i++;
  if (i == YLM_GPU_STAGES) return;
  if (i == t->stages) t->stage[t->stages++] = (struct ylm_gpu_stage){name, 0, 0, 0};
  t->stage[i].seconds += seconds;
  if (seconds > t->stage[i].longest) t->stage[i].longest = seconds;
}

/* Copies results of points begin .. begin+n-1 to their places. */
static ylm_status download(const ylm_gpu_lights *l, const ylm_field_query *q, size_t begin,
                           size_t n, ylm_field_result *r, ylm_error *e) {
  size_t count = (size_t)(q->lmax + 1) * (size_t)(q->lmax + 1) * (size_t)q->channels;
  struct {
    int buffer;
    void *to;
    size_t width;
  } part[] = {{BUFFER_VALUE, q->want & YLM_WANT_VALUE ? r->value : NULL, count},
              {BUFFER_GRADIENT, q->want & YLM_WANT_GRADIENT ? r->gradient : NULL, 3 * count},
              {BUFFER_HESSIAN, q->want & YLM_WANT_HESSIAN ? r->hessian : NULL, 6 * count},
              {BUFFER_LAMBDA, q->want & YLM_WANT_METRIC ? r->lambda : NULL, 1},
              {BUFFER_NORM, q->want & YLM_WANT_METRIC ? r->norm : NULL, 1}};
  ylm_status s = YLM_OK;
  for (int i = 0; i < 5 && s == YLM_OK; i++) {
    size_t row = part[i].width * ylm_dtype_size(q->dtype);
    if (part[i].to)
      s = ylm_gpu_download(l->scratch[part[i].buffer], 0, n * row, (char *)part[i].to + begin * row,
                           e);
  }
  if (s != YLM_OK || !r->inside) return s;
  uint32_t *flags = ylm_alloc(n, sizeof *flags);
  if (!flags) return ylm_no_memory(e);
  s = ylm_gpu_download(l->scratch[BUFFER_INSIDE], 0, n * sizeof *flags, flags, e);
  for (size_t i = 0; i < n && s == YLM_OK; i++) r->inside[begin + i] = flags[i] != 0;
  ylm_free(flags);
  return s;
}

ylm_status ylm__lights_reach(const ylm_gpu_lights *l, const sum_plan *plan,
                             const ylm_field_query *q, size_t n, size_t other, sum_reach *r,
                             ylm_error *e) {
  sum_size size = ylm__sum_size(plan, q);
  uint32_t chunks = ylm__lights_chunks(l), some = chunks < 8 ? chunks : 8;
  size_t widest = size.widest > other ? size.widest : other;
  r->rows =
      ylm_gpu_rows(l->gpu, n, widest, size.all + other + some * size.partial, LIGHTS_PASS_BYTES);
  if (!r->rows)
    return ylm_fail(
        e, YLM_ELIMIT,
        "'%s' lets kernels see %.0f MiB: too little for the sums of 64 points at lmax %d",
        ylm_gpu_about(l->gpu)->name, (double)ylm_gpu_about(l->gpu)->bind_bytes / 1048576, q->lmax);
  uint64_t room = ylm_gpu_about(l->gpu)->bind_bytes;
  if (room > LIGHTS_PARTIAL_BYTES) room = LIGHTS_PARTIAL_BYTES;
  r->places = (r->rows + GROUP - 1) / GROUP * GROUP;
  uint64_t at_once = room / (r->places * size.partial + 1);
  if (at_once > chunks) at_once = chunks;
  r->at_once = at_once < 1 ? 1 : (uint32_t)at_once;
  return YLM_OK;
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  ylm_gpu_lights *l = (ylm_gpu_lights *)(uintptr_t)f->self;
  const sum_plan *plan;
  ylm_status s = ylm__lights_idle(l, e);
  if (s == YLM_OK) s = check(l, q, n, points, r, e);
  if (s == YLM_OK) s = upload(l, q->dtype, e);
  if (s == YLM_OK) s = ylm__sum_plan_get(l, q, &plan, e);
  if (s != YLM_OK || !n) return s;
  sum_reach reach;
  s = ylm__lights_reach(l, plan, q, n, 0, &reach, e);
  if (s != YLM_OK) return s;
  size_t rows = reach.rows;
  size_t point = 3 * ylm_dtype_size(q->dtype);
  l->busy = true;
  for (size_t begin = 0; begin < n && s == YLM_OK; begin += rows) {
    size_t now = n - begin < rows ? n - begin : rows;
    ylm_progress_part part;
    const ylm_progress *progress =
        ylm_progress_part_of(&part, q->progress, "lights", begin, now, n);
    s = ylm__lights_scratch(l, BUFFER_POINTS, reach.places * point, e);
    double start = ylm_seconds();
    if (s == YLM_OK)
      s = ylm_gpu_upload(l->scratch[BUFFER_POINTS], 0, now * point,
                         (const char *)points + begin * point, e);
    ylm__lights_copied(l, "upload", start);
    if (s == YLM_OK) s = ylm__sum_run(l, plan, q, (uint32_t)now, reach.at_once, progress, e);
    start = ylm_seconds();
    if (s == YLM_OK) s = download(l, q, begin, now, r, e);
    ylm__lights_copied(l, "download", start);
  }
  l->busy = false;
  if (s == YLM_OK) r->pairs += n * ylm__lights_pairs(l);
  return s;
}

static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_gpu_lights *l = f->self;
  const ylm_field *here = ylm_light_set_field(l->set);
  return here->crosses(here, n, boxes, out);
}

/* -- the object ------------------------------------------------------------------------------ */

/*
** Lights of a chunk. A graphics processor wants many groups, so many chunks; a processor few.
** The number follows from the lights and the device alone: so do the sums.
*/
static uint32_t chunk_of(const ylm_gpu *g, uint32_t active) {
  if (ylm_gpu_about(g)->type == YLM_GPU_CPU) return 256;
  uint32_t chunk = (active / 64 + 15) / 16 * 16;
  return chunk < 16 ? 16 : chunk > 1024 ? 1024 : chunk;
}

/* Lights of a part that emit. */
static size_t emitting(const ylm_light_part *p) {
  ylm_light_lamp lamp;
  size_t n = 0;
  for (size_t i = 0; i < p->lamps; i++) {
    p->lamp(p->of, i, &lamp);
    n += lamp.radius > 0;
  }
  return n;
}

/* Takes one part of the lights. */
static ylm_status take(ylm_gpu_lights *l, const ylm_light_part *p, ylm_error *e) {
  if (!p->lamp && !p->rims.sides)
    return ylm_fail(e, YLM_EINVAL, "a device sums no lights of kind '%s'", p->kind);
  if (p->rims.sides)
    l->rims.of[l->rims.objects++] = p->rims;
  else if (!p->cosine)
    l->spheres = *p;
  else if (!l->cosines.kind)
    l->cosines = *p;
  else
    return ylm_fail(e, YLM_EINVAL,
                    "a device takes one set of lights with method = 'sphere'; join the two");
  return YLM_OK;
}

static ylm_status take_parts(ylm_gpu_lights *l, ylm_error *e) {
  ylm_light_part part;
  size_t n = 0;
  while (ylm_light_set_part(l->set, n, &part)) n++;
  l->rims.of = ylm_alloc(n, sizeof *l->rims.of);
  ylm_status s = YLM_OK;
  if (!l->rims.of) return ylm_no_memory(e);
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    ylm_light_set_part(l->set, i, &part);
    s = take(l, &part, e);
  }
  return s;
}

ylm_status ylm_gpu_lights_create(ylm_gpu *g, const ylm_light_set *set, ylm_gpu_method method,
                                 ylm_gpu_lights **out, ylm_error *e) {
  *out = NULL;
  ylm_gpu_lights *l = ylm_alloc_zero(1, sizeof *l);
  if (!l) return ylm_no_memory(e);
  l->gpu = ylm_gpu_share(g);
  l->set = set;
  l->method = method;
  ylm_status s = take_parts(l, e);
  size_t active = emitting(&l->spheres) + emitting(&l->cosines);
  if (s == YLM_OK && active > 1u << 28) s = ylm_fail(e, YLM_ELIMIT, "more than 2^28 lights");
  l->active = (uint32_t)active;
  l->chunk = chunk_of(g, l->active);
  l->field = (ylm_field){.self = l, .evaluate = evaluate, .crosses = crosses};
  if (s == YLM_OK) s = upload(l, YLM_FLOAT, e);
  if (s == YLM_OK) s = ylm__rims_create(l, e);
  if (s != YLM_OK) {
    ylm_gpu_lights_free(l);
    return s;
  }
  *out = l;
  return YLM_OK;
}

void ylm_gpu_lights_free(ylm_gpu_lights *l) {
  if (!l) return;
  ylm__sum_plans_free(l->plans);
  ylm__rims_free(&l->rims);
  for (int i = 0; i < BUFFERS; i++) ylm_gpu_buffer_free(l->scratch[i]);
  for (int i = 0; i < 2; i++) ylm_gpu_buffer_free(l->lamps[i]);
  ylm_gpu_free(l->gpu);
  ylm_free(l);
}

const ylm_field *ylm_gpu_lights_field(const ylm_gpu_lights *l) { return &l->field; }
ylm_gpu *ylm_gpu_lights_device(const ylm_gpu_lights *l) { return l->gpu; }
const ylm_gpu_times *ylm_gpu_lights_times(const ylm_gpu_lights *l) { return &l->times; }
