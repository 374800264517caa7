/*
** exr_write.c - writes OpenEXR through OpenEXRCore's C interface: layers become groups of channels.
*/
#include "exr.h"

#include <math.h>
#include <string.h>

/* The names of a layer's channels: vectors and depths by what they are, others as colours. */
static const char *suffixes(const ylm_layer *layer) {
  static const char *const by_count[] = {"", "Y", "XY", "RGB", "RGBA"};
  bool vector = strcmp(layer->name, "normal") == 0 || strcmp(layer->name, "position") == 0;
  if (layer->channels == 1 && strcmp(layer->name, "depth") == 0) return "Z";
  return vector && layer->channels == 3 ? "XYZ" : by_count[layer->channels];
}

/* "R" of the first layer, "normal.X" of others. */
static void channel_name(const ylm_image *image, int layer, int channel, char name[80]) {
  const ylm_layer *l = &image->layer[layer];
  char c = suffixes(l)[channel];
  if (layer == 0)
    snprintf(name, 80, "%c", c);
  else
    snprintf(name, 80, "%s.%c", l->name, c);
}

/* While a file is written the library may hold the lock that exr_get_user_data takes: asking for
   the stream from here would wait for ever. The file itself knows its error. */
static void on_write_error(exr_const_context_t c, exr_result_t code, const char *text) {
  (void)c, (void)code, (void)text;
}

static int64_t on_write(exr_const_context_t c, void *user, const void *data, uint64_t n,
                        uint64_t at, exr_stream_error_func_ptr_t error) {
  ylm__exr_stream *s = user;
  (void)c;
  (void)error;
  if (fseeko(ylm_file_stream(s->file), (off_t)at, SEEK_SET) != 0 ||
      ylm_file_write(s->file, data, (size_t)n) != YLM_OK) {
    s->failed = true;
    return -1;
  }
  return (int64_t)n;
}

static exr_result_t write_order(exr_context_t c, const ylm_image *image) {
  char text[YLM_IMAGE_MAX_LAYERS * (YLM_IMAGE_MAX_NAME + 4)];
  size_t n = 0;
  for (int i = 0; i < image->layers; i++)
    n += (size_t)snprintf(text + n, sizeof text - n, "%s%s:%d", i ? " " : "", image->layer[i].name,
                          image->layer[i].channels);
  return exr_attr_set_string(c, 0, EXR_ORDER_ATTRIBUTE, text);
}

