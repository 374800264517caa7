/* merged.h - many flat lights as spheres, by merged moments. Private to csrc/light. */
#ifndef YLM_LIGHT_POLYGON_MERGED_H
#define YLM_LIGHT_POLYGON_MERGED_H

#include "../moments/plan.h"
#include "calibration.h"
#include "flat.h"

/* How a query is answered; without a kernel light by light (approx.c). */
typedef struct ylm__merged {
  const ylm__moment_kernel *kernel;
  int derivatives;
  ylm_light_maps maps;
} ylm__merged;

/* To be freed with ylm__merged_free in any case. */
ylm_status ylm__merged_make(ylm__merged *m, const ylm_polygons *p, const ylm_field_query *q,
                            ylm_isa isa);
void ylm__merged_free(ylm__merged *m);

/* As ylm__polygon_spheres. */
ylm_status ylm__polygon_merged(const ylm_polygons *p, const ylm__merged *m,
                               const ylm_field_query *q, size_t n, const double (*x)[3],
                               double *sum, uint8_t *inside);

#endif
