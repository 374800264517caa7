/* file.c - grids from files and from memory. */
#include "file.h"

ylm_status ylm__grid_file_machine(const char *name, ylm_error *e) {
  if (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__) return YLM_OK;
  return ylm_fail(e, YLM_EFORMAT, "%s: grid files are little-endian, this processor is not", name);
}

ylm_status ylm__grid_file_bad(const char *name, const char *what, ylm_error *e) {
  return ylm_fail(e, YLM_EFORMAT, "%s: not a valid grid: %s", name, what);
}

ylm_status ylm_grid_decode(const unsigned char *data, size_t size, const char *name, ylm_grid **g,
                           ylm_error *e) {
  file_source source;
  *g = NULL;
  ylm_status s = ylm__file_source_memory(&source, name, data, size, e);
  return s == YLM_OK ? ylm__grid_file_read_source(&source, NULL, 0, g, e) : s;
}

ylm_status ylm__grid_file_read(const char *path, grid_file_room *room, int threads, ylm_grid **g,
                               ylm_error *e) {
  file_source source;
  *g = NULL;
  ylm_status s = ylm__file_source_open(&source, path, e);
  if (s == YLM_OK) s = ylm__grid_file_read_source(&source, room, threads, g, e);
  ylm__file_source_close(&source);
  return s;
}

ylm_status ylm_grid_read(const char *path, ylm_grid **g, ylm_error *e) {
  return ylm__grid_file_read(path, NULL, 0, g, e);
}
