/* kind.c - lamps with a photometric table and an opening, as a kind of light: a sphere, a disk, a rectangle. */
#include <string.h>

#include "../flat/flat.h"
#include "lamp.h"
#include "ylm_vector.h"

#define BRIGHTEST 1e20 /* a scale */
#define EDGE 1e-3      /* of cosines to the axis */

/* -- records --------------------------------------------------------------------------------------- */

size_t ylm__photometric_length(const double *x, size_t left) {
  (void)x;
  return left < YLM__LAMP_NUMBERS ? 0 : YLM__LAMP_NUMBERS;
}

/* The part of C0 that is perpendicular to the axis; any such direction where there is none. */
static void settle_across(double *x) {
  double *axis = x + YLM__LAMP_AXIS, *across = x + YLM__LAMP_ACROSS;
  for (int pass = 0; pass < 2; pass++) {
    double along = ylm_dot3d(axis, across);
    for (int k = 0; k < 3; k++) across[k] -= along * axis[k];
    if (ylm_dot3d(across, across) > 1e-12 && ylm_unit3(across)) return;
    int least = 0;
    for (int k = 1; k < 3; k++)
      if (fabs(axis[k]) < fabs(axis[least])) least = k;
    for (int k = 0; k < 3; k++) across[k] = k == least;
  }
}

ylm_status ylm__photometric_settle(double *x, size_t i, ylm_error *e) {
  if (!ylm_all_finite(YLM_DOUBLE, x, YLM__LAMP_NUMBERS, NULL))
    return ylm_fail(e, YLM_EDOMAIN, "lamp %zu is not finite", i + 1);
  for (int c = 0; c < 3; c++)
    if (fabs(x[c]) > BRIGHTEST)
      return ylm_fail(e, YLM_ERANGE, "lamp %zu is dimmed to beyond %g", i + 1, BRIGHTEST);
  for (int k = 0; k < 3; k++)
    if (fabs(x[YLM__LAMP_AT + k]) > YLM_LIGHT_EXTENT)
      return ylm_fail(e, YLM_ERANGE, "lamp %zu is beyond %g", i + 1, YLM_LIGHT_EXTENT);
  if (!ylm_unit3(x + YLM__LAMP_AXIS))
    return ylm_fail(e, YLM_EDOMAIN, "lamp %zu has no direction: at and to are the same", i + 1);
  if (!ylm_unit3(x + YLM__LAMP_ACROSS))
    return ylm_fail(e, YLM_EDOMAIN, "lamp %zu has no direction of C0", i + 1);
  if (!(x[YLM__LAMP_OPENING] >= 0 && x[YLM__LAMP_OPENING] < YLM__OPENINGS))
    return ylm_fail(e, YLM_EDOMAIN, "lamp %zu has no such opening", i + 1);
  settle_across(x);
  return YLM_OK;
}

static ylm_status settle(double *x, size_t i, ylm_error *e) {
  for (int k = 0; k < 2; k++) {
    double half = x[YLM__LAMP_HALF + k];
    if (!(half > 0 && half <= YLM_LIGHT_EXTENT))
      return ylm_fail(e, YLM_EDOMAIN,
                      "lamp %zu: its opening must be above 0 and at most %g wide, got %g", i + 1,
                      2 * YLM_LIGHT_EXTENT, 2 * half);
  }
  return ylm__photometric_settle(x, i, e);
}

void ylm__lamp_facing(double cosine, double out[3]) {
  double size = fabs(cosine), sign = cosine < 0 ? -1 : 1, t = size / EDGE;
  if (t >= 1) {
    out[0] = size, out[1] = sign, out[2] = 0;
    return;
  }
  out[0] = EDGE * (3 + t * t * (6 - t * t)) / 8;
  out[1] = sign * t * (3 - t * t) / 2;
  out[2] = (3 - 3 * t * t) / (2 * EDGE);
}

