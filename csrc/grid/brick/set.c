/* set.c - grids in bricks, opened: the index and the top in memory, bricks in a cache. */
#include "set.h"
#include "brick.h"

#include <stdlib.h>
#include <string.h>

/* -- the cache ------------------------------------------------------------------------------------------ */

static void free_room(ylm_grid_set *s) {
  ylm_regrow_free(s->room.data, s->room.bytes);
  s->room = (grid_file_room){0};
}

/* Forgets a brick; its rows' memory is kept where it is more than what is kept already. */
static void forget(ylm_grid_set *s, set_brick *k) {
  ylm_grid *g = k->grid;
  if (!g) return;
  s->held -= g->stats.bytes;
  if (g->data_bytes > s->room.bytes) {
    free_room(s);
    s->room = (grid_file_room){g->data, g->data_bytes};
    g->data = NULL;
    g->data_bytes = 0;
  }
  ylm_grid_free(g);
  k->grid = NULL;
}

/* Forgets the bricks that were used longest ago until no more than `bytes` are held, `keep` excepted. */
static void shrink(ylm_grid_set *s, size_t bytes, const set_brick *keep) {
  while (s->held > bytes) {
    set_brick *oldest = NULL;
    for (size_t i = 0; i < s->bricks; i++) {
      set_brick *k = &s->brick[i];
      if (k->grid && k != keep && (!oldest || k->used < oldest->used)) oldest = k;
    }
    if (!oldest) return;
    forget(s, oldest);
  }
}

/* Is the grid of a file the brick that the index says? */
static bool is_brick(const ylm_grid_set *s, const set_brick *k, const ylm_grid *g) {
  const ylm_grid_form *a = &s->top->contents.form, *b = &g->contents.form;
  return g->contents.root_level == (int)k->level && g->width == s->top->width &&
         !g->validity == !s->top->validity &&
         memcmp(g->contents.root, k->origin, sizeof k->origin) == 0 && a->depth == b->depth &&
         memcmp(a->bounds, b->bounds, sizeof a->bounds) == 0 && a->channels == b->channels;
}

/* Reads a brick, in place of those that were used longest ago. */
static ylm_status read_brick(ylm_grid_set *s, set_brick *k, int threads, ylm_error *e) {
  char path[FOLDER_PATH];
  size_t room = (size_t)(2 * k->size); /* interpolated points, which the file has not */
  shrink(s, s->cache > room ? s->cache - room : 0, k);
  ylm__folder_brick(s->folder, k->code, "ylm", path);
  ylm_status status = ylm__grid_file_read(path, &s->room, threads, &k->grid, e);
  if (status != YLM_OK) return status;
  s->reads++;
  s->held += k->grid->stats.bytes;
  if (!is_brick(s, k, k->grid)) {
    forget(s, k);
    return ylm_fail(e, YLM_EFORMAT, "%s: not the brick that the index names", path);
  }
  shrink(s, s->cache, k);
  return YLM_OK;
}

ylm_status ylm__set_get(ylm_grid_set *s, size_t number, int threads, const ylm_grid **g,
                        ylm_error *e) {
  *g = s->top;
  if (number == s->bricks) return YLM_OK;
  set_brick *k = &s->brick[number];
  k->used = ++s->clock;
  ylm_status status = k->grid ? YLM_OK : read_brick(s, k, threads, e);
  free_room(s);
  *g = k->grid;
  return status;
}

ylm_status ylm__set_report(ylm_grid_set *s, const ylm_progress *p, uint64_t done, uint64_t total,
                           const char *stage) {
  if (!p) return YLM_OK;
  pthread_mutex_unlock(&s->lock);
  ylm_status status = ylm_report(p, done, total, stage);
  pthread_mutex_lock(&s->lock);
  return status;
}

/* -- opening --------------------------------------------------------------------------------------------- */

static void name_brick(const ylm_grid_set *s, set_brick *k) {
  int depth = s->top->contents.form.depth;
  memset(k->code, 0, sizeof k->code);
  for (uint32_t level = 1; level <= k->level; level++)
    k->code[level - 1] =
        (char)('0' + octant_of(k->origin[0], k->origin[1], k->origin[2], (uint32_t)depth - level));
}

/* The brick of a cell of the top, YLM_GRID_NONE if there is none. */
static uint32_t number_of(const ylm_grid_set *s, const ylm_grid_cell *c) {
  uint64_t code = ylm_morton(c->origin[0], c->origin[1], c->origin[2]);
  size_t lo = 0, hi = s->bricks;
  while (lo < hi) {
    size_t mid = lo + (hi - lo) / 2;
    const uint32_t *o = s->brick[mid].origin;
    if (ylm_morton(o[0], o[1], o[2]) < code)
      lo = mid + 1;
    else
      hi = mid;
  }
  bool found = lo < s->bricks && s->brick[lo].level == c->level &&
               memcmp(s->brick[lo].origin, c->origin, sizeof c->origin) == 0;
  return found ? (uint32_t)lo : YLM_GRID_NONE;
}

