/*
** ylm_light.h - lights whose spherical-harmonic coefficients are known in closed form.
**
** A set holds lights of any kinds. Its light field is the sum of theirs; dynamic grids follow them
** one by one; ray casting asks for their surfaces, devices for what they can sum
** (ylm_light_device.h). The file of a kind says its parameters and formulas:
**
** | kind              | file                            | lights |
** | sphere            | csrc/light/sphere/kind.c        | spheres of one radiance |
** | polygon           | csrc/light/flat/kind.c          | polygons and ellipses, exactly |
** | polygon_as_sphere | csrc/light/flat/kind.c          | the same, approximated by spheres |
** | textured          | csrc/light/image/textured.c     | parallelograms with an image |
** | environment       | csrc/light/distant/environment.c | light from all around, infinitely far away |
** | sun               | csrc/light/distant/sun.c        | discs of one radiance, infinitely far away |
** | sampled           | csrc/light/image/sampled.c      | light known at a few places, blended between them |
** | virtual           | csrc/light/virtual/             | small lights that send different light in different directions |
**
**     ylm_light_set *lamps;
**     double at[3] = {0, 2, 0}, radius = 0.1, radiance[3] = {10, 8, 6};
**     if (ylm_light_set_spheres(1, at, &radius, radiance, &lamps, &error) == YLM_OK) {
**       const ylm_field *field = ylm_light_set_field(lamps); // ylm_base.h says what a field does
**       ...
**       ylm_light_set_free(lamps);
**     }
**
** Gradients and Hessians are with respect to the shading point.
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

/* The most vertices of a polygon. */
#define YLM_POLYGON_VERTICES 64
/* The most texels of an image that a light is made of. */
#define YLM_LIGHT_TEXELS (1 << 22)

/* -- sets of lights: csrc/light/set.c ---------------------------------------------------------- */

/* Any number of lights of any kinds; immutable once created. */
typedef struct ylm_light_set ylm_light_set;

/* Where lights of a set come from: records of a kind, another set, or a light field of another
   origin, which must outlive the set. */
typedef struct ylm_light_source {
  const char *kind;     /* of the records; NULL: there are none */
  const double *record; /* [numbers], one record after the other: csrc/light/kind.h */
  size_t numbers;
  const ylm_light_set *set; /* or NULL */
  const ylm_field *field;   /* or NULL */
} ylm_light_source;

/*
** ylm_light_set_create - make one set of lights from several sources.
**
**   n       in   number of sources; 0 makes darkness
**   source  in   [n]; records are copied, the lights of sets are shared
**   set     out  to be freed with ylm_light_set_free; NULL on failure
**
** Lights are summed in packs: all spheres together, first; then packs of other sets and fields;
** then for each kind, and for each value of what its lights must have in common, one pack.
**
** Returns  YLM_OK; YLM_EINVAL (no such kind, a record that is cut short); what the kind says of a
**          record, which `e` names; YLM_ENOMEM
** Threads  sets that share lights are made and freed by one thread at a time
*/
YLM_API ylm_status ylm_light_set_create(size_t n, const ylm_light_source *source,
                                        ylm_light_set **set, ylm_error *e);
/*
** ylm_light_set_spheres - make a set of n sphere lights from arrays, which are copied.
**
**   n         in   number of lights; 0 makes darkness
**   at        in   [n][3]  centres, scene units
**   radius    in   [n]     scene units
**   radiance  in   [n][3]  W sr^-1 m^-2
**
** Returns  YLM_OK; YLM_EDOMAIN (not finite, a negative radius), YLM_ERANGE (beyond
**          YLM_LIGHT_EXTENT): `e` names the light, counted from 1; YLM_ENOMEM
** Cost     O(n), 160 bytes per light
*/
YLM_API ylm_status ylm_light_set_spheres(size_t n, const double *at, const double *radius,
                                         const double *radiance, ylm_light_set **set, ylm_error *e);
YLM_API void ylm_light_set_free(ylm_light_set *set);
/* How many lights there are; fields of another origin count as one each. */
YLM_API size_t ylm_light_set_count(const ylm_light_set *set);
/* How many of them are spheres. */
YLM_API size_t ylm_light_set_sphere_count(const ylm_light_set *set);
/* Their light field (ylm_base.h); it lives as long as the set. lmax <= YLM_LIGHT_LMAX, or what the
   kinds allow. */
