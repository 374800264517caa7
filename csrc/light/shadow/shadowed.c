/*
** shadowed.c - light behind bodies: the field, whose points are shared out in blocks.
**
**   shadowed(x) = P(L(x) prod V_i(x))
**
** with P the cut at lmax, L the light and V_i what body i lets through. All factors are multiplied at the directions of
** one rule (csrc/sh/product/nodes.c). A lamp of a place counts the bodies that are nearer than it; its light without
** them is summed with that of all lamps, and replaced where a body is before it.
**
** Source  Zhou et al. 2005; Xin et al. 2021, Sec. 5.3.2; docs/shadow_fields.md
*/
#include "shadow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../finite.h"
#include "../set.h"

static const char *const names[] = {
#define X(name) #name,
    YLM_SHADOW_PRODUCT_LIST(X)
#undef X
};

const char *ylm_shadow_product_name(ylm_shadow_product p) {
  return (unsigned)p < YLM_SHADOW_PRODUCT_COUNT ? names[p] : "?";
}

#define MOST_ACCURATE (YLM_SH_PRODUCT_FACTORS - 1)

/* -- tables ------------------------------------------------------------------------------------ */

static void free_tables(shadow_tables *t) {
  if (!t) return;
  ylm_sh_nodes_free(t->nodes);
  ylm_sh_rotator_free(t->rotator);
  ylm_sh_exponential_free(t->exponential);
  ylm__shadow_rings_free(&t->rings);
  ylm_free(t);
}

/* The degree of the rule by which the light and all casters are multiplied. */
static int degree_of(const ylm_light_shadowed *s, int lmax) {
  if (s->form.product == YLM_SHADOW_PRODUCT_accurate) return (int)(s->n + 2) * lmax;
  double rule = s->form.product == YLM_SHADOW_PRODUCT_rule ? s->form.rule : 3;
  return (int)ceil(rule * lmax);
}

/* The tables of an lmax, made where they are first needed. */
static ylm_status tables_of(const ylm_light_shadowed *s, int lmax, const shadow_tables **out,
                            ylm_error *e) {
  _Atomic(shadow_tables *) *at = &((ylm_light_shadowed *)(uintptr_t)s)->tables[lmax];
  shadow_tables *t = atomic_load(at), *none = NULL;
  *out = t;
  if (t) return YLM_OK;
  t = ylm_alloc_zero(1, sizeof *t);
  ylm_status status = t ? ylm_sh_nodes_create(lmax, degree_of(s, lmax), &t->nodes, e) : YLM_ENOMEM;
  if (status == YLM_OK) status = ylm_sh_rotator_create(lmax, &t->rotator, e);
  if (status == YLM_OK && s->spheres) status = ylm__shadow_rings_create(t->nodes, &t->rings);
  if (status == YLM_OK && s->form.product == YLM_SHADOW_PRODUCT_exp)
    status =
        ylm_sh_exponential_create(lmax, s->form.exponential, s->form.terms, &t->exponential, e);
  if (status != YLM_OK) {
    free_tables(t);
    return status;
  }
  if (!atomic_compare_exchange_strong(at, &none, t)) {
    free_tables(t);
    t = none;
  }
  *out = t;
  return YLM_OK;
}

/* -- queries ----------------------------------------------------------------------------------- */

typedef struct job {
  shadow_query w;
  _Atomic(bool) failed;
  ylm_error *e;
} job;

/* One thread's sentence is kept: that of the first that fails. */
static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  job *j = context;
  ylm_error e = {YLM_OK, ""};
  ylm_status s = j->w.q->dtype == YLM_DOUBLE ? ylm__shadow_block_d(&j->w, begin, end, worker, &e)
                                             : ylm__shadow_block_f(&j->w, begin, end, worker, &e);
  if (s == YLM_OK || atomic_exchange(&j->failed, true)) return s;
  if (e.text[0])
    ylm_fail(j->e, s, "%s", e.text);
  else
    ylm_fail_plain(j->e, s);
  return s;
}

