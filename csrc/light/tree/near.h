/*
** near.h - which nodes of the tree of lights are too near or too strong for a block of points to
** interpolate. Lanes are nodes.
*/
#ifndef YLM_LIGHT_TREE_NEAR_H
#define YLM_LIGHT_TREE_NEAR_H

#include "nodes.h"

/* The square of the distance of nodes from a block, less `reach`, by which its interpolation
   converges. `d` gets the square of the distance itself. Along an axis whose half extent is h,
   interpolation converges alike for lights on an ellipsoid with the ends for foci: as for one whose
   distance across the middle is the minor axis. */
static ylm_vf convergence(const seen_from *from, const ylm__group *const *g, ylm_vf reach,
                          ylm_vf *d) {
  ylm_vf away[3], over[3], d2 = {0}, least = ylm_vf_set(INFINITY);
  for (int a = 0; a < 3; a++) {
    ylm_vf x = FIELD_OF(at, a);
    away[a] = beyond(x, from->x[a], 0);
    over[a] = beyond(x, from->x[a], from->half[a]);
    d2 += over[a] * over[a];
  }
  ylm_vf nearer = 1 - reach / ylm_vf_sqrt(d2 + 1e-30f);
  nearer = ylm_vf_select(nearer > 0, nearer, (ylm_vf){0});
  *d = d2 *= nearer * nearer;
  for (int a = 0; a < 3; a++) {
    float h = from->half[a];
    if (!(h > 0)) continue;
    ylm_vf o = over[a] * nearer, x = away[a] - over[a] + o, rest = d2 - o * o;
    rest = ylm_vf_select(rest > 0, rest, (ylm_vf){0});
    ylm_vf m = ylm_vf_sqrt((x - h) * (x - h) + rest) + ylm_vf_sqrt((x + h) * (x + h) + rest);
    m = m * m * 0.25f - h * h;
    least = ylm_vf_select(m < least, m, least);
  }
  return least;
}

/* Are nodes too strong for a block to interpolate? `fall` is the square of its nearest distance
   over theirs, `u2` that of 1/distance. */
static ylm_vi too_strong(const ylm__tree_plan *p, const seen_from *from, const ylm__group *const *g,
                         ylm_vf fall, ylm_vf u2) {
  ylm_vf part = u2, u = ylm_vf_sqrt(u2);
  ylm_vi strong = {0};
  for (int i = 0; i < from->power; i++) part *= fall * fall;
  for (int k = 0; k < 3; k++, part *= u)
    if (p->want[k]) strong |= part * FIELD_OF(strength, p->at[k]) * from->strong[k] > 1;
  return strong;
}

/* Leaves nodes to the packets of a block that are too near or too strong: as they are if nothing in
   them would be far, or else what is below them. */
static void leave_nodes(tree_walk *w, const seen_from *from, node_vector *v) {
  const ylm__group *const *g = v->g;
  ylm_vi far, absent, leaf = (ylm_vi)FIELD(child) < 0;
  memcpy(&far, v->closed, sizeof far);
  memcpy(&absent, v->absent, sizeof absent);
  ylm_vf reach = FIELD(reach), d2, nearest2 = ylm_vf_set(from->nearest * from->nearest);
  ylm_vf e2 = convergence(from, g, ylm_vf_select(far, FIELD(spread), reach), &d2);
  ylm_vi near = (e2 < nearest2) | too_strong(w->plan, from, g, nearest2 / e2, 1 / d2);
  near &= ~absent;
  ylm_vi within = reach < YLM__WITHIN * from->nearest;
  within &= convergence(from, g, (ylm_vf){0}, &reach) < nearest2;
  ylm_vi small = near & (far | leaf | within);
  far &= ~near;
  memcpy(v->closed, &far, sizeof far);
  memcpy(v->small, &small, sizeof small);
  for (int i = 0; i < YLM_VF; i += YLM__GROUP) {
    for (int k = 0; k < YLM__GROUP; k++)
      if (g[i / YLM__GROUP]->child[k] == YLM__NO_NODE) v->small[i + k] = 0;
    if (!(v->small[i] | v->small[i + 1])) continue;
    w->too_many = w->n_left == LEFT;
    if (w->too_many) return;
    w->left[w->n_left++] =
        v->at[i / YLM__GROUP] | (v->small[i] ? 0 : NOT_FIRST) | (v->small[i + 1] ? 0 : NOT_SECOND);
  }
}

#endif
