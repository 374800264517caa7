/*
** occlusion.c - the visibility of a mesh by rays: integrals over its rim.
**
** With H the directions that hit, m the normal of the rim into H, t the distance of what stands at the rim:
**
**   o_lm      = int_H Y_lm dw = 1/(l(l+1)) oint m . grad Y_lm ds,   l > 0
**   o_00      = |H| / sqrt(4 pi)
**   grad o_lm = oint m Y_lm / t ds
**
** by Gauss' theorem, since Y is an eigenfunction of the Laplacian of the sphere; the gradient since a point that moves by
** dx sees a place at distance t turn by -dx/t. The visibility is sqrt(4 pi) in (0, 0) less o.
**
** Source  Zhou et al. 2005; Ward & Heckbert 1992; docs/shadow_fields.md
*/
#include <math.h>
#include <string.h>

#include "occlusion.h"
#include "ylm_light.h"
#include "ylm_light_shadow.h"
#include "ylm_math.h"
#include "ylm_sh.h"
#include "ylm_vector.h"

#define LIGHT_ONE 3.54490770181103205459 /* sqrt(4 pi): the function 1 */

/* Bodies that are seen within this half angle have one map across them. */
#define NARROW (YLM_PI / 4)
/* A map is wider than its body by this factor, so that the rim lies in it. */
#define MARGIN 1.04
/* Arcs longer than this, times lmax, have two nodes of Gauss' rule: one errs by a square of it over 24. */
#define LONG_ARC 0.06
/* Nodes that are summed at once. */
#define BATCH 64
/* Of |sum of m Y / t^2|: that many times it is the largest eigenvalue of Hessians, or more. */
#define STEEP 6
/* Directions by which a point knows that it is in the body. */
#define LOOKS 14
/* Places and rays by which areas are measured. */
#define AREA_PLACES 128
#define AREA_RAYS 16

struct ylm_trace_occlusion {
  ylm_field field;
  ylm_trace *trace;
  int rays;
  double at[3], radius, area, turn; /* turn: -1 where triangles are clockwise from outside */
  size_t triangles;
  float *position;   /* [triangles][3][3] */
  double *area_upto; /* [triangles] of the surface */
};

void ylm_trace_occlusion_free(ylm_trace_occlusion *o) {
  if (!o) return;
  ylm_trace_free(o->trace);
  ylm_free(o->position);
  ylm_free(o->area_upto);
  ylm_free(o);
}

const ylm_field *ylm_trace_occlusion_field(const ylm_trace_occlusion *o) { return &o->field; }

void ylm_trace_occlusion_body(const ylm_trace_occlusion *o, double at[3], double *radius,
                              double *area) {
  memcpy(at, o->at, sizeof o->at);
  *radius = o->radius;
  *area = o->area;
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/* -- one point -------------------------------------------------------------------------------- */

/* Memory of one thread. */
typedef struct room {
  rim_room rim;
  double *sum;                   /* [7][count]: value, gradient, and what the metric takes */
  double *Y, *dY;                /* [BATCH][count], [BATCH][count][3] */
  double node[BATCH][3];         /* directions */
  double m[BATCH][3];            /* normals of the rim */
  double ds[BATCH], over[BATCH]; /* lengths, 1/t */
  size_t nodes;
} room;

typedef struct job {
  const ylm_trace_occlusion *o;
  const ylm_field_query *q;
  const void *points;
  ylm_field_result *r;
  room *room;
  int rays;
} job;

static ylm_status room_for(room *r, size_t count) {
  if (!r->sum) r->sum = ylm_alloc(7 * count, sizeof *r->sum);
  if (!r->Y) r->Y = ylm_alloc(BATCH * count, sizeof *r->Y);
  if (!r->dY) r->dY = ylm_alloc(BATCH * count, 3 * sizeof *r->dY);
  return r->sum && r->Y && r->dY ? YLM_OK : YLM_ENOMEM;
}

static void room_free(room *r) {
  ylm__rim_free(&r->rim);
  ylm_free(r->sum);
  ylm_free(r->Y);
  ylm_free(r->dY);
}

/* Adds the nodes that wait to the sums. */
static ylm_status add_nodes(room *r, int lmax, bool gradient, bool metric, ylm_error *e) {
  size_t count = ylm_sh_count(lmax);
  ylm_status s =
      ylm_sh_eval(lmax, 1, false, YLM_DOUBLE, r->nodes, r->node, r->Y, r->dY, NULL, 1, e);
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < r->nodes; i++) {
    const double *Y = r->Y + i * count, *dY = r->dY + 3 * i * count, *m = r->m[i];
    double *to = r->sum, ds = r->ds[i];
    for (size_t k = 1; k < count; k++)
      to[k] += ds * (m[0] * dY[3 * k] + m[1] * dY[3 * k + 1] + m[2] * dY[3 * k + 2]);
    for (int d = 1; d < (metric ? 7 : gradient ? 4 : 1); d++) {
      double f = ds * m[(d - 1) % 3] * r->over[i] * (d > 3 ? r->over[i] : 1);
      to += count;
      for (size_t k = 0; k < count; k++) to[k] += f * Y[k];
    }
  }
  r->nodes = 0;
  return YLM_OK;
}

