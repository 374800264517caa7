/* file_place.c - links, folders and permissions of files that are about to be replaced. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* O_PATH */
#endif
#include "file_place.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <time.h>
#include <unistd.h>

#ifdef __linux__
#include <sys/xattr.h>
#endif

/* Folders that may be written but not read are reached too. */
#ifndef O_PATH
#define O_PATH O_RDONLY
#endif

#define PREFIX ".ylm-unfinished-"
#define DIGITS 12
_Static_assert(sizeof PREFIX + DIGITS <= YLM__UNFINISHED_NAME, "the name fits");

#define MOST_LINKS 40           /* on the way to a file, as in Linux */
#define SWEEP_SECONDS (60 * 60) /* from the last change of a file on it may be swept */
#define SWEEP_NAMES (10 * 1000) /* of a folder are looked at: some 8 ms */

/* -- where ------------------------------------------------------------------ */

/* The last part of a path. */
static const char *last_part(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? slash + 1 : path;
}

/* The path behind the links at `path`, whether or not there is something; NULL with errno. */
static char *behind_links(const char *path) {
  char *at = strdup(path), to[PATH_MAX];
  for (int k = 0; at; k++) {
    ssize_t n = readlink(at, to, sizeof to);
    if (n < 0) return at; /* no link; what else is wrong shows when the folder is opened */
    size_t before = to[0] == '/' ? 0 : (size_t)(last_part(at) - at);
    char *next = k < MOST_LINKS && n < PATH_MAX ? malloc(before + (size_t)n + 1) : NULL;
    if (next) {
      memcpy(next, at, before);
      memcpy(next + before, to, (size_t)n);
      next[before + (size_t)n] = 0;
    } else {
      errno = k < MOST_LINKS && n < PATH_MAX ? ENOMEM : ELOOP;
    }
    free(at);
    at = next;
  }
  return at;
}

/* Opens the folder of a path. */
static int open_folder(const char *path) {
  size_t n = (size_t)(last_part(path) - path);
  char *folder = malloc(n + 2);
  if (!folder) return -1;
  memcpy(folder, n ? path : ".", n ? n : 1);
  folder[n ? n : 1] = 0;
  int fd = open(folder, O_PATH | O_DIRECTORY | O_CLOEXEC);
  int code = errno;
  free(folder);
  errno = code;
  return fd;
}

