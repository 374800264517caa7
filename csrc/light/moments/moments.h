/*
** moments.h - the sums over lights from which coefficients and their derivatives follow.
**
** Private to csrc/light. A light has v = y - x, d^2 = v.v, h^2 = d^2 - r^2, alpha = h/d, s2 =
** r^2/d^2, w = v/d and the emission e. Three kinds of sums over lights are kept:
**
**   kind  sum over lights of e weight_k Y_km(w)                           degrees k
**   0     w0_k = 2pi s2 P_k'(alpha)/(k(k+1)), w0_0 = 2pi s2/(1+alpha)      0 .. lmax
**   1     w1_k = 2pi s2 P_k'(alpha)/h                                      1 .. lmax+1
**   2     w2_k = 2pi s2 (P_k(alpha)/alpha - P_k'(alpha))/h^2, w2_1 = 0     0, 2 .. lmax+2
**
** Kernels sum unnormalised forms: P'_(k+1) over its value at 1 for the weights, monic Legendre
** polynomials in z times Re, Im (x+iy)^m for Y. The factors that are missing are put in once per
** point, with the linear maps of plan.h. Lanes are points.
**
** Losses of float at high degrees: P'_k changes by k^2/4 times a change of alpha near 1, P_k by
** k^2/2 times a change of z near 1. Both round to 6e-8, and so do all steps of a recurrence of
** three terms. Weights are therefore found from delta = 1 - alpha by differences. The columns of
** low order m (YLM__FINE), which matter near the poles, are found from o = (x^2+y^2)/(1+|z|).
** Directions below the horizon are turned to -w, and weights of odd degree change their sign.
**
** Source  docs/math.md "Sum of sphere lights"
*/
#ifndef YLM_LIGHT_MOMENTS_H
#define YLM_LIGHT_MOMENTS_H

#include "../lamp.h"
#include "calibration.h"
#include "ylm_base.h"

/* Which kinds are summed: bits. Kernels exist for 1, 3, 4, 5 and 7. */
enum { YLM__M0 = 1, YLM__M1 = 2, YLM__M2 = 4 };
#define YLM__KIND_SETS(X) X(1) X(3) X(4) X(5) X(7)

/* The lmax with kernels of their own: gen/moments_N.h. */
#define YLM__SPECIAL_LIST(X, isa)                                                                  \
  X(isa, 0)                                                                                        \
  X(isa, 1)                                                                                        \
  X(isa, 2) X(isa, 3) X(isa, 4) X(isa, 5) X(isa, 6) X(isa, 7) X(isa, 8) X(isa, 9) X(isa, 10)

/* Highest degree that a set of kinds needs. */
static inline int ylm__degree_of(int lmax, int kinds) {
  return kinds & YLM__M2 ? lmax + 2 : kinds & YLM__M1 ? lmax + 1 : lmax;
}

/* Whether a sum of kind `kind` exists at degree k. The general kernel sums zeros for those two
   that do not exist rather than having code without them. */
static inline bool ylm__has(int lmax, int kinds, int kind, int k) {
  if (!(kinds & (1 << kind))) return false;
  if (lmax > YLM__SPECIAL) return k <= lmax + kind;
  return kind == 0 ? k <= lmax : kind == 1 ? k >= 1 && k <= lmax + 1 : k != 1 && k <= lmax + 2;
}

/* The factor of z, so that high degrees do not underflow: as GROW of kernel.h. */
static inline double ylm__grow(int lmax) { return lmax > YLM__SPECIAL ? 2 : 1; }

/* Places of one light in a tile: z, then Re and Im of (x+iy)^m, m = 1 .. lmax+2, then 1 - |z|. */
static inline int ylm__geometry_slots(int lmax) { return 2 + 2 * (lmax + 2); }
static inline int ylm__below_pole(int lmax) { return 1 + 2 * (lmax + 2); }
/* Places of one light's weights: w0 0..lmax, w1 0..lmax+1, w2 0..lmax+2; w1_0 and w2_1 are 0. */
static inline int ylm__weight_slots(int lmax) { return 3 * lmax + 6; }
static inline int ylm__weight_at(int lmax, int kind, int k) {
  return kind == 0 ? k : kind == 1 ? lmax + 1 + k : 2 * lmax + 3 + k;
}

/* Number of sums of a set of kinds: columns (m, Re), (m, Im) in order of m; in a column degrees
   upwards; at a degree kinds upwards. */
static inline int ylm__sum_count(int lmax, int kinds) {
  int n = 0;
  int all = lmax > YLM__SPECIAL;
  if (kinds & YLM__M0) n += (lmax + 1) * (lmax + 1);
  if (kinds & YLM__M1) n += (lmax + 2) * (lmax + 2) - (all ? 0 : 1);
  if (kinds & YLM__M2) n += (lmax + 3) * (lmax + 3) - (all ? 0 : 3);
  return n;
}

/* Number of sums of a column of order m where lmax is known at run time only: all kinds up to lmax + kind. */
static inline int ylm__column_sums(int lmax, int kinds, int m) {
  int n = 0;
  for (int kind = 0; kind < 3; kind++)
    if (kinds & (1 << kind) && m <= lmax + kind) n += lmax + kind - m + 1;
  return n;
}

/* Lights whose geometry is kept at once for these kinds of sums in luminance and in three channels. */
static inline int ylm__tile(int lmax, int kinds_lum, int kinds_rgb) {
  if (lmax <= YLM__SPECIAL) return YLM__TILE;
  return kinds_rgb ? YLM__TILE_RGB : kinds_lum & (kinds_lum - 1) ? YLM__TILE : YLM__TILE_ONE;
}

/*
** A kernel, for one lmax (or any), dtype and instruction set. All pointers are to vectors.
**   grow     factor per degree of the recurrences in z, which keeps high degrees from underflowing
**   prepare  geometry and weights of `n` lights; the weights of all kinds (bright 7), of
**            the third alone (4) or of none (0) times luminance. Lanes inside of a light are added
**            to `inside` (a mask of all ones).
**   sum      adds n lights' products to sums; `state` holds 2*n vectors of scratch
**   sum_rgb  the same for three channels, whose sums are `stride` apart: times emission [n][3]
*/
typedef struct ylm__moment_kernel {
  int lanes;
  double grow;
  void (*prepare)(int lmax, int kinds, int n, const void *lamps, int bright, const void *xyz,
                  void *geometry, void *weights, void *inside);
  void (*sum)(int lmax, int kinds, int n, const void *geometry, const void *weights, void *state,
              void *sums);
  void (*sum_rgb)(int lmax, int kinds, int n, const void *geometry, const void *weights,
                  const void *emission, void *state, void *sums, int stride);
} ylm__moment_kernel;

#endif