static void free_turns(const ylm_light_shadowed *s, ylm_sh_rotation **turn) {
  for (size_t i = 0; turn && i < s->n; i++) ylm_sh_rotation_free(turn[i]);
  ylm_free(turn);
}

static ylm_status make_turns(const ylm_light_shadowed *s, const ylm_field_query *q,
                             const ylm_sh_rotator *rotator, ylm_sh_rotation ***out, ylm_error *e) {
  ylm_status status = YLM_OK;
  ylm_sh_rotation **turn = *out = ylm_alloc_zero(s->n, sizeof *turn);
  if (!turn) return YLM_ENOMEM;
  for (size_t i = 0; i < s->n && status == YLM_OK; i++)
    if (s->caster[i].turned && s->caster[i].form.hides)
      status = ylm_sh_rotation_create(rotator, s->caster[i].form.rotation, q->lmax, q->dtype,
                                      &turn[i], e);
  return status;
}

typedef struct placed {
  const shadow_caster *caster;
  size_t i;
} placed;

static int by_place(const void *a, const void *b) {
  const placed *p = a, *q = b;
  for (int k = 0; k < 3; k++)
    if (p->caster->centre[k] != q->caster->centre[k])
      return p->caster->centre[k] < q->caster->centre[k] ? -1 : 1;
  if (p->caster->radius != q->caster->radius) return p->caster->radius < q->caster->radius ? -1 : 1;
  return p->i < q->i ? -1 : p->i > q->i;
}

/* The casters by their places; NULL without memory. */
static size_t *order_casters(const ylm_light_shadowed *s) {
  placed *list = ylm_alloc(s->n, sizeof *list);
  size_t *order = list ? ylm_alloc(s->n, sizeof *order) : NULL;
  for (size_t i = 0; order && i < s->n; i++) list[i] = (placed){&s->caster[i], i};
  if (order) qsort(list, s->n, sizeof *list, by_place);
  for (size_t i = 0; order && i < s->n; i++) order[i] = list[i].i;
  ylm_free(list);
  return order;
}

/* Points of a block: fewer where there are few, so that all threads have some, and where gradients of what casters hide
   would not stay in the cache. */
static size_t grain_of(size_t n, int threads, size_t rows) {
  size_t share = n / (2 * (size_t)ylm_threads(threads)), lanes = (share + 15) / 16 * 16,
         most = rows > 1 ? SHADOW_BLOCK_GRADIENTS : SHADOW_BLOCK;
  return lanes < 16 ? 16 : lanes > most ? most : lanes;
}

/* Adds a query to what the light has done so far. */
static void note(const ylm_light_shadowed *s, shadow_query *w, size_t n, double seconds) {
  ylm_light_shadowed *to = (ylm_light_shadowed *)(uintptr_t)s;
  atomic_fetch_add(&to->points, n);
  atomic_fetch_add(&to->casters, atomic_load(&w->casters));
  atomic_fetch_add(&to->products, atomic_load(&w->products));
  atomic_fetch_add(&to->factors, atomic_load(&w->factors));
  atomic_fetch_add(&to->nanoseconds, (uint64_t)(1e9 * fmax(0, seconds)));
}

void ylm_light_shadowed_look(const ylm_light_shadowed *s, ylm_light_shadowed_stats *out) {
  ylm_light_shadowed *from = (ylm_light_shadowed *)(uintptr_t)s;
  *out = (ylm_light_shadowed_stats){.points = atomic_load(&from->points),
                                    .casters = atomic_load(&from->casters),
                                    .products = atomic_load(&from->products),
                                    .factors = atomic_load(&from->factors),
                                    .seconds = 1e-9 * (double)atomic_load(&from->nanoseconds)};
}

