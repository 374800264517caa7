/* fourier_double.c - products by Fourier series in double, for any processor. */
#include "fourier_kernel.h"
