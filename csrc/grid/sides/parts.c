/*
** parts.c - the parts of a leaf that surfaces cross.
**
** Pieces are joined where the way between neighbours is free. A connected set is then cut until each part is seen from one
** place: connected space runs around the end of a wall, and light on both sides of it is not one function.
*/
#include "sides.h"

#include <math.h>
#include <string.h>

void ylm__side_place(const ylm_grid *g, const ylm_grid_cell *c, size_t piece,
                     const double origin[3], float out[3]) {
  const double *box = g->contents.form.bounds;
  double edge = ylm__grid_edge(g, c);
  for (int a = 0; a < 3; a++) {
    double at = (c->origin[a] + edge * piece_middle(piece, a)) / g->scale[a];
    out[a] = (float)(box[a] + at - origin[a]);
  }
}

/* A leaf under the knife. */
typedef struct cutting {
  const ylm_grid *g;
  const ylm_grid_walls *walls;
  const ylm_grid_cell *cell;
  float at[YLM_GRID_PIECES][3];
  uint8_t order[YLM_GRID_PIECES]; /* pieces from the leaf's middle outwards */
  uint8_t root[YLM_GRID_PIECES];  /* of what a piece is connected with */
  uint8_t part[YLM_GRID_PIECES];
  uint32_t parts;
  uint64_t joined;
} cutting;

static double from_middle(size_t piece) {
  double d2 = 0;
  for (int a = 0; a < 3; a++) {
    double x = piece_middle(piece, a) - 0.5;
    d2 += x * x;
  }
  return d2;
}

/* The pieces, and their order. */
static void lay_out(cutting *k, const double origin[3]) {
  for (size_t i = 0; i < YLM_GRID_PIECES; i++) {
    size_t at = i;
    ylm__side_place(k->g, k->cell, i, origin, k->at[i]);
    k->root[i] = (uint8_t)i;
    k->part[i] = YLM_GRID_PARTS;
    for (; at > 0 && from_middle(k->order[at - 1]) > from_middle(i); at--)
      k->order[at] = k->order[at - 1];
    k->order[at] = (uint8_t)i;
  }
}

static uint8_t root_of(const cutting *k, size_t i) {
  while (k->root[i] != i) i = k->root[i];
  return (uint8_t)i;
}

/* Connects neighbours along one axis whose way is free. */
static void join_along(cutting *k, int axis) {
  enum { WAYS = (MORE - 1) * MORE * MORE };
  static const size_t step[3] = {1, MORE, MORE * MORE};
  float a[WAYS][3], b[WAYS][3], share[WAYS];
  uint8_t low[WAYS];
  size_t n = 0;
  for (size_t i = 0; i < YLM_GRID_PIECES; i++) {
    if (piece_at(i, axis) == MORE - 2) continue;
    low[n] = (uint8_t)i;
    memcpy(a[n], k->at[i], sizeof a[n]);
    memcpy(b[n], k->at[i + step[axis]], sizeof b[n]);
    n++;
  }
  k->walls->share(k->walls->self, n, (const float(*)[3])a, (const float(*)[3])b, share);
  for (size_t i = 0; i < n; i++) {
    uint8_t x = root_of(k, low[i]), y = root_of(k, low[i] + step[axis]);
    if (share[i] < 1 || x == y) continue;
    k->root[x > y ? x : y] = x > y ? y : x;
  }
}

/* The pieces of a connected set that have no part yet, from the middle outwards; how many. */
static size_t waiting(const cutting *k, uint8_t root, uint8_t out[YLM_GRID_PIECES]) {
  size_t n = 0;
  for (size_t i = 0; i < YLM_GRID_PIECES; i++) {
    uint8_t piece = k->order[i];
    if (k->part[piece] == YLM_GRID_PARTS && root_of(k, piece) == root) out[n++] = piece;
  }
  return n;
}

/* The part of the piece nearest to another one, among those that there are. */
static uint8_t nearest_part(const cutting *k, size_t piece) {
  double best = INFINITY;
  uint8_t part = 0;
  for (size_t i = 0; i < YLM_GRID_PIECES; i++) {
    double d2 = 0;
    if (k->part[i] == YLM_GRID_PARTS) continue;
    for (int a = 0; a < 3; a++) {
      double x = piece_middle(i, a) - piece_middle(piece, a);
      d2 += x * x;
    }
    if (d2 < best) best = d2, part = k->part[i];
  }
  return part;
}

