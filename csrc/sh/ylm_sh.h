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

/* Functions that take `progress` (NULL: none) report it between blocks of rows or points, and
   return YLM_ECANCELLED where it wants no more; what is done by then stays in the results. */

/* Conventions of coefficient arrays (ylmL_array.convention); the list grows in convert.c. */
#define YLM_SH_NATIVE 0

/*
** The ways to evaluate. All but the first exist to be compared with, and are in libylm_rival.so
** (csrc/rival). They are scalar. Methods that divide by sin(theta) give NaN in derivatives where
** x = y = 0.
**   solid       Cartesian recurrences and ladders, vectorised, exact everywhere
**   polynomial  explicit polynomials in x, y, z; lmax <= 6
**   direct      Mezieres et al. 2022, "Direct": (theta, phi), Eq. 19; derivatives <= 1
**   sloan       Mezieres et al. 2022, "Sloan's like": (theta, phi), Eq. 22; derivatives <= 1
**   scd         spherical-coordinate derivatives with Hessian, compared with in Iwasaki & Dobashi
**   2025
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
** Accuracy relative to the largest of its degree: 1e-13 (double), in float 4e-6 to lmax 20 and
**          about in proportion to lmax above (Hessians 7.5e-6 at 31), poles included
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

/* ylm_sh_eval with every choice open. Methods of libylm_rival.so: YLM_EMISSING until it is
   registered, YLM_ERANGE beyond their lmax or derivatives, YLM_EINVAL with solid (all but
   "polynomial"). */
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
                                      const void *p, void *out, int threads,
                                      const ylm_progress *progress, ylm_error *e);

/* -- rotation: csrc/sh/rotate/rotate.c, quarter.c --------------------------------------------- */

/* The highest degree that can be rotated. */
#define YLM_SH_ROTATE_LMAX 128

/*
** A plan for rotating up to degree lmax: the quarter turns that every rotation is made of.
** Immutable, to be shared between threads; about lmax^3 numbers.
*/
typedef struct ylm_sh_rotator ylm_sh_rotator;
/* YLM_ERANGE (lmax 0 .. YLM_SH_ROTATE_LMAX), YLM_ENOMEM. The caller frees *out. */
YLM_API ylm_status ylm_sh_rotator_create(int lmax, ylm_sh_rotator **out, ylm_error *e);
YLM_API void ylm_sh_rotator_free(ylm_sh_rotator *p);

/* Rotation matrices, row-major [3][3], that turn vectors: v -> R v. */
YLM_API ylm_status ylm_sh_rotation_from_axis(const double axis[3], double angle, double r[9],
                                             ylm_error *e);
YLM_API ylm_status ylm_sh_rotation_from_quaternion(const double wxyz[4], double r[9], ylm_error *e);
/* Rz(a) Ry(b) Rz(c), radians. */
YLM_API ylm_status ylm_sh_rotation_from_zyz(const double abc[3], double r[9], ylm_error *e);
/* YLM_EDOMAIN unless r is a rotation to 1e-5; *out (may be r) is the nearest exact one: of whole
   numbers where r is a product of quarter turns about the axes to 4e-16. */
YLM_API ylm_status ylm_sh_rotation_check(const double r[9], double out[9], ylm_error *e);

/*
** ylm_sh_rotate - turn functions given by coefficients: out(s) = in(R^-1 s).
**
**   p     in   of degree >= lmax
**   r     in   [3][3]                  a rotation, see ylm_sh_rotation_check
**   in    in   [rows][(lmax+1)^2]
**   out   out  [rows][(lmax+1)^2]      may be in
**
** Identity, half and quarter turns about the axes and their products, the cube's 24 rotations, are
** exact: signed permutations where z stays on its axis and in degree 1, else each entry of the
** blocks the nearest number (zeros exactly 0).
** Returns  YLM_OK, YLM_ERANGE (lmax), YLM_EDOMAIN (r), YLM_ENOMEM
** Accuracy relative to the norm: 1e-13 (double), 2e-6 (float)
** Cost     O(lmax^3) a row: z-turns between quarter turns, one row at a time for few rows; for
**          more as ylm_sh_rotation_apply
** Source   Pinchon & Hoggan 2007, Sec. 2; docs/math.md "Rotation"
*/
YLM_API ylm_status ylm_sh_rotate(const ylm_sh_rotator *p, const double r[9], int lmax, ylm_dtype t,
                                 size_t rows, const void *in, void *out, int threads,
                                 const ylm_progress *progress, ylm_error *e);

