/*
** crowd.h - sums over lists of lights and proxies that a packet of points shares, for the
** unit's element type. Here lanes are points, as in the exact sum.
*/
#ifndef YLM_LIGHT_TREE_CROWD_H
#define YLM_LIGHT_TREE_CROWD_H

#include "alone.h"

/* Vectors of points in a packet, and lights to sum over: room for one more leaf. */
#define VECTORS (YLM__PACKET > LANES ? YLM__PACKET / LANES : 1)
#define CROWD (YLM__BLOCK + YLM__LEAF)

typedef struct lamp_list {
  size_t n;
  real_lamp lamp[CROWD];
} lamp_list;

/* State of a packet, or of the nodes of a block; sums are of all its vectors. */
typedef struct crowd {
  lamp_list near, dim;
  vreal (*xyz)[3], (*c)[YLM__STRENGTHS][3]; /* [vectors]; sums of strength u^(2+k), a packet's */
  vreal (*tail)[YLM__TAILS];                /* of u^4 beyond distances */
  vmask *inside;
  seen_by by;
  int vectors;
  vreal *sums, *dim_sums, *pilot_sums;
} crowd;

/* Appends the first n lights of a block [FIELDS][width]. */
YLM_INLINE void append_lamps(lamp_list *l, const real *block, const size_t width, size_t n) {
  for (size_t i = 0; i < n; i++) {
    real_lamp *to = &l->lamp[l->n++];
    for (size_t a = 0; a < 3; a++) {
      to->at[a] = block[(YLM__X + a) * width + i];
      to->rgb[a] = block[(YLM__E + a) * width + i];
    }
    to->radius = block[YLM__R * width + i];
    to->luminance = block[YLM__LUM * width + i];
  }
}

/* The pilot's: sums of strength u^(2+k), and lights whose luminance is their strength. */
static void add_strengths(const ylm__tree_plan *p, crowd *k, lamp_list *l) {
  for (size_t i = 0; i < l->n; i++) {
    real_lamp *m = &l->lamp[i];
    vreal e2 = (vreal){0} + (m->rgb[0] * m->rgb[0] + m->rgb[1] * m->rgb[1] + m->rgb[2] * m->rgb[2]);
    real each[YLM__STRENGTHS] = {vreal_sqrt(e2)[0],
                                 m->luminance < 0 ? -m->luminance : m->luminance};
    m->luminance = each[p->at[0]];
    for (int v = 0; v < k->vectors; v++) {
      const vreal *x = k->xyz[v];
      vreal dx = m->at[0] - x[0], dy = m->at[1] - x[1], dz = m->at[2] - x[2];
      vreal d = vreal_sqrt(dx * dx + dy * dy + dz * dz);
      vreal u = keep_lanes(d > m->radius, 1 / larger(d, (vreal){0} + TINY));
      for (int s = 0; s < YLM__STRENGTHS; s++) {
        vreal e = u * m->radius * (u * m->radius) * each[s];
        if (p->want[2] && s == p->at[2]) add_tail(p, d, e * u * u, k->tail[v]);
        for (int n = 0; n < 3; n++) k->c[v][s][n] += e, e *= u;
      }
    }
  }
}

/* Adds a list to the sums of a plan for each vector of points, and empties it; how many pairs. */
static size_t sum_lamps(const ylm__tree_plan *p, const ylm__plan *s, crowd *k, work *w,
                        lamp_list *l, vreal *sums) {
  size_t count = (size_t)(s->n_lum + 3 * s->n_rgb), n = l->n;
  if (s == p->pilot) add_strengths(p, k, l);
  for (int v = 0; count && n && v < k->vectors; v++, sums += count) {
    memset(w->part, 0, count * sizeof(vreal));
    for (size_t i = 0; i < n; i += YLM__TILE)
      add_tile(s, w, n - i < YLM__TILE ? (int)(n - i) : YLM__TILE, &l->lamp[i], k->xyz[v], w->part,
               &k->inside[v]);
    for (size_t i = 0; i < count; i++) sums[i] += w->part[i];
  }
  l->n = 0;
  return n;
}

/* Adds what a walk noted of a kind to a list, which is summed whenever it is full. */
static size_t list_lamps(const tree_walk *walk, crowd *k, work *w, const ylm__plan *s, int kind,
                         bool dim, vreal *to) {
  const ylm_light_tree *t = walk->plan->tree;
  const uint32_t *at = walk->notes.at[kind + (dim ? OF_DIM : 0)];
  const size_t n = walk->notes.n[kind + (dim ? OF_DIM : 0)];
  const size_t width = kind == OF_FEW ? YLM__PROXIES : YLM__MOST_PROXIES;
  lamp_list *l = dim ? &k->dim : &k->near;
  size_t pairs = 0;
  for (size_t i = 0; i < n; i++) {
    if (kind == OF_WHOLE)
      l->lamp[l->n++] = lamp_of_node(t, at[i]);
    else
      append_lamps(l, block_of(t, kind, at[i]), width,
                   kind == OF_LEAF ? at[i] >> YLM__COUNT_AT & 15 : width);
    if (l->n >= YLM__BLOCK) pairs += sum_lamps(walk->plan, s, k, w, l, to);
  }
  return pairs;
}

/* Adds sums without Hessians, [dim], to those with. */
static void add_dim(const ylm__tree_plan *p, const vreal *from, vreal *to) {
  size_t lum = (size_t)p->dim.n_lum, rgb = (size_t)p->dim.n_rgb;
  for (size_t i = 0; i < lum; i++) to[p->dim_at[i]] += from[i];
  for (size_t c = 0; c < 3; c++)
    for (size_t i = 0; i < rgb; i++)
      to[(size_t)p->sums->n_lum + c * (size_t)p->sums->n_rgb + p->dim_at[lum + i]] +=
          from[lum + c * rgb + i];
}

/* Sums over what a walk comes to, for a packet of points or the nodes of a block; how many lights
   and proxies. */
static size_t walk_together(tree_walk *walk, crowd *k, work *w, const seen_from *from) {
  const ylm__tree_plan *p = walk->plan;
  const ylm__plan *sums = from->pilot ? p->pilot : p->sums;
  vreal *to = from->pilot ? k->pilot_sums : k->sums;
  size_t pairs = 0;
  while (walk_on(walk, from, from->pilot ? NULL : &k->by) > 0)
    for (int kind = 0; kind < OF_DIM; kind++) {
      pairs += list_lamps(walk, k, w, sums, kind, false, to);
      if (!from->pilot) pairs += list_lamps(walk, k, w, &p->dim, kind, true, k->dim_sums);
    }
  pairs += sum_lamps(p, sums, k, w, &k->near, to);
  if (!from->pilot) pairs += sum_lamps(p, &p->dim, k, w, &k->dim, k->dim_sums);
  return pairs;
}

#endif
