/*
** kind.c - flat lights as kinds of light: polygons and ellipses, exact and as spheres.
**
** A record: radiance [3], horizon [3] (0: none), the number of sides (0: an ellipse), vertices
** [sides][3], of an ellipse its centre and two half axes. A shape: horizon [3], sides, reach,
** normal [3], vertices.
*/
#include "../kind.h"
#include "calibration.h"
#include "flat.h"

#include <math.h>
#include <string.h>

enum { HORIZON, SIDES = 3, REACH, NORMAL, ROWS = 8 }; /* of a shape */
enum { COMMON = 3, HEAD = 7 };                        /* of a record */

static size_t rows_of(double sides) { return sides != 0 ? (size_t)sides : 3; }

static size_t length(const double *x, size_t left) {
  if (left < HEAD || !(x[HEAD - 1] >= 0) || x[HEAD - 1] > 1000) return 0;
  size_t n = HEAD + 3 * rows_of(x[HEAD - 1]);
  return n <= left ? n : 0;
}

/* -- packs ---------------------------------------------------------------------------------- */

static ylm_status create(const ylm__light_kind *kind, bool exact, size_t n,
                         const double *const *record, ylm__light_pack *p, ylm_error *e) {
  size_t rows = 0, at = 0;
  for (size_t i = 0; i < n; i++) rows += rows_of(record[i][HEAD - 1]);
  int *sides = ylm_alloc(n, sizeof *sides);
  double *vertices = ylm_alloc(rows, 3 * sizeof *vertices), *rgb = ylm_alloc(n, 3 * sizeof *rgb);
  ylm_polygons *made = NULL;
  ylm_status s = sides && vertices && rgb ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    size_t count = rows_of(record[i][HEAD - 1]);
    sides[i] = (int)record[i][HEAD - 1];
    memcpy(rgb + 3 * i, record[i], 3 * sizeof *rgb);
    memcpy(vertices + 3 * at, record[i] + HEAD, 3 * count * sizeof *vertices);
    at += count;
  }
  if (s == YLM_OK) s = ylm_polygons_create(n, sides, vertices, rgb, exact, record[0] + 3, &made, e);
  ylm_free(sides);
  ylm_free(vertices);
  ylm_free(rgb);
  if (s == YLM_OK) *p = (ylm__light_pack){kind, made, &made->field, n, 0};
  return s;
}

static ylm_status create_exact(size_t n, const double *const *record, ylm__light_pack *p,
                               ylm_error *e) {
  return create(&ylm__polygon_kind, true, n, record, p, e);
}

static ylm_status create_sphere(size_t n, const double *const *record, ylm__light_pack *p,
                                ylm_error *e) {
  return create(&ylm__polygon_as_sphere_kind, false, n, record, p, e);
}

static ylm_status join(void *of) { return ylm_polygons_join(of); }

static void release(void *of) { ylm_polygons_free(of); }

ylm_status ylm__flat_evaluate(const void *of, ylm_isa isa, const ylm_field_query *q, size_t n,
                              const void *points, ylm_field_result *r, ylm_error *e) {
  return ylm_polygons_evaluate(of, isa, q, n, points, r, e);
}

size_t ylm__flat_get(const void *of, size_t i, ylm_light *out, ylm_light_shape *shape) {
  const ylm_polygons *p = of;
  size_t rows = ylm__polygon_rows(p->sides[i]), numbers = ROWS + 3 * rows;
  if (!shape) return numbers;
  *shape = (ylm_light_shape){p->exact ? &ylm__polygon_kind : &ylm__polygon_as_sphere_kind, numbers,
                             false};
  memcpy(shape->x + HORIZON, p->horizon, sizeof p->horizon);
  shape->x[SIDES] = p->sides[i];
  shape->x[REACH] = p->reach[i];
  memcpy(shape->x + NORMAL, p->normal + 3 * i, 3 * sizeof *shape->x);
  memcpy(shape->x + ROWS, p->vertices + 3 * p->first[i], 3 * rows * sizeof *shape->x);
  *out = (ylm_light){.radius = p->radius[i], .shape = shape};
  memcpy(out->at, p->centroid + 3 * i, sizeof out->at);
  memcpy(out->radiance, p->radiance + 3 * i, sizeof out->radiance);
  return numbers;
}