/* The solid angle of the triangle of directions, negative where they are clockwise (van Oosterom & Strackee 1983). */
static double triangle(const double a[3], const double b[3], const double c[3]) {
  double n[3];
  cross(b, c, n);
  return 2 * atan2(dot(a, n), 1 + dot(a, b) + dot(b, c) + dot(c, a));
}

/* An arc's part of the sums. */
static ylm_status add_arc(room *r, const rim_arc *arc, int lmax, bool gradient, bool metric,
                          ylm_error *e) {
  const double *a = arc->a.w, *b = arc->b.w;
  double m[3], side[3];
  cross(a, b, m);
  double sine = sqrt(dot(m, m)), angle = atan2(sine, dot(a, b));
  if (!(sine > 1e-12)) return YLM_OK;
  for (int k = 0; k < 3; k++) m[k] /= sine;
  cross(m, a, side);
  int n = angle * lmax > LONG_ARC ? 2 : 1;
  double from = 1 / arc->a.t, to = 1 / arc->b.t;
  for (int i = 0; i < n; i++) {
    double u = n == 1 ? 0.5 : 0.5 + (i ? 1 : -1) * 0.28867513459481288225, c = cos(u * angle),
           s = sin(u * angle);
    size_t at = r->nodes++;
    for (int k = 0; k < 3; k++) {
      r->node[at][k] = c * a[k] + s * side[k];
      r->m[at][k] = m[k];
    }
    r->ds[at] = angle / n;
    r->over[at] = from + u * (to - from);
    if (r->nodes < BATCH) continue;
    ylm_status status = add_nodes(r, lmax, gradient, metric, e);
    if (status != YLM_OK) return status;
  }
  return YLM_OK;
}

/* Two directions across w, so that (across, up, w) is right-handed. */
static void frame(const double w[3], double across[3], double up[3]) {
  double sign = copysign(1, w[2]), a = -1 / (sign + w[2]), b = w[0] * w[1] * a;
  across[0] = 1 + sign * w[0] * w[0] * a;
  across[1] = sign * b;
  across[2] = -sign * w[0];
  up[0] = b;
  up[1] = sign + w[1] * w[1] * a;
  up[2] = -w[1];
}

/* One map across a body that is seen within an angle of `angle` about w. */
static rim_map narrow_map(const double w[3], double angle, int rays) {
  rim_map m = {.cells = 2 * rays, .cosine = cos((1 + MARGIN) / 2 * angle)};
  double wide = tan(MARGIN * angle);
  memcpy(m.middle, w, sizeof m.middle);
  frame(w, m.across, m.up);
  for (int a = 0; a < 3; a++) m.across[a] *= wide, m.up[a] *= wide;
  return m;
}

