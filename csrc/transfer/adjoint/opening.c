/*
** opening.c - places of lamps and of their rims, as receivers see them.
**
** Flat openings send I/A from each place: light is the mean of I cos/d^2 over places, which move with the lamp. Spheres are
** seen as the cap that they fill: light is I of the direction of the centre times the cap's part of the hemisphere.
**
** Source  docs/math.md "Derivatives by the lamp"
*/
#include <math.h>

#include "adjoint.h"
#include "ylm_math.h"

/* Directions within this cosine of the plane of an opening are taken at it. */
#define GRAZING 1e-3

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

/* The intensity against a direction towards the lamp, and its gradient by the direction that light takes. */
static double intensity(const ylm_lamp *l, const double to[3], double gradient[3]) {
  double side[3], local[3] = {0, 0, 0}, g[3], cd;
  for (int a = 0; a < 3; a++) gradient[a] = 0;
  if (!l->table) return 1;
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

/* Derivatives by the half sizes, of a disk by its radius, from those by the place s, t. */
static void by_size(const ylm_lamp *l, double s, double t, const double place[3], double size[2]) {
  double side[3];
  ylm_cross3d(l->across, l->axis, side);
  double along = s * ylm_dot3d(place, l->across), beside = t * ylm_dot3d(place, side);
  bool round = l->opening == YLM_LIGHT_OPENING_disk;
  size[0] = round ? along + beside : along;
  size[1] = round ? 0 : beside;
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

static bool sphere_sample(const ylm_lamp *l, const float x[3], const float normal[3],
                          const double u[2], adjoint_sample *out) {
  double g[3], against[3], about[3], by[2], d[3], r = l->half[0];
  float to[3], a[3], b[3];
  way w;
  if (!find_way(x, normal, l->at, &w) || !(w.far > r)) return false;
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
  for (int k = 0; k < 3; k++) out->to[k] = (double)x[k] + reach * d[k];
  return true;
}

static bool sphere_rim(const ylm_lamp *l, const float x[3], const float normal[3], double u,
                       int count, adjoint_rim *out) {
  double g[3], d[3], e[3], cosine, sine, r = l->half[0], up = 0;
  float to[3], a[3], b[3];
  way w;
  if (!find_way(x, normal, l->at, &w) || !(w.far > r)) return false;
  double q = r / w.far, edge = sqrt(1 - q * q);
  for (int k = 0; k < 3; k++) to[k] = (float)w.to[k];
  ylm_scene_basis(to, a, b);
  ylm_turn(u, &cosine, &sine);
  for (int k = 0; k < 3; k++) {
    e[k] = cosine * (double)a[k] + sine * (double)b[k];
    d[k] = edge * w.to[k] + q * e[k];
    up += d[k] * (double)normal[k];
    out->to[k] = (double)x[k] + w.far * edge * d[k];
  }
  if (!(up > 0)) return false;
  double light = 2 * intensity(l, d, g) * up / (count * r * w.far * w.far);
  for (int k = 0; k < 3; k++) {
    out->place[k] = light * (e[k] - q / edge * w.to[k]);
    out->turn[k] = 0;
  }
  out->size[0] = light / edge, out->size[1] = 0;
  return light > 0;
}

/* -- all --------------------------------------------------------------------------------------------- */

bool ylm__lamp_sample(const ylm_lamp *l, const float x[3], const float normal[3], const double u[2],
                      adjoint_sample *out) {
  if (l->opening == YLM_LIGHT_OPENING_sphere) return sphere_sample(l, x, normal, u, out);
  if (l->opening == YLM_LIGHT_OPENING_rectangle)
    return flat_sample(l, x, normal, 2 * u[0] - 1, 2 * u[1] - 1, out);
  double c = 0, s = 0, r = l->opening == YLM_LIGHT_OPENING_disk ? sqrt(u[0]) : 0;
  ylm_turn(u[1], &c, &s);
  bool there = flat_sample(l, x, normal, r * c, r * s, out);
  if (l->opening == YLM_LIGHT_OPENING_point)
    for (int a = 0; a < 3; a++) out->still[a] = out->turn[a]; /* it has no plane */
  return there;
}

bool ylm__lamp_rim(const ylm_lamp *l, const float x[3], const float normal[3], double u, int count,
                   adjoint_rim *out) {
  if (l->opening == YLM_LIGHT_OPENING_sphere) return sphere_rim(l, x, normal, u, count, out);
  if (l->opening == YLM_LIGHT_OPENING_disk) return disk_rim(l, x, normal, u, count, out);
  if (l->opening == YLM_LIGHT_OPENING_rectangle) return rectangle_rim(l, x, normal, u, count, out);
  return false;
}
