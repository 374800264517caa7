/* exr.h - what reading and writing OpenEXR share. Private to csrc/codec. */
#ifndef YLM_CODEC_EXR_H
#define YLM_CODEC_EXR_H

#include <openexr.h>

#include "codec.h"

#define EXR_ORDER_ATTRIBUTE "ylmLayers" /* "radiance:3 normal:3 ...": the layers in their order */

/* The bytes of a file, as OpenEXRCore's functions get at them. */
typedef struct ylm__exr_stream {
  const unsigned char *bytes; /* reading */
  size_t size;
  ylm_file *file; /* writing */
  bool failed;
  char message[160]; /* the first error of a file that is read */
} ylm__exr_stream;

/* Limits, compression, the stream as user data; functions are the caller's. */
exr_context_initializer_t ylm__exr_settings(ylm__exr_stream *s);

#endif
