/* tree.c - the field of virtual lights to a tolerance: plans of queries, which are given to the kernels. */
#include "tree.h"

#include "../../finite.h"
#include "ylm_sets.h"

/* -- plans ---------------------------------------------------------------------------------- */

/* The pilot's query: all that is wanted, of the strengths. */
static ylm_field_query pilot_query(const ylm_field_query *q) {
  bool metric = q->want & YLM_WANT_METRIC;
  ylm_field_query p = *q;
  p.channels = p.metric_channels = 1;
  p.want = (q->want & YLM_WANT_GRADIENT) | YLM_WANT_VALUE;
  if (metric || q->want & YLM_WANT_HESSIAN) p.want |= YLM_WANT_HESSIAN;
  return p;
}

/* Wants, strengths and factors of a query's bounds. */
static void find_bounds(ylm__virtual_tree_plan *p, const ylm_field_query *q) {
  bool metric = q->want & YLM_WANT_METRIC, rgb = q->channels == 3;
  int hessians = q->want & YLM_WANT_HESSIAN ? q->channels : 0;
  if (metric && q->metric_channels > hessians) hessians = q->metric_channels;
  if (metric && q->metric_channels == 3) rgb = true;
  p->want[0] = metric || q->want & YLM_WANT_VALUE;
  p->want[1] = q->want & YLM_WANT_GRADIENT;
  p->want[2] = hessians;
  p->at[0] = p->at[1] = rgb ? YLM__STRENGTH_RGB : YLM__STRENGTH_LUM;
  p->at[2] = hessians == 3 ? YLM__STRENGTH_RGB : YLM__STRENGTH_LUM;
  double G[YLM__NORMS];
  ylm__tree_norms(q->lmax, G);
  for (int k = 0; k < 3; k++) {
    p->norm[k] = G[k] / YLM_PI; /* of intensity 1 */
    for (int j = 0; j < 4; j++) p->c[k][j] = (float)(G[1 + k + j] / G[k]);
  }
  /* High degrees vary faster. */
  float high = fminf(1, sqrtf(5.0f / (float)(q->lmax + 1)));
  p->share[0] = VIRTUAL_SHARE_VALUE;
  p->share[1] = VIRTUAL_SHARE_GRADIENT * (double)high;
  p->share[2] =
      (q->want & YLM_WANT_HESSIAN ? VIRTUAL_SHARE_HESSIAN : VIRTUAL_SHARE_METRIC) * (double)high;
  p->flat[0] = VIRTUAL_FLAT_VALUE;
  p->flat[1] = VIRTUAL_FLAT_GRADIENT;
  p->flat[2] = VIRTUAL_FLAT_HESSIAN;
  p->even = VIRTUAL_EVEN;
  const bool rough = (q->want & YLM_WANT_ROUGH) && !(q->want & YLM_WANT_HESSIAN);
  p->kink = rough ? 0 : (float)(VIRTUAL_KINK * G[0] / G[2]);
  p->graze = VIRTUAL_GRAZE;
  p->margin = VIRTUAL_MARGIN;
  p->one_sign = VIRTUAL_ONE_SIGN;
  p->cancelled = (float)VIRTUAL_CANCELLED;
  p->widest = VIRTUAL_WIDEST * high;
  p->pilot_widest =
      (p->want[1] || p->want[2] ? VIRTUAL_PILOT_WIDEST : VIRTUAL_PILOT_WIDEST_VALUE) * high;
}

/* Sums without Hessians, where they are laid out as part of the others. */
static ylm_status leave_out(ylm__virtual_tree_plan *p, const ylm_field_query *q) {
  const ylm__virtual_tree *t = p->tree;
  p->dimmed = *q;
  p->dimmed.want &= ~(YLM_WANT_HESSIAN | YLM_WANT_METRIC);
  ylm_status s = ylm__virtual_plan_create(&p->dim[0], t->lights, &p->dimmed);
  p->dim[1] = p->dim[2] = p->dim[0];
  p->dim[1].lights = &t->matte, p->dim[2].lights = &t->rich;
  p->dims = p->dim[0].straight == p->lights.straight;
  for (int i = 0; i < 2; i++) p->dims &= p->dim[0].of[i].kinds == (p->lights.of[i].kinds & 3);
  for (int j = 0; j < YLM__TAILS; j++) p->skip[j] = 2 * powf(0.5f, 0.5f * (float)j);
  return s;
}

ylm_status ylm__virtual_tree_plan_create(ylm__virtual_tree_plan *p, const ylm__virtual_tree *t,
                                         double tolerance, const ylm_field_query *q) {
  *p = (ylm__virtual_tree_plan){.tree = t, .tolerance = tolerance, .scales = pilot_query(q)};
  find_bounds(p, q);
  if (t->lights->profile == YLM_LIGHT_VIRTUAL_FAR)
    p->nearest = (float)(VIRTUAL_CORES * t->lights->core / t->size);
  ylm_status s = ylm__virtual_plan_create(&p->lights, t->lights, q);
  if (s == YLM_OK) s = ylm__virtual_plan_create(&p->pilot[0], t->lights, &p->scales);
  p->matte = p->rich = p->lights;
  p->pilot[1] = p->pilot[2] = p->pilot[0];
  p->matte.lights = p->pilot[1].lights = &t->matte;
  p->rich.lights = p->pilot[2].lights = &t->rich;
  if (s == YLM_OK && p->want[2]) s = leave_out(p, q);
  return s;
}

