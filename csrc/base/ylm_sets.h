/*
** ylm_sets.h - the kernel sets that this build has, and the choice of a kernel among them.
**
** A file x.isa.c is compiled once for each set (ISAS in the Makefile). The names of its kernels end
** with the set's. The reference is no such set: it is in every build.
*/
#ifndef YLM_SETS_H
#define YLM_SETS_H

#include "ylm_base.h"

/* F(isa, ...) for each set, worst first. */
#if defined(__x86_64__)
#define YLM_SETS_WITH(F, ...) F(sse2, __VA_ARGS__) F(avx2, __VA_ARGS__) F(avx512, __VA_ARGS__)
#elif defined(__aarch64__)
#define YLM_SETS_WITH(F, ...) F(neon, __VA_ARGS__)
#else
#define YLM_SETS_WITH(F, ...)
#endif

/* X(isa) for each set. */
#define YLM__SET_ALONE(isa, X) X(isa)
#define YLM_SETS(X) YLM_SETS_WITH(YLM__SET_ALONE, X)

/* The declarations of kernels of a type: name_sse2, ... */
#define YLM__SET_DECLARE(isa, type, name) extern type name##_##isa;
#define YLM_SETS_DECLARE(type, name) YLM_SETS_WITH(YLM__SET_DECLARE, type, name)

/* The cases of a switch over a ylm_isa that return them. */
#define YLM__SET_RETURN(isa, name)                                                                 \
  case YLM_ISA_##isa:                                                                              \
    return name##_##isa;
#define YLM_SETS_RETURN(name) YLM_SETS_WITH(YLM__SET_RETURN, name)

#endif