YLM_API const ylm_field *ylm_light_set_field(const ylm_light_set *set);
/*
** ylm_light_set_evaluate - the field's `evaluate` by the kernels of a given instruction set.
**
** YLM_ISA_reference is plain code in double and judges the others. A point's result depends on the
** point and the lights alone.
**
** Returns  as the field; YLM_EINVAL too (isa is not available, lights of several packs)
*/
YLM_API ylm_status ylm_light_set_evaluate(const ylm_light_set *set, ylm_isa isa,
                                          const ylm_field_query *q, size_t n, const void *points,
                                          ylm_field_result *r, ylm_error *e);

/*
** The sum over `count` symmetric matrices of the squares of their largest absolute eigenvalues: for
** the Hessians of a light field that is lambda squared (ylm_field_result). hessian: [6][count], all
** xx first, then xy, xz, yy, yz, zz.
*/
typedef float ylm_light_lambda2_fn(size_t count, const float *hessian);
/* The ylm_light_lambda2_fn of the instruction set in use. */
YLM_API ylm_light_lambda2_fn *ylm_light_lambda2(void);

/* -- many lights: csrc/light/tree ------------------------------------------------------------- */

/*
** The field of lights to a tolerance. A group of spheres that looks small from a point is replaced
** by four or eight proxy lights. The tree of groups is built once and belongs to the lights.
**
**     ylm_light_cut *cut;
**     if (ylm_light_cut_create(lamps, 1e-2, 0, &cut, &error) == YLM_OK) {
**       const ylm_field *field = ylm_light_cut_field(cut);
**       ...
**       ylm_light_cut_free(cut);
**     }
**
** The error of the coefficients is the L2 norm, over all coefficients and channels, of their
** distance from the exact ones. The error is at most `tolerance` times the norm of a reference
** field, in which every radiance is replaced by its absolute value. For lights that are not
** negative, the reference is the field itself. Gradients and Hessians keep the tolerance relative
** to their own norms (Frobenius). Where they cancel to less than 1/64 of the sum of the lights'
** norms, the tolerance is relative to that part. lambda keeps it relative to itself. The tolerance
** holds at 99.9 % of points; at the others the error is at most four times as large
** (docs/bench/many_lights.md). Rounding in float comes on top, see csrc/light/sphere/sphere.h.
**
** Points that lie together are summed in packets. Within the tolerance, a point's result depends on
** the other points of the query. Neither their order nor the number of threads matters. Sets of
** some thousand lights, and all sums of the reference set, are exact. `pairs` counts the lights and
** proxies that were summed.
*/
typedef struct ylm_light_cut ylm_light_cut;

#define YLM_LIGHT_TOLERANCE_LEAST 1e-6
#define YLM_LIGHT_TOLERANCE_MOST 0.5

/*
** ylm_light_cut_create - the field of `set`, which must outlive it, to a tolerance.
**
**   tolerance  in  YLM_LIGHT_TOLERANCE_LEAST .. YLM_LIGHT_TOLERANCE_MOST
**   threads    in  to make the tree with, if it is not there yet; 0: the default
**
** Returns  YLM_OK; YLM_ERANGE (tolerance); YLM_ENOMEM
** Cost     O(n log n) and some 300 bytes per light where the tree is made
** Threads  makes the lights' tree, so not to be called for the same lights at the same time
** Source   docs/math.md "Many lights"; Walter et al. 2005 for the idea of a cut
*/
YLM_API ylm_status ylm_light_cut_create(ylm_light_set *set, double tolerance, int threads,
                                        ylm_light_cut **cut, ylm_error *e);
YLM_API void ylm_light_cut_free(ylm_light_cut *cut);
YLM_API const ylm_field *ylm_light_cut_field(const ylm_light_cut *cut);
/* The field's `evaluate` by the kernels of a given instruction set, as ylm_light_set_evaluate. */
YLM_API ylm_status ylm_light_cut_evaluate(const ylm_light_cut *cut, ylm_isa isa,
                                          const ylm_field_query *q, size_t n, const void *points,
                                          ylm_field_result *r, ylm_error *e);
