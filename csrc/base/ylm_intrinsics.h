/*
** ylm_intrinsics.h - the intrinsics of kernels: square roots, estimates, masks.
**
** gcc reads <immintrin.h> for 0.2 s, in each of a hundred compilations; the parts of it that are used take a tenth of
** that. They refuse to be included by others, so that its guard is set for them and taken back.
*/
#ifndef YLM_INTRINSICS_H
#define YLM_INTRINSICS_H

#if defined(__x86_64__)
#if defined(__clang__) || __GNUC__ > 14 || defined(_IMMINTRIN_H_INCLUDED)
#include <immintrin.h>
#else
#include <smmintrin.h>
#define _IMMINTRIN_H_INCLUDED
#ifdef __AVX2__
#include <avxintrin.h>
#endif
#ifdef __AVX512F__
/* each needs those before it */
/* clang-format off */
#include <avx2intrin.h>
#include <avx512fintrin.h>
#include <avx512dqintrin.h>
/* clang-format on */
#endif
#undef _IMMINTRIN_H_INCLUDED
#endif
#endif

#endif
