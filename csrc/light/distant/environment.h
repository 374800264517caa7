/* environment.h - what panoramas and environments share. Private to csrc/light. */
#ifndef YLM_LIGHT_ENVIRONMENT_H
#define YLM_LIGHT_ENVIRONMENT_H

#include "distant.h"

/* Copies records of kind "environment" as ylm__distant_copy does; the field has no `evaluate` yet. */
ylm_status ylm__environment_copy(ylm__distant *d, size_t n, const double *const *record,
                                 ylm_error *e);
/* Evaluates the field of n environments, `projected` from a panorama: errors say so. */
ylm_status ylm__environment_evaluate(const ylm__distant *d, bool projected,
                                     const ylm_field_query *q, size_t n, const void *points,
                                     ylm_field_result *r, ylm_error *e);

#endif
