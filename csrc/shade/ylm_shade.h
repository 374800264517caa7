/*
** ylm_shade.h - from a camera's rays to an image: shading points, transfer vectors, shading.
**
**   ylm_shade_view    what one camera sees of a scene: shading points with their transfer vectors.
**                     Everything that does not depend on how the light is known is done once,
**                     so that grids are compared on one view at the cost of sampling them.
**
** A shading point stands for samples of one pixel that hit the same mesh. Their hits lie within
** `share` pixel widths of each other and have normals within 10 degrees. One of these hits is
** taken, the one nearest to their mean; its weight is their share of the pixel. A pixel in the
** middle of a surface is shaded once, however many samples resolve its edges. A pixel that covers a
** long stretch of floor is shaded several times. With share = 0 every sample is shaded. With
** `fine`, normals of surfaces that gloss are within a twentieth of the width of their lobe.
**
** Its transfer vector T holds the SH coefficients of A(s) V(s), A being what its material weighs
** light with (matte: max(0, n.s)), and ylm_material_radiance makes radiance of
**
**   sum over k of T[k] L[c][k]
**
** Ownership   a view must not outlive its scene.
** Threads     views are read-only after creation.
** Results     depend on the seed, and not on the number of threads.
*/
#ifndef YLM_SHADE_H
#define YLM_SHADE_H

#include "ylm_base.h"
#include "ylm_grid.h"
#include "ylm_path.h"
#include "ylm_scene.h"
#include "ylm_sh.h"
#include "ylm_transfer.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_light_virtual ylm_light_virtual; /* ylm_light_virtual.h */

/* -- view -------------------------------------------------------------------- */

typedef struct ylm_shade_view ylm_shade_view;

typedef enum ylm_shade_visibility {
  YLM_SHADE_UNSHADOWED, /* V = 1: the clamped cosine, analytically                      */
  YLM_SHADE_PIXEL,      /* V by occlusion rays from every shading point                 */
  YLM_SHADE_VERTEX,     /* V by occlusion rays from the vertices of the triangles seen;
                           transfer vectors are interpolated over the triangle          */
  YLM_SHADE_RAYS        /* no transfer vectors: for ylm_shade_raycast, and for light that
                           holds its shadows (YLM_SHADE_COSINE)                          */
} ylm_shade_visibility;

/* The factor of the coefficients of light at a shading point. */
typedef enum ylm_shade_weight {
  YLM_SHADE_TRANSFER, /* its transfer vector: light without shadows                    */
  YLM_SHADE_COSINE    /* the clamped cosine A alone: light that holds its shadows, to the
                         degree of the light                                           */
} ylm_shade_weight;

#define YLM_SHADE_DEGREES 61 /* of slices: YLM_MATERIAL_TABLE_LMAX + 1 */

/* How coefficients of light shade surfaces that are not matte. */
typedef enum ylm_shade_gloss {
  YLM_SHADE_GLOSS_MATTE, /* as matte ones of their mean albedo                              */
  YLM_SHADE_GLOSS_SH,    /* by tables of their slices, to degree YLM_MATERIAL_TABLE_LMAX     */
  YLM_SHADE_GLOSS_AUTO,  /* by tables; where these miss more than gloss_error, by rays      */
  YLM_SHADE_GLOSS_RAYS   /* by rays alone (ylm_shade_blend): no tables                      */
} ylm_shade_gloss;

/* The most camera rays of a pixel. */
#define YLM_SHADE_SAMPLES 1024
/* The most pixels that are listed. */
#define YLM_SHADE_PIXELS 65536

typedef struct ylm_shade_options {
  int width, height;               /* pixels, 1 .. YLM_IMAGE_MAX_SIDE                      */
  int samples;                     /* per pixel, stratified, 1 .. YLM_SHADE_SAMPLES        */
  int lmax;                        /* of the transfer vectors, 0 .. YLM_LIGHT_LMAX         */
  bool per_vertex;                 /* shade vertices and interpolate colour over triangles */
  ylm_shade_visibility visibility; /* per_vertex: PIXEL means the same as VERTEX           */
  bool self;                 /* PIXEL, VERTEX: occlusion rays meet the mesh they start from alone */
  int transfer_samples;      /* occlusion rays per transfer vector, 1 .. YLM_SCENE_SAMPLES */
  const ylm_field *light;    /* transfer_samples is the least number; it is doubled  */
  double noise;              /* until the noise under this light is at most `noise`, */
  int most_samples;          /* up to this number. NULL: it is taken as it is        */
  double occlusion_distance; /* > 0, may be infinite: how far these rays reach       */
  double share;              /* pixel widths, >= 0                                   */
  bool fine; /* surfaces that gloss: samples are one point only where their lobes agree     */
  ylm_shade_gloss gloss; /* AUTO of a view per_vertex is SH, RAYS YLM_EINVAL         */
  bool
      below_dark; /* visibility of points that gloss: nothing below the horizon, not its mirror image */
  float window[YLM_SHADE_DEGREES]; /* factors of the degrees of slices; [0] = 0: all 1 */
  double gloss_error[2];           /* AUTO: 0 <= [0] < [1]: see ylm_shade_blend                */
  bool nearest;                    /* of these tables: the nearest of 90 rows, by libylm_rival.so */
  ylm_sh_product_method product;   /* by which visibility multiplies slices: of two factors */
  bool keep;                       /* the products, once made: other light costs a dot product */
  bool
      all_vertices; /* per_vertex: shading points are all vertices, on the outer side and, of meshes that
                        the camera sees from within, on the inner one: for other cameras */
  const uint32_t *pixel; /* [pixels] y * width + x: these alone, as an image of one column  */
  size_t pixels;         /* 1 .. YLM_SHADE_PIXELS; NULL: all                        */
  uint64_t seed;
  int threads;
  const ylm_progress *progress; /* stages "primary rays", "transfer"                    */
} ylm_shade_options;

typedef struct ylm_shade_stats {
  size_t points; /* shading points: where light is asked for                       */
  size_t hits;   /* primary samples that hit a mesh                                */
  size_t pixels; /* of the image                                                   */
  uint64_t primary_rays, occlusion_rays;
  double primary_seconds, transfer_seconds;
  double noise;         /* that transfer_samples leave, below 0: not measured             */
  size_t bytes;         /* memory the view holds                                          */
  size_t glossy;        /* points of surfaces that are not matte (options.gloss)  */
  size_t gloss_bytes;   /* of these tables, which materials keep                  */
  double gloss_seconds; /* that making those took which were not there            */
} ylm_shade_stats;

