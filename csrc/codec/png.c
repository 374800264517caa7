/* png.c - PNG through libpng's low-level interface (the simplified one hides limits). */
#include "codec.h"
#include "ylm_list.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

/* State that libpng's callbacks share with the caller. */
typedef struct state {
  const unsigned char *bytes;
  size_t size, at;
  ylm_file *file;         /* NULL: written to memory */
  unsigned char *written; /* [room] */
  size_t room;
  bool failed;
  bool no_memory;
  char message[160];
} state;

static void on_error(png_structp png, png_const_charp text) {
  state *s = png_get_error_ptr(png);
  snprintf(s->message, sizeof s->message, "%s", text);
  longjmp(png_jmpbuf(png), 1);
}

static void on_warning(png_structp png, png_const_charp text) {
  (void)png;
  (void)text;
}

/* libpng tells of memory that ran out in words alone. */
static png_voidp on_alloc(png_structp png, png_alloc_size_t size) {
  state *s = png_get_mem_ptr(png);
  void *p = malloc(size);
  if (!p) s->no_memory = true;
  return p;
}

static void on_free(png_structp png, png_voidp p) {
  (void)png;
  free(p);
}

static void on_read(png_structp png, png_bytep out, size_t n) {
  state *s = png_get_io_ptr(png);
  if (n > s->size - s->at) png_error(png, "truncated");
  memcpy(out, s->bytes + s->at, n);
  s->at += n;
}

/* Appends to s->written. */
static bool keep(state *s, const unsigned char *data, size_t n) {
  if (!ylm_list_reserve(&s->written, s->size, s->size + n, &s->room, 1)) return false;
  memcpy(s->written + s->size, data, n);
  s->size += n;
  return true;
}

static void on_write(png_structp png, png_bytep data, size_t n) {
  state *s = png_get_io_ptr(png);
  s->failed = s->file ? ylm_file_write(s->file, data, n) != YLM_OK : !keep(s, data, n);
  if (s->failed) png_error(png, "cannot be written");
}

static void on_flush(png_structp png) { (void)png; }

/* 8-bit sRGB to linear, 256 entries; 16-bit is computed. */
static void to_linear(ylm_layer *layer, const unsigned char *pixels, size_t n, int bits, bool raw) {
  float table[256];
  int alpha = layer->channels == 4 || layer->channels == 2 ? layer->channels - 1 : 4;
  for (int i = 0; i < 256; i++)
    table[i] = raw ? (float)i / 255 : ylm_tone_decode_srgb((float)i / 255);
  for (size_t i = 0; i < n; i++) {
    bool is_alpha = (int)(i % (size_t)layer->channels) == alpha;
    if (bits == 8) {
      layer->data[i] = is_alpha ? (float)pixels[i] / 255 : table[pixels[i]];
    } else {
      float x = (float)(pixels[2 * i] << 8 | pixels[2 * i + 1]) / 65535;
      layer->data[i] = raw || is_alpha ? x : ylm_tone_decode_srgb(x);
    }
  }
}

/* Pixels that survive a longjmp are reached through this. */
typedef struct work {
  ylm_image *image;
  unsigned char *pixels;
  png_bytep *rows;
} work;

static ylm_status read_all(png_structp png, png_infop info, const char *name,
                           const ylm_codec_input *input, work *w, size_t size, ylm_error *e) {
  png_read_info(png, info);
  uint32_t width = png_get_image_width(png, info), height = png_get_image_height(png, info);
  uint64_t packed = png_get_rowbytes(png, info); /* as the file has them */
  png_set_expand(png); /* palettes, small greys and transparency to whole channels */
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  int channels = png_get_channels(png, info), bits = png_get_bit_depth(png, info);
  /* deflate expands at most 1032 times */
  uint64_t least = packed * height / 1032;
  ylm_status s =
      ylm__codec_start(name, input, width, height, channels, size, (size_t)least, &w->image, e);
  if (s != YLM_OK) return s;
  size_t row = png_get_rowbytes(png, info);
  w->pixels = ylm_alloc_zero(row, height);
  w->rows = ylm_alloc(height, sizeof *w->rows);
  if (!w->pixels || !w->rows) return ylm_no_memory_for(e, name);
  for (size_t y = 0; y < height; y++) w->rows[y] = w->pixels + y * row;
  png_read_image(png, w->rows);
  png_read_end(png, NULL);
  to_linear(&w->image->layer[0], w->pixels, (size_t)width * height * (size_t)channels, bits,
            input->raw);
  return YLM_OK;
}

