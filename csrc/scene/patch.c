/* patch.c - flat lamps: triangles and disks, how bright they may be and where on them rays end. */
#include <math.h>
#include <string.h>

#include "calibration.h"
#include "scene.h"

/* A triangle as it is seen from a point. */
typedef struct about {
  double v[3][3], r[3]; /* to its corners, and how far they are */
  double across[3];     /* the normal, as long as twice the area */
} about;

/* A triangle about x but for distances. */
static inline void put_about(const float *corners, const float x[3], about *t) {
  double a[3], b[3];
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) t->v[i][k] = (double)corners[3 * i + k] - (double)x[k];
  for (int k = 0; k < 3; k++) a[k] = t->v[1][k] - t->v[0][k], b[k] = t->v[2][k] - t->v[0][k];
  ylm_cross3d(a, b, t->across);
}

/* A triangle about x, and its solid angle. */
static double triangle_about(const float *corners, const float x[3], about *t) {
  const double(*v)[3] = (const double(*)[3])t->v;
  double *r = t->r, d[3];
  put_about(corners, x, t);
  for (int i = 0; i < 3; i++) r[i] = sqrt(ylm_dot3d(v[i], v[i]));
  for (int i = 0; i < 3; i++) d[i] = ylm_dot3d(v[i], v[(i + 1) % 3]);
  return fabs(2 * atan2(ylm_dot3d(t->across, v[0]),
                        r[0] * r[1] * r[2] + d[0] * r[2] + d[1] * r[0] + d[2] * r[1]));
}

/* Bound of the cosine at the surface over what of a patch is above its horizon; 0: nothing is. Says
   the solid angle. */
static double triangle_weight(const float *corners, const float x[3], const float n[3],
                              double *solid) {
  about t;
  double most = 0, omega = *solid = triangle_about(corners, x, &t);
  if (!n) return omega / YLM_PI;
  for (int i = 0; i < 3; i++) {
    double h = t.v[i][0] * (double)n[0] + t.v[i][1] * (double)n[1] + t.v[i][2] * (double)n[2];
    double cosine = t.r[i] > 0 ? h / t.r[i] : 1;
    most = cosine > most ? cosine : most;
  }
  /* between corners the cosine may be larger: never below a fifth where anything is visible */
  return most > 0 ? omega / YLM_PI * (most > 0.2 ? most : 0.2) : 0;
}

static double disk_weight(const float *disk, const float x[3], const float n[3]) {
  double v[3], m[3], up = 0, nm = 0, r = (double)disk[3];
  for (int k = 0; k < 3; k++) {
    v[k] = (double)disk[k] - (double)x[k];
    m[k] = (double)disk[4 + k];
    up += v[k] * (n ? (double)n[k] : 0);
    nm += m[k] * (n ? (double)n[k] : 0);
  }
  double highest = up + r * sqrt(fmax(0, 1 - nm * nm)), d2 = ylm_dot3d(v, v), d = sqrt(d2);
  if (n && !(highest > 0)) return 0;
  double facing = fabs(ylm_dot3d(v, m)) / fmax(d, 1e-30), near = fmax(d - r, 0.2 * r);
  double omega = 2 * YLM_PI * (1 - d / sqrt(d2 + r * r)) * fmax(facing, 0.1);
  return omega / YLM_PI * (n ? fmin(1, fmax(0.2, highest / near)) : 1);
}

double ylm__scene_patch_weight(const ylm_scene *s, size_t i, const float x[3], const float n[3],
                               double *solid) {
  *solid = 0;
  return i < s->triangles ? triangle_weight(s->triangle + 9 * i, x, n, solid)
                          : disk_weight(s->disk + 7 * (i - s->triangles), x, n);
}

/* Sums in double. */
static void weigh_all(const ylm_scene *s, const float x[3], const float n[3], float *weight,
                      float *sum, double *solid) {
  size_t count = s->triangles + s->disks;
  for (size_t b = 0; b * YLM_LAMP_CHUNK < count; b++) {
    size_t first = b * YLM_LAMP_CHUNK,
           end = count - first < YLM_LAMP_CHUNK ? count : first + YLM_LAMP_CHUNK;
    double total = 0;
    for (size_t i = first; i < end; i++) {
      double w = ylm__scene_patch_weight(s, i, x, n, &solid[i]);
      weight[i] = (float)(w * (double)s->patch_luminance[i]);
      total += (double)weight[i];
    }
    sum[b] = (float)total;
  }
}

/* A direction uniform in a spherical triangle (Arvo 1995) that fills `solid`: corners a, b, c of length 1. Its inner angle
   at a is known by cosine and sine; no other angle is needed. */
