/* lamp.h - lights of any kind, as a dynamic grid remembers and compares them. */
#ifndef YLM_GRID_LAMP_H
#define YLM_GRID_LAMP_H

#include <math.h>

#include "../grid.h"
#include "ylm_light.h"

#define NEAR 3.0      /* radii: nearer to a light that changed, all lights are summed */
#define NEAR_FLAT 0.5 /* the same of an exact flat light, in its reaches */

/* Data of a flat light beside a lamp's numbers. */
typedef struct lamp_shape {
  int sides; /* 0: an ellipse */
  bool exact, clipped, marked;
  double horizon[3], normal[3];
  double reach; /* of its farthest point from the centroid */
  size_t rows;
  double row[][3]; /* vertices; of an ellipse centre and two half axes */
} lamp_shape;

typedef struct lamp {
  double at[3], radius, radiance[3]; /* of a flat light: the centroid, the radius of its area */
  const lamp_shape *shape;           /* NULL: a sphere */
} lamp;

typedef enum lamp_kind { LAMP_SPHERE, LAMP_APPROXIMATED, LAMP_EXACT, LAMP_KINDS } lamp_kind;

static inline lamp_kind lamp_kind_of(const lamp *l) {
  return !l->shape ? LAMP_SPHERE : l->shape->exact ? LAMP_EXACT : LAMP_APPROXIMATED;
}

/* Lamps whose shapes are in one block of memory. */
typedef struct lamp_set {
  lamp *lamp;
  size_t n;
  void *shapes;
} lamp_set;

/* Shapes that live until they are swept away. */
typedef struct shape_list {
  lamp_shape **shape;
  size_t n, room, bytes;
} shape_list;

/* The lights as a set that the caller frees; YLM_ENOMEM. */
ylm_status ylm__lamps(const ylm_light_parts *lights, lamp_set *set);
void ylm__lamps_free(lamp_set *set);
/* Gives a lamp a shape of its own in the list, if it has any; YLM_ENOMEM. */
ylm_status ylm__lamp_keep(shape_list *list, lamp *l);
/* Frees the shapes of a list that are not marked, and takes the marks away. */
void ylm__shapes_sweep(shape_list *list);

/* An order of lamps by all that they are made of; 0: equal. */
int ylm__lamp_compare(const lamp *a, const lamp *b);
/* True if the two differ in colour and by a translation alone. */
bool ylm__lamp_slides(const lamp *a, const lamp *b);
/* True if one field may hold both: spheres, or flat lights of one method and horizon. */
bool ylm__lamps_alike(const lamp *a, const lamp *b);
/* A box around it: min, max. */
void ylm__lamp_box(const lamp *l, double box[6]);
/* The distance of p from the disk of an exact flat light, which lies in there, and from the way of
   that disk where it slides and p is not in between its planes. */
double ylm__lamp_flat_distance(const lamp *a, const lamp *b, const double p[3]);
static inline bool lamp_is_exact(const lamp *l) { return l->shape && l->shape->exact; }

/* From p to the segment between a and b. */
static inline double segment_distance(const double p[3], const double a[3], const double b[3]) {
  double along = 0, length2 = 0, s = 0;
  for (int k = 0; k < 3; k++) {
    along += (p[k] - a[k]) * (b[k] - a[k]);
    length2 += (b[k] - a[k]) * (b[k] - a[k]);
  }
  double t = length2 > 0 ? along / length2 : 0;
  t = t < 0 ? 0 : t > 1 ? 1 : t;
  for (int k = 0; k < 3; k++) {
    double d = p[k] - (a[k] + t * (b[k] - a[k]));
    s += d * d;
  }
  return sqrt(s);
}

/* The distance from a lamp's centre, or what an exact flat light is away at least. */
static inline double lamp_distance(const lamp *l, const double p[3]) {
  double s = 0;
  if (lamp_is_exact(l)) return ylm__lamp_flat_distance(l, l, p);
  for (int k = 0; k < 3; k++) s += (p[k] - l->at[k]) * (p[k] - l->at[k]);
  return sqrt(s);
}
/* The distance from the way between two lamps that slide. */
static inline double lamp_way_distance(const lamp *a, const lamp *b, const double p[3]) {
  return lamp_is_exact(a) ? ylm__lamp_flat_distance(a, b, p) : segment_distance(p, a->at, b->at);
}
/* At such a distance and nearer all lights are to be summed when this one changes. */
static inline double lamp_near(const lamp *l) {
  return lamp_is_exact(l) ? NEAR_FLAT * l->shape->reach : NEAR * l->radius;
}

/* The field of up to two lamps that are alike, grey, of given radiances. */
typedef struct lamp_field {
  const ylm_field *field;
  ylm_lights *spheres;
  ylm_polygons *flat;
} lamp_field;
ylm_status ylm__lamp_field(size_t n, const lamp *const *lamps, const double *strength,
                           lamp_field *f);
void ylm__lamp_field_free(lamp_field *f);

/*
** Bounds of lamps of a kind, of radiance 1: the norms of the k-th derivatives of the coefficients,
** k = 0 .. 3, are below bound[k] radius^2 / d^(k+2) wherever lamp_distance, d, is above
** lamp_near. Not of what a horizon cuts.
*/
ylm_status ylm__lamp_bounds(int lmax, lamp_kind kind, double bound[4], ylm_error *e);

#endif
