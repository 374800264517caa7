/*
** ylm_sh_rival.h - tables of functions for methods that exist to be compared with.
**
** A rival is a method that libylm.so itself does not use. Rivals stand in libylm_rival.so
** (csrc/rival), which hands its tables to ylm_sh_rivals_set.
** Until then ylm_sh_eval_how and ylm_sh_product_create answer YLM_EMISSING for their names.
*/
#ifndef YLM_SH_RIVAL_H
#define YLM_SH_RIVAL_H

#include "ylm_sh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -- evaluation ------------------------------------------------------------------------------- */

/* A call of ylm_sh_eval_how whose points have been checked: finite, and not zero unless solid. */
typedef struct ylm_sh_job {
  int lmax, derivatives;
  bool solid;
  ylm_dtype dtype; /* of points and results */
  const void *p;   /* [n][3] */
  void *y;         /* [n][(lmax+1)^2]; NULL: not wanted */
  void *dy, *ddy;  /* [n][(lmax+1)^2][3], [n][(lmax+1)^2][6]; NULL: not wanted */
} ylm_sh_job;

/*
** A way to evaluate the basis.
**   lmax         the highest degree
**   derivatives  the highest order of derivatives, 1 or 2
**   solid        whether it has solid harmonics too
**   scratch      bytes that each worker needs
**   points       evaluates points begin .. end-1
*/
typedef struct ylm_sh_rival_eval {
  int lmax, derivatives;
  bool solid;
  size_t (*scratch)(int lmax);
  void (*points)(const ylm_sh_job *job, size_t begin, size_t end, void *scratch);
} ylm_sh_rival_eval;

/* v = d * w with |w| = 1, without overflow or underflow; for v = 0, d = 0 and w = +z. */
YLM_API void ylm_sh_unit(const double v[3], double w[3], double *d);
/* From a solid harmonic of degree l at the unit vector w to the same at v = d w, or to Y at v:
   value s[0], gradient s[1..3], Hessian s[4..9]. */
YLM_API void ylm_sh_scale_solid(int l, double d, double s[10]);
YLM_API void ylm_sh_surface(int l, double d, const double w[3], double s[10]);

/* -- products --------------------------------------------------------------------------------- */

/*
** A way to multiply coefficient vectors of degree <= lmax.
**   create   tables for a size, immutable; YLM_ELIMIT, YLM_ENOMEM
**   free     accepts NULL
**   scratch  bytes that a product needs
**   apply    one product: c [factors][(lmax+1)^2] to out [(lmax+1)^2]; stage: see
**            ylm_sh_product_apply
*/
typedef struct ylm_sh_rival_product {
  ylm_status (*create)(int lmax, int factors, void **plan, ylm_error *e);
  void (*free)(void *plan);
  size_t (*scratch)(const void *plan, ylm_dtype t);
  void (*apply)(const void *plan, ylm_dtype t, const void *const *c, void *out, void *scratch,
                double *stage);
} ylm_sh_rival_product;

/* -- registration ---------------------------------------------------------------------------- */

/*
** Makes rivals known for the life of the process: tables by method, NULL where libylm.so has it
** itself. Their targets must stay. May be called again, and from any thread.
*/
YLM_API void
ylm_sh_rivals_set(const ylm_sh_rival_eval *const eval[YLM_SH_METHOD_COUNT],
                  const ylm_sh_rival_product *const product[YLM_SH_PRODUCT_METHOD_COUNT]);

#ifdef __cplusplus
}
#endif
#endif