static void in_spherical_triangle(const double a[3], const double b[3], const double c[3],
                                  double solid, double u0, double u1, double out[3]) {
  double ab[3], ac[3];
  ylm_cross3d(a, b, ab), ylm_cross3d(a, c, ac);
  double both = sqrt(ylm_dot3d(ab, ab) * ylm_dot3d(ac, ac));
  double sine = both > 0 ? fmin(1, fabs(ylm_dot3d(ab, c)) / both) : 0;
  double cosine = both > 0 ? fmax(-1, fmin(1, ylm_dot3d(ab, ac) / both)) : 1;
  double x = sin(u0 * solid), y = cos(u0 * solid);
  double s = x * cosine - y * sine, t = y * cosine + x * sine; /* of that area less the angle */
  double u = t - cosine, v = s + sine * ylm_dot3d(a, b);
  double q = ((v * t - u * s) * cosine - v) / ((v * s + u * t) * sine);
  q = q > -1 ? fmin(q, 1) : -1; /* where rounding left the domain, or no number */
  double perp[3], ca = ylm_dot3d(c, a), l, edge[3];
  for (int k = 0; k < 3; k++) perp[k] = c[k] - ca * a[k];
  l = sqrt(ylm_dot3d(perp, perp));
  for (int k = 0; k < 3; k++)
    edge[k] = q * a[k] + sqrt(fmax(0, 1 - q * q)) * perp[k] / (l > 0 ? l : 1);
  double z = 1 - u1 * (1 - ylm_dot3d(edge, b)), eb = ylm_dot3d(edge, b), side[3];
  for (int k = 0; k < 3; k++) side[k] = edge[k] - eb * b[k];
  l = sqrt(ylm_dot3d(side, side));
  for (int k = 0; k < 3; k++)
    out[k] = z * b[k] + sqrt(fmax(0, 1 - z * z)) * side[k] / (l > 0 ? l : 1);
}

/* The place at fractions of a triangle's area. */
static void in_triangle(const double v[3][3], double u0, double u1, double out[3]) {
  double r = sqrt(u0);
  for (int k = 0; k < 3; k++)
    out[k] = (1 - r) * v[0][k] + r * (1 - u1) * v[1][k] + r * u1 * v[2][k];
}

/* The part of y along n; its length where there is no normal. */
static double part_along(const double y[3], const float n[3]) {
  return n ? y[0] * (double)n[0] + y[1] * (double)n[1] + y[2] * (double)n[2]
           : sqrt(ylm_dot3d(y, y));
}

/* Irradiance through a place y of a patch, for unit radiance: cosines over distance squared times
   the area. */
static double by_area(const double y[3], const double m[3], double area, const float n[3]) {
  double r2 = ylm_dot3d(y, y), up = part_along(y, n);
  return up > 0 && r2 > 0 ? up * fabs(ylm_dot3d(y, m)) * area / (r2 * r2) : 0;
}

static double sample_by_area(const float *corners, const float x[3], const float n[3], double u0,
                             double u1, double y[3]) {
  about t;
  put_about(corners, x, &t);
  in_triangle((const double(*)[3])t.v, u0, u1, y);
  return by_area(y, t.across, 0.5, n);
}

/* `solid`: the solid angle, if that is known; else 0. */
static double sample_triangle(const float *corners, const float x[3], const float n[3], double u0,
                              double u1, double solid, double y[3]) {
  about t;
  if (solid > 0)
    put_about(corners, x, &t);
  else
    solid = triangle_about(corners, x, &t);
  double twice = sqrt(ylm_dot3d(t.across, t.across)), m[3];
  for (int k = 0; k < 3; k++) m[k] = t.across[k] / (twice > 0 ? twice : 1);
  if (solid < PATCH_SMALL) {
    in_triangle((const double(*)[3])t.v, u0, u1, y);
    return by_area(y, m, twice / 2, n);
  }
  double w[3][3], s[3];
  for (int i = 0; i < 3; i++) {
    double r = sqrt(ylm_dot3d(t.v[i], t.v[i]));
    for (int k = 0; k < 3; k++) w[i][k] = t.v[i][k] / r;
  }
  in_spherical_triangle(w[0], w[1], w[2], solid, u0, u1, s);
  double along = ylm_dot3d(s, m), h = ylm_dot3d(t.v[0], m), far = h / along;
  if (!(far > 0) || !isfinite(far)) return 0;
  for (int k = 0; k < 3; k++) y[k] = far * s[k];
  return fmax(0, part_along(s, n)) * solid;
}

static double sample_disk(const float *disk, const float x[3], const float n[3], double u0,
                          double u1, double y[3]) {
  float a[3], b[3];
  double r = (double)disk[3], m[3], q = r * sqrt(u0);
  ylm_scene_basis(disk + 4, a, b);
  for (int k = 0; k < 3; k++) {
    m[k] = (double)disk[4 + k];
    y[k] = (double)disk[k] - (double)x[k] +
           q * (cos(2 * YLM_PI * u1) * (double)a[k] + sin(2 * YLM_PI * u1) * (double)b[k]);
  }
  return by_area(y, m, YLM_PI * r * r, n);
}

