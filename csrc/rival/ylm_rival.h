/* ylm_rival.h - libylm_rival.so: methods that exist to be compared with (ylm_sh_rival.h). */
#ifndef YLM_RIVAL_H
#define YLM_RIVAL_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/*
** Makes the library's methods known to ylm_sh_eval_how ("polynomial", "direct", "sloan", "scd") and
** ylm_sh_product_create ("fourier", "brute"), for the life of the process. May be called again, and
** from any thread.
*/
YLM_API void ylm_rival_register(void);

#ifdef __cplusplus
}
#endif
#endif
