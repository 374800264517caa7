/* index.c - the index of a folder: its presence says that the bake is finished. */
#include "../promise/tolerance.h"
#include "brick.h"
#include "set.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define INDEX_MAGIC "YLMindex"
#define INDEX_VERSION 1u

/* Adds the counts of a brick to those of all. */
static void add_stats(index_head *h, const ylm_grid_stats *s) {
  grid_file_stats *t = &h->stats;
  h->interpolated += s->interpolated;
  h->cells += s->cells;
  t->pairs += s->pairs;
  t->outside += s->outside;
  t->leaves += s->leaves;
  t->occupied += s->occupied;
  t->continuity += s->continuity;
  t->invalid += s->invalid;
  t->tested += s->tested;
  if (s->rounds > t->rounds) t->rounds = s->rounds;
  if (s->levels > t->levels) t->levels = s->levels;
  t->limited |= s->limited;
}

/* The entry of a finished brick; adds its counts. */
static ylm_status look(const plan *p, const brick *k, index_head *h, index_entry *entry,
                       ylm_error *e) {
  char path[FOLDER_PATH];
  border_head border;
  ylm_grid_file_info info;
  ylm__folder_brick(p->how.folder, k->code, "b", path);
  ylm_status s = ylm__border_head(path, &border, e);
  ylm__folder_brick(p->how.folder, k->code, "ylm", path);
  if (s == YLM_OK) s = ylm_grid_file_look(path, &info, e);
  if (s != YLM_OK) return s;
  *entry =
      (index_entry){.level = (uint32_t)k->level, .size = info.size, .evaluated = border.evaluated};
  memcpy(entry->origin, k->origin, sizeof entry->origin);
  h->points += border.evaluated;
  add_stats(h, &info.stats);
  ylm_grid_file_forget(&info);
  return YLM_OK;
}

/* The counts of the top, whose cells that are bricks are counted there. */
static ylm_status look_at_top(const plan *p, index_head *h, ylm_error *e) {
  char path[FOLDER_PATH];
  ylm_grid_file_info info;
  ylm__folder_file(p->how.folder, "top.ylm", path);
  ylm_status s = ylm_grid_file_look(path, &info, e);
  if (s != YLM_OK) return s;
  h->points += p->top.g->evaluated;
  info.stats.cells -= p->bricks;
  info.stats.leaves -= p->bricks;
  info.stats.occupied -= p->bricks;
  add_stats(h, &info.stats);
  ylm_grid_file_forget(&info);
  return YLM_OK;
}

static uint64_t sum_of(const index_head *h, const index_entry *entries) {
  return ylm_crc64(ylm_crc64(0, h, offsetof(index_head, crc)), entries,
                   h->bricks * sizeof *entries);
}

/* -- the judgement ---------------------------------------------------------------------------------- */

static ylm_status sample_set(void *set, const ylm_grid_query *q, size_t n, const float *points,
                             float *value, ylm_error *e) {
  return ylm_grid_set_sample(set, q, n, points, value, NULL, NULL, e);
}

/* Fresh points among all that are occupied say whether the whole keeps its tolerance. */
static ylm_status judge_set(const plan *p, ylm_grid_set *set, bool limited, ylm_error *e) {
  ylm_grid_source source = *p->source;
  source.team = NULL;
  source.progress = NULL;
  baker b;
  ylm__baker_begin(&b, p->top.g, &source, e);
  refiner r = {.b = &b, .tolerance = p->form.tolerance, .sample = sample_set, .sampled = set};
  ylm_status s = ylm__tolerance_begin(&r);
  if (s == YLM_OK && source.occupied_points && source.occupied < HELD_OUT) s = ylm__verify(&r, 1);
  if (s == YLM_OK) s = ylm__panel_judge(&r, limited);
  ylm__tolerance_end(&r);
  ylm__baker_free(&b);
  return s;
}

