/* many_gloss.h - receivers of virtual lights that gloss. Private to csrc/shade. */
#ifndef YLM_SHADE_MANY_GLOSS_H
#define YLM_SHADE_MANY_GLOSS_H

#include "many.h"

/* YLM_ENOMEM */
ylm_status ylm__many_series(int lmax, ylm_many_series *s);
void ylm__many_series_free(ylm_many_series *s);

/* The materials in sight that gloss. */
typedef struct many_gloss many_gloss;

/* *out NULL where none does or all count as matte; to be freed on failure too. */
ylm_status ylm__many_gloss(const ylm_shade_view *v, const ylm_shade_gather_options *o,
                           many_gloss **out, ylm_error *e);
void ylm__many_gloss_free(many_gloss *g);
/* Whether point p glosses. */
bool ylm__many_glosses(const many_gloss *g, const ylm_shade_view *v, size_t p);
/* Floats that one point's rows take. */
size_t ylm__many_gloss_room(const many_gloss *g);
/* The receiver at point p, which glosses; room [ylm__many_gloss_room]. YLM_ENOMEM */
ylm_status ylm__many_receive(const many_gloss *g, const ylm_shade_view *v, size_t p, float *room,
                             ylm_many_receiver *r);

/* f of the receiver, sr^-1, of light from n <= YLM_MANY_CHUNK directions w of the world: f [n][3]. */
void ylm__many_eval(const ylm_many_receiver *r, size_t n, const float (*w)[3], float (*f)[3]);
/* As the kernels of many.h have it, of light i: out [functions]. The plain form. */
void ylm__many_gloss_weight(const ylm_many_lights *l, const ylm_many_ask *a,
                            const ylm_many_receiver *r, size_t i, const float x[3], double out[3]);
/* The paper's Eq. 22: the part of light i that is above the horizon of N at x. many_plain.c */
double ylm__many_above(const ylm_many_lights *l, size_t i, const float x[3], const float N[3]);

#endif
