/*
** nodes.c - the points at the corners of leaves.
**
** Parts that see a corner share the point there with the leaves that no surface crosses. The others form classes: parts of
** different leaves that see each other around it. A class has one ghost, so that leaves of one size agree on their faces.
*/
#include "sides.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A corner of a part. */
typedef struct stake {
  uint64_t key; /* of the corner */
  uint32_t part, row;
  uint8_t corner;
  bool sees;
  uint32_t class; /* place among the stakes of the corner of the class' first */
  double way;     /* from its nearest piece to the corner, squared */
} stake;

typedef struct staking {
  side_baker *k;
  stake *stake;
  size_t n;
  const ylm_grid_walls *walls;
} staking;

static int by_corner(const void *a, const void *b) {
  const stake *x = a, *y = b;
  if (x->key != y->key) return x->key < y->key ? -1 : 1;
  return x->part != y->part ? (x->part < y->part ? -1 : 1) : x->corner - y->corner;
}

/* -- leaves that no surface crosses --------------------------------------------------------------- */

static ylm_status find_open(side_baker *k) {
  ylm_grid *g = k->b->g;
  for (size_t i = 0; i < g->cells; i++) {
    if (!(g->cell[i].flags & YLM_GRID_LEAF) || k->row[i] != ROW_OPEN) continue;
    for (int corner = 0; corner < 8; corner++) {
      uint32_t at[3], point = g->cell[i].corner[corner];
      if (point != YLM_GRID_NONE) continue;
      ylm__grid_corner_at(g, &g->cell[i], corner, at);
      ylm_status s = ylm__corners_point(k->b, at, 0, &point);
      if (s != YLM_OK) return s;
      g->cell[i].corner[corner] = point;
    }
  }
  return YLM_OK;
}

/* -- stakes --------------------------------------------------------------------------------------- */

/* The place of the piece from which a stake looks at its corner, relative to the walls' origin. */
static void stand_of(const staking *j, const stake *s, float out[3]) {
  const ylm_grid *g = j->k->b->g;
  const ylm_grid_cell *c = &g->cell[g->sides.side[s->row].cell];
  ylm__side_place(g, c, j->k->view[s->part].piece[s->corner], j->walls->origin, out);
}

/* A corner relative to the walls' origin. */
static void corner_place(const staking *j, const stake *s, double out[3]) {
  const ylm_grid *g = j->k->b->g;
  const ylm_grid_cell *c = &g->cell[g->sides.side[s->row].cell];
  uint32_t at[3];
  ylm__grid_corner_at(g, c, s->corner, at);
  ylm_grid_position(g, at, out);
  for (int a = 0; a < 3; a++) out[a] -= j->walls->origin[a];
}

/* All corners of all parts of leaves. */
static ylm_status drive_stakes(staking *j) {
  const side_baker *k = j->k;
  const ylm_grid *g = k->b->g;
  j->stake = ylm_alloc(8 * g->sides.parts, sizeof *j->stake);
  if (!j->stake) return YLM_ENOMEM;
  for (uint32_t row = 0; row < g->sides.n; row++) {
    const ylm_grid_side *side = &g->sides.side[row];
    const ylm_grid_cell *c = &g->cell[side->cell];
    if (!(c->flags & YLM_GRID_LEAF)) continue;
    for (uint32_t part = side->first; part < side->first + side->parts; part++)
      for (uint8_t corner = 0; corner < 8; corner++) {
        stake s = {.part = part, .row = row, .corner = corner};
        uint32_t at[3];
        float stand[3];
        double to[3];
        ylm__grid_corner_at(g, c, corner, at);
        s.key = lattice_key(at);
        s.sees = k->view[part].share[corner] >= 1;
        stand_of(j, &s, stand);
        corner_place(j, &s, to);
        for (int a = 0; a < 3; a++)
          s.way += (to[a] - (double)stand[a]) * (to[a] - (double)stand[a]);
        j->stake[j->n++] = s;
      }
  }
  if (j->n) qsort(j->stake, j->n, sizeof *j->stake, by_corner);
  return YLM_OK;
}

/* -- classes -------------------------------------------------------------------------------------- */

static uint32_t class_of(const stake *s, uint32_t i) {
  while (s[i].class != i) i = s[i].class;
  return i;
}

