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
#include "set.h"
#include "ylm_light_spot.h"
#include "ylm_vector.h"

#define BRIGHTEST 1e20 /* W sr^-1: light of it is a float at distances above 1e-3 */

enum { AT = 3, AXIS = 6, ANGLE = 9, BLEND, NUMBERS };

static size_t length(const double *x, size_t left) {
  (void)x;
  return left < NUMBERS ? 0 : NUMBERS;
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  (void)f, (void)q, (void)n, (void)points, (void)r;
  return ylm_fail(
      e, YLM_EINVAL,
      "a spot_light has no size, and no spherical harmonics: rays find its light "
      "(scene:render, raycast, pathtrace), scene:virtual_lights and radiosity bounce it");
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
  if (s == YLM_OK) ((ylm__distant *)made->of)->field.evaluate = evaluate;
  return s;
}

bool ylm_light_set_spot(const ylm_light_set *set, size_t i, ylm_light_spot *out) {
  for (size_t k = 0; k < set->packs; k++) {
    const ylm__light_pack *p = set->pack[k];
    if (p->kind != &ylm__spot_kind) continue;
    if (i >= p->n) {
      i -= p->n;
      continue;
    }
    const double *x = ((const ylm__distant *)p->of)->record[i], half = x[ANGLE] * YLM_PI / 360;
    memcpy(out->intensity, x, sizeof out->intensity);
    memcpy(out->at, x + AT, sizeof out->at);
    memcpy(out->axis, x + AXIS, sizeof out->axis);
    out->outer = cos(half);
    out->inner = cos(half * (1 - x[BLEND]));
    return true;
  }
  return false;
}

double ylm_light_spot_part(const ylm_light_spot *s, double cosine) {
  if (cosine >= s->inner) return 1;
  if (cosine <= s->outer) return 0;
  double t = (cosine - s->outer) / (s->inner - s->outer);
  return t * t * (3 - 2 * t);
}

double ylm_light_spot_solid(const ylm_light_spot *s) {
  return 2 * YLM_PI * (1 - (s->inner + s->outer) / 2);
}

const ylm__light_kind ylm__spot_kind = {
    .name = "spot", .length = length, .create = create, .free = ylm__distant_free};