/*
** ylm_shade_view_create - trace a camera's rays and find the transfer vectors of what they hit.
**
** Camera rays go through stratified places in each pixel. Occlusion rays are distributed as the
** cosine about the shading normal, a Hammersley set shifted at random per point; with V_i what
** ray i found, Y_i the basis at its direction, A Y(n) the exact clamped cosine and v the mean V_i,
**
**   T = pi/N sum V_i Y_i + v (A Y(n) - pi/N sum Y_i)
**
** which is exact where nothing or everything occludes; its bias is of the order of 1/N of its
** deviation.
**
** With options.gloss SH or AUTO, points of surfaces that are not matte have visibility alone in place of T;
** zeros where rays alone shade them. Rays are uniform over the hemisphere; s' being s mirrored in the surface,
**
**   V = sqrt(4 pi) e_00 - 2 pi/N sum over occluded rays of (Y(s) + Y(s'))
**
** so that nothing is lost where nothing occludes; with below_dark the hemisphere's own coefficients less those of
** Y(s) alone. Their radiance is (F x V) . L, F the slice f cos of the
** material towards the camera, x the product of functions, cut at the view's degree; F . L where the
** light holds its shadows (YLM_SHADE_COSINE), or V = 1.
**
** Noise is measured at 128 to 512 of the points, by two independent estimates a and b of the
** luminance r of each: the root mean square of |a - b| / sqrt 2 relative to r + (mean of r) / 10.
** `light` is asked for values at the view's lmax, 1 channel, float, and is not kept.
**
** Returns  YLM_OK; YLM_EINVAL (camera), YLM_ERANGE (an option), YLM_ENOMEM, YLM_ECANCELLED; what
**          `light` returns
** Cost     per shading point: transfer_samples rays and 4 (lmax+1)^2 + 64 bytes
** Source   Sloan et al. 2002, "Precomputed Radiance Transfer"; Iwasaki & Dobashi 2025, Sec. 6.2
*/
YLM_API ylm_status ylm_shade_view_create(const ylm_scene *scene, const ylm_camera *camera,
                                         const ylm_shade_options *o, ylm_shade_view **view,
                                         ylm_error *e);
YLM_API void ylm_shade_view_free(ylm_shade_view *view);

YLM_API void ylm_shade_view_stats(const ylm_shade_view *view, ylm_shade_stats *stats);
/* Bytes of tables and slices that shading has made since this was last asked: for collectors of garbage, which know
   of a view what it held at first. */
YLM_API size_t ylm_shade_view_grown(const ylm_shade_view *view);
/* Seconds since the view was made that its points that gloss took, summed over threads. */
typedef struct ylm_shade_stages {
  double rows, rotation, product; /* slices: looked up, turned to the world, times visibility */
  double light, dot;              /* coefficients of light; slices times light */
} ylm_shade_stages;
YLM_API void ylm_shade_view_stages(const ylm_shade_view *view, ylm_shade_stages *stages);
/* The options that the view was made with; `progress`, `light` and `pixel` are NULL. */
YLM_API const ylm_shade_options *ylm_shade_view_options(const ylm_shade_view *view);

/* The differences of a view from the one that it is made of. */
typedef struct ylm_shade_change {
  const ylm_camera *camera; /* NULL: the same; of views with options.all_vertices alone */
  bool blind; /* of another camera, no rays: its points are shaded, but no image is made */
  const ylm_material *const
      *materials; /* [meshes] NULL: the same; NULL among them: this one is the same */
  bool nearest;   /* as in the options */
  ylm_sh_product_method product;
  bool keep;
} ylm_shade_change;

/*
** ylm_shade_view_change - a view of the same shading points with other materials, or another camera.
**
** Visibility is that of `from`, whose memory is shared. Points of matte surfaces hold it times the cosine,
** so these stay matte; others may become of any kind.
**
** Returns    YLM_OK; YLM_EINVAL (a matte surface that would gloss; an anisotropic material, where `from` has
**            isotropic ones alone; another camera of a view whose points are not all vertices, or one that
**            sees the inner side of a mesh that `from` has not seen from within; a view with points that rays
**            alone shade: AUTO, RAYS); YLM_EMISSING (a method of
**            libylm_rival.so); YLM_ENOMEM, YLM_ECANCELLED
** Ownership  the view must not outlive `from`; materials are kept
*/
YLM_API ylm_status ylm_shade_view_change(const ylm_shade_view *from, const ylm_shade_change *c,
                                         int threads, const ylm_progress *progress,
                                         ylm_shade_view **view, ylm_error *e);

/* Per shading point; valid as long as the view. */
/* [points][3], relative to ylm_shade_view_origin */
YLM_API const float *ylm_shade_view_positions(const ylm_shade_view *view);
/* ylm_scene_origin of the scene. */
YLM_API const double *ylm_shade_view_origin(const ylm_shade_view *view);
YLM_API const float *ylm_shade_view_normals(const ylm_shade_view *view); /* [points][3] unit */
/* Normals of n points' triangles from `first` on, unit, on the side that is seen; of shading by
   vertices those of `normals`. */
YLM_API void ylm_shade_view_flats(const ylm_shade_view *view, size_t first, size_t n,
                                  float (*out)[3]);
/* [points][count], of points that gloss visibility (options.gloss); NULL: a view by rays has none */
YLM_API const float *ylm_shade_view_transfer(const ylm_shade_view *view);
/* albedo [points][3], tinted; object [points]: index of the mesh. Either may be NULL. */
YLM_API void ylm_shade_view_surface(const ylm_shade_view *view, float *albedo, float *object);
/* ylm_material_row of each point's material, tinted: row [points][YLM_MATERIAL_ROW]. */
YLM_API ylm_status ylm_shade_view_materials(const ylm_shade_view *view, float *row, ylm_error *e);

/*
** ylm_shade_judge - what paths say of the radiance of a view's shading points (ylm_path_places).
**
**   mean, variance  out  [points][3]
**
** Returns  YLM_OK; as ylm_path_places; YLM_EINVAL (shading points are vertices)
*/
YLM_API ylm_status ylm_shade_judge(const ylm_shade_view *view, const ylm_path_options *o,
                                   float *mean, float *variance, ylm_path_stats *stats,
                                   ylm_error *e);

/* Estimates of the radiance of a view's shading points. */
typedef struct ylm_shade_estimate {
  const ylm_shade_view *view;
  const float *radiance; /* [points][3] */
  const float *again;    /* [points][3] with random numbers of its own, or NULL: as `radiance` */
} ylm_shade_estimate;

/* How far two estimates are from each other, over the pixels that show surfaces, all channels. */
typedef struct ylm_shade_error {
  size_t pixels;
  double mean;        /* of b                                                                   */
  double square;      /* of (a - b) (a' - b') - variance                                        */
  double uncertainty; /* standard error of `square`, pixels being a random choice               */
} ylm_shade_error;