static exr_result_t write_header(exr_context_t c, const ylm_image *image, exr_pixel_type_t type) {
  exr_result_t r = exr_set_longname_support(c, 1);
  if (r == EXR_ERR_SUCCESS) r = exr_add_part(c, "picture", EXR_STORAGE_SCANLINE, NULL);
  if (r == EXR_ERR_SUCCESS)
    r = exr_initialize_required_attr_simple(c, 0, image->width, image->height, EXR_COMPRESSION_ZIP);
  for (int i = 0; r == EXR_ERR_SUCCESS && i < image->layers; i++)
    for (int k = 0; r == EXR_ERR_SUCCESS && k < image->layer[i].channels; k++) {
      char name[80];
      channel_name(image, i, k, name);
      r = (exr_result_t)exr_add_channel(c, 0, name, type, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
  for (int i = 0; r == EXR_ERR_SUCCESS && i < image->texts; i++) {
    char room[32];
    r = exr_attr_set_string(c, 0, ylm__exr_attribute(image->text[i].key, room),
                            image->text[i].value);
  }
  if (r == EXR_ERR_SUCCESS) r = write_order(c, image);
  if (r == EXR_ERR_SUCCESS) r = exr_write_header(c);
  return r;
}

/* The layer and channel that an EXR channel stands for. */
static const float *find_channel(const ylm_image *image, const char *wanted, int *stride) {
  char name[80];
  for (int i = 0; i < image->layers; i++)
    for (int k = 0; k < image->layer[i].channels; k++) {
      channel_name(image, i, k, name);
      if (strcmp(name, wanted) != 0) continue;
      *stride = image->layer[i].channels;
      return image->layer[i].data + k;
    }
  return NULL;
}

/* Rows y .. y+rows-1 of one channel, cut to what half precision holds. */
static void gather(const float *from, int stride, int width, int y, int rows, bool half,
                   float *out) {
  size_t n = (size_t)width * (size_t)rows;
  from += (size_t)y * (size_t)width * (size_t)stride;
  for (size_t i = 0; i < n; i++) {
    float x = from[i * (size_t)stride];
    if (half && isfinite(x)) x = x > 65504.0f ? 65504.0f : x < -65504.0f ? -65504.0f : x;
    out[i] = x;
  }
}

static exr_result_t write_chunks(exr_context_t c, const ylm_image *image, bool half, float *rows,
                                 int per_chunk) {
  exr_encode_pipeline_t p = EXR_ENCODE_PIPELINE_INITIALIZER;
  exr_result_t r = EXR_ERR_SUCCESS;
  bool begun = false;
  size_t each = (size_t)image->width * (size_t)per_chunk;
  for (int y = 0; r == EXR_ERR_SUCCESS && y < image->height; y += per_chunk) {
    exr_chunk_info_t chunk;
    r = exr_write_scanline_chunk_info(c, 0, y, &chunk);
    if (r != EXR_ERR_SUCCESS) break;
    r = begun ? exr_encoding_update(c, 0, &chunk, &p) : exr_encoding_initialize(c, 0, &chunk, &p);
    if (r != EXR_ERR_SUCCESS) break;
    for (int k = 0; k < p.channel_count; k++) {
      exr_coding_channel_info_t *ch = &p.channels[k];
      int stride = 1;
      const float *from = find_channel(image, ch->channel_name, &stride);
      gather(from, stride, image->width, y, chunk.height, half, rows + (size_t)k * each);
      ch->encode_from_ptr = (const uint8_t *)(rows + (size_t)k * each);
      ch->user_bytes_per_element = 4;
      ch->user_data_type = EXR_PIXEL_FLOAT;
      ch->user_pixel_stride = 4;
      ch->user_line_stride = 4 * image->width;
    }
    if (!begun) r = exr_encoding_choose_default_routines(c, 0, &p);
    begun = true;
    if (r == EXR_ERR_SUCCESS) r = exr_encoding_run(c, 0, &p);
  }
  exr_encoding_destroy(c, &p);
  return r;
}

static exr_result_t write_pixels(exr_context_t c, const ylm_image *image, bool half) {
  int32_t per_chunk = 1, channels = 0;
  exr_result_t r = exr_get_scanlines_per_chunk(c, 0, &per_chunk);
  if (r != EXR_ERR_SUCCESS) return r;
  for (int i = 0; i < image->layers; i++) channels += image->layer[i].channels;
  float *rows =
      ylm_alloc((size_t)image->width * (size_t)per_chunk * (size_t)channels, sizeof *rows);
  if (!rows) return EXR_ERR_OUT_OF_MEMORY;
  r = write_chunks(c, image, half, rows, per_chunk);
  ylm_free(rows);
  return r;
}

ylm_status ylm__exr_write(const ylm_image *image, const ylm_layer *layer, const char *path,
                          const ylm_codec_options *o, ylm_error *e) {
  (void)layer;
  if (o->bits != 0 && o->bits != 16 && o->bits != 32)
    return ylm_fail(e, YLM_EINVAL, "%s: OpenEXR has 16 or 32 bits, not %d", path, o->bits);
  ylm__exr_stream s = {0};
  ylm_status st = ylm_file_create(path, &s.file, e);
  if (st != YLM_OK) return st;
  exr_context_initializer_t init = ylm__exr_settings(&s);
  init.write_fn = on_write;
  init.error_handler_fn = on_write_error;
  exr_context_t c = NULL;
  exr_result_t r = exr_start_write(&c, path, EXR_WRITE_FILE_DIRECTLY, &init);
  if (r == EXR_ERR_SUCCESS)
    r = write_header(c, image, o->bits == 16 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT);
  if (r == EXR_ERR_SUCCESS) r = write_pixels(c, image, o->bits == 16);
  if (c) {
    exr_result_t last = exr_finish(&c);
    if (r == EXR_ERR_SUCCESS) r = last;
  }
  if (r == EXR_ERR_SUCCESS || s.failed) return ylm_file_commit(s.file, e);
  ylm_file_discard(s.file);
  st = r == EXR_ERR_OUT_OF_MEMORY ? YLM_ENOMEM : YLM_EINVAL;
  return ylm_fail(e, st, "%s: OpenEXR: %s", path, exr_get_error_code_as_string(r));
}