/* A face of a cube of directions. */
static rim_map cube_map(int face, int rays) {
  rim_map m = {.cells = rays, .cosine = -2};
  int axis = face / 2;
  double sign = face % 2 ? -1 : 1;
  m.middle[axis] = sign;
  m.across[(axis + 1) % 3] = 1;
  m.up[(axis + 2) % 3] = sign;
  return m;
}

/* Do most of the sides that p sees belong to the inside? */
static bool is_in(const ylm_trace_occlusion *o, const double p[3]) {
  ylm_trace_ray ray[LOOKS];
  ylm_trace_hit hit[LOOKS];
  int back = 0, seen = 0;
  for (int i = 0; i < LOOKS; i++) {
    double d[3];
    ylm_spiral(i, LOOKS, d);
    ray[i] = (ylm_trace_ray){.far = INFINITY};
    for (int a = 0; a < 3; a++) {
      ray[i].org[a] = (float)p[a];
      ray[i].dir[a] = (float)d[a];
    }
  }
  ylm_trace_nearest(o->trace, LOOKS, ray, false, hit);
  for (int i = 0; i < LOOKS; i++) {
    if (hit[i].mesh == YLM_TRACE_NOTHING) continue;
    double along = 0;
    for (int a = 0; a < 3; a++) along += (double)(ray[i].dir[a] * hit[i].normal[a]);
    seen++;
    back += along * o->turn > 0;
  }
  return 2 * back > LOOKS && 2 * back > seen;
}

/* The sums of what the body hides from p; *inside: p is in it, and nothing is summed. */
static ylm_status sum_rim(const job *j, room *r, const double p[3], bool *inside, ylm_error *e) {
  const ylm_trace_occlusion *o = j->o;
  int lmax = j->q->lmax;
  size_t count = ylm_sh_count(lmax);
  bool metric = j->q->want & YLM_WANT_METRIC, gradient = metric || j->q->want & YLM_WANT_GRADIENT;
  double w[3], hit = 0, solid = 0;
  for (int a = 0; a < 3; a++) w[a] = o->at[a] - p[a];
  double d = sqrt(dot(w, w)), sine = d > o->radius ? o->radius / d : 1;
  for (int a = 0; a < 3; a++) w[a] = d > 0 ? w[a] / d : a == 2;
  memset(r->sum, 0, 7 * count * sizeof *r->sum);
  r->rim.arcs = r->nodes = 0;
  *inside = sine == 1 && is_in(o, p);
  if (*inside) return YLM_OK;
  bool narrow = asin(sine) < NARROW;
  ylm_status s = YLM_OK;
  for (int face = 0; face < (narrow ? 1 : 6) && s == YLM_OK; face++) {
    rim_map m = narrow ? narrow_map(w, asin(sine), j->rays) : cube_map(face, j->rays);
    s = ylm__rim_find(o->trace, p, &m, &r->rim, &hit);
  }
  for (size_t i = 0; i < r->rim.arcs && s == YLM_OK; i++) {
    const rim_arc *arc = &r->rim.arc[i];
    solid += triangle(w, arc->a.w, arc->b.w);
    s = add_arc(r, arc, lmax, gradient, metric, e);
  }
  if (s == YLM_OK && r->nodes) s = add_nodes(r, lmax, gradient, metric, e);
  if (s != YLM_OK) return s;
  /* triangles know solid angles but for whole spheres */
  solid += 4 * YLM_PI * round((hit - solid) / (4 * YLM_PI));
  r->sum[0] = fmax(0, fmin(4 * YLM_PI, solid)) / LIGHT_ONE;
  for (int l = 1; l <= lmax; l++)
    for (size_t k = (size_t)(l * l); k < (size_t)((l + 1) * (l + 1)); k++) r->sum[k] /= l * (l + 1);
  return YLM_OK;
}

