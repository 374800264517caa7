/* file.c - whole files in; file_write.c writes them. */
#include "ylm_base.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Opens a regular file and tells its size; -1 after an error. */
static int open_regular(const char *path, struct stat *st, ylm_error *e) {
  /* O_NONBLOCK: opening a named pipe must not wait for its writer. */
  int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    ylm_fail(e, YLM_EIO, "%s: %s", path, strerror(errno));
  } else if (fstat(fd, st) != 0 || !S_ISREG(st->st_mode)) {
    ylm_fail(e, YLM_EIO, "%s: not a regular file%s", path,
             S_ISDIR(st->st_mode) ? " but a folder" : "");
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
