/*
** opening.c - places of lamps and of their rims, as receivers see them.
**
** Flat openings send I/A from each place: light is the mean of I cos/d^2 over places, which move with the lamp. Spheres are
** seen as the cap that they fill: light is I of the direction of the centre times the cap's part of the hemisphere. Suns are
** spheres at the distance 1 from wherever they are seen.
**
** Source  docs/math.md "Derivatives by the lamp"
*/
#include <math.h>

#include "adjoint.h"
#include "ylm_math.h"

/* Directions within this cosine of the plane of an opening are taken at it. */
#define GRAZING 1e-3
/* Scene units: where rays to suns end. */
#define FAR_AWAY 1e18

/* The way from a receiver to a place, as light comes. */
typedef struct way {
  double to[3], far; /* of length 1, towards the lamp; the distance */
  double cosine;     /* to the receiver's normal */
} way;

static bool find_way(const float x[3], const float normal[3], const double y[3], way *w) {
  double far2 = 0;
  for (int a = 0; a < 3; a++) {
    w->to[a] = y[a] - (double)x[a];
    far2 += w->to[a] * w->to[a];
  }
  w->far = sqrt(far2), w->cosine = 0;
  if (!(w->far > 0)) return false;
  for (int a = 0; a < 3; a++) w->to[a] /= w->far, w->cosine += w->to[a] * (double)normal[a];
  return true;
}

/* Intensities that a cosine to the axis tells, and their slope by it. */
static double by_cosine(const ylm_lamp *l, double c, double *slope) {
  *slope = 0;
  if (l->cone[0] < l->cone[1]) {
    double wide = l->cone[1] - l->cone[0], t = (c - l->cone[0]) / wide;
    if (t <= 0 || t >= 1) return t >= 1;
    *slope = 6 * t * (1 - t) / wide;
    return t * t * (3 - 2 * t);
  }
  if (!(l->power > 0)) return 1;
  double size = fmax(fabs(c), 1e-9), cd = pow(size, l->power);
  *slope = copysign(l->power * cd / size, c);
  return cd;
}

/* The intensity against a direction towards the lamp, and its gradient by the direction that light takes. */
static double intensity(const ylm_lamp *l, const double to[3], double gradient[3]) {
  double side[3], local[3] = {0, 0, 0}, g[3], cd;
  for (int a = 0; a < 3; a++) gradient[a] = 0;
  if (!l->table) {
    double c = -ylm_dot3d(to, l->axis), slope;
    cd = by_cosine(l, c, &slope);
    for (int a = 0; a < 3; a++) gradient[a] = slope * (l->axis[a] + c * to[a]);
    return cd;
  }
  ylm_cross3d(l->across, l->axis, side);
  const double *axes[3] = {l->across, side, l->axis};
  for (int i = 0; i < 3; i++) local[i] = -ylm_dot3d(to, axes[i]);
  ylm_light_photometry_intensity(l->table, 1, (const double(*)[3])local, &cd, &g, NULL);
  for (int i = 0; i < 3; i++)
    for (int a = 0; a < 3; a++) gradient[a] += g[i] * axes[i][a];
  return cd;
}

/* -- flat openings, and points --------------------------------------------------------------------- */

/* The place of the opening that s, t of -1 .. 1 stand for, and the way there from the middle. */
static void flat_place(const ylm_lamp *l, double s, double t, double at[3], double arm[3]) {
  double side[3];
  ylm_cross3d(l->across, l->axis, side);
  for (int a = 0; a < 3; a++) {
    arm[a] = l->half[0] * s * l->across[a] + l->half[1] * t * side[a];
    at[a] = l->at[a] + arm[a];
  }
}

/* Derivatives by the half sizes, of a disk by its radius, of a polygon by a factor, from those by the place s, t. */
static void by_size(const ylm_lamp *l, double s, double t, const double place[3], double size[2]) {
  double side[3];
  ylm_cross3d(l->across, l->axis, side);
  double along = s * ylm_dot3d(place, l->across), beside = t * ylm_dot3d(place, side);
  bool alone = l->shape == YLM_LAMP_rectangle;
  size[0] = alone ? along : along + beside;
  size[1] = alone ? beside : 0;
}

static double clear_of(double cosine) {
  return fabs(cosine) < GRAZING ? copysign(GRAZING, cosine) : cosine;
}

