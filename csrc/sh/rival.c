/* rival.c - methods that another library registers: see ylm_sh_rival.h. */
#include "ylm_sh_rival.h"

#include <stdatomic.h>

#include "eval/sh_eval.h"
#include "product/product.h"

/* Tables by method; NULL until they are set. */
static _Atomic(const ylm_sh_rival_eval *const *) evals;
static _Atomic(const ylm_sh_rival_product *const *) products;

void ylm_sh_rivals_set(const ylm_sh_rival_eval *const eval[YLM_SH_METHOD_COUNT],
                       const ylm_sh_rival_product *const product[YLM_SH_PRODUCT_METHOD_COUNT]) {
  atomic_store(&evals, eval);
  atomic_store(&products, product);
}

static ylm_status missing(const char *method, ylm_error *e) {
  return ylm_fail(e, YLM_EMISSING, "method '%s' needs libylm_rival: call ylm_rival_register()",
                  method);
}

ylm_status ylm__sh_rival(ylm_sh_method m, const ylm_sh_rival_eval **out, ylm_error *e) {
  const ylm_sh_rival_eval *const *all = atomic_load(&evals);
  *out = all ? all[m] : NULL;
  return *out ? YLM_OK : missing(ylm_sh_method_name(m), e);
}

ylm_status ylm__product_rival(ylm_sh_product_method m, const ylm_sh_rival_product **out,
                              ylm_error *e) {
  const ylm_sh_rival_product *const *all = atomic_load(&products);
  *out = all ? all[m] : NULL;
  return *out ? YLM_OK : missing(ylm_sh_product_method_name(m), e);
}

/* -- what rivals share with the reference kernel -- */

void ylm_sh_unit(const double v[3], double w[3], double *d) { ylm__sh_unit(v, w, d); }
void ylm_sh_scale_solid(int l, double d, double s[10]) { ylm__sh_scale_solid(l, d, s); }
void ylm_sh_surface(int l, double d, const double w[3], double s[10]) {
  ylm__sh_surface(l, d, w, s);
}
