/*
** unread.c - leaves without the bricks that no place of a surface reads: they lie behind surfaces, where nothing is lit or seen.
**
** A brick counts as read where one of its points is also one of a brick that a place reads: it may be a sliver that no place fell into.
** A side of planes whose brick is not read has that of the side with the fewest other planes between; planes that tell nothing apart
** then go. A leaf none of whose bricks is read stays as it is.
*/
#include "probes.h"

#include <string.h>

/* The side whose brick is read that the fewest planes part from one; -1: there is none. */
static int nearest(const probes_cut *c, const bool *read, int side) {
  int best = -1, least = PROBES_PLANES + 1;
  for (int s = 0; s < 1 << c->planes; s++) {
    int planes = 0;
    for (int k = 0; k < c->planes; k++) planes += (s ^ side) >> k & 1;
    if (!read[c->part[s]] || planes >= least) continue;
    least = planes;
    best = s;
  }
  return best;
}

/* Whether the two sides of a plane have the same bricks everywhere. */
static bool is_idle(const probes_cut *c, int plane) {
  for (int s = 0; s < 1 << c->planes; s++)
    if (c->part[s] != c->part[s ^ 1 << plane]) return false;
  return true;
}

static void remove_plane(probes_cut *c, int plane) {
  int below = (1 << plane) - 1;
  c->planes--;
  for (int s = 0; s < 1 << c->planes; s++) c->part[s] = c->part[(s & below) | (s & ~below) << 1];
  for (int k = plane; k < c->planes; k++) {
    memcpy(c->normal[k], c->normal[k + 1], sizeof c->normal[k]);
    c->offset[k] = c->offset[k + 1];
  }
}

static void drop_of_leaf(probes_cut *c, const bool *read) {
  probes_cut with = *c;
  for (int s = 0; s < 1 << c->planes; s++) {
    int to = nearest(&with, read, s);
    if (to >= 0) c->part[s] = with.part[to];
  }
  for (int k = c->planes - 1; k >= 0; k--)
    if (is_idle(c, k)) remove_plane(c, k);
}

/* Marks bricks that have a point in common with bricks that are read. */
static void mark_beside(const ylm_grid_probes *p, bool *read, bool *of_read) {
  for (size_t i = 0; i < p->bricks; i++)
    for (int k = 0; k < 8; k++) of_read[p->corner[i][k]] |= read[i];
  for (size_t i = 0; i < p->bricks; i++)
    for (int k = 0; k < 8; k++) read[i] |= of_read[p->corner[i][k]];
}

ylm_status ylm__probes_drop_unread(ylm_grid_probes *p, const ylm_grid_probes_places *at) {
  bool *read = ylm_alloc_zero(p->bricks + p->points + 1, sizeof *read);
  if (!read) return YLM_ENOMEM;
  for (size_t i = 0; i < at->n; i++) {
    probes_place place = ylm__probes_find(p, at->point[i], at->normal[i]);
    if (place.brick != YLM_GRID_NONE) read[place.brick] = true;
  }
  mark_beside(p, read, read + p->bricks);
  for (size_t i = 0; i < p->cells; i++)
    if (p->parts[i] != PROBES_SPLIT && p->row[i] != YLM_GRID_NONE)
      drop_of_leaf(&p->cut[p->row[i]], read + p->first[i]);
  ylm_free(read);
  return YLM_OK;
}
