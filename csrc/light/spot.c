/*
** spot.c - spots, as a kind of light: known to rays and particles, and to no light field.
**
** | parameter | unit        | allowed                                                          |
** | intensity | W sr^-1     | -1e20 .. 1e20                                                    |
** | at        | scene units | finite                                                           |
** | axis      |             | not 0                                                            |
** | angle     | degrees     | above 0, at most 360: of the whole cone                          |
** | blend     |             | 0 .. 1: the part of the angle over which light fades             |
*/
#include <math.h>
#include <string.h>

#include "distant/distant.h"
#include "point.h"
#include "set.h"
#include "ylm_vector.h"

#define BRIGHTEST 1e20 /* W sr^-1: light of it is a float at distances above 1e-3 */

enum { AT = 3, AXIS = 6, ANGLE = 9, BLEND, NUMBERS };

static size_t length(const double *x, size_t left) {
  (void)x;
  return left < NUMBERS ? 0 : NUMBERS;
}

static ylm_status settle(double *x, size_t i, ylm_error *e) {
  size_t where;
  if (!ylm_all_finite(YLM_DOUBLE, x, NUMBERS, &where))
    return ylm_fail(e, YLM_EDOMAIN, "spot %zu is not finite", i + 1);
  for (int k = 0; k < 3; k++)
    if (fabs(x[AT + k]) > YLM_LIGHT_EXTENT)
      return ylm_fail(e, YLM_ERANGE, "spot %zu is beyond %g", i + 1, YLM_LIGHT_EXTENT);
  for (int c = 0; c < 3; c++)
    if (fabs(x[c]) > BRIGHTEST)
      return ylm_fail(e, YLM_ERANGE, "spot %zu is of an intensity beyond %g W/sr", i + 1,
                      BRIGHTEST);
  if (!ylm_unit3(x + AXIS))
    return ylm_fail(e, YLM_EDOMAIN, "spot %zu has no direction: at and to are the same", i + 1);
  if (!(x[ANGLE] > 0 && x[ANGLE] <= 360))
    return ylm_fail(e, YLM_EDOMAIN, "spot %zu: its angle must be above 0 and at most 360, got %g",
                    i + 1, x[ANGLE]);
  if (!(x[BLEND] >= 0 && x[BLEND] <= 1))
    return ylm_fail(e, YLM_EDOMAIN, "spot %zu: blend must be from 0 to 1, got %g", i + 1, x[BLEND]);
  return YLM_OK;
}

static ylm_status create(size_t n, const double *const *record, ylm__light_pack *made,
                         ylm_error *e) {
  ylm_status s = ylm__distant_create(&ylm__spot_kind, n, record, settle, made, e);
  if (s == YLM_OK) ((ylm__distant *)made->of)->field.evaluate = ylm__fieldless;
  return s;
}

/* -- rays -------------------------------------------------------------------------------------

   Numbers of an emitter: intensity [3], place [3], axis [3], and the cosines to the axis below which it is dark, and
   above which it has all its intensity. */

enum { OUTER = 10, INNER = 9, SEEN };

static size_t numbers(const void *of, size_t i, double *out) {
  const double *x = ((const ylm__distant *)of)->record[i], half = x[ANGLE] * YLM_PI / 360;
  memcpy(out, x, ANGLE * sizeof *x);
  out[OUTER] = cos(half);
  out[INNER] = cos(half * (1 - x[BLEND]));
  return SEEN;
}

static void move(double *x, const double way[3]) {
  for (int a = 0; a < 3; a++) x[AT + a] += way[a];
}

/* The part of the intensity at a cosine to the axis: a smooth step. */
static double part_of(const double *x, double cosine) {
  if (cosine >= x[INNER]) return 1;
  if (cosine <= x[OUTER]) return 0;
  double t = (cosine - x[OUTER]) / (x[INNER] - x[OUTER]);
  return t * t * (3 - 2 * t);
}

static double power(const double *x) {
  return 2 * YLM_PI * (1 - (x[INNER] + x[OUTER]) / 2) * ylm_luminance_size(x);
}

static bool place(const double *x, ylm_light_place *out) {
  *out = (ylm_light_place){.outer = x[OUTER], .bright = fabs(ylm_luminance(x))};
  memcpy(out->at, x + AT, sizeof out->at);
  memcpy(out->axis, x + AXIS, sizeof out->axis);
  return true;
}

static double along(const double *x, const double way[3]) {
  return part_of(x, way[0] * x[AXIS] + way[1] * x[AXIS + 1] + way[2] * x[AXIS + 2]);
}

static void intensity(const double *x, const double way[3], double rgb[3]) {
  double part = along(x, way);
  for (int c = 0; c < 3; c++) rgb[c] = x[c] * part;
}

static double weight(const double *x, const double from[3], const float *n) {
  return ylm__point_weight(x, x + AT, along, from, n);
}

static bool toward(const double *x, const double from[3], ylm_light_way *out) {
  return ylm__point_toward(x, x + AT, along, from, out);
}

/* Directions are uniform in the cone. */
static bool leave(const double *x, const double u[4], ylm_light_leaving *out) {
  double z = 1 - u[0] * (1 - x[OUTER]);
  out->cosine = z;
  out->sine = sqrt(fmax(0, 1 - z * z));
  out->turn = u[1];
  out->extent = part_of(x, z) * 2 * M_PI * (1 - x[OUTER]);
  out->flat = true;
  memcpy(out->light, x, sizeof out->light);
  memcpy(out->at, x + AT, sizeof out->at);
  memcpy(out->axis, x + AXIS, sizeof out->axis);
  return out->extent > 0;
}

static const ylm__light_emits emits = {
    .numbers = numbers,
    .move = move,
    .power = power,
    .place = place,
    .toward = toward,
    .weight = weight,
    .intensity = intensity,
    .leave = leave,
    .fieldless =
        "a spot_light has no size, and no spherical harmonics: rays find its light "
        "(scene:render, raycast, pathtrace), scene:virtual_lights and radiosity bounce it"};

const ylm__light_kind ylm__spot_kind = {
    .name = "spot", .emits = &emits, .length = length, .create = create, .free = ylm__distant_free};
