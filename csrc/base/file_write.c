/* file_write.c - whole files out, or none. */
#include "file_place.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct ylm_file {
  FILE *stream;
  char *path; /* as the caller calls it */
  ylm__place place;
  char unfinished[YLM__UNFINISHED_NAME]; /* its name until the commit */
  bool failed;
  int code; /* errno of the first failure */
};

static void destroy(ylm_file *f) {
  ylm__place_leave(&f->place);
  free(f->path);
  free(f);
}

/* Opens the stream of a file whose place is known. */
static bool open_stream(ylm_file *f) {
  int fd = ylm__place_open(&f->place, f->unfinished);
  if (fd < 0) return false;
  f->stream = fdopen(fd, "w+b");
  if (f->stream) return true;
  int code = errno;
  unlinkat(f->place.folder, f->unfinished, 0);
  close(fd);
  errno = code;
  return false;
}

/* Says why no file could be made beside the place. */
static ylm_status fail_to_open(const ylm_file *f, ylm_error *e) {
  const char *why = strerror(errno);
  if (errno == ENOMEM) return ylm_no_memory_for(e, f->path);
  if (f->place.exists)
    return ylm_fail(
        e, YLM_EIO,
        "%s: cannot be written: the new file is made beside the old one before it takes "
        "its place, and that folder takes none: %s",
        f->path, why);
  return ylm_fail(e, YLM_EIO, "%s: cannot be created: %s", f->path, why);
}

ylm_status ylm_file_create(const char *path, ylm_file **out, ylm_error *e) {
  *out = NULL;
  ylm_file *f = calloc(1, sizeof *f);
  if (f) f->place.folder = -1;
  if (f) f->path = strdup(path);
  if (!f || !f->path) {
    free(f);
    return ylm_no_memory_for(e, path);
  }
  ylm_status s = ylm__place_find(path, &f->place, e);
  if (s == YLM_OK) {
    ylm__place_sweep(&f->place);
    if (!open_stream(f)) s = fail_to_open(f, e);
  }
  if (s != YLM_OK) {
    destroy(f);
    return s;
  }
  *out = f;
  return YLM_OK;
}

ylm_status ylm_file_write(ylm_file *f, const void *data, size_t size) {
  if (size && !f->failed && fwrite(data, 1, size, f->stream) != size) {
    f->failed = true;
    f->code = errno;
  }
  return f->failed ? YLM_EIO : YLM_OK;
}

FILE *ylm_file_stream(ylm_file *f) { return f->stream; }

ylm_status ylm_file_commit(ylm_file *f, ylm_error *e) {
  ylm_status s = YLM_OK;
  errno = 0;
  bool bad = f->failed || ferror(f->stream) || fflush(f->stream) != 0;
  if (!bad && fsync(fileno(f->stream)) != 0 && errno != EINVAL && errno != EROFS) bad = true;
  int code = f->failed ? f->code : errno;
  if (fclose(f->stream) != 0) bad = true;
  const ylm__place *p = &f->place;
  if (!bad && renameat(p->folder, f->unfinished, p->folder, p->name) != 0) {
    bad = true;
    code = errno;
  }
  if (bad) {
    s = ylm_fail(e, YLM_EIO, "%s: cannot be written: %s", f->path,
                 code ? strerror(code) : "the device may be full");
    unlinkat(p->folder, f->unfinished, 0);
  }
  destroy(f);
  return s;
}

void ylm_file_discard(ylm_file *f) {
  if (!f) return;
  fclose(f->stream);
  unlinkat(f->place.folder, f->unfinished, 0);
  destroy(f);
}

ylm_status ylm_file_probe(const char *path, ylm_error *e) {
  ylm_file *f;
  ylm_status s = ylm_file_create(path, &f, e);
  if (s == YLM_OK) ylm_file_discard(f);
  return s;
}

ylm_status ylm_file_save(const char *path, const void *data, size_t size, ylm_error *e) {
  ylm_file *f;
  ylm_status s = ylm_file_create(path, &f, e);
  if (s != YLM_OK) return s;
  ylm_file_write(f, data, size);
  return ylm_file_commit(f, e);
}
