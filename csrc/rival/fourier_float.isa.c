/* fourier_float.isa.c - products by Fourier series in float, for each instruction set. */
#define YLM_REAL_IS_FLOAT
#include "fourier_kernel.h"
