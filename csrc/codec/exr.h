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

/* Texts of an image are attributes of the file. Names that OpenEXR has for attributes of its own stand there as
   "ylm.NAME". The attribute of text `key`, in `room` where it has another name; the text of attribute `name`. */
const char *ylm__exr_attribute(const char *key, char room[32]);
const char *ylm__exr_text(const char *name);

/* Limits, compression, the stream as user data; functions are the caller's. */
exr_context_initializer_t ylm__exr_settings(ylm__exr_stream *s);

#endif
