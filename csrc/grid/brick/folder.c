/* folder.c - the folder of a grid in bricks: paths, the lock, and the form that all who bake into it share. */
#include "brick.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define ROOMS 64 /* folders that the files of bricks are in */

/* -- paths --------------------------------------------------------------------------------------- */

void ylm__folder_file(const char *folder, const char *name, char out[FOLDER_PATH]) {
  snprintf(out, FOLDER_PATH, "%s/%s", folder, name);
}

void ylm__folder_brick(const char *folder, const char *code, const char *ending,
                       char out[FOLDER_PATH]) {
  size_t n = strlen(code);
  char high = n > 1 ? code[n - 2] : '0', low = n ? code[n - 1] : '0';
  snprintf(out, FOLDER_PATH, "%s/%c%c/%s.%s", folder, high, low, code, ending);
}

bool ylm__folder_has(const char *path) {
  struct stat st;
  return stat(path, &st) == 0 && S_ISREG(st.st_mode);
}

void ylm__folder_rest(void) { nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL); }

bool ylm__folder_awaits(const plan *p, const char *path) {
  double begin = ylm_seconds();
  while (!ylm__folder_has(path)) {
    if (!plan_is_shared(p) || ylm_seconds() - begin > LATE_SECONDS) return false;
    ylm__folder_rest();
  }
  return true;
}

void ylm__folder_sync(const char *path) {
  char folder[FOLDER_PATH];
  snprintf(folder, sizeof folder, "%s", path);
  char *slash = strrchr(folder, '/');
  if (!slash) return;
  *slash = 0;
  int fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  (void)fsync(fd);
  close(fd);
}

static ylm_status make_folder(const char *path, ylm_error *e) {
  struct stat st;
  if (mkdir(path, 0777) == 0) return YLM_OK;
  int code = errno;
  if (code == EEXIST && stat(path, &st) == 0 && S_ISDIR(st.st_mode)) return YLM_OK;
  return ylm_fail(e, YLM_EIO, "%s: the folder cannot be made: %s", path, strerror(code));
}

/* -- what is in it -------------------------------------------------------------------------------- */

/* Files of the whole. */
static const char *const own[] = {"form", "index", "top.ylm", "fill", "lock"};

/* "00" .. "77" */
static bool is_room(const char *name) {
  return name[0] >= '0' && name[0] <= '7' && name[1] >= '0' && name[1] <= '7' && !name[2];
}

static bool is_own(const char *name) {
  for (size_t i = 0; i < sizeof own / sizeof *own; i++)
    if (strcmp(name, own[i]) == 0) return true;
  return strcmp(name, ".") == 0 || strcmp(name, "..") == 0 || is_room(name) ||
         strstr(name, ".ylm-") != NULL;
}

/* The first line of a form; a number of the version follows. */
#define FORM_BEGIN "ylm bricks "

/* Does the file `form`, which is there, belong to a bake? */
static bool is_form(const char *path) {
  unsigned char head[sizeof FORM_BEGIN - 1];
  size_t n;
  return ylm_file_head(path, head, sizeof head, &n, NULL) == YLM_OK && n == sizeof head &&
         memcmp(head, FORM_BEGIN, n) == 0;
}

/* Refuses a folder that holds something else, and has no form of a bake at `form`. */
static ylm_status check_foreign(const char *folder, const char *form, ylm_error *e) {
  const char *found = NULL;
  char name[256];
  if (ylm__folder_has(form))
    return is_form(form) ? YLM_OK
                         : ylm_fail(e, YLM_EINVAL,
                                    "%s: not a folder of a grid in bricks (its file form is no "
                                    "bake's)",
                                    folder);
  DIR *d = opendir(folder);
  if (!d) return ylm_fail(e, YLM_EIO, "%s: %s", folder, strerror(errno));
  for (struct dirent *entry; !found && (entry = readdir(d));)
    if (!is_own(entry->d_name) && entry->d_name[0] != '.') {
      snprintf(name, sizeof name, "%s", entry->d_name);
      found = name;
    }
  closedir(d);
  return found ? ylm_fail(e, YLM_EINVAL, "%s: not a folder of a grid in bricks (it has %s)", folder,
                          found)
               : YLM_OK;
}