/* Light behind all casters but `skips` from `skip` on. */
static ylm_status answer(const ylm_light_shadowed *s, size_t skip, size_t skips,
                         const ylm_field_query *q, size_t n, const void *points,
                         ylm_field_result *r, ylm_error *e) {
  ylm_status status = ylm_field_check(q, n, points, r, YLM_SH_PRODUCT_LMAX, "these lights", e);
  if (status != YLM_OK) return status;
  if (q->want & YLM_WANT_HESSIAN)
    return ylm_fail(e, YLM_EINVAL, "shadowed light has no Hessians: derivatives = 1 at most");
  const shadow_tables *tables;
  double begin = ylm_seconds();
  job j = {.w = {.s = s,
                 .skip = skip,
                 .skips = skips,
                 .q = q,
                 .points = points,
                 .r = r,
                 .count = ylm_sh_count(q->lmax),
                 .rows = q->want & YLM_WANT_GRADIENT ? 4 : 1,
                 .metric = q->want & YLM_WANT_METRIC},
           .e = e};
  j.w.channels = q->channels == 3 || (j.w.metric && q->metric_channels == 3) ? 3 : 1;
  size_t rooms = (size_t)ylm_threads(q->threads) * ROOMS;
  j.w.sums = ylm__shadow_sums();
  j.w.add = ylm__shadow_add();
  j.w.room = ylm_alloc_zero(rooms, sizeof *j.w.room);
  j.w.block = ylm_alloc_zero(rooms / ROOMS, sizeof *j.w.block);
  size_t *order = order_casters(s);
  uint32_t *place = NULL;
  void *moved = NULL;
  j.w.order = order;
  status = j.w.room && j.w.block && order ? tables_of(s, q->lmax, &tables, e) : YLM_ENOMEM;
  if (status == YLM_OK) status = make_turns(s, q, tables->rotator, &j.w.turn, e);
  if (status == YLM_OK) {
    j.w.nodes = tables->nodes;
    j.w.rings = &tables->rings;
    for (int lone = 0; lone < 2; lone++)
      j.w.blur[lone] = ylm__shadow_blur(degree_of(s, q->lmax), lone);
    j.w.profile = j.w.blur[1].step > 1.2 ? NULL : ylm__shadow_profile();
    j.w.exponential = tables->exponential;
    if (s->even && n) {
      status = (q->dtype == YLM_DOUBLE ? ylm__shadow_even_d : ylm__shadow_even_f)(&j.w, e);
      atomic_store(&j.w.pairs, n * atomic_load(&j.w.pairs));
    }
  }
  if (status == YLM_OK && n > SHADOW_BLOCK && n <= UINT32_MAX) {
    status = ylm__shadow_order(q->dtype, n, points, &place, &moved) ? YLM_OK : YLM_ENOMEM;
    j.w.points = moved;
    j.w.place = place;
  }
  if (status == YLM_OK)
    status = ylm_parallel(n, grain_of(n, q->threads, j.w.rows), q->threads, run, &j, q->progress,
                          "shadows");
  ylm_free(j.w.even);
  free_turns(s, j.w.turn);
  ylm_free(order);
  ylm_free(place);
  ylm_free(moved);
  for (size_t i = 0; j.w.room && i < rooms; i++) ylm_free(j.w.room[i].at);
  ylm_free(j.w.room);
  for (size_t i = 0; j.w.block && i < rooms / ROOMS; i++)
    (q->dtype == YLM_DOUBLE ? ylm__shadow_block_free_d : ylm__shadow_block_free_f)(j.w.block[i]);
  ylm_free(j.w.block);
  r->pairs += atomic_load(&j.w.pairs);
  if (status == YLM_OK) note(s, &j.w, n, ylm_seconds() - begin);
  if (status == YLM_ENOMEM) return ylm_no_memory(e);
  return status == YLM_OK ? ylm_light_finite(q, n, points, r, e) : status;
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  return answer(f->self, 0, 0, q, n, points, r, e);
}

static ylm_status evaluate_rest(const ylm_field *f, const ylm_field_query *q, size_t n,
                                const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm_light_shadowed_rest *rest = f->self;
  return answer(rest->of, rest->first, rest->n, q, n, points, r, e);
}

