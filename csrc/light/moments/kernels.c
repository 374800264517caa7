/* kernels.c - finds the kernels of an instruction set. */
#include "plan.h"
#include "ylm_sets.h"

#define DECLARE(isa, lmax)                                                                         \
  extern const ylm__moment_kernel ylm__moments_##lmax##_float_##isa,                               \
      ylm__moments_##lmax##_double_##isa;
#define ENTRY(isa, lmax) {&ylm__moments_##lmax##_float_##isa, &ylm__moments_##lmax##_double_##isa},
#define SET(isa)                                                                                   \
  YLM__SPECIAL_LIST(DECLARE, isa)                                                                  \
  DECLARE(isa, any)                                                                                \
  ylm__sum_range ylm__sum_range_float_##isa, ylm__sum_range_double_##isa;                          \
  ylm__tree_range ylm__tree_range_float_##isa, ylm__tree_range_double_##isa;                       \
  ylm_light_lambda2_fn ylm__lambda2_##isa;                                                         \
  static void find_##isa(int lmax, ylm_dtype t, ylm__kernel_set *set) {                            \
    static const ylm__moment_kernel *const special[][2] = {YLM__SPECIAL_LIST(ENTRY, isa)           \
                                                               ENTRY(isa, any)};                   \
    int at = lmax <= YLM__SPECIAL ? lmax : YLM__SPECIAL + 1;                                       \
    set->moments = special[at][t == YLM_DOUBLE];                                                   \
    set->range = t == YLM_DOUBLE ? ylm__sum_range_double_##isa : ylm__sum_range_float_##isa;       \
    set->tree = t == YLM_DOUBLE ? ylm__tree_range_double_##isa : ylm__tree_range_float_##isa;      \
    set->lambda2 = ylm__lambda2_##isa;                                                             \
  }
#define CASE(isa)                                                                                  \
  case YLM_ISA_##isa: find_##isa(lmax, t, set); return true;

YLM_SETS(SET)

bool ylm__kernels_of(ylm_isa isa, int lmax, ylm_dtype t, ylm__kernel_set *set) {
  switch (isa) {
    YLM_SETS(CASE)
  default: return false;
  }
}
