/* compact.c - probes without what nobody reads. */
#include "probes.h"

#include <string.h>

/* Marks the bricks that places of a leaf have. */
static void mark_used(const ylm_grid_probes *p, uint32_t row, bool used[PROBES_PARTS]) {
  for (int i = 0; i < PROBES_PARTS; i++) used[i] = row == YLM_GRID_NONE;
  if (row == YLM_GRID_NONE) return;
  for (int i = 0; i < 1 << p->cut[row].planes; i++) used[p->cut[row].part[i]] = true;
}

/* Moves what is known of a leaf of several bricks, which have new numbers. */
static void move_several(ylm_grid_probes *p, uint32_t from, size_t to,
                         const uint8_t number[PROBES_PARTS]) {
  p->cut[to] = p->cut[from];
  for (int i = 0; i < 1 << p->cut[to].planes; i++) p->cut[to].part[i] = number[p->cut[to].part[i]];
  for (int i = 0; i < PROBES_PIECES; i++) p->piece[to][i] = number[p->piece[from][i]];
  for (int i = 0; i < YLM_GRID_PARTS; i++) {
    uint8_t brick = p->brick_of[from][i];
    p->brick_of[to][i] = brick == 255 ? 255 : number[brick];
  }
}

/* Bricks that no place has go, and bricks of a leaf that have the same points become one. */
static void join_bricks(ylm_grid_probes *p) {
  size_t bricks = 0, several = 0;
  for (size_t cell = 0; cell < p->cells; cell++) {
    uint8_t parts = p->parts[cell], number[PROBES_PARTS] = {0}, kept = 0;
    bool used[PROBES_PARTS];
    if (parts == PROBES_SPLIT) continue;
    uint32_t first = p->first[cell], row = p->row[cell];
    mark_used(p, row, used);
    for (uint8_t i = 0; i < parts; i++) {
      uint8_t k = 0;
      if (!used[i]) continue;
      while (k < kept && memcmp(p->corner[bricks + k], p->corner[first + i], 32) != 0) k++;
      if (k == kept) memmove(p->corner[bricks + kept++], p->corner[first + i], 32);
      number[i] = k;
    }
    p->first[cell] = (uint32_t)bricks;
    p->parts[cell] = kept;
    bricks += kept;
    p->row[cell] = kept > 1 ? (uint32_t)several : YLM_GRID_NONE;
    if (kept > 1) move_several(p, row, several++, number);
  }
  p->bricks = bricks;
  p->several = several;
}

/* Marks a point, and those that it is between. */
static void mark_point(const ylm_grid_probes *p, uint32_t point, uint32_t *number) {
  if (number[point] != YLM_GRID_NONE) return;
  number[point] = 0;
  for (int k = 0; p->tie && p->tie[point][0] != YLM_GRID_NONE && k < 4; k++)
    mark_point(p, p->tie[point][k], number);
}

ylm_status ylm__probes_compact(ylm_grid_probes *p) {
  size_t width = 3 * (size_t)p->count, points = 0;
  uint32_t *number = ylm_alloc(p->points ? p->points : 1, sizeof *number);
  if (!number) return YLM_ENOMEM;
  join_bricks(p);
  for (size_t i = 0; i < p->points; i++) number[i] = YLM_GRID_NONE;
  for (size_t i = 0; i < p->bricks; i++)
    for (int k = 0; k < 8; k++) mark_point(p, p->corner[i][k], number);
  for (size_t i = 0; i < p->points; i++) {
    if (number[i] == YLM_GRID_NONE) continue;
    memmove(p->value + points * width, p->value + i * width, width * sizeof *p->value);
    p->ghost[points] = p->ghost[i];
    if (p->tie) memmove(p->tie[points], p->tie[i], sizeof *p->tie);
    number[i] = (uint32_t)points++;
  }
  for (size_t i = 0; i < p->bricks; i++)
    for (int k = 0; k < 8; k++) p->corner[i][k] = number[p->corner[i][k]];
  for (size_t i = 0; p->tie && i < points; i++)
    for (int k = 0; k < 4 && p->tie[i][0] != YLM_GRID_NONE; k++)
      p->tie[i][k] = number[p->tie[i][k]];
  p->points = points;
  ylm_free(number);
  return YLM_OK;
}
