/*
** product.h - what product*.c and their kernels share. Private to csrc/sh.
**
** Quadrature: `nodes` Gauss-Legendre nodes in z, of which `half` lie at z >= 0 (one at 0 if odd),
** and `azimuths` = 4 J directions at (j + 1/2) 2pi/azimuths. All symmetries of the rule are used: z
** to -z splits degrees by the parity of l-m, the four quadrants split cosines and sines by the
** parity of m.
*/
#ifndef YLM_SH_PRODUCT_H
#define YLM_SH_PRODUCT_H

#include "../calibration.h"
#include "ylm_sets.h"
#include "ylm_sh_rival.h"

/* Tables of one element type; lanes: numbers in 64 bytes of it. */
typedef struct ylm__product_tables {
  /* dense: values of Y at one of each pair of opposite points */
  int pairs, pairs_padded; /* rounded up to lanes */
  int evens, evens_padded; /* coefficients of even degree, rounded up */
  int odds, odds_padded;
  void *values;  /* [count][pairs_padded], even degrees first */
  void *weights; /* [pairs][evens_padded + odds_padded], times the rule's weights */
  /* separable */
  int half_padded;
  void *legendre;        /* by |m|, then l = m, m+2 .., then m+1, m+3 ..: [half_padded] */
  void *back;            /* by |m|, for each parity: [half][row of l's padded], times weights */
  int *back_at;          /* [lmax+1][2] */
  void *cosines, *sines; /* [J][lmax+1] */
  /* batch: the same numbers, one node after the other */
  void *node_legendre; /* [half][l(l+1)/2+m] */
  void *node_weights;  /* [half] */
} ylm__product_tables;

struct ylm__product_kernels;

typedef struct ylm__gaunt ylm__gaunt;

struct ylm_sh_product {
  int lmax, factors;
  int degree;                   /* of the rule */
  ylm_sh_product_method method; /* never AUTO */
  const struct ylm__product_kernels *kernels;
  int nodes, half, azimuths;
  bool dense; /* one product at a time is fastest by the dense tables */
  ylm__product_tables f, d;
  ylm__gaunt *gaunt;
  const ylm_sh_rival_product *rival; /* a method of another library, and its tables; or NULL */
  void *rival_plan;
  ylm_sh_product *inner; /* of the recursive approximation: two factors */
};

/* The degree to which the sparse tables carry a product of k factors: after j of them, degrees
   above (k - j + 1) lmax cannot reach the result. */
static inline int product_gaunt_top(int lmax, int factors) { return (factors + 1) / 2 * lmax; }

/* Rows of l's padded for a vector store. */
static inline int product_padded(int n, int lanes) { return (n + lanes - 1) / lanes * lanes; }
/* Degrees l <= lmax with l - m even (parity 0) or odd (1). */
static inline int product_degrees(int lmax, int m, int parity) {
  return lmax - m - parity < 0 ? 0 : (lmax - m - parity) / 2 + 1;
}

/* Numbers of scratch for one product at a time. */
static inline size_t product_scratch(const ylm_sh_product *p, const ylm__product_tables *t) {
  size_t orders = 2 * (size_t)p->lmax + 1, quadrants = (size_t)p->azimuths / 4;
  size_t dense = 2 * (size_t)t->pairs_padded + (size_t)(t->evens_padded + t->odds_padded) + 64;
  size_t separable = (2 * orders + 8 * quadrants) * (size_t)t->half_padded + (size_t)p->lmax + 64;
  return dense > separable ? dense : separable;
}

/* Numbers of scratch for `lanes` products at a time. */
static inline size_t product_batch_scratch(const ylm_sh_product *p, size_t lanes) {
  size_t count = ylm_sh_count(p->lmax), factors = (size_t)p->factors;
  size_t orders = 2 * (size_t)p->lmax + 1, quadrants = (size_t)p->azimuths / 4;
  return ((factors + 1) * count + 8 * factors * orders + 8 * quadrants) * lanes;
}

/* Numbers of scratch for `lanes` factors that several rows share (product_shared.h), of which PRODUCT_CHUNK nodes
   have their rings at once. */
