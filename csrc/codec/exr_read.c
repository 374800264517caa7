/*
** exr_read.c - reads OpenEXR through OpenEXRCore's C interface: groups of channels become layers.
*/
#include "exr.h"

#include <string.h>

#define MAX_CHANNELS (4 * YLM_IMAGE_MAX_LAYERS)

/* -- streams, errors -- */

/* Keeps the first message of a file that is read. */
static void on_error(exr_const_context_t c, exr_result_t code, const char *text) {
  void *user = NULL;
  (void)code;
  if (!c || exr_get_user_data(c, &user) != EXR_ERR_SUCCESS || !user) return;
  ylm__exr_stream *s = user;
  if (!s->message[0]) snprintf(s->message, sizeof s->message, "%s", text);
}

static int64_t on_read(exr_const_context_t c, void *user, void *out, uint64_t n, uint64_t at,
                       exr_stream_error_func_ptr_t error) {
  ylm__exr_stream *s = user;
  (void)c;
  (void)error;
  if (at > s->size) at = s->size;
  if (n > s->size - at) n = s->size - at; /* the header is read ahead: the library counts */
  memcpy(out, s->bytes + at, (size_t)n);
  return (int64_t)n;
}

static int64_t on_size(exr_const_context_t c, void *user) {
  (void)c;
  return (int64_t)((ylm__exr_stream *)user)->size;
}

/* One channel of the file and where it goes. */
typedef struct channel {
  char group[YLM_IMAGE_MAX_NAME + 1]; /* "" for channels without a prefix */
  const char *name, *suffix;
  bool integer;
  int layer, index; /* in the image */
} channel;

typedef struct reading {
  ylm__exr_stream s;
  exr_context_t c;
  const char *name;
  const ylm_codec_input *input;
  ylm_error *e;
  int channels;
  channel channel[MAX_CHANNELS];
  ylm_image *image;
  int x0, y0; /* of the data window */
} reading;

static ylm_status fail(reading *r, const char *what) {
  return ylm_fail(r->e, YLM_EFORMAT, "%s: OpenEXR: %s", r->name,
                  what              ? what
                  : r->s.message[0] ? r->s.message
                                    : "damaged or truncated");
}

/* -- channels and layers -- */

/* Where a channel stands among those of its layer: R G B A, X Y Z, U V, then by name. */
static int rank_of(const char *suffix) {
  static const char order[] = "RGBAXYZUVW";
  const char *at = suffix[0] && !suffix[1] ? strchr(order, suffix[0]) : NULL;
  return at ? (int)(at - order) : 100;
}

/* Letters that a layer's name may have; others become '_'. */
static char clean(char c) {
  bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
              c == '-' || c == '.';
  return good ? c : '_';
}

static ylm_status list_channels(reading *r) {
  const exr_attr_chlist_t *list;
  if (exr_get_channels(r->c, 0, &list) != EXR_ERR_SUCCESS) return fail(r, NULL);
  if (list->num_channels < 1 || list->num_channels > MAX_CHANNELS)
    return fail(r, "no channels, or too many");
  r->channels = list->num_channels;
  for (int i = 0; i < r->channels; i++) {
    const exr_attr_chlist_entry_t *entry = &list->entries[i];
    channel *ch = &r->channel[i];
    if (entry->x_sampling != 1 || entry->y_sampling != 1)
      return fail(r, "subsampled channels are not supported");
    ch->name = entry->name.str;
    const char *dot = strrchr(ch->name, '.');
    size_t n = dot ? (size_t)(dot - ch->name) : 0;
    if (n > YLM_IMAGE_MAX_NAME) n = YLM_IMAGE_MAX_NAME;
    for (size_t k = 0; k < n; k++) ch->group[k] = clean(ch->name[k]);
    ch->group[n] = 0;
    ch->suffix = dot ? dot + 1 : ch->name;
    ch->integer = entry->pixel_type == EXR_PIXEL_UINT;
  }
  return YLM_OK;
}

