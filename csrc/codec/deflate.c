/* deflate.c - streams of zlib, which libpng needs anyway. */
#include "ylm_codec.h"

#ifdef YLM_ZLIB
#include <zlib.h>

ylm_status ylm_codec_deflate(const unsigned char *bytes, size_t size, unsigned char **out,
                             size_t *packed, ylm_error *e) {
  *out = NULL;
  *packed = 0;
  if (size > ((size_t)1 << 31)) return ylm_fail(e, YLM_ELIMIT, "deflate: more than 2 GiB at once");
  uLongf n = compressBound((uLong)size);
  unsigned char *room = ylm_alloc((size_t)n, 1);
  if (!room) return ylm_no_memory_for(e, "deflate");
  if (compress2(room, &n, bytes, (uLong)size, Z_BEST_COMPRESSION) != Z_OK) {
    ylm_free(room);
    return ylm_no_memory_for(e, "deflate");
  }
  *out = room;
  *packed = (size_t)n;
  return YLM_OK;
}

ylm_status ylm_codec_inflate(const unsigned char *bytes, size_t size, size_t wanted,
                             unsigned char *out, ylm_error *e) {
  uLongf n = (uLongf)wanted;
  int result = uncompress(out, &n, bytes, (uLong)size);
  if (result == Z_MEM_ERROR) return ylm_no_memory_for(e, "inflate");
  if (result != Z_OK || n != wanted)
    return ylm_fail(e, YLM_EFORMAT, "inflate: the stream is damaged, or not of %zu bytes", wanted);
  return YLM_OK;
}
#else
ylm_status ylm_codec_deflate(const unsigned char *bytes, size_t size, unsigned char **out,
                             size_t *packed, ylm_error *e) {
  (void)bytes, (void)size;
  *out = NULL;
  *packed = 0;
  return ylm_fail(e, YLM_EMISSING, "this libylm_codec was built without zlib (zlib1g-dev)");
}

ylm_status ylm_codec_inflate(const unsigned char *bytes, size_t size, size_t wanted,
                             unsigned char *out, ylm_error *e) {
  (void)bytes, (void)size, (void)wanted, (void)out;
  return ylm_fail(e, YLM_EMISSING, "this libylm_codec was built without zlib (zlib1g-dev)");
}
#endif