/* The box, in the body's frame, around a box of space. */
static void box_in_frame(const ylm_light_caster *c, const double box[6], double out[6]) {
  for (int a = 0; a < 3; a++) {
    double middle = 0, half = 0;
    for (int k = 0; k < 3; k++) {
      middle += c->rotation[3 * k + a] * ((box[k] + box[3 + k]) / 2 - c->at[k]);
      half += fabs(c->rotation[3 * k + a]) * (box[3 + k] - box[k]) / 2;
    }
    out[a] = (middle - half) / c->scale;
    out[3 + a] = (middle + half) / c->scale;
  }
}

/* Does a box meet the surface of a sphere? */
static bool meets_sphere(const ylm_light_caster *c, const double box[6]) {
  double near = 0, far = 0;
  for (int a = 0; a < 3; a++) {
    double low = box[a] - c->at[a], high = box[3 + a] - c->at[a];
    double n = fmax(0, fmax(low, -high)), f = fmax(fabs(low), fabs(high));
    near += n * n;
    far += f * f;
  }
  return near <= c->scale * c->scale && far >= c->scale * c->scale;
}

static ylm_status add_crossing(const ylm_field *f, size_t n, const double *boxes, uint8_t *more,
                               uint8_t *out) {
  if (!f || !f->crosses) return YLM_OK;
  memset(more, 0, n);
  ylm_status s = f->crosses(f, n, boxes, more);
  for (size_t i = 0; i < n && s == YLM_OK; i++) out[i] |= more[i];
  return s;
}

static ylm_status cross(const ylm_light_shadowed *s, size_t skip, size_t skips, size_t n,
                        const double *boxes, uint8_t *out) {
  double *own = ylm_alloc(n, 6 * sizeof *own);
  uint8_t *more = ylm_alloc(n, 1);
  ylm_status status = own && more ? YLM_OK : YLM_ENOMEM;
  memset(out, 0, n);
  if (status == YLM_OK) status = add_crossing(s->local, n, boxes, more, out);
  if (status == YLM_OK) status = add_crossing(s->rest, n, boxes, more, out);
  for (size_t k = 0; k < s->n && status == YLM_OK; k++) {
    const ylm_light_caster *c = &s->caster[k].form;
    if (k >= skip && k - skip < skips) continue;
    for (size_t i = 0; i < n; i++) {
      if (c->hides)
        box_in_frame(c, boxes + 6 * i, own + 6 * i);
      else
        out[i] |= meets_sphere(c, boxes + 6 * i);
    }
    status = add_crossing(c->hides, n, own, more, out);
  }
  ylm_free(own);
  ylm_free(more);
  return status;
}

static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  return cross(f->self, 0, 0, n, boxes, out);
}

static ylm_status crosses_rest(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_light_shadowed_rest *rest = f->self;
  return cross(rest->of, rest->first, rest->n, n, boxes, out);
}

const ylm_field *ylm_light_shadowed_field(const ylm_light_shadowed *s) { return &s->field; }

const ylm_light_caster *ylm_light_shadowed_caster(const ylm_light_shadowed *s, size_t i) {
  return &s->caster[i].form;
}

ylm_status ylm_light_shadowed_without(const ylm_light_shadowed *s, size_t first, size_t n,
                                      ylm_light_shadowed_rest *rest) {
  if (first > s->n || n > s->n - first) return YLM_ERANGE;
  *rest = (ylm_light_shadowed_rest){s->field, s, first, n};
  rest->field.self = rest;
  rest->field.evaluate = evaluate_rest;
  rest->field.crosses = crosses_rest;
  return YLM_OK;
}

/* -- casters ------------------------------------------------------------------------------------ */

