/*
** occluder.c - what one body hides: a sphere, or a convex solid.
**
** The visibility is v = sqrt(4 pi) e_0 - o. Of a sphere, o is the field of a sphere light of
** radiance 1. Of a convex solid, o is half the sum of its faces as polygons that emit radiance 1 to
** both sides: each direction through the solid crosses two faces. The shares of an edge cancel where both of its faces
** are seen from the same side; ylm_polygons_join leaves the outline.
*/
#include "../set.h"
#include "shadow.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ylm_sh.h"

struct ylm_light_occluder {
  ylm_field field;
  ylm_light_set *light; /* o */
  double at[3], radius, area;
  double middle[3]; /* inside of it */
  size_t planes;
  double *plane; /* [planes][4] unit normal, outwards, and offset; a sphere has none */
};

void ylm_light_occluder_free(ylm_light_occluder *o) {
  if (!o) return;
  ylm_light_set_free(o->light);
  ylm_free(o->plane);
  ylm_free(o);
}

const ylm_field *ylm_light_occluder_field(const ylm_light_occluder *o) { return &o->field; }

void ylm_light_occluder_body(const ylm_light_occluder *o, double at[3], double *radius,
                             double *area) {
  memcpy(at, o->at, sizeof o->at);
  *radius = o->radius;
  *area = o->area;
}

/* The distance from the middle to the surface along w. */
static double surface(const ylm_light_occluder *o, const double w[3]) {
  double t = o->planes ? INFINITY : o->radius;
  for (size_t k = 0; k < o->planes; k++) {
    const double *n = o->plane + 4 * k;
    double along = n[0] * w[0] + n[1] * w[1] + n[2] * w[2];
    double above = n[3] - n[0] * o->middle[0] - n[1] * o->middle[1] - n[2] * o->middle[2];
    if (along > 0) t = fmin(t, above / along);
  }
  return t;
}

void ylm_light_occluder_places(const ylm_light_occluder *o, double near, double far, uint64_t seed,
                               size_t n, float *places) {
  ylm_rng r;
  ylm_rng_seed(&r, seed, 19);
  for (size_t i = 0; i < n; i++) {
    double z = 2 * ylm_rng_double(&r) - 1, phi = 2 * YLM_PI * ylm_rng_double(&r),
           u = ylm_rng_double(&r);
    double sine = sqrt(1 - z * z), w[3] = {sine * cos(phi), sine * sin(phi), z};
    double from = (1 + near) * surface(o, w), t = from * pow(fmax(1, far / from), u);
    for (size_t a = 0; a < 3; a++) places[3 * i + a] = (float)(o->middle[a] + t * w[a]);
  }
}

/* -- the field ------------------------------------------------------------------------------ */

/* Is p in or on the solid? */
static bool is_in(const ylm_light_occluder *o, const double p[3]) {
  for (size_t k = 0; k < o->planes; k++) {
    const double *n = o->plane + 4 * k;
    if (n[0] * p[0] + n[1] * p[1] + n[2] * p[2] > n[3]) return false;
  }
  return o->planes > 0;
}

static void negate(ylm_dtype t, void *x, size_t n) {
  double *d = x;
  float *f = x;
  if (t == YLM_DOUBLE)
    for (size_t i = 0; i < n; i++) d[i] = -d[i];
  else
    for (size_t i = 0; i < n; i++) f[i] = -f[i];
}

/* Results of o become those of v at point i. */
static void turn(const ylm_light_occluder *o, const ylm_field_query *q, size_t i,
                 const void *points, ylm_field_result *r) {
  size_t count = ylm_sh_count(q->lmax), channels = (size_t)q->channels;
  void *out[3] = {q->want & YLM_WANT_VALUE ? r->value : NULL,
                  q->want & YLM_WANT_GRADIENT ? r->gradient : NULL,
                  q->want & YLM_WANT_HESSIAN ? r->hessian : NULL};
  static const size_t width[3] = {1, 3, 6};
  size_t size = ylm_dtype_size(q->dtype);
  double p[3], square = 0;
  for (size_t a = 0; a < 3; a++) p[a] = ylm_get(q->dtype, points, 3 * i + a);
  bool inside = is_in(o, p) || (!o->planes && r->inside[i]);
  for (int k = 0; k < 3; k++) {
    if (!out[k]) continue;
    size_t n = channels * count * width[k];
    char *row = (char *)out[k] + i * n * size;
    if (inside)
      memset(row, 0, n * size);
    else
      negate(q->dtype, row, n);
  }
  for (size_t c = 0; out[0] && !inside && c < channels; c++) {
    size_t at = (i * channels + c) * count;
    ylm_put(q->dtype, out[0], at, LIGHT_ONE + ylm_get(q->dtype, out[0], at));
  }
  if (o->planes) r->inside[i] = inside;
  if (!(q->want & YLM_WANT_METRIC)) return;
  if (inside && r->lambda) ylm_put(q->dtype, r->lambda, i, 0);
  for (size_t k = 0; k < count; k++) {
    double x = ylm_get(q->dtype, out[0], i * channels * count + k);
    square += x * x;
  }
  if (r->norm) ylm_put(q->dtype, r->norm, i, sqrt((q->metric_channels == 3 ? 3 : 1) * square));
}