/*
** ylm_shade_compare - how far pixels by one estimate are from those by another.
**
** With `again`, noise of the two adds nothing to the mean of products: what is left is their
** systematic difference.
**
**   a, b      in  of views that show the same pixels
**   variance  in  [points][3] of b, or NULL: 0
**   weight    in  [pixels] those of ylm_shade_draw, or NULL: 1
**
** Returns  YLM_OK; YLM_EINVAL (shading points are vertices), YLM_ESHAPE (other pixels)
*/
YLM_API ylm_status ylm_shade_compare(const ylm_shade_estimate *a, const ylm_shade_estimate *b,
                                     const float *variance, const double *weight,
                                     ylm_shade_error *out);

/* Pictures [height][width][3] of surfaces alone, by which pixels are drawn. */
typedef struct ylm_shade_drawing {
  int width, height;
  const float *light; /* a picture                        */
  const float *again; /* another estimate of it, or NULL  */
  size_t count;       /* of pixels to draw                */
  uint64_t seed;
} ylm_shade_drawing;

/*
** ylm_shade_draw - pixels that say what a picture's mean square error is.
**
** Pixel i is drawn with the probability q_i = min(1, c p_i), c such that the q_i add up to `count`. p is a mixture: half of
** it is even; the rest is in proportion to the squared light of the brightest of nine pixels around, and, where there is
** `again`, a quarter to the squared difference of the two pictures. Few bright pixels are therefore drawn for certain, and
** no pixel has a weight above twice the mean. The draw is systematic, along columns of strips as high as the pixels drawn
** are apart: the pixels lie all over the picture.
**
**   pixel   out  [count] numbers y width + x
**   weight  out  [count] 1/q: sums of weight times x are sums of x over the picture, in the mean
**   drawn   out  how many: count, or all pixels where there are fewer
**
** Returns  YLM_OK; YLM_ERANGE (sizes below 1), YLM_ENOMEM
** Source   Horvitz, Thompson 1952; Madow 1949
*/
YLM_API ylm_status ylm_shade_draw(const ylm_shade_drawing *d, uint32_t *pixel, double *weight,
                                  size_t *drawn);

/* -- light ------------------------------------------------------------------- */

/*
** ylm_shade_field - radiance of every shading point under a light field.
**
**   field   in   asked for values at lmax of the view, 3 channels, float (or double)
**   weight  in   what it is multiplied by
**   t       in   the element type light is asked for and multiplied in; radiance is float
**   out     out  [points][3]
**   pairs   out  light x point evaluations, may be NULL
**
** Returns  YLM_OK; what the field returns; YLM_EINVAL: TRANSFER, and the view has no transfer vectors;
**          YLM_ENOMEM, YLM_ECANCELLED (progress stage "shading")
*/
YLM_API ylm_status ylm_shade_field(const ylm_shade_view *view, const ylm_field *field,
                                   ylm_shade_weight weight, ylm_dtype t, int threads,
                                   const ylm_progress *progress, float *out, uint64_t *pairs,
                                   ylm_error *e);

/*
** ylm_shade_grid - radiance of every shading point by interpolating a grid.
**
** TRANSFER: a grid of another lmax than the view's is used up to the smaller of the two.
**
**   grid           in
**   weight         in   what its light is multiplied by
**   interpolation  in
**   out            out  [points][3]
**   report         out  points outside and unbaked; seconds of sampling and shading together
**
** Returns  YLM_OK; YLM_EINVAL as ylm_shade_field; YLM_ENOMEM, YLM_ECANCELLED (progress stage "shading")
*/
YLM_API ylm_status ylm_shade_grid(const ylm_shade_view *view, const ylm_grid *grid,
                                  ylm_shade_weight weight, ylm_grid_interpolation interpolation,
                                  int threads, const ylm_progress *progress, float *out,
                                  ylm_grid_report *report, ylm_error *e);

/*
** ylm_shade_limits - halves of the distances from n shading points to the first surface along their
** normals.
**
**   flat   in   [n][3] of ylm_shade_view_flats
**   most   in   distances beyond twice this are infinite
**   limit  out  [n] scene units
**
** Returns  YLM_OK, YLM_ENOMEM
*/
YLM_API ylm_status ylm_shade_limits(const ylm_shade_view *view, size_t first, size_t n,
                                    const float (*flat)[3], float most, float *limit);

/* The distance from x along a direction of length 1 to the first occluding surface of a ylm_scene, or
   `far`: of ylm_grid_reach. */
YLM_API double ylm_shade_reach(const void *scene, const float x[3], const float direction[3],
                               double far);

/*
** ylm_shade_bias - where n shading points from `first` on look a grid up: ylm_grid_bias, at most half
** of the way to the first hit along the normal.
**
**   factor  in   of ylm_grid_form.bias
**   flat    in   [n][3] of ylm_shade_view_flats
**   places  out  [n][3]
**
** Returns  YLM_OK, YLM_ENOMEM
** Cost     five rays a point
*/
YLM_API ylm_status ylm_shade_bias(const ylm_shade_view *view, const ylm_grid *grid, double factor,
                                  size_t first, size_t n, const float (*flat)[3],
                                  float (*places)[3]);

/*
** ylm_shade_grid_biased - ylm_shade_grid, looked up beside surfaces (ylm_shade_bias,
** ylm_grid_sample_biased): of grids whose light jumps there.
**
**   factor  in   0: looked up at the points themselves, as ylm_shade_grid does
**   window  in   [lmax+1] of the grid: what degrees of its light are multiplied by; NULL: 1
**   report  out  points outside and unbaked, of the places that are looked up; may be NULL
**   bias    out  of the distances; may be NULL
**
** Returns  as ylm_shade_grid
** Cost     a ray per point, and samples with gradients
*/
YLM_API ylm_status ylm_shade_grid_biased(const ylm_shade_view *view, const ylm_grid *grid,
                                         ylm_shade_weight weight,
                                         ylm_grid_interpolation interpolation, double factor,
                                         const double *window, int threads,
                                         const ylm_progress *progress, float *out,
                                         ylm_grid_report *report, ylm_grid_bias_report *bias,
                                         ylm_error *e);

/* Radiance of a view under a dynamic grid, kept from one rendering to the next. */
typedef struct ylm_shade_memory ylm_shade_memory;
YLM_API ylm_status ylm_shade_memory_create(const ylm_shade_view *view, ylm_shade_memory **memory);
YLM_API void ylm_shade_memory_free(ylm_shade_memory *memory);

