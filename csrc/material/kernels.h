/* kernels.h - eval, sample and pdf of kinds once per instruction set; each kind's own file has the
   plain form, which judges the others. Private to csrc/material. */
#ifndef YLM_MATERIAL_KERNELS_H
#define YLM_MATERIAL_KERNELS_H

#include <stddef.h>

/* As in ylm_material.h; p: what the kind has made of its numbers. */
typedef void material_eval_fn(const void *p, size_t n, const float (*wi)[3], const float (*wo)[3],
                              float (*f)[3]);
typedef void material_sample_fn(const void *p, size_t n, const float (*wo)[3], const float (*u)[3],
                                float (*wi)[3], float (*weight)[3], float *pdf);
typedef void material_pdf_fn(const void *p, size_t n, const float (*wi)[3], const float (*wo)[3],
                             float *pdf);

typedef struct material_kernels {
  material_eval_fn *eval;
  material_sample_fn *sample;
  material_pdf_fn *pdf;
} material_kernels;

#define MATERIAL_KERNELS(X) X(matte) X(ggx) X(phong) X(abc)

/* The set in use; ylm__material_NAME_plain where there is none. */
#define X(name)                                                                                    \
  extern const material_kernels ylm__material_##name##_plain;                                      \
  const material_kernels *ylm__material_##name##_kernels(void);
MATERIAL_KERNELS(X)
#undef X

#endif
