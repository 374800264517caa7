/* fourier_float.c - products by Fourier series in float, for any processor. */
#define YLM_REAL_IS_FLOAT
#include "fourier_kernel.h"