/*
** ylm_shade_grid_again - ylm_shade_grid, which samples only what has changed since the last time.
**
**   memory  in/out  made for this view; some 20 bytes per shading point
**   out     in/out  [points][3]: what the last call with this memory has left there
**   fresh   out     points that were sampled
**
** Points in voxels whose data are what they were keep their radiance (ylm_grid_track); results are
** those of ylm_shade_grid with weight TRANSFER. A grid that is not dynamic is sampled everywhere.
** Threads  one memory is for one caller at a time
*/
YLM_API ylm_status ylm_shade_grid_again(const ylm_shade_view *view, ylm_shade_memory *memory,
                                        const ylm_grid *grid, ylm_grid_interpolation interpolation,
                                        int threads, const ylm_progress *progress, float *out,
                                        ylm_grid_report *report, uint64_t *fresh, ylm_error *e);

/* Links of a view's shading points: the elements of surfaces that they see. */
typedef struct ylm_shade_links ylm_shade_links;

/* Which points have links, and which rays those of surfaces that are not matte. */
typedef enum ylm_shade_linked {
  YLM_SHADE_LINKS_MATTE, /* all, as matte ones: rays as dense as the cosine              */
  YLM_SHADE_LINKS_BOTH,  /* all; of those that gloss rays that their materials choose    */
  YLM_SHADE_LINKS_GLOSS  /* those that gloss alone; nothing is gathered at others        */
} ylm_shade_linked;

typedef struct ylm_shade_links_stats {
  int links;      /* of a shading point */
  size_t glossy;  /* links whose rays materials choose */
  uint64_t rays;  /* that were traced for them */
  size_t bytes;   /* memory they hold */
  double seconds; /* that finding them took */
} ylm_shade_links_stats;

/*
** ylm_shade_links_create - find the elements that rays from the shading points of a view hit.
**
**   links  in   of a point, 4 .. YLM_TRANSFER_LINKS, a multiple of 4
**   which  in   rays that materials choose (ylm_material_sample) have weights, f cos over the density. Points of one
**               mesh share `links` as they share the pixel, four each at least (options.share 0: `links` each)
**
** A point's rays have the density of the cosine about its normal, and random numbers of its place in
** the image: what is seen elsewhere changes nothing. Rays that begin inside of a body are replaced by others
** of their point.
**
** Returns    YLM_OK; YLM_ERANGE, YLM_ENOMEM, YLM_ECANCELLED (progress stage "links")
** Ownership  links must not outlive their view, nor the transfer
** Cost       points * links rays; 4 bytes a link, 10 of points that gloss
** Source     Heitz 2018, "Sampling the GGX Distribution of Visible Normals" (rays of points that gloss)
*/
YLM_API ylm_status ylm_shade_links_create(const ylm_shade_view *view, const ylm_transfer *transfer,
                                          int links, ylm_shade_linked which, uint64_t seed,
                                          int threads, const ylm_progress *progress,
                                          ylm_shade_links **out, ylm_error *e);
YLM_API void ylm_shade_links_free(ylm_shade_links *links);
/* The transfer whose elements they lead to. */
YLM_API const ylm_transfer *ylm_shade_links_transfer(const ylm_shade_links *links);
YLM_API void ylm_shade_links_look(const ylm_shade_links *links, ylm_shade_links_stats *stats);

/*
** ylm_shade_gather - light that surfaces send to the shading points of a view, and that these reflect.
**
**   out[i] = start[i] + albedo_i/pi E_i,   E_i = pi * mean over links j of i of the radiance that leaves j
**
** and of points whose rays materials chose start[i] + mean over links j of weight_j times that radiance. Nothing is
** traced.
**
**   leaving  in      [elements + 1][4] of the links' transfer: ylm_radiosity_leaving
**   start    in      [points][3] or NULL: zeros
**   out      out     [points][3]; may be `start`
**
** Returns  YLM_OK; YLM_ECANCELLED (progress stage "gathering")
** Cost     as ylm_transfer_sum; no allocation
*/
YLM_API ylm_status ylm_shade_gather(const ylm_shade_links *links, const float *leaving,
                                    const float *start, int threads, const ylm_progress *progress,
                                    float *out);

/* The noise of gathered light at a shading point, in luminance: half of the difference of two
   estimates, by links of even and of odd number. The result is the root mean square over at most
   4,096 points, over the mean of the light. Of points that gloss it is that of what they reflect,
   over their mean albedo. 0 where there is none. */
YLM_API double ylm_shade_gather_noise(const ylm_shade_links *links, const float *leaving);

/* ylm_transfer_vectors_at and ylm_transfer_matrices of a view's shading points: out [points][3][(lmax+1)^2], lmax of the
   transfer, and [points][3][(lmax_out+1)^2][(lmax_in+1)^2]. Points keep the random numbers of their place in the image. */
YLM_API ylm_status ylm_shade_view_vectors(const ylm_shade_view *view, const ylm_transfer *transfer,
                                          const float *vectors, int links, uint64_t seed,
                                          int threads, const ylm_progress *progress, float *out,
                                          ylm_error *e);
YLM_API ylm_status ylm_shade_view_matrices(const ylm_shade_view *view, const ylm_transfer *transfer,
                                           const float *vectors, int rays, uint64_t seed,
                                           int lmax_in, int lmax_out, int threads,
                                           const ylm_progress *progress, float *out, ylm_error *e);

/*
** ylm_shade_by_vectors - radiance of every shading point by transfer vectors that are given.
**
**   T         in   [points][channels][(lmax+1)^2], channels 3 or 1
**   field     in   asked at every point for values at that lmax, 3 channels, float
**   out       out  [points][3]
**   pairs     out  light x point evaluations, may be NULL
**
** Returns  YLM_OK; what the field returns; YLM_ENOMEM, YLM_ECANCELLED (progress stage "shading")
*/
YLM_API ylm_status ylm_shade_by_vectors(const ylm_shade_view *view, int lmax, int channels,
                                        const float *T, const ylm_field *field, int threads,
                                        const ylm_progress *progress, float *out, uint64_t *pairs,
                                        ylm_error *e);

/* Level of the leaf that holds each shading point and the error estimated for it (NaN: unknown);
   level, error [points]. */
YLM_API ylm_status ylm_shade_grid_cells(const ylm_shade_view *view, const ylm_grid *grid,
                                        int threads, float *level, float *error);

/* Radiance of points first .. first+n-1 by their transfer vectors from coefficients L [n][channels][(lmax+1)^2], channels 1
   or 3, any lmax; out [n][3]. YLM_ERANGE, YLM_ESHAPE; YLM_EINVAL: the view has none. */
