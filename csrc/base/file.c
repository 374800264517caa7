/* file.c - whole files in, and bytes of open ones; file_write.c writes whole files. */
#include "ylm_base.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

bool ylm_descriptor_read(int file, void *data, size_t size, size_t *got) {
  for (*got = 0; *got < size;) {
    ssize_t n = read(file, (char *)data + *got, size - *got);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    if (n == 0) break;
    *got += (size_t)n;
  }
  return true;
}

bool ylm_descriptor_write(int file, const void *data, size_t size) {
  for (size_t put = 0; put < size;) {
    ssize_t n = write(file, (const char *)data + put, size - put);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    put += (size_t)n;
  }
  return true;
}

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
  bool good = ylm_descriptor_read(fd, bytes, room, size);
  if (!good) ylm_fail(e, YLM_EIO, "%s: %s", path, strerror(errno));
  close(fd);
  return good ? YLM_OK : YLM_EIO;
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
  size_t n = (size_t)st.st_size, got;
  unsigned char *p = ylm_alloc(n + 1, 1);
  if (!p) {
    close(fd);
    return ylm_fail(e, YLM_ENOMEM, "%s: no memory for %zu bytes", path, n);
  }
  if (!ylm_descriptor_read(fd, p, n, &got)) {
    ylm_fail(e, YLM_EIO, "%s: %s", path, strerror(errno));
    ylm_free(p);
    close(fd);
    return YLM_EIO;
  }
  close(fd);
  p[got] = 0;
  *data = p;
  *size = got;
  return YLM_OK;
}
