/*
** ylm_sh_exponential.h - approximate exponentials, and logarithms of circles: products of many bodies' visibilities as
** exponentials of sums (SHEXP), to compare with.
**
** A body that is a sphere hides a circle. The logarithm of what the circle leaves open is a function of its half angle
** alone, turned to where it stands. With f^ = f less its coefficient f_00, and products cut off at lmax:
**
**   exp f = e^(f_00/sqrt(4 pi)) exp f^
**   PS    exp f^ = 1 + f^ + f^ f^/2 + ..                  so many terms
**   OL    exp f^ = a(|f^|) 1 + b(|f^|) f^                 a, b from circles of that |f^|
**   HYB   exp f^ = (OL of f^/2^q)^(2^q)                   |f^|/2^q <= YLM_SH_EXP_HALVED, or the largest |f^| of a circle
**
** Source  Ren et al. 2006; docs/shadow_fields.md
*/
#ifndef YLM_SH_EXPONENTIAL_H
#define YLM_SH_EXPONENTIAL_H

#include "ylm_sh.h"

#ifdef __cplusplus
extern "C" {
#endif

#define YLM_SH_EXP_METHOD_LIST(X) X(PS) X(OL) X(HYB)

typedef enum ylm_sh_exp_method {
#define X(name) YLM_SH_EXP_##name,
  YLM_SH_EXP_METHOD_LIST(X)
#undef X
      YLM_SH_EXP_METHOD_COUNT
} ylm_sh_exp_method;

#define YLM_SH_EXP_HALVED 4.8
#define YLM_SH_EXP_EPSILON 0.02

YLM_API const char *ylm_sh_exp_method_name(ylm_sh_exp_method m);

/*
** ylm_sh_circle_log - the logarithm of 1 outside of a circle about z, 0 inside.
**
** The matrix that multiplies by the function is taken apart by orders m. The function is of order 0 alone, so the
** block of order 0 gives its logarithm.
**
**   lmax     in   0 .. YLM_SH_PRODUCT_LMAX
**   angle    in   0 .. pi: half the angle of the circle
**   epsilon  in   as of ylm_sh_log
**   z        out  [lmax+1]: of Y(l, 0)
**
** Returns  YLM_OK; YLM_ERANGE (lmax), YLM_EDOMAIN (nothing is left open), YLM_ENOMEM
** Cost     O(lmax^3)
*/
YLM_API ylm_status ylm_sh_circle_log(int lmax, double angle, double epsilon, double *z,
                                     ylm_error *e);

/* Tables of one lmax: logarithms of circles of up to 90 degrees, a and b of OL. Immutable, to be shared. */
typedef struct ylm_sh_exponential ylm_sh_exponential;

/* YLM_ERANGE (lmax 0 .. YLM_SH_LOG_LMAX, terms 1 .. YLM_SH_EXP_TERMS), YLM_ENOMEM. `terms` is of PS. */
YLM_API ylm_status ylm_sh_exponential_create(int lmax, ylm_sh_exp_method m, int terms,
                                             ylm_sh_exponential **out, ylm_error *e);
YLM_API void ylm_sh_exponential_free(ylm_sh_exponential *p);
/* The largest |f^| of a circle, below which |f^| rises with the angle. */
YLM_API double ylm_sh_exponential_reach(const ylm_sh_exponential *p);
/* The table of logarithms at an angle (beyond 90 degrees: of 90), and its derivative by the angle, or NULL: [lmax+1]. */
YLM_API void ylm_sh_exponential_circle(const ylm_sh_exponential *p, double angle, double *z,
                                       double *slope);
/*
** ylm_sh_exponential_apply - exponentials of functions, and their derivatives, row by row.
**
**   derivatives  in   0 or 3
**   in, out           [n][1 + derivatives][(lmax+1)^2], not the same memory
**
** Returns  YLM_OK; YLM_ERANGE (a series that diverges: `e` names the row, counted from 1), YLM_ENOMEM, YLM_ECANCELLED
** Cost     of a row: PS terms - 1 products, OL none, HYB q products
*/
YLM_API ylm_status ylm_sh_exponential_apply(const ylm_sh_exponential *p, ylm_dtype t, size_t n,
                                            int derivatives, const void *in, void *out, int threads,
                                            const ylm_progress *progress, ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