/* True if channel a comes before b within a layer. */
static bool before(const channel *a, const channel *b) {
  int ra = rank_of(a->suffix), rb = rank_of(b->suffix);
  return ra != rb ? ra < rb : strcmp(a->suffix, b->suffix) < 0;
}

/* Adds a layer of the unassigned channels of `group`; more than four make further layers. */
static ylm_status add_group(reading *r, const char *group, const char *name) {
  for (int part = 1;; part++) {
    channel *member[MAX_CHANNELS];
    int n = 0;
    for (int i = 0; i < r->channels; i++) {
      channel *ch = &r->channel[i];
      if (ch->layer >= 0 || strcmp(ch->group, group) != 0) continue;
      int k = n++;
      while (k > 0 && before(ch, member[k - 1])) member[k] = member[k - 1], k--;
      member[k] = ch;
    }
    if (n == 0) return YLM_OK;
    if (n > 4) n = 4;
    char unique[YLM_IMAGE_MAX_NAME + 1 + 12];
    snprintf(unique, YLM_IMAGE_MAX_NAME + 1, "%s", name);
    for (int k = part; ylm_image_find(r->image, unique); k++)
      snprintf(unique, sizeof unique, "%.*s-%d", YLM_IMAGE_MAX_NAME - 12, name, k + 1);
    ylm_status st = ylm_image_add(r->image, unique, n, r->e);
    if (st != YLM_OK) return st;
    for (int k = 0; k < n; k++) member[k]->layer = r->image->layers - 1, member[k]->index = k;
  }
}

/* Layers in the order that ylm wrote down; what does not fit it is left for add_layers. */
static ylm_status add_ordered(reading *r, const char *order, int32_t length) {
  int32_t at = 0;
  for (int i = 0; at < length && i < YLM_IMAGE_MAX_LAYERS; i++) {
    char name[YLM_IMAGE_MAX_NAME + 1];
    size_t n = 0;
    while (at < length && order[at] != ':' && n < YLM_IMAGE_MAX_NAME)
      name[n++] = clean(order[at++]);
    name[n] = 0;
    while (at < length && order[at] != ' ') at++;
    at++;
    if (n == 0 || ylm_image_find(r->image, name)) return YLM_OK;
    ylm_status st = add_group(r, i == 0 ? "" : name, name);
    if (st != YLM_OK) return st;
  }
  return YLM_OK;
}

static ylm_status add_layers(reading *r) {
  const char *order;
  int32_t length;
  ylm_status st = YLM_OK;
  for (int i = 0; i < r->channels; i++) r->channel[i].layer = -1;
  if (exr_attr_get_string(r->c, 0, EXR_ORDER_ATTRIBUTE, &length, &order) == EXR_ERR_SUCCESS)
    st = add_ordered(r, order, length);
  r->s.message[0] = 0;
  if (st == YLM_OK) st = add_group(r, "", "radiance");
  for (int i = 0; st == YLM_OK && i < r->channels; i++)
    if (r->channel[i].layer < 0) {
      const char *group = r->channel[i].group;
      st = add_group(r, group, group[0] ? group : "unnamed");
    }
  return st;
}

/* -- pixels -- */

static ylm_status read_texts(reading *r) {
  int32_t n = 0;
  if (exr_get_attribute_count(r->c, 0, &n) != EXR_ERR_SUCCESS) return fail(r, NULL);
  for (int32_t i = 0; i < n; i++) {
    const exr_attribute_t *a;
    if (exr_get_attribute_by_index(r->c, 0, EXR_ATTR_LIST_FILE_ORDER, i, &a) != EXR_ERR_SUCCESS)
      return fail(r, NULL);
    if (a->type != EXR_ATTR_STRING || strcmp(a->name, EXR_ORDER_ATTRIBUTE) == 0 ||
        strcmp(a->name, "name") == 0 || strcmp(a->name, "type") == 0)
      continue;
    const char *key = ylm__exr_text(a->name);
    ylm_status st = a->string->str ? ylm_image_set_text(r->image, key, a->string->str) : YLM_OK;
    if (st == YLM_ENOMEM) return ylm_no_memory_for(r->e, r->name);
  }
  return YLM_OK;
}

