/* pfm.c - fuzzes the PFM reader. */
#define FUZZ_FORMAT YLM_CODEC_PFM
#include "image.h"
