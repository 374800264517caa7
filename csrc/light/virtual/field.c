/* field.c - the light field of virtual lights: queries, shared out to kernels. */
#include "virtual.h"

typedef struct job {
  const ylm_light_virtual *lights;
  const ylm_field_query *q;
  const void *points;
  ylm_field_result *r;
} job;

static ylm_status run_reference(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  (void)worker;
  return ylm__virtual_reference(j->lights, j->q, begin, end, j->points, j->r);
}

ylm_status ylm_light_virtual_evaluate(const ylm_light_virtual *v, ylm_isa isa,
                                      const ylm_field_query *q, size_t n, const void *points,
                                      ylm_field_result *r, ylm_error *e) {
  ylm_status s = ylm__lights_check(q, isa, n, points, r, e);
  if (s != YLM_OK) return s;
  job j = {v, q, points, r};
  s = ylm_parallel(n, 4, q->threads, run_reference, &j, q->progress, "lights");
  if (s != YLM_OK) return ylm_fail(e, s, "%s", ylm_status_text(s));
  r->pairs += (uint64_t)n * v->n;
  return ylm_light_finite(q, n, points, r, e);
}