YLM_API ylm_status ylm_shade_coefficients(const ylm_shade_view *view, size_t first, size_t n,
                                          int channels, int lmax, ylm_dtype t, const void *L,
                                          int threads, float *out);

/*
** ylm_shade_raycast - radiance of every shading point by sampling the lamps themselves.
**
** Each of `light_samples` strata chooses a lamp in proportion to (a bound of) its unshadowed
** luminous irradiance, then a direction. The direction is uniform in the solid angle that the lamp
** fills; of disks, and triangles that fill little, it is that of a place uniform in area. A ray
** that starts at the point and ends at the lamp decides. No SH, no grid, no occlusion_distance.
** Surfaces that are not matte are lit by as many rays again that their material chooses, weighed by
** the balance heuristic (ylm_path_places).
**
**   lit            in   whose lamps: the view's scene with others (ylm_scene_relight); NULL: its own
**   light_samples  in   shadow rays per shading point, 1 .. YLM_SCENE_SAMPLES
**   out            out  [points][3]
**   rays           out  shadow rays that were traced, may be NULL
**
** Returns  YLM_OK; YLM_ERANGE, YLM_ENOMEM, YLM_ECANCELLED (progress stage "raycast"); YLM_EINVAL:
**          `lit` has other meshes, or a view per vertex has surfaces that are not matte
** Cost     points * (lamps + light_samples rays)
** Source   Shirley, Wang, Zimmerman 1996, "Monte Carlo Techniques for Direct Lighting
**          Calculations"; Arvo 1995, "Stratified Sampling of Spherical Triangles";
**          Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences" (R2)
*/
YLM_API ylm_status ylm_shade_raycast(const ylm_shade_view *view, const ylm_scene *lit,
                                     int light_samples, bool shadows, uint64_t seed, int threads,
                                     const ylm_progress *progress, float *out, uint64_t *rays);

/*
** ylm_shade_raycast_noise - the noise of ylm_shade_raycast at a shading point: the root mean square difference to another
** estimate, over the square root of 2 and over the mean, in luminance.
**
**   radiance  in   [points][3] what ylm_shade_raycast found by these arguments
**   noise     out  measured at one of 32 points, at 256 to 4,096; 0 where there is no light
**
** Returns  as ylm_shade_raycast
*/
YLM_API ylm_status ylm_shade_raycast_noise(const ylm_shade_view *view, const ylm_scene *lit,
                                           int light_samples, bool shadows, uint64_t seed,
                                           int threads, const float *radiance, double *noise);

typedef struct ylm_shade_blending {
  const ylm_scene *lit;    /* whose lamps: as ylm_shade_raycast; NULL: the view's             */
  ylm_shade_weight weight; /* what the light was multiplied by                                */
  int lmax;                /* its degree                                                      */
  int light_samples; /* 1 .. YLM_SCENE_SAMPLES: rays to lamps, and as many by the material; 0: there
                              are no lamps, and no rays                                       */
  double noise;      /* > 0: light_samples is the least number of a pixel and mesh, raised
                              where it varies until each mesh's noise is at most this, root mean
                              square over that of its radiance (a tenth of the picture's, if less), */
  int most_samples;  /* up to this                                                      */
  bool shadows;      /* false: nothing occludes                                         */
  uint64_t seed;
  int threads;
  const ylm_progress *progress; /* stage "places" */
} ylm_shade_blending;

/* How points of surfaces that are not matte were shaded. */
typedef struct ylm_shade_blended {
  size_t sh, rays;   /* points by harmonics, and by rays: both, where they are mixed            */
  double missed;     /* root mean square of e at points, each as often as harmonics count there */
  uint64_t traced;   /* rays                                                                    */
  int light_samples; /* the mean of pixels and meshes                                      */
  double noise;      /* that they leave in the mesh that has most; below 0: not measured   */
  double seconds;
} ylm_shade_blended;

/*
** ylm_shade_blend - radiance of points that gloss by rays, where the light's degree is too low for them.
**
** A point's slice f cos, towards the camera, misses the part e of its norm at degree lmax. Rays count
**
**   w = smoothstep(gloss_error[0], gloss_error[1], e)     SH: 0     RAYS: 1
**
** and what harmonics made of the point 1 - w. Rays are those of ylm_shade_raycast.
**
**   radiance  in/out  [points][3]
**   share     out     [points]: w; 0 of matte points
**
** Returns  YLM_OK; YLM_ERANGE, YLM_EINVAL (other meshes; RAYS, per_vertex), YLM_ENOMEM, YLM_ECANCELLED
** Cost     as ylm_shade_raycast for points where w > 0; the others' radiance keeps its bits
*/
YLM_API ylm_status ylm_shade_blend(const ylm_shade_view *view, const ylm_shade_blending *o,
                                   float *radiance, float *share, ylm_shade_blended *report,
                                   ylm_error *e);

/* -- virtual lights ------------------------------------------------------------ */

/* The light of one virtual light at a shading point, of which more is said below. */
typedef enum ylm_shade_gather_method {
  YLM_SHADE_HVL, /* its harmonics, to lmax, times the cosine's */
  YLM_SHADE_VPL, /* a point */
  YLM_SHADE_VSL, /* a sphere */
  YLM_SHADE_VSGL /* groups of lights, each a spherical Gaussian of places and one of directions */
} ylm_shade_gather_method;

/* The bound c of a point's light: of 1/d^2, of c_x c_y/d^2, or of f c_x c_y/d^2, f being the luminance of
   the receiver's albedo over pi. */
typedef enum ylm_shade_clamp {
  YLM_SHADE_CLAMP_NONE,
  YLM_SHADE_CLAMP_DISTANCE,
  YLM_SHADE_CLAMP_GEOMETRY,
  YLM_SHADE_CLAMP_WHOLE
} ylm_shade_clamp;

/* Directions to a sphere: of the cone that it fills; by the receiver's cosine; these, and the light's
   cosine, weighed by the balance heuristic. */
typedef enum ylm_shade_sphere_strategy {
  YLM_SHADE_CONE,
  YLM_SHADE_RECEIVER,
  YLM_SHADE_MIS
} ylm_shade_sphere_strategy;

/* Lights at the receiver's horizon: as they are; weighed by a smooth step of their angle above it, over
   their own half angle (the paper's Eq. 22); none that is below it with its whole radius. */
typedef enum ylm_shade_horizon {
  YLM_SHADE_HORIZON_NONE,
  YLM_SHADE_HORIZON_PAPER,
  YLM_SHADE_HORIZON_GATE
} ylm_shade_horizon;

/* Lights that a point asks: all; those of one pixel of a tile, and then the mean over such a tile; few, by chance. */
typedef enum ylm_shade_subset {
  YLM_SHADE_ALL,
  YLM_SHADE_INTERLEAVED,
  YLM_SHADE_STOCHASTIC
} ylm_shade_subset;

