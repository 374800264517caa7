/*
** fourier.h - products by Fourier series, as in Xin et al. 2021, Sec. 4. Private to csrc/rival.
**
** A function of degree d on the torus is f = sum over t of g_t(theta) e^(i t phi). Its g_t = sum
** over s of f_st e^(i s theta), |s|, |t| <= d; being real, f is kept for t >= 0: [2d+1][d+1], s
** from -d. A convolution is a product of values at N x N angles: transforms of length N along s for
** all t, then along t for two rows of theta at once, as real and imaginary part.
*/
#ifndef YLM_RIVAL_FOURIER_H
#define YLM_RIVAL_FOURIER_H

#include "rival.h"
#include "ylm_sets.h"

#define FOURIER_LEVELS 20 /* radix steps of a transform at most */

/* A transform's length: products of 2, 3, 4 and 5. */
typedef struct ylm__fft {
  int n, steps, radix[FOURIER_LEVELS];
  double *twiddle_d; /* [n][2], e^(2 pi i k/n) */
  float *twiddle_f;
} ylm__fft;

typedef struct ylm__fourier {
  int lmax, factors, ffts;
  ylm__fft *fft; /* one for each number of factors 2 .. factors: [factors+1] */
  double *series_d,
      *back_d; /* series: (l,m >= 0): coefficients s = l, l-2 ..; back: (l,m): s = l mod 2 .. */
  float *series_f, *back_f;
  size_t *series_at, *back_at; /* [(lmax+1)(lmax+2)/2] */
} ylm__fourier;

/* Numbers in a function of degree d: real parts, then imaginary parts. */
static inline size_t fourier_size(int d) { return 2 * (size_t)(2 * d + 1) * (size_t)(d + 1); }
/* Numbers of scratch of a convolution of length n: four grids of complex numbers. */
static inline size_t fourier_grid(int n) { return (size_t)n * (size_t)n * 8; }

/* out = the product of the factors c, at `stage` [3] the seconds of its parts, unless that is NULL. */
typedef void ylm__fourier_run_float(const ylm__fourier *f, const float *const *c, float *out,
                                    float *scratch, double *stage);
typedef void ylm__fourier_run_double(const ylm__fourier *f, const double *const *c, double *out,
                                     double *scratch, double *stage);
#define X(isa)                                                                                     \
  ylm__fourier_run_float ylm__fourier_run_f_##isa;                                                 \
  ylm__fourier_run_double ylm__fourier_run_d_##isa;
X(reference)
YLM_SETS(X)
#undef X

#endif