static ylm_status ask(const ylm_light_occluder *o, const ylm_field_query *q, size_t n,
                      const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm_field *light = ylm_light_set_field(o->light);
  ylm_status s = light->evaluate(light, q, n, points, r, e);
  for (size_t i = 0; i < n && s == YLM_OK; i++) turn(o, q, i, points, r);
  return s;
}

/* The metric takes values, and all that jumps takes to be told: both are asked for in any case. */
static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  ylm_field_query all = *q;
  ylm_field_result own = *r;
  size_t values = n * (size_t)q->channels * ylm_sh_count(q->lmax);
  bool metric = q->want & YLM_WANT_METRIC;
  void *value = NULL;
  uint8_t *inside = NULL;
  ylm_status s = ylm_field_check(q, n, points, r, YLM_LIGHT_LMAX, "these lights", e);
  if (s != YLM_OK) return s;
  if (metric && !(q->want & YLM_WANT_VALUE)) {
    all.want |= YLM_WANT_VALUE;
    own.value = value = ylm_alloc(values, ylm_dtype_size(q->dtype));
    if (!value) s = YLM_ENOMEM;
  }
  if (!own.inside) {
    own.inside = inside = ylm_alloc_zero(n, 1);
    if (!inside) s = YLM_ENOMEM;
  }
  if (s == YLM_OK)
    s = ask(f->self, &all, n, points, &own, e);
  else
    ylm_fail_plain(e, s);
  r->pairs = own.pairs;
  ylm_free(value);
  ylm_free(inside);
  return s;
}

static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_light_occluder *o = f->self;
  const ylm_field *light = ylm_light_set_field(o->light);
  return light->crosses(light, n, boxes, out);
}

bool ylm__occluder_ball(const ylm_field *f, double at[3], double *radius) {
  if (f->evaluate != evaluate) return false;
  const ylm_light_occluder *o = f->self;
  memcpy(at, o->at, sizeof o->at);
  *radius = o->radius;
  return o->planes == 0;
}

/* -- making ---------------------------------------------------------------------------------- */

static ylm_light_occluder *begin(void) {
  ylm_light_occluder *o = ylm_alloc_zero(1, sizeof *o);
  if (o)
    o->field = (ylm_field){
        .self = o, .evaluate = evaluate, .crosses = crosses, .quantity = YLM_QUANTITY_visibility};
  return o;
}

ylm_status ylm_light_occluder_sphere(const double at[3], double radius, ylm_light_occluder **out,
                                     ylm_error *e) {
  static const double one[3] = {1, 1, 1};
  *out = NULL;
  if (!(radius > 0))
    return ylm_fail(e, YLM_EDOMAIN, "the radius of a body must be above 0, got %g", radius);
  ylm_light_occluder *o = begin();
  if (!o) return ylm_no_memory(e);
  memcpy(o->at, at, sizeof o->at);
  o->radius = radius;
  o->area = YLM_PI * radius * radius;
  memcpy(o->middle, at, sizeof o->middle);
  ylm_status s = ylm_light_set_spheres(1, at, &radius, one, &o->light, e);
  if (s != YLM_OK) {
    ylm_light_occluder_free(o);
    return s;
  }
  *out = o;
  return YLM_OK;
}

ylm_status ylm_light_occluder_solid(size_t vertices, const float *position, size_t triangles,
                                    const uint32_t *index, ylm_light_occluder **out, ylm_error *e) {
  *out = NULL;
  ylm__solid solid;
  ylm_status s = ylm__solid_create(vertices, position, triangles, index, &solid, e);
  if (s != YLM_OK) return s;
  ylm_light_occluder *o = begin();
  if (o) {
    ylm_light_source source = {.kind = "polygon", .record = solid.record, .numbers = solid.numbers};
    memcpy(o->at, solid.centre, sizeof o->at);
    o->radius = solid.radius;
    o->area = solid.area / 4;
    memcpy(o->middle, solid.middle, sizeof o->middle);
    o->planes = solid.planes;
    o->plane = solid.plane;
    solid.plane = NULL;
    s = ylm_light_set_create(1, &source, &o->light, e);
    const ylm__light_pack *faces = s == YLM_OK ? o->light->pack[0] : NULL;
    if (faces && faces->kind->join(faces->of) != YLM_OK) s = ylm_no_memory(e);
  } else
    s = ylm_no_memory(e);
  ylm_free(solid.record);
  ylm_free(solid.plane);
  if (s == YLM_OK)
    *out = o;
  else
    ylm_light_occluder_free(o);
  return s;
}
