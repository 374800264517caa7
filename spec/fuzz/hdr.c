/* hdr.c - fuzzes the Radiance reader. */
#define FUZZ_FORMAT YLM_CODEC_HDR
#include "image.h"
