/* slices.h - slices of points that gloss: the weight of light from every direction, in the world. Private. */
#ifndef YLM_SHADE_SLICES_H
#define YLM_SHADE_SLICES_H

#include "gloss.h"

/* The most points whose slices are made at once. */
#define YLM_SHADE_SLICES 256

/* Slices of points of one material. One thread uses it. */
typedef struct shade_slices {
  const ylm_shade_view *v;
  const shade_tables *t;
  const ylm_material_table *table; /* of the material           */
  size_t functions, count;         /* of it; (lmax+1)^2         */
  float *slice;                    /* [YLM_SHADE_SLICES][functions][count] */
  bool halves;                     /* of rows: m >= 0 alone     */
  float *row;                      /* [YLM_SHADE_SLICES][functions][..] */
} shade_slices;

/* The direction of the camera at point i of a view, in the frame of its surface, and the axes of the view there:
   columns x, y, normal, x in the plane of normal and view. */
void ylm__shade_look(const ylm_shade_view *v, size_t i, float wo[3], float frame[3][3]);
/* As that, with the tangent there; NULL: the material is isotropic. */
void ylm__shade_look_along(const ylm_shade_view *v, size_t i, const float *tangent, float wo[3],
                           float frame[3][3]);

/* For points of a view, by tables of one degree; NULL without memory. */
shade_slices *ylm__shade_slices(const ylm_shade_view *v, const shade_tables *t);
void ylm__shade_slices_free(shade_slices *x);

/* Slices that are made after the call are of the view's material k (ylm__shade_gloss_slot). */
void ylm__shade_slices_of(shade_slices *x, uint32_t k);

/*
** ylm__shade_slices_make - slices of n points of the material, towards the camera.
**
**   n      in   0 .. YLM_SHADE_SLICES
**   point  in   [n]  numbers of points of the view
**   V      in   [n]  their rows of visibility, [count] each; NULL: nothing occludes
**
** Result   x->slice, in the axes of the scene, times V
** Returns  YLM_OK; YLM_ENOMEM
*/
ylm_status ylm__shade_slices_make(shade_slices *x, size_t n, const size_t *point,
                                  const float *const *V);

/* Whether n points, whose coefficients are rows number[..] of l, have the same light, and slices that need not be
   made to be lit. */
bool ylm__shade_slices_shares(const shade_slices *x, const shade_light *l, size_t n,
                              const size_t *number);
/* As ylm__shade_slices_make, then radiance under light L [3][count] that all points share, without slices and without
   tints; out [n][3]. */
ylm_status ylm__shade_slices_shine(shade_slices *x, size_t n, const size_t *point,
                                   const float *const *V, const float *L, float (*out)[3]);

/* Radiance by slices from .. from + n - 1 under coefficients l->L of these points, [n][channels][..]; without
   tints; out [n][3]. */
void ylm__shade_slices_light(const shade_slices *x, ylm_shade_dot_fn *dot, size_t from, size_t n,
                             const shade_light *l, float *out);

#endif
