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

#ifdef __cplusplus
extern "C" {
#endif

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

/*
** ylm_shade_judge_pixels - what paths say of the surfaces in a view's pixels: o.samples paths of each pixel begin at what its
** camera rays hit, in turn. Lamps in sight and what is behind surfaces are not in it.
**
**   radiance  out  [pixels][3]
**   variance  out  [pixels][3], or NULL; 0 where 16 paths or fewer cannot tell it
**
** Returns  YLM_OK; as ylm_path_places; YLM_EINVAL (shading points are vertices, or stand for several camera rays: share > 0)
*/
YLM_API ylm_status ylm_shade_judge_pixels(const ylm_shade_view *view, const ylm_path_options *o,
                                          float (*radiance)[3], float (*variance)[3],
                                          ylm_path_stats *stats, ylm_error *e);

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
                                  const double *window, int threads, const ylm_progress *progress,
                                  float *out, ylm_grid_report *report, ylm_error *e);

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

/* How rays are cast to lamps. */
typedef struct ylm_shade_casting {
  const ylm_scene
      *lit; /* whose lamps: the view's scene with others (ylm_scene_relight); NULL: its own */
  const ylm_scene_guide
      *guide;        /* learnt from these lamps: rays to lamps alone follow it; NULL: none do */
  int light_samples; /* shadow rays per shading point, 1 .. YLM_SCENE_SAMPLES */
  const float
      *rays; /* [points] of each point, whole numbers, 0: no light; NULL: all have light_samples */
  bool shadows; /* false: nothing is in the way */
  bool spread;  /* rays to lamps alone start from all over the point's part of the pixel */
  uint64_t seed;
  int threads;
  const ylm_progress *progress; /* stage "raycast" */
} ylm_shade_casting;

/*
** ylm_shade_guide - learns which lamps and tiles of the sky the points of a view see that are matte or have wide lobes: ylm_scene_guide_create.
**
**   o    in   its guide is not read; progress has the stage "guides"
**   out  out  NULL: nothing is to be guided
*/
YLM_API ylm_status ylm_shade_guide(const ylm_shade_view *view, const ylm_shade_casting *o,
                                   ylm_scene_guide **out);

/*
** ylm_shade_raycast - radiance of every shading point by sampling the lamps themselves.
**
** Each of `light_samples` strata chooses a lamp in proportion to (a bound of) its unshadowed
** luminous irradiance, times a factor of the guide, then a direction. The direction is uniform in the solid angle that the
** lamp fills; of disks, and triangles that fill little, it is that of a place uniform in area. A ray
** that starts at the point and ends at the lamp decides. No SH, no grid, no occlusion_distance.
** Surfaces with narrow lobes (ylm_material_excess) are lit by as many rays again that their material chooses,
** weighed by the balance heuristic (ylm_path_places), in batches of 16.
**
**   out   out  [points][3]
**   rays  out  shadow rays that were traced, may be NULL
**
** Returns  YLM_OK; YLM_ERANGE, YLM_ENOMEM, YLM_ECANCELLED; YLM_EINVAL: `lit` has other meshes, the guide
**          is of other lamps, or a view per vertex has surfaces that are not matte
** Cost     points * (lamps + light_samples rays)
** Source   Shirley, Wang, Zimmerman 1996, "Monte Carlo Techniques for Direct Lighting
**          Calculations"; Arvo 1995, "Stratified Sampling of Spherical Triangles";
**          Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences" (R2)
*/
YLM_API ylm_status ylm_shade_raycast(const ylm_shade_view *view, const ylm_shade_casting *o,
                                     float *out, uint64_t *rays);

/*
** ylm_shade_raycast_noise - the noise of ylm_shade_raycast at a shading point: the root mean square difference to another
** estimate, over the square root of 2 and over the mean, in luminance.
**
**   radiance  in   [points][3] what ylm_shade_raycast found by these options
**   noise     out  measured at one of 32 points, at 256 to 4,096; 0 where there is no light
**
** Returns  as ylm_shade_raycast
*/
YLM_API ylm_status ylm_shade_raycast_noise(const ylm_shade_view *view, const ylm_shade_casting *o,
                                           const float *radiance, double *noise);

/*
** ylm_shade_noise_around - the noise of the mean of two estimates, relative to the light around each pixel.
**
** It is half of the root mean square difference in luminance over 9 x 9 pixels around, over the mean of `all` there, of pixels
** that show surfaces and no lamp.
**
**   a, b, all  in   [height][width][3]
**   out        out  [height][width]
**
** Returns  YLM_OK; YLM_EINVAL: a view of some pixels; YLM_ENOMEM
*/
YLM_API ylm_status ylm_shade_noise_around(const ylm_shade_view *view, const float *a,
                                          const float *b, const float *all, int threads,
                                          float *out);
/* Rays that follow those of a pilot. Counts are in units of the pilot's, which every point has. */
typedef struct ylm_shade_plan {
  const float *noise; /* [height][width] of the pilot, ylm_shade_noise_around */
  double factor;      /* counts with the pilot's, over the noise of a pixel */
  double unit, least,
      most; /* rays of a point are the next whole number above `unit` times its count, from `least` to `most` */
} ylm_shade_plan;

