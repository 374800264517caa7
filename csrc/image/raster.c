/* raster.c - images: sizes, layers, metadata. */
#include "ylm_image.h"
#include "ylm_list.h"

#include <string.h>

ylm_status ylm_image_create(int width, int height, ylm_image **out, ylm_error *e) {
  *out = NULL;
  if (width < 1 || height < 1 || width > YLM_IMAGE_MAX_SIDE || height > YLM_IMAGE_MAX_SIDE)
    return ylm_fail(e, YLM_ERANGE, "image size %d x %d: sides must be 1 .. %d", width, height,
                    YLM_IMAGE_MAX_SIDE);
  if ((size_t)width * (size_t)height > YLM_IMAGE_MAX_PIXELS)
    return ylm_fail(e, YLM_EOVERFLOW, "image size %d x %d: more than %zu pixels", width, height,
                    YLM_IMAGE_MAX_PIXELS);
  ylm_image *image = ylm_alloc_zero(1, sizeof *image);
  if (!image) return ylm_fail(e, YLM_ENOMEM, "no memory for an image");
  image->width = width;
  image->height = height;
  *out = image;
  return YLM_OK;
}

static void free_text(ylm_text *t) {
  ylm_free(t->key);
  ylm_free(t->value);
}

void ylm_image_free(ylm_image *image) {
  if (!image) return;
  for (int i = 0; i < image->layers; i++) ylm_free(image->layer[i].data);
  for (int i = 0; i < image->texts; i++) free_text(&image->text[i]);
  ylm_free(image->text);
  ylm_free(image);
}

/* True for 1 .. YLM_IMAGE_MAX_NAME letters, digits, '_', '-', '.'. */
static bool is_name(const char *s) {
  size_t n = 0;
  for (; s[n]; n++) {
    char c = s[n];
    bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                c == '_' || c == '-' || c == '.';
    if (!good || n == YLM_IMAGE_MAX_NAME) return false;
  }
  return n > 0;
}

ylm_layer *ylm_image_find(const ylm_image *image, const char *name) {
  for (int i = 0; i < image->layers; i++)
    if (!name || strcmp(image->layer[i].name, name) == 0) return (ylm_layer *)&image->layer[i];
  return NULL;
}

ylm_status ylm_image_add(ylm_image *image, const char *name, int channels, ylm_error *e) {
  if (!is_name(name))
    return ylm_fail(e, YLM_EINVAL,
                    "layer name '%.80s': 1 to %d letters, digits, '_', '-' or '.' expected", name,
                    YLM_IMAGE_MAX_NAME);
  if (ylm_image_find(image, name))
    return ylm_fail(e, YLM_EINVAL, "layer '%s' is there already", name);
  if (channels < 1 || channels > 4)
    return ylm_fail(e, YLM_ERANGE, "layer '%s': 1 to 4 channels, not %d", name, channels);
  if (image->layers == YLM_IMAGE_MAX_LAYERS)
    return ylm_fail(e, YLM_ERANGE, "an image has at most %d layers", YLM_IMAGE_MAX_LAYERS);
  size_t pixels = (size_t)image->width * (size_t)image->height;
  float *data = ylm_alloc_zero(pixels * (size_t)channels, sizeof(float));
  if (!data)
    return ylm_fail(e, YLM_ENOMEM, "no memory for layer '%s' of %d x %d x %d", name, image->width,
                    image->height, channels);
  ylm_layer *layer = &image->layer[image->layers++];
  strcpy(layer->name, name);
  layer->channels = channels;
  layer->data = data;
  return YLM_OK;
}

static char *copy_text(const char *s) { return ylm_alloc_copy(s, strlen(s) + 1, 1); }

ylm_status ylm_image_set_text(ylm_image *image, const char *key, const char *value) {
  size_t length = strlen(key);
  if (length < 1 || length > 255) return YLM_EINVAL;
  int i = 0;
  while (i < image->texts && strcmp(image->text[i].key, key) < 0) i++;
  bool there = i < image->texts && strcmp(image->text[i].key, key) == 0;
  if (!value) {
    if (!there) return YLM_OK;
    free_text(&image->text[i]);
    memmove(image->text + i, image->text + i + 1, (size_t)(--image->texts - i) * sizeof(ylm_text));
    return YLM_OK;
  }
  char *v = copy_text(value), *k = there ? NULL : copy_text(key);
  if (!v || (!there && !k)) goto no_memory;
  if (there) {
    ylm_free(image->text[i].value);
    image->text[i].value = v;
    return YLM_OK;
  }
  size_t used = (size_t)image->texts;
  if (!ylm_list_resize(&image->text, used, used + 1, sizeof *image->text)) goto no_memory;
  ylm_text *grown = image->text;
  memmove(grown + i + 1, grown + i, (size_t)(image->texts++ - i) * sizeof *grown);
  grown[i] = (ylm_text){k, v};
  return YLM_OK;
no_memory:
  ylm_free(v);
  ylm_free(k);
  return YLM_ENOMEM;
}

const char *ylm_image_get_text(const ylm_image *image, const char *key) {
  for (int i = 0; i < image->texts; i++)
    if (strcmp(image->text[i].key, key) == 0) return image->text[i].value;
  return NULL;
}
