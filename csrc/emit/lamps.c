/* lamps.c - lamps and skies as sources of particles. */
#include "emit.h"
#include "ylm_light_spot.h"

/* Places of a lamp's record: csrc/light/kind.h. */
enum { HORIZON = 3, SPHERE_AT = 3, SPHERE_RADIUS = 6, SHAPE = 6, CORNERS = 7, SPHERE = 16 };

static void cross(const double *a, const double *b, double *out) {
  for (int k = 0; k < 3; k++)
    out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Two edges of a triangle, or two half axes of a disk; returns the area. */
static double edges(const double *x, double a[3], double b[3], double normal[3]) {
  bool triangle = x[SHAPE] > 0;
  const double *c = x + CORNERS;
  for (int k = 0; k < 3; k++) {
    a[k] = triangle ? c[3 + k] - c[k] : c[3 + k];
    b[k] = c[6 + k] - (triangle ? c[k] : 0);
  }
  cross(a, b, normal);
  double area = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  if (!ylm_unit3(normal)) return 0;
  return triangle ? area / 2 : YLM_PI * area;
}

/* The side that a lamp with this normal and horizon shines to: 1, -1, or 0: both, or neither wholly. */
static int side_of(const double *x, const double normal[3]) {
  double along = 0, length = 0;
  for (int k = 0; k < 3; k++) {
    along += x[HORIZON + k] * normal[k];
    length += x[HORIZON + k] * x[HORIZON + k];
  }
  if (!(length > 0) || fabs(along) < (1 - 1e-9) * sqrt(length)) return 0;
  return along > 0 ? -1 : 1;
}

static double power_of(const double *x) {
  double a[3], b[3], normal[3], light = YLM_PI * ylm_luminance_size(x);
  if (x[SPHERE] > 0) return light * 4 * YLM_PI * x[SPHERE_RADIUS] * x[SPHERE_RADIUS];
  double area = edges(x, a, b, normal);
  return light * area * (side_of(x, normal) ? 1 : 2);
}

/* The record of a lamp that is not distant, that of a sphere marked. */
static void read_record(const ylm_scene *scene, size_t i, double *x) {
  const char *kind;
  size_t n = ylm_scene_lamp_record(scene, i, &kind, x);
  x[SPHERE] = n == 7;
}

static void find_reach(emit_lamps *l) {
  double lo[3], hi[3], s = 0;
  ylm_scene_bounds(l->scene, lo, hi);
  for (int k = 0; k < 3; k++) {
    l->centre[k] = (lo[k] + hi[k]) / 2;
    s += (hi[k] - lo[k]) * (hi[k] - lo[k]) / 4;
  }
  l->reach = 1.0001 * sqrt(s);
}

/* Powers of particles from spheres, one radiance all over. */
static void find_powers(emit_lamps *l) {
  for (size_t i = 0; i < l->near; i++) {
    const double *x = l->record[i];
    double radius = x[SPHERE_RADIUS], area = 4 * YLM_PI * radius * radius;
    double chance = (l->upto[i] - (i > 0 ? l->upto[i - 1] : 0)) / l->upto[l->n - 1];
    for (int c = 0; x[SPHERE] > 0 && c < 3; c++)
      l->power[i][c] = x[c] * (YLM_PI * area) / chance / l->particles;
  }
}

ylm_status ylm__emit_lamps(const ylm_scene *scene, size_t particles, emit_lamps *l) {
  double sum = 0;
  *l = (emit_lamps){.scene = scene, .near = ylm_scene_near(scene), .particles = (double)particles};
  l->sky = l->near + ylm_scene_distant(scene);
  l->n = l->sky + ylm_scene_spots(scene, &l->spot);
  l->upto = ylm_alloc(l->n, sizeof *l->upto);
  l->record = ylm_alloc_zero(l->near, sizeof *l->record);
  l->power = ylm_alloc_zero(l->near, sizeof *l->power);
  if (!l->upto || !l->record || !l->power) return YLM_ENOMEM;
  find_reach(l);
  for (size_t i = 0; i < l->n; i++) {
    if (i < l->near) {
      read_record(scene, i, l->record[i]);
      sum += power_of(l->record[i]);
    } else if (i >= l->sky)
      sum += ylm_light_spot_solid(&l->spot[i - l->sky]) *
             ylm_luminance_size(l->spot[i - l->sky].intensity);
    else
      sum += YLM_PI * l->reach * l->reach * ylm_scene_distant_power(scene, i - l->near);
    l->upto[i] = sum;
  }
  find_powers(l);
  return YLM_OK;
}

void ylm__emit_lamps_free(emit_lamps *l) {
  ylm_free(l->upto);
  ylm_free(l->record);
  ylm_free(l->power);
}

/* The lamp that u of 0 .. 1 chooses, and how often it does. */
static size_t choose(const emit_lamps *l, double u, double *chance) {
  double all = l->upto[l->n - 1], target = u * all;
  size_t low = 0, high = l->n - 1;
  while (low < high) {
    size_t middle = low + (high - low) / 2;
    if (l->upto[middle] > target)
      high = middle;
    else
      low = middle + 1;
  }
  *chance = (l->upto[low] - (low > 0 ? l->upto[low - 1] : 0)) / all;
  return low;
}

static void widen(const float *x, double *out) {
  for (int k = 0; k < 3; k++) out[k] = (double)x[k];
}

/* A place on a flat lamp, the normal on the side that the particle takes; the area of the sides that
   it may take. *v, of 0 .. 1, chooses between two, and is as good as new afterwards. */
static double on_patch(const double *x, const double *u, double *v, float at[3], float normal[3]) {
  double a[3], b[3], n[3], area = edges(x, a, b, n), s, t;
  int side = side_of(x, n);
  if (x[SHAPE] > 0) { /* a triangle */
    s = 1 - sqrt(1 - u[0]);
    t = (1 - s) * u[1];
  } else {
    ylm__emit_turn(u[1], &s, &t);
    s *= sqrt(u[0]), t *= sqrt(u[0]);
  }
  bool both = side == 0;
  if (both) {
    side = *v < 0.5 ? 1 : -1;
    *v = *v < 0.5 ? 2 * *v : 2 * *v - 1;
  }
  for (int k = 0; k < 3; k++) {
    normal[k] = (float)(side * n[k]);
    at[k] = (float)(x[CORNERS + k] + s * a[k] + t * b[k]);
  }
  return both ? 2 * area : area;
}

/* A particle of a sphere. */
static void leave_sphere(const emit_lamps *l, size_t i, const double *u, ylm_trace_ray *ray,
                         double power[3]) {
  const double *x = l->record[i];
  double z = 1 - 2 * u[0], r = sqrt(fmax(0, 1 - z * z)), cosine, sine;
  ylm__emit_turn(u[1], &cosine, &sine);
  double n[3] = {r * cosine, r * sine, z};
  float normal[3];
  for (int k = 0; k < 3; k++) {
    normal[k] = (float)n[k];
    ray->org[k] = (float)(x[SPHERE_AT + k] + x[SPHERE_RADIUS] * n[k]);
  }
  ylm__emit_cosine(normal, u[2], u[3], ray->dir);
  for (int c = 0; c < 3; c++) power[c] = l->power[i][c];
  ray->near = 0;
  ray->far = INFINITY;
}

/* A particle of a flat lamp, whose power has not been divided by the chance yet. */
static bool leave_patch(const emit_lamps *l, size_t i, const double *u, ylm_trace_ray *ray,
                        double power[3]) {
  float normal[3], radiance[3];
  double v = u[2];
  double area = on_patch(l->record[i], u, &v, ray->org, normal);
  ylm__emit_cosine(normal, v, u[3], ray->dir);
  ylm_trace_ray back = *ray;
  for (int k = 0; k < 3; k++) back.dir[k] = -ray->dir[k];
  if (!ylm_scene_near_radiance(l->scene, &back, (uint32_t)i, 0, radiance)) return false;
  widen(radiance, power);
  for (int c = 0; c < 3; c++) power[c] *= YLM_PI * area;
  /* a lamp may lie on a wall, which then is not in its way */
  ray->near = ylm_trace_offset(ylm_scene_trace(l->scene), ray->org);
  return true;
}

static bool leave_sky(const emit_lamps *l, size_t i, const double *u, ylm_trace_ray *ray,
                      double power[3]) {
  float to[3], radiance[3], a[3], b[3];
  double solid = ylm_scene_distant_ray(l->scene, i - l->near, u, to, radiance);
  double r = l->reach * sqrt(u[2]), x, y;
  ylm__emit_turn(u[3], &x, &y);
  x *= r, y *= r;
  if (!(solid > 0)) return false;
  ylm_scene_basis(to, a, b);
  for (int k = 0; k < 3; k++) {
    ray->org[k] =
        (float)(l->centre[k] + x * (double)a[k] + y * (double)b[k] + l->reach * (double)to[k]);
    ray->dir[k] = -to[k];
  }
  widen(radiance, power);
  for (int c = 0; c < 3; c++) power[c] *= solid * YLM_PI * l->reach * l->reach;
  ray->near = 0;
  return true;
}

/* Directions are uniform in the cone. */
static bool leave_spot(const emit_lamps *l, size_t i, const double *u, ylm_trace_ray *ray,
                       double power[3]) {
  const ylm_light_spot *s = &l->spot[i - l->sky];
  float axis[3], a[3], b[3];
  double z = 1 - u[0] * (1 - s->outer), r = sqrt(fmax(0, 1 - z * z)), x, y;
  double part = ylm_light_spot_part(s, z) * 2 * YLM_PI * (1 - s->outer);
  for (int k = 0; k < 3; k++) axis[k] = (float)s->axis[k];
  ylm_scene_basis(axis, a, b);
  ylm__emit_turn(u[1], &x, &y);
  for (int k = 0; k < 3; k++) {
    ray->org[k] = (float)s->at[k];
    ray->dir[k] = (float)(r * x * (double)a[k] + r * y * (double)b[k] + z * s->axis[k]);
    power[k] = s->intensity[k] * part;
  }
  ray->near = ylm_trace_offset(ylm_scene_trace(l->scene), ray->org);
  return part > 0;
}

bool ylm__emit_texel(const emit_lamps *l, size_t i, ylm_trace_ray *ray, double power[3],
                     double *solid) {
  size_t side = (size_t)l->side, each = side * side;
  const ylm_light_spot *s = &l->spot[i / each];
  double wide = tan(fmin(acos(s->outer), EMIT_WIDEST)), step = 2 * wide / (double)side;
  double x = step * ((double)(i % side) + 0.5) - wide;
  double y = step * ((double)(i % each / side) + 0.5) - wide;
  double z = 1 / sqrt(1 + x * x + y * y), part = ylm_light_spot_part(s, z);
  float axis[3], a[3], b[3];
  for (int k = 0; k < 3; k++) axis[k] = (float)s->axis[k];
  ylm_scene_basis(axis, a, b);
  *solid = step * step * z * z * z;
  for (int k = 0; k < 3; k++) {
    ray->org[k] = (float)s->at[k];
    ray->dir[k] = (float)(z * (x * (double)a[k] + y * (double)b[k] + s->axis[k]));
    power[k] = s->intensity[k] * part * *solid;
  }
  ray->near = ylm_trace_offset(ylm_scene_trace(l->scene), ray->org);
  ray->far = INFINITY;
  return part > 0;
}

bool ylm__emit_start(const emit_lamps *l, const double u[EMIT_NUMBERS], ylm_trace_ray *ray,
                     double power[3]) {
  double chance;
  if (l->n == 0 || !(l->upto[l->n - 1] > 0)) return false;
  size_t i = choose(l, u[4], &chance);
  if (!(chance > 0)) return false;
  if (i < l->near && l->record[i][SPHERE] > 0) {
    leave_sphere(l, i, u, ray, power);
    return true;
  }
  if (!(i < l->near ? leave_patch : i < l->sky ? leave_sky : leave_spot)(l, i, u, ray, power))
    return false;
  for (int c = 0; c < 3; c++) power[c] = power[c] / chance / l->particles;
  ray->far = INFINITY;
  return true;
}
