/* table.c - the methods as ylm_shade_gather_virtual asks them, and the choice of their kernels. */
#include "many.h"
#include "ylm_rival.h"
#include "ylm_sets.h"

#define X(isa)                                                                                     \
  ylm_many_weights_fn ylm_k_many_points_##isa, ylm_k_many_gaussians_##isa;                         \
  ylm_many_gloss_fn ylm_k_many_gaussians_gloss_##isa;                                              \
  ylm_many_spheres_fn ylm_k_many_spheres_##isa;
YLM_SETS(X)
#undef X

/* Kernels of one instruction set, or the plain forms. */
typedef struct forms {
  ylm_many_weights_fn *points, *gaussians;
  ylm_many_gloss_fn *gaussians_gloss;
  ylm_many_spheres_fn *spheres;
} forms;

static forms choose(void) {
  switch (ylm_isa_current()) {
#define X(isa)                                                                                     \
  case YLM_ISA_##isa:                                                                              \
    return (forms){ylm_k_many_points_##isa, ylm_k_many_gaussians_##isa,                            \
                   ylm_k_many_gaussians_gloss_##isa, ylm_k_many_spheres_##isa};
    YLM_SETS(X)
#undef X
  default:
    return (forms){ylm__many_points, ylm__many_gaussians, ylm__many_gaussians_gloss,
                   ylm__many_spheres};
  }
}

static void kernels(ylm_shade_gather_method method, ylm_many_kernels *k) {
  forms f = choose();
  if (method == YLM_SHADE_VPL) k->weights = f.points;
  if (method == YLM_SHADE_VSGL) k->weights = f.gaussians, k->gloss = f.gaussians_gloss;
  if (method == YLM_SHADE_VSL) {
    k->spheres = f.spheres;
    k->spheres_gloss = ylm__many_spheres_gloss;
  }
}

const ylm_shade_rival *ylm_rival_many(void) {
  static const ylm_shade_rival table = {kernels, ylm__many_parts, ylm__many_compensate,
                                        ylm__many_filter};
  return &table;
}
