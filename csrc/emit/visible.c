/* visible.c - the light field of virtual lights that surfaces hide from points: a ray from each point to each light. */
#include "emit.h"
#include "ylm_light.h"
#include "ylm_light_virtual.h"

#define GRAIN 4  /* points */
#define RAYS 256 /* that are traced together */

struct ylm_emit_visible {
  ylm_field field; /* whose `self` it is */
  const ylm_scene *scene;
  ylm_light_set *set;      /* keeps the lights */
  ylm_light_virtual *none; /* of their profile: darkness */
  ylm_light_virtual_form form;
};

typedef struct job {
  const ylm_emit_visible *v;
  const ylm_field_query *q;
  const void *points;
  ylm_field_result *r;
  uint64_t *pairs; /* [threads] */
} job;

/* Lights that a point sees, as they are given to the kernels. */
typedef struct seen {
  size_t n;
  double *at, *normal, *radius, *shift, *emission; /* one block of memory */
  ylm_trace_ray ray[RAYS];
  size_t light[RAYS], rays;
} seen;

static size_t wide(const ylm_light_virtual_form *f) {
  return 3 * YLM_LIGHT_VIRTUAL_NUMBERS(f->degree);
}

static bool begin_seen(const ylm_light_virtual_form *all, seen *s) {
  size_t n = all->n;
  s->at = ylm_alloc(n + 1, (8 + wide(all)) * sizeof *s->at);
  if (!s->at) return false;
  s->normal = s->at + 3 * n;
  s->radius = s->at + 6 * n;
  s->shift = s->at + 7 * n;
  s->emission = s->at + 8 * n;
  return true;
}

/* Appends light i, which is seen. */
static void take(const ylm_light_virtual_form *all, size_t i, seen *s) {
  size_t n = s->n++, w = wide(all);
  memcpy(s->at + 3 * n, all->at + 3 * i, 3 * sizeof *s->at);
  memcpy(s->normal + 3 * n, all->normal + 3 * i, 3 * sizeof *s->normal);
  memcpy(s->emission + w * n, all->emission + w * i, w * sizeof *s->emission);
  s->radius[n] = all->radius[i];
  s->shift[n] = all->shift[i];
}

static void trace(const ylm_emit_visible *v, seen *s) {
  ylm_trace_occluded(ylm_scene_trace(v->scene), s->rays, s->ray);
  for (size_t k = 0; k < s->rays; k++)
    if (!(s->ray[k].far < 0)) take(&v->form, s->light[k], s);
  s->rays = 0;
}

/* Whether light i shows its back to a point that is `to` away from it, at distance d. */
static bool shows_back(const ylm_light_virtual_form *f, size_t i, const double to[3], double d) {
  const double *n = f->normal + 3 * i;
  bool turned = n[0] != 0 || n[1] != 0 || n[2] != 0;
  return turned && f->shift[i] * d - n[0] * to[0] - n[1] * to[1] - n[2] * to[2] <= 0;
}

/* The lights that x sees. */
static void look(const ylm_emit_visible *v, const double x[3], seen *s) {
  const ylm_light_virtual_form *f = &v->form;
  const ylm_trace *trace_of = ylm_scene_trace(v->scene);
  float from[3], near;
  ylm_scene_enter(v->scene, x, from);
  near = ylm_trace_offset(trace_of, from);
  s->n = s->rays = 0;
  for (size_t i = 0; i < f->n; i++) {
    double to[3], d = 0;
    float at[3];
    ylm_scene_enter(v->scene, f->at + 3 * i, at);
    for (size_t a = 0; a < 3; a++) {
      to[a] = f->at[3 * i + a] - x[a];
      d += to[a] * to[a];
    }
    d = sqrt(d);
    if (d > 0 && shows_back(f, i, to, d)) continue;
    float far = (float)(d * (1 - 1e-4)) - ylm_trace_offset(trace_of, at);
    if (!(far > near)) { /* nothing fits between */
      trace(v, s);
      take(f, i, s);
      continue;
    }
    ylm_trace_ray *ray = &s->ray[s->rays];
    for (size_t a = 0; a < 3; a++) {
      ray->org[a] = from[a];
      ray->dir[a] = (float)(to[a] / d);
    }
    ray->near = near;
    ray->far = far;
    s->light[s->rays++] = i;
    if (s->rays == RAYS) trace(v, s);
  }
  trace(v, s);
}

