/* product.c - products of functions given by coefficients: plans, choice of method. */
#include "product.h"

static const char *const names[] = {
#define X(name) #name,
    YLM_SH_PRODUCT_METHOD_LIST(X)
#undef X
};

const char *ylm_sh_product_method_name(ylm_sh_product_method m) {
  return (unsigned)m < YLM_SH_PRODUCT_METHOD_COUNT ? names[m] : "?";
}

const ylm__product_kernels *ylm__product_kernels_now(void) {
  switch (ylm_isa_current()) {
#define X(isa)                                                                                     \
  case YLM_ISA_##isa: {                                                                            \
    static const ylm__product_kernels kernels = {&ylm__product_kernels_float_##isa,                \
                                                 &ylm__product_kernels_double_##isa};              \
    return &kernels;                                                                               \
  }
    YLM_SETS(X)
#undef X
  default: return NULL;
  }
}

void ylm_sh_product_free(ylm_sh_product *p) {
  if (!p) return;
  ylm__product_tables_free(&p->f);
  ylm__product_tables_free(&p->d);
  ylm__gaunt_free(p->gaunt);
  if (p->rival) p->rival->free(p->rival_plan);
  ylm_sh_product_free(p->inner);
  ylm_free(p);
}

static ylm_sh_product_method best(int lmax, int factors) {
  if (factors == 2 && lmax <= PRODUCT_GAUNT_LOW) return YLM_SH_PRODUCT_gaunt;
  return YLM_SH_PRODUCT_quadrature;
}

/* The tables of a method of another library. */
static ylm_status create_rival(ylm_sh_product *p, ylm_error *e) {
  ylm_status s = ylm__product_rival(p->method, &p->rival, e);
  return s == YLM_OK ? p->rival->create(p->lmax, p->factors, &p->rival_plan, e) : s;
}

ylm_status ylm_sh_product_create(int lmax, int factors, ylm_sh_product_method method,
                                 ylm_sh_product_method inner, ylm_sh_product **out, ylm_error *e) {
  *out = NULL;
  if (lmax < 0 || lmax > YLM_SH_PRODUCT_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax of a product must be from 0 to %d, got %d",
                    YLM_SH_PRODUCT_LMAX, lmax);
  if (factors < 2 || factors > YLM_SH_PRODUCT_FACTORS)
    return ylm_fail(e, YLM_ERANGE, "a product of 2 to %d factors expected, got %d",
                    YLM_SH_PRODUCT_FACTORS, factors);
  if ((unsigned)method >= YLM_SH_PRODUCT_METHOD_COUNT ||
      (unsigned)inner >= YLM_SH_PRODUCT_METHOD_COUNT)
    return ylm_fail(e, YLM_EINVAL, "no such method");
  if (method == YLM_SH_PRODUCT_auto) method = best(lmax, factors);
  if (method == YLM_SH_PRODUCT_recursive && inner == YLM_SH_PRODUCT_recursive)
    return ylm_fail(e, YLM_EINVAL, "the steps of 'recursive' need another method");
  ylm_sh_product *p = ylm_alloc_zero(1, sizeof *p);
  if (!p) return YLM_ENOMEM;
  p->lmax = lmax;
  p->factors = factors;
  p->degree = (factors + 1) * lmax;
  p->method = method;
  p->kernels = ylm__product_kernels_now();
  ylm_status s = YLM_OK;
  switch (method) {
  case YLM_SH_PRODUCT_gaunt:
    s = ylm__gaunt_create(lmax, product_gaunt_top(lmax, factors), &p->gaunt, e);
    break;
  case YLM_SH_PRODUCT_fourier:
  case YLM_SH_PRODUCT_brute:
  case YLM_SH_PRODUCT_list: s = create_rival(p, e); break;
  case YLM_SH_PRODUCT_recursive:
    s = ylm_sh_product_create(lmax, 2, inner, inner, &p->inner, e);
    break;
  default: s = ylm__product_quadrature(p);
  }
  if (s != YLM_OK) {
    ylm_sh_product_free(p);
    return s;
  }
  *out = p;
  return YLM_OK;
}

ylm_sh_product_method ylm_sh_product_method_of(const ylm_sh_product *p) { return p->method; }
size_t ylm_sh_product_integrals(const ylm_sh_product *p) { return ylm__gaunt_count(p->gaunt); }
