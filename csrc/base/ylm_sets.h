/*
** ylm_sets.h - the kernel sets that this build has, and the choice of a kernel among them.
**
** A file x.isa.c is compiled once for each set (ISAS in the Makefile). The names of its kernels end
** with the set's. The reference is no such set: it is in every build.
*/
#ifndef YLM_SETS_H
#define YLM_SETS_H

#include "ylm_base.h"

/* F(isa, ...) for each set, worst first: the Makefile says which it builds. */
#if __has_include(<ylm_built_sets.h>)
#include <ylm_built_sets.h> /* of the build folder: the Makefile writes it */
#elif defined(__x86_64__)
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

/*
** YLM_KERNEL_CHOICE - defines the function that gives the kernel in use.
**
**   YLM_KERNEL_CHOICE(sum_fn, ylm__sum, ylm_k_sum, plain);
**
** is `sum_fn *ylm__sum(void)`: the address of ylm_k_sum_avx2 or its like of another set, which files
** x.isa.c define, or `plain` by default, which may be NULL. Kernels are functions, or tables of them
** (`const type`). YLM_KERNEL_CHOICE_OF is the same for a set that is given: `sum_fn *ylm__sum(ylm_isa isa)`.
** `static` may stand before either.
*/
#define YLM_KERNEL_CHOICE(type, function, name, plain)                                             \
  type *function(void) { YLM__KERNEL_OF(type, ylm_isa_current(), name, plain) }                    \
  _Static_assert(1, "a semicolon follows")
#define YLM_KERNEL_CHOICE_OF(type, function, name, plain)                                          \
  type *function(ylm_isa isa) { YLM__KERNEL_OF(type, isa, name, plain) }                           \
  _Static_assert(1, "a semicolon follows")

#define YLM__SET_CASE(isa, name)                                                                   \
  case YLM_ISA_##isa:                                                                              \
    return &name##_##isa;
#define YLM__KERNEL_OF(type, set, name, plain)                                                     \
  YLM_SETS_DECLARE(type, name)                                                                     \
  switch (set) {                                                                                   \
    YLM_SETS_WITH(YLM__SET_CASE, name)                                                             \
  default: return plain;                                                                           \
  }

#endif
