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

static void facts(const ylm_material *m, ylm_material_fact *fact, void *to) {
  ylm__merl_facts(m->table, fact, to);
}

static bool isotropic(const ylm_material *m) {
  (void)m;
  return true;
}

static void eval(const ylm_material *m, size_t n, const float (*wi)[3], const float (*wo)[3],
                 float (*f)[3]) {
  ylm__merl_eval(m->table, n, wi, wo, f);
}

static void sample(const ylm_material *m, size_t n, const float (*wo)[3], const float (*u)[3],
                   float (*wi)[3], float (*weight)[3], float *pdf) {
  ylm__merl_sample(m->table, n, wo, u, wi, weight, pdf);
}

static void pdf(const ylm_material *m, size_t n, const float (*wi)[3], const float (*wo)[3],
                float *out) {
  ylm__merl_pdf(m->table, n, wi, wo, out);
}

const material_kind ylm__material_tabulated = {.name = "tabulated",
                                               .check = check,
                                               .load = load,
                                               .facts = facts,
                                               .isotropic = isotropic,
                                               .eval = eval,
                                               .sample = sample,
                                               .pdf = pdf};
