/*
** ylm_simd.h - vectors for kernels that are compiled once per instruction set.
**
** A file `name.isa.c` is compiled by the Makefile for each set with YLM_ISA
** (avx2, ...) and YLM_VECTOR_BYTES (16, 32, 64) defined. The file calls its entry points
** YLM_KERNEL(name), which become name_avx2 and so on. Types: ylm_vf and ylm_vd hold YLM_VF floats
** and YLM_VD doubles; the usual operators work on them (GCC and Clang vector extensions).
*/
#ifndef YLM_SIMD_H
#define YLM_SIMD_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "ylm_intrinsics.h"

#ifndef YLM_ISA
#error "ylm_simd.h is for *.isa.c files: YLM_ISA is not defined"
#endif

#define YLM_PASTE_(a, b) a##_##b
#define YLM_PASTE(a, b) YLM_PASTE_(a, b)
#define YLM_KERNEL(name) YLM_PASTE(name, YLM_ISA)

#define YLM_VF (YLM_VECTOR_BYTES / 4)
#define YLM_VD (YLM_VECTOR_BYTES / 8)

typedef float ylm_vf __attribute__((vector_size(YLM_VECTOR_BYTES)));
typedef double ylm_vd __attribute__((vector_size(YLM_VECTOR_BYTES)));
typedef int32_t ylm_vi __attribute__((vector_size(YLM_VECTOR_BYTES)));
typedef int64_t ylm_vl __attribute__((vector_size(YLM_VECTOR_BYTES)));

#define YLM_INLINE static inline __attribute__((always_inline))

YLM_INLINE ylm_vf ylm_vf_set(float x) { return x - (ylm_vf){0}; }
YLM_INLINE ylm_vd ylm_vd_set(double x) { return x - (ylm_vd){0}; }
YLM_INLINE ylm_vf ylm_vf_load(const float *p) {
  ylm_vf v;
  memcpy(&v, p, sizeof v);
  return v;
}
YLM_INLINE ylm_vd ylm_vd_load(const double *p) {
  ylm_vd v;
  memcpy(&v, p, sizeof v);
  return v;
}
YLM_INLINE void ylm_vf_store(float *p, ylm_vf v) { memcpy(p, &v, sizeof v); }
YLM_INLINE void ylm_vd_store(double *p, ylm_vd v) { memcpy(p, &v, sizeof v); }

/* Lane-wise choice: a where the mask is set, else b. */
YLM_INLINE ylm_vf ylm_vf_select(ylm_vi m, ylm_vf a, ylm_vf b) {
  return (ylm_vf)(((ylm_vi)a & m) | ((ylm_vi)b & ~m));
}
YLM_INLINE ylm_vd ylm_vd_select(ylm_vl m, ylm_vd a, ylm_vd b) {
  return (ylm_vd)(((ylm_vl)a & m) | ((ylm_vl)b & ~m));
}

/* Square roots, correctly rounded. */
YLM_INLINE ylm_vf ylm_vf_sqrt(ylm_vf x) {
#if defined(__AVX512F__)
  return (ylm_vf)_mm512_sqrt_ps((__m512)x);
#elif defined(__AVX2__)
  return (ylm_vf)_mm256_sqrt_ps((__m256)x);
#elif defined(__x86_64__)
  return (ylm_vf)_mm_sqrt_ps((__m128)x);
#else
  for (int i = 0; i < YLM_VF; i++) x[i] = sqrtf(x[i]);
  return x;
#endif
}
YLM_INLINE ylm_vd ylm_vd_sqrt(ylm_vd x) {
#if defined(__AVX512F__)
  return (ylm_vd)_mm512_sqrt_pd((__m512d)x);
#elif defined(__AVX2__)
  return (ylm_vd)_mm256_sqrt_pd((__m256d)x);
#elif defined(__x86_64__)
  return (ylm_vd)_mm_sqrt_pd((__m128d)x);
#else
  for (int i = 0; i < YLM_VD; i++) x[i] = sqrt(x[i]);
  return x;
#endif
}

#endif
