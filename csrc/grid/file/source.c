/* source.c - the bytes that a grid is read from. */
#include "file.h"
#include "ylm_crc.h"

#include <errno.h>
#include <string.h>

/* Magic, byte order, version and size, from the first bytes. */
static ylm_status look(file_source *s, const unsigned char *head, size_t n, ylm_error *e) {
  grid_file_header h = {.order = 0};
  if (n < 8 || memcmp(head, YLM_GRID_MAGIC, 8) != 0)
    return ylm_fail(e, YLM_EFORMAT, "%s: not a grid file of ylm", s->name);
  if (n < GRID_FILE_LEAST)
    return ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file is cut off", s->name);
  memcpy(&h, head, GRID_FILE_LEAST);
  if (h.order == __builtin_bswap32(GRID_FILE_ORDER))
    return ylm_fail(e, YLM_EFORMAT, "%s: not a valid grid: big-endian numbers", s->name);
  if (h.order != GRID_FILE_ORDER)
    return ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file is damaged (byte order)", s->name);
  if (h.version != GRID_FILE_VERSION)
    return ylm_fail(e, YLM_EVERSION, "%s: grid file of version %u, this is ylm with version %u",
                    s->name, h.version, GRID_FILE_VERSION);
  if (h.size != s->size)
    return ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file is damaged: %llu bytes, should be %llu",
                    s->name, (unsigned long long)s->size, (unsigned long long)h.size);
  return YLM_OK;
}

ylm_status ylm__file_source_memory(file_source *s, const char *name, const unsigned char *data,
                                   size_t size, ylm_error *e) {
  *s = (file_source){.name = name, .data = data, .size = size};
  return look(s, data, size, e);
}

ylm_status ylm__file_source_open(file_source *s, const char *path, ylm_error *e) {
  unsigned char head[GRID_FILE_LEAST];
  size_t n;
  *s = (file_source){.name = path};
  ylm_status status = ylm_file_head(path, head, sizeof head, &n, e); /* a regular file, then */
  if (status != YLM_OK) return status;
  s->file = fopen(path, "rb");
  off_t size = s->file && fseeko(s->file, 0, SEEK_END) == 0 ? ftello(s->file) : -1;
  if (size < 0) return ylm_fail(e, YLM_EIO, "%s: %s", path, strerror(errno));
  setvbuf(s->file, NULL, _IONBF, 0);
  s->size = (uint64_t)size;
  return look(s, head, n, e);
}

void ylm__file_source_close(file_source *s) {
  if (s->file) fclose(s->file);
  s->file = NULL;
}

/* n bytes that follow one another in the file. */
static ylm_status take(const file_source *s, size_t n, void *to, ylm_error *e) {
  errno = 0;
  if (fread(to, 1, n, s->file) == n) return YLM_OK;
  if (ferror(s->file)) return ylm_fail(e, YLM_EIO, "%s: %s", s->name, strerror(errno));
  return ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file is cut off", s->name);
}

ylm_status ylm__file_source_read(const file_source *s, uint64_t at, size_t n, void *to,
                                 uint64_t *crc, bool *finite, ylm_error *e) {
  if (s->file && fseeko(s->file, (off_t)at, SEEK_SET) != 0)
    return ylm_fail(e, YLM_EIO, "%s: %s", s->name, strerror(errno));
  for (size_t done = 0; done < n;) {
    size_t some = n - done < GRID_FILE_CHUNK ? n - done : GRID_FILE_CHUNK;
    unsigned char *p = (unsigned char *)to + done;
    if (!s->file)
      memcpy(p, s->data + at + done, some);
    else if (take(s, some, p, e) != YLM_OK)
      return ferror(s->file) ? YLM_EIO : YLM_ECHECKSUM;
    if (finite)
      *crc = ylm_crc64_floats(*crc, p, some, finite);
    else if (crc)
      *crc = ylm_crc64(*crc, p, some);
    done += some;
  }
  return YLM_OK;
}
