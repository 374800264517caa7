/* finite.h - results that are too large for their type are an error. Private to csrc/light. */
#ifndef YLM_LIGHT_FINITE_H
#define YLM_LIGHT_FINITE_H

#include "light.h"

/* ylm_light_finite of sphere lights: their radiances bound results, which are seldom inspected. */
ylm_status ylm__lights_finite(const ylm_lights *lights, const ylm_field_query *q, size_t n,
                              const void *points, const ylm_field_result *r, ylm_error *e);

#endif
