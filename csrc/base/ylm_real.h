/*
** ylm_real.h - the element type of a unit of kernels: float where YLM_REAL_IS_FLOAT is defined, else double.
**
** A kernel for both types is written once, with plain names, for `real` and its vectors:
** x_float.isa.c defines YLM_REAL_IS_FLOAT and includes x_kernel.h, x_double.isa.c includes x_kernel.h.
** Only entries have other names in each: YLM_REAL_KERNEL(name) is name_float_avx2 and so on.
*/
#ifndef YLM_REAL_H
#define YLM_REAL_H

#include "ylm_simd.h"

#ifdef YLM_REAL_IS_FLOAT
typedef float real;
typedef ylm_vf vreal;
typedef ylm_vi vmask;
#define LANES YLM_VF
#define YLM_REAL_KERNEL(name) YLM_KERNEL(name##_float)
#define vreal_set ylm_vf_set
#define vreal_load ylm_vf_load
#define vreal_store ylm_vf_store
#define vreal_sqrt ylm_vf_sqrt
#else
typedef double real;
typedef ylm_vd vreal;
typedef ylm_vl vmask;
#define LANES YLM_VD
#define YLM_REAL_KERNEL(name) YLM_KERNEL(name##_double)
#define vreal_set ylm_vd_set
#define vreal_load ylm_vd_load
#define vreal_store ylm_vd_store
#define vreal_sqrt ylm_vd_sqrt
#endif

#endif
