/* environment.h - what the process's environment asks for. Private to csrc/base. */
#ifndef YLM_ENVIRONMENT_H
#define YLM_ENVIRONMENT_H

#include "ylm_base.h"

/* YLM_THREADS, 1 .. YLM_THREADS_MOST; 0 where it is unset or empty; -1 and a sentence where it is
   something else. `e` may be NULL. */
int ylm__environment_threads(ylm_error *e);

/* YLM_ISA as a ylm_isa that is available; -YLM_ISA_COUNT where it is unset or empty; -1 and
   a sentence where it is something else. `e` may be NULL. */
int ylm__environment_isa(ylm_error *e);

#endif
