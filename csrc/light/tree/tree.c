/* tree.c - the field of lights to a tolerance: a query is given to the kernels with the tree. */
#include "tree.h"
#include "../finite.h"

#include <math.h>

struct ylm__tree_field {
  ylm_field field;
  const ylm_lights *lights;
  double tolerance;
};

typedef struct job {
  const ylm__tree_plan *plan;
  ylm__tree_range *range;
  void **scratch; /* [workers][3] */
  const void *points;
  ylm_field_result *r;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  return j->range(j->plan, j->scratch + 3 * worker, begin, end, j->points, j->r);
}

/* The pilot's query: all that is wanted, of the strengths. */
static ylm_field_query pilot_query(const ylm_field_query *q) {
  bool metric = q->want & YLM_WANT_METRIC;
  ylm_field_query p = *q;
  p.channels = p.metric_channels = 1;
  p.want = (q->want & YLM_WANT_GRADIENT) | YLM_WANT_VALUE;
  if (metric || q->want & YLM_WANT_HESSIAN) p.want |= YLM_WANT_HESSIAN;
  return p;
}

/* Sums by the tree; the plans are made, the pairs counted. */
static ylm_status sum(ylm__tree_plan *plan, const ylm__kernel_set *set, size_t n,
                      const void *points, ylm_field_result *r) {
  const ylm_field_query *q = plan->sums->q;
  size_t workers = (size_t)ylm_threads(q->threads);
  job j = {plan, set->tree, ylm_alloc_zero(3 * workers, sizeof *j.scratch), points, r};
  ylm__packing packing;
  ylm__tree_plan_blocks(plan, n);
  ylm_status s = ylm__packing_create(q->dtype, n, points, plan->block, &packing);
  plan->packing = &packing;
  if (!j.scratch) s = YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__packing_run(&packing, q, run, &j);
  for (size_t i = 0; j.scratch && i < workers; i++)
    if (j.scratch[3 * i]) r->pairs += *(const uint64_t *)j.scratch[3 * i];
  for (size_t i = 0; j.scratch && i < 3 * workers; i++) ylm_free(j.scratch[i]);
  ylm_free(j.scratch);
  ylm__packing_free(&packing);
  return s;
}

ylm_status ylm__tree_field_evaluate(const ylm__tree_field *t, ylm_isa isa, const ylm_field_query *q,
                                    size_t n, const void *points, ylm_field_result *r,
                                    ylm_error *e) {
  const ylm_lights *lights = t->lights;
  ylm_status s = ylm__lights_check(q, isa, n, points, r, e);
  if (s != YLM_OK || n == 0) return s;
  ylm__kernel_set set;
  bool kernels = ylm__kernels_of(isa, q->lmax, q->dtype, &set);
  if (!kernels || !ylm__tree_pays(lights->tree, q->lmax, t->tolerance))
    return ylm_lights_evaluate(lights, isa, q, n, points, r, e);
  ylm__plan sums = {0}, pilot = {0};
  ylm__tree_plan plan = {0};
  ylm__local local;
  s = ylm__local_begin(q, lights->origin, n, points, &local);
  ylm_field_query scales = pilot_query(&local.q);
  if (s == YLM_OK) s = ylm__plan_create(&sums, lights, &local.q, set.moments);
  if (s == YLM_OK) s = ylm__plan_create(&pilot, lights, &scales, set.moments);
  if (s == YLM_OK) s = ylm__tree_plan_create(&plan, lights->tree, t->tolerance, &sums, &pilot);
  if (s == YLM_OK) s = sum(&plan, &set, n, local.points, r);
  ylm__tree_plan_free(&plan);
  ylm__plan_free(&pilot);
  ylm__plan_free(&sums);
  ylm__local_end(&local);
  if (s != YLM_OK) return ylm_fail_plain(e, s);
  return ylm__lights_finite(lights, q, n, points, r, e);
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  return ylm__tree_field_evaluate(f->self, ylm_isa_current(), q, n, points, r, e);
}

static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm__tree_field *t = f->self;
  const ylm_field *lights = &t->lights->field;
  return lights->crosses(lights, n, boxes, out);
}

ylm_status ylm__tree_field_create(ylm_lights *lights, double tolerance, int threads,
                                  ylm__tree_field **out, ylm_error *e) {
  *out = NULL;
  ylm__tree_field *c = ylm_alloc(1, sizeof *c);
  ylm_status s = lights->tree ? YLM_OK : ylm__tree_create(lights, threads, &lights->tree);
  if (!c || s != YLM_OK) ylm_free(c);
  if (!c || s != YLM_OK) return ylm_no_memory(e);
  *c = (ylm__tree_field){
      {.self = c, .evaluate = evaluate, .crosses = crosses, .relative = true}, lights, tolerance};
  *out = c;
  return YLM_OK;
}

void ylm__tree_field_free(ylm__tree_field *t) { ylm_free(t); }

const ylm_field *ylm__tree_field_get(const ylm__tree_field *t) { return &t->field; }