static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* Puts a caster at form's place; `i` counts from 1. */
static ylm_status settle(shadow_caster *c, size_t i, ylm_error *e) {
  ylm_light_caster *f = &c->form;
  if (!ylm_all_finite(YLM_DOUBLE, f->at, 3, NULL) || !isfinite(f->scale))
    return ylm_fail(e, YLM_EDOMAIN, "caster %zu is not finite", i);
  if (!(f->scale > 0))
    return ylm_fail(e, YLM_EDOMAIN, "caster %zu: scale must be above 0, got %g", i, f->scale);
  if (ylm_sh_rotation_check(f->rotation, f->rotation, NULL) != YLM_OK)
    return ylm_fail(e, YLM_EDOMAIN, "caster %zu: its rotation is none", i);
  c->turned = memcmp(f->rotation, identity, sizeof identity) != 0;
  c->radius = f->scale * f->radius;
  for (int a = 0; a < 3; a++) {
    c->centre[a] = f->at[a];
    for (int k = 0; k < 3; k++) c->centre[a] += f->scale * f->rotation[3 * a + k] * f->centre[k];
    if (fabs(c->centre[a]) + c->radius > YLM_LIGHT_EXTENT)
      return ylm_fail(e, YLM_ERANGE, "caster %zu is too far out (the limit is %g)", i,
                      YLM_LIGHT_EXTENT);
  }
  return YLM_OK;
}

static ylm_status add_caster(shadow_caster *c, const ylm_light_caster *from, bool spheres, size_t i,
                             ylm_error *e) {
  ylm_light_caster *f = &c->form;
  *f = *from;
  if (!f->hides) {
    f->radius = 1;
    f->far = 0;
    f->lmax = YLM_SH_PRODUCT_LMAX;
    memcpy(f->rotation, identity, sizeof identity);
    memset(f->centre, 0, sizeof f->centre);
  } else if (f->hides->quantity != YLM_QUANTITY_visibility)
    return ylm_fail(e, YLM_EINVAL, "caster %zu: a visibility expected, got %s", i,
                    ylm_quantity_name(f->hides->quantity));
  if (spheres && f->hides) {
    if (!ylm__occluder_ball(f->hides, f->centre, &f->radius))
      return ylm_fail(e, YLM_EINVAL,
                      "caster %zu is no sphere, and product 'exp' knows spheres only: "
                      "ylm.sphere_set makes spheres of a body",
                      i);
    f->far = 0;
  }
  if (!(f->radius > 0) || !isfinite(f->radius))
    return ylm_fail(e, YLM_EDOMAIN, "caster %zu: the radius of a body must be above 0, got %g", i,
                    f->radius);
  ylm_status s = settle(c, i, e);
  if (s != YLM_OK || !(f->far > 0)) return s;
  if (!(f->area > 0)) return ylm_fail(e, YLM_EDOMAIN, "caster %zu: its area must be above 0", i);
  return ylm_light_occluder_sphere(f->centre, sqrt(f->area / YLM_PI), &c->disk, e);
}

ylm_status ylm_light_shadowed_move(ylm_light_shadowed *s, size_t first, size_t n, const double *at,
                                   const double *rotation, const double *scale, ylm_error *e) {
  if (first > s->n || n > s->n - first) return ylm_fail(e, YLM_ERANGE, "there are no such casters");
  shadow_caster *was = ylm_alloc_copy(s->caster + first, n, sizeof *was);
  if (!was) return ylm_no_memory(e);
  ylm_status status = YLM_OK;
  for (size_t i = 0; i < n && status == YLM_OK; i++) {
    shadow_caster *c = &s->caster[first + i];
    if (at) memcpy(c->form.at, at + 3 * i, sizeof c->form.at);
    if (rotation && c->form.hides)
      memcpy(c->form.rotation, rotation + 9 * i, sizeof c->form.rotation);
    if (scale) c->form.scale = scale[i];
    status = settle(c, i + 1, e);
  }
  if (status != YLM_OK) ylm_copy(s->caster + first, was, n * sizeof *was);
  ylm_free(was);
  return status;
}

/* -- lights -------------------------------------------------------------------------------------- */

