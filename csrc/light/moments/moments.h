/*
** moments.h - the sums over lights from which coefficients and their derivatives follow.
**
** Private to csrc/light. Per light, with v = y - x, d^2 = v.v, h^2 = d^2 - r^2, alpha = h/d,
** s2 = r^2/d^2, w = v/d and emission e, three kinds of sums are kept:
**
**   kind  sum over lights of e weight_k Y_km(w)                           degrees k
**   0     w0_k = 2pi s2 P_k'(alpha)/(k(k+1)), w0_0 = 2pi s2/(1+alpha)      0 .. lmax
**   1     w1_k = 2pi s2 P_k'(alpha)/h                                      1 .. lmax+1
**   2     w2_k = 2pi s2 (P_k(alpha)/alpha - P_k'(alpha))/h^2, w2_1 = 0     0, 2 .. lmax+2
**
** Kernels sum unnormalised forms: P'_(k+1) over its value at 1 for the weights, monic Legendre
** polynomials in z times Re, Im (x+iy)^m for Y. The factors that are missing are put in once per
** point, with the linear maps of plan.c. Lanes are points.
**
** What float would lose at high degrees: P'_k changes by k^2/4 times a change of alpha near 1, P_k
** by k^2/2 times a change of z near 1, both round to 6e-8, and so do all steps of a recurrence of
** three terms. So weights are found from delta = 1 - alpha by differences, and the columns of low
** order m (ylm__fine), which hold what is near the poles, from o = (x^2+y^2)/(1+|z|). Directions
** below the horizon are turned to -w, and weights of odd degree change their sign.
**
** Source  docs/math.md "Sum of sphere lights"
*/
#ifndef YLM_LIGHT_MOMENTS_H
#define YLM_LIGHT_MOMENTS_H

#include "../light.h"

/* Which kinds are summed: bits. Kernels exist for 1, 3, 4, 5 and 7. */
enum { YLM__M0 = 1, YLM__M1 = 2, YLM__M2 = 4 };
#define YLM__KIND_SETS(X) X(1) X(3) X(4) X(5) X(7)

/* Lights whose geometry is kept at once, in the first-level cache. */
#define YLM__TILE 8
/* Lights after which a partial sum is added to the total; a multiple of YLM__TILE. */
#define YLM__BLOCK 256
/* The lmax with kernels of their own: gen/moments_N.isa.c. */
#define YLM__SPECIAL_LIST(X, isa)                                                                  \
  X(isa, 0)                                                                                        \
  X(isa, 1)                                                                                        \
  X(isa, 2) X(isa, 3) X(isa, 4) X(isa, 5) X(isa, 6) X(isa, 7) X(isa, 8) X(isa, 9) X(isa, 10)
#define YLM__SPECIAL 10

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

/* What z is multiplied by, so that high degrees do not underflow: as GROW of kernel.h. */
static inline double ylm__grow(int lmax) { return lmax > YLM__SPECIAL ? 2 : 1; }

/* Places of one light in a tile: z, then Re and Im of (x+iy)^m, m = 1 .. lmax+2, then 1 - |z|. */
static inline int ylm__geometry_slots(int lmax) { return 2 + 2 * (lmax + 2); }
static inline int ylm__below_pole(int lmax) { return 1 + 2 * (lmax + 2); }
/* Columns of orders below this are found by differences from the pole, in float: as many as keep
   errors below 0.9 of the bound (single ones 1.03; spec/bench/accuracy.c). */
static inline int ylm__fine(int lmax) { return lmax < 5 ? 0 : lmax < 11 ? 1 : (lmax - 4) / 3; }
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

