/* file.c - whole files in, whole files out or none. */
#include "ylm_base.h"

#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct ylm_file {
  FILE *stream;
  char *target, *temporary;
  bool failed;
  int code; /* errno of the first failure */
};

/* Opens a regular file and tells its size; -1 after an error. */
static int open_regular(const char *path, struct stat *st, ylm_error *e) {
  /* O_NONBLOCK: opening a named pipe must not wait for its writer. */
  int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    ylm_fail(e, YLM_EIO, "%s: %s", path, strerror(errno));
  } else if (fstat(fd, st) != 0 || !S_ISREG(st->st_mode)) {
    ylm_fail(e, YLM_EIO, "%s: not a regular file", path);
    close(fd);
    fd = -1;
  }
  return fd;
}

ylm_status ylm_file_head(const char *path, unsigned char *bytes, size_t room, size_t *size,
                         ylm_error *e) {
  struct stat st;
  *size = 0;
  int fd = open_regular(path, &st, e);
  if (fd < 0) return YLM_EIO;
  ssize_t r = 1;
  while (*size < room && r > 0) {
    r = read(fd, bytes + *size, room - *size);
    if (r < 0 && errno == EINTR)
      r = 1;
    else if (r > 0)
      *size += (size_t)r;
  }
  if (r < 0) ylm_fail(e, YLM_EIO, "%s: %s", path, strerror(errno));
  close(fd);
  return r < 0 ? YLM_EIO : YLM_OK;
}

ylm_status ylm_file_read(const char *path, size_t limit, unsigned char **data, size_t *size,
                         ylm_error *e) {
  if (limit == 0) limit = (size_t)4 << 30;
  struct stat st;
  int fd = open_regular(path, &st, e);
  if (fd < 0) return YLM_EIO;
  if (st.st_size < 0 || (uint64_t)st.st_size > limit) {
    close(fd);
    return ylm_fail(e, YLM_ELIMIT, "%s: %lld bytes, more than the limit of %zu", path,
                    (long long)st.st_size, limit);
  }
  size_t n = (size_t)st.st_size, got = 0;
  unsigned char *p = ylm_alloc(n + 1, 1);
  if (!p) {
    close(fd);
    return ylm_fail(e, YLM_ENOMEM, "%s: no memory for %zu bytes", path, n);
  }
  while (got < n) {
    ssize_t r = read(fd, p + got, n - got);
    if (r < 0 && errno == EINTR) continue;
    if (r < 0) {
      ylm_fail(e, YLM_EIO, "%s: %s", path, strerror(errno));
      ylm_free(p);
      close(fd);
      return YLM_EIO;
    }
    if (r == 0) break;
    got += (size_t)r;
  }
  close(fd);
  p[got] = 0;
  *data = p;
  *size = got;
  return YLM_OK;
}

static void destroy(ylm_file *f) {
  free(f->target);
  free(f->temporary);
  free(f);
}

/* Opens a new file "path.ylm-<pid>-<number>" beside the target. */
static FILE *open_beside(ylm_file *f) {
  static atomic_uint serial;
  size_t room = strlen(f->target) + 40;
  f->temporary = malloc(room);
  if (!f->temporary) return NULL;
  for (int attempt = 0; attempt < 100; attempt++) {
    snprintf(f->temporary, room, "%s.ylm-%ld-%u", f->target, (long)getpid(),
             atomic_fetch_add(&serial, 1u));
    int fd = open(f->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd >= 0) {
      FILE *s = fdopen(fd, "w+b");
      if (!s) {
        close(fd);
        unlink(f->temporary);
      }
      return s;
    }
    if (errno != EEXIST) break;
  }
  return NULL;
}

ylm_status ylm_file_create(const char *path, ylm_file **out, ylm_error *e) {
  struct stat st;
  *out = NULL;
  if (stat(path, &st) == 0 && !S_ISREG(st.st_mode))
    return ylm_fail(e, YLM_EIO, "%s: exists and is not a regular file", path);
  ylm_file *f = calloc(1, sizeof *f);
  if (f) f->target = strdup(path);
  if (!f || !f->target) {
    free(f);
    return ylm_fail(e, YLM_ENOMEM, "%s: memory ran out", path);
  }
  f->stream = open_beside(f);
  if (!f->stream) {
    ylm_fail(e, YLM_EIO, "%s: cannot be created: %s", path, strerror(errno));
    destroy(f);
    return YLM_EIO;
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

const char *ylm_file_temporary(const ylm_file *f) { return f->temporary; }

ylm_status ylm_file_commit(ylm_file *f, ylm_error *e) {
  ylm_status s = YLM_OK;
  errno = 0;
  bool bad = f->failed || ferror(f->stream) || fflush(f->stream) != 0;
  if (!bad && fsync(fileno(f->stream)) != 0 && errno != EINVAL && errno != EROFS) bad = true;
  int code = f->failed ? f->code : errno;
  if (fclose(f->stream) != 0) bad = true;
  if (!bad && rename(f->temporary, f->target) != 0) {
    bad = true;
    code = errno;
  }
  if (bad) {
    s = ylm_fail(e, YLM_EIO, "%s: cannot be written: %s", f->target,
                 code ? strerror(code) : "the device may be full");
    unlink(f->temporary);
  }
  destroy(f);
  return s;
}

void ylm_file_discard(ylm_file *f) {
  if (!f) return;
  fclose(f->stream);
  unlink(f->temporary);
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