static void write(const job *j, const room *r, size_t i, bool inside) {
  const ylm_field_query *q = j->q;
  size_t count = ylm_sh_count(q->lmax), channels = (size_t)q->channels;
  double square = 0, steep = 0;
  for (size_t k = 0; k < count; k++) {
    double v = inside ? 0 : (k ? 0 : LIGHT_ONE) - r->sum[k];
    square += v * v;
    for (size_t c = 0; c < channels; c++) {
      size_t to = (i * channels + c) * count + k;
      if (q->want & YLM_WANT_VALUE) ylm_put(q->dtype, j->r->value, to, v);
      for (size_t d = 0; d < 3 && q->want & YLM_WANT_GRADIENT; d++)
        ylm_put(q->dtype, j->r->gradient, 3 * to + d, inside ? 0 : -r->sum[(d + 1) * count + k]);
    }
    for (size_t d = 4; d < 7 && q->want & YLM_WANT_METRIC; d++)
      steep += r->sum[d * count + k] * r->sum[d * count + k];
  }
  if (j->r->inside) j->r->inside[i] = inside;
  if (!(q->want & YLM_WANT_METRIC)) return;
  double channel = sqrt(q->metric_channels == 3 ? 3 : 1);
  if (j->r->norm) ylm_put(q->dtype, j->r->norm, i, channel * sqrt(square));
  if (j->r->lambda) ylm_put(q->dtype, j->r->lambda, i, inside ? 0 : channel * STEEP * sqrt(steep));
}

/* -- the field ------------------------------------------------------------------------------- */

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  room *r = &j->room[worker];
  ylm_status s = room_for(r, ylm_sh_count(j->q->lmax));
  for (size_t i = begin; i < end && s == YLM_OK; i++) {
    double p[3];
    bool inside;
    for (size_t a = 0; a < 3; a++) p[a] = ylm_get(j->q->dtype, j->points, 3 * i + a);
    s = sum_rim(j, r, p, &inside, NULL);
    if (s == YLM_OK) write(j, r, i, inside);
  }
  return s;
}