/* The ray from x to x + y on patch i that brings irradiance e for radiance 1: e, or 0 where the
   patch's horizon hides that place. */
static double aim(const ylm_scene *s, size_t i, const float x[3], const double y[3], double e,
                  ylm_trace_ray *ray, float radiance[3]) {
  double p[3], d = sqrt(ylm_dot3d(y, y)), above = 0;
  float at[3];
  for (int k = 0; s->horizon && k < 3; k++) above += (double)s->horizon[3 * i + (size_t)k] * y[k];
  if (!(e > 0) || !(d > 0) || above < 0) return 0;
  double by = 1 / d;
  for (int k = 0; k < 3; k++) {
    ray->org[k] = x[k];
    ray->dir[k] = (float)(y[k] * by);
    at[k] = (float)(p[k] = (double)x[k] + y[k]);
  }
  ylm__scene_patch_radiance(s, i, p, ray->dir, radiance);
  ray->near = 0;
  /* a light may lie on a wall: the ray ends just before it */
  ray->far = fmaxf(0, (float)(d * (1 - 1e-5)) - ylm_trace_offset(s->trace, at));
  return e;
}

static double sample_all(const ylm_scene *s, size_t i, const scene_aim *to, ylm_trace_ray *ray,
                         float radiance[3]) {
  const float *x = to->x, *n = to->normal;
  double y[3] = {0, 0, 0}, e;
  e = i < s->triangles
          ? sample_triangle(s->triangle + 9 * i, x, n, to->u[0], to->u[1], to->solid, y)
          : sample_disk(s->disk + 7 * (i - s->triangles), x, n, to->u[0], to->u[1], y);
  return aim(s, i, x, y, e, ray, radiance);
}

/* -- one lamp ---------------------------------------------------------------------- */

ylm_status ylm__scene_make_far(ylm_scene *s) {
  s->far = ylm_alloc(s->triangles, sizeof *s->far);
  if (!s->far) return YLM_ENOMEM;
  for (size_t i = 0; i < s->triangles; i++) {
    const float *t = s->triangle + 9 * i;
    scene_far *f = &s->far[i];
    double e[3][3], longest = 0;
    for (int k = 0; k < 3; k++) {
      f->centre[k] = ((double)t[k] + (double)t[3 + k] + (double)t[6 + k]) / 3;
      for (int c = 0; c < 3; c++) e[c][k] = (double)t[3 * ((c + 1) % 3) + k] - (double)t[3 * c + k];
    }
    for (int c = 0; c < 3; c++) longest = fmax(longest, ylm_dot3d(e[c], e[c]));
    ylm_cross3d(e[0], e[1], f->across);
    for (int k = 0; k < 3; k++) f->across[k] /= 2;
    f->area = sqrt(ylm_dot3d(f->across, f->across));
    f->reach2 = PATCH_FAR * PATCH_FAR * longest;
  }
  return YLM_OK;
}

/* From x to the centre of triangle i, and the square of that distance where it is far; else 0. */
static double far_away(const ylm_scene *s, size_t i, const float x[3], double v[3]) {
  const scene_far *f = &s->far[i];
  for (int k = 0; k < 3; k++) v[k] = f->centre[k] - (double)x[k];
  double d2 = ylm_dot3d(v, v);
  return d2 >= f->reach2 && f->area > 0 ? d2 : 0;
}

/* As triangle_weight; never 0 where a corner is above the horizon. */
static double far_weight(const scene_far *f, const double v[3], double d2, const float n[3]) {
  double by = 1 / sqrt(d2), facing = fabs(ylm_dot3d(v, f->across)) * by, least = 0.1 * f->area;
  double part = (facing > least ? facing : least) * by * by * (1 / YLM_PI);
  if (!n) return part;
  double up = (v[0] * (double)n[0] + v[1] * (double)n[1] + v[2] * (double)n[2]) * by;
  /* corners are within 2/3 of the longest edge of the centre */
  return up > -2.0 / 3 / PATCH_FAR ? part * (up > 0.2 ? up : 0.2) : 0;
}

static void weigh_one(const ylm_scene *s, const float x[3], const float n[3], float *weight,
                      float *sum, double *solid) {
  size_t count = s->triangles + s->disks;
  for (size_t i = 0; i < count; i++) {
    double v[3], w, d2 = i < s->triangles ? far_away(s, i, x, v) : 0;
    if (i % YLM_LAMP_CHUNK == 0) sum[i / YLM_LAMP_CHUNK] = 0;
    if (d2 > 0)
      w = far_weight(&s->far[i], v, d2, n), solid[i] = 0;
    else
      w = ylm__scene_patch_weight(s, i, x, n, &solid[i]);
    weight[i] = (float)(w * (double)s->patch_luminance[i]);
    sum[i / YLM_LAMP_CHUNK] += weight[i];
  }
}