/* Points the pipeline at the image; rows below or right of it cannot occur. */
static bool aim(reading *r, exr_decode_pipeline_t *p, int x, int y) {
  for (int k = 0; k < p->channel_count; k++) {
    exr_coding_channel_info_t *ch = &p->channels[k];
    const channel *to = NULL;
    for (int i = 0; i < r->channels && !to; i++)
      if (strcmp(r->channel[i].name, ch->channel_name) == 0) to = &r->channel[i];
    if (!to || x < 0 || y < 0 || ch->width < 0 || ch->height < 0 ||
        x + ch->width > r->image->width || y + ch->height > r->image->height)
      return false;
    ylm_layer *layer = &r->image->layer[to->layer];
    size_t pixel = (size_t)y * (size_t)r->image->width + (size_t)x;
    ch->decode_to_ptr = (uint8_t *)(layer->data + pixel * (size_t)layer->channels + to->index);
    ch->user_bytes_per_element = 4;
    ch->user_data_type = to->integer ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
    ch->user_pixel_stride = 4 * layer->channels;
    ch->user_line_stride = 4 * layer->channels * r->image->width;
  }
  return true;
}

/* Decodes one chunk. */
static bool decode(reading *r, const exr_chunk_info_t *chunk, exr_decode_pipeline_t *p, bool *begun,
                   int x, int y) {
  exr_result_t code =
      *begun ? exr_decoding_update(r->c, 0, chunk, p) : exr_decoding_initialize(r->c, 0, chunk, p);
  if (code != EXR_ERR_SUCCESS || !aim(r, p, x, y)) return false;
  if (!*begun && exr_decoding_choose_default_routines(r->c, 0, p) != EXR_ERR_SUCCESS) return false;
  *begun = true;
  return exr_decoding_run(r->c, 0, p) == EXR_ERR_SUCCESS;
}

static bool read_scanlines(reading *r, exr_decode_pipeline_t *p) {
  int32_t per_chunk;
  bool begun = false;
  if (exr_get_scanlines_per_chunk(r->c, 0, &per_chunk) != EXR_ERR_SUCCESS || per_chunk < 1)
    return false;
  for (int y = 0; y < r->image->height; y += per_chunk) {
    exr_chunk_info_t chunk;
    if (exr_read_scanline_chunk_info(r->c, 0, y + r->y0, &chunk) != EXR_ERR_SUCCESS) return false;
    if (!decode(r, &chunk, p, &begun, 0, y)) return false;
  }
  return true;
}

static bool read_tiles(reading *r, exr_decode_pipeline_t *p) {
  int32_t tw, th;
  bool begun = false;
  if (exr_get_tile_sizes(r->c, 0, 0, 0, &tw, &th) != EXR_ERR_SUCCESS || tw < 1 || th < 1)
    return false;
  for (int ty = 0; ty * (int64_t)th < r->image->height; ty++)
    for (int tx = 0; tx * (int64_t)tw < r->image->width; tx++) {
      exr_chunk_info_t chunk;
      if (exr_read_tile_chunk_info(r->c, 0, tx, ty, 0, 0, &chunk) != EXR_ERR_SUCCESS) return false;
      if (!decode(r, &chunk, p, &begun, tx * tw, ty * th)) return false;
    }
  return true;
}

/* Integer channels were read as they stand: their bits become numbers. */
static void convert_integers(reading *r) {
  size_t n = (size_t)r->image->width * (size_t)r->image->height;
  for (int i = 0; i < r->channels; i++) {
    const channel *ch = &r->channel[i];
    if (!ch->integer) continue;
    const ylm_layer *layer = &r->image->layer[ch->layer];
    for (size_t k = 0; k < n; k++) {
      uint32_t u;
      float *x = layer->data + k * (size_t)layer->channels + ch->index;
      memcpy(&u, x, sizeof u);
      *x = (float)u;
    }
  }
}

