/* rival.h - the methods, each beside what it needs. Private to csrc/rival. */
#ifndef YLM_RIVAL_METHODS_H
#define YLM_RIVAL_METHODS_H

#include "ylm_material_rival.h"
#include "ylm_sh_rival.h"

/* eval.c */
extern const ylm_sh_rival_eval ylm__rival_polynomial, ylm__rival_direct, ylm__rival_sloan,
    ylm__rival_scd;

extern const ylm_sh_rival_product ylm__rival_fourier; /* fourier.c */
extern const ylm_sh_rival_product ylm__rival_brute;   /* brute.c */
extern const ylm_sh_rival_product ylm__rival_list;    /* list.c */

extern ylm_material_rival_fn ylm__rival_nearest; /* nearest.c */

#endif
