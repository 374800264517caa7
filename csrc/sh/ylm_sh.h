/*
** ylm_sh.h - spherical harmonics: evaluation, with first and second derivatives.
**
** Convention  real, orthonormal, with the Condon-Shortley phase: Y(1,1) = -sqrt(3/4pi) x.
**             Coefficient k = l*(l+1)+m for degree l, -l <= m <= l; count (lmax+1)^2.
** Derivatives of Y are those of Y(v/|v|) at v, exact wherever v is not zero, poles included;
**             of the solid harmonics S_lm(v) = |v|^l Y_lm(v/|v|), polynomials, anywhere.
** Hessians    six numbers: xx xy xz yy yz zz.
*/
#ifndef YLM_SH_H
#define YLM_SH_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The highest degree that is supported (float above 128 is computed in double). */
#define YLM_LMAX 1000

static inline size_t ylm_sh_count(int lmax) { return ((size_t)lmax + 1) * ((size_t)lmax + 1); }
static inline size_t ylm_sh_index(int l, int m) { return (size_t)(l * (l + 1) + m); }

/* Conventions of coefficient arrays (ylmL_array.convention); the list grows in convert.c. */
#define YLM_SH_NATIVE 0

/*
** The ways to evaluate. All but the first are kept for comparison; they are scalar, and those
** that divide by sin(theta) give NaN in derivatives where x = y = 0.
**   solid       Cartesian recurrences and ladders, vectorised, exact everywhere
**   polynomial  explicit polynomials in x, y, z; lmax <= 6
**   direct      Mezieres et al. 2022, "Direct": (theta, phi), Eq. 19; derivatives <= 1
**   sloan       Mezieres et al. 2022, "Sloan's like": (theta, phi), Eq. 22; derivatives <= 1
**   scd         spherical-coordinate derivatives with Hessian, compared with in Iwasaki & Dobashi 2025
*/
#define YLM_SH_METHOD_LIST(X) X(solid) X(polynomial) X(direct) X(sloan) X(scd)

typedef enum ylm_sh_method {
#define X(name) YLM_SH_##name,
  YLM_SH_METHOD_LIST(X)
#undef X
  YLM_SH_METHOD_COUNT
} ylm_sh_method;

/*
** ylm_sh_eval - evaluate every basis function of degree <= lmax at n points.
**
**   y[i][k] = Y_k(p[i] / |p[i]|),   k = l*(l+1)+m
**
**   lmax         in   0 .. YLM_LMAX
**   derivatives  in   0 .. 2: how many of y, dy, ddy are wanted
**   solid        in   solid harmonics |p|^l Y instead; then points may be zero
**   t            in   element type of points and results
**   n            in   number of points; 0 writes nothing
**   p            in   [n][3]                 finite, any length but 0
**   y            out  [n][(lmax+1)^2]        sr^-1/2; may be NULL if not wanted
**   dy           out  [n][(lmax+1)^2][3]     per unit of p; may be NULL if derivatives < 1
**   ddy          out  [n][(lmax+1)^2][6]     per unit of p squared; NULL if derivatives < 2
**   threads      in   0: the default
**
** Returns  YLM_OK; YLM_ERANGE (lmax; |p|^lmax of a solid harmonic or 1/|p|^derivatives is not
**          representable), YLM_EDOMAIN (a zero or non-finite point): nothing is written then;
**          YLM_ENOMEM
** Accuracy relative to the largest of its degree: 1e-13 (double), 4e-6 (float), poles included
** Cost     O(n lmax^2); thread-safe; results do not depend on the number of threads
** Source   Iwasaki & Dobashi 2025, Eqs. 10-14, 17; docs/math.md "Evaluating the basis"
*/
YLM_API ylm_status ylm_sh_eval(int lmax, int derivatives, bool solid, ylm_dtype t, size_t n,
                               const void *p, void *y, void *dy, void *ddy, int threads,
                               ylm_error *e);

/* How to evaluate, where the default will not do. */
typedef struct ylm_sh_how {
  int derivatives;
  bool solid;
  ylm_sh_method method;
  int isa;     /* a ylm_isa that is available, or -1: ylm_isa_current() */
  int threads; /* 0: the default */
  const ylm_progress *progress;
} ylm_sh_how;

/* ylm_sh_eval with every choice open. Comparison methods: YLM_ERANGE beyond their lmax or
   derivatives, YLM_EINVAL with solid (all but "polynomial"). */
YLM_API ylm_status ylm_sh_eval_how(const ylm_sh_how *how, int lmax, ylm_dtype t, size_t n,
                                   const void *p, void *y, void *dy, void *ddy, ylm_error *e);

YLM_API const char *ylm_sh_method_name(ylm_sh_method m);

/*
** ylm_sh_reconstruct - the functions that coefficients stand for, at points.
**
**   out[r][i] = sum_k c[r][k] Y_k(p[i] / |p[i]|)
**
**   c     in   [rows][(lmax+1)^2]
**   p     in   [n][3]        any length but 0
**   out   out  [rows][n]
**
** Returns  as ylm_sh_eval
** Cost     O(n (rows + 1) lmax^2)
*/
YLM_API ylm_status ylm_sh_reconstruct(int lmax, ylm_dtype t, size_t rows, const void *c, size_t n,
                                      const void *p, void *out, int threads, ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