void ylm__lamp_local(const double *x, const double way[3], double local[3]) {
  double side[3];
  ylm__lamp_side(x, side);
  local[0] = ylm_dot3d(way, x + YLM__LAMP_ACROSS);
  local[1] = ylm_dot3d(way, side);
  local[2] = ylm_dot3d(way, x + YLM__LAMP_AXIS);
}

int ylm__lamp_corners(const double *x, double corner[4][3]) {
  static const double turn[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  static const int halves[2][3] = {{0, 1, 2}, {0, 2, 3}};
  const double *at = x + YLM__LAMP_AT, *a = x + YLM__LAMP_ACROSS, *half = x + YLM__LAMP_HALF;
  double b[3];
  ylm__photometric_opening o = ylm__lamp_opening(x);
  ylm__lamp_side(x, b);
  if (o == YLM__OPENING_DISK) {
    for (int k = 0; k < 3; k++)
      corner[0][k] = at[k], corner[1][k] = half[0] * a[k], corner[2][k] = half[1] * b[k];
    return 0;
  }
  int n = o == YLM__OPENING_RECTANGLE ? 4 : 3;
  for (int i = 0; i < n; i++) {
    const double *t = turn[n == 4 ? i : halves[o == YLM__OPENING_UPPER][i]];
    for (int k = 0; k < 3; k++)
      corner[i][k] = at[k] + t[0] * half[0] * a[k] + t[1] * half[1] * b[k];
  }
  return n;
}

/* -- packs ----------------------------------------------------------------------------------------- */

/* The opening of lamp i, at radiance 1, as lights of its own kind. */
static ylm_status make_opening(ylm__photometric_lamps *l, size_t i, ylm_error *e) {
  static const double one[3] = {1, 1, 1};
  const double *x = l->base.record[i];
  double corner[4][3];
  if (!ylm__lamp_is_flat(x)) {
    ylm_lights *ball;
    ylm_status s = ylm_lights_create(1, x + YLM__LAMP_AT, x + YLM__LAMP_HALF, one, &ball, e);
    if (s != YLM_OK) return s;
    l->of[i] = ball;
    l->opening[i] = &ball->field;
    return s;
  }
  ylm_polygons *flat;
  int sides = ylm__lamp_corners(x, corner);
  ylm_status s = ylm_polygons_create(1, &sides, corner[0], one, true, NULL, &flat, e);
  if (s != YLM_OK) return s;
  l->of[i] = flat;
  l->opening[i] = &flat->field;
  return s;
}

static void release(void *of) {
  ylm__photometric_lamps *l = of;
  for (size_t i = 0; l->of && i < l->base.n; i++) {
    if (!l->of[i]) continue;
    if (ylm__lamp_is_flat(l->base.record[i]))
      ylm_polygons_free(l->of[i]);
    else
      ylm_lights_free(l->of[i]);
  }
  ylm_light_photometry_free(l->table);
  ylm_free(l->of);
  ylm_free((void *)l->opening);
  ylm__distant_free(l);
}

/* The table of records, which all name the same. */
static ylm_status take_table(ylm__photometric_lamps *l, ylm_error *e) {
  l->table = ylm_light_photometry_named(l->base.record[0][YLM__LAMP_TABLE]);
  if (l->table) return YLM_OK;
  return ylm_fail(e, YLM_EINVAL, "the photometry of lamp 1 has been closed");
}

static ylm_status create(size_t n, const double *const *record, ylm__light_pack *made,
                         ylm_error *e) {
  ylm__photometric_lamps *l = ylm_alloc_zero(1, sizeof *l);
  if (!l) return YLM_ENOMEM;
  ylm_status s = ylm__distant_copy(&l->base, &ylm__photometric_kind, n, record, settle, e);
  l->base.field = (ylm_field){.self = l,
                              .evaluate = ylm__photometric_evaluate,
                              .crosses = ylm__photometric_crosses,
                              .pointwise = true,
                              .relative = true};
  if (s == YLM_OK) s = take_table(l, e);
  l->of = ylm_alloc_zero(n, sizeof *l->of);
  l->opening = ylm_alloc_zero(n, sizeof *l->opening);
  if (s == YLM_OK && !(l->of && l->opening)) s = YLM_ENOMEM;
  for (size_t i = 0; i < n && s == YLM_OK; i++) s = make_opening(l, i, e);
  if (s == YLM_OK)
    *made = (ylm__light_pack){&ylm__photometric_kind, l, &l->base.field, n, 0};
  else
    release(l);
  return s;
}

/* -- one of them ----------------------------------------------------------------------------------- */

/* Numbers of a shape are those of a record behind the scale. */
enum { SHAPE_AT = YLM__LAMP_AT - 3, SHAPE_HALF = YLM__LAMP_HALF - 3 };

static double reach_of(const double *x) {
  const double *half = x + YLM__LAMP_HALF;
  return ylm__lamp_opening(x) < YLM__OPENING_RECTANGLE ? half[0] : hypot(half[0], half[1]);
}

static size_t get(const void *of, size_t i, ylm_light *out, ylm_light_shape *shape) {
  const ylm__photometric_lamps *l = of;
  size_t numbers = ylm__distant_get(&l->base, i, out, shape);
  if (!shape) return numbers;
  memcpy(out->at, l->base.record[i] + YLM__LAMP_AT, sizeof out->at);
  out->radius = reach_of(l->base.record[i]);
  return numbers;
}

static bool slides(const ylm_light *a, const ylm_light *b) {
  const double *s = a->shape->x, *t = b->shape->x;
  size_t behind = SHAPE_AT + 3;
  return memcmp(s, t, SHAPE_AT * sizeof *s) == 0 &&
         memcmp(s + behind, t + behind, (a->shape->numbers - behind) * sizeof *s) == 0;
}

static double reach(const ylm_light *l) { return l->radius; }

/* No distance is far enough for bounds, which tables have not. */
static double near(const ylm_light *l) {
  (void)l;
  return INFINITY;
}

static double distance(const ylm_light *a, const ylm_light *b, const double p[3]) {
  return a == b ? ylm__distance(p, a->at) : ylm__segment_distance(p, a->at, b->at);
}

/* The shape's table stays as long as the shape. */
static void hold(const ylm_light_shape *shape, bool on) {
  ylm_light_photometry *p = ylm_light_photometry_named(shape->x[0]); /* which keeps it */
  if (on) return;
  ylm_light_photometry_free(p);
  ylm_light_photometry_free(p);
}

/* -- rays ------------------------------------------------------------------------------------------ */

const ylm_light_photometry *ylm__lamp_table(const double *x) {
  const ylm_light_photometry *p;
  memcpy(&p, x + YLM__LAMP_NUMBERS, sizeof p);
  return p;
}

void ylm__lamp_refer(double *x, const ylm_light_photometry *p) {
  memcpy(x + YLM__LAMP_NUMBERS, &p, sizeof p);
}

void ylm__photometric_hold(const double *x, bool on) {
  ylm_light_photometry *p = (ylm_light_photometry *)(uintptr_t)ylm__lamp_table(x);
  if (on)
    ylm_light_photometry_keep(p);
  else
    ylm_light_photometry_free(p);
}

void ylm__photometric_move(double *x, const double way[3]) {
  for (int a = 0; a < 3; a++) x[YLM__LAMP_AT + a] += way[a];
}

static ylm_light_emitter emitter_of(const ylm__photometric_lamps *l, size_t i,
                                    ylm__photometric_opening opening) {
  ylm_light_emitter e = {.kind = &ylm__photometric_kind, .numbers = YLM__LAMP_NUMBERS};
  memcpy(e.x, l->base.record[i], YLM__LAMP_NUMBERS * sizeof *e.x);
  e.x[YLM__LAMP_OPENING] = opening;
  ylm__lamp_refer(e.x, l->table);
  return e;
}

/* Radiance that such a lamp is weighed by: that of its peak, along the axis. */
static void weight_of(const double *x, const ylm_light_photometry *p, double rgb[3]) {
  for (int c = 0; c < 3; c++) rgb[c] = x[c] * ylm_light_photometry_peak(p) / ylm__lamp_area(x);
}

static ylm_status add_triangles(const ylm__photometric_lamps *l, size_t i, const double rgb[3],
                                ylm_light_surfaces *out) {
  static const double none[3] = {0, 0, 0};
  double corner[4][3];
  ylm_status s = YLM_OK;
  for (int half = 0; half < 2 && s == YLM_OK; half++) {
    ylm_light_emitter e = emitter_of(l, i, half ? YLM__OPENING_UPPER : YLM__OPENING_LOWER);
    ylm__lamp_corners(e.x, corner);
    s = ylm__surfaces_triangle(out, corner[0], corner[1], corner[2], rgb, none);
    if (s == YLM_OK) s = ylm__surfaces_direct(out, YLM_LIGHT_DIRECTED_TRIANGLE, &e);
  }
  return s;
}

static ylm_status surfaces(const void *of, size_t i, ylm_light_surfaces *out) {
  static const double none[3] = {0, 0, 0};
  const ylm__photometric_lamps *l = of;
  const double *x = l->base.record[i];
  ylm__photometric_opening o = ylm__lamp_opening(x);
  double rgb[3], corner[4][3];
  weight_of(x, l->table, rgb);
  if (o == YLM__OPENING_RECTANGLE) return add_triangles(l, i, rgb, out);
  ylm_light_emitter e = emitter_of(l, i, o);
  if (o == YLM__OPENING_SPHERE) {
    ylm_light ball = {.radius = x[YLM__LAMP_HALF]};
    memcpy(ball.at, x + YLM__LAMP_AT, sizeof ball.at);
    memcpy(ball.radiance, rgb, sizeof ball.radiance);
    ylm_status s = ylm__surfaces_sphere(out, &ball);
    return s == YLM_OK ? ylm__surfaces_direct(out, YLM_LIGHT_DIRECTED_SPHERE, &e) : s;
  }
  if (o == YLM__OPENING_DISK) {
    ylm_status s =
        ylm__surfaces_disk(out, x + YLM__LAMP_AT, x[YLM__LAMP_HALF], x + YLM__LAMP_AXIS, rgb, none);
    return s == YLM_OK ? ylm__surfaces_direct(out, YLM_LIGHT_DIRECTED_DISK, &e) : s;
  }
  ylm__lamp_corners(x, corner);
  ylm_status s = ylm__surfaces_triangle(out, corner[0], corner[1], corner[2], rgb, none);
  return s == YLM_OK ? ylm__surfaces_direct(out, YLM_LIGHT_DIRECTED_TRIANGLE, &e) : s;
}

static double power(const double *x) {
  return ylm__lamp_part(x) * ylm__lamp_table(x)->flux * ylm_luminance_size(x);
}

static bool place(const double *x, ylm_light_place *out) {
  const ylm_light_photometry *p = ylm__lamp_table(x);
  *out = (ylm_light_place){.reach = reach_of(x),
                           .bright = fabs(ylm_luminance(x)) * p->peak * ylm__lamp_part(x)};
  memcpy(out->at, x + YLM__LAMP_AT, sizeof out->at);
  if (ylm__lamp_is_flat(x)) memcpy(out->normal, x + YLM__LAMP_AXIS, sizeof out->normal);
  return true;
}

/* The radiance along a unit direction of the lamp's frame, for a scale of 1. */
static double radiance_in(const double *x, const double local[3]) {
  double facing[3] = {1, 0, 0};
  if (ylm__lamp_is_flat(x)) ylm__lamp_facing(local[2], facing);
  return ylm__photometric_intensity(ylm__lamp_table(x), local) / (ylm__lamp_area(x) * facing[0]);
}

static void radiance(const double *x, const double way[3], double rgb[3]) {
  double unit[3] = {way[0], way[1], way[2]}, local[3];
  ylm_unit3(unit);
  ylm__lamp_local(x, unit, local);
  double part = radiance_in(x, local);
  for (int c = 0; c < 3; c++) rgb[c] = x[c] * part;
}

/* The part of the weight of `weight_of` that counts towards a place. */
static double part(const double *x, const double from[3]) {
  double v[3], local[3], peak = ylm__lamp_table(x)->peak;
  for (int a = 0; a < 3; a++) v[a] = from[a] - x[YLM__LAMP_AT + a];
  if (!ylm_unit3(v) || !(peak > 0)) return 1;
  ylm__lamp_local(x, v, local);
  return radiance_in(x, local) * ylm__lamp_area(x) / peak;
}

/* A place of the opening from which a particle leaves along `way`, for u [2], and the area across which it does. */
static double leave_at(const double *x, const double way[3], const double u[2], double at[3]) {
  double corner[4][3], a[3], b[3], s, t, z;
  double r = x[YLM__LAMP_HALF];
  if (!ylm__lamp_is_flat(x)) {
    int least = fabs(way[0]) < fabs(way[1]) ? 0 : 1;
    const double other[3] = {least == 0, least == 1, 0};
    ylm_cross3d(way, other, a);
    ylm_unit3(a);
    ylm_cross3d(way, a, b);
    ylm_turn(u[1], &s, &t);
    s *= sqrt(u[0]), t *= sqrt(u[0]), z = sqrt(1 - u[0]);
    for (int k = 0; k < 3; k++)
      at[k] = x[YLM__LAMP_AT + k] + r * (s * a[k] + t * b[k] + z * way[k]);
    return ylm__lamp_area(x);
  }
  int n = ylm__lamp_corners(x, corner);
  if (n == 0) {
    ylm_turn(u[1], &s, &t);
    s *= sqrt(u[0]), t *= sqrt(u[0]);
  } else if (n == 3) {
    s = 1 - sqrt(1 - u[0]);
    t = (1 - s) * u[1];
  } else {
    s = u[0], t = u[1];
  }
  for (int k = 0; k < 3; k++) {
    a[k] = n == 0 ? corner[1][k] : corner[1][k] - corner[0][k];
    b[k] = n == 0 ? corner[2][k] : corner[n - 1][k] - corner[0][k];
    at[k] = corner[0][k] + s * a[k] + t * b[k];
  }
  return ylm__lamp_part(x) * ylm__lamp_area(x) * fabs(ylm_dot3d(way, x + YLM__LAMP_AXIS));
}

double ylm__lamp_leave(const double *x, const double u[4], double local[3],
                       ylm_light_leaving *out) {
  double side[3], density = ylm_light_photometry_sample(ylm__lamp_table(x), u, local);
  if (!(density > 0)) return 0;
  ylm__lamp_side(x, side);
  for (int k = 0; k < 3; k++)
    out->axis[k] = (double)(float)(local[0] * x[YLM__LAMP_ACROSS + k] + local[1] * side[k] +
                                   local[2] * x[YLM__LAMP_AXIS + k]);
  out->cosine = 1;
  return density;
}

static bool leave(const double *x, const double u[4], ylm_light_leaving *out) {
  double local[3], density = ylm__lamp_leave(x, u, local, out);
  if (!(density > 0)) return false;
  out->extent = leave_at(x, out->axis, u + 2, out->at) / density;
  double part = radiance_in(x, local);
  for (int c = 0; c < 3; c++) out->light[c] = x[c] * part;
  out->flat = ylm__lamp_is_flat(x);
  return part > 0;
}

static const ylm__light_emits emits = {.move = ylm__photometric_move,
                                       .power = power,
                                       .place = place,
                                       .radiance = radiance,
                                       .part = part,
                                       .hold = ylm__photometric_hold,
                                       .leave = leave};

const ylm__light_kind ylm__photometric_kind = {.name = "photometric",
                                               .common = 1,
                                               .emits = &emits,
                                               .length = ylm__photometric_length,
                                               .create = create,
                                               .free = release,
                                               .get = get,
                                               .hold = hold,
                                               .surfaces = surfaces,
                                               .record = ylm__distant_record,
                                               .slides = slides,
                                               .reach = reach,
                                               .distance = distance,
                                               .near = near};
