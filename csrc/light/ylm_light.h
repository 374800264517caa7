/*
** ylm_light.h - lights whose spherical-harmonic coefficients are known in closed form.
**
** Sphere lights: spheres that emit the same radiance everywhere and in every direction.
**
** | parameter | unit            | allowed                                          |
** | at        | scene units     | finite, |coordinate| <= YLM_LIGHT_EXTENT         |
** | radius    | scene units     | 0 .. YLM_LIGHT_EXTENT; a radius of 0 emits nothing |
** | radiance  | W sr^-1 m^-2    | finite, linear Rec. 709, may be negative         |
**
**     ylm_lights *lamps;
**     double at[3] = {0, 2, 0}, radius = 0.1, radiance[3] = {10, 8, 6};
**     if (ylm_lights_create(1, at, &radius, radiance, &lamps, &error) == YLM_OK) {
**       const ylm_field *field = ylm_lights_field(lamps);   // ylm_base.h says what a field does
**       ...
**       ylm_lights_free(lamps);
**     }
**
** The coefficients at a point x of a light with centre y, v = y - x, d = |v| > r:
** L_lm(x) = integral of Y_lm over the cap of half-angle asin(r/d) about v/d, times the radiance.
** At points in or on a light the sphere fills every direction: L_00 = sqrt(4pi) times the radiance,
** all else and all derivatives 0, and `inside` is set. Gradients and Hessians are with respect to
** x.
*/
#ifndef YLM_LIGHT_H
#define YLM_LIGHT_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The highest degree a field of lights is computed to. */
#define YLM_LIGHT_LMAX 100
/* Largest coordinate and radius: squares stay representable in float. */
#define YLM_LIGHT_EXTENT 1e15

/* Weights of linear Rec. 709 red, green and blue in luminance. */
#define YLM_LUMINANCE_R 0.2126
#define YLM_LUMINANCE_G 0.7152
#define YLM_LUMINANCE_B 0.0722

/* Any number of sphere lights; immutable once created. */
typedef struct ylm_lights ylm_lights;

/*
** ylm_lights_create - make one object of n sphere lights; the arrays are copied.
**
**   n         in   number of lights; 0 makes darkness
**   at        in   [n][3]  centres, scene units
**   radius    in   [n]     scene units
**   radiance  in   [n][3]  W sr^-1 m^-2
**   lights    out  to be freed with ylm_lights_free; NULL on failure
**
** Returns  YLM_OK; YLM_EDOMAIN (not finite, a negative radius), YLM_ERANGE (beyond
**          YLM_LIGHT_EXTENT): `e` names the light, counted from 1; YLM_ENOMEM
** Cost     O(n), 160 bytes per light
*/
YLM_API ylm_status ylm_lights_create(size_t n, const double *at, const double *radius,
                                     const double *radiance, ylm_lights **lights, ylm_error *e);
YLM_API void ylm_lights_free(ylm_lights *lights);

YLM_API size_t ylm_lights_count(const ylm_lights *lights);
/* What they were made from, as long as the object lives: at [n][3], radius [n], radiance [n][3].
   Each pointer may be NULL. */
YLM_API void ylm_lights_arrays(const ylm_lights *lights, const double **at, const double **radius,
                               const double **radiance);

/* Their light field (ylm_base.h); it lives as long as the object. lmax <= YLM_LIGHT_LMAX. */
YLM_API const ylm_field *ylm_lights_field(const ylm_lights *lights);

/*
** The sum over `count` symmetric matrices of the squares of their largest absolute eigenvalues,
** which
** for the Hessians of a light field is lambda squared (ylm_field_result). hessian: [6][count], all
** xx first, then xy, xz, yy, yz, zz.
*/
typedef float ylm_light_lambda2_fn(size_t count, const float *hessian);
/* That function for the instruction set in use. */
YLM_API ylm_light_lambda2_fn *ylm_light_lambda2(void);

/*
** ylm_lights_evaluate - the field's `evaluate` by the kernels of a given instruction set.
**
** Value, gradient, Hessian and the metric of the sum of all lights at n points, see
** ylm_field_query and ylm_field_result. YLM_ISA_reference is the product rule in double, light by
** light, and judges the others, which sum moments.
**
**   isa     in   an available one
**   points  in   [n][3] of q->dtype, finite, |coordinate| <= YLM_LIGHT_EXTENT
**   r       out  what q->want asks for; r->pairs grows by n times the number of lights
**
** Returns  YLM_OK; YLM_ERANGE (lmax, a point too far out), YLM_EDOMAIN (a point is not finite),
**          YLM_EINVAL (channels, isa): nothing is written then; YLM_ENOMEM; YLM_ECANCELLED
** Accuracy relative to the L2 norm over all degrees, against double at the inputs rounded to the
**          dtype, d/r from 1.001 on: double 1e-13 + 1e-15 d/(d-r); float 4e-6 + 1.5e-7 d/(d-r) to
**          lmax 31 (spec/bench/accuracy.c; docs/performance.md has what is found)
** Sums     of 1e5 lights in float stay within 1e-5 of double (compensated sums of 128)
** Threads  a point's result depends on the point and the lights alone: neither on the number of
**          threads nor on the other points of the batch
** Source   Iwasaki & Dobashi 2025, Eqs. 2-8, 15-20; docs/math.md "Sum of sphere lights"
*/
YLM_API ylm_status ylm_lights_evaluate(const ylm_lights *lights, ylm_isa isa,
                                       const ylm_field_query *q, size_t n, const void *points,
                                       ylm_field_result *r, ylm_error *e);

