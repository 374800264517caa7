/* fit.h - places of surfaces as rows of a system whose unknowns are the numbers of probes. */
#ifndef YLM_GRID_PROBES_FIT_H
#define YLM_GRID_PROBES_FIT_H

#include "probes.h"

typedef struct probes_rows {
  size_t *first;   /* [places + 1] of the points of a place */
  uint32_t *point; /* none of them tied */
  float *share;
  float *basis; /* [places][count] */
  float *hold;  /* [points] */
} probes_rows;

/* The rows of places, which ylm__probes_leave frees; YLM_ENOMEM. `found` [places], or NULL: where they are read. */
ylm_status ylm__probes_rows(const ylm_grid_probes *p, const ylm_grid_probes_places *at,
                            const probes_place *found, probes_rows *r);
void ylm__probes_leave(probes_rows *r);

#endif
