/*
** lobe.c - disks whose radiance is a power of the cosine to their normal, as a kind of light: known to rays and particles,
** and to no light field.
**
** | parameter | unit           | allowed                                                              |
** | radiance  | W sr^-1 m^-2   | -1e20 .. 1e20, along the normal                                      |
** | horizon   |                | finite; 0: none                                                      |
** | middle    | scene units    | finite                                                               |
** | half axes | scene units    | at right angles, as long as each other, not 0                        |
** | spread    |                | above 0, at most 1000                                                |
**
** A record is that of a disk (kind.c) and the spread n behind it. With t the angle to the normal, on either side,
**
**   radiance(t) = radiance cos^n t,   power = 2 area 2 pi/(n+2) radiance
*/
#include <math.h>
#include <string.h>

#include "../distant/distant.h"
#include "flat.h"
#include "ylm_vector.h"

#define BRIGHTEST 1e20 /* W sr^-1 m^-2 */

enum { HORIZON = 3, MIDDLE = 7, AXES = 10, SPREAD = 16, NUMBERS };

static size_t length(const double *x, size_t left) {
  (void)x;
  return left < NUMBERS ? 0 : NUMBERS;
}

static double radius_of(const double *x) { return sqrt(ylm_dot3d(x + AXES, x + AXES)); }

/* Not of length 1. */
static void normal_of(const double *x, double normal[3]) {
  ylm_cross3d(x + AXES, x + AXES + 3, normal);
}

static ylm_status settle(double *x, size_t i, ylm_error *e) {
  double normal[3], radius = radius_of(x);
  if (!ylm_all_finite(YLM_DOUBLE, x, NUMBERS, NULL))
    return ylm_fail(e, YLM_EDOMAIN, "disk %zu is not finite", i + 1);
  for (int k = 0; k < 3; k++)
    if (fabs(x[MIDDLE + k]) > YLM_LIGHT_EXTENT)
      return ylm_fail(e, YLM_ERANGE, "disk %zu is beyond %g", i + 1, YLM_LIGHT_EXTENT);
  for (int c = 0; c < 3; c++)
    if (fabs(x[c]) > BRIGHTEST)
      return ylm_fail(e, YLM_ERANGE, "disk %zu is of a radiance beyond %g W/(sr m^2)", i + 1,
                      BRIGHTEST);
  normal_of(x, normal);
  if (!(radius > 0 && radius <= YLM_LIGHT_EXTENT) || !ylm_unit3(normal))
    return ylm_fail(e, YLM_EDOMAIN, "disk %zu has no area", i + 1);
  if (!(x[SPREAD] > 0 && x[SPREAD] <= 1000))
    return ylm_fail(e, YLM_EDOMAIN, "disk %zu: its spread must be above 0 and at most 1000, got %g",
                    i + 1, x[SPREAD]);
  return YLM_OK;
}

static ylm_status create(size_t n, const double *const *record, ylm__light_pack *made,
                         ylm_error *e) {
  ylm_status s = ylm__distant_create(&ylm__lobe_kind, n, record, settle, made, e);
  if (s == YLM_OK) ((ylm__distant *)made->of)->field.evaluate = ylm__fieldless;
  return s;
}

/* -- rays: numbers of an emitter are its record, and begin as those of a disk ------------------- */

static ylm_status surfaces(const void *of, size_t i, ylm_light_surfaces *out) {
  const double *x = ((const ylm__distant *)of)->record[i];
  double normal[3];
  normal_of(x, normal);
  ylm_unit3(normal);
  ylm_status s = ylm__surfaces_disk(out, x + MIDDLE, radius_of(x), normal, x, x + HORIZON);
  ylm_light_emitter e = {.kind = &ylm__lobe_kind, .numbers = NUMBERS};
  memcpy(e.x, x, NUMBERS * sizeof *x);
  return s == YLM_OK ? ylm__surfaces_direct(out, YLM_LIGHT_DIRECTED_DISK, &e) : s;
}

static void move(double *x, const double way[3]) { ylm__flat_emits.move(x, way); }

static double power(const double *x) { return ylm__flat_emits.power(x) * 2 / (x[SPREAD] + 2); }

static bool place(const double *x, ylm_light_place *out) { return ylm__flat_emits.place(x, out); }

static void radiance(const double *x, const double way[3], double rgb[3]) {
  double normal[3], size;
  normal_of(x, normal);
  size = sqrt(ylm_dot3d(normal, normal) * ylm_dot3d(way, way));
  double part = size > 0 ? pow(fmin(1, fabs(ylm_dot3d(normal, way)) / size), x[SPREAD]) : 0;
  for (int c = 0; c < 3; c++) rgb[c] = x[c] * part;
}

/* As a disk's, but in proportion to cos^(n+1). */
static bool leave(const double *x, const double u[4], ylm_light_leaving *out) {
  double n = x[SPREAD];
  if (!ylm__flat_emits.leave(x, u, out)) return false;
  out->cosine = pow(out->cosine, 2 / (n + 2));
  out->sine = sqrt(fmax(0, 1 - out->cosine * out->cosine));
  double part = pow(out->cosine, n);
  out->extent *= 2 / (n + 2) / part;
  for (int c = 0; c < 3; c++) out->light[c] *= part;
  return part > 0;
}

static const ylm__light_emits emits = {.move = move,
                                       .power = power,
                                       .place = place,
                                       .radiance = radiance,
                                       .leave = leave,
                                       .fieldless =
                                           "a disk_light with spread has no light field, since its "
                                           "spherical harmonics have no closed form: rays find "
                                           "its light (scene:render, raycast, pathtrace), "
                                           "scene:virtual_lights and radiosity bounce it"};

const ylm__light_kind ylm__lobe_kind = {.name = "lobe",
                                        .emits = &emits,
                                        .length = length,
                                        .create = create,
                                        .free = ylm__distant_free,
                                        .surfaces = surfaces};