static ylm_status ask(const ylm_trace_occlusion *o, int rays, const ylm_field_query *q, size_t n,
                      const void *points, ylm_field_result *r, ylm_error *e) {
  int threads = ylm_threads(q->threads);
  job j = {o, q, points, r, ylm_alloc_zero((size_t)threads, sizeof *j.room), rays};
  ylm_status s = j.room ? ylm_parallel(n, 4, threads, run, &j, q->progress, "rays") : YLM_ENOMEM;
  for (int i = 0; j.room && i < threads; i++) room_free(&j.room[i]);
  ylm_free(j.room);
  r->pairs += n;
  return s == YLM_OK ? s : ylm_fail_plain(e, s);
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm_trace_occlusion *o = f->self;
  if (q->lmax < 0 || q->lmax > YLM_LIGHT_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax: 0 to %d, got %d", YLM_LIGHT_LMAX, q->lmax);
  if (q->want & YLM_WANT_HESSIAN)
    return ylm_fail(e, YLM_EINVAL,
                    "a body by rays has no Hessians: derivatives = 1 at most, or a convex body");
  ylm_status s = ylm_trace_check(q->dtype, n, points, "point", e);
  if (s != YLM_OK) return s;
  return ask(o, o->rays, q, n, points, r, e);
}

/* -- boxes ------------------------------------------------------------------------------------- */

typedef struct box_look {
  const ylm_trace_occlusion *o;
  double middle[3], half[3];
  bool met;
} box_look;

/* Do a triangle's shadow and the box's on an axis lie apart? */
static bool is_apart(const double axis[3], const double v[3][3], const double half[3]) {
  double least = INFINITY, most = -INFINITY, reach = 0, size = 0;
  for (int i = 0; i < 3; i++) {
    double x = dot(axis, v[i]);
    least = fmin(least, x);
    most = fmax(most, x);
    size = fmax(size, fabs(axis[0] * v[i][0]) + fabs(axis[1] * v[i][1]) + fabs(axis[2] * v[i][2]));
  }
  for (int a = 0; a < 3; a++) reach += fabs(axis[a]) * half[a];
  reach += 1e-14 * (size + reach);
  return least > reach || most < -reach;
}

/* By separating axes (Akenine-Moeller 2001). */
static bool meets_triangle(const box_look *b, const float *position) {
  double v[3][3], edge[3][3], axis[3];
  for (int i = 0; i < 3; i++)
    for (int a = 0; a < 3; a++) v[i][a] = (double)position[3 * i + a] - b->middle[a];
  for (int i = 0; i < 3; i++)
    for (int a = 0; a < 3; a++) edge[i][a] = v[(i + 1) % 3][a] - v[i][a];
  cross(edge[0], edge[1], axis);
  if (is_apart(axis, v, b->half)) return false;
  for (int a = 0; a < 3; a++) {
    double unit[3] = {a == 0, a == 1, a == 2};
    if (is_apart(unit, v, b->half)) return false;
    for (int i = 0; i < 3; i++) {
      cross(unit, edge[i], axis);
      if (is_apart(axis, v, b->half)) return false;
    }
  }
  return true;
}

/* Embree shows triangles near the middle; the first that the box meets ends the search. */
static bool look_at(struct RTCPointQueryFunctionArguments *a) {
  box_look *b = a->userPtr;
  if (b->met || !meets_triangle(b, b->o->position + 9 * (size_t)a->primID)) return false;
  b->met = true;
  a->query->radius = 0;
  return true;
}

static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_trace_occlusion *o = f->self;
  for (size_t i = 0; i < n; i++) {
    box_look b = {.o = o};
    struct RTCPointQueryContext context;
    double reach = 0;
    for (int a = 0; a < 3; a++) {
      b.middle[a] = (boxes[6 * i + (size_t)a] + boxes[6 * i + 3 + (size_t)a]) / 2;
      b.half[a] = (boxes[6 * i + 3 + (size_t)a] - boxes[6 * i + (size_t)a]) / 2;
      reach += b.half[a] * b.half[a];
    }
    float at[3] = {(float)b.middle[0], (float)b.middle[1], (float)b.middle[2]};
    struct RTCPointQuery q = {.x = at[0],
                              .y = at[1],
                              .z = at[2],
                              .radius =
                                  (float)(1.001 * sqrt(reach)) + ylm_trace_offset(o->trace, at)};
    rtcInitPointQueryContext(&context);
    rtcPointQuery(o->trace->occluders, &q, &context, look_at, &b);
    out[i] = b.met;
  }
  return YLM_OK;
}

/* -- places --------------------------------------------------------------------------------- */

/* A random place of the surface and its normal, outwards. */
static void surface_place(const ylm_trace_occlusion *o, ylm_rng *rng, double p[3], double n[3]) {
  double x = ylm_rng_double(rng) * o->area_upto[o->triangles - 1], u = sqrt(ylm_rng_double(rng)),
         v = ylm_rng_double(rng), e[2][3];
  const float *t = o->position + 9 * ylm_interval_at(o->triangles, o->area_upto, x);
  for (int a = 0; a < 3; a++) {
    p[a] = (1 - u) * (double)t[a] + u * (1 - v) * (double)t[3 + a] + u * v * (double)t[6 + a];
    for (int i = 0; i < 2; i++) e[i][a] = (double)t[3 * (i + 1) + a] - (double)t[a];
  }
  cross(e[0], e[1], n);
  double length = sqrt(dot(n, n));
  for (int a = 0; a < 3; a++) n[a] *= o->turn / fmax(length, 1e-300);
}