/* True if every chunk up to IEND lies within the file: libpng takes memory for one of any length
   before it reads it. */
static bool chunks_fit(const unsigned char *p, size_t size) {
  for (size_t at = 8; size - at >= 12;) {
    size_t length =
        (size_t)p[at] << 24 | (size_t)p[at + 1] << 16 | (size_t)p[at + 2] << 8 | p[at + 3];
    if (length > size - at - 12) return false;
    if (memcmp(p + at + 4, "IEND", 4) == 0) return true;
    at += 12 + length;
  }
  return false;
}

ylm_status ylm__png_parse(const unsigned char *bytes, size_t size, const char *name,
                          const ylm_codec_input *input, ylm_image **image, ylm_error *e) {
  *image = NULL;
  if (!chunks_fit(bytes, size)) return ylm_fail(e, YLM_EFORMAT, "%s: truncated or damaged", name);
  state st = {.bytes = bytes, .size = size};
  work *w = ylm_alloc_zero(1, sizeof *w);
  png_structp png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &st, on_error, on_warning, &st,
                                             on_alloc, on_free);
  png_infop info = png ? png_create_info_struct(png) : NULL;
  volatile ylm_status s = YLM_OK;
  if (!w || !info) {
    s = ylm_no_memory_for(e, name);
  } else if (setjmp(png_jmpbuf(png))) {
    s = st.no_memory ? ylm_no_memory_for(e, name)
                     : ylm_fail(e, YLM_EFORMAT, "%s: not a whole PNG image: %s", name, st.message);
  } else {
    png_set_read_fn(png, &st, on_read);
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
    png_set_crc_action(png, PNG_CRC_QUIET_USE, PNG_CRC_QUIET_USE); /* else nothing gets past them */
#endif
    png_set_user_limits(png, YLM_IMAGE_MAX_SIDE, YLM_IMAGE_MAX_SIDE);
    png_set_chunk_malloc_max(png, size < 1 << 20 ? 16 * size + 65536 : 1 << 24);
    png_set_chunk_cache_max(png, 64);
    s = read_all(png, info, name, input, w, size, e);
  }
  png_destroy_read_struct(&png, &info, NULL);
  if (w) {
    ylm_free(w->pixels);
    ylm_free(w->rows);
    if (s == YLM_OK)
      *image = w->image;
    else
      ylm_image_free(w->image);
    ylm_free(w);
  }
  return s;
}

/* One row of a layer as PNG samples; alpha is not tone-mapped. */
static void encode_row(const ylm_layer *layer, int width, int y, const ylm_codec_options *o,
                       float *tmp, unsigned char *out) {
  size_t n = (size_t)width * (size_t)layer->channels;
  const float *in = layer->data + (size_t)y * n;
  ylm_tone_map(o->tone, o->exposure, n, in, tmp);
  if (layer->channels == 4 || layer->channels == 2)
    for (size_t i = (size_t)layer->channels - 1; i < n; i += (size_t)layer->channels)
      tmp[i] = ylm_tone_apply(YLM_TONE_linear, in[i]);
  for (size_t i = 0; i < n; i++) {
    if (o->bits == 16) {
      unsigned v = (unsigned)(tmp[i] * 65535.0f + 0.5f);
      out[2 * i] = (unsigned char)(v >> 8);
      out[2 * i + 1] = (unsigned char)v;
    } else {
      out[i] = (unsigned char)(tmp[i] * 255.0f + 0.5f);
    }
  }
}