void ylm__virtual_tree_plan_free(ylm__virtual_tree_plan *p) {
  ylm__virtual_plan_free(&p->lights);
  ylm__virtual_plan_free(&p->pilot[0]);
  if (p->want[2]) ylm__virtual_plan_free(&p->dim[0]);
}

/* As ylm__tree_pays. */
bool ylm__virtual_tree_pays(const ylm__virtual_tree *t, int lmax, double tolerance) {
  double least = (VIRTUAL_FEW + 15.0 * lmax * lmax) * pow(0.1 / tolerance, 0.44);
  return t && (double)t->lights->n >= least;
}

YLM_KERNEL_CHOICE_OF(ylm__virtual_tree_range, ylm__virtual_tree_kernel, ylm__virtual_tree, NULL);

/* -- the field ------------------------------------------------------------------------------ */

typedef struct within {
  ylm_field field;
  ylm_light_virtual *lights;
  double tolerance;
} within;

typedef struct job {
  const ylm__virtual_tree_plan *plan;
  ylm__virtual_tree_range *range;
  void **scratch; /* [workers] */
  const float *points;
  ylm_field_result *r;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  return j->range(j->plan, j->scratch + worker, begin, end, j->points, j->r);
}

/* Sums by the tree; the pairs are counted. */
static ylm_status sum(ylm__virtual_tree_plan *plan, ylm__virtual_tree_range *range, size_t n,
                      const void *points, ylm_field_result *r) {
  const ylm_field_query *q = plan->lights.q;
  const size_t workers = (size_t)ylm_threads(q->threads);
  job j = {plan, range, ylm_alloc_zero(workers, sizeof *j.scratch), points, r};
  ylm__packing packing;
  ylm_status s = ylm__packing_create(q->dtype, n, points, 2 * YLM__PACKET, &packing);
  plan->packing = &packing;
  if (!j.scratch) s = YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__packing_run(&packing, q, run, &j);
  for (size_t i = 0; j.scratch && i < workers; i++) {
    if (j.scratch[i]) r->pairs += *(const uint64_t *)j.scratch[i];
    ylm_free(j.scratch[i]);
  }
  ylm_free(j.scratch);
  ylm__packing_free(&packing);
  return s;
}

ylm_status ylm__virtual_within_evaluate(const void *of, ylm_isa isa, const ylm_field_query *q,
                                        size_t n, const void *points, ylm_field_result *r,
                                        ylm_error *e) {
  const within *w = of;
  const ylm__virtual_tree *t = w->lights->tree;
  ylm__virtual_tree_range *range = ylm__virtual_tree_kernel(isa);
  bool narrow = q->dtype == YLM_FLOAT && q->lmax <= YLM__VIRTUAL_FLOAT;
  if (!range || !narrow || !ylm__virtual_tree_pays(t, q->lmax, w->tolerance) || n == 0)
    return ylm_light_virtual_evaluate(w->lights, isa, q, n, points, r, e);
  ylm_status s = ylm__lights_check(q, isa, n, points, r, e);
  if (s != YLM_OK) return s;
  ylm__virtual_tree_plan plan;
  ylm__local local;
  s = ylm__local_begin(q, w->lights->origin, n, points, &local);
  if (s == YLM_OK) {
    s = ylm__virtual_tree_plan_create(&plan, t, w->tolerance, &local.q);
    if (s == YLM_OK) s = sum(&plan, range, n, local.points, r);
    ylm__virtual_tree_plan_free(&plan);
  }
  ylm__local_end(&local);
  if (s != YLM_OK) return ylm_fail_plain(e, s);
  return ylm_light_finite(q, n, points, r, e);
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  return ylm__virtual_within_evaluate(f->self, ylm_isa_current(), q, n, points, r, e);
}

static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const within *w = f->self;
  return w->lights->field.crosses(&w->lights->field, n, boxes, out);
}

ylm_status ylm__virtual_within(void *of, double tolerance, int threads, ylm_field **field,
                               ylm_error *e) {
  ylm_light_virtual *v = of;
  *field = NULL;
  within *w = ylm_alloc(1, sizeof *w);
  ylm_status s = w ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && !v->tree) s = ylm__virtual_tree_create(v, threads, &v->tree);
  if (s != YLM_OK) {
    ylm_free(w);
    return ylm_fail_plain(e, s);
  }
  *w = (within){
      {.self = w, .evaluate = evaluate, .crosses = crosses, .relative = true}, v, tolerance};
  *field = &w->field;
  return YLM_OK;
}

void ylm__virtual_within_free(ylm_field *field) {
  if (field) ylm_free((void *)(uintptr_t)field->self);
}

size_t ylm__virtual_within_bytes(const void *of) {
  const ylm_light_virtual *v = of;
  return ylm__virtual_tree_bytes(v->tree);
}
