/*
** journal.c - light and texels that a bake has found, appended to a file, so that one that was interrupted goes on.
**
** A bake asks for the same parts in the same order again. A part is its size, its bytes, and the sum of all bytes of the file
** before it and of its own. An end that a killed process left unfinished, or that is damaged, has another sum: it is cut off and
** found anew.
*/
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "map.h"

#define MAGIC "ylm lightmap 1\n"
/* Bytes of a description, at most. */
#define WORDS 4096

static bool get(int file, void *data, size_t size) {
  size_t got;
  return ylm_descriptor_read(file, data, size, &got) && got == size;
}

static ylm_status fail(const map_bake *b, const char *what) {
  return ylm_fail(b->e, YLM_EIO, "%s: %s: %s", b->form->journal, what, strerror(errno));
}

/* Compares descriptions line by line, and names the first that differs. */
static ylm_status compare(const map_bake *b, const char *had, const char *wanted) {
  while (*had && *wanted) {
    size_t m = strcspn(had, "\n"), n = strcspn(wanted, "\n");
    if (m != n || memcmp(had, wanted, n) != 0)
      return ylm_fail(b->e, YLM_EINVAL, "%s: of another bake, of %.*s; this is of %.*s",
                      b->form->journal, (int)(m < 120 ? m : 120), had, (int)(n < 120 ? n : 120),
                      wanted);
    had += m + (had[m] != 0);
    wanted += n + (wanted[n] != 0);
  }
  return YLM_OK;
}

/* The description of a bake: words, and the sum of the light of its elements. */
static void describe(const map_bake *b, char out[WORDS]) {
  ylm_transfer_stats t;
  ylm_transfer_look(ylm_radiosity_transfer(b->r), &t);
  uint64_t sum = ylm_crc64(0, ylm_radiosity_irradiance(b->r), 16 * t.elements);
  sum = ylm_crc64(sum, ylm_radiosity_leaving(b->r), 16 * t.elements);
  memset(out, 0, WORDS);
  snprintf(out, WORDS, "%.*selements %016llx\n", WORDS - 64, b->form->words ? b->form->words : "",
           (unsigned long long)sum);
}

/* Begins a file, or reads its description; what is no journal stays as it is. */
static ylm_status begin(map_bake *b) {
  char wanted[WORDS], had[WORDS], magic[sizeof MAGIC - 1];
  struct stat st;
  map_journal *j = &b->journal;
  describe(b, wanted);
  j->sum = ylm_crc64(0, wanted, WORDS);
  if (fstat(j->file, &st) != 0) return fail(b, "cannot be read");
  if (st.st_size == 0) {
    if (!ylm_descriptor_write(j->file, MAGIC, sizeof magic) ||
        !ylm_descriptor_write(j->file, wanted, WORDS))
      return fail(b, "cannot be written");
    return YLM_OK;
  }
  if (!get(j->file, magic, sizeof magic) || memcmp(magic, MAGIC, sizeof magic) != 0 ||
      !get(j->file, had, WORDS) || had[WORDS - 1])
    return ylm_fail(b->e, YLM_EFORMAT, "%s: not a file that a lightmap goes on from",
                    b->form->journal);
  j->reads = true;
  return compare(b, had, wanted);
}

ylm_status ylm__map_journal_open(map_bake *b) {
  map_journal *j = &b->journal;
  if (!b->form->journal) return YLM_OK;
  j->file = open(b->form->journal, O_RDWR | O_CREAT | O_CLOEXEC | O_NOCTTY, 0666);
  j->open = j->file >= 0;
  if (!j->open) return fail(b, "cannot be opened");
  struct stat st;
  if (fstat(j->file, &st) != 0 || !S_ISREG(st.st_mode))
    return ylm_fail(b->e, YLM_EIO, "%s: not a regular file", b->form->journal);
  if (flock(j->file, LOCK_EX | LOCK_NB) != 0)
    return ylm_fail(b->e, YLM_EBUSY, "%s: another bake writes it", b->form->journal);
  return begin(b);
}

void ylm__map_journal_close(map_bake *b) {
  if (b->journal.open) close(b->journal.file);
  b->journal.open = false;
}

/* The bytes of a part as the file has them; false: it has none. */
static bool read_part(map_journal *j, void *data, size_t wanted) {
  uint64_t size, sum;
  if (!get(j->file, &size, sizeof size) || size != wanted || !get(j->file, data, wanted) ||
      !get(j->file, &sum, sizeof sum))
    return false;
  if (sum != ylm_crc64(j->sum, data, wanted)) return false;
  j->sum = sum;
  return true;
}

/* All parts, or none of them. */
static bool read_parts(map_journal *j, size_t n, const map_part *part, uint8_t *room) {
  uint8_t *at = room;
  for (size_t i = 0; i < n; at += part[i++].size)
    if (!read_part(j, at, part[i].size)) return false;
  for (size_t i = 0; i < n; room += part[i++].size) memcpy(part[i].data, room, part[i].size);
  return true;
}

ylm_status ylm__map_recall(map_bake *b, size_t n, const map_part *part, bool *had) {
  map_journal *j = &b->journal;
  *had = false;
  if (!j->open || !j->reads) return YLM_OK;
  off_t at = lseek(j->file, 0, SEEK_CUR);
  uint64_t sum = j->sum, size = 0;
  for (size_t i = 0; i < n; i++) size += part[i].size;
  uint8_t *room = ylm_alloc(size, 1);
  if (!room) return YLM_ENOMEM;
  j->reads = *had = read_parts(j, n, part, room);
  ylm_free(room);
  if (*had) return YLM_OK;
  j->sum = sum;
  if (at < 0 || ftruncate(j->file, at) != 0 || lseek(j->file, at, SEEK_SET) < 0)
    return fail(b, "cannot be written");
  return YLM_OK;
}

ylm_status ylm__map_remember(map_bake *b, size_t n, const map_part *part) {
  map_journal *j = &b->journal;
  if (!j->open) return YLM_OK;
  for (size_t i = 0; i < n; i++) {
    uint64_t size = part[i].size;
    j->sum = ylm_crc64(j->sum, part[i].data, part[i].size);
    if (!ylm_descriptor_write(j->file, &size, sizeof size) ||
        !ylm_descriptor_write(j->file, part[i].data, part[i].size) ||
        !ylm_descriptor_write(j->file, &j->sum, sizeof j->sum))
      return fail(b, "cannot be written");
  }
  return fsync(j->file) == 0 || errno == EINVAL ? YLM_OK : fail(b, "cannot be written");
}
