/* codec.h - one parser and one writer per format. Private to csrc/codec. */
#ifndef YLM_CODEC_PRIVATE_H
#define YLM_CODEC_PRIVATE_H

#include "ylm_codec.h"

typedef ylm_status ylm_codec_parser(const unsigned char *bytes, size_t size, const char *name,
                                    const ylm_codec_input *input, ylm_image **image, ylm_error *e);
typedef ylm_status ylm_codec_writer(const ylm_image *image, const ylm_layer *layer,
                                    const char *path, const ylm_codec_options *o, ylm_error *e);

ylm_codec_parser ylm__exr_parse, ylm__png_parse, ylm__hdr_parse, ylm__pfm_parse, ylm__jpeg_parse;
ylm_codec_writer ylm__exr_write, ylm__png_write, ylm__hdr_write, ylm__pfm_write;

/* YLM_ELIMIT unless an image of this size may be read. */
ylm_status ylm__codec_check_size(const char *name, const ylm_codec_input *input, uint64_t width,
                                 uint64_t height, int channels, ylm_error *e);
/* An image of one layer "radiance"; refuses a file that is too short for its pixels
   (`least` bytes are needed). */
ylm_status ylm__codec_start(const char *name, const ylm_codec_input *input, uint64_t width,
                            uint64_t height, int channels, size_t size, size_t least,
                            ylm_image **image, ylm_error *e);

#endif
