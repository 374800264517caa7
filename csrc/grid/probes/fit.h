/* fit.h - places of surfaces as rows of a system whose unknowns are the numbers of probes. */
#ifndef YLM_GRID_PROBES_FIT_H
#define YLM_GRID_PROBES_FIT_H

#include "probes.h"

typedef struct probes_rows {
  uint32_t (*around)[8]; /* [places] points */
  float (*share)[8];     /* [places] 0 where it is dark */
  float *basis;          /* [places][count] */
  float *hold;           /* [points] */
} probes_rows;

/* The rows of places, which ylm__probes_leave frees; YLM_ENOMEM. */
ylm_status ylm__probes_rows(const ylm_grid_probes *p, const ylm_grid_probes_places *at,
                            probes_rows *r);
void ylm__probes_leave(probes_rows *r);

#endif
