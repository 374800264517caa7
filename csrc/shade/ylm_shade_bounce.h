/*
** ylm_shade_bounce.h - light that the surfaces of a scene send to the shading points of a view.
**
**   ylm_shade_links            the elements of surfaces that points see: bounces as sums over links
**   ylm_shade_gather_virtual   virtual lights, each asked at each point
**   ylm_shade_surfaces         light that a surface grid holds
**   ylm_shade_near             the near parts of virtual lights, over a grid of the far ones
*/
#ifndef YLM_SHADE_BOUNCE_H
#define YLM_SHADE_BOUNCE_H

#include "ylm_shade_gloss.h"
#include "ylm_surface.h"
#include "ylm_transfer_targets.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_light_virtual ylm_light_virtual; /* ylm_light_virtual.h */
struct ylm_shade_rival;                             /* ylm_shade_rival.h */

/* -- links -------------------------------------------------------------------- */

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
** Cost       points * links rays; 2 bytes a link or 4 (ylm_links), 10 of points that gloss
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

/* The most links of a set. */
enum { YLM_SHADE_SET = 32 };

/* Sets of links that are found one after the other. */
typedef struct ylm_shade_sets {
  const ylm_transfer *transfer;
  const ylm_transfer_targets
      *targets; /* by which half of the links are aimed, where they are an even number; or NULL */
  const float *leaving; /* ylm_radiosity_leaving */
  int links;            /* of a set, a multiple of 4 up to YLM_SHADE_SET */
  const float *sets;    /* [points] how many sets each point has, whole numbers */
  bool all;             /* points that gloss have links too, as matte ones */
  uint64_t seed;
  int threads;
  const ylm_progress *progress; /* stage "links" */
} ylm_shade_sets;

/*
** ylm_shade_gather_sets - as ylm_shade_gather, along sets of links that are found one after the other and not kept.
**
** Links of matte points go as the cosine, those of points that gloss as their materials choose.
**
**   half  out  [2][points][3] the light by sets of even and of odd number; 0 where there is none of them
**   rays  out  links of all sets
**
** Returns  YLM_OK; YLM_ERANGE (links), YLM_ENOMEM, YLM_ECANCELLED. Bits are the same for any number of threads
*/
YLM_API ylm_status ylm_shade_gather_sets(const ylm_shade_view *view, const ylm_shade_sets *o,
                                         float *half[2], uint64_t *rays, ylm_error *e);

/* ylm_transfer_targets_create for the points of a view whose light is not that of a narrow lobe. */
YLM_API ylm_status ylm_shade_targets(const ylm_shade_view *v, const ylm_transfer *t,
                                     const float *leaving, uint64_t seed, int threads,
                                     const ylm_progress *progress, ylm_transfer_targets **out);

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

/* -- light on surfaces ---------------------------------------------------------- */

/*
** ylm_shade_surfaces - what a surface grid holds at the shading points of a view of its scene.
**
**   irradiance  out  [points][3], W m^-2; ylm_shade_reflect makes radiance of it
**   rectangle   out  [points] or NULL: the number of the rectangle, UINT32_MAX: none
**
** Returns  YLM_OK; YLM_EINVAL (the view's points are vertices), YLM_ENOMEM. Nothing is traced
*/
YLM_API ylm_status ylm_shade_surfaces(const ylm_shade_view *view, const ylm_surface_grid *g,
                                      int threads, float (*irradiance)[3], uint32_t *rectangle,
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
** Methods but HVL, and INTERLEAVED, are those of libylm_rival.so (ylm_shade_rival_set).
**
** Returns  YLM_OK; YLM_ERANGE (an option; lmax above YLM_MATERIAL_TABLE_LMAX, where surfaces gloss), YLM_EINVAL (compensation
**          without a bound), YLM_EMISSING (a method of libylm_rival.so), YLM_ENOMEM, YLM_ECANCELLED (progress stages
**          "virtual lights", "compensation")
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

/* Makes the methods that ylm_rival_many answers known for the life of the process. May be called again, and from any thread. */
YLM_API void ylm_shade_rival_set(const struct ylm_shade_rival *rival);

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

#ifdef __cplusplus
}
#endif
#endif
