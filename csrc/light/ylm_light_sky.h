/*
** ylm_light_sky.h - skies: what rays see of light from infinity that fills the sky, for scenes.
**
** The light field of an environment is a sum of harmonics (csrc/light/distant/environment.c). A panorama
** is what rays see of one that is more than that: an image of the whole sphere, or a sky of the CIE.
**
** A dome is light that fills the sky, as one thing to be sampled. A set has one for each panorama,
** and one for all environments that were packed together.
*/
#ifndef YLM_LIGHT_SKY_H
#define YLM_LIGHT_SKY_H

#include "ylm_base.h"
#include "ylm_image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_light_set ylm_light_set; /* ylm_light.h */

/* -- skies of the CIE: csrc/light/distant/cie.c ------------------------------------------------ */

/* Skies of the CIE: their names and the constants a, b, k, c, e of ylm_light_cie_luminance. */
#define YLM_LIGHT_CIE_LIST(X)                                                                      \
  X(overcast, 0, 0, 0, 0, 0)                                                                       \
  X(clear, 0.91, 10, -3, 0.45, -0.32)                                                              \
  X(partly_cloudy, 0.526, 5, -1.5, 0, -0.8)

typedef enum ylm_light_cie_kind {
#define X(name, a, b, k, c, e) YLM_LIGHT_CIE_##name,
  YLM_LIGHT_CIE_LIST(X)
#undef X
} ylm_light_cie_kind;

typedef struct ylm_light_cie {
  ylm_light_cie_kind kind;
  double zenith[3], sun[3]; /* of length 1; overcast skies know no sun */
  double luminance;         /* at the zenith */
} ylm_light_cie;

/*
** ylm_light_cie_luminance - the luminance of a sky in a direction d of length 1.
**
** With t the angle to the zenith, g that to the sun and s that between these,
**
**   overcast   (1 + 2 cos t)/3
**   others     (f(g) h(t)) / (f(s) h(0)),  f(g) = a + b exp(k g) + c cos^2 g,
**                                          h(t) = 1 - exp(e / cos t)
**
** times the luminance at the zenith; 0 below the horizon.
**
** Source  Green 2003, "Creating Light Sources" (cos t in 'partly cloudy', misprinted there)
*/
YLM_API double ylm_light_cie_luminance(const ylm_light_cie *sky, const double d[3]);

/* -- panoramas: csrc/light/distant/panorama.c -------------------------------------------------- */

typedef struct ylm_light_panorama {
  int width, height;
  const float
      *texel; /* [height][width][3], the top row first; W sr^-1 m^-2. NULL: a sky of the CIE */
  ylm_mapping mapping;
  ylm_up up;
  ylm_light_cie cie;
  double scale; /* multiplies it */
} ylm_light_panorama;

/* Whether an image may be a panorama: YLM_ESHAPE (of another shape than its mapping's), YLM_EDOMAIN
   (a texel is negative or not finite); `e` names the pixel, counted from 1. */
YLM_API ylm_status ylm_light_panorama_check(const ylm_light_panorama *p, ylm_error *e);
/*
** ylm_light_set_panorama - a set of the environment that a panorama is.
**
**   p        in   texels are copied
**   n        in   number of records
**   record   in   [n]  of kind "environment": its coefficients, the scale included
**
** Returns  YLM_OK; as ylm_light_panorama_check, ylm_light_set_create
*/
YLM_API ylm_status ylm_light_set_panorama(const ylm_light_panorama *p, size_t n,
                                          const double *const *record, ylm_light_set **set,
                                          ylm_error *e);

/* -- domes: csrc/light/distant/sky.c ----------------------------------------------------------- */

typedef struct ylm_light_dome {
  const ylm_light_panorama *panorama; /* NULL: environments, whose coefficients are all */
  bool uniform;                       /* radiance is the same in every direction */
  const void *pack;
} ylm_light_dome;

/* Dome i of the set, as long as that lives; false where there are no more. */
YLM_API bool ylm_light_set_dome(const ylm_light_set *set, size_t i, ylm_light_dome *out);
/* The radiance that comes from direction d of length 1. */
YLM_API void ylm_light_dome_radiance(const ylm_light_dome *dome, const double d[3], double rgb[3]);

#ifdef __cplusplus
}
#endif
#endif