/*
** A rotation prepared for batches: its blocks, one (2l+1)x(2l+1) matrix for each low degree; above,
** where a block has four times the numbers of a quarter turn, its angles. A rotation keeps the
** rotator that it was made by alive, which the caller may free.
*/
typedef struct ylm_sh_rotation ylm_sh_rotation;
YLM_API ylm_status ylm_sh_rotation_create(const ylm_sh_rotator *p, const double r[9], int lmax,
                                          ylm_dtype t, ylm_sh_rotation **out, ylm_error *e);
YLM_API void ylm_sh_rotation_free(ylm_sh_rotation *r);
YLM_API int ylm_sh_rotation_lmax(const ylm_sh_rotation *r);
YLM_API ylm_dtype ylm_sh_rotation_dtype(const ylm_sh_rotation *r);
/* The block of degree l, [2l+1][2l+1] row-major; m = -l first. */
YLM_API ylm_status ylm_sh_rotation_block(const ylm_sh_rotation *r, int l, double *out);
/* As ylm_sh_rotate, for arrays of the rotation's type and any lmax up to its own; out may be in. */
YLM_API ylm_status ylm_sh_rotation_apply(const ylm_sh_rotation *r, int lmax, size_t rows,
                                         const void *in, void *out, int threads,
                                         const ylm_progress *progress);

/* The highest degree of ylm_sh_rotate_each. */
#define YLM_SH_ROTATE_EACH_LMAX 60

/*
** ylm_sh_rotate_each - turn rows that each have a rotation of their own, as frames of surfaces are.
**
**   p       in   of degree >= lmax
**   r       in   [n][3][3]       rotations, orthonormal to 1e-3; columns are the axes of a frame. Of type t
**   rows    in   1 ..            rows of each rotation
**   halves  in                   rows of `in` hold m >= 0 alone, l by l: (lmax+1)(lmax+2)/2 numbers
**   in      in   [n][rows][(lmax+1)^2 or that]
**   out     out  [n][rows][(lmax+1)^2]      may be in, if rows are whole
**
** Returns  YLM_OK; YLM_ERANGE (lmax 0 .. YLM_SH_ROTATE_EACH_LMAX and that of p), YLM_EDOMAIN (which rotation is none),
**          YLM_ECANCELLED (stage "rotate")
** Accuracy relative to the norm, where r is exact to its type: 1e-13 (double), 2e-6 (float; 5e-6 above degree 20)
** Cost     O(lmax^3) a row, rows in the lanes of vectors
** Source   Pinchon & Hoggan 2007, Sec. 2; docs/math.md "Rotation"
*/
YLM_API ylm_status ylm_sh_rotate_each(const ylm_sh_rotator *p, int lmax, ylm_dtype t, size_t n,
                                      const void *r, int rows, bool halves, const void *in,
                                      void *out, int threads, const ylm_progress *progress,
                                      ylm_error *e);

/*
** The recurrence of Ivanic & Ruedenberg 1996 (corrected 1998), which judges the others:
** blocks of degrees 0 .. lmax, one after the other, [2l+1][2l+1] each. `r` is not checked.
** Accuracy 1e-15 to degree 50; errors grow tenfold every eight degrees above: 1e-8 at 128.
*/
YLM_API ylm_status ylm_sh_rotation_reference(const double r[9], int lmax, double *blocks);

/* -- conventions: csrc/sh/convert.c ------------------------------------------------------------ */

