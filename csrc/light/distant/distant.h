/* distant.h - what kinds of distant lights share: their packs, and fields that are the same at
   every point. Private to csrc/light. */
#ifndef YLM_LIGHT_DISTANT_H
#define YLM_LIGHT_DISTANT_H

#include "../kind.h"

/* Distant lights that are summed together: the first member of a pack's `of`. */
typedef struct ylm__distant {
  ylm_field field; /* whose `self` it is */
  const ylm__light_kind *kind;
  size_t n;
  double **record; /* [n], in `numbers` */
  double *numbers;
} ylm__distant;

/* Copies n records of a kind. `settle` checks a copy, light i of them from 0 on, and may change it.
   To be released with ylm__distant_release, even after an error: that, or YLM_ENOMEM. */
typedef ylm_status ylm__distant_settle_fn(double *record, size_t i, ylm_error *e);
ylm_status ylm__distant_copy(ylm__distant *d, const ylm__light_kind *kind, size_t n,
                             const double *const *record, ylm__distant_settle_fn *settle,
                             ylm_error *e);
void ylm__distant_release(ylm__distant *d);

/* `create` and `free` of a kind whose packs are such lights and no more; its field evaluates. */
ylm_status ylm__distant_create(const ylm__light_kind *kind, size_t n, const double *const *record,
                               ylm__distant_settle_fn *settle, ylm__light_pack *made, ylm_error *e);
void ylm__distant_free(void *of);
/* A kind's `get` and `record`: a shape is the record behind its radiance. */
size_t ylm__distant_get(const void *of, size_t i, ylm_light *out, ylm_light_shape *shape);
size_t ylm__distant_record(const ylm_light *l, const double radiance[3], double *to);

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