/*
** A kernel, for one lmax (or any), dtype and instruction set. All pointers are to vectors.
**   grow     factor per degree of the recurrences in z, which keeps high degrees from underflowing
**   prepare  geometry and weights of `n` <= YLM__TILE lights; the weights of all kinds (bright 7),
**   of
**            the third alone (4) or of none (0) times luminance. Lanes inside of a light are added
**            to `inside` (a mask of all ones).
**   sum      adds n lights' products to sums; `state` holds 2*YLM__TILE vectors of scratch
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

typedef ylm_light_rows ylm__rows;

/* Room for n rows with so many terms in all; rows are then made one after the other. */
ylm_status ylm__rows_create(ylm__rows *r, size_t n, size_t terms);
/* Adds a term to the row being built. */
void ylm__rows_term(ylm__rows *r, size_t index, double coef);
void ylm__rows_end(ylm__rows *r);
/* Appends `factor` times a row over sums that begin at `offset` to the row being built. maps.c */
void ylm__rows_append(ylm__rows *to, const ylm__rows *from, size_t row, size_t offset,
                      double factor);
/* Appends row i of hessian * bend; own [m->sums] is scratch. maps.c */
void ylm__rows_bent(ylm__rows *to, const ylm_light_maps *m, size_t i, double *own);
void ylm__rows_free(ylm__rows *r);

/*
** What follows from the sums of one set of channels. Rows are in the order of the results:
** coefficient i = l(l+1)+m, then x y z, or xx xy xz yy yz zz. `bend` makes U of docs/math.md,
** [(lmax+2)^2][3], from sums, and `hessian` (in ylm__plan) the Hessian from U.
*/
typedef struct ylm__map {
  ylm__rows value, gradient, bend;
} ylm__map;

/* The maps for the kinds of `need` out of sums of `kinds`. */
ylm_status ylm__map_create(ylm__map *map, int lmax, int need, int kinds, double grow);
void ylm__map_free(ylm__map *map);
/* H_ab L_lm from U. */
ylm_status ylm__map_hessian(ylm__rows *r, int lmax);
/* Y_km over (monic polynomial in z) times Re or Im (x+iy)^|m|. */
double ylm__harmonic_scale(int k, int m, double grow);
/* The kinds of sums that results of `channels` channels need. */
int ylm__kinds_of(const ylm_field_query *q, int channels);

/* How a query is answered: what is summed in which channels, and how results follow. */
typedef struct ylm__plan {
  const ylm_field_query *q;
  const ylm_lights *lights;
  const ylm__moment_kernel *kernel;
  int need_lum, need_rgb;   /* kinds that results need in luminance and in rgb */
  int kinds_lum, kinds_rgb; /* kinds that are summed in each */
  int n_lum, n_rgb;         /* how many sums these are */
  ylm__map lum, mixed, rgb; /* from luminance sums, from rgb sums weighted to luminance, from rgb */
  ylm__rows hessian;
} ylm__plan;

/* The plan of a query for a kernel, or YLM_ENOMEM; to be freed with ylm__plan_free in any case. */
ylm_status ylm__plan_create(ylm__plan *p, const ylm_lights *lights, const ylm_field_query *q,
                            const ylm__moment_kernel *kernel);
void ylm__plan_free(ylm__plan *p);

/* The kernel of an instruction set for (lmax, dtype), and the loop around it: points begin ..
 *end-1. scratch is NULL at a worker's first call; what it then holds is freed by the caller. */
typedef ylm_status ylm__sum_range(const ylm__plan *p, void **scratch, size_t begin, size_t end,
                                  const void *points, ylm_field_result *r);
struct ylm__tree_plan;
/* The same over a tree of lights (tree/tree.h), for blocks begin .. end-1 of points; scratch is of
   three, the first of which begins with the number of lights and proxies that were summed, a
   uint64_t. */
typedef ylm_status ylm__tree_range(const struct ylm__tree_plan *p, void **scratch, size_t begin,
                                   size_t end, const void *points, ylm_field_result *r);
typedef struct ylm__kernel_set {
  const ylm__moment_kernel *moments;
  ylm__sum_range *range;
  ylm__tree_range *tree;
  ylm_light_bend_fn *bend; /* always of floats */
} ylm__kernel_set;
/* False where there are none (the reference). */
bool ylm__kernels_of(ylm_isa isa, int lmax, ylm_dtype t, ylm__kernel_set *set);

#endif
