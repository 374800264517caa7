/* polygon.c - polygon lights: exact, by integrals along their edges, and approximated by spheres.
 */
#include <math.h>
#include <string.h>

#include "light.h"
#include "ylm_sh.h"

#define PI 3.14159265358979323846
#define MAX_VERTICES (2 * YLM_POLYGON_VERTICES)

/* Nodes along an edge at most: degree 60 on half a circle. */
#define MOST_NODES 96
#define RULES 7
#define EXACT_LMAX 60

static double dot(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static void cross(const double *a, const double *b, double *c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}
static double length(const double *a) { return sqrt(dot(a, a)); }

/* -- one polygon, exactly
 * -------------------------------------------------------------------------- */

/* n Gauss-Legendre nodes on -1 .. 1; a light's own, small copy of Newton's method. */
static void gauss(int n, double *x, double *w) {
  for (int i = 0; i < n; i++) {
    double t = cos(PI * (i + 0.75) / (n + 0.5)), derivative = 1;
    for (int pass = 0; pass < 20; pass++) {
      double a = 1, b = 0;
      for (int k = 1; k <= n; k++) {
        double c = ((2 * k - 1) * t * a - (k - 1) * b) / k;
        b = a;
        a = c;
      }
      derivative = n * (t * a - b) / (t * t - 1);
      double step = a / derivative;
      t -= step;
      if (fabs(step) < 1e-16) break;
    }
    x[i] = t;
    w[i] = 2 / ((1 - t * t) * derivative * derivative);
  }
}

/* Rules of the lengths that are used. */
typedef struct rules {
  double x[RULES][MOST_NODES], w[RULES][MOST_NODES];
} rules;
static const int rule_length[RULES] = {12, 16, 24, 32, 48, 64, MOST_NODES};

static void make_rules(rules *r) {
  for (int i = 0; i < RULES; i++) gauss(rule_length[i], r->x[i], r->w[i]);
}

/* Cuts the polygon v (relative to the shading point) at the plane across `up`; real[i] tells
   whether the edge from i to i+1 is one of the polygon. Returns the number of vertices. */
static int clip(int n, const double (*v)[3], const double *up, double (*out)[3], bool *real) {
  int m = 0;
  for (int i = 0; i < n; i++) {
    const double *a = v[i], *b = v[(i + 1) % n];
    double ha = dot(a, up), hb = dot(b, up);
    if (ha >= 0) {
      memcpy(out[m], a, sizeof out[m]);
      real[m++] = true;
    }
    if ((ha >= 0) != (hb >= 0)) {
      double t = ha / (ha - hb);
      for (int k = 0; k < 3; k++) out[m][k] = a[k] + t * (b[k] - a[k]);
      real[m++] = ha < 0; /* leaving: the next edge runs along the horizon */
      if (ha >= 0) real[m - 1] = false;
    }
  }
  return m;
}

/* The solid angle of a fan of triangles with sign: counter-clockwise seen from outside is positive.
 */
static double solid_angle(int n, const double (*u)[3]) {
  double sum = 0, c[3];
  for (int i = 1; i + 1 < n; i++) {
    cross(u[0], u[i], c);
    sum += 2 *
           atan2(dot(c, u[i + 1]), 1 + dot(u[0], u[i]) + dot(u[i], u[i + 1]) + dot(u[i + 1], u[0]));
  }
  return sum;
}

typedef struct edge {
  double a[3], b[3],
      normal[3];         /* unit: start, at right angles to it in the arc's plane, the arc's axis */
  double angle, foot[3]; /* 1/rho(s) = s . foot */
} edge;

/* The arc from v to w; false if the edge's line passes through the shading point. */
static bool make_edge(const double *v, const double *w, edge *e) {
  double n[3], d[3], lv = length(v), along[3];
  for (int k = 0; k < 3; k++) d[k] = w[k] - v[k];
  cross(v, d, n); /* = v x w, with less cancellation */
  double ln = length(n), ld = length(d);
  if (!(ln > 1e-15 * lv * ld) || !(ld > 0)) return false;
  for (int k = 0; k < 3; k++) {
    e->a[k] = v[k] / lv;
    e->normal[k] = n[k] / ln;
  }
  cross(e->normal, e->a, e->b);
  e->angle = atan2(ln / lv, dot(w, e->a));
  if (e->angle < 0) e->angle += 2 * PI;
  /* the foot of the perpendicular is at distance h = |v x d|/|d| in direction d^ x n^ */
  for (int k = 0; k < 3; k++) along[k] = d[k] / ld;
  cross(along, e->normal, e->foot);
  double h = ln / ld;
  for (int k = 0; k < 3; k++) e->foot[k] /= h;
  return true;
}

/* Adds an edge's share: value by the flux of grad Y through it, gradient by its motion. */
static ylm_status add_edge(const rules *r, int lmax, const edge *e, double sign, bool moves,
                           double *value, double *gradient) {
  size_t count = ylm_sh_count(lmax);
  int needed = (int)((lmax + 1) * e->angle * 0.35) + 11, rule = 0;
  while (rule < RULES - 1 && rule_length[rule] < needed) rule++;
  int n = rule_length[rule];
  double w[MOST_NODES], s[MOST_NODES][3];
  for (int i = 0; i < n; i++) {
    double t = 0.5 * e->angle * (r->x[rule][i] + 1), c = cos(t), z = sin(t);
    for (int k = 0; k < 3; k++) s[i][k] = c * e->a[k] + z * e->b[k];
    w[i] = 0.5 * e->angle * r->w[rule][i];
  }
  double *y = ylm_alloc((size_t)n * count * 4, sizeof *y), *dy = y ? y + (size_t)n * count : NULL;
  if (!y) return YLM_ENOMEM;
  ylm_status status = ylm_sh_eval(lmax, 1, false, YLM_DOUBLE, (size_t)n, s, y, dy, NULL, 1, NULL);
  for (int i = 0; i < n && status == YLM_OK; i++) {
    for (int l = 1; l <= lmax; l++)
      for (int m = -l; m <= l; m++) {
        size_t k = ylm_sh_index(l, m);
        value[k] += sign * w[i] * dot(e->normal, dy + 3 * ((size_t)i * count + k)) / (l * (l + 1));
      }
    if (!gradient || !moves) continue;
    /* -nu_out Y/rho: nu_out is -sign normal */
    double q = sign * w[i] * dot(s[i], e->foot);
    for (size_t k = 0; k < count; k++)
      for (int a = 0; a < 3; a++)
        gradient[3 * k + (size_t)a] += q * y[(size_t)i * count + k] * e->normal[a];
  }
  ylm_free(y);
  return status;
}

static ylm_status project(const rules *r, int lmax, int n, const double *vertex,
                          const double *horizon, double *value, double *gradient) {
  if (lmax < 0 || lmax > EXACT_LMAX || n < 3 || n > YLM_POLYGON_VERTICES) return YLM_ERANGE;
  size_t count = ylm_sh_count(lmax);
  double v[MAX_VERTICES][3], u[MAX_VERTICES][3];
  bool real[MAX_VERTICES];
  memset(value, 0, count * sizeof *value);
  if (gradient) memset(gradient, 0, 3 * count * sizeof *gradient);
  if (horizon) {
    double whole[YLM_POLYGON_VERTICES][3];
    memcpy(whole, vertex, (size_t)n * sizeof whole[0]);
    n = clip(n, whole, horizon, v, real);
    if (n < 3) return YLM_OK;
  } else {
    memcpy(v, vertex, (size_t)n * sizeof v[0]);
    for (int i = 0; i < n; i++) real[i] = true;
  }
  bool touches = false;
  for (int i = 0; i < n; i++) {
    double d = length(v[i]);
    touches |= !(d > 0);
    for (int k = 0; k < 3; k++) u[i][k] = v[i][k] / (d > 0 ? d : 1);
  }
  double omega = touches ? 0 : solid_angle(n, u), sign = omega < 0 ? -1 : 1;
  value[0] = fabs(omega) * sqrt(1 / (4 * PI));
  for (int i = 0; i < n && !touches; i++) {
    edge e;
    const double *a = v[i], *b = v[(i + 1) % n];
    if (a[0] == b[0] && a[1] == b[1] && a[2] == b[2]) continue; /* clipping may double a vertex */
    if (!make_edge(a, b, &e)) {
      /* the shading point lies on the edge's line: beyond the edge it sees nothing of it */
      touches = dot(a, b) <= 0;
      continue;
    }
    ylm_status s = add_edge(r, lmax, &e, sign, real[i], value, gradient);
    if (s != YLM_OK) return s;
  }
  if (!touches) return YLM_OK;
  memset(value, 0, count * sizeof *value);
  if (gradient) memset(gradient, 0, 3 * count * sizeof *gradient);
  value[0] = sqrt(PI);
  return YLM_EDOMAIN;
}

ylm_status ylm_polygon_project(int lmax, int n, const double *vertex, const double *horizon,
                               double *value, double *gradient) {
  rules r;
  make_rules(&r);
  return project(&r, lmax, n, vertex, horizon, value, gradient);
}

/* -- many
 * ------------------------------------------------------------------------------------------- */

struct ylm_polygons {
  ylm_field field;
  size_t n;
  bool exact, clipped;
  double horizon[3];
  int *sides;
  size_t *first;                      /* [n], into vertices */
  double *vertices;                   /* [..][3] */
  double *radiance;                   /* [n][3] */
  double *normal, *centroid, *radius; /* [n][3], [n][3], [n] */
  rules rules;
  ylm_lights **sphere; /* [n], of the approximation: unit radiance */
};

void ylm_polygons_free(ylm_polygons *p) {
  if (!p) return;
  for (size_t i = 0; p->sphere && i < p->n; i++) ylm_lights_free(p->sphere[i]);
  ylm_free(p->sphere);
  ylm_free(p->sides);
  ylm_free(p->first);
  ylm_free(p->vertices);
  ylm_free(p->radiance);
  ylm_free(p->normal);
  ylm_free(p->centroid);
  ylm_free(p->radius);
  ylm_free(p);
}

size_t ylm_polygons_count(const ylm_polygons *p) { return p->n; }
const ylm_field *ylm_polygons_field(const ylm_polygons *p) { return &p->field; }

/* Normal, centroid and the radius of the disc of the same area; says what is wrong with a polygon.
 */
static ylm_status describe(size_t index, int n, const double *v, double *normal, double *centroid,
                           double *radius, ylm_error *e) {
  double sum[3] = {0, 0, 0}, size = 0, weight = 0, c[3], a[3], b[3];
  for (int i = 0; i < 3 * n; i++) {
    if (!isfinite(v[i]))
      return ylm_fail(e, YLM_EDOMAIN, "polygon %zu: a vertex is not finite", index + 1);
    if (fabs(v[i]) > YLM_LIGHT_EXTENT)
      return ylm_fail(e, YLM_ERANGE, "polygon %zu is beyond %g", index + 1, YLM_LIGHT_EXTENT);
    size = fmax(size, fabs(v[i] - v[i % 3]));
  }
  for (int i = 1; i + 1 < n; i++) {
    for (int k = 0; k < 3; k++) a[k] = v[3 * i + k] - v[k], b[k] = v[3 * i + 3 + k] - v[k];
    cross(a, b, c);
    for (int k = 0; k < 3; k++) sum[k] += c[k];
  }
  double twice = length(sum);
  if (!(twice > 1e-12 * size * size))
    return ylm_fail(e, YLM_EDOMAIN, "polygon %zu has no area", index + 1);
  for (int k = 0; k < 3; k++) normal[k] = sum[k] / twice, centroid[k] = 0;
  for (int i = 1; i + 1 < n; i++) {
    for (int k = 0; k < 3; k++) a[k] = v[3 * i + k] - v[k], b[k] = v[3 * i + 3 + k] - v[k];
    cross(a, b, c);
    double area = dot(c, normal);
    weight += area;
    for (int k = 0; k < 3; k++) centroid[k] += area * (v[k] + v[3 * i + k] + v[3 * i + 3 + k]) / 3;
  }
  for (int k = 0; k < 3; k++) centroid[k] /= weight;
  for (int i = 0; i < n; i++) {
    const double *p = v + 3 * i, *q = v + 3 * ((i + 1) % n), *r = v + 3 * ((i + 2) % n);
    for (int k = 0; k < 3; k++) a[k] = q[k] - p[k], b[k] = r[k] - q[k], c[k] = p[k] - centroid[k];
    if (fabs(dot(c, normal)) > 1e-5 * size)
      return ylm_fail(e, YLM_EDOMAIN, "polygon %zu is not planar", index + 1);
    cross(a, b, c);
    if (dot(c, normal) < -1e-9 * size * size)
      return ylm_fail(e, YLM_EDOMAIN, "polygon %zu is not convex", index + 1);
  }
  *radius = sqrt(twice / 2 / PI);
  return YLM_OK;
}

/* -- the approximation
 * ------------------------------------------------------------------------------- */

/* |cos gamma| at v = centre - x, its gradient with respect to x and its Hessian. */
static double cosine(const double *n, const double *v, double *gradient, double *hessian) {
  double d2 = dot(v, v), d = sqrt(d2), d3 = d * d2, nv = dot(n, v), c = nv / d,
         sign = c < 0 ? -1 : 1;
  for (int k = 0; k < 3; k++) gradient[k] = -sign * (n[k] / d - v[k] * nv / d3);
  for (int i = 0, q = 0; i < 3; i++)
    for (int j = i; j < 3; j++, q++)
      hessian[q] = sign * (-(n[i] * v[j] + v[i] * n[j]) / d3 - (i == j ? nv / d3 : 0) +
                           3 * nv * v[i] * v[j] / (d3 * d2));
  return fabs(c);
}

/* Value, gradient and Hessian of sphere times |cos gamma| at x; 1 if x is in the sphere. */
static ylm_status approximate(const ylm_polygons *p, size_t i, int lmax, const double *x,
                              double *value, double *gradient, double *hessian, uint8_t *inside) {
  size_t count = ylm_sh_count(lmax);
  ylm_field_query q = {.lmax = lmax,
                       .channels = 1,
                       .want = YLM_WANT_VALUE | YLM_WANT_GRADIENT | YLM_WANT_HESSIAN,
                       .metric_channels = 1,
                       .dtype = YLM_DOUBLE,
                       .threads = 1};
  ylm_field_result r = {.value = value, .gradient = gradient, .hessian = hessian, .inside = inside};
  const ylm_field *f = ylm_lights_field(p->sphere[i]);
  ylm_status s = f->evaluate(f, &q, 1, x, &r, NULL);
  if (s != YLM_OK) return s;
  double v[3], g[3], h[6];
  for (int k = 0; k < 3; k++) v[k] = p->centroid[3 * i + (size_t)k] - x[k];
  if (*inside) return YLM_OK;
  double c = cosine(p->normal + 3 * i, v, g, h);
  static const int first[6] = {0, 0, 0, 1, 1, 2}, second[6] = {0, 1, 2, 1, 2, 2};
  for (size_t k = 0; k < count; k++) {
    double *dk = gradient + 3 * k, *hk = hessian + 6 * k;
    for (int a = 0; a < 6; a++)
      hk[a] =
          c * hk[a] + dk[first[a]] * g[second[a]] + dk[second[a]] * g[first[a]] + value[k] * h[a];
    for (int a = 0; a < 3; a++) dk[a] = c * dk[a] + value[k] * g[a];
    value[k] *= c;
  }
  return YLM_OK;
}

/* The exact polygon; its Hessian by central differences of its gradient. scratch: [6][count][3]. */
static ylm_status exactly(const ylm_polygons *p, size_t i, int lmax, const double *x, double *value,
                          double *gradient, double *hessian, double *scratch, uint8_t *inside) {
  size_t count = ylm_sh_count(lmax);
  int n = p->sides[i];
  const double *vertices = p->vertices + 3 * p->first[i], *up = p->clipped ? p->horizon : NULL;
  double v[YLM_POLYGON_VERTICES][3], near = INFINITY;
  for (int k = 0; k < n; k++)
    for (int a = 0; a < 3; a++) v[k][a] = vertices[3 * k + a] - x[a];
  ylm_status s = project(&p->rules, lmax, n, v[0], up, value, gradient);
  *inside = s == YLM_EDOMAIN;
  if (s == YLM_EDOMAIN) {
    memset(gradient, 0, 3 * count * sizeof *gradient);
    memset(hessian, 0, 6 * count * sizeof *hessian);
    return YLM_OK;
  }
  if (s != YLM_OK || !scratch) return s;
  for (int k = 0; k < n; k++) near = fmin(near, length(v[k]));
  double c[3];
  for (int a = 0; a < 3; a++) c[a] = p->centroid[3 * i + (size_t)a] - x[a];
  near = fmin(near, fabs(dot(c, p->normal + 3 * i)) + 0.1 * length(c));
  double step = 1e-5 * near;
  double *unused = scratch + 18 * count;
  for (int a = 0; a < 3; a++)
    for (int side = 0; side < 2; side++) {
      double shifted[YLM_POLYGON_VERTICES][3];
      memcpy(shifted, v, (size_t)n * sizeof v[0]);
      for (int k = 0; k < n; k++) shifted[k][a] -= side ? -step : step;
      s = project(&p->rules, lmax, n, shifted[0], up, unused,
                  scratch + (size_t)(2 * a + side) * 3 * count);
      if (s == YLM_EDOMAIN)
        memset(scratch + (size_t)(2 * a + side) * 3 * count, 0, 3 * count * sizeof *scratch);
      else if (s != YLM_OK)
        return s;
    }
  static const int first[6] = {0, 0, 0, 1, 1, 2}, second[6] = {0, 1, 2, 1, 2, 2};
  for (size_t k = 0; k < count; k++)
    for (int q = 0; q < 6; q++) {
      int a = first[q], b = second[q];
#define D(axis, of)                                                                                \
  (scratch[(size_t)(2 * (axis)) * 3 * count + 3 * k + (size_t)(of)] -                              \
   scratch[(size_t)(2 * (axis) + 1) * 3 * count + 3 * k + (size_t)(of)])
      hessian[6 * k + (size_t)q] = (D(a, b) + D(b, a)) / (4 * step);
#undef D
    }
  return YLM_OK;
}

/* -- the field
 * ------------------------------------------------------------------------------------------ */

typedef struct job {
  const ylm_polygons *p;
  const ylm_field_query *q;
  const void *points;
  ylm_field_result *r;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  const ylm_polygons *p = j->p;
  const ylm_field_query *q = j->q;
  size_t count = ylm_sh_count(q->lmax), wide = 10 * count;
  bool hessian = q->want & (YLM_WANT_HESSIAN | YLM_WANT_METRIC);
  /* one polygon: value, gradient, Hessian; three channels of sums; scratch of differences */
  double *one = ylm_alloc_zero(wide * 4 + 19 * count, sizeof *one), *sum = one + wide,
         *scratch = sum + 3 * wide;
  if (!one) return YLM_ENOMEM;
  ylm_status s = YLM_OK;
  for (size_t i = begin; i < end && s == YLM_OK; i++) {
    double x[3];
    for (size_t a = 0; a < 3; a++)
      x[a] = q->dtype == YLM_DOUBLE ? ((const double *)j->points)[3 * i + a]
                                    : (double)((const float *)j->points)[3 * i + a];
    memset(sum, 0, 3 * wide * sizeof *sum);
    uint8_t any = 0;
    for (size_t k = 0; k < p->n && s == YLM_OK; k++) {
      uint8_t inside = 0;
      s = p->exact ? exactly(p, k, q->lmax, x, one, one + count, one + 4 * count,
                             hessian ? scratch : NULL, &inside)
                   : approximate(p, k, q->lmax, x, one, one + count, one + 4 * count, &inside);
      any |= inside;
      for (int c = 0; c < 3; c++)
        for (size_t t = 0; t < wide; t++)
          sum[(size_t)c * wide + t] += p->radiance[3 * k + (size_t)c] * one[t];
    }
    if (s == YLM_OK) ylm__field_write(q, i, sum, wide, j->r);
    if (j->r->inside) j->r->inside[i] = any;
  }
  ylm_free(one);
  return s;
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm_polygons *p = f->self;
  ylm_status s = ylm__field_check(q, n, points, r, p->exact ? EXACT_LMAX : YLM_LIGHT_LMAX, e);
  if (s != YLM_OK) return s;
  job j = {p, q, points, r};
  s = ylm_parallel(n, 4, q->threads, run, &j, q->progress, "polygons");
  if (s != YLM_OK) return ylm_fail(e, s, "%s", ylm_status_text(s));
  r->pairs += (uint64_t)n * p->n;
  return YLM_OK;
}

/* A polygon's face, or the sphere of its approximation, against boxes: by its bounding sphere and
 * plane. */
static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_polygons *p = f->self;
  for (size_t i = 0; i < n; i++) {
    const double *box = boxes + 6 * i;
    out[i] = 0;
    for (size_t k = 0; k < p->n && !out[i]; k++) {
      const double *c = p->centroid + 3 * k, *m = p->normal + 3 * k;
      double reach = p->radius[k], lo = 0, hi = 0, near = 0;
      for (int v = 0; p->exact && v < p->sides[k]; v++) {
        double d[3];
        for (int a = 0; a < 3; a++)
          d[a] = p->vertices[3 * (p->first[k] + (size_t)v) + (size_t)a] - c[a];
        reach = fmax(reach, length(d));
      }
      for (int a = 0; a < 3; a++) {
        double d0 = box[a] - c[a], d1 = box[3 + a] - c[a];
        double away = d0 > 0 ? d0 : d1 < 0 ? -d1 : 0;
        near += away * away;
        lo += fmin(m[a] * d0, m[a] * d1);
        hi += fmax(m[a] * d0, m[a] * d1);
      }
      out[i] = near <= reach * reach && lo <= 0 && hi >= 0;
    }
  }
  return YLM_OK;
}

