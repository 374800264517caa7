/*
** rotate.h - what rotate*.c and their kernels share. Private to csrc/sh.
**
** A rotation is Rz(a) Ry(b) Rz(c). With J the matrix of the quarter turn about x,
** Ry(b) = J^T Z(b) J and J^T = Z(pi) J Z(pi), so that
**
**   M = Z(a + pi) J Z(b + pi) J Z(c)
**
** and one table serves both turns. J links m and m' only within classes: by cosine or sine and by
** the parity of m (Pinchon & Hoggan 2007). "Class order" of a degree's coefficients is four padded
** rows, CE SE CO SO, in which entry k is m = 2k (even) or 2k+1 (odd); SE[0] is 0.
*/
#ifndef YLM_SH_ROTATE_H
#define YLM_SH_ROTATE_H

#include "../calibration.h"
#include "ylm_sets.h"
#include "ylm_sh.h"

/* Elements of a padded row of class order, a multiple of 64 bytes for either type. */
#define ROTATE_PAD 16
static inline int rotate_row(int lmax) {
  return (lmax / 2 + 1 + ROTATE_PAD - 1) / ROTATE_PAD * ROTATE_PAD;
}

/* A degree's block, column by column, padded to whole 64 byte vectors of `lanes` elements. */
static inline int rotate_padded(int l, int lanes) { return (2 * l + lanes) / lanes * lanes; }

/* Representations of a rotation; all but the first make quarter and half turns exact. */
typedef enum ylm__turn {
  TURN_GENERAL, /* Z(a) J Z(b) J Z(c), a and b turned by pi already */
  TURN_FLAT,    /* Z(c) */
  TURN_QUARTER, /* Z(a) J Z(c) */
  TURN_HALF     /* Z(a) H Z(c), H the half turn about x: signs */
} ylm__turn;

/* Cosines and sines of a, b, c. */
typedef struct ylm__angles {
  double c[3], s[3];
  ylm__turn turn;
} ylm__angles;

/* H for coefficient (l, m). */
static inline int half_turn_sign(int l, int m) { return ((l + m) & 1) != (m < 0) ? -1 : 1; }

/* Columns of a class at degree l. */
static inline int class_columns(int l, int c) {
  switch (c) {
  case 0: return l / 2 + 1;    /* CE: m = 0, 2 .. */
  case 1: return l / 2 + 1;    /* SE: m = 0 (zero), 2 .. */
  default: return (l + 1) / 2; /* CO, SO: m = 1, 3 .. */
  }
}
/* The class that coefficient m belongs to. */
static inline int class_of(int m) { return (m & 1) * 2 + (m < 0); }

/* The class that J takes to class c at degree l: an involution. */
static inline int class_partner(int l, int c) {
  static const int even[4] = {0, 2, 1, 3}, odd[4] = {3, 1, 2, 0};
  return l & 1 ? odd[c] : even[c];
}

/* Coefficients of a class at degree l, and the m of its first; the next are 2 away. */
static inline int class_size(int l, int c) { return c == 1 ? l / 2 : class_columns(l, c); }
static inline int class_first(int c) {
  static const int first[4] = {0, -2, 1, -1};
  return first[c];
}

/* Tables of a batch; the arrays have the batch's type. */
typedef struct ylm__rotate_batch {
  const ylm_sh_rotator *plan;
  ylm__angles angles;
  ylm__turn turn;
  int lmax;           /* of the rotation */
  int blocked;        /* degrees up to this one have blocks */
  const void *blocks; /* per degree, column by column, rotate_padded(l, 16 or 8) rows */
  const void *turns;  /* [3][2][lmax+1]: cosines and sines of m times each angle */
} ylm__rotate_batch;

/* Kernels for rows of T. */
#define YLM__ROTATE_KERNELS(T)                                                                                          \
  {                                                                                                                     \
    void (*one)(const ylm_sh_rotator *p, int lmax, const ylm__angles *a, const T *in, T *out);                          \
    /* lmax <= b->lmax; out may be in */                                                                                \
    void (*apply)(const ylm__rotate_batch *b, int lmax, size_t rows, const T *in, T *out);                              \
    /* n rotations r [n][9], of `rows` rows each; `halves`: of in, m >= 0 alone; out may be in */                       \
    void (*each)(const ylm_sh_rotator *p, int lmax, size_t n, const T *r, int rows, bool halves,                        \
                 const T *in, T *out);                                                                                  \
    /* those of n rotations whose numbers are `point`, then times factors by a product of degree   \
       lmax <= ROTATE_TIMES_LMAX by quadrature; scratch as in rotate_times.c */                    \
    void (*times)(const ylm_sh_rotator *p, const struct ylm_sh_product *q, size_t n,                                    \
                  const size_t *point, const T *r, int rows, bool halves, const T *in,                                  \
                  const T *const *factor, T *out, T *scratch, double *stage);                                           \
    /* the same, integrated with light [3] rows of that degree and mixed, [3][rows], out [n][3]; factor: NULL, or one \
       for each of these points */ \
    void (*integrate)(const ylm_sh_rotator *p, const struct ylm_sh_product *q, size_t n,                                \
                      const size_t *point, const T *r, int rows, bool halves, const T *in,                              \
                      const T *const *factor, const T *const *light, const T(*mix)[3], T *out,                          \
                      T *scratch, double *stage);                                                                       \
    /* the first of n matrices that is no rotation within ROTATE_NEAR, or n */                                          \
    size_t (*not_rotation)(size_t n, const T *r);                                                                       \
    int panel; /* rows of J in a panel */                                                                               \
    int lanes; /* half of the rows of a tile */                                                                         \
  }
typedef struct ylm__rotate_kernels_float YLM__ROTATE_KERNELS(float) ylm__rotate_kernels_float;
typedef struct ylm__rotate_kernels_double YLM__ROTATE_KERNELS(double) ylm__rotate_kernels_double;
typedef struct ylm__rotate_kernels {
  const ylm__rotate_kernels_float *f;
  const ylm__rotate_kernels_double *d;
} ylm__rotate_kernels;

/* J of degrees 0 .. lmax, one after the other, [2l+1][2l+1] row-major: quarter.c. YLM_ENOMEM. */
ylm_status ylm__sh_quarter_turns(int lmax, double *blocks);

struct ylm_sh_rotator {
  int lmax;
  const ylm__rotate_kernels *kernels; /* NULL: the plain forms */
  double *dense;                      /* J, degree after degree, [2l+1][2l+1] row-major */
  size_t *dense_at;                   /* [lmax+1] */
  double *packed_d; /* J in class order, column by column, rotate_row(l) rows each */
  float *packed_f;
  size_t *packed_at; /* [lmax+1] */
  /* J for tiles: of each class, panels of kernels->f->panel rows or what is left, column by column */
  double *panels_d;
  float *panels_f;
  size_t *panel_at; /* [lmax+1] */
  int users;        /* the caller and the rotations that were made by it */
};

/* Makes a matrix that departs from a rotation by less than ROTATE_NEAR one, to rounding: rotate_matrix.c. */
void ylm__sh_orthonormal(double m[9]);
/* Whether columns are orthonormal within so much, right-handed and finite. */
bool ylm__sh_is_rotation(const double r[9], double within);

#define X(isa)                                                                                     \
  extern const ylm__rotate_kernels_float ylm__rotate_kernels_float_##isa;                          \
  extern const ylm__rotate_kernels_double ylm__rotate_kernels_double_##isa;
YLM_SETS(X)
#undef X

#endif