typedef struct ylm_shade_gather_options {
  ylm_shade_gather_method method;
  ylm_shade_subset subset;
  int tile; /* INTERLEAVED: pixels a side, 2 .. YLM_SHADE_TILE */
  double
      alpha; /* STOCHASTIC: W m^-2, 0: one of which about YLM_SHADE_KEPT lights of a point are kept */
  int lmax;                  /* HVL: 0 .. YLM_SHADE_GATHER_LMAX */
  const double *window;      /* HVL: [lmax+1] factors of the receiver's coefficients; NULL: 1 */
  ylm_shade_horizon horizon; /* HVL */
  bool zonal; /* HVL: lobes of surfaces that gloss are circular about an axis, above a matte base */
  bool matte; /* surfaces that gloss reflect as matte ones of their mean albedo */
  ylm_shade_clamp clamp; /* VPL */
  double limit;          /* c, > 0 */
  int compensate;        /* VPL, clamped: rays of a point that find what the bound takes away; 0 */
  int bounces;           /* of these: reflections that the lights stand for, 1 .. */
  int samples;           /* VSL: 1 .. YLM_SCENE_SAMPLES */
  size_t groups;         /* VSGL: 1 .., at most as many as lights */
  ylm_shade_sphere_strategy strategy;
  bool shadows; /* a ray from the point to the middle of each light */
  uint64_t seed;
  int threads;
  const ylm_progress *progress;
} ylm_shade_gather_options;

#define YLM_SHADE_GATHER_LMAX 100
#define YLM_SHADE_TILE 16
#define YLM_SHADE_KEPT 64

typedef struct ylm_shade_gather_report {
  uint64_t pairs, rays; /* pairs that were asked; of STOCHASTIC also those that were left out */
  uint64_t
      singular; /* pairs of a point and a light without size at the same place: they count as nothing; not of INTERLEAVED */
  uint64_t lights; /* that were asked; of VSGL groups */
  uint64_t kept;   /* pairs; all but of STOCHASTIC */
  double alpha;
  double seconds;
} ylm_shade_gather_report;

/*
** ylm_shade_gather_virtual - radiance of every shading point under virtual lights, each asked at each.
**
** y, n, r are a light's place, normal and radius, I its intensity, N the receiver's normal. d and w
** are distance and direction from x to y; c_x = max(0, N.w), c_y = max(0, s - n.w)
** (ylm_light_virtual.h). The irradiance is the sum over lights of
**
**   HVL  I c_y sum over l of a_l (2l+1)/(4 pi) G_l P_l(N.w)     a_l of the clamped cosine
**   VPL  I c_x c_y / d^2, bounded
**   VSL  I/(pi r^2) times the integral of max(0, N.w') max(0, s - n.w') over the cone of half angle
**        asin(r/d) about w; within r the hemisphere. max(4, samples (1 - cos)) directions, of RECEIVER
**        `samples`
**
** VSGL parts the lights into groups where they are widest in place and direction. A group of power P, mean place m, deviation
** s of places, axis a and sharpness k of directions sends L(w') = P/(2 pi s^2) g(w'; w, d^2/s^2) g(-w'; a, k)/A(k), d and w
** from x to m, g(w; a, k) = e^(k (w.a - 1)), A its integral; a light's own radius r counts as the deviation r/2. Surfaces that
** gloss have a Gaussian lobe, of the power and the mean direction of f above its least value.
**
** INTERLEAVED: the point's pixel has the place i in a tile of tile x tile pixels, and asks lights
** i, i + tile^2, ..; the irradiance is tile^2 times their sum. A mean over the tile of pixels
** around follows; points on the same mesh whose normals are within 20 degrees count. STOCHASTIC: a
** light whose unshadowed light b (of VSL 2I/max(d^2, 2r^2)) is below alpha is kept with the chance
** b/alpha and counts alpha/b times; lights of a point are chosen by equal steps along the sum of b,
** from a start that is random. Its mean is that of all lights, its standard deviation at most
** sqrt(alpha E) by independent choices. Points that gloss ask all lights where they are
** interleaved.
**
** Compensation: rays from x as the cosine meet y'; what the bound took from the light that y' reflects,
** L f max(0, G - c)/G, is added (ylm_path_places has L). With shadows, the mean is that of no bound.
** On a surface that glosses f, of the direction to the eye, stands in place of albedo/pi:
**
**   HVL  I c_y sum over l, m of F_lm G_l Y_lm(w), F of f cos in harmonics to lmax, in the frame of the view
**        zonal: I c_y c_x sum over l of z_l G_l P_l(a.w), a and z of f less its least value, for which the cosine's
**        harmonics stand as on matte surfaces
**   VPL  I f c_x c_y / d^2; VSL: the integral of f times both cosines; RECEIVER: directions of the material
**
**   out  out  [points][3]
**
** Returns  YLM_OK; YLM_ERANGE (an option; lmax above YLM_MATERIAL_TABLE_LMAX, where surfaces gloss), YLM_EINVAL (compensation without a bound), YLM_ENOMEM,
**          YLM_ECANCELLED (progress stages "virtual lights", "compensation")
** Cost     a pair: HVL some ns (lmax 4, one core), VPL 1 ns, VSL some ns a direction (matte), 50 (gloss); a ray with shadows; tables of
**          materials that gloss, which they keep
** Source   Mezieres & Paulin 2022; Keller 1997, "Instant Radiosity"; Kollig & Keller 2004,
**          "Illumination in the Presence of Weak Singularities"; Tokuyoshi 2015, "Virtual Spherical
**          Gaussian Lights for Real-time Glossy Indirect Illumination"; Hasan et al. 2009, "Virtual Spherical
**          Lights for Many-Light Rendering of Glossy Scenes"; Keller & Heidrich 2001, "Interleaved Sampling"; Tokuyoshi &
**          Harada 2016, "Stochastic Light Culling"
*/
YLM_API ylm_status ylm_shade_gather_virtual(const ylm_shade_view *view,
                                            const ylm_light_virtual *lights,
                                            const ylm_shade_gather_options *o, float *out,
                                            ylm_shade_gather_report *report, ylm_error *e);

typedef struct ylm_shade_near_report {
  uint64_t pairs; /* of lights and points that were looked at */
  double seconds;
} ylm_shade_near_report;