/* Whether `path` may be written, and a folder with the sticky bit lets this user rename over it. */
static bool may_replace(const char *path, const ylm__place *p) {
  struct stat folder;
  int fd = open(path, O_WRONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return false;
  close(fd);
  if (fstat(p->folder, &folder) != 0) return false;
  uid_t user = geteuid();
  if (!(folder.st_mode & S_ISVTX) || user == 0 || user == p->old.st_uid || user == folder.st_uid)
    return true;
  errno = EPERM;
  return false;
}

/* Says why there is no place: errno, and where a link leads to. */
static ylm_status fail_to_find(const char *path, const ylm__place *p, ylm_error *e) {
  if (errno == ENOMEM) return ylm_no_memory_for(e, path);
  bool link = p->path && strcmp(path, p->path) != 0;
  return ylm_fail(e, YLM_EIO, "%s: cannot be %s: %s%s%s%s", path, p->exists ? "written" : "created",
                  strerror(errno), link ? " (it is a link to " : "", link ? p->path : "",
                  link ? ")" : "");
}

ylm_status ylm__place_find(const char *path, ylm__place *p, ylm_error *e) {
  *p = (ylm__place){.folder = -1};
  p->path = behind_links(path);
  p->name = p->path ? last_part(p->path) : NULL;
  p->exists = p->path && stat(path, &p->old) == 0;
  if (p->exists && !S_ISREG(p->old.st_mode)) {
    ylm__place_leave(p);
    return ylm_fail(e, YLM_EIO, "%s: exists and is not a regular file", path);
  }
  bool good = p->path && (p->exists || errno == ENOENT);
  if (good && (*p->name == 0 || strlen(p->name) > NAME_MAX)) {
    errno = *p->name ? ENAMETOOLONG : ENOENT;
    good = false;
  }
  if (good) p->folder = open_folder(p->path);
  good = good && p->folder >= 0 && (!p->exists || may_replace(path, p));
  if (good) return YLM_OK;
  ylm_status s = fail_to_find(path, p, e);
  ylm__place_leave(p);
  return s;
}

void ylm__place_leave(ylm__place *p) {
  if (p->folder >= 0) close(p->folder);
  free(p->path);
  p->folder = -1;
  p->path = NULL;
}

/* -- new files -------------------------------------------------------------- */

/* Gives a new file the access list of the old one, or none where that has none. */
static bool copy_access_list(int fd, const char *from) {
#ifdef __linux__
  static const char name[] = "system.posix_acl_access";
  char list[4096];
  ssize_t n = getxattr(from, name, list, sizeof list);
  if (n >= 0) return fsetxattr(fd, name, list, (size_t)n, 0) == 0;
  if (errno == ENODATA && fremovexattr(fd, name) == 0) return true;
  return errno == ENODATA || errno == ENOTSUP;
#else
  (void)fd, (void)from;
  return true;
#endif
}

/* Gives a new file, which only its owner may open, what the old one has. A group that cannot be
   given, or an access list, leaves the group no more than everybody has. */
static void dress(int fd, const ylm__place *p) {
  struct stat now;
  mode_t mode = p->old.st_mode & 07777;
  if (fstat(fd, &now) != 0) return;
  if (now.st_uid != p->old.st_uid && fchown(fd, p->old.st_uid, (gid_t)-1) != 0) mode &= 01777;
  if (now.st_gid != p->old.st_gid && fchown(fd, (uid_t)-1, p->old.st_gid) != 0)
    mode &= 01707 | (mode & 7) << 3;
  if (!copy_access_list(fd, p->path)) mode &= 07707 | (mode & 7) << 3;
  (void)fchmod(fd, mode);
}

/* A name that nothing else has: of this process, this call and this moment. */
static void make_name(char name[YLM__UNFINISHED_NAME]) {
  static atomic_uint serial;
  ylm_rng r;
  struct timespec t;
  clock_gettime(CLOCK_REALTIME, &t);
  ylm_rng_seed(&r, (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec,
               (uint64_t)getpid() << 32 | atomic_fetch_add(&serial, 1u));
  unsigned high = ylm_rng_u32(&r) & 0xffffff, low = ylm_rng_u32(&r) & 0xffffff;
  snprintf(name, YLM__UNFINISHED_NAME, PREFIX "%06x%06x", high, low);
}

int ylm__place_open(const ylm__place *p, char name[YLM__UNFINISHED_NAME]) {
  for (int attempt = 0; attempt < 100; attempt++) {
    make_name(name);
    int fd =
        openat(p->folder, name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, p->exists ? 0600 : 0666);
    if (fd < 0 && errno == EEXIST) continue;
    if (fd < 0) return -1;
    (void)flock(fd, LOCK_EX | LOCK_NB); /* where there are no locks, nothing is swept either */
    if (p->exists) dress(fd, p);
    return fd;
  }
  return -1;
}

/* -- what killed processes left --------------------------------------------- */

static bool is_unfinished_name(const char *name) {
  const size_t n = sizeof PREFIX - 1;
  return strncmp(name, PREFIX, n) == 0 && strspn(name + n, "0123456789abcdef") == DIGITS &&
         name[n + DIGITS] == 0;
}

/* A regular file with one name, this user's, unchanged for an hour? */
static bool is_left(const struct stat *s) {
  return S_ISREG(s->st_mode) && s->st_nlink == 1 && s->st_uid == geteuid() &&
         s->st_mtime <= time(NULL) - SWEEP_SECONDS;
}

/* Removes one file unless a process that lives has its lock. */
static void sweep_one(int folder, const char *name) {
  struct stat seen, opened;
  if (fstatat(folder, name, &seen, AT_SYMLINK_NOFOLLOW) != 0 || !is_left(&seen)) return;
  int fd = openat(folder, name, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return;
  if (fstat(fd, &opened) == 0 && opened.st_dev == seen.st_dev && opened.st_ino == seen.st_ino &&
      is_left(&opened) && flock(fd, LOCK_EX | LOCK_NB) == 0)
    unlinkat(folder, name, 0);
  close(fd);
}

void ylm__place_sweep(const ylm__place *p) {
  int fd = openat(p->folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR *folder = fd < 0 ? NULL : fdopendir(fd);
  if (!folder) {
    if (fd >= 0) close(fd);
    return;
  }
  const struct dirent *entry;
  for (int k = 0; k < SWEEP_NAMES && (entry = readdir(folder)) != NULL; k++)
    if (is_unfinished_name(entry->d_name)) sweep_one(p->folder, entry->d_name);
  closedir(folder);
}