/*
** ylm_shade_plan_rays - rays of points where the noise of a pilot is, and its weight beside them.
**
** Tiles of 32 x 32 pixels whose noise asks for less than half of `least` have none. The pilot's weight is that of a tile: it is
** nearly independent of the light of a point, so that weighted means stay unbiased.
**
**   rays    out  [points] whole numbers, or NULL
**   weight  out  [points] of the pilot's light, from 0 to 1; or NULL
**   sum     out  over pixels: the squared noise of the weighted mean; rays of a point on average
**
** Returns  YLM_OK; YLM_EINVAL: points are vertices, or pixels some of an image
** Source   Neyman 1934, "On the two different aspects of the representative method"
*/
YLM_API ylm_status ylm_shade_plan_rays(const ylm_shade_view *view, const ylm_shade_plan *p,
                                       float *rays, float *weight, double sum[2]);

/* Light that tells where shadows have edges, and the rays of points there. */
typedef struct ylm_shade_edges {
  const float *light, *all; /* [points][3] direct light, and all light */
  double unit, most;        /* rays of a point that `light` is of, and the most behind them */
} ylm_shade_edges;

/*
** ylm_shade_edge_rays - rays for points at edges of shadows, where a filter finds few points that are alike.
**
** The contrast of a point is the standard deviation of light over 5 x 5 pixels around, on its surface, over the mean of all light
** there. Where it is c times 1.5 of the mean over all points, and c^2 above 2, there are unit (c^2 - 1) rays more.
**
**   rays  out  [points] whole numbers: those of light that has not told them. Means then stay as they are
**   mean  out  of these
**
** Returns  YLM_OK; YLM_EINVAL: a view per vertex, or of some pixels; YLM_ENOMEM. Bits are the same for any number of threads
*/
YLM_API ylm_status ylm_shade_edge_rays(const ylm_shade_view *view, const ylm_shade_edges *o,
                                       int threads, float *rays, double *mean);

/* A picture, and layers that tell a filter where light may change: albedo and normal, NULL: not known. */
typedef struct ylm_shade_picture {
  int width, height;
  const float *radiance, *albedo, *normal; /* [height][width][3] */
} ylm_shade_picture;

/*
** ylm_shade_oidn - a picture without its noise, by Intel's Open Image Denoise.
**
** The library is opened at run time, as libOpenImageDenoise.so.2, .so.1 or .so, or as the environment's YLM_OIDN_LIBRARY.
**
**   picture  in   of high dynamic range; NULL: whether the library is there
**   out      out  [height][width][3]; not the picture's own
**
** Returns  YLM_OK; YLM_EMISSING: no such library; YLM_EDEVICE: what it says
** Source   its documentation, https://www.openimagedenoise.org
*/
YLM_API ylm_status ylm_shade_oidn(const ylm_shade_picture *picture, float *out, ylm_error *e);

/*
** ylm_shade_denoise - light of shading points without most of its noise: that of points around, in the picture.
**
** Irradiance is fitted, without albedo. A point counts by its distance in the picture, its distance from the other's plane,
** the angle of normals, and how far its light is from the other's beside their variances. In each half that is told by
** the other half, so that weights know nothing of the noise they take away. Planes are fitted to light in a disk, which reaches
** as far as leaves `noise`, and at most 18 pixels; points whose light has less noise stay as they are, as do surfaces that gloss.
** Sums of light over cells of pixels, 8 to 64 on a side, of surfaces that face alike, become those before the filter, as far as
** these are known: the filter moves light within cells.
**
** Light of rays that few points have met, and points around have not, is shared among the points of cells of 16 pixels.
**
**   half     in/out  [2][points][3] radiance by two halves of the rays, independent of each other
**   all      in      [points][3] all radiance there, of which `noise` is a part
**   bounced  in      it is light that bounces, of which no pixel has much more than those around it
**   noise    in      that may be left, > 0
**
** Half of the difference of the results tells their noise, and nothing of their bias.
**
** Returns  YLM_OK; YLM_EINVAL: a view per vertex, or of some pixels; YLM_ERANGE, YLM_ENOMEM, YLM_ECANCELLED (progress stage
**          "denoising"). Bits are the same for any number of threads
** Cost     some 3 s of a core for 1280 x 720 pixels and a kind of light; 180 bytes a point
** Source   Rousselle, Knaus & Zwicker 2012 (halves that filter each other); Moon, Carr & Yoon 2014 (fits of planes)
*/
YLM_API ylm_status ylm_shade_denoise(const ylm_shade_view *view, float *half[2], const float *all,
                                     bool bounced, double noise, int threads,
                                     const ylm_progress *progress);

/* Turns irradiance [points][3] of all shading points into the radiance that matte surfaces of their albedo send. */
YLM_API void ylm_shade_reflect(const ylm_shade_view *view, float *irradiance);

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

#ifdef __cplusplus
}
#endif
#endif
