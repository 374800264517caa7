/* adjoint.h - what the files of csrc/transfer/adjoint share. Private. */
#ifndef YLM_TRANSFER_ADJOINT_PRIVATE_H
#define YLM_TRANSFER_ADJOINT_PRIVATE_H

#include "../transfer.h"
#include "ylm_transfer_adjoint.h"

struct ylm_receivers {
  const ylm_transfer *t;
  size_t n;
  int links;
  float (*point)[3], (*normal)[3]; /* [n] */
  ylm_links link;                  /* [n][links] */
  float *share;                    /* [n] */
};

/* -- opening.c: what one place of a lamp sends ------------------------------------------------------ */

/* Irradiance for a scale of 1 if all of the lamp sent what this place of it does, and its derivatives. */
typedef struct adjoint_sample {
  double light;
  double place[3], turn[3], size[2]; /* of the light that moves with the lamp */
  double still[3];                   /* by a turn, of light in a fixed direction */
  double to[3];                      /* where a ray to it ends */
} adjoint_sample;

/* A place of the rim: its share of derivatives is these numbers times the visibility there less the mean. */
typedef struct adjoint_rim {
  double place[3], turn[3], size[2];
  double to[3];
} adjoint_rim;

/* Fills in areas and rims of the corners of a polygon, which are its own. */
void ylm__lamp_measure(ylm_lamp *l);
/* The place u [2] of a lamp, from 0 below 1, as x with this normal sees it. False: it sends nothing there. */
bool ylm__lamp_sample(const ylm_lamp *l, const float x[3], const float normal[3], const double u[2],
                      adjoint_sample *out);
/* The place u, from 0 below 1, of the rim, of which so many are taken. False: there is none, or no light. */
bool ylm__lamp_rim(const ylm_lamp *l, const float x[3], const float normal[3], double u, int count,
                   adjoint_rim *out);

#endif