/*
** ylm_shade_near - add to radiance what the near parts of virtual lights bring to every shading point.
**
** COSINE: matte points by irradiance; all by coefficients where some gloss. TRANSFER: by coefficients.
**
**   near      in      of profile near (ylm_light_virtual_split)
**   weight    in      what their light is multiplied by
**   lmax      in      of the light: that of the grid of the far parts; TRANSFER: that of the view instead
**   radiance  in out  [points][3]
**
** Returns  YLM_OK; YLM_EINVAL: another profile, or TRANSFER and the view has no transfer vectors; YLM_ERANGE (lmax, or
**          light beyond the range of float); YLM_ENOMEM, YLM_ECANCELLED (progress stage "near lights")
*/
YLM_API ylm_status ylm_shade_near(const ylm_shade_view *view, const ylm_light_virtual *near,
                                  ylm_shade_weight weight, int lmax, int threads,
                                  const ylm_progress *progress, float *radiance,
                                  ylm_shade_near_report *report, ylm_error *e);

/* Turns irradiance [points][3] of all shading points into the radiance that matte surfaces of their albedo send. */
YLM_API void ylm_shade_reflect(const ylm_shade_view *view, float *irradiance);

/*
** ylm_shade_blend_links - radiance of points that gloss by the light of elements. The points are
** those for which the degree of a light that holds its shadows (COSINE) is too low. w is as
** ylm_shade_blend has it, g as ylm_shade_gather finds it.
**
**   leaving   in      of the links' transfer: ylm_radiosity_leaving
**   lmax      in      of the light that harmonics were made of
**   known     in      share is that of ylm_shade_blend, and g is added: radiance + w g;
**                     false: (1 - w) radiance + w g
**   radiance  in/out  [points][3]
**   share     in/out  [points]: w; 0 of matte points
**
** Returns  YLM_OK; YLM_ERANGE (no tables have that degree), YLM_ENOMEM, YLM_ECANCELLED (progress stage "gathering")
*/
YLM_API ylm_status ylm_shade_blend_links(const ylm_shade_links *links, const float *leaving,
                                         int lmax, bool known, int threads,
                                         const ylm_progress *progress, float *radiance,
                                         float *share, ylm_shade_blended *report, ylm_error *e);

/* How a view's visibility differs from that of its scene, as light of the picture. */
typedef struct ylm_shade_occlusion {
  double passing; /* part of the view's light that occluders keep from the scene's surfaces */
  double missing; /* part of the light on the scene's surfaces that the view takes away     */
  double passing_error, missing_error; /* their standard errors */
  size_t points;                       /* shading points that were looked at */
  uint64_t rays;
  double seconds;
} ylm_shade_occlusion;

/*
** ylm_shade_measure_occlusion - how much light passes a view's occluders, and how much is missing.
**
** A view's visibility is by direction: whatever occludes within occlusion_distance darkens all
** lamps in its direction, nearer ones too, and what is farther none. Rays to the lamps, chosen as
** ylm_shade_raycast chooses them, are traced twice from each of some shading points: up to the lamp
** (V = 1: free) and up to occlusion_distance (M = 1: free; UNSHADOWED: always). A ray that is free
** brings the luminance c to the picture, weight of the point and albedo included:
**
**   passing = sum c M (1 - V) / sum c M        missing = sum c V (1 - M) / sum c V
**
** Both are 0 where there are no lamps or nothing occludes, and of a view by rays. Light that harmonics of the view's
** degree lose counts in neither.
**
**   points         in   how many shading points, spread evenly over the view's; at most all
**   light_samples  in   rays per point, 1 .. YLM_SCENE_SAMPLES
**   out            out  the same whatever the number of threads, but for `seconds`
**
** Returns  YLM_OK; YLM_ERANGE, YLM_ENOMEM
** Cost     points * (lamps + 2 light_samples rays)
** Source   docs/math.md "Shading"; Cochran 1977, "Sampling Techniques" (errors of ratios)
*/
YLM_API ylm_status ylm_shade_measure_occlusion(const ylm_shade_view *view, size_t points,
                                               int light_samples, int threads,
                                               ylm_shade_occlusion *out);

/* How the openness of a point is found. */
typedef enum ylm_shade_ambience {
  YLM_SHADE_SCREEN, /* 16 samples of the picture about the point's place in it, and their horizons */
  YLM_SHADE_AMBIENT_RAYS /* 128 rays, dense as the cosine */
} ylm_shade_ambience;

/*
** ylm_shade_ambient - the part of the light from everywhere that nothing keeps from a shading point.
**
**   a = 1/pi integral of cosine over directions in which nothing is nearer than `radius`
**
** SCREEN knows the surfaces that the camera sees: two slices through the line of sight with four samples
** on each side, turned and shifted from pixel to pixel, the mean of 4 x 4 pixels. Samples less than 0.05
** of their distance above the surface are the surface. The result is 1 where the radius is below a
** pixel.
**
**   radius  in   scene units, > 0
**   out     out  [points], 0 to 1
**
** Returns  YLM_OK; YLM_ERANGE (radius), YLM_EINVAL (a view per vertex; SCREEN: of some pixels alone),
**          YLM_ENOMEM, YLM_ECANCELLED (RAYS: progress stage "ambient")
** Source   Bavoil & Sainz 2008, "Screen Space Ambient Occlusion"; slices weighted by the cosine: Jimenez,
**          Wu, Pesce, Jarabo 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion"
*/
YLM_API ylm_status ylm_shade_ambient(const ylm_shade_view *view, ylm_shade_ambience method,
                                     double radius, int threads, const ylm_progress *progress,
                                     float *out);

/* -- image ------------------------------------------------------------------- */

/*
** ylm_shade_resolve - values at shading points to pixels: the mean over a pixel's samples.
**
**   channels  in   1 .. 4
**   values    in   [points][channels]
**   fill      in   [channels] or NULL (zeros): for the part of a pixel that shows no surface
**   covered   in   divide by the part that shows surface instead, so that edges keep the
**                  surface's value; pixels without any are `fill`
**   out       out  [height][width][channels]
*/
YLM_API ylm_status ylm_shade_resolve(const ylm_shade_view *view, int channels, const float *values,
                                     const float *fill, bool covered, int threads, float *out);

typedef enum ylm_shade_layer {
  YLM_SHADE_RADIANCE_OF_LAMPS, /* 3: what lamps in sight add to the pixel     */
  YLM_SHADE_DEPTH,             /* 1: along the view axis, infinity: nothing   */
  YLM_SHADE_COVERAGE,          /* 1: part of the pixel's samples that hit a mesh */
  YLM_SHADE_EMITTER,           /* 1: part that hit a lamp                     */
  YLM_SHADE_NORMAL,            /* 3: mean over the surface in sight, unit     */
  YLM_SHADE_POSITION,          /* 3: mean over the surface in sight           */
  YLM_SHADE_ALBEDO,            /* 3: mean over the surface in sight           */
  YLM_SHADE_OBJECT             /* 1: 1 + index of the mesh that has most of the pixel; 0: none */
} ylm_shade_layer;