static bool flat_sample(const ylm_lamp *l, const float x[3], const float normal[3], double s,
                        double t, adjoint_sample *out) {
  double arm[3], g[3], against[3], about[3], lean[3];
  way w;
  flat_place(l, s, t, out->to, arm);
  if (!find_way(x, normal, out->to, &w) || !(w.cosine > 0)) return false;
  double cd = intensity(l, w.to, g), over = 1 / (w.far * w.far), part = w.cosine * over;
  out->light = cd * part;
  for (int a = 0; a < 3; a++) {
    out->place[a] =
        (cd * ((double)normal[a] - 3 * w.cosine * w.to[a]) * over - part * g[a]) / w.far;
    against[a] = -w.to[a];
  }
  ylm_cross3d(arm, out->place, out->turn);
  ylm_cross3d(against, g, about);
  ylm_cross3d(l->axis, against, lean);
  double facing = clear_of(ylm_dot3d(l->axis, against));
  for (int a = 0; a < 3; a++) {
    out->turn[a] -= part * about[a];
    out->still[a] = -part * about[a] - out->light * lean[a] / facing;
  }
  by_size(l, s, t, out->place, out->size);
  return out->light > 0;
}

static bool flat_rim(const ylm_lamp *l, const float x[3], const float normal[3], double s, double t,
                     const double outward[3], double part, adjoint_rim *out) {
  double arm[3], g[3];
  way w;
  flat_place(l, s, t, out->to, arm);
  if (!find_way(x, normal, out->to, &w) || !(w.cosine > 0)) return false;
  double light = part * intensity(l, w.to, g) * w.cosine / (w.far * w.far);
  double tilt = ylm_dot3d(outward, w.to) / clear_of(ylm_dot3d(l->axis, w.to));
  for (int a = 0; a < 3; a++) out->place[a] = light * (outward[a] - tilt * l->axis[a]);
  ylm_cross3d(arm, out->place, out->turn);
  by_size(l, s, t, out->place, out->size);
  return light > 0;
}

static bool disk_rim(const ylm_lamp *l, const float x[3], const float normal[3], double u,
                     int count, adjoint_rim *out) {
  double c, s, side[3], outward[3];
  ylm_turn(u, &c, &s);
  ylm_cross3d(l->across, l->axis, side);
  for (int a = 0; a < 3; a++) outward[a] = c * l->across[a] + s * side[a];
  return flat_rim(l, x, normal, c, s, outward, 2 / (l->half[0] * count), out);
}

static bool rectangle_rim(const ylm_lamp *l, const float x[3], const float normal[3], double u,
                          int count, adjoint_rim *out) {
  double around = l->half[0] + l->half[1], side[3], outward[3];
  double along = fmod(2 * u, 1) * around; /* two edges are half of the rim */
  double sign = u < 0.5 ? 1 : -1;
  bool first = along < l->half[0];
  double s = first ? 2 * along / l->half[0] - 1 : sign;
  double t = first ? sign : 2 * (along - l->half[0]) / l->half[1] - 1;
  ylm_cross3d(l->across, l->axis, side);
  for (int a = 0; a < 3; a++) outward[a] = sign * (first ? side[a] : l->across[a]);
  return flat_rim(l, x, normal, s, t, outward, around / (l->half[0] * l->half[1] * count), out);
}

/* -- polygons ---------------------------------------------------------------------------------------- */

static double doubled_area(const double a[2], const double b[2], const double c[2]) {
  return fabs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
}

void ylm__lamp_measure(ylm_lamp *l) {
  ylm_lamp_corner *c = (ylm_lamp_corner *)(uintptr_t)l->corner;
  double area = 0, rim = 0;
  for (size_t i = 0; i < l->corners; i++) {
    const double *last = c[i > 0 ? i - 1 : 0].place;
    if (i > 1) area += doubled_area(c[0].place, last, c[i].place) / 2;
    rim += hypot(c[i].place[0] - last[0], c[i].place[1] - last[1]);
    c[i].area = area, c[i].rim = rim;
  }
}

/* The place u [2] of a polygon, evenly over its area: of a triangle of the fan about the first corner. */
static void polygon_place(const ylm_lamp *l, const double u[2], double *s, double *t) {
  const ylm_lamp_corner *c = l->corner;
  double wanted = u[0] * c[l->corners - 1].area;
  size_t i = 2;
  while (i + 1 < l->corners && c[i].area <= wanted) i++;
  double part = (wanted - c[i - 1].area) / (c[i].area - c[i - 1].area);
  double r = sqrt(fmax(0, fmin(1, part))), b = r * (1 - u[1]), d = r * u[1];
  *s = (1 - r) * c[0].place[0] + b * c[i - 1].place[0] + d * c[i].place[0];
  *t = (1 - r) * c[0].place[1] + b * c[i - 1].place[1] + d * c[i].place[1];
}

