/* fourier_double.isa.c - products by Fourier series in double, for each instruction set. */
#include "fourier_kernel.h"
