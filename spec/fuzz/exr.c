/* exr.c - fuzzes the OpenEXR reader. */
#define FUZZ_FORMAT YLM_CODEC_EXR
#include "image.h"