ylm_status ylm_polygons_create(size_t n, const int *sides, const double *vertices,
                               const double *radiance, bool exact, const double *horizon,
                               ylm_polygons **polygons, ylm_error *e) {
  *polygons = NULL;
  size_t total = 0;
  for (size_t i = 0; i < n; i++) {
    if (sides[i] < 3 || sides[i] > YLM_POLYGON_VERTICES)
      return ylm_fail(e, YLM_ERANGE, "polygon %zu: 3 to %d vertices expected, got %d", i + 1,
                      YLM_POLYGON_VERTICES, sides[i]);
    total += (size_t)sides[i];
  }
  ylm_polygons *p = ylm_alloc_zero(1, sizeof *p);
  if (!p) return YLM_ENOMEM;
  p->field = (ylm_field){.self = p, .evaluate = evaluate, .crosses = crosses};
  p->n = n;
  p->exact = exact;
  make_rules(&p->rules);
  p->sides = ylm_alloc(n, sizeof *p->sides);
  p->first = ylm_alloc(n, sizeof *p->first);
  p->vertices = ylm_alloc(total, 3 * sizeof(double));
  p->radiance = ylm_alloc(n, 3 * sizeof(double));
  p->normal = ylm_alloc(n, 3 * sizeof(double));
  p->centroid = ylm_alloc(n, 3 * sizeof(double));
  p->radius = ylm_alloc(n, sizeof(double));
  p->sphere = ylm_alloc_zero(n, sizeof *p->sphere);
  ylm_status s = p->sides && p->first && p->vertices && p->radiance && p->normal && p->centroid &&
                         p->radius && p->sphere
                     ? YLM_OK
                     : YLM_ENOMEM;
  if (s == YLM_OK && horizon && (horizon[0] != 0 || horizon[1] != 0 || horizon[2] != 0)) {
    p->clipped = true;
    memcpy(p->horizon, horizon, sizeof p->horizon);
    if (!isfinite(horizon[0] + horizon[1] + horizon[2]))
      s = ylm_fail(e, YLM_EDOMAIN, "the horizon's direction is not finite");
    else if (!exact)
      s = ylm_fail(e, YLM_EINVAL, "only exact polygons are cut at a horizon");
  }
  const double unit[3] = {1, 1, 1};
  size_t at = 0;
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    p->sides[i] = sides[i];
    p->first[i] = at;
    s = describe(i, sides[i], vertices + 3 * at, p->normal + 3 * i, p->centroid + 3 * i,
                 p->radius + i, e);
    for (int c = 0; c < 3 && s == YLM_OK; c++) {
      p->radiance[3 * i + (size_t)c] = radiance[3 * i + (size_t)c];
      if (!isfinite(radiance[3 * i + (size_t)c]))
        s = ylm_fail(e, YLM_EDOMAIN, "polygon %zu: its radiance is not finite", i + 1);
    }
    if (s == YLM_OK && !exact)
      s = ylm_lights_create(1, p->centroid + 3 * i, p->radius + i, unit, &p->sphere[i], e);
    memcpy(p->vertices + 3 * at, vertices + 3 * at, (size_t)sides[i] * 3 * sizeof(double));
    at += (size_t)sides[i];
  }
  if (s != YLM_OK) {
    ylm_polygons_free(p);
    return s;
  }
  *polygons = p;
  return YLM_OK;
}