/* Is a file of a folder a brick's with one of these endings, or one that a killed process left unfinished? */
static bool is_spent(const char *name, const char *const *endings, size_t n) {
  const char *dot = strchr(name, '.');
  bool spent = strncmp(name, ".ylm-unfinished-", 16) == 0;
  if (!dot || strspn(name, "01234567") != (size_t)(dot - name)) return spent;
  for (size_t i = 0; i < n; i++) spent |= strcmp(dot + 1, endings[i]) == 0;
  return spent;
}

static void clean_folder(const char *path, const char *const *endings, size_t n) {
  char file[FOLDER_PATH + 300];
  DIR *d = opendir(path);
  if (!d) return;
  for (struct dirent *entry; (entry = readdir(d));) {
    snprintf(file, sizeof file, "%s/%s", path, entry->d_name);
    if (is_spent(entry->d_name, endings, n)) unlink(file);
  }
  closedir(d);
}

static void room_of(const char *folder, int room, char path[FOLDER_PATH]) {
  snprintf(path, FOLDER_PATH, "%.*s/%d%d", FOLDER_PATH - 64, folder, room / 8, room % 8);
}

/* Removes the files of bricks with one of these endings; nobody else is at work. */
static void remove_bricks(const char *folder, const char *const *endings, size_t n) {
  clean_folder(folder, endings, n);
  for (int room = 0; room < ROOMS; room++) {
    char path[FOLDER_PATH];
    room_of(folder, room, path);
    clean_folder(path, endings, n);
  }
}

static void remove_own(const char *folder, const char *name) {
  char path[FOLDER_PATH];
  ylm__folder_file(folder, name, path);
  unlink(path);
}

void ylm__folder_clean(const plan *p) {
  static const char *const endings[] = {"a", "b", "c", "s"};
  remove_bricks(p->how.folder, endings, 4);
  remove_own(p->how.folder, "fill");
}

/* Everything that a bake has left; the index first. */
static void remove_all(const char *folder) {
  static const char *const endings[] = {"a", "b", "c", "s", "ylm"};
  remove_own(folder, "index");
  remove_own(folder, "form");
  remove_bricks(folder, endings, 5);
  remove_own(folder, "fill");
  remove_own(folder, "top.ylm");
}

/* -- the lock ------------------------------------------------------------------------------------- */

/* Says who holds the lock. */
static ylm_status busy(const plan *p, const char *path, ylm_error *e) {
  unsigned char text[200];
  size_t n = 0;
  if (ylm_file_head(path, text, sizeof text - 1, &n, NULL) != YLM_OK) n = 0;
  text[n] = 0;
  return ylm_fail(e, YLM_EBUSY, "%s: another bake is at work here%s%s", p->how.folder,
                  n ? ", " : "", (const char *)text);
}