/* Lamps of a pack that can be told apart and have places. */
static bool is_local(const ylm__light_pack *p) {
  return p->kind->get && p->kind->reach && p->n <= SHADOW_LAMPS;
}

static ylm_status add_lamps(ylm_light_shadowed *s, const ylm__light_pack *p) {
  for (size_t i = 0; i < p->n; i++) {
    ylm_light light = {0};
    size_t numbers = p->kind->get(p->of, i, &light, NULL);
    ylm_light_shape *shape = ylm_alloc(1, sizeof *shape + numbers * sizeof shape->x[0]);
    if (!shape) return YLM_ENOMEM;
    if (numbers) p->kind->get(p->of, i, &light, shape);
    shadow_lamp *l = &s->lamp[s->lamps];
    const ylm_light *one = &light;
    memcpy(l->at, light.at, sizeof l->at);
    memcpy(l->rgb, light.radiance, sizeof l->rgb);
    l->radius = p->kind->reach(&light);
    ylm_status status = YLM_OK;
    if (light.radiance[0] != 0 || light.radiance[1] != 0 || light.radiance[2] != 0) {
      status = ylm_light_set_of(1, &one, (const double[]){1}, &l->grey);
      if (status == YLM_OK) s->lamps++;
    }
    ylm_free(shape);
    if (status != YLM_OK) return status;
  }
  return YLM_OK;
}

/* Lights become lamps, and light behind all casters. */
static ylm_status sort_lights(ylm_light_shadowed *s, const ylm_light_set *set,
                              const ylm_field *other) {
  size_t packs = set ? set->packs : 0, lamps = 0, locals = 0, rests = 0;
  const ylm_field **field = ylm_alloc(2 * packs + 2, sizeof *field);
  if (!field) return YLM_ENOMEM;
  const ylm_field **rest = field + packs;
  for (size_t k = 0; k < packs; k++) {
    const ylm__light_pack *p = set->pack[k];
    if (is_local(p)) {
      lamps += p->n;
      field[locals++] = p->field;
    } else
      rest[rests++] = p->field;
  }
  s->even = rests > 0 && !other;
  for (size_t k = 0; k < packs; k++)
    if (!is_local(set->pack[k]) && !set->pack[k]->kind->radiance) s->even = false;
  if (other) rest[rests++] = other;
  s->lamp = ylm_alloc_zero(lamps, sizeof *s->lamp);
  ylm_status status = s->lamp ? YLM_OK : YLM_ENOMEM;
  for (size_t k = 0; k < packs && status == YLM_OK; k++)
    if (is_local(set->pack[k])) status = add_lamps(s, set->pack[k]);
  if (status == YLM_OK && locals > 1) status = ylm_field_sum_create(locals, field, &s->local_sum);
  if (status == YLM_OK && rests > 1) status = ylm_field_sum_create(rests, rest, &s->rest_sum);
  if (status == YLM_OK) {
    s->local = s->local_sum ? ylm_field_sum_field(s->local_sum) : locals ? field[0] : NULL;
    s->rest = s->rest_sum ? ylm_field_sum_field(s->rest_sum) : rests ? rest[0] : NULL;
  }
  ylm_free((void *)field);
  return status;
}

/* -- bodies of spheres ---------------------------------------------------------------------------- */

static int by_number(const void *a, const void *b) {
  uint32_t p = *(const uint32_t *)a, q = *(const uint32_t *)b;
  return p < q ? -1 : p > q;
}

/* Notes which spheres are the only ones of their body. */
static ylm_status sort_bodies(ylm_light_shadowed *s) {
  uint32_t *body = ylm_alloc(s->n, sizeof *body);
  size_t n = 0;
  if (!body) return YLM_ENOMEM;
  for (size_t i = 0; i < s->n; i++)
    if (!s->caster[i].form.hides) body[n++] = s->caster[i].form.body;
  qsort(body, n, sizeof *body, by_number);
  s->spheres = n > 0;
  for (size_t i = 0; i < s->n; i++) {
    if (s->caster[i].form.hides) continue;
    uint32_t own = s->caster[i].form.body;
    const uint32_t *found = bsearch(&own, body, n, sizeof *body, by_number);
    s->caster[i].lone =
        !(found > body && found[-1] == own) && !(found + 1 < body + n && found[1] == own);
  }
  ylm_free(body);
  return YLM_OK;
}

