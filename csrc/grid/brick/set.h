/* set.h - a grid in bricks, opened. */
#ifndef YLM_GRID_SET_H
#define YLM_GRID_SET_H

#include <pthread.h>

#include "brick.h"

/* A brick; its grid is NULL while it is not in memory. */
typedef struct set_brick {
  uint32_t origin[3], level;
  char code[BRICK_CODE];
  uint64_t size, used; /* bytes of the file; when it was used */
  ylm_grid *grid;
} set_brick;

struct ylm_grid_set {
  char folder[FOLDER_PATH];
  ylm_grid *top;
  uint32_t *number; /* by cell of the top: the brick, `bricks` where it is none */
  set_brick *brick; /* [bricks] along the Morton code of their origins */
  size_t bricks, cache, held;
  uint64_t clock, reads, bytes, level;
  grid_file_room room; /* of the rows of a brick that was forgotten, while another is read */
  ylm_field field;
  pthread_mutex_t lock; /* of cache and clock */
};

/* A set from what its index says. */
ylm_status ylm__set_make(const char *folder, size_t cache, const index_head *h,
                         const index_entry *entries, ylm_grid_set **s, ylm_error *e);
/* The grid of a brick, of the top where `number` is the number of bricks; good until the next call. */
ylm_status ylm__set_get(ylm_grid_set *s, size_t number, int threads, const ylm_grid **g,
                        ylm_error *e);
/* ylm_report with the lock open, since a progress function may ask the set: a grid of ylm__set_get is not good any more. */
ylm_status ylm__set_report(ylm_grid_set *s, const ylm_progress *p, uint64_t done, uint64_t total,
                           const char *stage);
/* Is the grid of a brick in memory? The top always is. */
static inline bool set_holds(const ylm_grid_set *s, size_t number) {
  return number == s->bricks || s->brick[number].grid;
}
/* Facts of the bake of a set, by its top; pack.c. */
void ylm__pack_stats(ylm_grid *g, const ylm_grid *top);
/* set_sample.c: the field of a set. */
ylm_status ylm__set_evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                             const void *points, ylm_field_result *r, ylm_error *e);

#endif