/* A lock that ends with the process, on a file that tells who and since when. */
static ylm_status lock(plan *p, ylm_error *e) {
  char path[FOLDER_PATH], host[128] = "", text[200], since[32] = "";
  struct stat here, there;
  ylm__folder_file(p->how.folder, "lock", path);
  for (int tries = 0; tries < 100; tries++) {
    int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd < 0)
      return ylm_fail(e, YLM_EIO, "%s: cannot be written: %s", p->how.folder, strerror(errno));
    if (flock(fd, LOCK_EX | LOCK_NB) != 0 && (errno == EWOULDBLOCK || errno == EINTR)) {
      close(fd);
      return busy(p, path, e);
    }
    if (fstat(fd, &here) == 0 && stat(path, &there) == 0 && here.st_ino == there.st_ino) {
      p->lock = fd;
      break;
    }
    close(fd); /* its holder has just removed it */
  }
  if (p->lock < 0) return busy(p, path, e);
  time_t now = time(NULL);
  struct tm when;
  if (gmtime_r(&now, &when)) strftime(since, sizeof since, "%Y-%m-%d %H:%M:%S UTC", &when);
  gethostname(host, sizeof host - 1);
  int n = snprintf(text, sizeof text, "process %ld of %s since %s", (long)getpid(), host, since);
  if (ftruncate(p->lock, 0) != 0 || write(p->lock, text, (size_t)n) != n)
    return ylm_fail(e, YLM_EIO, "%s: cannot be written: %s", path, strerror(errno));
  return YLM_OK;
}

void ylm__folder_close(plan *p) {
  char path[FOLDER_PATH];
  if (p->lock < 0) return;
  ylm__folder_file(p->how.folder, "lock", path);
  unlink(path);
  close(p->lock);
  p->lock = -1;
}

/* -- the form ------------------------------------------------------------------------------------- */

#define FORM_TEXT 2048

static void put_line(char *text, const char *name, const void *bytes, size_t n) {
  size_t at = strlen(text);
  const unsigned char *b = bytes;
  at += (size_t)snprintf(text + at, FORM_TEXT - at, "%s ", name);
  for (size_t i = 0; i < n; i++)
    at += (size_t)snprintf(text + at, FORM_TEXT - at, "%02x", b[n - 1 - i]);
  snprintf(text + at, FORM_TEXT - at, "\n");
}

/* All that bricks depend on, a line each: the name first. */
static void describe(const plan *p, char text[FORM_TEXT]) {
  const ylm_grid_form *f = &p->form;
  uint32_t numbers[] = {(uint32_t)f->lmax,    (uint32_t)f->channels, (uint32_t)f->metric_channels,
                        (uint32_t)f->depth,   (uint32_t)f->metric,   f->continuous,
                        (uint32_t)f->quantity};
  static const char *const names[] = {"lmax",   "channels",   "metric_channels", "depth",
                                      "metric", "continuous", "quantity"};
  uint64_t points = p->how.points, occupied = ylm__top_occupied(p), light = ylm__top_light(p);
  uint32_t level = (uint32_t)p->how.level;
  snprintf(text, FORM_TEXT, FORM_BEGIN "1\nkernels %s\n", ylm_isa_name(ylm_isa_current()));
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
    put_line(text, names[i], &numbers[i], sizeof *numbers);
  put_line(text, "bounds", f->bounds, sizeof f->bounds);
  put_line(text, "threshold", &f->threshold, sizeof f->threshold);
  put_line(text, "tolerance", &f->tolerance, sizeof f->tolerance);
  put_line(text, "floor", &f->floor, sizeof f->floor);
  put_line(text, "bricks", &level, sizeof level);
  put_line(text, "brick_points", &points, sizeof points);
  put_line(text, "occupied", &occupied, sizeof occupied);
  put_line(text, "lights", &light, sizeof light);
}

/* The first line in which two forms differ; false: none. */
static bool find_difference(const char *a, const char *b, char name[64], char was[64]) {
  while (*a && *b) {
    size_t n = strcspn(a, "\n"), m = strcspn(b, "\n"), word = strcspn(a, " \n");
    if (n != m || memcmp(a, b, n) != 0) {
      snprintf(name, 64, "%.*s", (int)word, a);
      snprintf(was, 64, "%.*s", n > word ? (int)(n - word - 1) : 0, a + word + (n > word));
      return true;
    }
    a += n + (a[n] != 0);
    b += m + (b[m] != 0);
  }
  snprintf(name, 64, "version");
  was[0] = 0;
  return *a != *b;
}