/*
** A convention says what coefficients mean: a system, a quantity and the axes, in one number.
** 0 is ylm's own: real, orthonormal, with the Condon-Shortley phase, radiance, axes as they are.
** Numbers are kept in files: the list only grows at its end.
**
**   system          numbers      relation to ylm's c(l,m) of a function f = sum c Y
**   ylm             [count]      c
**   plain           [count]      (-1)^m c: no phase; also sphericart's
**   n3d             [count]      (-1)^m sqrt(4pi) c: ambisonics, ACN order, N3D
**   sn3d            [count]      (-1)^m sqrt(4pi/(2l+1)) c: ambisonics, ACN order, SN3D (AmbiX)
**   scipy           [count][2]   complex a(l,m), f = sum a sph_harm(m, l): real and imaginary part;
**                                also sph_harm_y's
**   unity           [7][4]       SHAr SHAg SHAb SHBr SHBg SHBb SHC of three channels, lmax 2,
**                                irradiance/pi
**   three.js        [9][3]       SphericalHarmonics3: (-1)^m c, coefficients before channels, lmax 2
**   filament        [9][3]       irradiance/pi with the constants of Y multiplied in, lmax 2; also
**                                LOVR's
**   e3nn            [count]      plain in axes z, x, y: the polar axis is y; "integral"
**   e3nn-component  [count]      e3nn over sqrt(4pi)
**   e3nn-norm       [count]      e3nn times sqrt((2l+1)/4pi)
**   3dgs            [count][3]   c, coefficients before channels: Gaussian splats
**   mrtrix          [even]       c of even degrees, (lmax+1)(lmax+2)/2 numbers
**   dipy            [even]       c(l,-m) of even degrees: descoteaux07
*/
#define YLM_SH_SYSTEM_LIST(X)                                                                      \
  X(ylm, "ylm")                                                                                    \
  X(plain, "plain")                                                                                \
  X(n3d, "n3d")                                                                                    \
  X(sn3d, "sn3d")                                                                                  \
  X(scipy, "scipy")                                                                                \
  X(unity, "unity")                                                                                \
  X(threejs, "three.js")                                                                           \
  X(filament, "filament")                                                                          \
  X(e3nn, "e3nn")                                                                                  \
  X(e3nn_component, "e3nn-component")                                                              \
  X(e3nn_norm, "e3nn-norm")                                                                        \
  X(splats, "3dgs")                                                                                \
  X(mrtrix, "mrtrix")                                                                              \
  X(dipy, "dipy")

typedef enum ylm_sh_system {
#define X(name, text) YLM_SH_SYSTEM_##name,
  YLM_SH_SYSTEM_LIST(X)
#undef X
      YLM_SH_SYSTEM_COUNT
} ylm_sh_system;

static inline ylm_sh_system ylm_sh_convention_system(uint32_t c) { return (ylm_sh_system)(c & 31); }
/* Set: irradiance E(l,m) = A(l) L(l,m) instead of radiance. */
#define YLM_SH_IRRADIANCE 0x20u
/* Bits 8 .. 13: the permutation (of xyz, xzy, yxz, yzx, zxy, zyx) times 8 plus a bit for each
   negative axis: the directions, in ylm's axes, of the convention's x, y and z. */
static inline int ylm_sh_convention_axes(uint32_t c) { return (int)(c >> 8 & 63); }

/*
** Words to a convention and back: a system, then "irradiance", then axes like "x,z,-y". The axes
** say where the convention's x, y, z axes point. The last two stand only if they are not the usual
** ones. YLM_EINVAL names the word that is not understood. `text` takes at most 64 bytes.
*/
YLM_API ylm_status ylm_sh_convention_parse(const char *text, uint32_t *convention, ylm_error *e);
YLM_API ylm_status ylm_sh_convention_name(uint32_t convention, char text[64]);

/*
** ylm_sh_convert - translate coefficients from one convention to another.
**
**   rows   in   vectors of (lmax+1)^2 coefficients; whole groups of three (the channels) where a
**               system puts channels last
**   in     in   in the shape of `from`, see the list
**   out    out  in the shape of `to`; not `in`
**
** mrtrix and dipy hold functions that are the same in opposite directions: odd degrees are left out.
**
** Returns  YLM_OK; YLM_EINVAL (no convention); YLM_ERANGE (lmax over YLM_LMAX, over 128 where axes
**          change, not 2 for unity, three.js and filament, odd for mrtrix and dipy); YLM_ESHAPE
**          (rows); YLM_EDOMAIN (irradiance to radiance with degrees 3, 5 .., which irradiance does
**          not hold); YLM_ENOMEM
** Accuracy rounding of the type
** Source   docs/conventions.md, "Conventions of others"; Sloan 2008, appendix A10 (unity)
*/
YLM_API ylm_status ylm_sh_convert(uint32_t from, uint32_t to, int lmax, ylm_dtype t, size_t rows,
                                  const void *in, void *out, int threads,
                                  const ylm_progress *progress, ylm_error *e);

