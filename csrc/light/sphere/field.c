/* field.c - a query about lights: checked, cut into blocks of points, given to the kernels. */
#include "../finite.h"
#include "../moments/plan.h"

#include <math.h>

ylm__channels ylm__channels_of(const ylm_field_query *q) {
  bool metric = q->want & YLM_WANT_METRIC;
  int value = q->want & YLM_WANT_VALUE ? q->channels : 0;
  int hessian = q->want & YLM_WANT_HESSIAN ? q->channels : 0;
  if (metric && q->metric_channels > value) value = q->metric_channels;
  if (metric && q->metric_channels > hessian) hessian = q->metric_channels;
  return (ylm__channels){value, q->want & YLM_WANT_GRADIENT ? q->channels : 0, hessian};
}

static ylm_status check_points(const ylm_field_query *q, size_t n, const void *points,
                               ylm_error *e) {
  size_t where;
  if (!ylm_all_finite(q->dtype, points, 3 * n, &where))
    return ylm_fail(e, YLM_EDOMAIN, "point %zu is not finite", where / 3 + 1);
  for (size_t i = 0; i < 3 * n; i++)
    if (fabs(ylm_get(q->dtype, points, i)) > YLM_LIGHT_EXTENT)
      return ylm_fail(e, YLM_ERANGE, "point %zu is beyond %g", i / 3 + 1, YLM_LIGHT_EXTENT);
  return YLM_OK;
}

typedef struct job {
  const ylm_lights *lights;
  const ylm_field_query *q;
  const void *points;
  ylm_field_result *r;
  ylm__plan plan;
  ylm__sum_range *range;
  void **scratch; /* one for each worker */
} job;

static ylm_status run_reference(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  (void)worker;
  return ylm__reference_range(j->lights, j->q, begin, end, j->points, j->r);
}

static ylm_status run_kernels(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  return j->range(&j->plan, &j->scratch[worker], begin, end, j->points, j->r);
}

/* Points in a block of work: whole vectors, some 10^4 light-point pairs, at most 1024. */
static size_t grain(size_t lights, int lanes) {
  size_t vectors = 1 + 16384 / ((lights + 1) * (size_t)lanes);
  size_t most = 1024 / (size_t)lanes;
  return (vectors < most ? vectors : most) * (size_t)lanes;
}

static ylm_status sum(const ylm_lights *lights, ylm_isa isa, const ylm_field_query *q, size_t n,
                      const void *points, ylm_field_result *r) {
  job j = {.lights = lights, .q = q, .points = points, .r = r};
  ylm__kernel_set set;
  if (!ylm__kernels_of(isa, q->lmax, q->dtype, &set))
    return ylm_parallel(n, 4, q->threads, run_reference, &j, q->progress, "lights");
  size_t workers = (size_t)ylm_threads(q->threads);
  j.range = set.range;
  j.scratch = ylm_alloc_zero(workers, sizeof *j.scratch);
  if (!j.scratch) return YLM_ENOMEM;
  ylm_status s = ylm__plan_create(&j.plan, lights, q, set.moments);
  if (s == YLM_OK)
    s = ylm_parallel(n, grain(lights->active, set.moments->lanes), q->threads, run_kernels, &j,
                     q->progress, "lights");
  ylm__plan_free(&j.plan);
  for (size_t i = 0; i < workers; i++) ylm_free(j.scratch[i]);
  ylm_free(j.scratch);
  return s;
}

ylm_status ylm_light_check(const ylm_field_query *q, int most, size_t n, const void *points,
                           const ylm_field_result *r, ylm_error *e) {
  ylm_status s = ylm_field_check(q, n, NULL, r, most, "these lights", e);
  return s == YLM_OK ? check_points(q, n, points, e) : s;
}

ylm_status ylm__lights_check(const ylm_field_query *q, ylm_isa isa, size_t n, const void *points,
                             const ylm_field_result *r, ylm_error *e) {
  if (!ylm_isa_available(isa))
    return ylm_fail(e, YLM_EINVAL, "no kernels for '%s' here", ylm_isa_name(isa));
  return ylm_light_check(q, YLM_LIGHT_LMAX, n, points, r, e);
}

ylm_status ylm_lights_evaluate(const ylm_lights *lights, ylm_isa isa, const ylm_field_query *q,
                               size_t n, const void *points, ylm_field_result *r, ylm_error *e) {
  ylm_status s = ylm__lights_check(q, isa, n, points, r, e);
  if (s != YLM_OK) return s;
  ylm__local local;
  s = ylm__local_begin(q, lights->origin, n, points, &local);
  if (s == YLM_OK && n) s = sum(lights, isa, &local.q, n, local.points, r);
  ylm__local_end(&local);
  if (s != YLM_OK) return ylm_fail_plain(e, s);
  r->pairs += (uint64_t)n * lights->active;
  return ylm__lights_finite(lights, q, n, points, r, e);
}
