/* slice.h - the slice f wi.z of a view in spherical harmonics. Private to csrc/material. */
#ifndef YLM_MATERIAL_SLICE_H
#define YLM_MATERIAL_SLICE_H

#include "ylm_material.h"

/* A slice, in the frame of its view. */
typedef struct material_slice {
  double total[3]; /* the integrals of the squares of the channels */
  double *c;       /* [3][(lmax+1)^2] */
} material_slice;

/* Room for slices. */
typedef struct slice_room slice_room;
slice_room *ylm__slice_room(int lmax);
void ylm__slice_room_free(slice_room *r);

/* The slice of the view at `angle` from the normal, `azimuth` from the tangent; `cosine` as the form says.
   YLM_ENOMEM */
ylm_status ylm__slice(const ylm_material *m, slice_room *r, double angle, double azimuth,
                      bool cosine, material_slice *out);

#endif
