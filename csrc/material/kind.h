/* kind.h - what a kind of material is. Private to csrc/material. */
#ifndef YLM_MATERIAL_KIND_H
#define YLM_MATERIAL_KIND_H

#include "ylm_material.h"

/* A kind's functions, which ylm_material.h describes; x: the numbers of a material. */
typedef struct material_kind {
  const char *name;
  size_t numbers; /* at most YLM_MATERIAL_NUMBERS */
  ylm_status (*check)(const float *x, ylm_error *e);
  ylm_status (*transfer)(int lmax, double *a);
  void (*albedo)(const float *x, float albedo[3]);
  void (*radiance)(const float *x, size_t n, float *light);
  void (*reflect)(const float *x, const double irradiance[3], float radiance[3]);
  void (*row)(const float *x, float *row); /* NULL: shaders do not have the kind */
  bool (*isotropic)(const float *x);
  void (*eval)(const float *x, size_t n, const float (*wi)[3], const float (*wo)[3], float (*f)[3]);
  void (*sample)(const float *x, size_t n, const float (*wo)[3], const float (*u)[3],
                 float (*wi)[3], float (*weight)[3], float *pdf);
  void (*pdf)(const float *x, size_t n, const float (*wi)[3], const float (*wo)[3], float *pdf);
} material_kind;

/* Each X(name) is a file name.c with ylm__material_name. */
#define MATERIAL_KINDS(X) X(matte)

#define X(name) extern const material_kind ylm__material_##name;
MATERIAL_KINDS(X)
#undef X

#endif
