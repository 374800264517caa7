/* ylm_rival.h - libylm_rival.so: methods that exist to be compared with (ylm_sh_rival.h, ylm_material_rival.h). */
#ifndef YLM_RIVAL_H
#define YLM_RIVAL_H

#include "ylm_base.h"

struct ylm_shade_rival; /* ylm_shade_rival.h */

#ifdef __cplusplus
extern "C" {
#endif

/*
** Makes the library's methods known to ylm_sh_eval_how ("polynomial", "direct", "sloan", "scd"),
** ylm_sh_product_create ("fourier", "brute", "list") and ylm_material_rival_nearest, for the life of
** the process. May be called again, and from any thread.
*/
YLM_API void ylm_rival_register(void);

/*
** The library's ways to ask virtual lights (ylm_shade_bounce.h): for ylm_shade_rival_set of libylm_scene.so, which this
** library is not linked with.
*/
YLM_API const struct ylm_shade_rival *ylm_rival_many(void);

/* Points that gloss, and lobes of their materials, for ylm_rival_zonal. */
typedef struct ylm_rival_points {
  size_t n;
  const float (*position)[3], (*normal)[3]; /* [n]; normals of length 1 */
  const float *lobe; /* [n] place in `zonal`, from 0; below 0: out is left as it is */
  double eye[3];
  int lmax;           /* 0 .. 60 */
  size_t lobes, rows; /* rows: of elevation, from 0 to 90 degrees, 2 at least */
  const double
      *zonal; /* [lobes][rows][3][lmax+1] of the material f, about the mirror image of the view */
} ylm_rival_points;

typedef struct ylm_rival_lamps {
  size_t n;
  const float *at, *radius, *radiance; /* [n][3], [n], [n][3] */
} ylm_rival_lamps;

/*
** ylm_rival_zonal - radiance of points under sphere lights, light and material both being zonal.
**
**   out[i] = sum over lamps j of L_j max(0, n.d) sum over l of z_l w_l (2l+1)/(4 pi) P_l(r.d)
**
** d points towards the middle of lamp j, r is the mirror image of the direction to the eye. z is of
** the material at its elevation, linear between rows; w has the zonal coefficients of a sphere of
** radiance 1. The cosine is that of the lamp's middle: the approximation. Nothing occludes.
**
**   out  in/out  [n][3]
**
** Returns  YLM_OK; YLM_ERANGE (lmax, rows, a lobe that is not there)
** Cost     n * lamps * lmax
** Source   Mezieres, Desrichard, Vanderhaeghe, Paulin 2022; gradient-spherical-lights-2022, Table 4
*/
YLM_API ylm_status ylm_rival_zonal(const ylm_rival_points *p, const ylm_rival_lamps *lamps,
                                   int threads, float *out);

#ifdef __cplusplus
}
#endif
#endif
