/*
** tie.c - corners that hang on a larger leaf's face or edge, so that light is continuous there.
**
** A point that a larger brick beside has between two or four of its own corners is their mean, where both bricks have a corner in
** common: only then no wall is between them. Fits and joins know the other points alone. Ends of ties are corners of larger leaves, so
** that ties end at points that are free.
*/
#include "probes.h"

#include <string.h>

#define MIDDLES 18 /* of a cell's edges and faces */

typedef struct tie_middle {
  uint32_t next, point[4];
  uint8_t level;
} tie_middle;

typedef struct tying {
  ylm_grid_probes *p;
  probes_lattice lattice;
  lattice_hash hash; /* the first row of a place's list */
  tie_middle *middle;
  size_t middles;
} tying;

/* The middles of a brick's edges and faces, which smaller leaves may have as corners. */
static ylm_status add_middles(tying *t, size_t cell, uint32_t brick) {
  const probes_lattice *l = &t->lattice;
  uint32_t half = 1u << (l->deepest - l->level[cell] - 1);
  for (uint32_t i = 0; i < 27; i++) {
    const uint32_t step[3] = {i % 3, i / 3 % 3, i / 9};
    uint32_t at[3], odd[3], n = 0, corner = 0;
    for (uint32_t a = 0; a < 3; a++) {
      at[a] = l->at[cell][a] + step[a] * half;
      corner |= step[a] == 2 ? 1u << a : 0;
      if (step[a] == 1) odd[n++] = a;
    }
    if (n < 1 || n > 2) continue;
    ylm_status s = ylm__lattice_hash_reserve(&t->hash, t->hash.used + 1);
    if (s != YLM_OK) return s;
    tie_middle m = {.level = l->level[cell]};
    uint32_t *first = ylm__lattice_hash_at(&t->hash, ylm__probes_key(at));
    m.next = *first;
    *first = (uint32_t)t->middles;
    for (uint32_t j = 0; j < 4; j++) {
      uint32_t k = corner;
      for (uint32_t o = 0; o < n; o++) k |= (j >> o & 1) << odd[o];
      m.point[j] = t->p->corner[brick][k];
    }
    t->middle[t->middles++] = m;
  }
  return YLM_OK;
}

static bool has(const uint32_t point[4], uint32_t x) {
  return point[0] == x || point[1] == x || point[2] == x || point[3] == x;
}

/* Whether a brick has a corner that is one of four points. */
static bool touches(const uint32_t corner[8], const uint32_t point[4]) {
  for (int k = 0; k < 8; k++)
    if (has(point, corner[k])) return true;
  return false;
}

static void tie_corner(tying *t, size_t cell, uint32_t brick, uint32_t k) {
  ylm_grid_probes *p = t->p;
  uint32_t point = p->corner[brick][k];
  if (p->tie[point][0] != YLM_GRID_NONE) return;
  uint32_t i = ylm__lattice_hash_find(&t->hash, ylm__probes_corner(&t->lattice, cell, k));
  for (; i != YLM_GRID_NONE; i = t->middle[i].next) {
    const tie_middle *m = &t->middle[i];
    if (m->level + 1 != t->lattice.level[cell] || has(m->point, point) ||
        !touches(p->corner[brick], m->point))
      continue;
    memcpy(p->tie[point], m->point, sizeof m->point);
    return;
  }
}

ylm_status ylm__probes_tie(ylm_grid_probes *p) {
  tying t = {.p = p, .middle = ylm_alloc(p->bricks + 1, MIDDLES * sizeof *t.middle)};
  if (p->tie || !t.middle) {
    ylm_free(t.middle);
    return p->tie ? YLM_OK : YLM_ENOMEM;
  }
  p->tie = ylm_alloc(p->points + 1, sizeof *p->tie);
  ylm_status s = p->tie ? ylm__probes_lattice(p, &t.lattice) : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < p->points; i++) p->tie[i][0] = YLM_GRID_NONE;
  for (size_t i = 0; s == YLM_OK && i < p->cells; i++)
    for (uint32_t b = 0; s == YLM_OK && p->parts[i] != PROBES_SPLIT && b < p->parts[i]; b++)
      if (t.lattice.level[i] < t.lattice.deepest) s = add_middles(&t, i, p->first[i] + b);
  for (size_t i = 0; s == YLM_OK && i < p->cells; i++)
    for (uint32_t b = 0; p->parts[i] != PROBES_SPLIT && b < p->parts[i]; b++)
      for (uint32_t k = 0; t.lattice.level[i] && k < 8; k++) tie_corner(&t, i, p->first[i] + b, k);
  ylm__probes_lattice_free(&t.lattice);
  ylm__lattice_hash_free(&t.hash);
  ylm_free(t.middle);
  if (s == YLM_OK) return s;
  ylm_free(p->tie);
  p->tie = NULL;
  return s;
}

void ylm__probes_follow_ties(ylm_grid_probes *p) {
  size_t width = 3 * (size_t)p->count;
  /* a tie's ends may be ties themselves, of larger leaves: as many rounds as there are levels */
  for (int round = 0; p->tie && round < PROBES_DEPTH; round++) {
    bool changed = false;
    for (size_t i = 0; i < p->points; i++) {
      if (p->tie[i][0] == YLM_GRID_NONE) continue;
      for (size_t j = 0; j < width; j++) {
        float sum = 0;
        for (int k = 0; k < 4; k++) sum += p->value[p->tie[i][k] * width + j];
        changed |= p->value[i * width + j] != sum / 4;
        p->value[i * width + j] = sum / 4;
      }
    }
    if (!changed) break;
  }
}

size_t ylm__probes_free_points(const ylm_grid_probes *p) {
  size_t n = 0;
  for (size_t i = 0; i < p->points; i++) n += !p->tie || p->tie[i][0] == YLM_GRID_NONE;
  return n;
}