/* A(l) = 2 pi times the integral of t P_l(t) over 0 .. 1: the factor from radiance to
   irradiance. */
YLM_API double ylm_sh_cosine_factor(int l);

/* -- products: csrc/sh/product/product.c ----------------------------------------------------- */

/*
** The ways to multiply functions given by coefficients of degree <= lmax, cut off at lmax again.
** All but the last are exact. fourier, brute and list exist to be compared with, and are in
** libylm_rival.so.
**   auto        the fastest for the size
**   gaunt       sums over the non-zero integrals of three basis functions; two factors
**   quadrature  to the points of a rule that is exact for the degree, and back
**   fourier     convolution of Fourier series, divide and conquer (Xin et al. 2021)
**   brute       sums over the non-zero integrals of all factors and the result (small sizes)
**   list        two factors: a list of all non-zero integrals, each with its three places, walked one
**               by one (Ng et al. 2004)
**   recursive   two at a time, cut off at lmax in between: an approximation for three or more
*/
#define YLM_SH_PRODUCT_METHOD_LIST(X)                                                              \
  X(auto) X(gaunt) X(quadrature) X(fourier) X(brute) X(list) X(recursive)

typedef enum ylm_sh_product_method {
#define X(name) YLM_SH_PRODUCT_##name,
  YLM_SH_PRODUCT_METHOD_LIST(X)
#undef X
      YLM_SH_PRODUCT_METHOD_COUNT
} ylm_sh_product_method;

/* The highest degree and the most factors of a product. */
#define YLM_SH_PRODUCT_LMAX 100
#define YLM_SH_PRODUCT_FACTORS 16

/* Tables for one size. Immutable, to be shared between threads. */
typedef struct ylm_sh_product ylm_sh_product;
/*
** `inner` is the method of the steps of `recursive`, else ignored.
** YLM_ERANGE (lmax; factors 2 .. YLM_SH_PRODUCT_FACTORS), YLM_EINVAL (list with other than two
** factors), YLM_ELIMIT (brute, gaunt or list: tables of more than some million entries), YLM_EMISSING
** (a method of libylm_rival.so, which is not registered), YLM_ENOMEM.
*/
YLM_API ylm_status ylm_sh_product_create(int lmax, int factors, ylm_sh_product_method method,
                                         ylm_sh_product_method inner, ylm_sh_product **out,
                                         ylm_error *e);
YLM_API void ylm_sh_product_free(ylm_sh_product *p);
/* The method that is used: never auto. */
YLM_API ylm_sh_product_method ylm_sh_product_method_of(const ylm_sh_product *p);
YLM_API const char *ylm_sh_product_method_name(ylm_sh_product_method m);
/* The number of non-zero integrals of a gaunt plan, i and j exchanged counted once; else 0. */
YLM_API size_t ylm_sh_product_integrals(const ylm_sh_product *p);

/*
** ylm_sh_product_apply - multiply row by row.
**
**   out[r] = the coefficients of factor[0][r] * factor[1][r] * ...
**
**   factor  in   [factors] arrays of rows [(lmax+1)^2]
**   stride  in   [factors] numbers from one row to the next: (lmax+1)^2, or 0 to use one row for
**                all; NULL means (lmax+1)^2 for all
**   out     out  [rows][(lmax+1)^2], no factor
**   stage   out  [3] seconds of transform, multiplication and transform back are added (quadrature
**                and fourier, one thread); may be NULL. quadrature counts the multiplication to the
**                first.
**
** Returns  YLM_OK, YLM_ENOMEM
** Accuracy of the norm of the result: 1e-12 (double), 1e-5 (float)
** Cost     O(factors lmax^3) a row by quadrature, vectorised over nodes or, for several rows, over
**          rows, as gaunt up to lmax 3
** Source   Gauss quadrature (docs/math.md "Products"); Xin et al. 2021, Sec. 4
*/
YLM_API ylm_status ylm_sh_product_apply(const ylm_sh_product *p, ylm_dtype t, size_t rows,
                                        const void *const *factor, const size_t *stride, void *out,
                                        int threads, const ylm_progress *progress, double *stage);

