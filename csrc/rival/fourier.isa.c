/* fourier.isa.c - products by Fourier series, compiled for each instruction set. */
#include "fourier_both.h"
#include "ylm_simd.h"

void YLM_KERNEL(ylm__fourier_run_f)(const ylm__fourier *f, const float *const *c, float *out,
                                    float *scratch, double *stage) {
  run_f(f, c, out, scratch, stage);
}

void YLM_KERNEL(ylm__fourier_run_d)(const ylm__fourier *f, const double *const *c, double *out,
                                    double *scratch, double *stage) {
  run_d(f, c, out, scratch, stage);
}
