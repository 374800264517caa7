/* within.isa.c - the largest numbers of arrays, once per instruction set; loops that the compiler makes vectors of. */
#include "ylm_simd.h"

#include "within.h"

YLM__MAGNITUDE(of_float, float, int32_t, INT32_MAX);
YLM__MAGNITUDE(of_double, double, int64_t, INT64_MAX);

const ylm__magnitudes YLM_KERNEL(ylm_k_magnitudes) = {of_float, of_double};
