/*
** ylm_path.h - the judge: light along paths of any length, sampled, with its variance.
**
**   ylm_path_image       pictures of a scene
**   ylm_path_probe       spherical harmonics of the light that arrives at points in space
**   ylm_path_irradiance  the light that arrives at surfaces
**
** Estimates are unbiased: nothing is clamped. Places of reflection are lit by rays to the lamps and by
** rays that the material or a guide chooses, weighed by the balance heuristic; paths go on until Russian roulette
** ends them.
**
** Light      lamps never occlude, flat ones emit to both sides, horizons hold; a mesh that does not
**            occlude is seen by the camera alone. Two-sided surfaces, normals as ylm_scene.h has them:
**            what a normal of vertices would send below the triangle is absorbed there.
** Orders     a reflection of order 0 is light that comes straight from lamps; 1 is direct light on
**            surfaces, 2 the first bounce.
** Threads    results do not depend on their number, bit for bit.
** Source     Kajiya 1986, "The Rendering Equation"; Veach & Guibas 1995, "Optimally Combining
**            Sampling Techniques for Monte Carlo Rendering"; Arvo & Kirk 1990, "Particle Transport
**            and Image Synthesis"
*/
#ifndef YLM_PATH_H
#define YLM_PATH_H

#include "ylm_scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Samples come in batches of this many, stratified in themselves: variance is that among batches. */
#define YLM_PATH_BATCH 16
/* The most samples of a pixel or point. */
#define YLM_PATH_SAMPLES (1 << 28)
/* The highest degree of a probe. */
#define YLM_PATH_LMAX 20

/* Rays that light is found by: to lamps and by material, weighed; or one kind alone. */
typedef enum ylm_path_strategy {
  YLM_PATH_BOTH,
  YLM_PATH_LIGHTS,
  YLM_PATH_MATERIAL
} ylm_path_strategy;

/* Knowledge that the pilot of an estimate leaves for more of them, of the same scene: they have no pilot, unless it would be far
   larger. */
typedef struct ylm_path_guides ylm_path_guides;
/* Nothing learnt yet; NULL without memory. */
YLM_API ylm_path_guides *ylm_path_guides_create(void);
YLM_API void ylm_path_guides_free(ylm_path_guides *g);

typedef struct ylm_path_options {
  int samples;     /* of each pixel or point, 1 .. YLM_PATH_SAMPLES; rounded up to whole batches */
  bool single;     /* one batch is enough, of which no variance is known; else two are the least */
  int first, last; /* orders that count, first >= 0; last < 0: without end */
  ylm_path_strategy strategy;
  double error;   /* > 0: ends early, once the noise (see ylm_path_stats) is at most this */
  double seconds; /* > 0: ends early, after so long */
  bool
      guides; /* a pilot learns what is seen (ylm_scene_guide), and where reflected light comes from */
  ylm_path_guides *
      kept; /* gets what it learns, or holds that of an estimate before; NULL: nothing is kept. For one caller at a
                            time, as long as the scene is as it was: YLM_EINVAL with another one */
  uint64_t seed;
  int threads;
  const ylm_progress *progress;
} ylm_path_options;

/* Estimates of [items][values] numbers: mean + rest, and the variance of that mean. An estimate goes on
   from what stands here, bit for bit as if it had not been interrupted; samples = 0 begins. */
typedef struct ylm_path_sum {
  uint64_t samples; /* of each item, so far: whole batches */
  float *mean, *rest;
  float *variance; /* 0 where there is one batch alone, of which it is not known */
} ylm_path_sum;

typedef struct ylm_path_stats {
  uint64_t paths, nearest_rays, lamp_rays, shadow_rays;
  uint64_t guide_rays; /* of the pilot, all of them */
  size_t clusters;     /* of the guide; 0: there is none */
  uint64_t absorbed;   /* paths that a normal of vertices sent below the surface */
  uint64_t lost;       /* contributions that were no finite numbers */
  double noise; /* mean over items of the root of summed variances over the norm; -1: not known */
  double seconds;
  enum {
    YLM_PATH_DONE,
    YLM_PATH_PRECISE,
    YLM_PATH_LATE
  } end; /* why it ended: samples, error, seconds */
} ylm_path_stats;

/*
** ylm_path_image - a picture of a scene.
**
**   background  in      [3] seen where a ray of the camera hits nothing and no sky is seen, order 0
**   sum         in/out  [height][width][3], W sr^-1 m^-2
**
** Returns  YLM_OK; YLM_EINVAL (the camera), YLM_ERANGE (an option), YLM_ENOMEM, YLM_ECANCELLED
** Cost     O(pixels samples paths' lengths (rays + lamps)), with more than 4,096 lamps as with few
*/
YLM_API ylm_status ylm_path_image(const ylm_scene *scene, const ylm_camera *camera, int width,
                                  int height, const float background[3], const ylm_path_options *o,
                                  ylm_path_sum *sum, ylm_path_stats *stats, ylm_error *e);

/*
** ylm_path_probe - spherical harmonics of the radiance that arrives at points in space.
**
**   points  in      [n][3]                    finite
**   lmax    in      0 .. YLM_PATH_LMAX
**   sum     in/out  [n][3][(lmax+1)^2]        W sr^-1/2 m^-2
*/
YLM_API ylm_status ylm_path_probe(const ylm_scene *scene, size_t n, const float (*points)[3],
                                  int lmax, const ylm_path_options *o, ylm_path_sum *sum,
                                  ylm_path_stats *stats, ylm_error *e);

/*
** ylm_path_irradiance - irradiance of surfaces.
**
**   points   in      [n][3]  finite
**   normals  in      [n][3]  any length but 0
**   sum      in/out  [n][3]  W m^-2
*/
YLM_API ylm_status ylm_path_irradiance(const ylm_scene *scene, size_t n, const float (*points)[3],
                                       const float (*normals)[3], const ylm_path_options *o,
                                       ylm_path_sum *sum, ylm_path_stats *stats, ylm_error *e);

/*
** ylm_path_places - radiance that leaves places of surfaces towards an eye.
**
**   places   in      [n], or of first[n]
**   first    in      [n+1]   places first[i] .. first[i+1]-1 are one item: each sample is at one of them,
**                            weight [first[n]] says how often; NULL: an item is a place
**   eye      in      [3]     where they are seen from
**   shadows  in      false: nothing is in the way of light, and it is reflected once
**   sum      in/out  [n][3]  W sr^-1 m^-2; of order 1 at least
*/
YLM_API ylm_status ylm_path_places(const ylm_scene *scene, size_t n, const ylm_scene_place *places,
                                   const size_t *first, const float *weight, const double eye[3],
                                   bool shadows, const ylm_path_options *o, ylm_path_sum *sum,
                                   ylm_path_stats *stats, ylm_error *e);

/* Adds estimates of all n numbers of a sum as one batch. */
YLM_API void ylm_path_add(ylm_path_sum *sum, size_t n, const float *values);

#ifdef __cplusplus
}
#endif
#endif
