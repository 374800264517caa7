/* pfm.c - portable float maps: "PF|Pf width height scale", rows from the bottom up. */
#include "codec.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The header's next word (without its space) into `word`; false if there is none that fits. */
static bool next_word(const unsigned char *p, size_t size, size_t *at, char word[32]) {
  size_t n = 0;
  while (*at < size && (p[*at] == ' ' || p[*at] == '\n' || p[*at] == '\r' || p[*at] == '\t')) ++*at;
  while (*at < size && p[*at] > ' ' && n < 31) word[n++] = (char)p[(*at)++];
  word[n] = 0;
  return n > 0 && n < 31 && *at < size;
}

static bool next_size(const unsigned char *p, size_t size, size_t *at, uint64_t *x) {
  char word[32], *end;
  if (!next_word(p, size, at, word) || word[0] < '0' || word[0] > '9' || strlen(word) > 9)
    return false;
  *x = strtoull(word, &end, 10);
  return *end == 0;
}

static float load(const unsigned char *p, bool big) {
  uint32_t u = big ? (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3]
                   : (uint32_t)p[3] << 24 | (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 | p[0];
  float f;
  memcpy(&f, &u, sizeof f);
  return f;
}

ylm_status ylm__pfm_parse(const unsigned char *p, size_t size, const char *name,
                          const ylm_codec_input *input, ylm_image **image, ylm_error *e) {
  char word[32], *end;
  size_t at = 2;
  uint64_t w, h;
  int channels = p[1] == 'F' ? 3 : 1;
  if (!next_size(p, size, &at, &w) || !next_size(p, size, &at, &h) ||
      !next_word(p, size, &at, word))
    return ylm_fail(e, YLM_EFORMAT, "%s: not a PFM header (width, height, scale)", name);
  double scale = strtod(word, &end);
  if (*end || !isfinite(scale) || scale == 0)
    return ylm_fail(e, YLM_EFORMAT, "%s: PFM scale '%s' is not a number other than 0", name, word);
  at++;                  /* exactly one byte of white space */
  uint64_t need = w * h; /* each has at most 9 digits */
  if (need > YLM_IMAGE_MAX_PIXELS) need = YLM_IMAGE_MAX_PIXELS;
  ylm_status s = ylm__codec_start(name, input, w, h, channels, size,
                                  at + need * (size_t)channels * 4, image, e);
  if (s != YLM_OK) return s;
  size_t row = (size_t)w * (size_t)channels;
  for (size_t y = 0; y < h; y++)
    for (size_t i = 0; i < row; i++)
      (*image)->layer[0].data[(h - 1 - y) * row + i] = load(p + at + 4 * (y * row + i), scale > 0);
  return YLM_OK;
}

static void store(unsigned char *p, float f) {
  uint32_t u;
  memcpy(&u, &f, sizeof u);
  for (int i = 0; i < 4; i++) p[i] = (unsigned char)(u >> 8 * i);
}

ylm_status ylm__pfm_write(const ylm_image *image, const ylm_layer *layer, const char *path,
                          const ylm_codec_options *o, ylm_error *e) {
  (void)o;
  if (layer->channels != 1 && layer->channels != 3)
    return ylm_fail(e, YLM_ESHAPE, "%s: PFM holds 1 or 3 channels, layer '%s' has %d", path,
                    layer->name, layer->channels);
  size_t row = (size_t)image->width * (size_t)layer->channels;
  unsigned char *bytes = ylm_alloc(row, 4);
  ylm_file *f;
  if (!bytes) return ylm_no_memory_for(e, path);
  ylm_status s = ylm_file_create(path, &f, e);
  if (s == YLM_OK) {
    char head[64];
    int n = snprintf(head, sizeof head, "P%c\n%d %d\n-1.0\n", layer->channels == 3 ? 'F' : 'f',
                     image->width, image->height);
    ylm_file_write(f, head, (size_t)n);
    for (int y = image->height - 1; y >= 0; y--) {
      for (size_t i = 0; i < row; i++) store(bytes + 4 * i, layer->data[(size_t)y * row + i]);
      ylm_file_write(f, bytes, row * 4);
    }
    s = ylm_file_commit(f, e);
  }
  ylm_free(bytes);
  return s;
}
