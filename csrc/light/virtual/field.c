/* field.c - the light field of virtual lights: queries, shared out to kernels. */
#include "plan.h"

typedef struct job {
  const ylm_light_virtual *lights;
  const ylm_field_query *q;
  const void *points;
  ylm_field_result *r;
  ylm__virtual_range *range;
  ylm__virtual_plan plan;
} job;

static ylm_status run_reference(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  (void)worker;
  return ylm__virtual_reference(j->lights, j->q, begin, end, j->points, j->r);
}

static ylm_status run_kernels(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  (void)worker;
  return j->range(&j->plan, begin, end, j->points, j->r);
}

static ylm_status sum(job *j, ylm_isa isa, size_t n) {
  const ylm_field_query *q = j->q;
  j->range = ylm__virtual_kernel(isa, q);
  if (!j->range) return ylm_parallel(n, 4, q->threads, run_reference, j, q->progress, "lights");
  ylm_status s = ylm__virtual_plan_create(&j->plan, j->lights, q);
  size_t grain = j->lights->n > 4096 ? 16 : j->lights->n > 256 ? 64 : 256;
  if (s == YLM_OK) s = ylm_parallel(n, grain, q->threads, run_kernels, j, q->progress, "lights");
  ylm__virtual_plan_free(&j->plan);
  return s;
}

ylm_status ylm_light_virtual_evaluate(const ylm_light_virtual *v, ylm_isa isa,
                                      const ylm_field_query *q, size_t n, const void *points,
                                      ylm_field_result *r, ylm_error *e) {
  ylm_status s = ylm__lights_check(q, isa, n, points, r, e);
  if (s != YLM_OK) return s;
  ylm__local local;
  s = ylm__local_begin(q, v->origin, n, points, &local);
  job j = {.lights = v, .q = &local.q, .points = local.points, .r = r};
  if (s == YLM_OK && n) s = sum(&j, isa, n);
  ylm__local_end(&local);
  if (s != YLM_OK) return ylm_fail_plain(e, s);
  r->pairs += (uint64_t)n * v->n;
  return ylm_light_finite(q, n, points, r, e);
}
