/* codec.c - which format: by ending when writing, by content when reading. */
#include "codec.h"

#include <string.h>
#include <strings.h>

static const struct {
  const char *ending;
  ylm_codec_writer *write;
} writers[] = {
    {".exr", ylm__exr_write},
    {".png", ylm__png_write},
    {".hdr", ylm__hdr_write},
    {".pfm", ylm__pfm_write},
};

ylm_status ylm_codec_write(const ylm_image *image, const char *path, const ylm_codec_options *o,
                           ylm_error *e) {
  static const ylm_codec_options defaults;
  if (!o) o = &defaults;
  const ylm_layer *layer = ylm_image_find(image, o->layer);
  if (!layer)
    return ylm_fail(e, YLM_EINVAL, o->layer ? "no layer '%s'" : "the image has no layer", o->layer);
  size_t n = strlen(path);
  for (size_t i = 0; i < sizeof writers / sizeof *writers; i++)
    if (n >= 4 && strcasecmp(path + n - 4, writers[i].ending) == 0)
      return writers[i].write(image, layer, path, o, e);
  return ylm_fail(e, YLM_EINVAL, "%s: the name must end in .exr, .png, .hdr or .pfm", path);
}

ylm_codec_kind ylm_codec_recognise(const unsigned char *p, size_t size) {
  if (size >= 4 && memcmp(p, "\x76\x2f\x31\x01", 4) == 0) return YLM_CODEC_EXR;
  if (size >= 8 && memcmp(p, "\x89PNG\r\n\x1a\n", 8) == 0) return YLM_CODEC_PNG;
  if (size >= 3 && memcmp(p, "\xff\xd8\xff", 3) == 0) return YLM_CODEC_JPEG;
  if (size >= 2 && memcmp(p, "#?", 2) == 0) return YLM_CODEC_HDR;
  if (size >= 3 && p[0] == 'P' && (p[1] == 'F' || p[1] == 'f') &&
      (p[2] == '\n' || p[2] == '\r' || p[2] == ' '))
    return YLM_CODEC_PFM;
  return YLM_CODEC_NONE;
}

static const ylm_codec_input any;

ylm_status ylm_codec_parse(const unsigned char *bytes, size_t size, const char *name,
                           const ylm_codec_input *input, ylm_image **image, ylm_error *e) {
  static ylm_codec_parser *const parsers[] = {
      [YLM_CODEC_EXR] = ylm__exr_parse,   [YLM_CODEC_HDR] = ylm__hdr_parse,
      [YLM_CODEC_PNG] = ylm__png_parse,   [YLM_CODEC_PFM] = ylm__pfm_parse,
      [YLM_CODEC_JPEG] = ylm__jpeg_parse,
  };
  ylm_codec_kind kind = ylm_codec_recognise(bytes, size);
  *image = NULL;
  if (kind == YLM_CODEC_NONE)
    return ylm_fail(e, YLM_EFORMAT,
                    "%s: not an image that is known (EXR, PNG, JPEG, Radiance, PFM)", name);
  return parsers[kind](bytes, size, name, input ? input : &any, image, e);
}

ylm_status ylm_codec_read(const char *path, const ylm_codec_input *input, ylm_image **image,
                          ylm_error *e) {
  unsigned char *bytes;
  size_t size;
  *image = NULL;
  ylm_status s = ylm_file_read(path, input ? input->bytes : 0, &bytes, &size, e);
  if (s != YLM_OK) return s;
  s = ylm_codec_parse(bytes, size, path, input, image, e);
  ylm_free(bytes);
  return s;
}

ylm_status ylm__codec_check_size(const char *name, const ylm_codec_input *input, uint64_t width,
                                 uint64_t height, int channels, ylm_error *e) {
  if (width < 1 || height < 1 || width > YLM_IMAGE_MAX_SIDE || height > YLM_IMAGE_MAX_SIDE)
    return ylm_fail(e, YLM_ELIMIT, "%s: %llu x %llu pixels: sides are limited to 1 .. %d", name,
                    (unsigned long long)width, (unsigned long long)height, YLM_IMAGE_MAX_SIDE);
  if (width * height > YLM_IMAGE_MAX_PIXELS)
    return ylm_fail(e, YLM_ELIMIT, "%s: %llu x %llu pixels: images are limited to %llu of them",
                    name, (unsigned long long)width, (unsigned long long)height,
                    (unsigned long long)YLM_IMAGE_MAX_PIXELS);
  if (input->numbers && width * height > input->numbers / (uint64_t)channels)
    return ylm_fail(e, YLM_ELIMIT,
                    "%s: %llu x %llu pixels of %d channels are more than %llu numbers", name,
                    (unsigned long long)width, (unsigned long long)height, channels,
                    (unsigned long long)input->numbers);
  return YLM_OK;
}

ylm_status ylm__codec_start(const char *name, const ylm_codec_input *input, uint64_t width,
                            uint64_t height, int channels, size_t size, size_t least,
                            ylm_image **image, ylm_error *e) {
  *image = NULL;
  ylm_status s = ylm__codec_check_size(name, input, width, height, channels, e);
  if (s != YLM_OK) return s;
  if (size < least)
    return ylm_fail(e, YLM_EFORMAT, "%s: truncated: %zu bytes cannot hold %d x %d pixels", name,
                    size, (int)width, (int)height);
  s = ylm_image_create((int)width, (int)height, image, e);
  if (s == YLM_OK) s = ylm_image_add(*image, "radiance", channels, e);
  if (s != YLM_OK) {
    ylm_image_free(*image);
    *image = NULL;
  }
  return s;
}