/* Joins the n stakes of a corner that do not see it, where parts of different leaves see each other. */
static ylm_status find_classes(const staking *j, stake *s, uint32_t n) {
  const ylm_grid_walls *w = j->walls;
  float(*stand)[3] = ylm_alloc(3 * (size_t)n, sizeof *stand);
  float *share = ylm_alloc(n, sizeof *share);
  bool ok = stand && share;
  for (uint32_t i = 0; ok && i < n; i++) {
    s[i].class = i;
    stand_of(j, &s[i], stand[i]);
  }
  for (uint32_t i = 1; ok && i < n; i++) {
    float(*from)[3] = stand + n, (*to)[3] = stand + 2 * (size_t)n;
    for (uint32_t m = 0; m < i; m++) {
      memcpy(from[m], stand[i], sizeof *stand);
      memcpy(to[m], stand[m], sizeof *stand);
    }
    if (!s[i].sees) w->share(w->self, i, (const float(*)[3])from, (const float(*)[3])to, share);
    for (uint32_t m = 0; m < i; m++) {
      if (s[i].sees || s[m].sees || s[i].row == s[m].row || share[m] < 1) continue;
      uint32_t x = class_of(s, i), y = class_of(s, m);
      s[x > y ? x : y].class = x > y ? y : x;
    }
  }
  ylm_free(stand);
  ylm_free(share);
  return ok ? YLM_OK : YLM_ENOMEM;
}

/* The place where the field is asked for the ghost of a stake, relative to the grid's origin. */
static void ask_at(const staking *j, const stake *s, float out[3]) {
  const ylm_grid *g = j->k->b->g;
  float stand[3];
  double to[3], way = fmax(0, (double)j->k->view[s->part].share[s->corner] - GHOST_BEFORE);
  stand_of(j, s, stand);
  corner_place(j, s, to);
  for (int a = 0; a < 3; a++) {
    double p = (double)stand[a] + way * (to[a] - (double)stand[a]);
    out[a] = (float)(p + j->walls->origin[a] - g->origin[a]);
  }
}

/* The point of a ghost, a new one where there is none. */
static ylm_status find_ghost(staking *j, const stake *s, uint32_t *point) {
  side_baker *k = j->k;
  ylm_grid *g = k->b->g;
  const size_t size = sizeof(ghost_key);
  ghost_key key;
  uint32_t number;
  size_t before = k->ghosts.n;
  ylm__grid_corner_at(g, &g->cell[g->sides.side[s->row].cell], s->corner, key.lattice);
  ask_at(j, s, key.asked);
  ylm_status status = ylm_keys_put(&k->ghosts, &key, size, &number);
  if (status != YLM_OK) return status;
  if (k->ghosts.n > before) {
    if (!ylm_list_reserve(&k->ghost_point, before, before + 1, &k->ghost_room,
                          sizeof *k->ghost_point))
      return YLM_ENOMEM;
    status = ylm__corners_room(k->b);
    if (status != YLM_OK) return status;
    size_t p = g->points++;
    memcpy(g->lattice + 3 * p, key.lattice, sizeof key.lattice);
    memcpy(g->sides.asked[p], key.asked, sizeof key.asked);
    g->flags[p] = YLM_GRID_POINT_GHOST;
    k->ghost_point[number] = (uint32_t)p;
  }
  *point = k->ghost_point[number];
  return YLM_OK;
}

/* Gives the n stakes of one corner their points. */
static ylm_status settle_corner(staking *j, stake *s, uint32_t n) {
  const ylm_grid *g = j->k->b->g;
  uint32_t point = YLM_GRID_NONE, at[3];
  bool blind = false;
  ylm__grid_corner_at(g, &g->cell[g->sides.side[s->row].cell], s->corner, at);
  ylm_status status = YLM_OK;
  for (uint32_t i = 0; i < n; i++) blind |= !s[i].sees;
  for (uint32_t i = 0; status == YLM_OK && i < n; i++) {
    if (!s[i].sees) continue;
    if (point == YLM_GRID_NONE) status = ylm__corners_point(j->k->b, at, 0, &point);
    g->sides.node[s[i].part][s[i].corner] = point;
  }
  if (status == YLM_OK && blind) status = find_classes(j, s, n);
  for (uint32_t i = 0; status == YLM_OK && blind && i < n; i++) {
    uint32_t best = i;
    if (s[i].sees || class_of(s, i) != i) continue;
    for (uint32_t m = i; m < n; m++)
      if (!s[m].sees && class_of(s, m) == i && s[m].way < s[best].way) best = m;
    status = find_ghost(j, &s[best], &point);
    for (uint32_t m = i; m < n; m++)
      if (!s[m].sees && class_of(s, m) == i) g->sides.node[s[m].part][s[m].corner] = point;
  }
  return status;
}

ylm_status ylm__sides_find_nodes(side_baker *k) {
  ylm_grid *g = k->b->g;
  staking j = {.k = k, .walls = k->b->source->walls};
  ylm_status s = find_open(k);
  if (s == YLM_OK) s = drive_stakes(&j);
  for (size_t i = 0, n; s == YLM_OK && i < j.n; i += n) {
    for (n = 1; i + n < j.n && j.stake[i + n].key == j.stake[i].key;) n++;
    s = settle_corner(&j, j.stake + i, (uint32_t)n);
  }
  for (size_t i = 0; s == YLM_OK && i < g->sides.n; i++) {
    const ylm_grid_side *side = &g->sides.side[i];
    if (side->parts)
      memcpy(g->cell[side->cell].corner, g->sides.node[side->first], sizeof g->cell->corner);
  }
  ylm_free(j.stake);
  return s;
}
