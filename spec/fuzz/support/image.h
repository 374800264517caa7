/* image.h - fuzzes the reader of one image format, FUZZ_FORMAT: the body of exr.c, hdr.c, pfm.c and
 * png.c. */
#include "ylm_codec.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  ylm_error e;
  ylm_image *image;
  if (ylm_codec_recognise(data, size) != FUZZ_FORMAT) return -1; /* not into the corpus */
  if (ylm_codec_parse(data, size, "fuzz", NULL, &image, &e) != YLM_OK) {
    if (image) __builtin_trap();
    return 0;
  }
  if (image->width < 1 || image->height < 1 || image->layers < 1) __builtin_trap();
  ylm_image_free(image);
  return 0;
}