/* A direction by the cosine to n. */
static void random_direction(const double n[3], ylm_rng *rng, double w[3]) {
  double across[3], up[3], r = sqrt(ylm_rng_double(rng)), phi = 2 * YLM_PI * ylm_rng_double(rng);
  frame(n, across, up);
  for (int a = 0; a < 3; a++)
    w[a] = r * (cos(phi) * across[a] + sin(phi) * up[a]) + sqrt(1 - r * r) * n[a];
}

/* One place; false: it starts in the body. */
static bool draw_place(const ylm_trace_occlusion *o, double near, double far, ylm_rng *rng,
                       float out[3]) {
  double p[3], n[3], w[3], back[3], d = 0;
  surface_place(o, rng, p, n);
  random_direction(n, rng, w);
  double u = ylm_rng_double(rng);
  ylm_trace_ray ray[2] = {{.far = INFINITY}, {.far = INFINITY}};
  ylm_trace_hit hit[2];
  for (int a = 0; a < 3; a++) {
    p[a] += near * n[a];
    back[a] = p[a] - o->at[a];
    ray[0].org[a] = ray[1].org[a] = (float)p[a];
    ray[0].dir[a] = (float)w[a];
    ray[1].dir[a] = (float)-n[a];
  }
  ylm_trace_nearest(o->trace, 2, ray, false, hit);
  /* what stands below is the place's own triangle, and not another part of the body */
  if (hit[1].mesh == YLM_TRACE_NOTHING || !(fabs((double)hit[1].t - near) < 0.01 * near))
    return false;
  if (is_in(o, p)) return false;
  /* where the way leaves the sphere of radius `far` */
  double b = dot(back, w), c = dot(back, back) - far * far, most = -b + sqrt(fmax(0, b * b - c));
  if (hit[0].mesh != YLM_TRACE_NOTHING) most = fmin(most, (double)hit[0].t - near);
  double from = fmax(near, sqrt(dot(back, back)));
  if (most > 0) d = from * (pow(1 + most / from, u) - 1);
  for (int a = 0; a < 3; a++) out[a] = (float)(p[a] + d * w[a]);
  return true;
}

ylm_status ylm_trace_occlusion_places(const ylm_trace_occlusion *o, double near, double far,
                                      uint64_t seed, size_t n, float *places, ylm_error *e) {
  ylm_rng rng;
  ylm_rng_seed(&rng, seed, 20);
  for (size_t i = 0, left = 100 * n + 1000; i < n; left--) {
    if (!left)
      return ylm_fail(e, YLM_EDOMAIN,
                      "no room is left %.3g off the body's surface: near is too far", near);
    if (draw_place(o, near, far, &rng, places + 3 * i)) i++;
  }
  return YLM_OK;
}

/* -- noise ----------------------------------------------------------------------------------- */

ylm_status ylm_trace_occlusion_noise(const ylm_trace_occlusion *o, int lmax, size_t n,
                                     const float *places, int threads, double *noise,
                                     ylm_error *e) {
  size_t count = ylm_sh_count(lmax);
  float *v = ylm_alloc(2 * n * count, sizeof *v);
  ylm_field_query q = {.lmax = lmax,
                       .channels = 1,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 1,
                       .dtype = YLM_FLOAT,
                       .threads = threads};
  *noise = 0;
  if (!v) return ylm_no_memory(e);
  ylm_field_result all = {.value = v}, half = {.value = v + n * count};
  ylm_status s = ask(o, o->rays, &q, n, places, &all, e);
  if (s == YLM_OK) s = ask(o, (o->rays + 1) / 2, &q, n, places, &half, e);
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    double square = 0;
    for (size_t k = 0; k < count; k++) {
      double x = (double)v[i * count + k] - (double)v[(n + i) * count + k];
      square += x * x;
    }
    *noise = fmax(*noise, sqrt(square) / LIGHT_ONE / 2);
  }
  ylm_free(v);
  return s;
}

/* -- making ---------------------------------------------------------------------------------- */