/* Polygons as fans of triangles about their first vertex; of ellipses there are forms of disks
 * alone. */
static ylm_status surfaces(const void *of, size_t i, ylm_light_surfaces *out) {
  const ylm_polygons *p = of;
  const double *v = p->vertices + 3 * p->first[i], *rgb = p->radiance + 3 * i;
  const double *horizon = p->horizon;
  ylm_status s = YLM_OK;
  if (!p->sides[i])
    return ylm__surfaces_disk(out, v, sqrt(ylm_dot3d(v + 3, v + 3)), p->normal + 3 * i, rgb,
                              horizon);
  for (int k = 1; k + 1 < p->sides[i] && s == YLM_OK; k++)
    s = ylm__surfaces_triangle(out, v, v + 3 * k, v + 3 * k + 3, rgb, horizon);
  return s;
}

static void lamp(const void *of, size_t i, ylm_light_lamp *out) {
  const ylm_polygons *p = of;
  *out = (ylm_light_lamp){.radius = p->radius[i]};
  memcpy(out->at, p->centroid + 3 * i, sizeof out->at);
  memcpy(out->radiance, p->radiance + 3 * i, sizeof out->radiance);
  memcpy(out->normal, p->normal + 3 * i, sizeof out->normal);
}

void ylm__flat_device(const void *of, ylm_light_part *out) {
  const ylm_polygons *p = of;
  if (!p->exact) {
    out->lamps = p->n;
    out->cosine = true;
    out->lamp = lamp;
    out->of = of;
    return;
  }
  out->rims = (ylm_light_rims){.n = p->n,
                               .sides = p->sides,
                               .first = p->first,
                               .vertices = p->vertices,
                               .normal = p->normal,
                               .centroid = p->centroid,
                               .radiance = p->radiance,
                               .horizon = p->clipped ? p->horizon : NULL};
}

/* -- one of them ---------------------------------------------------------------------------- */

static size_t record(const ylm_light *l, const double radiance[3], double *to) {
  const double *x = l->shape->x;
  size_t rows = rows_of(x[SIDES]);
  if (!to) return HEAD + 3 * rows;
  memcpy(to, radiance, 3 * sizeof *to);
  memcpy(to + COMMON, x + HORIZON, 3 * sizeof *to);
  to[HEAD - 1] = x[SIDES];
  memcpy(to + HEAD, x + ROWS, 3 * rows * sizeof *to);
  return HEAD + 3 * rows;
}

static bool is_cut(const ylm_light *l) {
  const double *h = l->shape->x + HORIZON;
  return h[0] != 0 || h[1] != 0 || h[2] != 0;
}

/* A polygon's vertices move with its centroid, to a part in 1e9 of its size; axes stay. */
static bool slides(const ylm_light *a, const ylm_light *b) {
  const double *s = a->shape->x, *t = b->shape->x;
  double most = 0;
  if (a->shape->numbers == b->shape->numbers && memcmp(s, t, a->shape->numbers * sizeof *s) == 0)
    return true;
  if (s[SIDES] != t[SIDES] || is_cut(a) || is_cut(b)) return false;
  for (size_t i = 0; i < rows_of(s[SIDES]); i++)
    for (size_t k = 0; k < 3; k++) {
      double way = s[SIDES] != 0 || i == 0 ? b->at[k] - a->at[k] : 0;
      most = fmax(most, fabs(t[ROWS + 3 * i + k] - s[ROWS + 3 * i + k] - way));
    }
  return most <= 1e-9 * s[REACH];
}

static double reach(const ylm_light *l) { return fmax(l->radius, l->shape->x[REACH]); }

/* A light's centre moved along `normal` to the height of p, and how far that is. */
static double level(const ylm_light *l, const double p[3], const double normal[3], double out[3]) {
  double height = 0;
  for (int k = 0; k < 3; k++) height += normal[k] * (l->at[k] - p[k]);
  for (int k = 0; k < 3; k++) out[k] = l->at[k] - height * normal[k];
  return fabs(height);
}

