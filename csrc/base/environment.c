/* environment.c - YLM_THREADS and YLM_ISA: read by the code that they steer, checked on request. */
#include "environment.h"

#include <stdlib.h>
#include <string.h>

/* A variable's text; NULL where it is unset or empty. */
static const char *text_of(const char *name) {
  const char *s = getenv(name);
  return s && *s ? s : NULL;
}

int ylm__environment_threads(ylm_error *e) {
  const char *s = text_of("YLM_THREADS"), *p = s;
  if (!s) return 0;
  int n = 0;
  for (; *p >= '0' && *p <= '9' && n <= YLM_THREADS_MOST; p++) n = 10 * n + (*p - '0');
  if (!*p && n >= 1 && n <= YLM_THREADS_MOST) return n;
  ylm_fail(e, YLM_EDOMAIN,
           "YLM_THREADS is '%.40s' in the environment: an integer from 1 to %d expected", s,
           YLM_THREADS_MOST);
  return -1;
}

int ylm__environment_isa(ylm_error *e) {
  const char *s = text_of("YLM_ISA");
  if (!s) return -YLM_ISA_COUNT;
  char sets[100] = "";
  for (int i = 0; i < YLM_ISA_COUNT; i++) {
    if (!ylm_isa_available((ylm_isa)i)) continue;
    const char *name = ylm_isa_name((ylm_isa)i);
    if (strcmp(s, name) == 0) return i;
    snprintf(sets + strlen(sets), sizeof sets - strlen(sets), "%s%s", *sets ? ", " : "", name);
  }
  ylm_fail(e, YLM_EDOMAIN,
           "YLM_ISA is '%.40s' in the environment: one of %s expected on this processor", s, sets);
  return -1;
}

ylm_status ylm_environment_check(ylm_error *e) {
  if (ylm__environment_threads(e) == -1 || ylm__environment_isa(e) == -1) return YLM_EDOMAIN;
  return YLM_OK;
}
