/* ambient.h - what the two ways to find ambient occlusion share. Private. */
#ifndef YLM_SHADE_AMBIENT_H
#define YLM_SHADE_AMBIENT_H

#include "../view.h"

/* ssao.c: ylm_shade_ambient by the picture, YLM_SHADE_SCREEN. */
ylm_status ylm__shade_ssao(const ylm_shade_view *v, double radius, int threads, float *out);

#endif