/* From the disk that an exact light lies in. In its plane the disk's way is a segment, seen from
   the nearer of two planes. */
static double disk_distance(const ylm_light *a, const ylm_light *b, const double p[3]) {
  const double *normal = a->shape->x + NORMAL;
  double from[3], to[3], ha = level(a, p, normal, from), hb = level(b, p, normal, to);
  return hypot(fmin(ha, hb), fmax(0, ylm__segment_distance(p, from, to) - a->shape->x[REACH]));
}

static double disk_near(const ylm_light *l) { return YLM__NEAR_FLAT * l->shape->x[REACH]; }

static double centre_distance(const ylm_light *a, const ylm_light *b, const double p[3]) {
  return a == b ? ylm__distance(p, a->at) : ylm__segment_distance(p, a->at, b->at);
}

static double centre_near(const ylm_light *l) { return YLM__NEAR * l->radius; }

/* Across the plane of a light gradients jump: p must be on one side of both. */
static bool passes(const ylm_light *a, const ylm_light *b, const double p[3]) {
  const double *normal = a->shape->x + NORMAL;
  double sa = 0, sb = 0;
  for (int k = 0; k < 3; k++) {
    sa += normal[k] * (p[k] - a->at[k]);
    sb += normal[k] * (p[k] - b->at[k]);
  }
  return !((sa > 0 && sb > 0) || (sa < 0 && sb < 0));
}

/* The part that a horizon cuts off changes with the point. The gradient gets a term along the cut,
   which is at most as long as the light. The Hessian depends on the corners at its ends and has no
   bound. */
static void cut(const ylm_light *l, int lmax, double e, double d, double bound[3]) {
  if (!is_cut(l) || !(e > 0)) return;
  double whole = (lmax + 1) * 0.28209479177387814; /* the norm of Y */
  bound[1] += whole * e * 2 * l->shape->x[REACH] / (d * d);
  bound[2] = INFINITY;
}

/* A disk about the z axis. An exact light is the integral over its area of what a very small one
   emits, which scales with the distance. */
#define DISK(r)                                                                                    \
  (const double[]) { 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, r, 0, 0, 0, r, 0 }
static const double one[] = {1};
static const ylm__light_probes probes_exact = {1e-4, DISK(1e-4),       1, YLM__PROBE_COSINES,
                                               one,  ylm__probe_cosine};
static const ylm__light_probes probes_sphere = {
    1, DISK(1), YLM__PROBE_DISTANCES, YLM__PROBE_COSINES, ylm__probe_distance, ylm__probe_cosine};

const ylm__light_kind ylm__polygon_kind = {.name = "polygon",
                                           .common = COMMON,
                                           .length = length,
                                           .emits = &ylm__flat_emits,
                                           .create = create_exact,
                                           .free = release,
                                           .join = join,
                                           .evaluate = ylm__flat_evaluate,
                                           .get = ylm__flat_get,
                                           .surfaces = surfaces,
                                           .device = ylm__flat_device,
                                           .record = record,
                                           .slides = slides,
                                           .reach = reach,
                                           .distance = disk_distance,
                                           .near = disk_near,
                                           .passes = passes,
                                           .cut = cut,
                                           .probes = &probes_exact};

const ylm__light_kind ylm__polygon_as_sphere_kind = {.name = "polygon_as_sphere",
                                                     .common = COMMON,
                                                     .length = length,
                                                     .create = create_sphere,
                                                     .free = release,
                                                     .evaluate = ylm__flat_evaluate,
                                                     .get = ylm__flat_get,
                                                     .surfaces = surfaces,
                                                     .device = ylm__flat_device,
                                                     .record = record,
                                                     .slides = slides,
                                                     .reach = reach,
                                                     .distance = centre_distance,
                                                     .near = centre_near,
                                                     .passes = passes,
                                                     .cut = cut,
                                                     .probes = &probes_sphere};
