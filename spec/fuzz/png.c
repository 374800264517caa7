/* png.c - fuzzes the PNG reader. */
#define FUZZ_FORMAT YLM_CODEC_PNG
#include "image.h"