static void write_all(png_structp png, png_infop info, const ylm_image *image,
                      const ylm_layer *layer, const ylm_codec_options *o, float *tmp,
                      unsigned char *row) {
  static const int types[] = {0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                              PNG_COLOR_TYPE_RGB_ALPHA};
  png_set_IHDR(png, info, (png_uint_32)image->width, (png_uint_32)image->height,
               o->bits == 16 ? 16 : 8, types[layer->channels], PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (o->tone != YLM_TONE_linear) png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  char tone[64];
  snprintf(tone, sizeof tone, "tone curve %s, exposure %+.2f stops", ylm_tone_name(o->tone),
           o->exposure);
  png_text text[2] = {
      {.compression = PNG_TEXT_COMPRESSION_NONE,
       .key = (char *)"Software",
       .text = (char *)"ylm " YLM_VERSION},
      {.compression = PNG_TEXT_COMPRESSION_NONE, .key = (char *)"Comment", .text = tone},
  };
  png_set_text(png, info, text, 2);
  png_write_info(png, info);
  for (int y = 0; y < image->height; y++) {
    encode_row(layer, image->width, y, o, tmp, row);
    png_write_row(png, row);
  }
  png_write_end(png, info);
}

/* Writes a layer to st->file, or where that is NULL to st->written; false where libpng gave up. */
static bool write_png(const ylm_image *image, const ylm_layer *layer, const ylm_codec_options *o,
                      state *st) {
  size_t samples = (size_t)image->width * (size_t)layer->channels;
  float *tmp = ylm_alloc(samples, sizeof(float));
  unsigned char *row = ylm_alloc(samples, 2);
  snprintf(st->message, sizeof st->message, "memory ran out");
  volatile bool ok = false;
  if (tmp && row) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, st, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (info && !setjmp(png_jmpbuf(png))) {
      png_set_write_fn(png, st, on_write, on_flush);
      write_all(png, info, image, layer, o, tmp, row);
      ok = true;
    }
    png_destroy_write_struct(&png, &info);
  }
  ylm_free(tmp);
  ylm_free(row);
  return ok;
}

static ylm_status check_bits(const ylm_codec_options *o, const char *name, ylm_error *e) {
  if (o->bits == 0 || o->bits == 8 || o->bits == 16) return YLM_OK;
  return ylm_fail(e, YLM_EINVAL, "%s: PNG has 8 or 16 bits, not %d", name, o->bits);
}

ylm_status ylm__png_write(const ylm_image *image, const ylm_layer *layer, const char *path,
                          const ylm_codec_options *o, ylm_error *e) {
  state st = {0};
  ylm_status s = check_bits(o, path, e);
  if (s == YLM_OK) s = ylm_file_create(path, &st.file, e);
  if (s != YLM_OK) return s;
  if (write_png(image, layer, o, &st) || st.failed)
    return ylm_file_commit(st.file, e); /* a failed write sticks to the file and is told here */
  ylm_file_discard(st.file);
  return ylm_fail(e, YLM_ENOMEM, "%s: libpng: %s", path, st.message);
}

ylm_status ylm_codec_png(const ylm_image *image, const ylm_codec_options *o, unsigned char **bytes,
                         size_t *size, ylm_error *e) {
  state st = {0};
  *bytes = NULL;
  *size = 0;
  const ylm_layer *layer = ylm_image_find(image, o->layer);
  if (!layer) return ylm_fail(e, YLM_EINVAL, "png: the image has no such layer");
  ylm_status s = check_bits(o, "png", e);
  if (s != YLM_OK) return s;
  if (!write_png(image, layer, o, &st)) {
    ylm_free(st.written);
    return ylm_fail(e, YLM_ENOMEM, "png: libpng: %s", st.message);
  }
  *bytes = st.written;
  *size = st.size;
  return YLM_OK;
}
