/* register.c - the library's methods by name. */
#include "rival.h"
#include "ylm_rival.h"

void ylm_rival_register(void) {
  static const ylm_sh_rival_eval *const evals[YLM_SH_METHOD_COUNT] = {
      [YLM_SH_polynomial] = &ylm__rival_polynomial,
      [YLM_SH_direct] = &ylm__rival_direct,
      [YLM_SH_sloan] = &ylm__rival_sloan,
      [YLM_SH_scd] = &ylm__rival_scd};
  static const ylm_sh_rival_product *const products[YLM_SH_PRODUCT_METHOD_COUNT] = {
      [YLM_SH_PRODUCT_fourier] = &ylm__rival_fourier,
      [YLM_SH_PRODUCT_brute] = &ylm__rival_brute,
      [YLM_SH_PRODUCT_list] = &ylm__rival_list};
  ylm_sh_rivals_set(evals, products);
  ylm_material_rival_set(ylm__rival_nearest);
}
