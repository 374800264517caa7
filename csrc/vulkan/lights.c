/* lights.c - sphere lights in a device's memory, and their light field. */
#include "lights.h"

#include <math.h>
#include <string.h>

#define PASS_BYTES ((uint64_t)96 << 20) /* of the device's memory for a pass of points */
#define PARTIAL_BYTES ((uint64_t)48 << 20)

/* -- lamps ------------------------------------------------------------------------------ */

/* Three vectors of four for each light that emits: see shaders/lamps.glsl. */
static void pack_float(const ylm_lights *lights, float *to) {
  const double *at, *radius, *rgb;
  ylm_lights_arrays(lights, &at, &radius, &rgb);
  for (size_t i = 0, n = ylm_lights_count(lights); i < n; i++) {
    if (radius[i] == 0) continue;
    float r = (float)radius[i], color[3];
    double r2 = (double)r * (double)r; /* exact */
    float high = (float)r2;
    for (int a = 0; a < 3; a++) to[a] = (float)at[3 * i + a], color[a] = (float)rgb[3 * i + a];
    double lum = YLM_LUMINANCE_R * rgb[3 * i] + YLM_LUMINANCE_G * rgb[3 * i + 1] +
                 YLM_LUMINANCE_B * rgb[3 * i + 2];
    float rest[9] = {
        high, (float)(r2 - (double)high), r, 0, (float)lum, color[0], color[1], color[2], 0};
    memcpy(to + 3, rest, sizeof rest);
    to += 12;
  }
}

static void pack_double(const ylm_lights *lights, double *to) {
  const double *at, *radius, *rgb;
  ylm_lights_arrays(lights, &at, &radius, &rgb);
  for (size_t i = 0, n = ylm_lights_count(lights); i < n; i++) {
    if (radius[i] == 0) continue;
    double r = radius[i], high = r * r;
    double lum = YLM_LUMINANCE_R * rgb[3 * i] + YLM_LUMINANCE_G * rgb[3 * i + 1] +
                 YLM_LUMINANCE_B * rgb[3 * i + 2];
    double rest[9] = {high,           fma(r, r, -high), r, 0, lum, rgb[3 * i],
                      rgb[3 * i + 1], rgb[3 * i + 2],   0};
    memcpy(to, at + 3 * i, 3 * sizeof *to);
    memcpy(to + 3, rest, sizeof rest);
    to += 12;
  }
}

