/* fit.h - least squares over the hemisphere, of slices by harmonics. Private to csrc/material. */
#ifndef YLM_MATERIAL_FIT_H
#define YLM_MATERIAL_FIT_H

#include "ylm_material_table.h"

/* Equations of one degree: they depend on the cosine alone. */
typedef struct material_fit material_fit;

/* NULL without memory. To be given to ylm_free. */
material_fit *ylm__fit_create(int lmax);
/* In place, c [(lmax+1)^2] from integrals of f (wi.z)^2 Y_lm to the coefficients of B, z being the normal. Returns how much
   less the integral of (wi.z (B - f))^2 is than that of (wi.z f)^2. */
double ylm__fit(const material_fit *fit, double *c);

#endif
