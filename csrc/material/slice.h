/* slice.h - the slice f wi.z of an eye in spherical harmonics. Private to csrc/material. */
#ifndef YLM_MATERIAL_SLICE_H
#define YLM_MATERIAL_SLICE_H

#include "calibration.h"
#include "ylm_material_table.h"

/* A slice, in the frame of its eye. */
typedef struct material_slice {
  double total[3]; /* the integrals of the squares of the channels */
  double *c;       /* [3][(lmax+1)^2] */
} material_slice;

/* Room for slices. */
typedef struct slice_room slice_room;
slice_room *ylm__slice_room(int lmax);
void ylm__slice_room_free(slice_room *r);

/* The slice of the eye at `angle` from the normal, `azimuth` from the tangent. Of FIT: f (wi.z)^2, which fit.c
   takes, and the integrals of (f wi.z)^2. YLM_ENOMEM */
ylm_status ylm__slice(const ylm_material *m, slice_room *r, double angle, double azimuth,
                      ylm_material_table_slice of, material_slice *out);

/* -- kernels: slice_kernel.h ----------------------------------------------------- */

/* Half planes through the mirror direction of an eye. */
typedef struct slice_planes {
  int nodes;
  const double *part, *weight; /* [nodes]: angles in parts of `end`, and what they count */
  double end[SLICE_WIDE], cos_phi[SLICE_WIDE],
      sin_phi[SLICE_WIDE];      /* angle of the horizon; azimuth */
  double cosine, sine, turn[2]; /* of the eye's angle; of its azimuth */
} slice_planes;

/* Their nodes: [nodes][SLICE_WIDE]. */
typedef struct slice_nodes {
  float (*wi)[3];
  double *x, *s, *z,
      *measure; /* cosine and sine of the angle from the mirror direction; wi.z; weight */
} slice_nodes;

/* P_(l+1)m = a x P_lm - b P_(l-1)m, P_mm = first[m] sine^m; a, b by order, then degree. */
typedef struct slice_recurrence {
  int lmax;
  double *first, *a, *b;
} slice_recurrence;

typedef struct slice_kernels {
  void (*places)(const slice_planes *p, slice_nodes *out);
  void (*sums)(const slice_recurrence *r, int n, const double *x, const double *s, const double *f,
               double *sum);
} slice_kernels;

#endif