/* Uploads the lights in a precision, once. */
static ylm_status upload(ylm_gpu_lights *l, ylm_dtype t, ylm_error *e) {
  if (l->lamps[t]) return YLM_OK;
  size_t bytes = (size_t)l->active * 12 * ylm_dtype_size(t);
  void *packed = ylm_alloc(bytes, 1);
  if (!packed) return ylm_fail(e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  if (t == YLM_DOUBLE)
    pack_double(l->lights, packed);
  else
    pack_float(l->lights, packed);
  ylm_status s = ylm_gpu_buffer_from(l->gpu, bytes, packed, &l->lamps[t], e);
  ylm_free(packed);
  return s;
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
  int most = l->method == YLM_GPU_MERGED ? YLM_GPU_LMAX : YLM_GPU_PRODUCT_LMAX;
  size_t where;
  ylm_status s = ylm_lights_evaluate(l->lights, YLM_ISA_reference, q, 0, points, r, e);
  if (s != YLM_OK) return s;
  if (q->lmax > most)
    return ylm_fail(e, YLM_ERANGE, "lmax must be 0 .. %d for lights on a device%s, got %d", most,
                    most < YLM_GPU_LMAX ? " with this method" : "", q->lmax);
  if (!ylm_all_finite(q->dtype, points, 3 * n, &where))
    return ylm_fail(e, YLM_EDOMAIN, "point %zu is not finite", where / 3 + 1);
  for (size_t i = 0; i < 3 * n; i++) {
    double x =
        q->dtype == YLM_DOUBLE ? ((const double *)points)[i] : (double)((const float *)points)[i];
    if (fabs(x) > YLM_LIGHT_EXTENT)
      return ylm_fail(e, YLM_ERANGE, "point %zu is beyond %g", i / 3 + 1, YLM_LIGHT_EXTENT);
  }
  if (q->dtype == YLM_DOUBLE && !ylm_gpu_about(l->gpu)->float64)
    return ylm_fail(e, YLM_EMISSING, "'%s' does not compute in double",
                    ylm_gpu_about(l->gpu)->name);
  return ylm_gpu_state(l->gpu, e);
}

/* Progress of a pass as progress of all points. */
typedef struct pass_progress {
  const ylm_progress *outer;
  size_t begin, points, all;
} pass_progress;

static bool forward(void *user, uint64_t done, uint64_t total, const char *stage) {
  const pass_progress *p = user;
  (void)stage;
  uint64_t here = total ? (uint64_t)((double)p->points * (double)done / (double)total) : 0;
  return ylm_report(p->outer, p->begin + here, p->all, "lights") == YLM_OK;
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
  if (!flags) return ylm_fail(e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  s = ylm_gpu_download(l->scratch[BUFFER_INSIDE], 0, n * sizeof *flags, flags, e);
  for (size_t i = 0; i < n && s == YLM_OK; i++) r->inside[begin + i] = flags[i] != 0;
  ylm_free(flags);
  return s;
}

ylm_status ylm__lights_reach(const ylm_gpu_lights *l, const sum_plan *plan,
                             const ylm_field_query *q, size_t n, size_t other, sum_reach *r,
                             ylm_error *e) {
  sum_size size = ylm__sum_size(plan, q);
  uint32_t chunks = (l->active + l->chunk - 1) / l->chunk, some = chunks < 8 ? chunks : 8;
  size_t widest = size.widest > other ? size.widest : other;
  r->rows = ylm_gpu_rows(l->gpu, n, widest, size.all + other + some * size.partial, PASS_BYTES);
  if (!r->rows) return ylm_fail(e, YLM_ELIMIT, "the device has too little memory for 64 points");
  uint64_t room = ylm_gpu_about(l->gpu)->bind_bytes;
  if (room > PARTIAL_BYTES) room = PARTIAL_BYTES;
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
  ylm_status s = check(l, q, n, points, r, e);
  if (s == YLM_OK) s = upload(l, q->dtype, e);
  if (s == YLM_OK) s = ylm__sum_plan_get(l, q, &plan, e);
  if (s != YLM_OK || !n) return s;
  sum_reach reach;
  s = ylm__lights_reach(l, plan, q, n, 0, &reach, e);
  if (s != YLM_OK) return s;
  size_t rows = reach.rows;
  size_t point = 3 * ylm_dtype_size(q->dtype);
  for (size_t begin = 0; begin < n && s == YLM_OK; begin += rows) {
    size_t now = n - begin < rows ? n - begin : rows;
    pass_progress pass = {q->progress, begin, now, n};
    ylm_progress progress = {forward, &pass};
    s = ylm__lights_scratch(l, BUFFER_POINTS, reach.places * point, e);
    double start = ylm_seconds();
    if (s == YLM_OK)
      s = ylm_gpu_upload(l->scratch[BUFFER_POINTS], 0, now * point,
                         (const char *)points + begin * point, e);
    ylm__lights_copied(l, "upload", start);
    if (s == YLM_OK)
      s = ylm__sum_run(l, plan, q, (uint32_t)now, reach.at_once, q->progress ? &progress : NULL, e);
    start = ylm_seconds();
    if (s == YLM_OK) s = download(l, q, begin, now, r, e);
    ylm__lights_copied(l, "download", start);
  }
  if (s == YLM_OK) r->pairs += (uint64_t)n * l->active;
  return s;
}

static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_gpu_lights *l = f->self;
  const ylm_field *field = ylm_lights_field(l->lights);
  return field->crosses(field, n, boxes, out);
}

/* -- the object ------------------------------------------------------------------------------ */

/*
** Lights of a chunk. A graphics processor wants many groups, so many chunks; a processor few.
** It follows from the lights and the device alone: so do the sums.
*/
static uint32_t chunk_of(const ylm_gpu *g, uint32_t active) {
  if (ylm_gpu_about(g)->type == YLM_GPU_CPU) return 256;
  uint32_t chunk = (active / 64 + 15) / 16 * 16;
  return chunk < 16 ? 16 : chunk > 1024 ? 1024 : chunk;
}

ylm_status ylm_gpu_lights_create(ylm_gpu *g, const ylm_lights *lights, ylm_gpu_method method,
                                 ylm_gpu_lights **out, ylm_error *e) {
  const double *radius;
  size_t active = 0;
  *out = NULL;
  ylm_lights_arrays(lights, NULL, &radius, NULL);
  for (size_t i = 0, n = ylm_lights_count(lights); i < n; i++) active += radius[i] > 0;
  if (active > 1u << 28) return ylm_fail(e, YLM_ELIMIT, "more than 2^28 lights");
  ylm_gpu_lights *l = ylm_alloc_zero(1, sizeof *l);
  if (!l) return ylm_fail(e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  l->gpu = ylm_gpu_share(g);
  l->lights = lights;
  l->method = method;
  l->active = (uint32_t)active;
  l->chunk = chunk_of(g, l->active);
  l->field = (ylm_field){.self = l, .evaluate = evaluate, .crosses = crosses};
  ylm_status s = upload(l, YLM_FLOAT, e);
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
  for (int i = 0; i < BUFFERS; i++) ylm_gpu_buffer_free(l->scratch[i]);
  for (int i = 0; i < 2; i++) ylm_gpu_buffer_free(l->lamps[i]);
  ylm_gpu_free(l->gpu);
  ylm_free(l);
}

const ylm_field *ylm_gpu_lights_field(const ylm_gpu_lights *l) { return &l->field; }
ylm_gpu *ylm_gpu_lights_device(const ylm_gpu_lights *l) { return l->gpu; }
const ylm_gpu_times *ylm_gpu_lights_times(const ylm_gpu_lights *l) { return &l->times; }
