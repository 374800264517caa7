/*
** lamp.h - lamps with a photometric table, as records. Private to csrc/light.
**
** | number     | unit        | is                                                                 |
** | scale [3]  | -           | a colour of luminance 1 times what dims: multiplies the table's cd |
** | table      | -           | its name (ylm_light_photometry_name)                               |
** | opening    | -           | a choice of ylm__photometric_opening                               |
** | at [3]     | scene units | the middle of the opening                                          |
** | axis [3]   | -           | where gamma is 0; not 0                                            |
** | across [3] | -           | C0, made perpendicular to the axis                                 |
** | half [2]   | scene units | of the opening along C0 and along C90: a radius twice              |
**
** An opening of area A sends the intensity I/A from each of its places: its radiance in a direction w is I(w)/(A |cos|), of
** a sphere I(w)/(pi r^2), of direction alone. Far away the lamp is its file; near by the opening is seen.
**
** Numbers of an emitter are its record, and behind them the address of the table.
*/
#ifndef YLM_LIGHT_PHOTOMETRIC_LAMP_H
#define YLM_LIGHT_PHOTOMETRIC_LAMP_H

#include "../distant/distant.h"
#include "table.h"

enum {
  YLM__LAMP_TABLE = 3,
  YLM__LAMP_OPENING,
  YLM__LAMP_AT,
  YLM__LAMP_AXIS = 8,
  YLM__LAMP_ACROSS = 11,
  YLM__LAMP_HALF = 14,
  YLM__LAMP_NUMBERS = 16
};

/* Rays meet a rectangle as two triangles: halves of it, of the radiance of the whole. */
typedef enum ylm__photometric_opening {
  YLM__OPENING_SPHERE,
  YLM__OPENING_DISK,
  YLM__OPENING_RECTANGLE,
  YLM__OPENING_LOWER, /* the half with the corner -C0, -C90 */
  YLM__OPENING_UPPER,
  YLM__OPENINGS
} ylm__photometric_opening;

static inline ylm__photometric_opening ylm__lamp_opening(const double *x) {
  return (ylm__photometric_opening)x[YLM__LAMP_OPENING];
}
static inline bool ylm__lamp_is_flat(const double *x) {
  return ylm__lamp_opening(x) != YLM__OPENING_SPHERE;
}
/* C90: a lamp's frame is left-handed. */
static inline void ylm__lamp_side(const double *x, double side[3]) {
  const double *a = x + YLM__LAMP_ACROSS, *b = x + YLM__LAMP_AXIS;
  for (int k = 0; k < 3; k++)
    side[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}
/* The area that the radiance is spread over: of a half that of the whole; pi r^2 of a sphere. */
static inline double ylm__lamp_area(const double *x) {
  const double *half = x + YLM__LAMP_HALF;
  return (ylm__lamp_opening(x) < YLM__OPENING_RECTANGLE ? YLM_PI : 4) * half[0] * half[1];
}
/* Half of the lamp, or all of it. */
static inline double ylm__lamp_part(const double *x) {
  return ylm__lamp_opening(x) >= YLM__OPENING_LOWER ? 0.5 : 1;
}

/* Corners of a flat opening: a disk's middle and half axes, 3 of a half, 4 of a rectangle; returns the sides. */
int ylm__lamp_corners(const double *x, double corner[4][3]);

/* |cos| of a direction to the axis as it divides radiance: within 1e-3 of 0 it is bent to 3.75e-4, so that radiance has two
   continuous derivatives. out: it, and its derivatives by the cosine. */
void ylm__lamp_facing(double cosine, double out[3]);

/* A unit direction in the lamp's frame. */
void ylm__lamp_local(const double *x, const double way[3], double local[3]);

/* Lamps of one table: the pack of the kind. */
typedef struct ylm__photometric_lamps {
  ylm__distant base; /* comes first */
  ylm_light_photometry *table;
  const ylm_field **opening; /* [n] of radiance 1 */
  void **of;                 /* [n] sphere lights, or flat lights, that it belongs to */
} ylm__photometric_lamps;

/* The field's `evaluate` and `crosses`. field.c */
ylm_status ylm__photometric_evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                                     const void *points, ylm_field_result *r, ylm_error *e);
ylm_status ylm__photometric_crosses(const ylm_field *f, size_t n, const double *boxes,
                                    uint8_t *out);

/* A particle's way out of a lamp by its table: out->axis and cosine; local: that way in the lamp's frame. Its density, 0: none leaves.
   kind.c */
double ylm__lamp_leave(const double *x, const double u[4], double local[3], ylm_light_leaving *out);

/* Checks a record, and makes its frame one of unit vectors. kind.c */
ylm_status ylm__photometric_settle(double *x, size_t i, ylm_error *e);
size_t ylm__photometric_length(const double *x, size_t left);

/* The address behind an emitter's numbers. */
const ylm_light_photometry *ylm__lamp_table(const double *x);
void ylm__lamp_refer(double *x, const ylm_light_photometry *p);
/* `hold` and `move` of both kinds. */
void ylm__photometric_hold(const double *x, bool on);
void ylm__photometric_move(double *x, const double way[3]);

#endif