/* The mean area of projections, by the solid angle that the body takes from far away: places along a spiral. */
static ylm_status measure_area(ylm_trace_occlusion *o, ylm_error *e) {
  float place[AREA_PLACES][3], v[AREA_PLACES];
  double far = 20 * o->radius, sum = 0;
  for (int i = 0; i < AREA_PLACES; i++) {
    double w[3];
    ylm_spiral(i, AREA_PLACES, w);
    for (int a = 0; a < 3; a++) place[i][a] = (float)(o->at[a] + far * w[a]);
  }
  ylm_field_query q = {.lmax = 0,
                       .channels = 1,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 1,
                       .dtype = YLM_FLOAT,
                       .threads = 1};
  ylm_field_result r = {.value = v};
  ylm_status s = ask(o, o->rays < AREA_RAYS ? o->rays : AREA_RAYS, &q, AREA_PLACES, place, &r, e);
  if (s != YLM_OK) return s;
  for (int i = 0; i < AREA_PLACES; i++) sum += (LIGHT_ONE - (double)v[i]) * LIGHT_ONE;
  o->area = fmax(1e-6 * o->radius * o->radius, sum / AREA_PLACES * far * far);
  return YLM_OK;
}

static ylm_status copy_triangles(ylm_trace_occlusion *o, const float *position,
                                 const uint32_t *index) {
  double upto = 0, e[2][3], normal[3];
  o->position = ylm_alloc(o->triangles, 9 * sizeof *o->position);
  o->area_upto = ylm_alloc(o->triangles, sizeof *o->area_upto);
  if (!o->position || !o->area_upto) return YLM_ENOMEM;
  for (size_t t = 0; t < o->triangles; t++) {
    float *to = o->position + 9 * t;
    for (size_t k = 0; k < 3; k++)
      memcpy(to + 3 * k, position + 3 * (size_t)index[3 * t + k], 3 * sizeof *to);
    for (int i = 0; i < 2; i++)
      for (int a = 0; a < 3; a++) e[i][a] = (double)to[3 * (i + 1) + a] - (double)to[a];
    cross(e[0], e[1], normal);
    o->area_upto[t] = upto += sqrt(dot(normal, normal)) / 2;
  }
  return YLM_OK;
}

ylm_status ylm_trace_occlusion_create(size_t vertices, const float *position, size_t triangles,
                                      const uint32_t *index, int rays, ylm_trace_occlusion **out,
                                      ylm_error *e) {
  ylm_light_body body;
  *out = NULL;
  if (rays < YLM_OCCLUSION_LEAST_RAYS || rays > YLM_OCCLUSION_MOST_RAYS)
    return ylm_fail(e, YLM_ERANGE, "rays: %d to %d, got %d", YLM_OCCLUSION_LEAST_RAYS,
                    YLM_OCCLUSION_MOST_RAYS, rays);
  ylm_status s = ylm_light_body_measure(vertices, position, triangles, index, &body, e);
  if (s != YLM_OK) return s;
  ylm_trace_occlusion *o = ylm_alloc_zero(1, sizeof *o);
  if (!o) return ylm_no_memory(e);
  o->field = (ylm_field){
      .self = o, .evaluate = evaluate, .crosses = crosses, .quantity = YLM_QUANTITY_visibility};
  memcpy(o->at, body.at, sizeof o->at);
  o->radius = body.radius;
  o->turn = body.volume < 0 ? -1 : 1;
  o->rays = rays;
  o->triangles = triangles;
  ylm_trace_mesh mesh = {position, vertices, index, triangles, true};
  s = copy_triangles(o, position, index);
  if (s == YLM_OK) s = ylm_trace_create(1, &mesh, &(ylm_trace_lamps){0}, &o->trace, e);
  if (s == YLM_OK) s = measure_area(o, e);
  if (s == YLM_OK)
    *out = o;
  else
    ylm_trace_occlusion_free(o);
  return s == YLM_ENOMEM ? ylm_no_memory(e) : s;
}