/* The number of channels of a layer. */
YLM_API int ylm_shade_layer_channels(ylm_shade_layer layer);
/* Writes a layer: out [height][width][channels]. Normal, position and albedo are 0 and depth is
   infinite where no surface is in sight. */
YLM_API ylm_status ylm_shade_layer_write(const ylm_shade_view *view, ylm_shade_layer layer,
                                         int threads, float *out);

/* Radiance: shaded points resolved, plus lamps, plus `background` [3] where neither is seen.
   colours [points][3], out [height][width][3]. */
YLM_API ylm_status ylm_shade_compose(const ylm_shade_view *view, const float *colours,
                                     const float background[3], int threads, float *out);

/*
** ylm_shade_draw_lamps - draw spheres over an image of the view: lamps that are not in its scene.
**
** A lamp covers the part of a pixel by which the pixel's centre is inside of its rim. Surfaces that
** are nearer than the lamp's centre hide it. Farther lamps are drawn first.
**
**   out  in/out  [height][width][3]
*/
YLM_API ylm_status ylm_shade_draw_lamps(const ylm_shade_view *view, const ylm_scene_lamps *lamps,
                                        int threads, float *out);

/* -- bodies that move: bodies.c ---------------------------------------------------------------- */

/* A body at its place. A point p of the body's frame is at + scale rotation p. */
typedef struct ylm_shade_body {
  const ylm_shade_view *view; /* of the body alone, in its frame: options.all_vertices, matte, with
                                 transfer vectors, which know the body alone                   */
  double at[3], rotation[9], scale;
  const float *radiance; /* [points of view][3], for ylm_shade_draw_bodies                     */
} ylm_shade_body;

/*
** ylm_shade_body_field - radiance of a body's vertices where it stands: its transfer vectors, turned, times light there.
**
**   light  in   light without the body's own shadow (ylm_light_shadowed_without), asked for values at lmax of the
**               body's view, 3 channels, float
**   out    out  [points of the body's view][3]
**
** Returns  YLM_OK; YLM_EINVAL (the view is not such a one), YLM_EDOMAIN (its place), as ylm_shade_field
** Source   Sloan et al. 2002; Zhou et al. 2005
*/
YLM_API ylm_status ylm_shade_body_field(const ylm_shade_body *body, const ylm_field *light,
                                        int threads, const ylm_progress *progress, float *out,
                                        uint64_t *pairs, ylm_error *e);

/*
** ylm_shade_draw_bodies - draw bodies over an image of the view, by the camera rays that it was made with.
**
** A sample that meets a body covers its share of the pixel, less the part of the pixel that shows nearer surfaces of the
** view. Lamps of the view are behind bodies. Radiance is interpolated over triangles.
**
**   out   in/out  [height][width][3]
**   rays  out     that were traced, may be NULL
**
** Returns  YLM_OK; YLM_EINVAL, YLM_EDOMAIN as ylm_shade_body_field; YLM_ENOMEM
*/
YLM_API ylm_status ylm_shade_draw_bodies(const ylm_shade_view *view, size_t n,
                                         const ylm_shade_body *body, int threads, float *out,
                                         uint64_t *rays, ylm_error *e);

/* Depth of what such a picture shows: a lamp that covers more than half of a pixel writes its nearest
   depth where that is less than what stands there. depth in/out [height][width] of
   YLM_SHADE_DEPTH. YLM_ENOMEM. */
YLM_API ylm_status ylm_shade_lamp_depth(const ylm_shade_view *view, const ylm_scene_lamps *lamps,
                                        int threads, float *depth);

/* A lamp near a place of the image. */
typedef struct ylm_shade_lamp {
  size_t index; /* of the sphere */
  double away;  /* from its rim, pixels; 0: the place lies on it */
  double depth; /* of its centre, along the view axis */
} ylm_shade_lamp;

/* The lamp whose rim is nearest to place x, y of the image (pixels from its upper left corner; the
   first pixel's centre is 0.5, 0.5), at most `reach` pixels away; of several there that with the least depth.
   False: there is none, or surfaces hide it. No allocation. */
YLM_API bool ylm_shade_lamp_at(const ylm_shade_view *view, const ylm_scene_lamps *lamps, double x,
                               double y, double reach, ylm_shade_lamp *found);

/* The surface that has the largest part of a pixel. */
typedef struct ylm_shade_hit {
  float position[3], normal[3]; /* normal: unit, on the side that is seen */
  float depth;                  /* along the view axis */
  uint32_t object;              /* index of the mesh */
} ylm_shade_hit;

/* Looks at the pixel of column x and row y, from 0. False: no surface, or no such pixel. */
YLM_API bool ylm_shade_view_hit(const ylm_shade_view *view, int x, int y, ylm_shade_hit *hit);

/* -- what pictures are made of, for those that make them elsewhere --------------- */

/* An entry is a part of a pixel: a shading point or, with a view per vertex, a place on a triangle
   between three of them. Either array may be NULL. */
typedef struct ylm_shade_entries {
  double *first; /* [pixels + 1]    of each pixel's entries                                */
  float *shown;  /* [pixels][4]     what lamps in sight add; the background's share        */
  float *weight; /* [entries]       share of the pixel                                     */
  float *depth;  /* [entries]       along the view axis                                    */
  double *point; /* [entries][3]    per vertex: shading points; else entry i is point i    */
  float *part;   /* [entries][3]    per vertex: their weights                              */
} ylm_shade_entries;

/* Writes them and returns their number; `out` NULL: the number alone. */
YLM_API size_t ylm_shade_view_entries(const ylm_shade_view *view, const ylm_shade_entries *out);
/* Right, up and forward: a pixel is seen in the direction forward + x right + y up, x and y from -1
   to 1 over the image; the height of a pixel at distance 1. */
YLM_API void ylm_shade_view_camera(const ylm_shade_view *view, double out[10]);

#define YLM_SHADE_DISC 12

/* Spheres as ylm_shade_draw_lamps draws them, the farthest first. A row has the direction to a
   sphere [3], its depth, the chord of half the angle it fills, and its radiance [3]. The box x0,
   x1, y0, y1 of its pixels (x0 <= x < x1) ends the row. disc
   [lamps->shape.spheres][YLM_SHADE_DISC]; *n: how many are in sight. */
YLM_API ylm_status ylm_shade_view_discs(const ylm_shade_view *view, const ylm_scene_lamps *lamps,
                                        double *disc, size_t *n);

#ifdef __cplusplus
}
#endif
#endif