/* Which brick each cell of the top is. */
static ylm_status number_cells(ylm_grid_set *s, ylm_error *e) {
  size_t found = 0;
  s->number = ylm_alloc(s->top->cells, sizeof *s->number);
  if (!s->number) return ylm_no_memory_for(e, s->folder);
  for (size_t i = 0; i < s->top->cells; i++) {
    const ylm_grid_cell *c = &s->top->cell[i];
    s->number[i] = (uint32_t)s->bricks;
    if (!(c->flags & YLM_GRID_BRICK)) continue;
    s->number[i] = number_of(s, c);
    found++;
    if (s->number[i] == YLM_GRID_NONE || c->child)
      return ylm_fail(e, YLM_EFORMAT, "%s: its index and its top disagree", s->folder);
  }
  return found == s->bricks
             ? YLM_OK
             : ylm_fail(e, YLM_EFORMAT, "%s: its index and its top disagree", s->folder);
}

/* Stats of all bricks, by the index. */
static void take_stats(ylm_grid_set *s, const index_head *h) {
  ylm_grid_stats *to = &s->top->stats;
  to->points = h->points;
  to->interpolated = h->interpolated;
  to->cells = h->cells;
#define X(type, name) to->name = h->stats.name;
  GRID_FILE_STATS(X)
#undef X
}

static ylm_status make_all(ylm_grid_set *s, const index_head *h, const index_entry *entries,
                           ylm_error *e) {
  char path[FOLDER_PATH];
  ylm__folder_file(s->folder, "top.ylm", path);
  ylm_status status = ylm_grid_read(path, &s->top, e);
  if (status != YLM_OK) return status;
  s->bricks = h->bricks;
  s->level = h->level;
  s->brick = ylm_alloc_zero(h->bricks, sizeof *s->brick);
  if (status == YLM_OK && !s->brick) status = ylm_no_memory_for(e, s->folder);
  for (size_t i = 0; status == YLM_OK && i < s->bricks; i++) {
    set_brick *k = &s->brick[i];
    memcpy(k->origin, entries[i].origin, sizeof k->origin);
    k->level = entries[i].level;
    k->size = entries[i].size;
    s->bytes += k->size;
    if (k->level < 1 || k->level > (uint32_t)s->top->contents.form.depth)
      status = ylm_fail(e, YLM_EFORMAT, "%s: its index names no brick", s->folder);
    else
      name_brick(s, k);
  }
  if (status == YLM_OK) take_stats(s, h);
  return status == YLM_OK ? number_cells(s, e) : status;
}

ylm_status ylm_grid_set_open(const char *folder, size_t cache, ylm_grid_set **out, ylm_error *e) {
  index_head h;
  index_entry *entries;
  *out = NULL;
  if (strlen(folder) > FOLDER_PATH - 64)
    return ylm_fail(e, YLM_EINVAL, "the folder's name is too long");
  ylm_status s = ylm__index_read(folder, &h, &entries, e);
  if (s != YLM_OK) return s;
  s = ylm__set_make(folder, cache, &h, entries, out, e);
  ylm_free(entries);
  return s;
}

ylm_status ylm__set_make(const char *folder, size_t cache, const index_head *h,
                         const index_entry *entries, ylm_grid_set **out, ylm_error *e) {
  *out = NULL;
  ylm_grid_set *s = ylm_alloc_zero(1, sizeof *s);
  if (!s) return ylm_no_memory_for(e, folder);
  snprintf(s->folder, sizeof s->folder, "%s", folder);
  s->cache = cache ? cache : SET_CACHE;
  pthread_mutex_init(&s->lock, NULL);
  ylm_status status = make_all(s, h, entries, e);
  if (status != YLM_OK) {
    ylm_grid_set_free(s);
    return status;
  }
  s->field = (ylm_field){.self = s,
                         .evaluate = ylm__set_evaluate,
                         .quantity = s->top->contents.form.quantity,
                         .relative = true};
  *out = s;
  return YLM_OK;
}

void ylm_grid_set_free(ylm_grid_set *s) {
  if (!s) return;
  for (size_t i = 0; s->brick && i < s->bricks; i++) ylm_grid_free(s->brick[i].grid);
  ylm_grid_free(s->top);
  ylm_free(s->brick);
  ylm_free(s->number);
  pthread_mutex_destroy(&s->lock);
  ylm_free(s);
}

const ylm_grid_contents *ylm_grid_set_look(const ylm_grid_set *s) { return &s->top->contents; }

ylm_grid_set_stats ylm_grid_set_stats_of(const ylm_grid_set *s) {
  pthread_mutex_t *lock = (pthread_mutex_t *)(uintptr_t)&s->lock;
  pthread_mutex_lock(lock);
  ylm_grid_set_stats stats = {s->bricks, s->level, s->bytes, s->held, s->reads};
  pthread_mutex_unlock(lock);
  return stats;
}

const ylm_field *ylm_grid_set_field(const ylm_grid_set *s) { return &s->field; }