static inline size_t product_shared_scratch(const ylm_sh_product *p, size_t lanes) {
  size_t orders = 2 * (size_t)p->lmax + 1, quadrants = (size_t)p->azimuths / 4;
  return (8 * quadrants * ((size_t)p->half + 1) + 2 * PRODUCT_CHUNK * orders) * lanes;
}

/* Numbers of scratch for `lanes` rows to nodes or back. */
static inline size_t product_nodes_scratch(const ylm_sh_product *p, size_t lanes) {
  size_t quadrants = (size_t)p->azimuths / 4;
  return (ylm_sh_count(p->lmax) + 8 * (2 * (size_t)p->lmax + 1) + 8 * quadrants) * lanes;
}

/* Kernels for rows of T; `lanes` of them at once. */
#define YLM__PRODUCT_KERNELS(T)                                                                       \
  {                                                                                                   \
    void (*dense)(const ylm_sh_product *p, const T *const *c, T *out, T *scratch);                    \
    /* stage: seconds of transform, multiplication, transform back are added; or NULL */              \
    void (*separable)(const ylm_sh_product *p, const T *const *c, T *out, T *scratch,                 \
                      double *stage);                                                                 \
    /* by quadrature or by gaunt of low degree; rows: [factors][lanes]; out: [lanes] rows */          \
    void (*batch)(const ylm_sh_product *p, const T *const *rows, T *const *out, T *scratch);          \
    void (*gaunt)(int lmax, const T *a, const T *b, T *out); /* lmax <= PRODUCT_GAUNT_LOW */          \
    /* halves of batch: [lanes] rows to values at all nodes, set or multiplied, and back */           \
    void (*synthesise)(const ylm_sh_product *p, const T *const *rows, bool multiply, T *value,        \
                       T *scratch);                                                                   \
    void (*analyse)(const ylm_sh_product *p, const T *value, const T *by, T *const *out,              \
                    T *scratch);                                                                      \
    /* matrices of products: m [n][padded], symmetric, 64 bytes aligned, padded to 128 bytes a row */ \
    void (*transfer)(size_t n, size_t padded, const T *m, size_t rows, const T *in, T *out);          \
    int lanes;                                                                                        \
  }
typedef struct ylm__product_kernels_float YLM__PRODUCT_KERNELS(float) ylm__product_kernels_float;
typedef struct ylm__product_kernels_double YLM__PRODUCT_KERNELS(double) ylm__product_kernels_double;
typedef struct ylm__product_kernels {
  const ylm__product_kernels_float *f;
  const ylm__product_kernels_double *d;
} ylm__product_kernels;

#define X(isa)                                                                                     \
  extern const ylm__product_kernels_float ylm__product_kernels_float_##isa;                        \
  extern const ylm__product_kernels_double ylm__product_kernels_double_##isa;
YLM_SETS(X)
#undef X

/* The vector kernels in use; NULL for the plain forms. */
const ylm__product_kernels *ylm__product_kernels_now(void);

/* The tables of the quadrature that a plan's lmax and factors ask for: product_tables.c.
   YLM_ENOMEM; what was made is then freed with the plan. */
ylm_status ylm__product_quadrature(ylm_sh_product *p);
void ylm__product_tables_free(ylm__product_tables *t);
/* cos and sin of m times azimuth j of the rule. */
double ylm__product_cosine(int m, int j, int azimuths);
double ylm__product_sine(int m, int j, int azimuths);

/* Eigenvalues w [n] and eigenvectors, the columns of a [n][n], of the symmetric matrix a. YLM_ENOMEM. symmetric.c */
ylm_status ylm__sh_eigen(int n, double *a, double *w);

/* Integrals of Y_i Y_j Y_k, i to degree lmax, j and k to degree top >= lmax. */
ylm_status ylm__gaunt_create(int lmax, int top, ylm__gaunt **out, ylm_error *e);
void ylm__gaunt_free(ylm__gaunt *g);
size_t ylm__gaunt_count(const ylm__gaunt *g);
void ylm__gaunt_f(const ylm__gaunt *g, const float *a, const float *b, float *out);
void ylm__gaunt_d(const ylm__gaunt *g, const double *a, const double *b, double *out);

/* The rival of a method; YLM_EMISSING while its library is not there. */
ylm_status ylm__product_rival(ylm_sh_product_method m, const ylm_sh_rival_product **out,
                              ylm_error *e);

#endif
