/* jpeg.c - fuzzes the JPEG reader. */
#define FUZZ_FORMAT YLM_CODEC_JPEG
#include "image.h"
