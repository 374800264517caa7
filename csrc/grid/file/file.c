/*
** file.c - grids from files and from memory, of whichever version.
**
** Version 2 is written and read (file.h, write.c); version 1 is read.
*/
#include "file.h"

#include <string.h>

#define MAX_LIMIT ((size_t)64 << 30) /* of a file of version 1, which is read whole */

ylm_status ylm__grid_file_machine(const char *name, ylm_error *e) {
  if (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__) return YLM_OK;
  return ylm_fail(e, YLM_EFORMAT, "%s: grid files are little-endian, this processor is not", name);
}

ylm_status ylm__grid_file_bad(const char *name, const char *what, ylm_error *e) {
  return ylm_fail(e, YLM_EFORMAT, "%s: not a valid grid: %s", name, what);
}

/* A file of version 1 at a path. */
static ylm_status read_whole(const file_source *source, ylm_grid **g, ylm_error *e) {
  unsigned char *data;
  size_t size;
  ylm_status s = ylm_file_read(source->name, MAX_LIMIT, &data, &size, e);
  if (s != YLM_OK) return s;
  if (size == source->size)
    s = ylm__grid_file_read_1(source->name, data, size, source->swapped, g, e);
  else
    s = ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file changed while it was read", source->name);
  ylm_free(data);
  return s;
}

ylm_status ylm_grid_decode(const unsigned char *data, size_t size, const char *name, ylm_grid **g,
                           ylm_error *e) {
  file_source source;
  *g = NULL;
  ylm_status s = ylm__file_source_memory(&source, name, data, size, e);
  if (s != YLM_OK) return s;
  return source.version == 1 ? ylm__grid_file_read_1(name, data, size, source.swapped, g, e)
                             : ylm__grid_file_read_2(&source, NULL, 0, g, e);
}

ylm_status ylm__grid_file_read(const char *path, grid_file_room *room, int threads, ylm_grid **g,
                               ylm_error *e) {
  file_source source;
  *g = NULL;
  ylm_status s = ylm__file_source_open(&source, path, e);
  if (s == YLM_OK)
    s = source.version == 1 ? read_whole(&source, g, e)
                            : ylm__grid_file_read_2(&source, room, threads, g, e);
  ylm__file_source_close(&source);
  return s;
}

ylm_status ylm_grid_read(const char *path, ylm_grid **g, ylm_error *e) {
  return ylm__grid_file_read(path, NULL, 0, g, e);
}
