/* cie.h - skies of the CIE that are asked often. Private to csrc/light. */
#ifndef YLM_LIGHT_CIE_H
#define YLM_LIGHT_CIE_H

#include "ylm_light_emitter.h"

/* The part of a sky's luminance that is the same in all directions, and the luminance by it: ylm_light_cie_luminance. */
double ylm__light_cie_scale(const ylm_light_cie *sky);
double ylm__light_cie_scaled(const ylm_light_cie *sky, double scale, const double d[3]);

#endif