static bool polygon_rim(const ylm_lamp *l, const float x[3], const float normal[3], double u,
                        int count, adjoint_rim *out) {
  const ylm_lamp_corner *c = l->corner, *last = &c[l->corners - 1];
  double closing = hypot(last->place[0] - c[0].place[0], last->place[1] - c[0].place[1]);
  double around = last->rim + closing, wanted = u * around, side[3], outward[3];
  size_t i = 0;
  while (i + 1 < l->corners && c[i + 1].rim <= wanted) i++;
  const double *a = c[i].place, *b = c[(i + 1) % l->corners].place;
  double length = i + 1 < l->corners ? c[i + 1].rim - c[i].rim : closing;
  if (!(length > 0)) return false;
  double part = (wanted - c[i].rim) / length;
  double e[2] = {(b[0] - a[0]) / length, (b[1] - a[1]) / length};
  double s = a[0] + part * (b[0] - a[0]), t = a[1] + part * (b[1] - a[1]);
  double sign = s * e[1] - t * e[0] < 0 ? -1 : 1; /* the middle lies within */
  ylm_cross3d(l->across, l->axis, side);
  for (int k = 0; k < 3; k++) outward[k] = sign * (e[1] * l->across[k] - e[0] * side[k]);
  return flat_rim(l, x, normal, s, t, outward, around / (last->area * count), out);
}

/* -- spheres ----------------------------------------------------------------------------------------- */

/* The irradiance of a cap of radiance 1, whose centre has the cosine c to the normal and whose half angle has the sine squared q,
   and its derivatives by c and q. Source: Snyder 1996, "Area Light Sources for Real-Time Graphics". */
static double cap_light(double c, double q, double by[2]) {
  by[0] = by[1] = 0;
  if (c * c > q) {
    if (c > 0) by[0] = YLM_PI * q, by[1] = YLM_PI * c;
    return c > 0 ? YLM_PI * q * c : 0;
  }
  double x = sqrt(1 / q - 1), sine2 = 1 - c * c, sine = sqrt(sine2);
  double y = fmax(-1, fmin(1, -x * c / sine)), root = sqrt(fmax(0, 1 - c * c / q));
  double turn = acos(y), dx = -1 / (2 * q * q * x), safe = fmax(root, 1e-9);
  double droot = c * c / (2 * q * q * safe);
  by[0] = q * turn + x * c * q * root / sine2;
  by[1] = c * turn - x * root + q * (c * c * dx / safe - dx * root - x * droot) +
          (droot * x - root * dx) * q / sine2;
  return q * (c * turn - x * root) + atan(root / x);
}

/* The way to the middle of a sphere, or to a sun. */
static bool find_middle(const ylm_lamp *l, const float x[3], const float normal[3], way *w) {
  if (l->shape != YLM_LAMP_sun) return find_way(x, normal, l->at, w) && w->far > l->half[0];
  w->far = 1, w->cosine = 0;
  for (int a = 0; a < 3; a++) w->to[a] = l->axis[a], w->cosine += w->to[a] * (double)normal[a];
  return true;
}

/* A sun has no place: light that a move of it by the way d would change is that by a turn, at the distance 1. */
static void only_turns(const ylm_lamp *l, double place[3], double turn[3]) {
  ylm_cross3d(l->axis, place, turn);
  for (int a = 0; a < 3; a++) place[a] = 0;
}

static bool sphere_sample(const ylm_lamp *l, const float x[3], const float normal[3],
                          const double u[2], adjoint_sample *out) {
  double g[3], against[3], about[3], by[2], d[3], r = l->half[0];
  float to[3], a[3], b[3];
  way w;
  if (!find_middle(l, x, normal, &w)) return false;
  double q = r * r / (w.far * w.far), edge = sqrt(1 - q);
  double cd = intensity(l, w.to, g) / (YLM_PI * r * r), cap = cap_light(w.cosine, q, by);
  out->light = cd * cap;
  if (!(out->light > 0)) return false;
  for (int k = 0; k < 3; k++) {
    double dc = ((double)normal[k] - w.cosine * w.to[k]) / w.far, dq = -2 * q * w.to[k] / w.far;
    out->place[k] = cd * (by[0] * dc + by[1] * dq) - cap * g[k] / (w.far * YLM_PI * r * r);
    against[k] = -w.to[k], to[k] = (float)w.to[k];
  }
  ylm_cross3d(against, g, about);
  for (int k = 0; k < 3; k++) out->turn[k] = out->still[k] = -cap * about[k] / (YLM_PI * r * r);
  if (l->shape == YLM_LAMP_sun) only_turns(l, out->place, out->turn);
  out->size[0] = 2 * cd * (by[1] * q - cap) / r, out->size[1] = 0;
  ylm_scene_basis(to, a, b);
  double z = 1 - u[0] * q / (1 + edge), side = sqrt(1 - z * z), cosine, sine, up = 0;
  ylm_turn(u[1], &cosine, &sine);
  for (int flip = 0; flip < 2 && !(up > 0); flip++) { /* below the horizon: the place across */
    double sign = flip ? -1 : 1;
    up = 0;
    for (int k = 0; k < 3; k++) {
      d[k] = z * w.to[k] + sign * side * (cosine * (double)a[k] + sine * (double)b[k]);
      up += d[k] * (double)normal[k];
    }
  }
  double reach = w.far * z - sqrt(fmax(0, r * r - w.far * w.far * side * side));
  if (l->shape == YLM_LAMP_sun) reach = FAR_AWAY;
  for (int k = 0; k < 3; k++) out->to[k] = (double)x[k] + reach * d[k];
  return true;
}

