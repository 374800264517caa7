/* plain.h - the plain forms of kinds that say f and the density of samples at once: in double, pair by
   pair. They judge the kernels. Private to csrc/material. */
#ifndef YLM_MATERIAL_PLAIN_H
#define YLM_MATERIAL_PLAIN_H

#include <stddef.h>

#include "kernels.h"

/* f and the density of samples for two directions above the surface; p: what the kind has made of
   its numbers. */
typedef double plain_both_fn(const void *p, const double wi[3], const double wo[3], double f[3]);
/* A direction by three numbers. */
typedef void plain_choose_fn(const void *p, const double wo[3], const float u[3], double wi[3]);

/* As in ylm_material.h. */
void ylm__plain_eval(plain_both_fn *both, const void *p, size_t n, const float (*wi)[3],
                     const float (*wo)[3], float (*f)[3]);
void ylm__plain_pdf(plain_both_fn *both, const void *p, size_t n, const float (*wi)[3],
                    const float (*wo)[3], float *pdf);
void ylm__plain_sample(plain_both_fn *both, plain_choose_fn *choose, const void *p, size_t n,
                       const float (*wo)[3], const float (*u)[3], float (*wi)[3],
                       float (*weight)[3], float *pdf);

/* The plain kernels of a kind whose file has `both` and `choose`. */
#define PLAIN_KERNELS(name)                                                                        \
  static void eval_plain(const void *p, size_t n, const float(*wi)[3], const float(*wo)[3],        \
                         float(*f)[3]) {                                                           \
    ylm__plain_eval(both, p, n, wi, wo, f);                                                        \
  }                                                                                                \
  static void pdf_plain(const void *p, size_t n, const float(*wi)[3], const float(*wo)[3],         \
                        float *pdf) {                                                              \
    ylm__plain_pdf(both, p, n, wi, wo, pdf);                                                       \
  }                                                                                                \
  static void sample_plain(const void *p, size_t n, const float(*wo)[3], const float(*u)[3],       \
                           float(*wi)[3], float(*weight)[3], float *pdf) {                         \
    ylm__plain_sample(both, choose, p, n, wo, u, wi, weight, pdf);                                 \
  }                                                                                                \
  const material_kernels ylm__material_##name##_plain = {eval_plain, sample_plain, pdf_plain};

/* wo mirrored at a visible normal of GGX microfacets: visible.h. */
void ylm__plain_mirrored(double ax, double ay, const double wo[3], const float u[3], double wi[3]);
/* A direction as the cosine. */
void ylm__plain_cosine(const float u[3], double wi[3]);

#endif