/* -- many lights: csrc/light/tree ------------------------------------------------------------
 */

/*
** The field of sphere lights to a tolerance: lights that are far away from a point in relation to
** what they span are summed as four proxy lights, by a tree that the lights keep once it is made.
**
**     ylm_light_cut *cut;
**     if (ylm_light_cut_create(lamps, 1e-2, 0, &cut, &error) == YLM_OK) {
**       const ylm_field *field = ylm_light_cut_field(cut);
**       ...
**       ylm_light_cut_free(cut);
**     }
**
** The distance of the coefficients from the exact ones, in the L2 norm over all coefficients and
** channels, is at most `tolerance` times the norm of the field that the lights would have if every
** radiance were replaced by its absolute value: for lights that are not negative, the field itself.
** Gradients and Hessians keep the same tolerance, each beside its own norm (Frobenius), or beside
** 1/64 of the sum of the lights' norms where they cancel to less; so does lambda beside itself.
** That holds at 99.9 % of points; at the others it is at most four times as much
** (docs/performance.md). It comes on top of what float rounds, see ylm_lights_evaluate.
** Points that lie together are summed in packets, so a point's result depends, within the
** tolerance,
** on the other points of the query; but neither on their order nor on the number of threads. Sets
** of some thousand lights, and the reference's,
** are summed exactly; `pairs` counts what was summed, proxies included.
*/
typedef struct ylm_light_cut ylm_light_cut;

#define YLM_LIGHT_TOLERANCE_LEAST 1e-6
#define YLM_LIGHT_TOLERANCE_MOST 0.5

/*
** ylm_light_cut_create - the field of `lights`, which must outlive it, to a tolerance.
**
**   tolerance  in  YLM_LIGHT_TOLERANCE_LEAST .. YLM_LIGHT_TOLERANCE_MOST
**   threads    in  to make the tree with, if it is not there yet; 0: the default
**
** Returns  YLM_OK; YLM_ERANGE (tolerance); YLM_ENOMEM
** Cost     O(n log n) and some 300 bytes per light where the tree is made
** Threads  makes the lights' tree, so not to be called for the same lights at the same time
** Source   docs/math.md "Many lights"; Walter et al. 2005 for the idea of a cut
*/
YLM_API ylm_status ylm_light_cut_create(ylm_lights *lights, double tolerance, int threads,
                                        ylm_light_cut **cut, ylm_error *e);
YLM_API void ylm_light_cut_free(ylm_light_cut *cut);
YLM_API const ylm_field *ylm_light_cut_field(const ylm_light_cut *cut);
/* The field's `evaluate` by the kernels of a given instruction set, as ylm_lights_evaluate. */
YLM_API ylm_status ylm_light_cut_evaluate(const ylm_light_cut *cut, ylm_isa isa,
                                          const ylm_field_query *q, size_t n, const void *points,
                                          ylm_field_result *r, ylm_error *e);
/* The memory that the lights' tree takes; 0 where there is none. */
YLM_API size_t ylm_lights_tree_bytes(const ylm_lights *lights);

/* -- textured parallelograms: csrc/light/texture.c ------------------------------------------- */

/*
** An image on a parallelogram, which is cut into parts: a quadtree whose leaves are of one colour
** to `tolerance`, at most twice as long as wide, and no larger than `largest` of the image's width
** and height. Parts without any radiance are left out.
**
** Source   Mezieres et al. 2022, Fig. 9 (a sphere for each texel) and Sec. 6 (the quadtree)
*/
typedef struct ylm_light_texture {
  double corner[3], u[3], v[3]; /* the image's bottom left, to its bottom right, to its top left */
  size_t width, height;         /* 1 .. 2^16 each */
  const float *texel;           /* [height][width][3], the top row first; finite; W sr^-1 m^-2 */
  double scale;                 /* multiplies it */
  double tolerance;             /* >= 0, of the largest number in the image */
  double largest;               /* 0 < largest <= 1 */
} ylm_light_texture;

