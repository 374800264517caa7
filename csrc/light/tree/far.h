/*
** far.h - the sums that a block of points shares, for the unit's element type. Lights that are far
** from the whole block are summed at the nodes of a grid of Chebyshev's over its box, lanes being
** nodes; the sums of its points are interpolated from there. Near lights are left to the packets
** of the block.
*/
#ifndef YLM_LIGHT_TREE_FAR_H
#define YLM_LIGHT_TREE_FAR_H

#include "crowd.h"

typedef struct far_field {
  int pays;      /* if blocks of this size do; -1: not known yet */
  float nearest; /* what is nearer is left to the packets */
  size_t nodes;
  int n[3];                                      /* nodes along each axis; x varies fastest */
  real middle[3], scale[3];                      /* of the box; 1 over half an extent */
  real basis[3][YLM__FAR_NODES][YLM__FAR_NODES]; /* of Lagrange, by Chebyshev */
  vreal weight[3][YLM__FAR_NODES];               /* of the nodes, at points */
  crowd crowd;                                   /* the nodes */
  real *table;                                   /* [sums][nodes] */
  size_t n_start;
  uint32_t start[LEFT]; /* what is left to the packets */
} far_field;

/* -- nodes ----------------------------------------------------------------------------------- */

/* Places the nodes in the box; the last vector is filled up with the first node. */
static void place_nodes(far_field *f, const real *half) {
  crowd *c = &f->crowd;
  c->vectors = (int)((f->nodes + LANES - 1) / LANES);
  for (size_t i = 0; i < (size_t)c->vectors * LANES; i++) {
    size_t at = i < f->nodes ? i : 0;
    for (int a = 0; a < 3; at /= (size_t)f->n[a++]) {
      double t = cos(((double)(at % (size_t)f->n[a]) + 0.5) * YLM_PI / f->n[a]);
      c->xyz[i / LANES][a][i % LANES] = f->middle[a] + half[a] * (real)t;
    }
  }
  for (int a = 0; a < 3; a++) {
    int n = f->n[a];
    f->scale[a] = n > 1 ? 1 / half[a] : 0;
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++)
        f->basis[a][i][j] = (real)((j ? 2.0 : 1.0) / n * cos(j * (i + 0.5) * YLM_PI / n));
  }
}

/* The nodes' weights at LANES points. */
static void weigh(far_field *f, const vreal *xyz) {
  for (int a = 0; a < 3; a++) {
    vreal T[YLM__FAR_NODES], t = (xyz[a] - f->middle[a]) * f->scale[a];
    T[0] = (vreal){0} + 1, T[1] = t;
    for (int j = 2; j < f->n[a]; j++) T[j] = 2 * t * T[j - 1] - T[j - 2];
    for (int i = 0; i < f->n[a]; i++) {
      vreal w = {0};
      for (int j = 0; j < f->n[a]; j++) w += f->basis[a][i][j] * T[j];
      f->weight[a][i] = w;
    }
  }
}

/* Adds the sums that are interpolated at LANES points, n of them. */
static void interpolate(far_field *f, const vreal *xyz, size_t n, vreal *to) {
  weigh(f, xyz);
  size_t X = (size_t)f->n[0], Y = (size_t)f->n[1], Z = (size_t)f->n[2];
  for (size_t s = 0; s < n; s += ABREAST) {
    const real *at[ABREAST];
    vreal sum[ABREAST] = {{0}};
    for (size_t i = 0; i < ABREAST; i++) at[i] = f->table + (s + i < n ? s + i : s) * f->nodes;
    for (size_t z = 0; z < Z; z++) {
      vreal plane[ABREAST] = {{0}};
      for (size_t y = 0; y < Y; y++) {
        vreal row[ABREAST] = {{0}};
        for (size_t x = 0; x < X; x++)
          for (int i = 0; i < ABREAST; i++) row[i] += f->weight[0][x] * *at[i]++;
        for (int i = 0; i < ABREAST; i++) plane[i] += f->weight[1][y] * row[i];
      }
      for (int i = 0; i < ABREAST; i++) sum[i] += f->weight[2][z] * plane[i];
    }
    for (size_t i = 0; i < ABREAST && s + i < n; i++) to[s + i] += sum[i];
  }
}

/* -- what is far ----------------------------------------------------------------------------- */