/* DWA is read by OpenEXRCore 3.2 and later. */
static bool reads_dwa(void) {
  int major, minor, patch;
  const char *more;
  exr_get_library_version(&major, &minor, &patch, &more);
  return major > 3 || (major == 3 && minor >= 2);
}

/* Refuses a size that the file cannot hold, before memory is taken: black pixels of 16 bits become 953 times smaller by
   ZIP and 401 times by PIZ; DWA keeps a number for 64 of them, which is packed as ZIP does. */
static ylm_status check_size(reading *r, int64_t width, int64_t height) {
  exr_compression_t how;
  if (exr_get_compression(r->c, 0, &how) != EXR_ERR_SUCCESS) return fail(r, NULL);
  bool dwa = how == EXR_COMPRESSION_DWAA || how == EXR_COMPRESSION_DWAB;
  if (dwa && !reads_dwa()) return fail(r, "DWA compression is read by OpenEXR 3.2 and later");
  uint64_t pixels = (uint64_t)width * (uint64_t)height;
  ylm_status st = ylm__codec_check_size(r->name, r->input, (uint64_t)width, (uint64_t)height,
                                        r->channels, r->e);
  if (st != YLM_OK) return st;
  if (pixels * 2 * (uint64_t)r->channels / (dwa ? 50000 : 1100) > r->s.size)
    return fail(r, "truncated");
  return YLM_OK;
}

static ylm_status read_all(reading *r) {
  exr_attr_box2i_t box;
  exr_storage_t storage;
  if (exr_get_data_window(r->c, 0, &box) != EXR_ERR_SUCCESS) return fail(r, NULL);
  if (exr_get_storage(r->c, 0, &storage) != EXR_ERR_SUCCESS) return fail(r, NULL);
  if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
    return fail(r, "deep images are not supported");
  int64_t width = (int64_t)box.max.x - box.min.x + 1, height = (int64_t)box.max.y - box.min.y + 1;
  r->x0 = box.min.x;
  r->y0 = box.min.y;
  ylm_status st = list_channels(r);
  if (st == YLM_OK) st = check_size(r, width, height);
  if (st == YLM_OK) st = ylm_image_create((int)width, (int)height, &r->image, r->e);
  if (st == YLM_OK) st = add_layers(r);
  if (st == YLM_OK) st = read_texts(r);
  if (st != YLM_OK) return st;
  exr_decode_pipeline_t p = EXR_DECODE_PIPELINE_INITIALIZER;
  bool ok = storage == EXR_STORAGE_SCANLINE ? read_scanlines(r, &p) : read_tiles(r, &p);
  exr_decoding_destroy(r->c, &p);
  if (!ok) return fail(r, NULL);
  convert_integers(r);
  return YLM_OK;
}

ylm_status ylm__exr_parse(const unsigned char *bytes, size_t size, const char *name,
                          const ylm_codec_input *input, ylm_image **image, ylm_error *e) {
  *image = NULL;
  reading *r = ylm_alloc_zero(1, sizeof *r);
  if (!r) return ylm_no_memory_for(e, name);
  r->s.bytes = bytes;
  r->s.size = size;
  r->name = name;
  r->input = input;
  r->e = e;
  exr_context_initializer_t init = ylm__exr_settings(&r->s);
  init.error_handler_fn = on_error;
  init.read_fn = on_read;
  init.size_fn = on_size;
  ylm_status st = YLM_OK;
  if (exr_start_read(&r->c, name, &init) != EXR_ERR_SUCCESS) st = fail(r, NULL);
  if (st == YLM_OK) st = read_all(r);
  if (r->c) exr_finish(&r->c);
  if (st == YLM_OK)
    *image = r->image;
  else
    ylm_image_free(r->image);
  ylm_free(r);
  return st;
}