/* The memory that the lights' tree takes; 0 where there is none. */
YLM_API size_t ylm_light_set_tree_bytes(const ylm_light_set *set);

/* -- lights one by one: csrc/light/light.c, bound.c ------------------------------------------- */

/* The other numbers of a light; its kind knows them. */
typedef struct ylm_light_shape ylm_light_shape;

/*
** One light: as it is remembered and compared, and as rays see a sphere.
**
** The struct is the first of three forms in which spheres are stored. The others are private to the
** library: rows with the luminance, of the element type (csrc/light/lamp.h), for kernels that read
** light by light; and columns, [field][lights], for kernels that read several lights at once:
** leaves and proxies of the tree of lights (csrc/light/tree/tree.h), and the lamps of a scene
** (csrc/scene/scene.h). Two more forms are prescribed by others: Embree keeps float [4], and a
** device has the rows that shaders/lamps.glsl reads.
*/
typedef struct ylm_light {
  double at[3], radius; /* its place and size; of a flat light the centroid, a disk of its area */
  double radiance[3];
  const ylm_light_shape *shape;
} ylm_light;

/* The lights of a set one by one, whose shapes are in one block of memory. */
typedef struct ylm_light_list {
  ylm_light *light;
  size_t n;
  void *shapes;
} ylm_light_list;

/* Shapes that live until they are swept away. */
typedef struct ylm_light_shapes {
  ylm_light_shape **shape;
  size_t n, room, bytes;
} ylm_light_shapes;

/* Whether all lights of the set can be told apart: fields of another origin cannot. */
YLM_API bool ylm_light_set_is_listable(const ylm_light_set *set);
/* The lights as a list that the caller frees. YLM_ENOMEM; YLM_EINVAL: they cannot be told apart. */
YLM_API ylm_status ylm_light_set_list(const ylm_light_set *set, ylm_light_list *list);
YLM_API void ylm_light_list_free(ylm_light_list *list);
/* A set of n lights that are alike, grey, of radiances `strength`. */
YLM_API ylm_status ylm_light_set_of(size_t n, const ylm_light *const *light, const double *strength,
                                    ylm_light_set **set);

/* Gives a light a shape of its own in `shapes`, if it has any; YLM_ENOMEM. */
YLM_API ylm_status ylm_light_keep(ylm_light_shapes *shapes, ylm_light *l);
/* Marks a light's shape, and frees the shapes that are not marked, after which no shape is. */
YLM_API void ylm_light_mark(const ylm_light *l);
YLM_API void ylm_light_sweep(ylm_light_shapes *shapes);

/* An order of lights by all that they are made of; 0: equal. */
YLM_API int ylm_light_compare(const ylm_light *a, const ylm_light *b);
/* True if one pack may hold both. */
YLM_API bool ylm_light_alike(const ylm_light *a, const ylm_light *b);
/* True if the two differ in colour and by what moves a light continuously: a translation. */
YLM_API bool ylm_light_slides(const ylm_light *a, const ylm_light *b);
/* A box around it: min, max; of a distant light an empty one. */
YLM_API void ylm_light_box(const ylm_light *l, double box[6]);

#define YLM_LIGHT_KINDS 16 /* room for as many */

/* Bounds of fields of lights, measured once for a kind that is met. */
typedef struct ylm_light_bounds {
  int lmax, channels;            /* of the fields */
  double of[YLM_LIGHT_KINDS][4]; /* 0: the kind has not been met */
} ylm_light_bounds;

/* Measures what bounds of n lights take. Returns what light fields return; YLM_ENOMEM. */
YLM_API ylm_status ylm_light_bounds_meet(ylm_light_bounds *b, size_t n, const ylm_light *light,
                                         ylm_error *e);
/*
** Adds to bound [3] bounds of the norms of the values, gradients and Hessians of L(b) - L(a) at p,
** `slides` being ylm_light_slides(a, b). False if p is too near to either for them to hold. Both
** have been met.
*/
YLM_API bool ylm_light_bounds_add(const ylm_light_bounds *bounds, const ylm_light *a,
                                  const ylm_light *b, bool slides, const double p[3],
                                  double bound[3]);

/* -- what rays see: csrc/light/surfaces.c ------------------------------------------------------ */