/*
** ylm_sh_rotate_times - turn rows by their point's rotation (ylm_sh_rotate_each), then multiply them by its factor.
**
**   p       in   of degree >= that of q
**   q       in   of two factors; its lmax is that of all rows
**   r       in   [n][3][3]  rotations, orthonormal to 1e-3, not checked
**   rows    in   1 ..       rows of each point
**   halves  in              rows of `in` hold m >= 0 alone
**   in      in   [n][rows][(lmax+1)^2 or (lmax+1)(lmax+2)/2]
**   factor  in   [n]        rows [(lmax+1)^2]; NULL: the point's rows are turned alone
**   out     out  [n][rows][(lmax+1)^2]
**   stage   out  [2] seconds of rotation and multiplication are added; may be NULL
**
** Returns  YLM_OK; YLM_ERANGE (lmax, rows, q), YLM_EDOMAIN (ylm_sh_rotate_each, of points without a factor), YLM_ENOMEM
** Accuracy as ylm_sh_rotate_each and ylm_sh_product_apply
** Cost     the factor is transformed once for all its rows; one thread
** Source   as these two
*/
YLM_API ylm_status ylm_sh_rotate_times(const ylm_sh_rotator *p, const ylm_sh_product *q,
                                       ylm_dtype t, size_t n, const void *r, int rows, bool halves,
                                       const void *in, const void *const *factor, void *out,
                                       double *stage, ylm_error *e);

/*
** ylm_sh_rotate_integrate - turn rows by their point's rotation, multiply them by its factor and by three functions,
** and integrate.
**
**   out[i][c] = sum_k mix[c][k] int row_k factor_i light_c
**
** All but the following as ylm_sh_rotate_times has it.
**
**   rows    in   1 .. 3
**   light   in   [3]        rows [(lmax+1)^2], the same for all points
**   mix     in   [3][3]     of which `rows` columns count
**   out     out  [n][3]
**
** Accuracy as ylm_sh_rotate_times, of the norm of a row times that of light: 2e-6 (float)
** Cost     rows and factors are transformed to nodes, light once a call; nothing is transformed back
** Source   Gauss quadrature, exact for three functions of degree lmax (docs/math.md "Products")
*/
YLM_API ylm_status ylm_sh_rotate_integrate(const ylm_sh_rotator *p, const ylm_sh_product *q,
                                           ylm_dtype t, size_t n, const void *r, int rows,
                                           bool halves, const void *in, const void *const *factor,
                                           const void *const *light, const void *mix, void *out,
                                           double *stage, ylm_error *e);

/* Whether kernels turn and multiply rows in one pass, without which integrals cost more than products: quadrature, lmax
   14 at most. */
YLM_API bool ylm_sh_rotate_in_one(const ylm_sh_rotator *p, const ylm_sh_product *q);

/* -- any number of factors: csrc/sh/product/nodes.c ------------------------------------------- */

/*
** The directions of one rule, at which functions of degree <= lmax are multiplied, and the way there and back. A rule
** of degree (k+1) lmax is exact for k factors; one of degree 3 lmax serves any number of factors, with an error that
** falls with lmax (docs/shadow_fields.md). Immutable, to be shared between threads.
*/
typedef struct ylm_sh_nodes ylm_sh_nodes;

#define YLM_SH_NODES_DEGREE 2000

/* YLM_ERANGE (lmax 0 .. YLM_SH_PRODUCT_LMAX, degree lmax .. YLM_SH_NODES_DEGREE), YLM_ENOMEM. */
YLM_API ylm_status ylm_sh_nodes_create(int lmax, int degree, ylm_sh_nodes **out, ylm_error *e);
YLM_API void ylm_sh_nodes_free(ylm_sh_nodes *n);
/* The number of directions; those on the equator count twice, with half the weight. */
YLM_API size_t ylm_sh_nodes_count(const ylm_sh_nodes *n);
/* [count][3], of length 1; they live as long as n. */
YLM_API const double *ylm_sh_nodes_directions(const ylm_sh_nodes *n);
/* How many rows are transformed at once, 16 at most. */
YLM_API size_t ylm_sh_nodes_lanes(const ylm_sh_nodes *n, ylm_dtype t);
/* Bytes of scratch for them. */
YLM_API size_t ylm_sh_nodes_scratch(const ylm_sh_nodes *n, ylm_dtype t);
/*
** ylm_sh_nodes_synthesise - values of functions at the nodes; ylm_sh_nodes_analyse - their coefficients.
**
**   row      in   [lanes] rows [(lmax+1)^2], which may repeat
**   multiply in   value is multiplied by them, else set
**   value    i/o  [count][lanes], aligned to YLM_ALIGN; analyse reads it
**   by       in   [count] numbers that the values of all lanes are multiplied by; or NULL
**   out      out  [lanes] rows [(lmax+1)^2], which may repeat
**
** Cost     O(lmax^3) a row. Thread-safe, no allocation
*/
YLM_API void ylm_sh_nodes_synthesise(const ylm_sh_nodes *n, ylm_dtype t, const void *const *row,
                                     bool multiply, void *value, void *scratch);
