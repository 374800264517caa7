/* exr.c - how OpenEXRCore is set up, for reading and writing. */
#include "exr.h"

exr_context_initializer_t ylm__exr_settings(ylm__exr_stream *s) {
  exr_context_initializer_t i = EXR_DEFAULT_CONTEXT_INITIALIZER;
  i.user_data = s;
  i.max_image_width = i.max_image_height = YLM_IMAGE_MAX_SIDE;
  i.max_tile_width = i.max_tile_height = YLM_IMAGE_MAX_SIDE;
  i.zip_level = 4;
  i.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
  return i;
}
