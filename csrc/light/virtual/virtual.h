/* virtual.h - what the files of csrc/light/virtual share. Private to the folder. */
#ifndef YLM_LIGHT_VIRTUAL_PRIVATE_H
#define YLM_LIGHT_VIRTUAL_PRIVATE_H

#include "../kind.h"
#include "../set.h"
#include "ylm_light_virtual.h"

/* Widths of a Gaussian light: sg = r GAUSS_WIDTH, eps = sg GAUSS_SOFT. */
#define YLM__GAUSS_WIDTH 0.5
#define YLM__GAUSS_SOFT 0.25

struct ylm_light_virtual {
  ylm_field field; /* whose `self` it is */
  size_t users, n;
  int degree;
  ylm_light_virtual_profile profile;
  double core;
  double outer; /* of `far` beyond levels.c: a larger core whose far part is not in it; else 0 */
  double *at, *normal, *radius, *shift; /* [n][3], [n][3], [n], [n]: one block of memory */
  double origin[3];                     /* ylm_origin of the lights */
  double *local;                  /* [n][3] places relative to it; `at` itself where it is 0 */
  double *emission;               /* [n][3][(degree+1)^2] */
  size_t stride;                  /* numbers of a light as kernels see it: plan.h */
  float *seen;                    /* [n][stride] */
  struct ylm__virtual_tree *tree; /* NULL until a cut needs it */
};

/* Their field to a tolerance, by their tree, which is made where there is none: rows of kind.h. tree.c */
ylm_status ylm__virtual_within(void *of, double tolerance, int threads, ylm_field **field,
                               ylm_error *e);
void ylm__virtual_within_free(ylm_field *field);
ylm_status ylm__virtual_within_evaluate(const void *within, ylm_isa isa, const ylm_field_query *q,
                                        size_t n, const void *points, ylm_field_result *r,
                                        ylm_error *e);
size_t ylm__virtual_within_bytes(const void *of);
void ylm__virtual_tree_free(struct ylm__virtual_tree *tree);

/* Fills origin, local places, and what kernels in float see; YLM_ENOMEM. plan.c */
ylm_status ylm__virtual_settle(ylm_light_virtual *v);

/* The reference: product rule, double, points begin .. end-1. */
ylm_status ylm__virtual_reference(const ylm_light_virtual *lights, const ylm_field_query *q,
                                  size_t begin, size_t end, const void *points,
                                  ylm_field_result *r);

#endif