YLM_API void ylm_sh_nodes_analyse(const ylm_sh_nodes *n, ylm_dtype t, const void *value,
                                  const void *by, void *const *out, void *scratch);
/* Products of any number of factors, row by row; arguments as ylm_sh_product_apply has them, stride not NULL.
   Cost  factors + 1 transforms a row */
YLM_API ylm_status ylm_sh_nodes_product(const ylm_sh_nodes *n, ylm_dtype t, size_t factors,
                                        size_t rows, const void *const *factor,
                                        const size_t *stride, void *out, int threads,
                                        const ylm_progress *progress);

/* -- exponentials: csrc/sh/product/exponential.c ---------------------------------------------- */

#define YLM_SH_LOG_LMAX 20
#define YLM_SH_EXP_TERMS 64

/*
** ylm_sh_log, ylm_sh_exp - coefficients of the logarithm and the exponential of functions, row by row.
**
**   epsilon  in   0 < epsilon < 1: eigenvalues of the matrix that multiplies by f count as at least epsilon times the
**                 largest one
**   terms    in   1 .. YLM_SH_EXP_TERMS: powers of the function without c(0,0)
**   in, out       [rows][(lmax+1)^2], not the same memory
**
** Returns  YLM_OK; YLM_ERANGE (lmax, terms; a series that diverges), YLM_EDOMAIN (log of a function that is nowhere
**          positive): `e` names the row; YLM_ENOMEM
** Cost     log O(lmax^6), exp O(terms lmax^3) a row
** Source   Ren et al. 2006
*/
YLM_API ylm_status ylm_sh_log(int lmax, ylm_dtype t, size_t rows, double epsilon, const void *in,
                              void *out, int threads, const ylm_progress *progress, ylm_error *e);
YLM_API ylm_status ylm_sh_exp(int lmax, ylm_dtype t, size_t rows, int terms, const void *in,
                              void *out, int threads, const ylm_progress *progress, ylm_error *e);

/*
** ylm_sh_product_matrix - the matrix that multiplies by a function: (M a)_i = sum_j M_ij a_j.
**
**   M_ij = sum_k c_k int Y_i Y_j Y_k,   Green 2003, Eq. 8; symmetric
**
**   c       in   [(2 lmax+1)^2] or fewer: degree clmax, of which at most 2 lmax matters
**   matrix  out  [(lmax+1)^2][(lmax+1)^2]
**
** Returns  YLM_OK, YLM_ERANGE, YLM_ENOMEM.  Cost  O(lmax^5)
*/
YLM_API ylm_status ylm_sh_product_matrix(int clmax, const double *c, int lmax, double *matrix,
                                         ylm_error *e);

/* out[r] = M in[r]: `n` numbers a row, M [n][n], symmetric; out is not in. YLM_OK, YLM_ENOMEM. */
YLM_API ylm_status ylm_sh_apply(size_t n, ylm_dtype t, const void *matrix, size_t rows,
                                const void *in, void *out, int threads,
                                const ylm_progress *progress);

/*
** ylm_sh_matrices_apply - n matrices of their own, each applied to `rows` rows: out[i][r] = M[i] in[i mod period][r].
**
**   matrix  in   [n][a][b], of any kind
**   period  in   1 .. n: of in; 1: all matrices are applied to the same rows
**   in      in   [period][rows][b]
**   out     out  [n][rows][a], is not in
**
** Returns  YLM_OK, YLM_ECANCELLED (stage "transfer").  Cost  the matrices' memory, read once
*/
YLM_API ylm_status ylm_sh_matrices_apply(size_t n, size_t a, size_t b, ylm_dtype t,
                                         const void *matrix, size_t period, size_t rows,
                                         const void *in, void *out, int threads,
                                         const ylm_progress *progress);

