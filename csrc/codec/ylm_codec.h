/*
** ylm_codec.h - image files: OpenEXR, PNG, Radiance .hdr, PFM; JPEG is read.
**
** Readers take bytes in memory (`*_parse`, for fuzzing and pipes) or a path. Readers refuse a file
** that is truncated, damaged or too large, with a sentence that begins with its name. Readers
** allocate at most a small multiple of what the file can hold. Writers replace the file whole or
** not at all. Nothing is printed.
*/
#ifndef YLM_CODEC_H
#define YLM_CODEC_H

#include "ylm_image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Options of a writer; zeros are the defaults. */
typedef struct ylm_codec_options {
  int bits;          /* exr: 16 (half) or 32 (default); png: 8 (default) or 16 */
  ylm_tone tone;     /* png: the curve; default srgb */
  double exposure;   /* png: stops */
  const char *layer; /* png, hdr, pfm: which layer; NULL: the first */
} ylm_codec_options;

/*
** ylm_codec_write - an image to a file, by the ending of its name.
**
**   .exr  every layer and the metadata; the first layer as R, G, B (or Y), the others as
**         NAME.R ...; normals and positions as X, Y, Z. ZIP compression. Half saturates at 65504.
**   .png  one layer through exposure and tone curve; 1 .. 4 channels
**   .hdr  one layer of 3 channels (1 is repeated), RGBE, 8 bits of mantissa, negatives become 0
**   .pfm  one layer of 1 or 3 channels, float, little-endian
**
** Returns  YLM_OK; YLM_EINVAL (ending, layer, bits), YLM_ESHAPE (channels that the format lacks),
**          YLM_EDOMAIN (hdr: a number that is not finite), YLM_EIO, YLM_ENOMEM
*/
YLM_API ylm_status ylm_codec_write(const ylm_image *image, const char *path,
                                   const ylm_codec_options *options, ylm_error *e);

/*
** ylm_codec_png - one layer of an image as the bytes of a .png file; options of ylm_codec_write.
**
**   bytes  out  [*size], the caller frees them with ylm_free; NULL on failure
**
** Returns  YLM_OK; YLM_EINVAL (layer, bits), YLM_ENOMEM
*/
YLM_API ylm_status ylm_codec_png(const ylm_image *image, const ylm_codec_options *options,
                                 unsigned char **bytes, size_t *size, ylm_error *e);

/*
** ylm_codec_deflate, ylm_codec_inflate - a stream of zlib of bytes, and back.
**
**   out     out  [*packed], freed by ylm_free; NULL on failure. Of inflate [wanted]
**   wanted  in   bytes that the stream has unpacked
**
** Returns  YLM_OK; YLM_ENOMEM, YLM_ELIMIT (more than 2 GiB), YLM_EFORMAT (damaged, or another
**          size), YLM_EMISSING (built without zlib)
*/
YLM_API ylm_status ylm_codec_deflate(const unsigned char *bytes, size_t size, unsigned char **out,
                                     size_t *packed, ylm_error *e);
YLM_API ylm_status ylm_codec_inflate(const unsigned char *bytes, size_t size, size_t wanted,
                                     unsigned char *out, ylm_error *e);

typedef enum ylm_codec_kind {
  YLM_CODEC_NONE,
  YLM_CODEC_EXR,
  YLM_CODEC_PNG,
  YLM_CODEC_HDR,
  YLM_CODEC_PFM,
  YLM_CODEC_JPEG /* read only */
} ylm_codec_kind;

/* The format, by the first bytes. */
YLM_API ylm_codec_kind ylm_codec_recognise(const unsigned char *bytes, size_t size);

/* Options of a reader; zeros are the defaults. */
typedef struct ylm_codec_input {
  bool raw; /* png, jpeg: k/255 or k/65535 as they stand, not decoded from sRGB */
  uint64_t
      numbers;  /* most that the image may hold, pixels times channels; 0: no limit of its own */
  size_t bytes; /* most of the file; 0: any */
} ylm_codec_input;

/*
** ylm_codec_parse - an image from a file's bytes, by content.
**
** Numbers of PNG and JPEG are decoded from sRGB to linear. Formats without layer names give one layer
** "radiance"; an EXR of ylm gives back its layers in order. `input` may be NULL.
** Returns  YLM_OK; YLM_EFORMAT, YLM_ELIMIT (before memory is taken), YLM_ENOMEM
*/
YLM_API ylm_status ylm_codec_parse(const unsigned char *bytes, size_t size, const char *name,
                                   const ylm_codec_input *input, ylm_image **image, ylm_error *e);
/* ylm_codec_parse from a file; errors of ylm_file_read too. */
YLM_API ylm_status ylm_codec_read(const char *path, const ylm_codec_input *input, ylm_image **image,
                                  ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