/* -- making --------------------------------------------------------------------------------------- */

static ylm_status check_form(const ylm_light_shadow_form *f, size_t n, ylm_error *e) {
  if (n > YLM_CASTERS)
    return ylm_fail(e, YLM_ERANGE, "%zu casters, at most %d expected", n, YLM_CASTERS);
  if ((unsigned)f->product >= YLM_SHADOW_PRODUCT_COUNT)
    return ylm_fail(e, YLM_EINVAL, "no such product");
  if (!(f->rule >= 2 && f->rule <= 12))
    return ylm_fail(e, YLM_ERANGE, "rule must be 2 to 12, got %g", f->rule);
  if (f->product == YLM_SHADOW_PRODUCT_exp && (f->terms < 1 || f->terms > YLM_SH_EXP_TERMS))
    return ylm_fail(e, YLM_ERANGE, "1 to %d terms expected, got %d", YLM_SH_EXP_TERMS, f->terms);
  if (!(f->cull >= 0 && f->cull <= 1))
    return ylm_fail(e, YLM_ERANGE, "cull must be 0 to 1, got %g", f->cull);
  if (f->product == YLM_SHADOW_PRODUCT_accurate && n > MOST_ACCURATE)
    return ylm_fail(
        e, YLM_ERANGE,
        "product 'accurate' is for %d casters at most, got %zu: 'rule' takes any number",
        MOST_ACCURATE, n);
  return YLM_OK;
}

ylm_status ylm_light_shadowed_create(const ylm_light_set *lights, const ylm_field *other, size_t n,
                                     const ylm_light_caster *caster,
                                     const ylm_light_shadow_form *form, ylm_light_shadowed **out,
                                     ylm_error *e) {
  *out = NULL;
  ylm_status status = check_form(form, n, e);
  if (status != YLM_OK) return status;
  ylm_light_shadowed *s = ylm_alloc_zero(1, sizeof *s);
  if (s) s->caster = ylm_alloc_zero(n, sizeof *s->caster);
  if (!s || !s->caster) {
    ylm_free(s);
    return ylm_no_memory(e);
  }
  s->form = *form;
  s->field = (ylm_field){.self = s, .evaluate = evaluate, .crosses = crosses, .relative = true};
  for (size_t i = 0; i < n && status == YLM_OK; i++) {
    s->n = i + 1; /* what is freed */
    status =
        add_caster(&s->caster[i], &caster[i], form->product == YLM_SHADOW_PRODUCT_exp, i + 1, e);
  }
  if (status == YLM_OK) status = sort_bodies(s);
  if (status == YLM_OK) status = sort_lights(s, lights, other);
  if (status == YLM_OK) {
    s->field.quantity = other ? other->quantity : YLM_QUANTITY_lights;
    *out = s;
    return YLM_OK;
  }
  ylm_light_shadowed_free(s);
  return status == YLM_ENOMEM ? ylm_no_memory(e) : status;
}

void ylm_light_shadowed_free(ylm_light_shadowed *s) {
  if (!s) return;
  for (size_t i = 0; i < s->n; i++) ylm_light_occluder_free(s->caster[i].disk);
  for (size_t i = 0; i < s->lamps; i++) ylm_light_set_free(s->lamp[i].grey);
  for (int l = 0; l <= YLM_SH_PRODUCT_LMAX; l++) free_tables(atomic_load(&s->tables[l]));
  ylm_field_sum_free(s->local_sum);
  ylm_field_sum_free(s->rest_sum);
  ylm_free(s->caster);
  ylm_free(s->lamp);
  ylm_free(s);
}
