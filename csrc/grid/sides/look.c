/* look.c - the part of a leaf that a place is in. */
#include "sides.h"

#include <math.h>
#include <string.h>

/* A leaf as a place is looked for in it. */
typedef struct looking {
  const ylm_grid *g;
  const ylm_grid_side *side;
  const ylm_grid_cell *cell;
  double edge[3];  /* scene units */
  double mean;     /* edge */
  double place[3]; /* in edges of the leaf */
} looking;

static looking look_into(const ylm_grid *g, const ylm_grid_side *s, const double x[3]) {
  looking l = {.g = g, .side = s, .cell = &g->cell[s->cell]};
  const double *box = g->contents.form.bounds;
  double units = ylm__grid_edge(g, l.cell);
  for (int a = 0; a < 3; a++) {
    l.edge[a] = units / g->scale[a];
    l.mean += l.edge[a] / 3;
    l.place[a] = ((x[a] - box[a]) * g->scale[a] - l.cell->origin[a]) / units;
  }
  return l;
}

/* Squared distances of pieces from a place, in scene units; INFINITY for those without a part. */
static void measure_pieces(const looking *l, const double place[3], double d2[YLM_GRID_PIECES]) {
  double axis[3][MORE];
  for (int a = 0; a < 3; a++)
    for (int i = 0; i < MORE; i++) {
      double x = ((i - 0.5) / SUB - place[a]) * l->edge[a];
      axis[a][i] = x * x;
    }
  for (size_t i = 0; i < YLM_GRID_PIECES; i++)
    d2[i] = ylm_grid_side_part(l->side, i) == YLM_GRID_PARTS
                ? INFINITY
                : axis[0][i % MORE] + axis[1][i / MORE % MORE] + axis[2][i / (MORE * MORE)];
}

static size_t nearest(const double d2[YLM_GRID_PIECES]) {
  size_t best = 0;
  for (size_t i = 1; i < YLM_GRID_PIECES; i++)
    if (d2[i] < d2[best]) best = i;
  return best;
}

/* A place in front of one on a surface, in edges: `way` scene units along its normal. */
static void in_front(const looking *l, const float normal[3], double way, double out[3]) {
  for (int a = 0; a < 3; a++)
    out[a] = l->place[a] + (normal ? way * (double)normal[a] / l->edge[a] : 0);
}

/* The part of the piece in front of a place; else of the nearest that has one. */
static uint8_t by_pieces(const looking *l, const float normal[3]) {
  static const double way[3] = {1, 1.7, 0.5};
  double place[3], thick = 0, d2[YLM_GRID_PIECES];
  for (int a = 0; normal && a < 3; a++) thick += 0.75 * fabs((double)normal[a]) * l->edge[a] / SUB;
  for (int i = 0; i < (normal ? 3 : 1); i++) {
    in_front(l, normal, way[i] * thick, place);
    uint8_t part = ylm_grid_side_part_at(l->side, place);
    if (part != YLM_GRID_PARTS) return part;
  }
  in_front(l, normal, thick, place);
  measure_pieces(l, place, d2);
  return ylm_grid_side_part(l->side, nearest(d2));
}

/* The part of the first piece, from the place in front of a point outwards, that the point sees. */
static uint8_t by_rays(const looking *l, const double x[3], const float normal[3],
                       const ylm_grid_walls *walls) {
  double place[3], d2[YLM_GRID_PIECES];
  float from[1][3], to[1][3], share;
  in_front(l, normal, LOOK_FRONT * l->mean, place);
  measure_pieces(l, place, d2);
  for (int a = 0; a < 3; a++) {
    double off = normal ? LOOK_OFF * l->mean * (double)normal[a] : 0;
    from[0][a] = (float)(x[a] - walls->origin[a] + off);
  }
  for (int asked = 0; asked < LOOK_PIECES; asked++) {
    size_t i = nearest(d2);
    uint8_t part = ylm_grid_side_part(l->side, i);
    if (isinf(d2[i])) break;
    ylm__side_place(l->g, l->cell, i, walls->origin, to[0]);
    walls->share(walls->self, 1, (const float(*)[3])from, (const float(*)[3])to, &share);
    if (share >= 1) return part;
    d2[i] = INFINITY;
  }
  return by_pieces(l, normal);
}

uint32_t ylm__side_look(const ylm_grid *g, const ylm_grid_side *s, const double x[3],
                        const float normal[3], const ylm_grid_walls *walls) {
  if (s->parts == 1) return s->first;
  looking l = look_into(g, s, x);
  return s->first + (walls ? by_rays(&l, x, normal, walls) : by_pieces(&l, normal));
}

bool ylm__side_is_free(const ylm_grid *g, const ylm_grid_side *s, const double x[3]) {
  looking l = look_into(g, s, x);
  return ylm_grid_side_part_at(s, l.place) != YLM_GRID_PARTS;
}

uint8_t ylm__side_part_near(const ylm_grid *g, const ylm_grid_side *s, size_t piece) {
  uint8_t part = ylm_grid_side_part(s, piece);
  if (part != YLM_GRID_PARTS) return part;
  const double *box = g->contents.form.bounds;
  looking l = look_into(g, s, box);
  double middle[3], d2[YLM_GRID_PIECES];
  for (int a = 0; a < 3; a++) middle[a] = (piece_at(piece, a) + 0.5) / SUB;
  measure_pieces(&l, middle, d2);
  return ylm_grid_side_part(s, nearest(d2));
}
