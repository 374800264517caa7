/* tabulated.c - reflectance that a function has filled MERL's bins with; see ylm_material.h. */
#include <math.h>
#include <string.h>

#include "kind.h"
#include "merl.h"

static ylm_status check(const float *x, ylm_error *e) {
  (void)x, (void)e;
  return YLM_OK;
}

/* The bytes are floats [MERL_THETA_H][MERL_THETA_D][MERL_PHI_D][3]. */
static ylm_status load(ylm_material *m, const unsigned char *bytes, size_t size, const char *name,
                       ylm_error *e) {
  size_t bins = (size_t)MERL_THETA_H * MERL_THETA_D * MERL_PHI_D;
  if (size != bins * 3 * sizeof(float))
    return ylm_fail(e, YLM_ESHAPE, "%s: %zu bytes, but %zu bins of three floats take %zu", name,
                    size, bins, bins * 3 * sizeof(float));
  merl_table *t = ylm__merl_new(MERL_PHI_D, &m->bytes);
  if (!t) return YLM_ENOMEM;
  m->table = t;
  for (size_t i = 0; i < bins; i++) {
    float *bin = t->bin[i], f[3];
    memcpy(f, bytes + i * sizeof f, sizeof f);
    bin[3] = 1;
    for (int c = 0; c < 3; c++) {
      if (!isfinite(f[c])) return ylm_fail(e, YLM_EDOMAIN, "%s: a number is not finite", name);
      if (f[c] < 0) bin[3] = 0;
      bin[c] = f[c];
    }
  }
  t->linear = true;
  ylm__merl_complete(t);
  return YLM_OK;
}

const material_kind ylm__material_tabulated = {.name = "tabulated",
                                               .check = check,
                                               .load = load,
                                               .facts = ylm__merl_facts,
                                               .isotropic = ylm__merl_isotropic,
                                               .kernels = ylm__merl_kernels};