static bool sphere_rim(const ylm_lamp *l, const float x[3], const float normal[3], double u,
                       int count, adjoint_rim *out) {
  double g[3], d[3], e[3], cosine, sine, r = l->half[0], up = 0;
  float to[3], a[3], b[3];
  way w;
  if (!find_middle(l, x, normal, &w)) return false;
  double q = r / w.far, edge = sqrt(1 - q * q);
  for (int k = 0; k < 3; k++) to[k] = (float)w.to[k];
  ylm_scene_basis(to, a, b);
  ylm_turn(u, &cosine, &sine);
  for (int k = 0; k < 3; k++) {
    e[k] = cosine * (double)a[k] + sine * (double)b[k];
    d[k] = edge * w.to[k] + q * e[k];
    up += d[k] * (double)normal[k];
    out->to[k] = (double)x[k] + (l->shape == YLM_LAMP_sun ? FAR_AWAY : w.far * edge) * d[k];
  }
  if (!(up > 0)) return false;
  double light = 2 * intensity(l, d, g) * up / (count * r * w.far * w.far);
  for (int k = 0; k < 3; k++) {
    out->place[k] = light * (e[k] - q / edge * w.to[k]);
    out->turn[k] = 0;
  }
  if (l->shape == YLM_LAMP_sun) only_turns(l, out->place, out->turn);
  out->size[0] = light / edge, out->size[1] = 0;
  return light > 0;
}

/* -- all --------------------------------------------------------------------------------------------- */

static bool point_sample(const ylm_lamp *l, const float x[3], const float normal[3],
                         adjoint_sample *out) {
  bool there = flat_sample(l, x, normal, 0, 0, out);
  for (int a = 0; a < 3; a++) out->still[a] = out->turn[a]; /* it has no plane */
  return there;
}

static bool disk_sample(const ylm_lamp *l, const float x[3], const float normal[3],
                        const double u[2], adjoint_sample *out) {
  double c, s, r = sqrt(u[0]);
  ylm_turn(u[1], &c, &s);
  return flat_sample(l, x, normal, r * c, r * s, out);
}

static bool polygon_sample(const ylm_lamp *l, const float x[3], const float normal[3],
                           const double u[2], adjoint_sample *out) {
  double s, t;
  polygon_place(l, u, &s, &t);
  return flat_sample(l, x, normal, s, t, out);
}

bool ylm__lamp_sample(const ylm_lamp *l, const float x[3], const float normal[3], const double u[2],
                      adjoint_sample *out) {
  switch (l->shape) {
  case YLM_LAMP_point: return point_sample(l, x, normal, out);
  case YLM_LAMP_disk: return disk_sample(l, x, normal, u, out);
  case YLM_LAMP_rectangle: return flat_sample(l, x, normal, 2 * u[0] - 1, 2 * u[1] - 1, out);
  case YLM_LAMP_polygon: return polygon_sample(l, x, normal, u, out);
  case YLM_LAMP_sphere:
  case YLM_LAMP_sun: return sphere_sample(l, x, normal, u, out);
  }
  return false;
}

bool ylm__lamp_rim(const ylm_lamp *l, const float x[3], const float normal[3], double u, int count,
                   adjoint_rim *out) {
  switch (l->shape) {
  case YLM_LAMP_point: return false;
  case YLM_LAMP_disk: return disk_rim(l, x, normal, u, count, out);
  case YLM_LAMP_rectangle: return rectangle_rim(l, x, normal, u, count, out);
  case YLM_LAMP_polygon: return polygon_rim(l, x, normal, u, count, out);
  case YLM_LAMP_sphere:
  case YLM_LAMP_sun: return sphere_rim(l, x, normal, u, count, out);
  }
  return false;
}
