/* distant.h - fields of distant lights: the same at every point. Private to csrc/light. */
#ifndef YLM_LIGHT_DISTANT_H
#define YLM_LIGHT_DISTANT_H

#include "kind.h"

/* A query is sound; lmax <= most, which `what` says of itself. */
ylm_status ylm__distant_check(const ylm_field_query *q, size_t n, const void *points,
                              const ylm_field_result *r, int most, const char *what, ylm_error *e);
/* Writes coefficients [3][(lmax+1)^2] for all n points; derivatives are 0, nothing is inside;
   `lights` of them count as pairs. */
ylm_status ylm__distant_write(const ylm_field_query *q, size_t n, const void *points,
                              const double *coefficients, size_t lights, ylm_field_result *r,
                              ylm_error *e);
/* The field's `crosses`: no surface anywhere. */
ylm_status ylm__distant_crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out);
/* Whether two lights differ in colour alone. */
bool ylm__distant_slides(const ylm_light *a, const ylm_light *b);

#endif