/* A texture on triangles, the last ones of surfaces; pointers live as long as the set. */
typedef struct ylm_light_image {
  double corner[3], u[3], v[3]; /* its bottom left, to its bottom right, to its top left */
  size_t width, height;
  const float *texel; /* [height][width][3], the top row first */
  double scale;       /* multiplies it */
  size_t triangles;   /* how many cover it */
} ylm_light_image;

/* Surfaces that emit, spheres in the order of the set; of flat ones first triangles, then disks.
   Radiances in W sr^-1 m^-2; a horizon of 0 cuts nothing off. */
typedef struct ylm_light_surfaces {
  size_t spheres, triangles, disks, images;
  ylm_light *sphere;         /* [spheres] */
  double *triangle, *disk;   /* [triangles][9] corners; [disks][7] centre, radius, normal */
  double *triangle_emission; /* [triangles][6] radiance, horizon */
  double *disk_emission;     /* [disks][6] */
  ylm_light_image *image;    /* [images], in the order of their triangles */
  size_t tiles;              /* an image is covered by, a side */
} ylm_light_surfaces;

/* To be freed with ylm_light_surfaces_free in any case; images are covered by at most `tiles` tiles
   a side. YLM_ENOMEM. */
YLM_API ylm_status ylm_light_set_surfaces(const ylm_light_set *set, size_t tiles,
                                          ylm_light_surfaces *out);
YLM_API void ylm_light_surfaces_free(ylm_light_surfaces *s);

/* -- light from infinity, as rays see it: csrc/light/distant/sky.c ----------------------------- */

/* Directions about an axis of length 1, with the cosine of half the angle; radiance all over it. */
typedef struct ylm_light_cone {
  double axis[3], cosine, radiance[3];
} ylm_light_cone;

/* Whether there are distant lights. */
YLM_API bool ylm_light_set_is_distant(const ylm_light_set *set);
/* The radiance that comes from infinity, from direction d of length 1: of lights that fill the sky,
   and with `cones` of all. */
YLM_API void ylm_light_set_sky(const ylm_light_set *set, const double d[3], bool cones,
                               double rgb[3]);
/* Cone i of the set; false where there are no more. */
YLM_API bool ylm_light_set_cone(const ylm_light_set *set, size_t i, ylm_light_cone *out);

/* -- textured parallelograms: csrc/light/image/texture.c, textured.c -------------------------- */

/*
** An image on a parallelogram, which a quadtree cuts into parts. Leaves are of one colour to
** `tolerance` and at most twice as long as wide. Their sides are at most `largest` of the image's
** width and height. Parts without any radiance are left out.
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
   tile alike. Rays are aimed at these. Returns n. */
YLM_API size_t ylm_light_texture_tiles(const ylm_light_texture *t, size_t across, double *triangles,
                                       double *radiance);

/* A set of the parts of a texture as quadrilaterals, exact ones or approximated by spheres
   (csrc/light/flat/flat.h), cut at a horizon unless that is NULL. Texels are copied. *parts: how
   many they are. Returns as ylm_light_set_create. */
YLM_API ylm_status ylm_light_set_textured(const ylm_light_texture *t, bool exact,
                                          const double *horizon, ylm_light_set **set, size_t *parts,
                                          ylm_error *e);

/* -- light from samples: csrc/light/image/sampled.c --------------------------------------- */

#define YLM_LIGHT_SAMPLES 4096 /* the most places of a sampled light */

/* Light that is known at n places, between which it is blended by 1/distance^power. */
typedef struct ylm_light_sampled {
  size_t n;
  const double *at; /* [n][3], no two of them at one place */
  int lmax;
  const double *coefficients; /* [n][3][(lmax+1)^2] W m^-2 sr^-1/2 */
  double power;               /* 2 .. 100: below 2 it would have kinks */
} ylm_light_sampled;

/* A set of one sampled light; numbers are copied. Rays see nothing of it, and nothing follows it.
   YLM_OK; YLM_ERANGE, YLM_EDOMAIN: `e` names the sample, counted from 1; YLM_ENOMEM.
   Cost  O(n) a point. */
YLM_API ylm_status ylm_light_set_sampled(const ylm_light_sampled *light, ylm_light_set **set,
                                         ylm_error *e);

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