static ylm_status judge(const plan *p, index_head *h, const index_entry *entries, ylm_error *e) {
  ylm_grid_set *set;
  grid_file_stats *t = &h->stats;
  ylm_status s = ylm__set_make(p->how.folder, 0, h, entries, &set, e);
  if (s != YLM_OK) return s;
  s = judge_set(p, set, t->limited, e);
  ylm_grid_set_free(set);
  if (s == YLM_ENOMEM) ylm__grid_no_room(s, p->source, e);
  const ylm_grid_stats *said = &p->top.g->stats;
  t->verified = said->verified;
  t->error = said->error;
  t->largest_error = said->largest_error;
  t->met = said->met;
  t->limited = said->limited;
  return s;
}

ylm_status ylm__index_write(const char *folder, index_head *h, const index_entry *entries,
                            ylm_error *e) {
  char path[FOLDER_PATH];
  ylm_file *f = NULL;
  h->crc = sum_of(h, entries);
  ylm__folder_file(folder, "index", path);
  ylm_status s = ylm_file_create(path, &f, e);
  if (s != YLM_OK) return s;
  ylm_file_write(f, h, sizeof *h);
  ylm_file_write(f, entries, h->bricks * sizeof *entries);
  s = ylm_file_commit(f, e);
  if (s == YLM_OK) ylm__folder_sync(path);
  return s;
}

ylm_status ylm__brick_finish(const plan *p, ylm_error *e) {
  index_head h = {.magic = INDEX_MAGIC,
                  .version = INDEX_VERSION,
                  .level = (uint32_t)p->how.level,
                  .bricks = p->bricks,
                  .stats = {.error = NAN, .largest_error = NAN}};
  index_entry *entries = ylm_alloc_zero(p->bricks, sizeof *entries);
  ylm_status s = entries ? look_at_top(p, &h, e) : ylm_no_memory_for(e, p->how.folder);
  for (size_t i = 0; i < p->bricks && s == YLM_OK; i++)
    s = look(p, &p->brick[i], &h, &entries[i], e);
  if (s == YLM_OK && p->form.tolerance > 0) s = judge(p, &h, entries, e);
  if (s == YLM_OK) s = ylm__index_write(p->how.folder, &h, entries, e);
  ylm_free(entries);
  return s;
}

ylm_status ylm__index_read(const char *folder, index_head *h, index_entry **entries, ylm_error *e) {
  char path[FOLDER_PATH];
  struct stat st;
  unsigned char *data;
  size_t size;
  *entries = NULL;
  if (stat(folder, &st) != 0) return ylm_fail(e, YLM_EIO, "%s: %s", folder, strerror(errno));
  ylm__folder_file(folder, "index", path);
  if (!ylm__folder_has(path)) {
    ylm__folder_file(folder, "form", path);
    return ylm__folder_has(path)
               ? ylm_fail(e, YLM_EIO, "%s: its bake has not finished: bake again, to go on", folder)
               : ylm_fail(e, YLM_EFORMAT, "%s: not a folder of a grid in bricks", folder);
  }
  ylm_status s = ylm_file_read(path, SIZE_MAX, &data, &size, e);
  if (s != YLM_OK) return s;
  bool holds = size >= sizeof *h;
  if (holds) memcpy(h, data, sizeof *h);
  holds = holds && memcmp(h->magic, INDEX_MAGIC, 8) == 0 && h->version == INDEX_VERSION &&
          h->bricks <= size / sizeof **entries && size == sizeof *h + h->bricks * sizeof **entries;
  *entries = holds ? ylm_alloc_copy(data + sizeof *h, h->bricks, sizeof **entries) : NULL;
  ylm_free(data);
  if (holds && !*entries) return ylm_no_memory_for(e, path);
  if (holds && h->crc == sum_of(h, *entries)) return YLM_OK;
  ylm_free(*entries);
  *entries = NULL;
  return ylm_fail(e, YLM_ECHECKSUM,
                  "%s: the file is damaged: bake anew, with fresh = true (ylm bake --fresh)", path);
}