static double sample(const ylm_scene *s, size_t i, const scene_aim *to, ylm_trace_ray *ray,
                     float radiance[3]) {
  double y[3], v[3];
  if (!to->one || i >= s->triangles || !(far_away(s, i, to->x, v) > 0))
    return sample_all(s, i, to, ray, radiance);
  double e = sample_by_area(s->triangle + 9 * i, to->x, to->normal, to->u[0], to->u[1], y);
  return aim(s, i, to->x, y, e, ray, radiance);
}

/* Distance squared over the cosine at the patch and its area: h is the plane's distance, `along` the
   cosine. */
static double density_by_area(double h, double along, double area) {
  double t = h / along;
  return t > 0 && isfinite(t) ? t * t / (fabs(along) * area) : 0;
}

static double triangle_density(const ylm_scene *s, size_t i, const float x[3], double solid,
                               const double d[3]) {
  const scene_far *f = &s->far[i];
  double to[3];
  about t;
  if (!(far_away(s, i, x, to) > 0)) {
    double omega = solid > 0 ? solid : triangle_about(s->triangle + 9 * i, x, &t);
    if (omega >= PATCH_SMALL) return 1 / omega;
  }
  if (!(f->area > 0)) return 0;
  return density_by_area(ylm_dot3d(to, f->across) / f->area, ylm_dot3d(d, f->across) / f->area,
                         f->area);
}

static double disk_density(const float *disk, const float x[3], const double d[3]) {
  double h = 0, along = 0, r = (double)disk[3];
  for (int k = 0; k < 3; k++) {
    h += ((double)disk[k] - (double)x[k]) * (double)disk[4 + k];
    along += d[k] * (double)disk[4 + k];
  }
  return density_by_area(h, along, YLM_PI * r * r);
}

static double density(const ylm_scene_chooser *c, size_t i, const float d[3]) {
  const ylm_scene *s = c->scene;
  double to[3], above = 0;
  for (int k = 0; k < 3; k++) to[k] = (double)d[k];
  for (int k = 0; s->horizon && k < 3; k++) above += (double)s->horizon[3 * i + (size_t)k] * to[k];
  if (above < 0) return 0;
  return i < s->triangles ? triangle_density(s, i, c->x, ylm__scene_solid(c, SCENE_PATCHES, i), to)
                          : disk_density(s->disk + 7 * (i - s->triangles), c->x, to);
}

/* -- the storage ------------------------------------------------------------------- */

static size_t count(const ylm_scene *s) { return s->triangles + s->disks; }

static void weigh(const ylm_scene_chooser *c, bool one, float *weight, float *sum) {
  const ylm_scene *s = c->scene;
  const float *n = c->in_space ? NULL : c->normal;
  (one ? weigh_one : weigh_all)(s, c->x, n, weight, sum, c->solid);
  if (s->directions > 0) ylm__scene_weigh_directed(s, s->lamps, count(s), c->x, weight, sum);
}

static void widen(const float *from, int n, double *to) {
  for (int a = 0; a < n; a++) to[a] = (double)from[a];
}

/* A disk's middle and two half axes. */
static void axes_of(const float *disk, double rows[9]) {
  double n[3];
  float unit[3], a[3], b[3];
  widen(disk + 4, 3, n);
  ylm_unit3(n);
  for (int k = 0; k < 3; k++) unit[k] = (float)n[k];
  ylm_scene_basis(unit, a, b);
  widen(disk, 3, rows);
  for (int k = 0; k < 3; k++) {
    rows[3 + k] = (double)disk[3] * (double)a[k];
    rows[6 + k] = (double)disk[3] * (double)b[k];
  }
}

static bool emitter(const ylm_scene *s, size_t i, ylm_light_emitter *out) {
  const float *radiance = s->lamp_radiance + 3 * (s->lamps + i);
  const float *horizon = s->horizon ? s->horizon + 3 * i : NULL;
  const ylm_light_emitter *directed = ylm__scene_directed(s, s->lamps + i);
  double rows[9];
  if (directed) {
    *out = *directed;
  } else if (i < s->triangles) {
    widen(s->triangle + 9 * i, 9, rows);
    ylm_light_emitter_triangle(radiance, horizon, rows, out);
  } else {
    axes_of(s->disk + 7 * (i - s->triangles), rows);
    ylm_light_emitter_disk(radiance, horizon, rows, out);
  }
  return true;
}

const scene_storage ylm__scene_patch_storage = {count, weigh, sample, density, emitter};
