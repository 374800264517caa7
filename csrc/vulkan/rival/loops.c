/*
** loops.c - lights summed one by one by the product rule (shaders/product.real.comp), to compare with.
**
** YLM_GPU_FORWARD   one dispatch has the sums of all orders m, and may run out of registers
** YLM_GPU_REVERSED  a dispatch for each order, which evaluates every light anew
** Source  Mezieres et al. 2022, Sec. 5.1
*/
#include "../light/lights.h"

ylm_status ylm__loops_check(const ylm_gpu_lights *l, const ylm_field_query *q, ylm_error *e) {
  if (!ylm__loops(l) || q->lmax <= YLM_GPU_PRODUCT_LMAX || q->lmax > YLM_LIGHT_LMAX) return YLM_OK;
  return ylm_fail(e, YLM_ERANGE,
                  "lmax must be 0 .. %d for lights on a device with this method, got %d",
                  YLM_GPU_PRODUCT_LMAX, q->lmax);
}

/* The number of sums of one order m. */
static uint32_t width_of(int lmax, uint32_t kinds, int m) {
  static const int parts[3] = {1, 4, 10}; /* value; and gradient; and Hessian */
  int n = (lmax + 1 - m) * parts[ylm__sum_derivatives(kinds)];
  return (uint32_t)(m ? 2 * n : n);
}

void ylm__loops_cut(const ylm_gpu_lights *l, int lmax, sum_set *set) {
  for (int m = 0; m <= lmax; m++) {
    if (m == 0 || l->method == YLM_GPU_REVERSED)
      set->pass[set->passes++] = (struct sum_pass){.m_first = (uint32_t)m, .loops = true};
    struct sum_pass *last = &set->pass[set->passes - 1];
    uint32_t n = width_of(lmax, set->kinds, m);
    last->m_last = (uint32_t)m;
    last->sums += n;
    set->sums += n;
  }
}