/* -- projection: csrc/sh/project/project.c --------------------------------------------------- */

/*
** ylm_sh_sphere_rule - directions and weights of a product rule: `nodes` Gauss-Legendre nodes in z,
** `azimuths` directions around each. Exact for polynomials of degree min(2 nodes - 1, azimuths -
** 1).
**
**   lo, hi      in   the range of z: -1 .. 1 is the sphere, 0 .. 1 the upper half
**   direction   out  [nodes * azimuths][3]
**   weight      out  [nodes * azimuths]      sr; the sum is 2 pi (hi - lo)
**
** Returns  YLM_OK, YLM_ERANGE (counts 1 .. 100000, -1 <= lo < hi <= 1), YLM_ENOMEM
*/
YLM_API ylm_status ylm_sh_sphere_rule(int nodes, int azimuths, double lo, double hi,
                                      double *direction, double *weight);

/*
** ylm_sh_sphere_samples - side*side directions, one at random in each of as many cells of equal
** area ("jittered"); the same seed and stream give the same directions everywhere.
**   direction  out  [side * side][3]
** Source  Green 2003, "SH_setup_spherical_samples"
*/
YLM_API void ylm_sh_sphere_samples(int side, uint64_t seed, uint64_t stream, double *direction);

/*
** ylm_sh_project_samples - c[ch][k] = sum_i weight[i] value[i][ch] Y_k(direction[i]).
**
**   direction  in   [n][3]          of any length; a zero one is skipped if its weight is 0
**   weight     in   [n] sr; NULL: 4 pi / n each
**   value      in   [n][channels]
**   out        out  [channels][(lmax+1)^2]
**   square     out  [channels][(lmax+1)^2], the sums of squares of the same terms; NULL: not wanted
**
** Returns  YLM_OK; YLM_ERANGE (lmax), YLM_EDOMAIN (a direction: `e` names it), YLM_ENOMEM
** Threads  the sums do not depend on their number
*/
YLM_API ylm_status ylm_sh_project_samples(int lmax, size_t n, const double *direction,
                                          const double *weight, int channels, const double *value,
                                          double *out, double *square, int threads,
                                          const ylm_progress *progress, ylm_error *e);

/*
** ylm_sh_halve_pixels - an image of the sphere from blocks of 2 x 2 of its pixels, to see what its
** resolution costs.
**
**   width, height  in   height is that of all `faces` that lie one above the other
**   faces          in   1, or 6 for a cube map: no block reaches over a border
**   direction      in   [height * width][3] unit;  weight [height * width] sr
**   value          in   [height * width][channels]
**   coarse_*       out  [ylm_sh_halved(width, height, faces)] of the same: mean direction, sum of
**   weights, mean value
*/
YLM_API size_t ylm_sh_halved(int width, int height, int faces);
YLM_API void ylm_sh_halve_pixels(int width, int height, int faces, int channels,
                                 const double *direction, const double *weight, const double *value,
                                 double *coarse_direction, double *coarse_weight,
                                 double *coarse_value);

/* -- for kernels elsewhere: csrc/sh/eval/eval.c, csrc/sh/project/quadrature.c ------------------ */

/* Refuses points that ylm_sh_eval_how refuses, in its words. */
YLM_API ylm_status ylm_sh_check_points(const ylm_sh_how *how, int lmax, ylm_dtype t, size_t n,
                                       const void *p, ylm_error *e);
/* The coefficients a b e A B b' c' of the recurrences of csrc/sh/eval/sh_kernel.h, for degree l > 0
   and order q, 0 .. l. */
YLM_API void ylm_sh_coefficients(int l, int q, double k[7]);

/* n nodes in (-1, 1), rising, and their weights; exact to degree 2n-1. Newton's method in long
 * double. */
YLM_API void ylm_sh_gauss_legendre(int n, double *x, double *w);

/* p[l*(l+1)/2+m] = sqrt(m ? 2 : 1) K_lm P_lm(x) with the Condon-Shortley phase, 0 <= m <= l <=
   lmax: the part of Y_lm that depends on z = x. `sine` is sqrt(1-x^2). */
YLM_API void ylm_sh_legendre(int lmax, double x, double sine, double *p);

#ifdef __cplusplus
}
#endif
#endif