/* Walks from what the larger block `above` left, or from the root. */
static void walk_below(tree_walk *walk, const far_field *above) {
  static const uint32_t root = 1;
  walk->n_left = 0, walk->too_many = false;
  walk_from(walk, above ? above->start : &root, above ? above->n_start : 1);
}

/* How many lights and proxies a block's walk comes to. */
static size_t count_far(tree_walk *walk, const far_field *above, const seen_from *from,
                        const seen_by *by) {
  const note_lists *notes = &walk->notes;
  size_t n = 0;
  walk_below(walk, above);
  while (walk_on(walk, from, by) > 0 && !walk->too_many)
    for (int dim = 0; dim <= OF_DIM; dim += OF_DIM) {
      for (size_t i = 0; i < notes->n[OF_LEAF + dim]; i++)
        n += notes->at[OF_LEAF + dim][i] >> YLM__COUNT_AT & 15;
      n += notes->n[OF_FEW + dim] * YLM__PROXIES + notes->n[OF_MANY + dim] * YLM__MOST_PROXIES;
    }
  return n;
}

/* The nodes of a block of so many points, and the distance from which on they serve; 0 if there
   would be too many. */
static size_t find_nodes(const ylm__tree_plan *p, size_t points, seen_from *from, int n[3]) {
  float part[3];
  int axes = (from->half[0] > 0) + (from->half[1] > 0) + (from->half[2] > 0), along = ALONG;
  while (pow(along, axes) > 0.25 * (double)points) along--;
  if (along < FEWEST) return 0;
  for (int k = 0; k < 3; k++) {
    part[k] = fminf(FAR_SHARE * from->part[k], LARGEST);
    from->strong[k] =
        part[k] * part[k] / (STRONG * STRONG * from->part[k] * fmaxf(from->error[k], 1e-30f));
  }
  n[0] = along;
  from->nearest = (float)ylm__far_nodes(&p->far, p->want, from->half, part, n);
  from->power = (along - 2) / 2;
  size_t nodes = (size_t)(n[0] * n[1] * n[2]);
  return nodes > p->nodes || !(from->nearest > 0) ? 0 : nodes;
}

/* Does it pay to interpolate? */
static bool pays(const ylm__tree_plan *p, tree_walk *walk, const far_field *above, size_t points,
                 seen_from *from, const seen_by *by) {
  int n[3];
  size_t nodes = find_nodes(p, points, from, n);
  if (nodes == 0 || (above && from->nearest >= above->nearest)) return false;
  double lanes = (double)((nodes + LANES - 1) / LANES * LANES);
  double many = (double)count_far(walk, above, from, by);
  return !walk->too_many && many * (INSTEAD - lanes / (double)points) > COST * (double)nodes;
}

/* Sums what is far from a block at its nodes; how many pairs that took. `from` is the box and what
   its points allow, `half` its extent in the scene. f->nodes is 0 if nothing is interpolated. */
static uint64_t sum_far(const ylm__tree_plan *p, tree_walk *walk, far_field *above, far_field *f,
                        work *w, seen_from *from, size_t points, const real *half) {
  crowd *c = &f->crowd;
  size_t n = (size_t)(p->sums->n_lum + 3 * p->sums->n_rgb);
  size_t dim = (size_t)(p->dim.n_lum + 3 * p->dim.n_rgb);
  f->nodes = find_nodes(p, points, from, f->n);
  if (f->nodes == 0) return 0;
  place_nodes(f, half);
  memset(c->sums, 0, (size_t)c->vectors * n * sizeof(vreal));
  memset(c->dim_sums, 0, (size_t)c->vectors * dim * sizeof(vreal));
  walk_below(walk, above);
  uint64_t pairs = (size_t)c->vectors * LANES * walk_together(walk, c, w, from);
  if (walk->too_many) f->nodes = 0;
  for (int v = 0; v < c->vectors; v++) {
    vreal *sums = c->sums + (size_t)v * n;
    add_dim(p, c->dim_sums + (size_t)v * dim, sums);
    if (above) interpolate(above, c->xyz[v], n, sums);
  }
  const real *sums = (const real *)c->sums;
  for (size_t s = 0; s < n; s++)
    for (size_t i = 0; i < f->nodes; i++)
      f->table[s * f->nodes + i] = sums[(i / LANES * n + s) * LANES + i % LANES];
  f->nearest = from->nearest;
  f->n_start = walk->n_left;
  memcpy(f->start, walk->left, f->n_start * sizeof *f->start);
  return pairs;
}

#endif
