/*
** ylm_version.h - the version of these headers, and that of the library a program has loaded.
**
**     if (ylm_version_number() / 100 != YLM_VERSION_NUMBER / 100)
**       fprintf(stderr, "compiled for ylm %s, loaded %s\n", YLM_VERSION, ylm_version());
**
** docs/c.md has the promise about the binary interface. The headers' version as text is YLM_VERSION
** of ylm_base.h, "0.1.0".
*/
#ifndef YLM_VERSION_H
#define YLM_VERSION_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define YLM_VERSION_MAJOR 0
#define YLM_VERSION_MINOR 1
#define YLM_VERSION_PATCH 0

/* One number that grows with the version: 0.1.0 is 100, 1.2.3 is 10203. */
#define YLM_VERSION_NUMBER (YLM_VERSION_MAJOR * 10000 + YLM_VERSION_MINOR * 100 + YLM_VERSION_PATCH)

/* YLM_VERSION and YLM_VERSION_NUMBER of the headers that the library was compiled with. */
YLM_API const char *ylm_version(void);
YLM_API int ylm_version_number(void);

#ifdef __cplusplus
}
#endif
#endif