/* The parts: vertices [n][4][3], counter-clockwise seen with u to the right and v up, radiance
   [n][3] their means. Returns n; with vertices NULL nothing is written. O(texels log texels). */
YLM_API size_t ylm_light_texture_quads(const ylm_light_texture *t, double *vertices,
                                       double *radiance);
/* The whole parallelogram as a regular net of at most `across` tiles a side, cut at texels, two
   triangles each: triangles [n][9], radiance [n][3] the mean of absolute values, both halves of a
   tile alike. What rays are aimed at. Returns n. */
YLM_API size_t ylm_light_texture_tiles(const ylm_light_texture *t, size_t across, double *triangles,
                                       double *radiance);

/* -- flat lights: csrc/light/flat/flat.c, contour*.c ----------------------------------------- */

/*
** Planar convex polygons, and ellipses, that emit the same radiance to both sides.
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
typedef struct ylm_polygons ylm_polygons;

#define YLM_POLYGON_VERTICES 64

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
YLM_API ylm_status ylm_polygons_create(size_t n, const int *sides, const double *vertices,
                                       const double *radiance, bool exact, const double *horizon,
                                       ylm_polygons **polygons, ylm_error *e);
YLM_API void ylm_polygons_free(ylm_polygons *polygons);
YLM_API size_t ylm_polygons_count(const ylm_polygons *polygons);
/* Their light field (ylm_base.h); lives as long as the object. Exact: lmax <= 60. */
YLM_API const ylm_field *ylm_polygons_field(const ylm_polygons *polygons);
/* One of them as it is; pointers are good as long as the object lives. */
typedef struct ylm_polygon {
  int sides; /* 0: an ellipse */
  bool exact;
  const double *vertices; /* [sides][3]; of an ellipse [3][3]: its centre, two half axes */
  const double *radiance, *centroid, *normal; /* [3]; the normal of length 1 */
  const double *horizon;                      /* [3] of length 1; NULL: none */
  double radius, reach; /* of a disk of its area; of the farthest point from the centroid */
} ylm_polygon;
YLM_API void ylm_polygons_get(const ylm_polygons *polygons, size_t i, ylm_polygon *out);
/* The approximation, as long as the object lives: centres [n][3], radii [n], normals of length 1
   [n][3], radiances [n][3]. False, and nothing written, where lights are exact. */
YLM_API bool ylm_polygons_spheres(const ylm_polygons *polygons, const double **at,
                                  const double **radius, const double **normal,
                                  const double **radiance);
/* The field's `evaluate` by the kernels of a given instruction set. YLM_ISA_reference sums node by
   node and judges the others, which take exact polygons without a horizon; what they cannot, on a
   light, edge-on or far, and ellipses, goes to the reference. A point's result depends on the point
   and the lights alone. YLM_EINVAL: isa is not available. */
YLM_API ylm_status ylm_polygons_evaluate(const ylm_polygons *polygons, ylm_isa isa,
                                         const ylm_field_query *q, size_t n, const void *points,
                                         ylm_field_result *r, ylm_error *e);

/* Lights of any kind: the spheres, then the sets of flat ones. */
typedef struct ylm_light_parts {
  const ylm_lights *spheres;       /* NULL: none */
  const ylm_polygons *const *flat; /* [flats] */
  size_t flats;
} ylm_light_parts;

/* -- sums of fields: csrc/light/field_sum.c ------------------------------------------------ */

/* The sum of light fields, which must live as long as it does. */
typedef struct ylm_field_sum ylm_field_sum;
YLM_API ylm_status ylm_field_sum_create(size_t n, const ylm_field *const *parts,
                                        ylm_field_sum **sum);
YLM_API void ylm_field_sum_free(ylm_field_sum *sum);
YLM_API const ylm_field *ylm_field_sum_field(const ylm_field_sum *sum);

/* -- results beyond the range of their type: finite.c ------------------------------------------ */

/*
** ylm_light_finite - what every light field says of results that are too large for their type.
**
** Lambda and norm, where q->want has the metric, end at the largest number (ylm_light_saturate);
** everything else that was wanted has to be finite.
**
** Returns  YLM_OK; YLM_ERANGE (`e` names the quantity and the first point)
*/
YLM_API ylm_status ylm_light_finite(const ylm_field_query *q, size_t n, const void *points,
                                    const ylm_field_result *r, ylm_error *e);
/* Its sentence: `what` at points[point] is beyond the range of the type. YLM_ERANGE */
YLM_API ylm_status ylm_light_beyond(const char *what, ylm_dtype t, size_t point,
                                    const void *points /* [..][3] */, ylm_error *e);
/* Puts the largest number for infinity among n numbers: sums of squares overflow long before what
   they are of. */
YLM_API void ylm_light_saturate(ylm_dtype t, size_t n, void *x);

#ifdef __cplusplus
}
#endif
#endif
