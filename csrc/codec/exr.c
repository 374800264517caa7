/* exr.c - how OpenEXRCore is set up, for reading and writing. */
#include "exr.h"

#include <stdio.h>
#include <string.h>

static bool is_taken(const char *name) {
  static const char *const taken[] = {"channels",
                                      "chunkCount",
                                      "compression",
                                      "dataWindow",
                                      "displayWindow",
                                      "lineOrder",
                                      "name",
                                      "tiles",
                                      "type",
                                      "version",
                                      "pixelAspectRatio",
                                      "screenWindowCenter",
                                      "screenWindowWidth",
                                      EXR_ORDER_ATTRIBUTE};
  for (size_t i = 0; i < sizeof taken / sizeof *taken; i++)
    if (strcmp(name, taken[i]) == 0) return true;
  return false;
}

static const char prefix[] = "ylm.";

const char *ylm__exr_attribute(const char *key, char room[32]) {
  if (!is_taken(key)) return key;
  snprintf(room, 32, "%s%s", prefix, key);
  return room;
}

const char *ylm__exr_text(const char *name) {
  size_t n = sizeof prefix - 1;
  return strncmp(name, prefix, n) == 0 && is_taken(name + n) ? name + n : name;
}

exr_context_initializer_t ylm__exr_settings(ylm__exr_stream *s) {
  exr_context_initializer_t i = EXR_DEFAULT_CONTEXT_INITIALIZER;
  i.user_data = s;
  i.max_image_width = i.max_image_height = YLM_IMAGE_MAX_SIDE;
  i.max_tile_width = i.max_tile_height = YLM_IMAGE_MAX_SIDE;
  i.zip_level = 4;
  i.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
  return i;
}