/* Where results of point i go. */
static ylm_field_result part_of(const job *j, size_t i) {
  size_t n = (size_t)j->q->channels * (size_t)(j->q->lmax + 1) * (size_t)(j->q->lmax + 1);
  size_t size = ylm_dtype_size(j->q->dtype);
  const ylm_field_result *r = j->r;
#define AT(x, step) ((x) ? (void *)((char *)(x) + i * (step)*size) : NULL)
  ylm_field_result part = {.value = AT(r->value, n),
                           .gradient = AT(r->gradient, 3 * n),
                           .hessian = AT(r->hessian, 6 * n),
                           .lambda = AT(r->lambda, 1),
                           .norm = AT(r->norm, 1)};
#undef AT
  return part;
}

static ylm_status run_point(const job *j, size_t i, seen *s, uint64_t *pairs) {
  double x[3];
  ylm_light_virtual *lights;
  ylm_field_query q = *j->q;
  ylm_field_result r = part_of(j, i);
  q.threads = 1;
  q.progress = NULL;
  for (size_t a = 0; a < 3; a++)
    x[a] = ylm_get(q.dtype, j->points, 3 * i + a) + (q.origin ? q.origin[a] : 0);
  look(j->v, x, s);
  if (s->n == 0) return YLM_OK; /* darkness is there */
  ylm_light_virtual_form f = j->v->form;
  f.n = s->n;
  f.at = s->at;
  f.normal = s->normal;
  f.radius = s->radius;
  f.shift = s->shift;
  f.emission = s->emission;
  ylm_status status = ylm_light_virtual_create(&f, &lights, NULL);
  if (status != YLM_OK) return status;
  status = ylm_light_virtual_evaluate(lights, ylm_isa_current(), &q, 1,
                                      (const char *)j->points + 3 * i * ylm_dtype_size(q.dtype), &r,
                                      NULL);
  *pairs += r.pairs;
  ylm_light_virtual_free(lights);
  return status;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  seen *s = ylm_alloc_zero(1, sizeof *s);
  ylm_status status = s && begin_seen(&j->v->form, s) ? YLM_OK : YLM_ENOMEM;
  for (size_t i = begin; status == YLM_OK && i < end; i++)
    status = run_point(j, i, s, &j->pairs[worker]);
  if (s) ylm_free(s->at);
  ylm_free(s);
  return status;
}

/* Darkness first, which looks at the query and the points; then what each point sees. */
static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm_emit_visible *v = f->self;
  ylm_field_query quiet = *q;
  quiet.progress = NULL;
  ylm_status s = ylm_light_virtual_evaluate(v->none, ylm_isa_current(), &quiet, n, points, r, e);
  if (s != YLM_OK) return s;
  int threads = ylm_threads(q->threads);
  job j = {v, q, points, r, ylm_alloc_zero((size_t)threads, sizeof *j.pairs)};
  s = j.pairs ? ylm_parallel(n, GRAIN, q->threads, run, &j, q->progress, "lights") : YLM_ENOMEM;
  for (int i = 0; j.pairs && i < threads; i++) r->pairs += j.pairs[i];
  ylm_free(j.pairs);
  if (s == YLM_OK || s == YLM_EDOMAIN || s == YLM_ERANGE) {
    ylm_status where = ylm_light_finite(q, n, points, r, e);
    if (where != YLM_OK) return where;
  }
  return s == YLM_OK ? s : ylm_fail_plain(e, s);
}

static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_field *own = ylm_light_set_field(((const ylm_emit_visible *)f->self)->set);
  return own->crosses(own, n, boxes, out);
}

ylm_status ylm_emit_visible_create(const ylm_scene *scene, ylm_light_virtual *lights,
                                   ylm_emit_visible **visible, ylm_error *e) {
  ylm_emit_visible *v = ylm_alloc_zero(1, sizeof *v);
  *visible = NULL;
  if (!v) return ylm_no_memory(e);
  ylm_light_virtual_get(lights, &v->form);
  v->scene = scene;
  v->field = (ylm_field){.self = v,
                         .evaluate = evaluate,
                         .crosses = crosses,
                         .quantity = YLM_QUANTITY_indirect,
                         .relative = true};
  ylm_light_virtual_form none = v->form;
  none.n = 0;
  ylm_status s = ylm_light_virtual_create(&none, &v->none, e);
  if (s == YLM_OK) s = ylm_light_set_virtual(lights, &v->set, e);
  if (s != YLM_OK) {
    ylm_emit_visible_free(v);
    return s;
  }
  *visible = v;
  return s;
}

void ylm_emit_visible_free(ylm_emit_visible *v) {
  if (!v) return;
  ylm_light_virtual_free(v->none);
  ylm_light_set_free(v->set);
  ylm_free(v);
}

const ylm_field *ylm_emit_visible_field(const ylm_emit_visible *v) { return &v->field; }