static ylm_status compare_form(const plan *p, const char *path, const char *text, ylm_error *e) {
  unsigned char *data;
  size_t size;
  char name[64], was[64];
  ylm_status s = ylm_file_read(path, 65536, &data, &size, e);
  if (s != YLM_OK) return s;
  bool differs = find_difference((const char *)data, text, name, was);
  ylm_free(data);
  if (!differs) return YLM_OK;
  if (strcmp(name, "kernels") == 0)
    return ylm_fail(e, YLM_EINVAL,
                    "%s: it was begun with the kernels %s, sums by %s differ in the last bit: set "
                    "YLM_ISA=%s, or begin anew",
                    p->how.folder, was, ylm_isa_name(ylm_isa_current()), was);
  return ylm_fail(
      e, YLM_EINVAL,
      "%s: it holds another bake, which differs in '%s': choose another folder, or begin "
      "anew (fresh)",
      p->how.folder, name);
}

static ylm_status make_rooms(const char *folder, ylm_error *e) {
  char room[FOLDER_PATH];
  ylm_status s = YLM_OK;
  for (int i = 0; i < ROOMS && s == YLM_OK; i++) {
    room_of(folder, i, room);
    s = make_folder(room, e);
  }
  return s;
}

/* By the process that looks after the folder. */
static ylm_status prepare(plan *p, const char *path, const char *text, ylm_error *e) {
  const char *folder = p->how.folder;
  ylm_status s = make_folder(folder, e);
  if (s == YLM_OK) s = check_foreign(folder, path, e);
  if (s == YLM_OK) s = lock(p, e);
  if (s == YLM_OK && p->how.fresh) remove_all(folder);
  if (s == YLM_OK && !ylm__folder_has(path)) s = ylm_file_save(path, text, strlen(text), e);
  if (s == YLM_OK) s = make_rooms(folder, e);
  if (s == YLM_OK) ylm__folder_sync(path);
  return s;
}

ylm_status ylm__folder_open(plan *p, ylm_error *e) {
  char path[FOLDER_PATH], text[FORM_TEXT];
  ylm_status s = ylm__grid_file_machine(p->how.folder, e);
  describe(p, text);
  ylm__folder_file(p->how.folder, "form", path);
  if (s == YLM_OK && p->owner) s = prepare(p, path, text, e);
  return s == YLM_OK ? compare_form(p, path, text, e) : s;
}

/* -- sets in few bytes --------------------------------------------------------------------------- */

#define PACKED_FORM FORM_BEGIN "1\npacked\n" /* differs from the form of any bake */

ylm_status ylm__folder_pack(const char *folder, ylm_error *e) {
  char form[FOLDER_PATH];
  unsigned char *text = NULL;
  size_t size = 0;
  if (strlen(folder) > FOLDER_PATH - 64)
    return ylm_fail(e, YLM_EINVAL, "the folder's name is too long");
  ylm__folder_file(folder, "form", form);
  ylm_status s = make_folder(folder, e);
  if (s == YLM_OK) s = check_foreign(folder, form, e);
  if (s == YLM_OK && ylm__folder_has(form)) {
    s = ylm_file_read(form, 65536, &text, &size, e);
    if (s == YLM_OK && strcmp((const char *)text, PACKED_FORM) != 0)
      s = ylm_fail(e, YLM_EINVAL, "%s: it holds a bake: choose another folder", folder);
    ylm_free(text);
  }
  if (s != YLM_OK) return s;
  remove_all(folder);
  s = ylm_file_save(form, PACKED_FORM, strlen(PACKED_FORM), e);
  if (s == YLM_OK) s = make_rooms(folder, e);
  if (s == YLM_OK) ylm__folder_sync(form);
  return s;
}

void ylm__folder_remove(const char *folder) {
  char room[FOLDER_PATH];
  remove_all(folder);
  for (int i = 0; i < ROOMS; i++) {
    room_of(folder, i, room);
    rmdir(room);
  }
  rmdir(folder);
}
