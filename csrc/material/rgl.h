/* rgl.h - the tables of a measured material in RGL's format. Private to csrc/material. */
#ifndef YLM_MATERIAL_RGL_H
#define YLM_MATERIAL_RGL_H

#include "warp.h"

/* Slices belong to directions of the eye: azimuths times elevations. */
typedef struct rgl_table {
  int phis, thetas;
  float *phi, *theta; /* radians, increasing */
  bool isotropic, jacobian;
  int reduction;   /* 1: all azimuths are measured, 2: half of them, 4: a quarter */
  float middle[2]; /* of the measured azimuths, as a direction */
  float turn[2];   /* cosine and sine of the angle by which the material is turned */
  raster ndf, sigma;
  warp vndf, luminance;
  float *colour; /* [slices][height][width][4] with the extents of luminance */
} rgl_table;

/*
** ylm__rgl_read - tables from the bytes of a .bsdf file, turned by `rotate` degrees about the normal.
**
**   t     out  to be freed by ylm_free; all tables lie behind it
**   held  out  bytes of t
**
** Returns  YLM_OK; YLM_EFORMAT and YLM_EVERSION naming the field, YLM_ENOMEM
*/
ylm_status ylm__rgl_read(const unsigned char *bytes, size_t size, const char *name, float rotate,
                         rgl_table **t, size_t *held, ylm_error *e);

#endif
