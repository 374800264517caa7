/*
** ylm_material.h - how surfaces reflect, as data, and as zonal coefficients.
**
** A material knows nothing of scenes, meshes or rays.
*/
#ifndef YLM_MATERIAL_H
#define YLM_MATERIAL_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/*
** A matte (Lambertian) surface: the same radiance in every direction.
**
** | field  | unit | range  | meaning                                        |
** | ------ | ---- | ------ | ---------------------------------------------- |
** | albedo | 1    | 0 .. 1 | reflected over incident flux, linear Rec. 709  |
**
** Radiance leaving it is albedo / pi times irradiance.
**
**     matte { albedo = { 0.63, 0.06, 0.05 } }
*/
typedef struct ylm_material {
  float albedo[3];
} ylm_material;

/* The highest degree of ylm_material_cosine. */
#define YLM_MATERIAL_LMAX 1000

/* YLM_OK, or YLM_EDOMAIN naming the channel where an albedo is not in 0 .. 1. */
YLM_API ylm_status ylm_material_check(const ylm_material *m, ylm_error *e);

/*
** ylm_material_cosine - zonal coefficients of the clamped cosine.
**
**   a[l] = 2 pi * integral of t P_l(t) over 0 <= t <= 1
**
** so that max(0, n.s) = sum over l, m of a[l] Y_lm(n) Y_lm(s), and the irradiance of a surface
** with normal n under a light field L is the sum of a[l] L_lm Y_lm(n).
**
**   lmax  in   0 .. YLM_MATERIAL_LMAX
**   a     out  [lmax+1]   sr
**
** Returns  YLM_OK; YLM_ERANGE (lmax)
** Accuracy 4e-16 relative (lmax 20)
** Cost     O(lmax), no allocation, thread-safe
** Source   Ramamoorthi & Hanrahan 2001, "An Efficient Representation for Irradiance Environment
**          Maps", Eq. 7; here as the recurrence a[l+2] = -a[l] (l-1)/(l+4) of even l
*/
YLM_API ylm_status ylm_material_cosine(int lmax, double *a);

#ifdef __cplusplus
}
#endif
#endif