/* Are all of some of the n pieces of a set buried? */
static bool is_buried(const cutting *k, const uint8_t *piece, size_t n) {
  for (size_t i = 0; i < SIDES_TRIED; i++) {
    size_t tried = piece[i * (n - 1) / (SIDES_TRIED - 1)];
    if (!place_buried(k->g, k->walls, k->at[tried])) return false;
  }
  return true;
}

/* One part: what a pole sees of the n pieces that wait, or all of them. */
static void take_part(cutting *k, const uint8_t *piece, size_t n, bool all) {
  float a[YLM_GRID_PIECES][3], b[YLM_GRID_PIECES][3], share[YLM_GRID_PIECES];
  uint8_t part = (uint8_t)k->parts;
  for (size_t i = 0; i < n; i++) {
    memcpy(a[i], k->at[piece[0]], sizeof a[i]);
    memcpy(b[i], k->at[piece[i]], sizeof b[i]);
    share[i] = 1;
  }
  if (!all && n > 1)
    k->walls->share(k->walls->self, n - 1, (const float(*)[3])(a + 1), (const float(*)[3])(b + 1),
                    share + 1);
  if (k->parts == YLM_GRID_PARTS) {
    part = nearest_part(k, piece[0]);
    k->joined++;
  } else
    k->parts++;
  for (size_t i = 0; i < n; i++)
    if (share[i] >= 1) k->part[piece[i]] = part;
}

/* Cuts what is connected with a piece; sets whose middle is buried have no part. */
static void cut_set(cutting *k, uint8_t root) {
  uint8_t piece[YLM_GRID_PIECES];
  size_t n = waiting(k, root, piece);
  if (!n || is_buried(k, piece, n)) return;
  for (int pole = 0; n && pole < SIDES_POLES; pole++) {
    take_part(k, piece, n, pole == SIDES_POLES - 1);
    n = waiting(k, root, piece);
  }
}

/* How a part sees its leaf's corners: from its nearest pieces, of which outer ones count as twice as far. */
static void look_at_corners(const cutting *k, const double origin[3], uint8_t part, part_view *v) {
  float a[8][3], b[8][3];
  const double *box = k->g->contents.form.bounds;
  double edge = ylm__grid_edge(k->g, k->cell);
  for (int corner = 0; corner < 8; corner++) {
    double best = INFINITY;
    for (size_t i = 0; i < YLM_GRID_PIECES; i++) {
      double d2 = 0;
      if (k->part[i] != part) continue;
      for (int axis = 0; axis < 3; axis++) {
        double x = piece_middle(i, axis) - (corner >> axis & 1);
        d2 += x * x;
      }
      if (piece_outer(i)) d2 *= 4;
      if (d2 < best) best = d2, v->piece[corner] = (uint8_t)i;
    }
    memcpy(a[corner], k->at[v->piece[corner]], sizeof a[corner]);
    for (int axis = 0; axis < 3; axis++) {
      double at = k->cell->origin[axis] + (corner >> axis & 1 ? edge : 0);
      double to = box[axis] + at / k->g->scale[axis] - origin[axis];
      b[corner][axis] = (float)(to + LOOK_BEYOND * (to - (double)a[corner][axis]));
    }
  }
  k->walls->share(k->walls->self, 8, (const float(*)[3])a, (const float(*)[3])b, v->share);
  for (int corner = 0; corner < 8; corner++)
    if (v->share[corner] < 1)
      v->share[corner] = fminf(v->share[corner] * (1 + LOOK_BEYOND), 0.999f);
}

uint64_t ylm__side_cut(const ylm_grid *g, const ylm_grid_walls *walls, uint32_t cell,
                       ylm_grid_side *side, part_view *views) {
  const double *origin = walls->origin;
  cutting k = {.g = g, .walls = walls, .cell = &g->cell[cell]};
  lay_out(&k, origin);
  for (int axis = 0; axis < 3; axis++) join_along(&k, axis);
  for (size_t i = 0; i < YLM_GRID_PIECES; i++) {
    uint8_t piece = k.order[i];
    if (k.part[piece] == YLM_GRID_PARTS) cut_set(&k, root_of(&k, piece));
  }
  *side = (ylm_grid_side){.cell = cell, .parts = k.parts};
  for (size_t i = 0; i < YLM_GRID_PIECES; i++) side_set_part(side, i, k.part[i]);
  for (uint32_t p = 0; p < k.parts; p++) look_at_corners(&k, origin, (uint8_t)p, &views[p]);
  return k.joined;
}
