/* point.c - lamps with a photometric table and no size: known to rays and particles, and to no light field. Records are those
   of lamp.h, whose opening and half sizes are not looked at. */
#include <string.h>

#include "../point.h"
#include "lamp.h"
#include "ylm_vector.h"

/* Lamps of one table. */
typedef struct points {
  ylm__distant base; /* comes first */
  ylm_light_photometry *table;
} points;

static void release(void *of) {
  points *p = of;
  ylm_light_photometry_free(p->table);
  ylm__distant_free(p);
}

static ylm_status create(size_t n, const double *const *record, ylm__light_pack *made,
                         ylm_error *e) {
  points *p = ylm_alloc_zero(1, sizeof *p);
  if (!p) return YLM_ENOMEM;
  ylm_status s = ylm__distant_copy(&p->base, &ylm__photometric_point_kind, n, record,
                                   ylm__photometric_settle, e);
  p->base.field.evaluate = ylm__fieldless;
  if (s == YLM_OK && !(p->table = ylm_light_photometry_named(record[0][YLM__LAMP_TABLE])))
    s = ylm_fail(e, YLM_EINVAL, "the photometry of lamp 1 has been closed");
  if (s == YLM_OK)
    *made = (ylm__light_pack){&ylm__photometric_point_kind, p, &p->base.field, n, 0};
  else
    release(p);
  return s;
}

/* -- rays ------------------------------------------------------------------------------------------ */

static size_t numbers(const void *of, size_t i, double *out) {
  const points *p = of;
  memcpy(out, p->base.record[i], YLM__LAMP_NUMBERS * sizeof *out);
  ylm__lamp_refer(out, p->table);
  return YLM__LAMP_NUMBERS;
}

static double power(const double *x) { return ylm__lamp_table(x)->flux * ylm_luminance_size(x); }

static bool place(const double *x, ylm_light_place *out) {
  const ylm_light_photometry *p = ylm__lamp_table(x);
  *out = (ylm_light_place){.outer = cos(p->angle[p->angles - 1]),
                           .bright = fabs(ylm_luminance(x)) * p->peak};
  memcpy(out->at, x + YLM__LAMP_AT, sizeof out->at);
  memcpy(out->axis, x + YLM__LAMP_AXIS, sizeof out->axis);
  return true;
}

static double intensity_along(const double *x, const double way[3]) {
  double local[3];
  ylm__lamp_local(x, way, local);
  return ylm__photometric_intensity(ylm__lamp_table(x), local);
}

static void intensity(const double *x, const double way[3], double rgb[3]) {
  double cd = intensity_along(x, way);
  for (int c = 0; c < 3; c++) rgb[c] = x[c] * cd;
}

static double weight(const double *x, const double from[3], const float *n) {
  return ylm__point_weight(x, x + YLM__LAMP_AT, intensity_along, from, n);
}

static bool toward(const double *x, const double from[3], ylm_light_way *out) {
  return ylm__point_toward(x, x + YLM__LAMP_AT, intensity_along, from, out);
}

static bool leave(const double *x, const double u[4], ylm_light_leaving *out) {
  double local[3], density = ylm__lamp_leave(x, u, local, out);
  if (!(density > 0)) return false;
  out->extent = ylm__photometric_intensity(ylm__lamp_table(x), local) / density;
  out->flat = true;
  memcpy(out->light, x, sizeof out->light);
  memcpy(out->at, x + YLM__LAMP_AT, sizeof out->at);
  return out->extent > 0;
}

static const ylm__light_emits emits = {
    .numbers = numbers,
    .move = ylm__photometric_move,
    .power = power,
    .place = place,
    .toward = toward,
    .weight = weight,
    .intensity = intensity,
    .hold = ylm__photometric_hold,
    .leave = leave,
    .fieldless =
        "a photometric_light with opening = 'point' has no size, and so no light field: rays find "
        "its light (scene:render, raycast, pathtrace); an opening { shape = 'sphere', radius = } "
        "gives it one"};

const ylm__light_kind ylm__photometric_point_kind = {.name = "photometric_point",
                                                     .common = 1,
                                                     .emits = &emits,
                                                     .length = ylm__photometric_length,
                                                     .create = create,
                                                     .free = release};
