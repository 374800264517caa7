/* missing.c - stands for the other files of this room where jansson is not installed. */
#include "ylm_gltf.h"

static ylm_status missing(ylm_gltf **g, ylm_error *e) {
  *g = NULL;
  return ylm_fail(e, YLM_EMISSING,
                  "glTF needs jansson: install libjansson-dev, and build ylm again");
}

ylm_status ylm_gltf_decode(const unsigned char *data, size_t size, const char *name,
                           const ylm_gltf_options *o, ylm_gltf **g, ylm_error *e) {
  (void)data, (void)size, (void)name, (void)o;
  return missing(g, e);
}

ylm_status ylm_gltf_read(const char *path, size_t limit, const ylm_gltf_options *o, ylm_gltf **g,
                         ylm_error *e) {
  (void)path, (void)limit, (void)o;
  return missing(g, e);
}

void ylm_gltf_free(ylm_gltf *g) { (void)g; }

bool ylm_gltf_is_binary(const unsigned char *data, size_t size) {
  return size >= 4 && memcmp(data, "glTF", 4) == 0;
}
