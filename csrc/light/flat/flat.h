/*
** flat.h - flat lights: planar convex polygons, and ellipses, that emit the same radiance
** to both sides. Private to csrc/light.
**
** | parameter | unit         | allowed                                                     |
** | vertices  | scene units  | 3 .. YLM_POLYGON_VERTICES, planar, convex, of some area      |
** | radiance  | W sr^-1 m^-2 | finite, linear Rec. 709, may be negative                    |
** | horizon   | -            | a direction: what lies below the plane through the shading   |
** |           |              | point across it is cut off; or zero: nothing is             |
**
** exact      integrals along the rim (Wang & Ramamoorthi 2018): coefficients, gradients, Hessians.
**            Polygons: in closed form but for Gauss-Legendre nodes that leave 1e-16 of an edge's
**            share. Ellipses: Gauss-Legendre nodes too, 1e-13; there is no closed form off the axis
** otherwise  the approximation of Mezieres et al. 2022, Eqs. 24-28, generalised to polygons: the
**            sphere at the centroid whose disc has the polygon's area, times |cos gamma|; gradient
**            and Hessian of that function are exact
** Accuracy   of values, gradients and Hessians, each relative to its norm over all degrees: 1e-12,
**            but 1e-14 lmax / (a |cos gamma|) for slivers that are seen at an angle a across, gamma
**            off the normal, and are not far; a light whose size over distance is below
**            0.02/(lmax+4) is summed over its area
** Edge-on    points in the plane but not on the light: all zero (derivatives jump there; the mean
**            of both sides is 0). Points on it: half a sphere, derivatives 0, and `inside` is set,
**            as in or on the sphere of the approximation
*/
#ifndef YLM_LIGHT_POLYGON_H
#define YLM_LIGHT_POLYGON_H

#include "calibration.h"
#include "contour.h"
#include "ylm_light_device.h"

/* An edge that two polygons share. */
typedef struct ylm__flat_edge {
  uint32_t from, to;    /* rows of `vertices` of the polygon `left`, whose boundary runs this way */
  uint32_t left, right; /* polygons */
} ylm__flat_edge;

typedef struct ylm_polygons {
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
  size_t edges;           /* 0: polygons are summed one by one */
  ylm__flat_edge *edge;   /* [edges] of a closed surface of one radiance */
} ylm_polygons;

/*
** ylm_polygons_create - n flat lights; the arrays are copied.
**
**   sides     in   [n]                 vertices of each; 0: an ellipse
**   vertices  in   [rows][3]           of an ellipse three rows: its centre and two half axes
**   radiance  in   [n][3]
**   horizon   in   [3] or NULL
**
** Returns  YLM_OK; YLM_EDOMAIN (not finite, not planar to 1e-5 of its size, not convex, crossing
**          itself, without area), YLM_ERANGE (sides, beyond YLM_LIGHT_EXTENT): `e` names the
**          polygon; YLM_ENOMEM
*/
ylm_status ylm_polygons_create(size_t n, const int *sides, const double *vertices,
                               const double *radiance, bool exact, const double *horizon,
                               ylm_polygons **polygons, ylm_error *e);
void ylm_polygons_free(ylm_polygons *polygons);
/* The field's `evaluate` by the kernels of a given instruction set. YLM_ISA_reference sums node by
   node and judges the others, which take exact polygons without a horizon; what they cannot, on a
   light, edge-on or far, and ellipses, goes to the reference. A point's result depends on the point
   and the lights alone. YLM_EINVAL: isa is not available. */
ylm_status ylm_polygons_evaluate(const ylm_polygons *polygons, ylm_isa isa,
                                 const ylm_field_query *q, size_t n, const void *points,
                                 ylm_field_result *r, ylm_error *e);

/*
** ylm_polygons_join - finds the edges that polygons share, for surfaces that are closed.
**
** On the side that is not seen an edge's share has the other sign, so that the shares of an edge cancel where both
** of its polygons are seen from the same side. The kernels then sum the edges of the outline alone. Results change
** by rounding. Nothing is joined where an edge has no partner of the opposite direction, radiances differ, or
** polygons are approximated or cut at a horizon.
**
** Returns  YLM_OK; YLM_ENOMEM. edges.c
*/
ylm_status ylm_polygons_join(ylm_polygons *polygons);

/* Functions that the kinds of flat lights share, for csrc/light/image/textured.c: see kind.h. kind.c */
size_t ylm__flat_get(const void *of, size_t i, ylm_light *out, ylm_light_shape *shape);
ylm_status ylm__flat_evaluate(const void *of, ylm_isa isa, const ylm_field_query *q, size_t n,
                              const void *points, ylm_field_result *r, ylm_error *e);
void ylm__flat_device(const void *of, ylm_light_part *out);

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

#endif
