/* version.c - the version of the library. */
#include "ylm_version.h"

const char *ylm_version(void) { return YLM_VERSION; }

int ylm_version_number(void) { return YLM_VERSION_NUMBER; }
