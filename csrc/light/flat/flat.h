/* flat.h - what the files about flat lights share. Private to csrc/light. */
#ifndef YLM_LIGHT_POLYGON_H
#define YLM_LIGHT_POLYGON_H

#include "contour.h"

struct ylm_polygons {
  ylm_field field;
  size_t n;
  bool exact, clipped;
  double horizon[3];
  int *sides;                /* [n]; 0: an ellipse */
  size_t *first;             /* [n], rows of `vertices` */
  double *vertices;          /* [..][3]; of an ellipse centre and two half axes */
  double *radiance;          /* [n][3] */
  double *normal, *centroid; /* [n][3], the normal of length 1 */
  double *radius, *reach; /* [n]: of a disk of the same area; farthest vertex from the centroid */
};

/* Rows of vertices that a light of so many sides has. */
static inline size_t ylm__polygon_rows(int sides) { return sides ? (size_t)sides : 3; }

/* shape.c: fills normal, centroid, radius and reach of one; `e` says what is wrong. */
ylm_status ylm__polygon_describe(size_t index, int sides, const double *vertices, double *normal,
                                 double *centroid, double *radius, double *reach, ylm_error *e);
/* shape.c: the field's `crosses`. */
ylm_status ylm__polygon_crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out);

/* The approximation, light by light: sums of all flat lights at n points x: sum [n][3][10 count]
   (value, gradient, Hessian as far as wanted), inside [n]. Sums come zeroed. */
ylm_status ylm__polygon_spheres(const ylm_polygons *p, const ylm_field_query *q, size_t n,
                                const double (*x)[3], double *sum, uint8_t *inside);

/* Points of a block of work. */
#define YLM__POLYGON_BLOCK 256

#endif
