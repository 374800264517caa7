/* emitter.c - triangles and disks as rays and particles meet them. Numbers of an emitter are its record: radiance [3],
   horizon [3], sides (3, or 0: a disk), corners [3][3], of a disk its middle and two half axes. */
#include "../kind.h"
#include "flat.h"

#include <math.h>
#include <string.h>

#include "ylm_vector.h"

enum { HORIZON = 3, SIDES = 6, CORNERS = 7, NUMBERS = 16 };

static void fill(const float radiance[3], const float *horizon, int sides, const double rows[9],
                 ylm_light_emitter *out) {
  *out = (ylm_light_emitter){.kind = &ylm__polygon_kind, .numbers = NUMBERS};
  for (int k = 0; k < 3; k++) {
    out->x[k] = (double)radiance[k];
    out->x[HORIZON + k] = horizon ? (double)horizon[k] : 0;
  }
  out->x[SIDES] = sides;
  memcpy(out->x + CORNERS, rows, 9 * sizeof *rows);
}

void ylm_light_emitter_triangle(const float radiance[3], const float *horizon,
                                const double corner[9], ylm_light_emitter *out) {
  fill(radiance, horizon, 3, corner, out);
}

void ylm_light_emitter_disk(const float radiance[3], const float *horizon,
                            const double middle_and_axes[9], ylm_light_emitter *out) {
  fill(radiance, horizon, 0, middle_and_axes, out);
}

static bool is_triangle(const double *x) { return x[SIDES] > 0; }

static void move(double *x, const double way[3]) {
  for (int k = 0; k < (is_triangle(x) ? 9 : 3); k++) x[CORNERS + k] += way[k % 3];
}

/* Two edges of a triangle, or two half axes of a disk, and the normal; returns the area. */
static double edges(const double *x, double a[3], double b[3], double normal[3]) {
  bool triangle = is_triangle(x);
  const double *c = x + CORNERS;
  for (int k = 0; k < 3; k++) {
    a[k] = triangle ? c[3 + k] - c[k] : c[3 + k];
    b[k] = c[6 + k] - (triangle ? c[k] : 0);
  }
  ylm_cross3d(a, b, normal);
  double area = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  if (!ylm_unit3(normal)) return 0;
  return triangle ? area / 2 : M_PI * area;
}

/* The side that a light with this normal and horizon shines to: 1, -1, or 0: both, or neither wholly. */
static int side_of(const double *x, const double normal[3]) {
  double along = 0, length = 0;
  for (int k = 0; k < 3; k++) {
    along += x[HORIZON + k] * normal[k];
    length += x[HORIZON + k] * x[HORIZON + k];
  }
  if (!(length > 0) || fabs(along) < (1 - 1e-9) * sqrt(length)) return 0;
  return along > 0 ? -1 : 1;
}

static double power(const double *x) {
  double a[3], b[3], normal[3], light = M_PI * ylm_luminance_size(x);
  double area = edges(x, a, b, normal);
  return light * area * (side_of(x, normal) ? 1 : 2);
}

static bool place(const double *x, ylm_light_place *out) {
  const double *p = x + CORNERS;
  double u[3], v[3], n[3], area = 0;
  bool triangle = is_triangle(x);
  *out = (ylm_light_place){.reach = 0};
  for (int a = 0; a < 3; a++) {
    out->at[a] = triangle ? (p[a] + p[3 + a] + p[6 + a]) / 3 : p[a];
    u[a] = triangle ? p[3 + a] - p[a] : p[3 + a];
    v[a] = triangle ? p[6 + a] - p[a] : p[6 + a];
  }
  ylm_cross3d(u, v, n);
  for (int a = 0; a < 3; a++) area += n[a] * n[a];
  area = sqrt(area) * (triangle ? 0.5 : M_PI);
  for (int k = 0; k < 3; k++) {
    double d2 = 0;
    for (int a = 0; a < 3; a++)
      d2 += triangle ? (p[3 * k + a] - out->at[a]) * (p[3 * k + a] - out->at[a])
                     : (k ? p[3 * k + a] * p[3 * k + a] : 0);
    out->reach = fmax(out->reach, sqrt(d2));
  }
  out->bright = fabs(ylm_luminance(x)) * area;
  if (ylm_unit3(n)) memcpy(out->normal, n, sizeof n);
  return true;
}

/* From a place uniform in the area, as the cosine to the normal, on a side that it shines to. u[2] chooses between two
   sides, and is as good as new afterwards. */
static bool leave(const double *x, const double u[4], ylm_light_leaving *out) {
  double a[3], b[3], n[3], area = edges(x, a, b, n), v = u[2], s, t;
  int side = side_of(x, n);
  if (is_triangle(x)) {
    s = 1 - sqrt(1 - u[0]);
    t = (1 - s) * u[1];
  } else {
    ylm_turn(u[1], &s, &t);
    s *= sqrt(u[0]), t *= sqrt(u[0]);
  }
  bool both = side == 0;
  if (both) {
    side = v < 0.5 ? 1 : -1;
    v = v < 0.5 ? 2 * v : 2 * v - 1;
  }
  for (int k = 0; k < 3; k++) {
    out->axis[k] = (double)(float)(side * n[k]);
    out->at[k] = x[CORNERS + k] + s * a[k] + t * b[k];
    out->light[k] = x[k];
  }
  out->cosine = sqrt(1 - v);
  out->sine = sqrt(v);
  out->turn = u[3];
  out->extent = M_PI * (both ? 2 * area : area);
  out->flat = true;
  return true;
}

const ylm__light_emits ylm__flat_emits = {
    .move = move, .power = power, .place = place, .leave = leave};
