/* fourier_both.h - fourier_kernel.h for both element types. */
#include "fourier.h"

#include <string.h>

#define T float
#define FN(name) name##_f
#define TWIDDLE twiddle_f
#define SERIES series_f
#define BACK back_f
#include "fourier_kernel.h"

#undef T
#undef FN
#undef TWIDDLE
#undef SERIES
#undef BACK
#define T double
#define FN(name) name##_d
#define TWIDDLE twiddle_d
#define SERIES series_d
#define BACK back_d
#include "fourier_kernel.h"
